"""What an ablation asks of the training environment: terms of the reward left out, and masks of the moves."""

from __future__ import annotations

import numpy as np
import pytest

from lawn_sb3.envs import make_vec_env
from lawn_sb3.errors import UserError
from lawn_sb3.game.state import REWARD_TERMS
from lawn_sb3.scenario import PRESETS

SHORT = PRESETS["paper"].changed(max_slots=6)


@pytest.mark.parametrize("term", REWARD_TERMS)
def test_a_term_left_out_is_missing_from_the_reward_and_nothing_else_is(term: str) -> None:
    whole, without = make_vec_env(SHORT, 8, seed=0), make_vec_env(SHORT, 8, seed=0, without_reward=(term,))  # type: ignore[arg-type]
    rng, missing, ends = np.random.default_rng(0), 0.0, 0
    for env in (whole, without):
        env.reset()
    for _ in range(12):
        actions = rng.integers(63, size=32)
        (seen, rewards, dones, infos), (seen_too, rest, dones_too, infos_too) = (
            whole.step(actions),
            without.step(actions),
        )
        terms = whole.get_attr("simulator", [0])[0].outcome.reward_terms.reshape(32, -1)
        np.testing.assert_allclose(rewards - rest, terms[:, REWARD_TERMS.index(term)], atol=1e-5)  # type: ignore[arg-type]
        np.testing.assert_array_equal(seen, seen_too)
        np.testing.assert_array_equal(dones, dones_too)
        missing += float(np.abs(rewards - rest).sum())
        for info, info_too in zip(infos, infos_too, strict=True):
            assert info.get("episode") == info_too.get("episode")  # missions are scored in full
            ends += "episode" in info
    assert missing > 0.0
    assert ends > 0


def test_an_unknown_term_is_refused() -> None:
    with pytest.raises(UserError, match=r"unknown reward term 'navi' .did you mean 'nav'"):
        make_vec_env(SHORT, 1, without_reward=("navi",))  # type: ignore[arg-type]


@pytest.mark.parametrize("copies", [1, 2])
def test_masks_are_those_of_the_slots_that_ask(copies: int) -> None:
    """In the corner (0, 0, 0) the 20 moves without a negative step stay inside, but for (0, 0, 3): H is 3 voxels."""
    env = make_vec_env(SHORT, 3, copies=copies, seed=0)
    env.reset()
    last = env.games[-1].simulator
    last.state.position[2, 3] = 0
    masks = np.stack(env.env_method("action_masks"))
    assert masks.shape == (12 * copies, 63)
    stays = (last.rules.actions >= 0).all(axis=1) & (last.rules.actions != [0, 0, 3]).any(axis=1)
    np.testing.assert_array_equal(masks[-1], stays)
    assert masks[-1].sum() == 19
    for slot, mask in enumerate(masks):
        game, place = env.games[slot // 12].simulator, slot % 12
        ends = game.state.position[place // 4, place % 4] + game.rules.actions
        np.testing.assert_array_equal(mask, ((ends >= 0) & (ends < SHORT.grid)).all(axis=1))
    np.testing.assert_array_equal(env.env_method("action_masks", indices=[5, 1]), masks[[5, 1]])
