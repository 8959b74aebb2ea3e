"""Claims about the game: whether it has a potential, and whether welfare is maximised and costs fairness."""

from __future__ import annotations

from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.experiment.evaluation import evaluation_games
from lawn_sb3.game.fairness import gini
from lawn_sb3.paper.claims.claim import CannotTellError, Evidence, Finding, Verdict
from lawn_sb3.paper.claims.comparisons import (
    TINY,
    combine,
    difference,
    in_words,
    is_positive,
    join,
    seed_difference,
)
from lawn_sb3.paper.claims.distributions import UTILITY
from lawn_sb3.planning.association import association_rates_mbps, cycle_gain, deviation_cycle, one_slot_game


def maximises_welfare(evidence: Evidence, of: list[str], planner: str) -> Finding:
    """Whether a policy earns no less than a planner that climbs towards the largest welfare with full information.

    :param evidence: what the runs left
    :param of: the parts of the method's forms
    :param planner: the planner's part; what it earns is no more than a lower bound of the largest welfare
    :return: the finding
    """
    symbol, unit, decimals = in_words("utility_mbps")
    reached = evidence.scores(planner, "utility_mbps").mean()
    figures, less = [f"{evidence.label(planner)}: {symbol} {reached:.{decimals}f}{unit}"], []
    for role in of:
        found = difference(evidence, "utility_mbps", role, planner)
        figures.append(f"{evidence.label(role)}: {found.text(decimals)}{unit} against it")
        if is_positive(-found.high):
            less.append(evidence.label(role))
    why = "A policy that maximises the welfare cannot earn less than joint trajectories that a planner has found"
    return Finding(
        combine([evidence.label(role) not in less for role in of]),
        "; ".join(figures),
        f"{why}; {join(less)} {'does' if len(less) == 1 else 'do'}." if less else f"{why}.",
    )


def costs_fairness(evidence: Evidence, planner: str, other: str) -> Finding:
    """Whether joint flights for the welfare are less even than others: on average, and in any episode at all.

    :param evidence: what the runs left
    :param planner: the part that looks for welfare
    :param other: the part that it is held against
    :return: the finding
    """
    coefficients = [gini(evidence.results.scores(evidence.key(role), UTILITY, per="uav")) for role in (planner, other)]
    own, others = coefficients  # [S, E] each
    found = seed_difference(own.mean(axis=1), others.mean(axis=1))
    same_seeds = min(len(own), len(others))
    share = 100.0 * float((own[:same_seeds] > others[:same_seeds] + TINY).mean())
    label, rival = evidence.label(planner), evidence.label(other)
    return Finding(
        combine([is_positive(found.low), share > 0.0]),
        f"Gini coefficient of U within an episode: {label} {own.mean():.3f}, {rival} {others.mean():.3f}, difference "
        f"{found.text(3)}; in {share:.0f} % of the episodes {label} is the less even one",
        "The first half needs a higher Gini coefficient on average, with its whole interval; that fairness is not "
        f"guaranteed needs episodes with a higher one. This is for {evidence.results.recipe.game().num_uavs} UAVs and "
        f"{evidence.results.recipe.game().num_gbs} GBSs.",
    )


def has_potential(evidence: Evidence, games: int) -> Finding:
    """Whether the association game of one slot is one of Rosenthal's congestion games, which have an exact potential.

    :param evidence: what the runs left
    :param games: test missions whose first slot is looked at
    :return: the finding
    :raises CannotTellError: if no two UAVs can change their cells within a slot
    """
    sums = _cycle_sums(evidence, games)
    if not len(sums):
        raise CannotTellError("needs UAVs that can change their cells within a slot")
    rates, log_rates = (np.abs(column) > TINY for column in sums.T)
    verdict: Verdict = "not reproduced"
    if not log_rates.any():
        verdict = "partly" if rates.any() else "reproduced"
    return Finding(
        verdict,
        f"gains around {len(sums):,} closed cycles of four deviations do not add up to 0 in {int(rates.sum()):,} for "
        f"rates (by up to {np.abs(sums[:, 0]).max():.1f} Mbps), in {int(log_rates.sum()):,} for log-rates",
        "All sums have to be 0, as in every congestion game of Rosenthal's: "
        + (
            "with log-rates they are, so each slot taken alone has a potential and a pure equilibrium; with the rates, "
            "which the utility adds up over slots, they are not."
            if verdict == "partly"
            else "they are."
            if verdict == "reproduced"
            else "they are not, for log-rates either."
        ),
    )


def _cycle_sums(evidence: Evidence, games: int) -> NDArray[np.float64]:
    """Sums of the gains around cycles of two UAVs in the first slot of test missions: of rates and log-rates [C, 2]."""
    recipe = evidence.results.recipe
    simulator = evaluation_games(recipe.game(), min(games, recipe.evaluation.episodes), recipe.evaluation.seed)
    x, y, z = np.moveaxis(simulator.state.position, -1, 0)
    cells, num_rbs = simulator.rules.cell[x, y, z], simulator.rules.num_rbs
    sums = []
    for game, start in enumerate(cells):
        rb_rate_mbps, _ = one_slot_game(simulator, game)
        others = [[b for b in np.flatnonzero(own) if b != start[i]] for i, own in enumerate(rb_rate_mbps)]
        for uavs in combinations(range(len(start)), 2):
            for targets in product(others[uavs[0]], others[uavs[1]]):
                around = deviation_cycle(start, uavs, (int(targets[0]), int(targets[1])))
                rates_mbps = association_rates_mbps(rb_rate_mbps, num_rbs, around)
                if (rates_mbps > 0.0).all():
                    sums.append([float(cycle_gain(rates_mbps, uavs)), float(cycle_gain(np.log(rates_mbps), uavs))])
    return np.array(sums).reshape(-1, 2)
