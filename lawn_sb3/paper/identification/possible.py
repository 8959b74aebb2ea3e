"""Which weights of progress, rate units and ``ema_beta`` can give the J that the paper prints of CTDE-MAPPO."""

from collections.abc import Mapping
from typing import Any

import pandas as pd

from lawn_sb3.game.radio import rate_unit_mbps
from lawn_sb3.paper.identification.bounds import Floats, Legs, rate_range_mbps, rate_terms_mbps, rewards
from lawn_sb3.paper.identification.candidates import ALTERNATIVES, PAPER
from lawn_sb3.paper.printed_values import LATEST_SLOTS, ROUNDING, TABLE_II
from lawn_sb3.paper.standard_error import DISFAVOURED_Z, RULED_OUT_Z, standard_error

PRINTED = TABLE_II["CTDE-MAPPO"]
NONE = float("nan")


def rate_units_mbps() -> dict[str, float]:
    """Units that rates inside the rewards might have, in Mbps by name; the preset's first."""
    alone = rate_unit_mbps(PAPER)
    return {
        "lone UAV one voxel away": alone,
        "lone UAV in the best voxel": rate_range_mbps(PAPER)[1],
        "100 Mbps": 100.0,
        "10 Mbps": 10.0,
        "one RB one voxel away": alone / int(PAPER.num_rbs.max()),
        "1 Mbps": 1.0,
    }


def bounds_table(legs: Legs, random: Mapping[str, float]) -> pd.DataFrame:
    """Bounds on J by what it is made of, and whether the printed J lies between them.

    The paper's missions are others than ours: the bounds have the standard error of a mean of its episodes. A choice is
    ruled out if the printed J lies above the upper bound, or if not even a collision of every UAV in every slot of the
    printed T-bar brings the lower bound down to it. It is disfavoured if it takes more collisions than Random has.

    :param legs: missions of the preset
    :param random: means per UAV of Random's reward terms (:data:`lawn_sb3.paper.identification.reward.TERMS`)
    :return: one row for each rate unit with each ``nav_weight``, then for each other ``ema_beta``: the bounds, their
        error, the collisions that a UAV needs, the verdict; from which ``nav_weight`` on the paper's J is possible up
        to which without a collision and with Random's, NaN if there is none (sampling error apart); and the
        ``fail_penalty`` with which the choice gives the J of Random too, NaN where its rates are not known
    """
    units, betas = rate_units_mbps(), ALTERNATIVES["ema_beta"]
    weights = (PAPER.nav_weight, *ALTERNATIVES["nav_weight"])
    choices = [(PAPER.ema_beta, name, weight) for name in units for weight in weights]
    choices += [(beta, next(iter(units)), PAPER.nav_weight) for beta in betas]
    terms_mbps = {
        beta: [
            rate_terms_mbps(PAPER.changed(ema_beta=beta), legs.min_slots, PRINTED.rate_mbps, LATEST_SLOTS, largest)
            for largest in (False, True)
        ]
        for beta in (PAPER.ema_beta, *betas)
    }
    rows: list[dict[str, object]] = []
    for beta, name, weight in choices:
        choice = {"rate_unit": name, "rate_unit_mbps": units[name], "nav_weight": weight, "ema_beta": beta}
        row = _row(legs, terms_mbps[beta], random, units[name], weight)
        rows.append({**choice, "is_preset": not rows, **row})
    table = pd.DataFrame(rows)
    table.loc[table["ema_beta"] != PAPER.ema_beta, "fail_penalty_of_random"] = NONE
    return table


def _row(
    legs: Legs, terms_mbps: list[Floats], random: Mapping[str, float], unit_mbps: float, nav_weight: float
) -> dict[str, Any]:
    """The bounds of one choice, given the rate terms at least and at most."""
    usual, most = (PAPER.collision_penalty * each for each in (random["collisions"], PRINTED.makespan_slots))
    ends = [rewards(legs, terms, nav_weight, unit_mbps) for terms in terms_mbps]  # [E, N] each
    error = max(standard_error(pd.Series(end.mean(axis=1)), ROUNDING.reward) for end in ends)
    lower, upper = (float(end.mean()) for end in ends)
    reach = float(legs.distance_voxels.mean())
    first, last_clean, last = (nav_weight + (PRINTED.reward - end) / reach for end in (upper, lower, lower - usual))
    others = nav_weight * random["progress_voxels"] - usual + random["rate_sum_mbps"] / unit_mbps
    return {
        "lower": lower,
        "upper": upper,
        "standard_error": error,
        "collisions_needed": max(lower - PRINTED.reward, 0.0) / PAPER.collision_penalty,
        "verdict": _verdict(lower, upper, usual, most, error),
        "nav_weight_from": max(first, 0) if last >= 0 else NONE,
        "nav_weight_to_without_collisions": last_clean if last_clean >= 0 else NONE,
        "nav_weight_to": last if last >= 0 else NONE,
        "fail_penalty_of_random": (others - TABLE_II["Random"].reward) / random["failed"],
    }


def _verdict(lower: float, upper: float, usual_cost: float, most_cost: float, error: float) -> str:
    """What the printed J says of bounds, given what Random's collisions cost and what the most would."""
    above, below = PRINTED.reward - upper, lower - PRINTED.reward
    if max(above, below - most_cost) > RULED_OUT_Z * error:
        return "ruled out"
    return "disfavoured" if max(above, below - usual_cost) > DISFAVOURED_Z * error else "agrees"
