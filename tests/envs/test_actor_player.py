import numpy as np
import pytest
from numpy.typing import NDArray

from lawn_sb3.envs import ActorPlayer, LawnEnv
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.evaluation import evaluate, evaluation_missions
from lawn_sb3.scenario import PRESETS
from tests.envs.corridor import CORRIDOR, action

TINY = PRESETS["tiny"].changed(max_slots=15)


def test_it_is_shown_what_a_trainer_is_shown_and_flies_what_it_chooses() -> None:
    weights = np.random.default_rng(0).normal(size=(len(LawnEnv(TINY).action_table), 16))

    def choose(o: NDArray[np.float32]) -> NDArray[np.int64]:
        return np.asarray(np.argmax(o[..., :16] @ weights.T, axis=-1))

    rows = evaluate(ActorPlayer(choose), TINY, episodes=4, seed=3)
    missions = evaluation_missions(TINY, 4, seed=3)
    env = LawnEnv(TINY, leaving=False)
    rewards: list[float] = []
    for origins, destinations in zip(*missions, strict=True):
        observations, _ = env.reset(options={"missions": (origins, destinations)})
        total = dict.fromkeys(env.possible_agents, 0.0)
        while env.agents:
            flown = env.step({uav: int(choose(own)) for uav, own in observations.items()})
            observations = flown[0]
            total = {uav: total[uav] + reward for uav, reward in flown[1].items()}
        rewards += total.values()
    np.testing.assert_allclose(rows["reward"], rewards)
    assert len(set(np.round(rewards, 6))) > 2


def test_straight_flight_arrives_in_the_least_slots() -> None:
    table = LawnEnv(CORRIDOR).action_table

    def choose(o: NDArray[np.float32]) -> NDArray[np.int64]:
        return np.where(o[..., 3] > o[..., 0], action(table, 1, 0, 0), action(table, -1, 0, 0))

    rows = evaluate(ActorPlayer(choose, "straight"), CORRIDOR, episodes=5, seed=0)
    assert rows["arrived"].all()
    np.testing.assert_array_equal(rows["slots"], rows["min_slots"])


@pytest.mark.parametrize("given", [lambda o: np.zeros(o.shape[:1], dtype=int), lambda o: np.zeros(o.shape[:2])])
def test_what_is_no_action_for_each_uav_is_refused(given: object) -> None:
    with pytest.raises(UserError, match=r"mine gave \w+ of shape .*: whole numbers of shape \(2, 2\), one action for"):
        evaluate(ActorPlayer(given, "mine"), TINY, episodes=2, seed=0)  # type: ignore[arg-type]
