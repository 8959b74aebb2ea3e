"""Claims that the paper's own constants and equations decide, without any training."""

from __future__ import annotations

import numpy as np

from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.game.airspace import action_table
from lawn_sb3.game.payoff import corrected_rate, ema_rate
from lawn_sb3.game.player import RandomPlayer
from lawn_sb3.game.radio import rate_unit_mbps, rb_share
from lawn_sb3.paper.claims.claim import CannotTellError, Evidence, Finding
from lawn_sb3.paper.claims.comparisons import combine, counted, join
from lawn_sb3.paper.claims.table_rows import FAR
from lawn_sb3.paper.identification.bounds import draw_legs, rate_terms_mbps
from lawn_sb3.paper.printed_values import ROUNDING, TABLE_II, TEST_EPISODES
from lawn_sb3.scenario import load_scenario

RATE_MBPS = 30.0
SWING_MBPS = 10.0
"""Rates of the examples, near those of Table II."""
EXAMPLE_SLOTS = (1, 10, 100)


def share_falls(evidence: Evidence) -> Finding:
    """Whether every UAV that enters a cell lowers the RB share of all in it (eq:rb).

    :param evidence: what the runs left
    :return: the finding; partly if rounding down leaves some shares as they were
    :raises CannotTellError: if there is a single UAV
    """
    game = evidence.results.recipe.game()
    if game.num_uavs < 2:
        raise CannotTellError("needs a game of at least two UAVs")
    loads = range(1, game.num_uavs + 1)
    shares = np.array([[rb_share(int(num_rbs), load) for load in loads] for num_rbs in np.unique(game.num_rbs)])
    held = (np.diff(shares, axis=1) < 0).ravel()
    listed = "; ".join(", ".join(map(str, row)) for row in shares)
    return Finding(
        combine(held.tolist()),
        f"N = {game.num_uavs}: {listed}",
        f"Each further UAV has to lower the share: {counted(held.tolist())}.",
    )


def longest_move(evidence: Evidence, at_most: int) -> Finding:
    """Whether a UAV moves so little in a slot as the paper says when it chooses the slot duration.

    :param evidence: what the runs left
    :param at_most: voxels
    :return: the finding
    """
    steps = load_scenario("as-printed").max_voxel_steps
    moves = np.abs(action_table(steps)).sum(axis=1)
    further = int((moves > at_most).sum())
    return Finding(
        "impossible as printed" if further else "reproduced",
        f"{further} of the {len(moves)} moves of A_i lead further than {at_most} voxel with v_max = {steps}",
        f"No move of eq:action_space may lead further; with Table I's v_max {further} do.",
    )


def continuous_actions(evidence: Evidence) -> Finding:
    """Whether the action space is continuous.

    :param evidence: what the runs left
    :return: the finding: eq:action_space is a finite set
    """
    count = len(action_table(load_scenario("as-printed").max_voxel_steps))
    return Finding(
        "impossible as printed",
        f"A_i has {count} elements",
        "By eq:action_space A_i is a finite set of displacements, and the actor ends in a softmax over it.",
    )


def fluctuation_costs(evidence: Evidence) -> Finding:
    """Whether the corrected EMA rate captures the mean of the rates, and takes something off where they fluctuate.

    :param evidence: what the runs left
    :return: the finding: two conditions
    """
    beta = evidence.results.recipe.game().ema_beta
    low, high = RATE_MBPS - SWING_MBPS, RATE_MBPS + SWING_MBPS
    steady, rising, falling = (
        _corrected([first, second] * (EXAMPLE_SLOTS[1] // 2), beta)
        for first, second in ((RATE_MBPS, RATE_MBPS), (low, high), (high, low))
    )
    either = (rising + falling) / 2
    return Finding(
        combine([bool(np.isclose(steady, RATE_MBPS)), bool(either < steady - 1e-6)]),
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


def duration_pays_nothing(evidence: Evidence) -> Finding:
    """Whether the rate term of the reward (eq:reward_rate) adds up to no more on a longer flight at the same rate.

    :param evidence: what the runs left
    :return: the finding: it telescopes, and its sum does not grow
    """
    beta = evidence.results.recipe.game().ema_beta
    ema = [0.0]
    for _ in range(max(EXAMPLE_SLOTS)):
        ema.append(ema_rate(ema[-1], RATE_MBPS, beta))
    sums = np.concatenate([[0.0], np.cumsum(np.diff(ema))])
    telescopes, grows = bool(np.allclose(sums, ema)), bool(sums[-1] > sums[1] + 1e-6)
    shown = [f"{100 * sums[slots] / RATE_MBPS:.0f} % after {slots}" for slots in EXAMPLE_SLOTS]
    return Finding(
        combine([telescopes, not grows]),
        f"sum of the term, as a share of the rate: {join(shown)} slots",
        "The sum has to telescope, and not to grow with the flight: it telescopes to the EMA rate, which starts at 0 "
        "and has no bias correction here.",
    )


def printed_grid(evidence: Evidence) -> Finding:
    """Whether the paper's figures are possible on the grid that its Table I prints.

    :param evidence: what the runs left
    :return: the finding
    """
    game, chosen = load_scenario("as-printed"), evidence.results.recipe.evaluation
    rows = evaluate(RandomPlayer(), game, chosen.episodes, chosen.seed)
    least = rows.groupby("episode")["min_slots"].mean()
    error = float(np.nan_to_num(least.std(ddof=1))) * np.sqrt(1 / len(least) + 1 / TEST_EPISODES)
    printed, random = TABLE_II["CTDE-MAPPO"].makespan_slots, TABLE_II["Random"].success_percent
    impossible = bool(least.mean() - FAR * error > printed + ROUNDING.makespan_slots)
    return Finding(
        "impossible as printed" if impossible else "not testable",
        f"{' x '.join(map(str, game.grid))} voxels: T_min is {least.mean():.1f} ± {error:.1f} slots on average (one "
        f"standard error; the paper's CTDE-MAPPO took {printed:g}); Random succeeds in "
        f"{100 * rows['arrived'].mean():.2f} % of the missions (paper {random:g} %)",
        "No method can be faster than T_min on average, and the printed time is."
        if impossible
        else "The printed time is possible there; whether a method reaches it, only runs on that grid could tell.",
    )


def reward_in_mbps(evidence: Evidence) -> Finding:
    """Whether CTDE-MAPPO's printed J is possible with its printed rate, time and success and U_i in Mbps.

    Progress is worth something above 0, and collisions are forbidden by eq:collision, so what is left of the
    reward, the EMA rate and the utility, is a lower bound of J.

    :param evidence: what the runs left
    :return: the finding
    """
    game, chosen, row = load_scenario("paper"), evidence.results.recipe.evaluation, TABLE_II["CTDE-MAPPO"]
    legs = draw_legs(game, chosen.episodes, chosen.seed)
    latest = row.makespan_slots + ROUNDING.makespan_slots
    least = float(rate_terms_mbps(game, legs.min_slots, row.rate_mbps, latest, largest=False).mean())
    unit, impossible = rate_unit_mbps(game), least > row.reward + ROUNDING.reward
    return Finding(
        "impossible as printed" if impossible else "not testable",
        f"least J̄ of any method with the printed R̂, T̄ and success: {least:.1f} with rates in Mbps, "
        f"{least / unit:.2f} in units of {unit:.1f} Mbps (paper {row.reward:g})",
        "Without collisions, which eq:collision forbids, rate and terminal terms alone exceed the printed J̄."
        if impossible
        else "The printed J̄ is possible; the unit of rates inside rewards remains open.",
    )
