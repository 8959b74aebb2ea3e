"""Render modes as Gymnasium's and PettingZoo's users know them, with a window and without."""

import copy
import pickle
import warnings
from collections.abc import Iterator
from typing import Any, get_args

import numpy as np
import pytest
from matplotlib import pyplot as plt

from lawn_sb3 import lawn_v0
from lawn_sb3.envs import LawnEnv
from lawn_sb3.envs.parallel_env import RenderMode
from lawn_sb3.errors import Notice, UserError
from lawn_sb3.scenario import PRESETS
from tests.envs import window_backend
from tests.envs.window_backend import FigureCanvas, FigureManager

TINY = PRESETS["tiny"]


def fly(env: Any, slots: int) -> None:
    for slot in range(slots):
        env.step({uav: (slot + k + 1) % len(env.action_table) for k, uav in enumerate(env.agents)})


@pytest.fixture
def windows(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    before = plt.get_backend()
    monkeypatch.setattr(FigureCanvas, "shown", [])
    monkeypatch.setattr(FigureManager, "opened", [])
    plt.switch_backend(window_backend.NAME)
    yield
    plt.switch_backend(before)


def test_every_mode_that_is_named_is_taken_and_others_are_not() -> None:
    assert LawnEnv.metadata["render_modes"] == list(get_args(RenderMode))
    for mode in get_args(RenderMode):
        assert lawn_v0.parallel_env("tiny", render_mode=mode).render_mode == mode
        assert lawn_v0.env("tiny", render_mode=mode).render_mode == mode
    with pytest.raises(UserError, match="render_mode 'rgb': one of human, ansi, rgb_array, rgb_array_list, or none"):
        LawnEnv(TINY, render_mode="rgb")  # type: ignore[arg-type]


def test_a_list_has_a_picture_of_every_slot_since_the_last_one() -> None:
    env, drawn = LawnEnv(TINY, render_mode="rgb_array_list"), LawnEnv(TINY, render_mode="rgb_array")
    expected = []
    for one in (env, drawn):
        one.reset(seed=2)
    expected.append(drawn.render())
    for _ in range(2):
        fly(env, 1)
        fly(drawn, 1)
        expected.append(drawn.render())
    np.testing.assert_array_equal(env.render(), np.stack(expected))  # type: ignore[arg-type]
    assert env.render() == []
    env.reset(seed=3)
    env.reset(seed=2)
    np.testing.assert_array_equal(env.render(), expected[:1])  # of the new game alone


def test_a_window_follows_the_game_by_itself(windows: None) -> None:
    env, drawn = LawnEnv(TINY, render_mode="human"), LawnEnv(TINY, render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for one in (env, drawn):
            one.reset(seed=2)
            fly(one, 2)
    assert env.render() is None
    (manager,) = FigureManager.opened
    assert [seconds for seconds, _ in FigureCanvas.shown] == [1 / LawnEnv.metadata["render_fps"]] * 3
    off = np.abs(FigureCanvas.shown[-1][1].astype(int) - np.asarray(drawn.render(), dtype=int))
    assert off.mean() < 1.0  # the picture, as good as pixel by pixel
    assert manager.is_open
    env.close()
    assert not manager.is_open


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_a_copy_opens_a_window_of_its_own(windows: None, copied: Any) -> None:
    env = LawnEnv(TINY, render_mode="human")
    env.reset(seed=2)
    other = copied(env)
    fly(other, 1)
    assert len(FigureManager.opened) == 2
    other.close()
    assert FigureManager.opened[0].is_open
    env.close()


@pytest.mark.parametrize("leads_nowhere", [False, True])
def test_without_a_window_the_game_is_told_in_text_after_one_line(
    leads_nowhere: bool, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse() -> str:
        raise ImportError("Cannot load backend 'TkAgg' which requires the 'tk' interactive framework")

    if leads_nowhere:  # what matplotlib says where TkAgg is asked for and there is no display
        monkeypatch.setattr(plt, "get_backend", refuse)
    else:
        plt.switch_backend("agg")
    env = lawn_v0.parallel_env("tiny", render_mode="human")
    with pytest.warns(Notice, match="no window for render_mode 'human'.*matplotlib has .*MPLBACKEND") as said:
        env.reset(seed=2)
    assert (said[0].filename, len(str(said[0].message).splitlines())) == (__file__, 1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fly(env, 2)
    assert capsys.readouterr().out.count("0: (") == 3
    env.close()
