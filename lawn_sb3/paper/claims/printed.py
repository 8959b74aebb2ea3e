"""Claims that the paper's own constants, equations and tables decide, without any training."""

import itertools
from functools import cache

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.airspace import action_table
from lawn_sb3.game.payoff import corrected_rate, ema_rate, slot_weight, utility
from lawn_sb3.game.radio import (
    link_distances_m,
    nearest_gbs,
    rate_unit_mbps,
    rb_rate_mbps,
    rb_share,
)
from lawn_sb3.paper.claims.claim import Condition, Finding, claim
from lawn_sb3.paper.claims.evidence import CannotTellError, Evidence
from lawn_sb3.paper.claims.rule_parts import combine, counted, holds_if, join
from lawn_sb3.paper.printed_values import ROUNDING, TABLE_II
from lawn_sb3.paper.standard_error import RULED_OUT_Z, standard_error
from lawn_sb3.scenario import PRESETS, Scenario

RATE_MBPS = 30.0
SWING_MBPS = 10.0
"""Rates of the examples, near those of Table II."""
EXAMPLE_SLOTS = (1, 10, 100)
POINTS = 3
"""Points of a voxel along each axis, in the middle of its thirds."""


@claim(
    place=110,
    section="Abstract, I, III",
    text="A UAV that enters a GBS cell reduces the RB share of all UAVs served there.",
    measure="RBs of each UAV by eq:rb, for 1 to N UAVs in the cell",
    owed_to="by construction",
)
def share_falls(evidence: Evidence) -> Finding:
    """Whether every UAV that enters lowers the share, Eq. (1), eq:rb; partly if rounding down leaves some unchanged."""
    game = evidence.results.recipe.game()
    if game.num_uavs < 2:
        raise CannotTellError("needs a game of at least two UAVs")
    loads = range(1, game.num_uavs + 1)
    shares = np.array([[rb_share(int(num_rbs), load) for load in loads] for num_rbs in np.unique(game.num_rbs)])
    held = [holds_if(bool(falls)) for falls in (np.diff(shares, axis=1) < 0).ravel()]
    listed = "; ".join(", ".join(map(str, row)) for row in shares)
    return Finding(
        combine(held),
        f"N = {game.num_uavs}: {listed}",
        f"Each further UAV has to lower the share: {counted(held)}.",
    )


@claim(
    place=210,
    section="II-B with Table I",
    text="The slot is so short that a UAV's displacement in it remains within one voxel; v_max is 3 voxels a slot.",
    measure="L1 norms of the moves of eq:action_space",
)
def one_voxel_a_slot(evidence: Evidence) -> Finding:
    """Whether a UAV moves so little in a slot as the paper says when it chooses the slot duration."""
    at_most, steps = 1, PRESETS["as-printed"].max_voxel_steps
    moves = np.abs(action_table(steps)).sum(axis=1)
    further = int((moves > at_most).sum())
    return Finding(
        "impossible as printed" if further else "reproduced",
        f"{further} of the {len(moves)} moves of A_i lead further than {at_most} voxel with v_max = {steps}",
        f"No move of eq:action_space may lead further; with Table I's v_max {further} do.",
    )


@claim(
    place=215,
    section="II-B",
    text="Propagation is nearly constant within a voxel, so the channel gain can be evaluated at the voxel centre "
    "without loss of generality.",
    measure="rate of a UAV alone at 27 points of every voxel, here and on the grid of Table I: their mean less the "
    "rate at the centre, and their range. The paper calls two rates comparable that differ by 8 % (CTDE-MAPPO and "
    "QMIX, V-B), and nearly constant has to be no more than that in every voxel; and the GBS has to be the same",
)
def voxel_centres(evidence: Evidence) -> Finding:
    """Whether the rate at a voxel's centre stands for the voxel, Eq. (2), eq:rate."""
    first, second = TABLE_II["CTDE-MAPPO"].rate_mbps, TABLE_II["QMIX"].rate_mbps
    comparable, figures = abs(first - second) / second, []
    held: list[Condition] = []
    for game in dict.fromkeys((evidence.results.recipe.game(), PRESETS["as-printed"])):
        off, ranges, moved = _within_voxels(game)
        held += [holds_if(off.max() <= comparable), holds_if(ranges.max() <= comparable), holds_if(not moved.any())]
        figures.append(
            f"{' x '.join(map(str, game.grid))} voxels: the mean is at most {100.0 * off.max():.1f} % off, the range "
            f"{100.0 * ranges.mean():.1f} % on average and {100.0 * ranges.max():.0f} % at most, above "
            f"{100.0 * comparable:.0f} % in {100.0 * (ranges > comparable).mean():.2g} % of the voxels; another GBS is "
            f"nearer somewhere in {100.0 * moved.mean():.2g} %"
        )
    return Finding(combine(held), "; ".join(figures), f"All three have to hold on each grid: {counted(held)}.")


@cache
def _within_voxels(game: Scenario) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """How the rate of a UAV alone varies within each voxel, for all voxels [V].

    :param game: the game
    :return: by how much its mean over 27 points is off the rate at the centre, and its range, both as shares of that
        rate; and whether any of the points is served by another GBS than the centre
    """
    centres_m = game.voxel_centre(np.moveaxis(np.indices(game.grid), 0, -1).reshape(-1, 3))
    thirds_m = ((np.arange(POINTS) + 0.5) / POINTS - 0.5) * game.voxel_size_m
    served = [_served(game, centres_m + offset_m) for offset_m in itertools.product(thirds_m, repeat=3)]
    rates_mbps, cells = (np.stack(values) for values in zip(*served, strict=True))  # [27, V] each
    centre = len(served) // 2
    off = np.abs(rates_mbps.mean(axis=0) / rates_mbps[centre] - 1.0)
    return off, np.ptp(rates_mbps, axis=0) / rates_mbps[centre], (cells != cells[centre]).any(axis=0)


def _served(game: Scenario, position_m: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Rate of a UAV alone in Mbps, and its GBS, at positions in metres [B, 3]."""
    distances_m = link_distances_m(position_m, game.gbs_positions)
    serving = nearest_gbs(distances_m)
    serving_m = np.take_along_axis(distances_m, serving[:, None], 1)[:, 0]
    single = rb_rate_mbps(serving_m, game.snr_at_1m, game.path_loss_exponent, game.rb_bandwidth_hz)
    return game.num_rbs[serving] * single, serving


@claim(
    place=220,
    section="Table I with Table II",
    text="The voxel grid is 100 x 100 x 30, and CTDE-MAPPO completes missions in 8.7 slots.",
    measure="least flight time T_min on that grid, mean over the UAVs, of origins and destinations drawn over the "
    "whole of it, as the paper's random missions without overlap are read here",
    headline=True,
)
def table_1_grid(evidence: Evidence) -> Finding:
    """Whether the paper's figures are possible on the grid that its Table I prints."""
    rows = evidence.check("printed_grid")
    least = rows.groupby("episode")["min_slots"].mean()
    error = standard_error(least)
    printed, random = TABLE_II["CTDE-MAPPO"].makespan_slots, TABLE_II["Random"].success_percent
    impossible = bool(least.mean() - RULED_OUT_Z * error > printed + ROUNDING.makespan_slots)
    return Finding(
        "impossible as printed" if impossible else "not testable",
        f"{' x '.join(map(str, PRESETS['as-printed'].grid))} voxels: T_min is {least.mean():.1f} ± {error:.1f} slots "
        f"on average (one standard error; the paper's CTDE-MAPPO took {printed:g}); Random succeeds in "
        f"{100 * rows['arrived'].mean():.2f} % of the missions (paper {random:g} %)",
        "No method can be faster than T_min on average, and the printed time is."
        if impossible
        else "The printed time is possible there; whether a method reaches it, only runs on that grid could tell.",
    )


@claim(
    place=325,
    section="III-A",
    text="The sum rate is an inadequate metric: it grows with the duration of a mission, and does not penalise "
    "fluctuation.",
    measure="sum over the slots of a steady rate in longer and longer flights, and of an alternating rate with the "
    "same mean",
    owed_to="by construction",
)
def sum_rate_inadequate(evidence: Evidence) -> Finding:
    """Whether the sum of the rates is what the paper says, Section III-A, which holds of every sum."""
    slots = EXAMPLE_SLOTS[1]
    by_duration = [RATE_MBPS * flown for flown in EXAMPLE_SLOTS]
    alternating = sum([RATE_MBPS - SWING_MBPS, RATE_MBPS + SWING_MBPS] * (slots // 2))
    grows, blind = bool(np.all(np.diff(by_duration) > 0.0)), bool(np.isclose(alternating, RATE_MBPS * slots))
    shown = [f"{total:g} over {flown}" for flown, total in zip(EXAMPLE_SLOTS, by_duration, strict=True)]
    return Finding(
        combine([holds_if(grows), holds_if(blind)]),
        f"a steady {RATE_MBPS:g} Mbps adds up to {join(shown)} slots; {RATE_MBPS - SWING_MBPS:g} and "
        f"{RATE_MBPS + SWING_MBPS:g} Mbps by turns to {alternating:g} over {slots}",
        "The sum has to grow with the flight, and to be the same where the rate fluctuates: both hold. The EMA rate, "
        "which the paper takes instead, does not penalise fluctuation as such either (ema-consistency).",
    )


@claim(
    place=330,
    section="III-A",
    text="The terminal EMA rate captures both mean rate quality and temporal consistency.",
    measure="corrected EMA rate of a steady and of an alternating rate with the same mean",
)
def ema_consistency(evidence: Evidence) -> Finding:
    """Whether the corrected EMA rate captures the mean of the rates, and takes something off where they fluctuate."""
    beta = evidence.results.recipe.game().ema_beta
    low, high = RATE_MBPS - SWING_MBPS, RATE_MBPS + SWING_MBPS
    steady, rising, falling = (
        _corrected([first, second] * (EXAMPLE_SLOTS[1] // 2), beta)
        for first, second in ((RATE_MBPS, RATE_MBPS), (low, high), (high, low))
    )
    either = (rising + falling) / 2
    return Finding(
        combine([holds_if(bool(np.isclose(steady, RATE_MBPS))), holds_if(bool(either < steady - 1e-6))]),
        f"{EXAMPLE_SLOTS[1]} slots at {RATE_MBPS:g} Mbps give R̂ {steady:.1f}; {low:g} and {high:g} Mbps by turns give "
        f"{rising:.1f} or {falling:.1f}, as the last slot has it, {either:.1f} on average",
        "A steady rate has to come out as it is, and one that fluctuates around it lower; R̂ is a weighted mean of the "
        "rates, so fluctuation as such costs nothing.",
    )


def _corrected(rates_mbps: list[float], beta: float) -> float:
    ema = 0.0
    for rate in rates_mbps:
        ema = ema_rate(ema, rate, beta)
    return float(corrected_rate(ema, beta, len(rates_mbps)))


@claim(
    place=405,
    section="III-B",
    text="The terminal payoff U_i cannot be decomposed into per-step decisions analytically.",
    measure="U_i of rates drawn at random, for every flight time up to T_max, less the sum over the slots of rate "
    "times the weight w(t) = beta (1 - beta)^(T - t) / (1 - (1 - beta)^T) T_min/T, where no other slot's rate occurs",
)
def payoff_decomposition(evidence: Evidence) -> Finding:
    """Whether the utility, Eq. (9), eq:utility, is no sum over slots once the flight time is chosen."""
    game, rng = evidence.results.recipe.game(), np.random.default_rng(0)
    beta, least, off = game.ema_beta, 1, 0.0
    for flown in range(1, game.max_slots + 1):
        rates, ema = rng.uniform(0.0, 2.0 * RATE_MBPS, flown), 0.0
        for rate in rates:
            ema = ema_rate(ema, float(rate), beta)
        weights = [slot_weight(beta, flown - t, least, flown, flown) for t in range(1, flown + 1)]
        off = max(off, abs(utility(corrected_rate(ema, beta, flown), least, flown) - float(np.dot(weights, rates))))
    agrees = off < 1e-6
    return Finding(
        combine([holds_if(not agrees)]),
        f"largest difference {off:.1e} Mbps over flights of 1 to {game.max_slots} slots",
        "For each flight time U_i must be no sum over the slots: "
        + (
            "it is one, so a backward recursion over slots and voxels finds a UAV's exact best flight beside the "
            "others'; the planners here rest on it."
            if agrees
            else "it is none."
        ),
    )


@claim(
    place=420,
    section="IV-A",
    text="The rate term of the reward telescopes and does not directly favour longer trajectories.",
    measure="its sum over a flight at a steady rate",
)
def rate_term_duration(evidence: Evidence) -> Finding:
    """Whether the rate term, Eq. (15), eq:reward_rate, adds up to no more on a longer flight at the same rate."""
    beta = evidence.results.recipe.game().ema_beta
    ema = [0.0]
    for _ in range(max(EXAMPLE_SLOTS)):
        ema.append(ema_rate(ema[-1], RATE_MBPS, beta))
    sums = np.concatenate([[0.0], np.cumsum(np.diff(ema))])
    telescopes, grows = bool(np.allclose(sums, ema)), bool(sums[-1] > sums[1] + 1e-6)
    shown = [f"{100 * sums[slots] / RATE_MBPS:.0f} % after {slots}" for slots in EXAMPLE_SLOTS]
    return Finding(
        combine([holds_if(telescopes), holds_if(not grows)]),
        f"sum of the term, as a share of the rate: {join(shown)} slots",
        "The sum has to telescope, and not to grow with the flight: it telescopes to the EMA rate, which starts at 0 "
        "and has no bias correction here.",
    )


@claim(
    place=430,
    section="IV-A with Table II",
    text="The terminal reward is U_i, a rate, which Table II gives in Mbps, and CTDE-MAPPO earns 3.19 in all.",
    measure="least J̄ with rates in Mbps, by linear programming over the lengths of the test missions, if no UAV ever "
    "collides, as eq:collision demands",
)
def table_1_reward_unit(evidence: Evidence) -> Finding:
    """Whether CTDE-MAPPO's printed J is possible with its printed rate, time and success and U_i in Mbps."""
    row, unit = TABLE_II["CTDE-MAPPO"], rate_unit_mbps(PRESETS["paper"])
    terms = evidence.check("least_reward")
    least = float(np.average(terms["least_mbps"], weights=terms["uavs"]))
    impossible = least > row.reward + ROUNDING.reward
    return Finding(
        "impossible as printed" if impossible else "not testable",
        f"least J̄ of any method with the printed R̂, T̄ and success: {least:.1f} with rates in Mbps, "
        f"{least / unit:.2f} in units of {unit:.1f} Mbps (paper {row.reward:g})",
        "Without collisions, which eq:collision forbids, rate and terminal terms alone exceed the printed J̄: some "
        "unit of rates inside the rewards is missing from the paper."
        if impossible
        else "The printed J̄ is possible; the unit of rates inside rewards remains open.",
    )


@claim(
    place=450,
    section="IV-B with III-B",
    text="The trajectory action space is continuous.",
    measure="number of elements of A_i, eq:action_space",
)
def continuous_actions(evidence: Evidence) -> Finding:
    """Whether the action space is continuous: by Eq. (13), eq:action_space, it is a finite set."""
    count = len(action_table(PRESETS["as-printed"].max_voxel_steps))
    return Finding(
        "impossible as printed",
        f"A_i has {count} elements",
        "By eq:action_space A_i is a finite set of displacements, and the actor ends in a softmax over it.",
    )


@claim(
    place=475,
    section="IV-B with Eqs. (20) and (22)",
    text="The critic maps the global state to the expected discounted team return.",
    measure="the value that makes eq:critic_loss least in a state, for returns of the UAVs drawn at random, as a share "
    "of their mean sum",
)
def critic_team_return(evidence: Evidence) -> Finding:
    """Whether the critic loss, Eq. (22), eq:critic_loss, over each UAV's own return, is least at the team's."""
    num_uavs, rng = evidence.results.recipe.game().num_uavs, np.random.default_rng(0)
    returns = rng.normal(rng.uniform(1.0, 5.0, num_uavs), 1.0, (1_000, num_uavs))  # [samples of one state, N]
    fitted = float(np.linalg.lstsq(np.ones((returns.size, 1)), returns.ravel(), rcond=None)[0][0])
    share = fitted / float(returns.sum(axis=1).mean())
    return Finding(
        combine([holds_if(bool(np.isclose(share * num_uavs, 1.0))), holds_if(bool(np.isclose(share, 1.0)))]),
        f"N = {num_uavs}: the best V(x) is {share:.3g} of the team's return",
        "The best V(x) has to be in proportion to the team's return, and to be it: fitted to the UAVs' own returns it "
        "is their mean, the team's over N. So advantages, Eq. (20), hold what a UAV gets against the mean of all.",
    )
