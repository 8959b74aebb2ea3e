"""What a method's UAVs know when they act, and what has to be communicated for it."""

from collections.abc import Collection, Mapping
from typing import Literal, get_args

from lawn_sb3.envs.observation import Sight, broadcast_bits
from lawn_sb3.experiment.find_policy import find_policy
from lawn_sb3.experiment.recipe import Method
from lawn_sb3.scenario import Scenario

Rung = Literal["nothing", "loads", "clock", "memory", "destinations", "intents", "state"]
RUNGS: tuple[Rung, ...] = get_args(Rung)
"""The ladder, from the bottom: each rung knows what those below it know, but for memory, which stands aside."""
FEWEST_RUNGS = 3
"""A recipe whose learners stand on fewer has no ladder."""

PLAYERS: dict[str, Rung | None] = {
    "random": "nothing",
    "shortest-path": "nothing",
    "best-route": "nothing",
    "forecast": "clock",
    "mean-field": "clock",
    "mean-field-memory": "memory",
    "mean-field-destinations": "destinations",
    "worst-equilibrium": "state",
    "equilibrium": "state",
    "welfare": "state",
    "bound": None,
}
"""The rung of every player without training; the bound's UAVs have a network each, so nobody is there to know of."""

SEES: dict[Rung, tuple[Sight, ...]] = {
    "nothing": (),
    "loads": (),
    "clock": ("clock",),
    "memory": ("clock", "memory"),
    "destinations": ("clock", "destinations"),
    "intents": ("clock", "intents"),
    "state": ("state",),
}


def rung_of(method: Method) -> Rung | None:
    """The rung on which a method stands; none if its UAVs have nobody to know of."""
    if method.player is not None:
        return PLAYERS[method.player]
    assert method.policy is not None
    policy = find_policy(method.policy)
    sees: Collection[Sight] = getattr(policy, "sees", ())
    for rung in reversed(RUNGS):
        if rung in sees and rung != "clock":
            return rung
    if not getattr(policy, "looks_at_loads", True):
        return "nothing"
    return "clock" if "clock" in sees else "loads"


def has_ladder(methods: Mapping[str, Method]) -> bool:
    """Whether the learners among a recipe's methods stand on enough rungs to compare them."""
    return len({rung_of(method) for method in methods.values() if method.algo is not None}) >= FEWEST_RUNGS


def bits_of(method: Method, scenario: Scenario) -> int | None:
    """Uncoded bits that every UAV broadcasts in a slot for what a method's UAVs know; none if nobody hears them."""
    rung = rung_of(method)
    return None if rung is None else broadcast_bits(SEES[rung], scenario)
