"""Settings of an algorithm: whether it accepts them, and what a recipe's values for them mean."""

from collections.abc import Mapping
from typing import Any

from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.experiment.registry import ALGORITHMS


def check_settings(algo: str, settings: Mapping[str, Any]) -> None:
    """Refuse settings that an algorithm does not know, or a schedule that cannot be read.

    :param algo: the algorithm's name
    :param settings: settings as a recipe writes them
    :raises UserError: naming the first such setting
    """
    known = ALGORITHMS[algo].settings
    for key in settings:
        if key not in known:
            raise unknown_name(f"setting of {algo}:", key, known)
    for key, value in settings.items():
        if (start := _schedule_start(value)) is not None:
            try:
                float(start)
            except ValueError:
                raise UserError(
                    f"setting {key} = {value!r}: a linear schedule is written lin_X with a number X"
                ) from None


def constructor_arguments(algo: str, settings: Mapping[str, Any]) -> dict[str, Any]:
    """What a recipe's settings mean to the algorithm's constructor.

    :param algo: the algorithm's name
    :param settings: settings as a recipe writes them
    :return: keyword arguments; ``lin_X`` is a function of the progress remaining
    :raises UserError: as :func:`check_settings`
    """
    check_settings(algo, settings)
    return {key: _argument(value) for key, value in settings.items()}


def _schedule_start(value: Any) -> str | None:
    """The X of ``lin_X``; None of anything else."""
    kind, _, start = value.partition("_") if isinstance(value, str) else ("", "", "")
    return start if kind == "lin" else None


def _argument(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    if (start := _schedule_start(value)) is not None:
        from stable_baselines3.common.utils import LinearSchedule  # here, as recipes are checked without torch

        return LinearSchedule(float(start), 0.0, 1.0)
    try:
        return float(value)  # YAML takes 1e-3, without a point, for text
    except ValueError:
        return value
