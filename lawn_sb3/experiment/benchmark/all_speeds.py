"""All measurements, in order."""

from collections.abc import Mapping
from functools import partial
from typing import NamedTuple

import pandas as pd
import torch as th

from lawn_sb3.experiment.benchmark.clock import peak_memory_mb
from lawn_sb3.experiment.benchmark.game_speed import against_plain, env_step_ms, growth, large_game
from lawn_sb3.experiment.benchmark.planning_speed import planning_speeds
from lawn_sb3.experiment.benchmark.training_speed import (
    against_stock,
    bfloat16_speeds,
    learner_speeds,
    short_training,
    update_share,
)
from lawn_sb3.experiment.benchmark.vector_speed import vector_speeds
from lawn_sb3.experiment.plan_episodes import Advance
from lawn_sb3.experiment.recipe import Method


class Speeds(NamedTuple):
    """What was measured."""

    figures: dict[str, float]
    """By name, the unit in the name; a ratio is of two things measured in turn."""
    growth: pd.DataFrame
    """How the simulator's cost grows (:func:`lawn_sb3.experiment.benchmark.game_speed.growth`)."""


def benchmark(methods: Mapping[str, Method], quick: bool, advance: Advance) -> Speeds:
    """Measure all speeds.

    :param methods: methods of a recipe, among them one of MAPPO
    :param quick: in about a minute: shorter, smaller, and without whole trainings
    :param advance: called after each part of what is being measured
    :return: figures
    """
    th.set_num_threads(1)
    seconds = 0.5 if quick else 4.0
    mappo = next(method for method in methods.values() if method.algo == "mappo")
    figures = against_plain(64 if quick else 1024, seconds, advance)
    figures |= vector_speeds(seconds, advance)
    for num_uavs in (4, 1024):
        figures[f"lawn_env_step_{num_uavs}_uavs_ms"] = env_step_ms(num_uavs, seconds, advance)
    grown = growth(256 if quick else 4096, seconds / 4, advance)
    figures |= planning_speeds(20 if quick else 200, advance)
    figures |= learner_speeds(methods, 4_000 if quick else 20_000, advance)
    figures |= bfloat16_speeds(mappo, seconds, advance)
    figures |= update_share(mappo, seconds, advance)
    figures["memory_one_game_of_1024_uavs_mb"] = peak_memory_mb(large_game)
    figures["memory_training_mb"] = peak_memory_mb(partial(short_training, mappo))
    if not quick:
        figures |= against_stock(mappo, mappo.env_steps, advance)
    return Speeds(figures, grown)
