"""From claims to verdicts: find each claim's test, run it, and say so where the evidence is missing."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from lawn_sb3.errors import UserError
from lawn_sb3.paper.claims import comparisons, curves, distributions, flights, game_theory, printed, table_rows
from lawn_sb3.paper.claims.claim import CannotTellError, Claim, Evidence, Finding, Judged
from lawn_sb3.paper.claims.comparisons import sentence

TESTS: dict[str, Callable[..., Finding]] = {
    test.__name__: test
    for test in (
        comparisons.better_than,
        comparisons.comparable,
        comparisons.suffices,
        table_rows.agrees_with_row,
        table_rows.average_completion,
        table_rows.time_ratio,
        table_rows.varies_little,
        table_rows.reaches,
        curves.crosses,
        curves.stays_above,
        curves.fluctuates_more,
        curves.learns_faster,
        curves.declines,
        curves.rises_together,
        distributions.larger,
        distributions.collapses,
        distributions.never_collide,
        distributions.uneven_through_congestion,
        printed.share_falls,
        printed.longest_move,
        printed.continuous_actions,
        printed.fluctuation_costs,
        printed.duration_pays_nothing,
        printed.printed_grid,
        printed.reward_in_mbps,
        flights.ignores_state,
        flights.hovering_explains_rate,
        game_theory.maximises_welfare,
        game_theory.costs_fairness,
        game_theory.has_potential,
    )
}
"""The tests of the claims, by name."""


def judge(claim: Claim, evidence: Evidence) -> Finding:
    """Hold one claim to the evidence.

    :param claim: the claim
    :param evidence: what the runs left
    :return: verdict, figure and reason; ``not testable`` where the evidence is missing
    """
    try:
        return TESTS[claim.test](evidence, **claim.arguments)
    except (CannotTellError, UserError) as error:  # the latter from runs that do not fit together
        elsewhere = f"; it is judged in the report of runs/{claim.needs}.yaml" if claim.needs is not None else ""
        return Finding("not testable", "", sentence(f"{error}{elsewhere}"))


def judge_all(claims: Sequence[Claim], evidence: Evidence) -> list[Judged]:
    """Hold all claims to the evidence.

    :param claims: the claims
    :param evidence: what the runs left
    :return: each claim with what was found, in order
    """
    return [Judged(claim, judge(claim, evidence)) for claim in claims]
