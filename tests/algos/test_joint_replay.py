"""Joint replay: whole games come back as they were played, never mixed."""

import pickle
from typing import Any

import numpy as np
import pytest

from lawn_sb3.algos.qmix import JointReplayBuffer, JointSamples
from lawn_sb3.envs import ObservationLayout
from tests.algos.games import Countdown


def empty(env: Countdown, size: int = 300) -> JointReplayBuffer:
    return JointReplayBuffer(
        size, env.observation_space, env.action_space, "cpu", n_envs=env.num_envs, layout=env.layout
    )


def observed(env: Countdown, actions: np.ndarray) -> Any:
    """A step, without SB3's other kinds of observation."""
    return env.step(actions)


def play(env: Countdown, buffer: JointReplayBuffer, slots: int, seed: int = 0) -> None:
    """Random play, stored as SB3 does: a slot that is done has its terminal observation as the next one."""
    rng, obs = np.random.default_rng(seed), env.reset()
    buffer.start_games()
    for _ in range(slots):
        actions = rng.integers(5, size=env.num_envs)
        new_obs, rewards, dones, infos = observed(env, actions)
        next_obs = new_obs.copy()
        for k in np.flatnonzero(dones):
            next_obs[k] = infos[k]["terminal_observation"]
        buffer.add(obs, next_obs, actions, rewards, dones, infos)
        obs = new_obs


def everything(buffer: JointReplayBuffer, game: int, monkeypatch: pytest.MonkeyPatch) -> JointSamples:
    with monkeypatch.context() as patch:
        patch.setattr(np.random, "randint", lambda *args, **kwargs: np.full(kwargs["size"], game))
        return buffer._get_samples(np.arange(buffer.size()))


def names(values: Any) -> np.ndarray:
    """Game and UAV that a number of the countdown tells."""
    return np.asarray(values) // 1_000


def times(values: Any) -> np.ndarray:
    """Round and slot that it tells."""
    return np.asarray(values) % 1_000


def test_a_sample_never_mixes_games_uavs_or_rounds() -> None:
    env = Countdown()
    buffer = empty(env)
    play(env, buffer, 40)
    batch = buffer.sample(2000)
    games = names(batch.state)[:, :1] // 10
    assert set(games.ravel().tolist()) == {0, 1, 2}
    assert (names(batch.state) == 10 * games + 9).all()
    assert (names(batch.next_state) == 10 * games + 9).all()
    for uav in range(2):
        assert (names(batch.local[:, uav]) == 10 * games + uav).all()
        assert (names(batch.next_local[:, uav]) == 10 * games + uav).all()
    now = times(batch.state)[:, 0]
    assert (times(batch.local) == now[:, None, None]).all()
    assert (times(batch.next_state)[:, 0] == now + 1).all()
    in_play = np.asarray(batch.flying)
    assert (times(batch.next_local)[..., 0][in_play] == np.repeat(now + 1, in_play.sum(axis=1))).all()
    assert (times(batch.next_local)[..., 0] // 10 == now[:, None] // 10).all()  # also of those that wait


@pytest.mark.parametrize("game", [0, 1, 2])
def test_what_was_played_is_returned_exactly(game: int, monkeypatch: pytest.MonkeyPatch) -> None:
    env = Countdown()
    buffer = empty(env)
    play(env, buffer, 12)
    actions = np.random.default_rng(0).integers(5, size=(12, 3, 2))[:, game]
    lasts = (np.arange(2) + game) % 3 + 1  # slots that the two UAVs fly: (1, 2), (2, 3), (3, 1)
    slots = np.arange(12) % lasts.max()
    stored = everything(buffer, game, monkeypatch)
    flying = slots[:, None] < lasts
    np.testing.assert_array_equal(stored.actions, actions)
    np.testing.assert_array_equal(stored.flying, flying)
    np.testing.assert_array_equal(stored.next_flying, slots[:, None] + 1 < lasts)
    np.testing.assert_array_equal(stored.game_over, slots + 1 == lasts.max())
    reward = np.where(flying, 10_000 * game + 1_000 * np.arange(2) + actions, 0.0).mean(axis=1)
    np.testing.assert_allclose(stored.rewards, reward)
    time = 10 * (np.arange(12) // lasts.max()) + slots
    assert (times(stored.state)[:, 0] == time).all()


def test_rewards_of_a_team_are_their_mean_by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    env = Countdown(num_games=1)
    buffer = empty(env)
    obs = env.reset()
    for actions in ([3, 4], [2, 2]):
        new_obs, rewards, dones, infos = observed(env, np.array(actions))
        buffer.add(obs, new_obs, np.array(actions), rewards, dones, infos)
    # UAV 0 earns 3 and leaves; UAV 1 earns 1000 + 4, then 1000 + 2.
    assert everything(buffer, 0, monkeypatch).rewards.tolist() == [503.5, 501.0]


def test_a_truncated_uav_flies_on_in_its_transition_but_not_in_the_game(monkeypatch: pytest.MonkeyPatch) -> None:
    env = Countdown(num_games=1)
    buffer = empty(env)
    flat, rewards, both = env.reset(), np.zeros(2), np.ones(2, dtype=bool)
    buffer.add(flat, flat, np.zeros(2), rewards, both, [{"TimeLimit.truncated": True}, {}])
    stored = everything(buffer, 0, monkeypatch)
    assert stored.next_flying.tolist() == [[True, False]]
    assert stored.game_over.tolist() == [0.0]
    assert buffer.now_flying.tolist() == [[True, True]]  # the game has restarted


def test_the_oldest_transitions_are_overwritten_first(monkeypatch: pytest.MonkeyPatch) -> None:
    env = Countdown()
    small, large = empty(env, size=15), empty(env, size=300)
    for buffer in (small, large):
        play(env, buffer, 12)
    assert (small.size(), large.size()) == (5, 12)
    kept, all_of_it = (everything(buffer, 1, monkeypatch).state[:, 0] for buffer in (small, large))
    assert sorted(kept.tolist()) == sorted(all_of_it[-5:].tolist())


def test_after_a_reset_everybody_flies() -> None:
    env = Countdown()
    buffer = empty(env)
    play(env, buffer, 1)
    assert not buffer.now_flying.all()
    buffer.start_games()
    assert buffer.now_flying.all()


@pytest.mark.parametrize("slots", [7, 150])
def test_content_restores_a_buffer_that_goes_on_equally(slots: int) -> None:
    env = Countdown()
    buffer, twin = empty(env), empty(env)
    play(env, buffer, slots)
    twin.restore(pickle.loads(pickle.dumps(buffer.content())))
    copy = pickle.loads(pickle.dumps(buffer))
    for each in (twin, copy):
        assert (each.pos, each.full, each.size()) == (buffer.pos, buffer.full, buffer.size())
        np.testing.assert_array_equal(each.now_flying, buffer.now_flying)
        batches = []
        for one in (buffer, each):
            np.random.seed(0)
            batches.append(one.sample(64))
        for mine, theirs in zip(*batches, strict=True):
            assert mine.equal(theirs)


def test_content_is_no_larger_than_what_is_stored() -> None:
    env = Countdown()
    buffer = empty(env)
    play(env, buffer, 7)
    assert all(len(buffer.content()[name]) == 7 for name in ("observations", "actions", "flying"))


def test_slots_that_are_no_whole_games_are_refused() -> None:
    env = Countdown()
    with pytest.raises(ValueError, match="5 slots are no whole number of games of 2 UAVs"):
        JointReplayBuffer(100, env.observation_space, env.action_space, n_envs=5, layout=ObservationLayout(2, 0))
    with pytest.raises(ValueError, match="optimize_memory_usage"):
        JointReplayBuffer(100, env.observation_space, env.action_space, "cpu", 6, True, layout=ObservationLayout(2, 0))
