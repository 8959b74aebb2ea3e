"""The training environment and the untrained model of a cell, or one line that says why there can be none."""

from typing import Any

from sb3_contrib.common.maskable.policies import MaskableActorCriticPolicy
from stable_baselines3.common.base_class import BaseAlgorithm

from lawn_sb3.algos.iql import InTimeQPolicy
from lawn_sb3.algos.qmix import InTimeQMIXPolicy
from lawn_sb3.envs import FlatVecEnv, make_vec_env
from lawn_sb3.envs.observation import EXTRAS
from lawn_sb3.errors import UserError, first_line
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.find_policy import find_policy
from lawn_sb3.experiment.memory import check_memory
from lawn_sb3.experiment.policy_errors import line_of_user, policy_error
from lawn_sb3.experiment.registry import find_algorithm
from lawn_sb3.experiment.settings import constructor_arguments

IN_TIME = (MaskableActorCriticPolicy, InTimeQMIXPolicy, InTimeQPolicy)
"""Policies whose moves can be held to a slack."""


def training_env(cell: Cell) -> FlatVecEnv:
    """The environment that a cell is trained in.

    :param cell: the cell
    :return: its vector environment
    """
    method = cell.method
    assert method.policy is not None
    policy = find_policy(method.policy)
    return make_vec_env(
        cell.scenario,
        method.num_games,
        seed=cell.seed,
        continuation=method.continuation,
        without_reward=method.without_reward,
        extras=[extra for extra in EXTRAS if extra in getattr(policy, "sees", ())],
        slack=method.slack,
        credit=method.credit,
        fewest_uavs=method.fewest_uavs,
    )


def build_model(cell: Cell, **arguments: Any) -> BaseAlgorithm:
    """Build the untrained model of a cell, with its training environment.

    :param cell: the cell
    :param arguments: what else to give the algorithm
    :return: the model
    :raises UserError: if the policy cannot be built, the algorithm refuses its settings, or there is no room for it
    """
    method = cell.method
    assert method.algo is not None
    assert method.policy is not None
    policy = find_policy(method.policy)
    algorithm = find_algorithm(method.algo, policy)
    if method.slack is not None and not issubclass(policy, IN_TIME):
        raise UserError(
            f"method {cell.key!r}: policy {method.policy} knows no in-time moves: no slack; those that derive from "
            "MaskableCTDEPolicy, InTimeQMIXPolicy or InTimeQPolicy do"
        )
    check_memory(cell)
    settings = {"device": "cpu", **constructor_arguments(method.algo, method.settings), **arguments}
    try:
        return algorithm(policy, training_env(cell), seed=cell.seed, **settings)
    except UserError:
        raise
    except Exception as error:
        if isinstance(error, NotImplementedError) or line_of_user(error, policy):
            raise policy_error(error, policy, method.policy) from error
        raise UserError(f"method {cell.key!r}: {method.algo} refuses its settings: {first_line(error)}") from error
