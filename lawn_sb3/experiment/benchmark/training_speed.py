"""Speed of learning: env steps a second, the update against a matrix multiplication, and MAPPO against stock PPO."""

import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import supersuit
import torch as th
from numpy.typing import NDArray
from stable_baselines3 import PPO
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm
from stable_baselines3.common.utils import set_random_seed
from torch import nn

from lawn_sb3.envs import LawnEnv, Observer
from lawn_sb3.experiment.benchmark.clock import calls_per_second
from lawn_sb3.experiment.build import build_model
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.measures import summarize
from lawn_sb3.experiment.plan_episodes import Advance
from lawn_sb3.experiment.players import ModelPlayer
from lawn_sb3.experiment.recipe import Evaluation, Method
from lawn_sb3.game.player import Player
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.scenario import PRESETS

SCENARIO = PRESETS["paper"]
NUM_UAVS = SCENARIO.num_uavs
WARM_UP = 4_000
"""Env steps before a training is timed: off-policy learners have begun to learn by then."""
LOOK_EVERY = 5_000
"""Env steps between two looks at the greedy player."""


def first_methods(methods: Mapping[str, Method]) -> dict[str, Method]:
    """The first method of each algorithm."""
    found: dict[str, Method] = {}
    for method in methods.values():
        if method.algo is not None:
            found.setdefault(method.algo, method)
    return found


def learner_speeds(methods: Mapping[str, Method], env_steps: int, advance: Advance) -> dict[str, float]:
    """Env steps a second of each algorithm's first method, without evaluations.

    :param methods: methods of a recipe
    :param env_steps: how many are timed
    :param advance: told after each algorithm
    :return: figures by name
    """
    first = first_methods(methods)
    figures = {}
    for algo, method in first.items():
        model = _model(method)
        model.learn(WARM_UP * NUM_UAVS)
        before, began = model.num_timesteps, time.perf_counter()
        model.learn(env_steps * NUM_UAVS, reset_num_timesteps=False)
        done = (model.num_timesteps - before) / NUM_UAVS
        figures[f"{algo}_env_steps_per_s"] = done / (time.perf_counter() - began)
        advance("trainings", len(first))
    return figures


def bfloat16_speeds(method: Method, seconds: float, advance: Advance) -> dict[str, float]:
    """Env steps a second of MAPPO with its updates in float32 and in bfloat16, rollouts and updates in turn.

    :param method: a method of MAPPO
    :param seconds: for each of the two; at least a few rollouts and updates
    :param advance: told after each round
    :return: figures by name, and the ratio of the two
    """
    precisions = {"float32": None, "bfloat16": "bfloat16"}
    jobs = []
    for autocast in precisions.values():
        model = _model(method.model_copy(update={"settings": {**method.settings, "autocast": autocast}}))
        assert isinstance(model, PPO)
        rollout = model.n_steps * model.n_envs
        jobs.append(partial(model.learn, rollout, reset_num_timesteps=False))
    often = calls_per_second(jobs, seconds, advance, "MAPPO in float32 and in bfloat16", rounds=3)
    speeds = [calls * rollout / NUM_UAVS for calls in often]
    figures = {f"mappo_{name}_env_steps_per_s": speed for name, speed in zip(precisions, speeds, strict=True)}
    return figures | {"mappo_bfloat16_ratio": speeds[1] / speeds[0]}


def update_share(method: Method, seconds: float, advance: Advance) -> dict[str, float]:
    """How much of the machine's own matrix-multiply rate MAPPO's update reaches, measured in turn.

    A row costs 6 operations a weight, forward and backward, and 4 in first layers, whose input needs no gradient.

    :param method: a method of MAPPO
    :param seconds: for each of the two
    :param advance: told after each round
    :return: samples a second, both rates in Gflop/s, and the share in percent
    """
    model = _model(method)
    assert isinstance(model, PPO)
    model.learn(model.n_steps * model.n_envs)
    samples = model.n_steps * model.n_envs * model.n_epochs
    parts = (model.policy.mlp_extractor.policy_net, model.policy.mlp_extractor.value_net)
    weights = sum(layer.weight.numel() for layer in model.policy.modules() if isinstance(layer, nn.Linear))
    inputs = sum(next(layer.weight.numel() for layer in part if isinstance(layer, nn.Linear)) for part in parts)
    rows, square = th.randn(model.batch_size, 256), th.randn(256, 256)
    jobs: list[Callable[[], object]] = [model.train, lambda: rows @ square]
    updates, products = calls_per_second(jobs, seconds, advance, "update, matrix multiplication")
    reached = updates * samples * (6 * weights - 2 * inputs) / 1e9
    possible = products * 2 * model.batch_size * 256 * 256 / 1e9
    return {
        "mappo_update_samples_per_s": updates * samples,
        "mappo_update_gflop_per_s": reached,
        "matrix_multiply_gflop_per_s": possible,
        "mappo_update_share_percent": 100.0 * reached / possible,
    }


class Look(NamedTuple):
    """The greedy player at one moment of a training."""

    seconds: float
    """Of training alone."""
    env_steps: int
    success_percent: float
    utility_mbps: float


def against_stock(method: Method, env_steps: int, advance: Advance) -> dict[str, float]:
    """How soon MAPPO and stock PPO reach 95 % success, and 99 % of their own last utility, greedy.

    Stock PPO is SB3's, with its default settings but for ``net_arch=[256, 256]``, on PettingZoo's environment flattened
    by SuperSuit alone.

    :param method: a method of MAPPO
    :param env_steps: how long both are trained
    :param advance: told after each look
    :return: seconds and env steps by name, and the ratios of the seconds; what was not reached is not a number
    """
    learners = {"mappo": _model(method), "stock_ppo": _stock_model()}
    figures: dict[str, float] = {}
    for name, model in learners.items():
        looks = _watched(name, model, env_steps, advance)
        last = looks[-1].utility_mbps
        reached = {
            "95_percent_success": next((look for look in looks if look.success_percent >= 95.0), None),
            "99_percent_of_its_utility": next((look for look in looks if look.utility_mbps >= 0.99 * last), None),
        }
        for what, look in reached.items():
            figures[f"{name}_to_{what}_s"] = look.seconds if look else float("nan")
            figures[f"{name}_to_{what}_env_steps"] = look.env_steps if look else float("nan")
        figures[f"{name}_last_utility_mbps"] = last
    for what in ("95_percent_success", "99_percent_of_its_utility"):
        figures[f"to_{what}_ratio"] = figures[f"stock_ppo_to_{what}_s"] / figures[f"mappo_to_{what}_s"]
    return figures


def short_training(method: Method) -> None:
    """Train for some rollouts, for the memory that it takes."""
    _model(method).learn(WARM_UP * NUM_UAVS)


def _model(method: Method) -> BaseAlgorithm:
    return build_model(Cell("bench", method, 0, SCENARIO, Evaluation(), Path()))


def _stock_model() -> PPO:
    env = supersuit.pettingzoo_env_to_vec_env_v1(supersuit.black_death_v3(LawnEnv(SCENARIO)))
    env = supersuit.concat_vec_envs_v1(env, 1, num_cpus=0, base_class="stable_baselines3")
    set_random_seed(0)  # SuperSuit's environment takes no seed
    return PPO("MlpPolicy", env, policy_kwargs={"net_arch": [256, 256]}, device="cpu")


class LocalPlayer:
    """A model over o_i alone, greedy."""

    name = "stock"

    def __init__(self, model: PPO) -> None:
        self.model, self.observer = model, Observer(SCENARIO)

    def start(self, simulator: Simulator, rng: np.random.Generator) -> None:
        """Nothing to get ready."""

    def act(self, simulator: Simulator) -> NDArray[np.int64]:
        """Ask the model."""
        local = self.observer.local(simulator.state)
        actions, _ = self.model.predict(local.reshape(-1, local.shape[-1]), deterministic=True)
        return np.asarray(actions, dtype=np.int64).reshape(local.shape[:2])


class _Watching(BaseCallback):
    """Looks at the greedy player now and then, and leaves that out of the time."""

    def __init__(self, player: Player, env_steps: int, name: str, advance: Advance) -> None:
        super().__init__()
        self.player, self.env_steps, self.name, self.advance = player, env_steps, name, advance
        self.looks: list[Look] = []
        self.began = time.perf_counter()

    def _on_step(self) -> bool:
        return True

    def _on_rollout_end(self) -> None:
        done = self.num_timesteps // NUM_UAVS
        if done < LOOK_EVERY * (len(self.looks) + 1) and done < self.env_steps:
            return
        passed = time.perf_counter() - self.began
        found = summarize(evaluate(self.player, SCENARIO, 100, Evaluation().watch_seed))
        self.looks.append(Look(passed, done, found["success_percent"], found["utility_mbps"]))
        self.advance(f"{self.name}, {self.env_steps:,} env steps", max(1, self.env_steps // LOOK_EVERY))
        self.began = time.perf_counter() - passed


def _watched(name: str, model: BaseAlgorithm, env_steps: int, advance: Advance) -> list[Look]:
    """Train a model and look at its greedy player now and then."""
    assert isinstance(model, OnPolicyAlgorithm)
    player: Any = ModelPlayer(model, name) if name == "mappo" else LocalPlayer(model)  # type: ignore[arg-type]
    watching = _Watching(player, env_steps, name, advance)
    model.learn(env_steps * NUM_UAVS, callback=watching)
    return watching.looks
