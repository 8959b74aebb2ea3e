"""Claims about the game: whether it has a potential, and whether welfare is maximised and costs fairness."""

from lawn_sb3.game.fairness import gini
from lawn_sb3.paper.claims.claim import Finding, Verdict, claim
from lawn_sb3.paper.claims.evidence import Evidence
from lawn_sb3.paper.claims.rule_parts import (
    TINY,
    combine,
    difference,
    in_words,
    is_positive,
    join,
    seed_difference,
)
from lawn_sb3.paper.roles import FORMS


@claim(
    place=320,
    section="III",
    text="The problem is a congestion game.",
    measure="gains around closed cycles of four deviations of two UAVs in the association game of one slot, of rates "
    "and of log-rates; an exact potential needs them to add up to 0",
)
def congestion_game(evidence: Evidence) -> Finding:
    """Whether one slot's association game is one of Rosenthal's congestion games, which have an exact potential."""
    cycles = evidence.check("deviation_cycles")
    gains = cycles["rate_gain_mbps"].abs()
    rates, log_rates = gains > TINY, cycles["log_rate_gain"].abs() > TINY
    verdict: Verdict = "not reproduced"
    if not log_rates.any():
        verdict = "partly" if rates.any() else "reproduced"
    return Finding(
        verdict,
        f"gains around {len(cycles):,} closed cycles of four deviations do not add up to 0 in {rates.sum():,} for "
        f"rates (by up to {gains.max():.1f} Mbps), in {log_rates.sum():,} for log-rates",
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


@claim(
    place=770,
    section="III-A, V-C, VI",
    text="The joint policy maximises social welfare.",
    measure="difference in mean utility to a coordinate ascent on the welfare with full information; interval over "
    "seeds",
    headline=True,
)
def welfare_maximising(evidence: Evidence) -> Finding:
    """Whether a policy earns no less than a planner, who finds no more than a lower bound of the largest welfare."""
    symbol, unit, decimals = in_words("utility_mbps")
    reached = evidence.scores("welfare", "utility_mbps").mean()
    figures, less = [f"{evidence.label('welfare')}: {symbol} {reached:.{decimals}f}{unit}"], []
    for role in FORMS:
        found = difference(evidence, "utility_mbps", role, "welfare")
        figures.append(f"{evidence.label(role)}: {found.text(decimals)}{unit} against it")
        if is_positive(-found.high):
            less.append(evidence.label(role))
    why = "A policy that maximises the welfare cannot earn less than joint trajectories that a planner has found"
    return Finding(
        combine([evidence.label(role) not in less for role in FORMS]),
        "; ".join(figures),
        f"{why}; {join(less)} {'does' if len(less) == 1 else 'do'}." if less else f"{why}.",
    )


@claim(
    place=780,
    section="V-C, VI",
    text="Optimising the social welfare distributes utilities unevenly, and does not guarantee fair outcomes.",
    measure="Gini coefficient of the utilities that a coordinate ascent on the welfare gives, against the equilibrium "
    "in which every UAV looks after itself, on average and episode by episode",
)
def welfare_unfair(evidence: Evidence) -> Finding:
    """Whether joint flights for the welfare are less even than selfish ones: on average, and in any episode at all."""
    own, others = (gini(evidence.utilities_mbps(role)) for role in ("welfare", "equilibrium"))  # [S, E] each
    found = seed_difference(own.mean(axis=1), others.mean(axis=1))
    same_seeds = min(len(own), len(others))
    share = 100.0 * float((own[:same_seeds] > others[:same_seeds] + TINY).mean())
    label, rival = evidence.label("welfare"), evidence.label("equilibrium")
    game = evidence.results.recipe.game()
    return Finding(
        combine([is_positive(found.low), share > 0.0]),
        f"Gini coefficient of U within an episode: {label} {own.mean():.3f}, {rival} {others.mean():.3f}, difference "
        f"{found.text(3)}; in {share:.0f} % of the episodes {label} is the less even one",
        "The first half needs a higher Gini coefficient on average, with its whole interval; that fairness is not "
        f"guaranteed needs episodes with a higher one. This is for {game.num_uavs} UAVs and {game.num_gbs} GBSs.",
    )
