"""Speed of the vector environment: all games in one PettingZoo environment, against one environment a game."""

import numpy as np

from lawn_sb3.envs import make_vec_env
from lawn_sb3.experiment.benchmark.clock import calls_per_second
from lawn_sb3.experiment.plan_episodes import Advance
from lawn_sb3.scenario import PRESETS

NUM_GAMES = 64


def vector_speeds(seconds: float, advance: Advance) -> dict[str, float]:
    """Milliseconds of a vector step of 64 games, through SuperSuit in both cases."""
    scenario = PRESETS["paper"]
    many, single = make_vec_env(scenario, NUM_GAMES, seed=0), make_vec_env(scenario, 1, copies=NUM_GAMES, seed=0)
    for env in (many, single):
        env.reset()
    actions = np.random.default_rng(0).integers(0, 63, many.num_envs)
    jobs = [lambda: many.step(actions), lambda: single.step(actions)]
    together, apart = calls_per_second(jobs, seconds, advance, "vector environment, 64 games in one or in 64")
    return {
        "vec_step_one_64_game_env_ms": 1e3 / together,
        "vec_step_64_one_game_envs_ms": 1e3 / apart,
        "vec_step_ratio": together / apart,
    }
