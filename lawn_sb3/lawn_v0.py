"""The game under PettingZoo's usual names: ``lawn_v0.parallel_env()``, and in turns ``lawn_v0.env()``."""

from typing import Any

from pettingzoo import AECEnv
from pettingzoo.utils import parallel_to_aec
from pettingzoo.utils.wrappers import OrderEnforcingWrapper

from lawn_sb3.envs import LawnEnv
from lawn_sb3.scenario import load_scenario


def parallel_env(scenario: str = "paper", changes: tuple[str, ...] = (), **arguments: Any) -> LawnEnv:
    """One game, all UAVs at once.

    :param scenario: a preset, or the path of a YAML file
    :param changes: changes of its constants, ``key=value``
    :param arguments: what else :class:`~lawn_sb3.envs.LawnEnv` takes
    :return: the environment
    :raises UserError: if there is no such scenario, or an argument has no such value
    """
    return LawnEnv(load_scenario(scenario, changes, "changes"), **arguments)


def env(scenario: str = "paper", changes: tuple[str, ...] = (), **arguments: Any) -> AECEnv:
    """The same with one UAV acting after the other; a slot is played once all have.

    :param scenario: as for :func:`parallel_env`, like all that follows
    :return: the environment, which refuses calls out of order
    """
    return OrderEnforcingWrapper(parallel_to_aec(parallel_env(scenario, changes, **arguments)))
