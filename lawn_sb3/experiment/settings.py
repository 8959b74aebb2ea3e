"""Settings of an algorithm: whether it accepts them, and what a recipe's values for them mean."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from lawn_sb3.config import Number, Whole, validated
from lawn_sb3.errors import unknown_name
from lawn_sb3.experiment.registry import ALGORITHMS


def _start_of(value: Any) -> Any:
    """The X of a linear schedule ``lin_X``; anything else as it is."""
    kind, _, start = value.partition("_") if isinstance(value, str) else ("", "", "")
    if kind != "lin":
        return value
    try:
        return float(start)
    except ValueError:
        raise ValueError("a linear schedule is written lin_X with a number X") from None


Scheduled = Annotated[Number, BeforeValidator(_start_of)]
"""A number, or ``lin_X``, which anneals X to 0."""
Share = Annotated[Number, Field(ge=0, le=1)]
Positive = Annotated[Scheduled, Field(gt=0)]
AtLeastOne = Annotated[Whole, Field(ge=1)]
UNSET: Any = None
"""Of a setting that a recipe does not give; the algorithm has its own default."""


class Bounds(BaseModel):
    """Values that settings can take, under SB3's names; an algorithm knows a part of them."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    # of all
    learning_rate: Positive = UNSET
    gamma: Share = UNSET
    batch_size: Annotated[Whole, Field(ge=2)] = UNSET
    max_grad_norm: Positive = UNSET
    device: str = UNSET
    policy_kwargs: dict[str, Any] | None = UNSET
    stats_window_size: AtLeastOne = UNSET

    # of MAPPO
    n_steps: AtLeastOne = UNSET  # of IQL too: n-step returns
    n_epochs: AtLeastOne = UNSET
    gae_lambda: Share = UNSET
    clip_range: Positive = UNSET
    clip_range_vf: Positive | None = UNSET
    ent_coef: Annotated[Scheduled, Field(ge=0)] = UNSET
    vf_coef: Annotated[Number, Field(ge=0)] = UNSET
    target_kl: Annotated[Number, Field(gt=0)] | None = UNSET
    normalize_advantage: bool = UNSET
    normalize_per_rollout: bool = UNSET
    normalize_value: bool = UNSET
    clip_apart: bool = UNSET
    autocast: Literal["bfloat16"] | None = UNSET
    use_sde: Literal[False] = UNSET  # for continuous actions alone
    sde_sample_freq: Annotated[Whole, Field(ge=-1)] = UNSET
    rollout_buffer_class: Any = UNSET
    rollout_buffer_kwargs: dict[str, Any] | None = UNSET
    teacher: str = UNSET
    taught_fraction: Share = UNSET

    # of IQL and QMIX
    buffer_size: AtLeastOne = UNSET
    learning_starts: Annotated[Whole, Field(ge=0)] = UNSET
    train_freq: AtLeastOne = UNSET  # vector steps
    gradient_steps: Annotated[Whole, Field(ge=-1)] = UNSET
    target_update_interval: AtLeastOne = UNSET
    tau: Annotated[Number, Field(gt=0, le=1)] = UNSET
    exploration_fraction: Share = UNSET
    exploration_initial_eps: Share = UNSET
    exploration_final_eps: Share = UNSET
    double_q: bool = UNSET
    share_parameters: bool = UNSET
    replay_buffer_class: Any = UNSET
    replay_buffer_kwargs: dict[str, Any] | None = UNSET


def check_settings(algo: str, settings: Mapping[str, Any]) -> None:
    """Refuse settings that an algorithm does not know, or values that they cannot take.

    :param algo: the algorithm's name
    :param settings: settings as a recipe writes them
    :raises UserError: naming the first such setting
    """
    known = ALGORITHMS[algo].settings
    for key in settings:
        if key not in known:
            raise unknown_name(f"setting of {algo}:", key, known)
    validated(Bounds, settings, "settings")


def constructor_arguments(algo: str, settings: Mapping[str, Any]) -> dict[str, Any]:
    """What a recipe's settings mean to the algorithm's constructor.

    :param algo: the algorithm's name
    :param settings: settings as a recipe writes them
    :return: keyword arguments; ``lin_X`` is a function of the progress remaining
    :raises UserError: as :func:`check_settings`
    """
    check_settings(algo, settings)
    return {key: _argument(value) for key, value in settings.items()}


def _argument(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    if (start := _start_of(value)) != value:
        from stable_baselines3.common.utils import LinearSchedule  # here, as recipes are checked without torch

        return LinearSchedule(start, 0.0, 1.0)
    try:
        return float(value)  # YAML takes 1e-3, without a point, for text
    except ValueError:
        return value
