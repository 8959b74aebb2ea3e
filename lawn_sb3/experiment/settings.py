"""Settings of an algorithm: which it accepts, and what a recipe's values for them mean."""

import inspect
from collections.abc import Mapping
from typing import Any

from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.utils import LinearSchedule

from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.experiment.registry import ALGORITHMS

GIVEN_BY_THE_KIT = {"policy", "env", "seed", "tensorboard_log", "verbose", "_init_setup_model"}


def accepted_settings(algo: str) -> set[str]:
    """Names of the constructor arguments that an algorithm takes, in any of its classes."""
    classes = set(ALGORITHMS[algo].values())
    return set().union(*(_arguments(one) - getattr(one, "not_taken", set()) for one in classes))


def _arguments(algorithm: type[BaseAlgorithm]) -> set[str]:
    """Names of constructor arguments, those that a class hands on to the next included."""
    names: set[str] = set()
    for owner in (base for base in algorithm.__mro__ if "__init__" in vars(base)):
        parameters = inspect.signature(owner).parameters.values()
        handed_on = {one.name for one in parameters if one.kind in (one.VAR_POSITIONAL, one.VAR_KEYWORD)}
        names |= {one.name for one in parameters} - handed_on
        if not handed_on:
            break
    return names


def constructor_arguments(algo: str, settings: Mapping[str, Any]) -> dict[str, Any]:
    """What a recipe's settings mean to the algorithm's constructor.

    :param algo: the algorithm's name
    :param settings: settings as a recipe writes them
    :return: keyword arguments; ``lin_X`` is a function of the progress remaining
    :raises UserError: if the algorithm knows no such setting, or a schedule cannot be read
    """
    known = accepted_settings(algo) - GIVEN_BY_THE_KIT
    for key in settings:
        if key not in known:
            raise unknown_name(f"setting of {algo}:", key, known)
    return {key: _argument(key, value) for key, value in settings.items()}


def _argument(key: str, value: Any) -> Any:
    if not isinstance(value, str):
        return value
    kind, _, start = value.partition("_")
    if kind != "lin":
        try:
            return float(value)  # YAML takes 1e-3, without a point, for text
        except ValueError:
            return value
    try:
        return LinearSchedule(float(start), 0.0, 1.0)
    except ValueError:
        raise UserError(f"setting {key} = {value!r}: a linear schedule is written lin_X with a number X") from None
