"""What can be chosen besides the game itself: how it goes on, which rewards training gives, how long flights may take.

Nothing here needs the compiled game or the learners, so that a recipe is checked before these are loaded.
"""

from numbers import Integral
from typing import Literal, get_args

from lawn_sb3.errors import UserError
from lawn_sb3.scenario import Scenario

MOST_EPISODES = 1_000_000
"""Joint episodes at a time; rows of all of them are held in memory."""
Continuation = Literal["mission", "episode"]
"""How UAVs that are done go on: with a mission of their own at once, or with a new game once all of theirs are done."""
RewardTerm = Literal["rate", "nav", "col", "term"]
REWARD_TERMS: tuple[RewardTerm, ...] = get_args(RewardTerm)
"""The terms of the reward; Eq. (14), eq:reward: r_i = r_i^rate + r_i^nav + r_i^col + r_i^term."""
Credit = Literal["own", "difference", "team"]
"""Whose reward a learner is given: the UAV's own; its own less what it takes from the utilities of the others in its
cell; or the mean over the UAVs of its game."""


def is_whole(value: object) -> bool:
    """Whether something is a whole number, NumPy's too; true and false are none."""
    return isinstance(value, Integral) and not isinstance(value, bool)


def check_fewest(fewest_uavs: int, scenario: Scenario, continuation: Continuation) -> None:
    """Refuse a smallest number of UAVs that the games cannot have.

    :raises UserError: if it is not from 1 to N, the games never start anew, or UAVs that are done stay in the air
    """
    if not 1 <= fewest_uavs <= scenario.num_uavs:
        raise UserError(f"fewest_uavs = {fewest_uavs}: from 1 to num_uavs = {scenario.num_uavs}")
    if continuation != "episode":
        raise UserError(f"fewest_uavs = {fewest_uavs} needs games that start anew: continuation episode")
    if scenario.arrived_uav != "leaves":
        raise UserError(f"fewest_uavs = {fewest_uavs} needs arrived_uav leaves: an absent UAV takes no resources")
