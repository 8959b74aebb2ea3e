"""A few real games for a policy to answer to, in such a way that training notices nothing of it."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
import torch as th
from numpy.typing import NDArray
from stable_baselines3.common.base_class import BaseAlgorithm
from torch.distributions import Distribution

from lawn_sb3.envs import ObservationLayout
from lawn_sb3.envs.observation import OWN, POSITION_UNIT_VOXELS
from lawn_sb3.game.simulator import Simulator

Flat = NDArray[np.float32]
"""Flat observations [T, G, N, flat_dim]."""

SEED = 0
NUM_GAMES = 8
NUM_SLOTS = 2
"""Slots in which the networks are asked, one after the other for those with a memory."""
SWARMS = 6
"""How often x becomes that of a swarm around the UAV: enough for each move to be seen in some rows."""
SLOTS_APART = 3
"""Slots of random play before each of them."""


class Games(NamedTuple):
    """A few slots of a few games, apart from those of the training environment.

    :param flat: flat observations [T, G, N, flat_dim]
    :param inside: the moves that stay inside the airspace [T, G, N, A]
    :param moves: the action set in units of observed positions [A, 3]
    :param layout: where o_i and x lie
    :param seed: what all that is random in them, and in what x becomes, was drawn with
    """

    flat: Flat
    inside: NDArray[np.bool_]
    moves: Flat
    layout: ObservationLayout
    seed: int


def play(model: BaseAlgorithm) -> Games:
    """Play a few games of a model's scenario at random, in a simulator of their own; other games after training.

    :param model: a model with its training environment
    :return: what the UAVs saw
    """
    seed = model.num_timesteps
    env = model.get_env()
    assert env is not None
    scenario, observer = (env.get_attr(what, [0])[0] for what in ("scenario", "observer"))
    simulator, rng = Simulator(scenario, NUM_GAMES, seed), np.random.default_rng(seed)
    flat, inside = [], []
    for _ in range(NUM_SLOTS):
        for _ in range(SLOTS_APART):
            simulator.step(rng.integers(simulator.num_actions, size=simulator.state.flying.shape))
            simulator.go_on()
        flat.append(observer.flat(simulator.state))
        inside.append(simulator.allowed_moves())
    moves = (simulator.rules.actions / POSITION_UNIT_VOXELS).astype(np.float32)
    return Games(np.stack(flat), np.stack(inside), moves, observer.layout, seed)


def with_other_states(games: Games) -> Iterator[tuple[str, Flat]]:
    """Replace x and nothing else.

    :param games: the games
    :return: what x becomes, and the observations
    """
    rng, columns = np.random.default_rng(games.seed), games.layout.state
    x = games.flat[..., columns]
    others: dict[str, NDArray[Any]] = {
        "that of another game": np.roll(x, 1, axis=1),
        **{f"that of a swarm around the UAV, draw {k + 1}": _around(games, rng) for k in range(SWARMS)},
        "noise": rng.normal(size=x.shape),
        "noise a hundred times as large": rng.normal(scale=100.0, size=x.shape),
        "zero": np.zeros_like(x),
    }
    for becomes, other in others.items():
        flat = games.flat.copy()
        flat[..., columns] = other
        yield becomes, flat


def _around(games: Games, rng: np.random.Generator) -> Flat:
    """Global states in which all others are one move away, where an actor that peeps would look for them."""
    layout, x = games.layout, games.flat[..., games.layout.state].copy()
    uavs = x[..., layout.state_uavs].reshape(*x.shape[:-1], layout.num_uavs, OWN)
    beside = games.moves[rng.integers(len(games.moves), size=uavs.shape[:-1])]
    uavs[..., layout.position] = games.flat[..., None, layout.position] + beside
    x[..., layout.state_uavs] = uavs.reshape(*x.shape[:-1], -1)
    return x


def beside_other_slots(games: Games) -> Iterator[tuple[NDArray[np.bool_], Flat]]:
    """Replace some slots of the batch by those of another game: whole games, and all but one UAV of each or just one.

    :param games: the games
    :return: which slots were kept [G, N], and the observations
    """
    game, uav = np.indices(games.flat.shape[1:3])
    for kept in (game % 2 == 0, uav == 0, uav != 0):
        yield kept, np.where(kept[..., None], games.flat, np.roll(games.flat, 1, axis=1))


@contextmanager
def no_trace(model: BaseAlgorithm) -> Iterator[None]:
    """Put a model's weights, statistics and modes and all global random states back as they were.

    :param model: the model
    """
    modes = {part: part.training for part in model.policy.modules()}
    python, numpy, validating = random.getstate(), np.random.get_state(), Distribution._validate_args
    # Otherwise torch refuses NaN, at length, before it can be said in one line.
    Distribution.set_default_validate_args(False)
    num_threads = th.get_num_threads()
    th.set_num_threads(1)  # so few rows are answered fastest by one
    devices = [model.device] if model.device.type == "cuda" else []
    with restored([*model.policy.parameters(), *model.policy.buffers()]), th.random.fork_rng(devices):
        try:
            yield
        finally:
            Distribution.set_default_validate_args(validating)
            th.set_num_threads(num_threads)
            random.setstate(python)
            np.random.set_state(numpy)
            for part, training in modes.items():
                part.training = training


@contextmanager
def restored(tensors: Sequence[th.Tensor]) -> Iterator[None]:
    """Put tensors back as they were.

    :param tensors: the tensors
    """
    kept = [tensor.detach().clone() for tensor in tensors]
    try:
        yield
    finally:
        with th.no_grad():
            for tensor, value in zip(tensors, kept, strict=True):
                tensor.copy_(value)


def seed_all() -> None:
    """Start all global random states anew; to be called inside :func:`no_trace`."""
    random.seed(SEED)
    np.random.seed(SEED)
    th.manual_seed(SEED)
