"""Players of finished runs: whose stand for the rows of the paper's Table II."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

from lawn_sb3.cli.tools import ASKED
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.players import FEWEST_ASKED, ModelPlayer, kept_player
from lawn_sb3.experiment.registry import REPOSITORY


def test_the_paper_s_own_critic_stands_for_ctde_mappo_among_the_reference_results() -> None:
    assert list(ASKED.items()) == [("CTDE-MAPPO", "mappo-state"), ("QMIX", "qmix")]  # the order of the tables
    for method in ASKED.values():
        player = kept_player(REPOSITORY / "runs" / "reference" / "paper" / method)
        assert isinstance(player, ModelPlayer)
        assert player.name == method


def test_a_method_without_kept_networks_has_no_player(tmp_path: Path) -> None:
    (tmp_path / "qmix" / "seed-0").mkdir(parents=True)
    assert kept_player(tmp_path / "qmix") is None
    assert kept_player(tmp_path / "nowhere") is None


def test_a_greedy_model_is_asked_only_about_games_in_which_somebody_flies(monkeypatch: pytest.MonkeyPatch) -> None:
    """It flies as if it were asked about all; one that draws its moves is, so that it draws the same ones."""
    player = kept_player(REPOSITORY / "runs" / "reference" / "paper" / "iql")
    assert isinstance(player, ModelPlayer)
    model, scenario, games = player.model, player.model.env.get_attr("scenario", [0])[0], 20  # type: ignore[union-attr]
    predict, asked = model.predict, list[int]()

    def counted(rows: NDArray[np.float32], **more: object) -> object:
        asked.append(len(rows) // scenario.num_uavs)
        return predict(rows, **more)  # type: ignore[arg-type]

    monkeypatch.setattr(model, "predict", counted)
    flown = evaluate(player, scenario, games, 0)
    ends = flown.groupby("episode")["slots"].max()
    assert asked == [max(int((ends > slot).sum()), FEWEST_ASKED) for slot in range(ends.max())]
    assert asked[-1] < games
    with monkeypatch.context() as patched:
        patched.setattr(ModelPlayer, "_asked", lambda self, flies: np.arange(len(flies)))
        pd.testing.assert_frame_equal(evaluate(player, scenario, games, 0), flown)
    asked.clear()
    player.deterministic = False
    evaluate(player, scenario, games, 0)
    assert set(asked) == {games}
