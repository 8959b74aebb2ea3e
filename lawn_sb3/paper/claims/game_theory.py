"""Claims about the game: whether it has a potential and can be solved, and if its welfare is maximised and fair."""

import numpy as np

from lawn_sb3.game.fairness import gini
from lawn_sb3.paper.claims.claim import Condition, Finding, claim
from lawn_sb3.paper.claims.evidence import CannotTellError, Evidence
from lawn_sb3.paper.claims.rule_parts import TINY, combine, difference, holds_if, in_words, join, seed_difference
from lawn_sb3.paper.roles import FORMS
from lawn_sb3.results.attainable import attainable
from lawn_sb3.results.equilibria import is_equilibrium

NEARLY = 0.99
"""A welfare of this share of a proven bound counts as the largest."""


@claim(
    place=320,
    section="III",
    text="The problem is a congestion game as Rosenthal defines it.",
    measure="gains around closed cycles of four deviations of two UAVs in the association game of one slot, of rates "
    "and of log-rates; an exact potential needs them to add up to 0",
)
def congestion_game(evidence: Evidence) -> Finding:
    """Whether one slot's association game is one of Rosenthal's congestion games, which have an exact potential."""
    cycles = evidence.check("deviation_cycles")
    gains = cycles["rate_gain_mbps"].abs()
    rates, log_rates = gains > TINY, cycles["log_rate_gain"].abs() > TINY
    verdict = combine([holds_if(not rates.any()), holds_if(not log_rates.any())])
    return Finding(
        verdict,
        f"gains around {len(cycles):,} closed cycles of four deviations do not add up to 0 in {rates.sum():,} for "
        f"rates (by up to {gains.max():.1f} Mbps), in {log_rates.sum():,} for log-rates",
        "All sums have to be 0, as in every congestion game of Rosenthal's: "
        + (
            "they are."
            if verdict == "reproduced"
            else "they are not, for log-rates either."
            if log_rates.any()
            else "with log-rates they are, so each slot taken alone has a potential and a pure equilibrium; with the "
            "rates, which the utility adds up over slots, they are not, as links differ between UAVs."
        ),
    )


@claim(
    place=404,
    section="III-B",
    text="Solving the game directly is intractable: the joint strategy space grows exponentially with N.",
    measure="test episodes for which a planner finds an equilibrium that is certified by exact best responses, and the "
    "share of a proven bound of the welfare that planners reach",
)
def solving_intractable(evidence: Evidence) -> Finding:
    """Whether neither an equilibrium nor the largest welfare is found directly: each is a sense of solving it."""
    results, key = evidence.results, evidence.key("equilibrium")
    limits, rows = attainable(results), results.regrets
    if limits is None or not len(rows) or key not in set(rows["method"]):
        raise CannotTellError("needs the bound, and what the UAVs of the equilibria could gain by deviating")
    certified = is_equilibrium(results, key)
    share = float(limits.best_known_mbps.mean() / limits.bound_mbps.mean())
    senses: list[list[Condition]] = [
        ["fails" if certified.all() else "open"],
        ["fails" if share >= NEARLY else "open"],
    ]
    learner = max(float(evidence.scores(role, "utility_mbps").mean()) for role in FORMS)
    best = evidence.scores("welfare", "utility_mbps").mean()
    return Finding(
        combine(*senses),
        f"certified equilibria in {certified.sum():,} of {certified.size:,} test episodes; {100.0 * share:.1f} % of "
        f"the bound, no less than {best:.1f} Mbps a UAV, where CTDE-MAPPO has up to {learner:.1f}",
        "Directly means without learning. An equilibrium of every game "
        f"{'is' if certified.all() else 'is not'} found so; that welfare is the largest is "
        f"{'nearly proven' if share >= NEARLY else 'not proven'}, though planners earn more than the learners. This is "
        f"for N = {results.recipe.game().num_uavs}, and says nothing of how it grows.",
    )


@claim(
    place=770,
    section="III-A, V-C, VI",
    text="The joint policy maximises social welfare.",
    measure="difference in mean utility to a planner that is told no more than o_i and the clock, and to a coordinate "
    "ascent on the welfare with full information",
    headline=True,
)
def welfare_maximising(evidence: Evidence) -> Finding:
    """Whether a policy earns less than planners do: of policies over o_i, or of all; the largest welfare is unknown."""
    symbol, unit, decimals = in_words("utility_mbps")
    figures, less = [], []
    forms: list[list[Condition]] = []
    for role in FORMS:
        parts, conditions = [], []
        for other in ("forecast", "welfare"):
            found = difference(evidence, "utility_mbps", role, other)
            parts.append(f"{found.text(decimals)}{unit} against {evidence.label(other)}")
            conditions.append(found.above(-1.0))
        figures.append(f"{evidence.label(role)}: {symbol} {', '.join(parts)}")
        forms.append(["fails" if "holds" in conditions else "open"])
        if forms[-1] == ["fails"]:
            less.append(evidence.label(role))
    why = "A policy that maximises the welfare cannot earn less than planners do, whether they see as much or more"
    return Finding(
        combine(*forms),
        "; ".join(figures),
        f"{why}; {join(less)} {'does' if len(less) == 1 else 'do'}." if less else f"{why}.",
    )


@claim(
    place=780,
    section="V-C, VI",
    text="The policy that maximises the social welfare distributes utilities unevenly.",
    measure="difference in the Gini coefficient of U within an episode between a coordinate ascent on the welfare and "
    "UAVs that look after themselves, in an equilibrium or flying straight",
)
def welfare_uneven(evidence: Evidence) -> Finding:
    """Whether joint flights for the welfare are less even than selfish and than blind ones."""
    own = gini(evidence.utilities_mbps("welfare"))  # [S, E]
    label, parts = evidence.label("welfare"), []
    held: list[Condition] = []
    for role in ("equilibrium", "straight"):
        others = gini(evidence.utilities_mbps(role))
        found = seed_difference(evidence, "gini", "welfare", role, own.mean(axis=1), others.mean(axis=1))
        parts.append(f"{evidence.label(role)} {others.mean():.3f}, difference {found.text(3)}")
        held.append(found.above())
    return Finding(
        combine(held),
        f"Gini coefficient of U within an episode: {label} {own.mean():.3f}; {'; '.join(parts)}",
        f"{label} has to be the less even one against both, and "
        + ("is." if set(held) == {"holds"} else "is the more even one." if set(held) == {"fails"} else "is not."),
    )


@claim(
    place=785,
    section="V-C",
    text="Optimising the social welfare does not guarantee fair outcomes for every individual agent.",
    measure="test episodes whose utilities are less even, by the Gini coefficient, for a coordinate ascent on the "
    "welfare than in the equilibrium where all look after themselves; one of them shows that nothing is guaranteed",
)
def welfare_unfair(evidence: Evidence) -> Finding:
    """Whether any episode is less even than where every UAV looks after itself; who has less by it is told beside."""
    own, others = (evidence.utilities_mbps(role) for role in ("welfare", "equilibrium"))  # [S, E, N] each
    seeds = min(len(own), len(others))
    own, others = own[:seeds], others[:seeds]
    worse = 100.0 * float((own < others - TINY).mean())
    uneven = 100.0 * float((gini(own) > gini(others) + TINY).mean())
    label, rival = evidence.label("welfare"), evidence.label("equilibrium")
    game = evidence.results.recipe.game()
    return Finding(
        combine([holds_if(uneven > 0.0)]),
        f"{label} against {rival}: {uneven:.0f} % of the episodes are less even, {worse:.0f} % of the UAVs have less; "
        f"mean U of the UAV that has least {np.mean(own.min(axis=-1)):.1f} against {np.mean(others.min(axis=-1)):.1f} "
        "Mbps",
        "An episode has to be less even than if all looked after themselves; on average it is otherwise "
        f"(welfare-uneven). This is for {game.num_uavs} UAVs and {game.num_gbs} GBSs.",
    )
