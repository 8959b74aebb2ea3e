"""The parts that methods of a recipe play in the claims, such as ``qmix``: claims name parts, recipes choose keys."""

from collections.abc import Mapping
from typing import Any

from lawn_sb3.experiment.recipe import Method

LADDER = {"algo": "mappo-episodes", "without_reward": ("rate", "nav", "col")}
"""What the learners of the ladder have in common."""
ROLES: dict[str, dict[str, Any]] = {
    "random": {"player": "random"},
    "straight": {"player": "shortest-path"},
    "alone": {"player": "best-route"},
    "forecast": {"player": "forecast"},
    "welfare": {"player": "welfare"},
    "equilibrium": {"player": "equilibrium"},
    "iql": {"algo": "iql", "policy": "local_q"},
    "iql-shared": {"algo": "iql", "policy": "local_q", "share_parameters": True},
    "qmix": {"algo": "qmix", "policy": "monotonic_mixer"},
    "qmix-additive": {"algo": "qmix", "policy": "additive_mixer"},
    "mappo": {"algo": "mappo", "policy": "state_critic"},
    "mappo-o": {"algo": "mappo", "policy": "centralized_critic"},
    "mappo-raw": {"algo": "mappo", "policy": "centralized_critic", "normalize_value": False},
    "mappo-separate": {"algo": "mappo", "policy": "separate_actors"},
    "no-rate": {"algo": "mappo", "policy": "centralized_critic", "without_reward": ("rate",)},
    "no-nav": {"algo": "mappo", "policy": "centralized_critic", "without_reward": ("nav",)},
    "no-col": {"algo": "mappo", "policy": "centralized_critic", "without_reward": ("col",)},
    "no-term": {"algo": "mappo", "policy": "centralized_critic", "without_reward": ("term",)},
    "no-entropy": {"algo": "mappo", "policy": "centralized_critic", "ent_coef": 0.0},
    "ippo": {"algo": "mappo", "policy": "local_critic"},
    "blind": {"algo": "mappo", "policy": "congestion_blind"},
    "knows-nothing": {**LADDER, "policy": "knows_nothing"},
    "knows-loads": {**LADDER, "policy": "knows_clock"},
    "knows-destinations": {**LADDER, "policy": "knows_destinations"},
}
"""What a method must be to play each part."""

FORMS = ("mappo", "mappo-o")
"""CTDE-MAPPO with the critic V(x) that the paper writes down (Eq. (11), eq:global_state, and Algorithm 1), and with
V([o_i, x]): claims about CTDE-MAPPO are tested for both, and both have to hold."""

UNLESS_SET = {"share_parameters": False, "normalize_value": True, "without_reward": (), "ent_coef": "any"}
"""What tell parts apart, and the defaults: a method that changes one plays only a part that asks for it. Of the entropy
coefficient only that it is 0 tells a part."""


def cast(methods: Mapping[str, Method]) -> dict[str, str]:
    """Who plays which part.

    :param methods: the methods of a recipe by key, in its order
    :return: part: key of the first method that plays it
    """
    found: dict[str, str] = {}
    for role in ROLES:
        for key, method in methods.items():
            if _plays(method, role):
                found.setdefault(role, key)
    return found


def described(role: str) -> str:
    """What a method must be to play a part, for an error."""
    return ", ".join(f"{name} {str(value).lower()}" for name, value in ROLES[role].items())


def _plays(method: Method, role: str) -> bool:
    fields = {name: getattr(method, name) for name in ("player", "algo", "policy", "without_reward")}
    values = {**UNLESS_SET, **method.settings, **fields}
    if values["ent_coef"] != 0.0:
        values["ent_coef"] = "any"
    return all(values[name] == wanted for name, wanted in {**UNLESS_SET, **ROLES[role]}.items())
