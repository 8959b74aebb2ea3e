"""Table II: every method's figures with the paper's beside them, and every method held against CTDE-MAPPO."""

from lawn_sb3.experiment.knowledge import bits_of
from lawn_sb3.paper.comparable import printed_rows
from lawn_sb3.report.section import Section
from lawn_sb3.report.table import Table, row_of, sample_of, table_of
from lawn_sb3.results.attainable import attainable, explanation, share
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.results import BOUND, Results
from lawn_sb3.results.statistics import (
    UNKNOWN,
    crossed_t,
    holm,
    interquartile_mean,
    mean_interval,
    paired_difference,
    probability_of_improvement,
)

COLUMNS = ("reward", "rate_mbps", "makespan_slots", "success_percent", "utility_mbps")
"""The paper's four quantities, and the utility that they stand for."""
BASES = ("state_critic", "centralized_critic")
"""Policies of the method that others are held against, the first there is: the paper's own critic."""
COMPARED = ("reward", "utility_mbps")
STRAIGHT = "shortest-path"
"""The player that flies straight."""


def section(results: Results) -> Section:
    """Table II of all methods, and the comparison of those whose UAVs meet."""
    tables = {"table2": _table_two(results), "comparison": _comparison(results.without_bound())}
    return Section("Table II: performance", tables, summary=_beside_straight_flight(results))


def _table_two(results: Results) -> Table:
    """Means over seeds, the paper's values, and with results of the bound the share of the attainable welfare."""
    by_seed, limits, in_paper = results.by_seed(), attainable(results), printed_rows(results.recipe)
    rows = []
    for key, method in results.methods.items():
        own = by_seed[by_seed["method"] == key]
        printed = in_paper[key]._asdict() if key in in_paper else {}
        row = row_of(results, key, seeds=len(own), episodes=results.recipe.evaluation.episodes)
        for name in COLUMNS:
            quantity = QUANTITIES[name]
            paper = f" ({printed[name]:.{quantity.decimals}f})" if name in printed else ""
            row.add(name, quantity.heading, mean_interval(own[name]), quantity.decimals, after=paper)
            row.numbers[f"{name}_paper"] = printed.get(name, float("nan"))
        bits = bits_of(method, results.recipe.game())
        row.numbers["told_bits"], row.cells["Told (bits)"] = bits, "–" if bits is None else str(bits)
        if limits is not None and method.player != BOUND:
            low, high = share(results, key, limits)
            row.add("share_low_percent", "Share (%)", low, 1)
            row.add("share_high_percent", "Share (%)", high, 1)
            row.cells["Share (%)"] = f"{low.value:.1f}–{high.value:.1f}"
        elif limits is not None:
            row.cells["Share (%)"] = "–"
        row.cells["n"] = sample_of(results, key)
        rows.append(row)
    actions = "greedy" if results.recipe.evaluation.deterministic else "sampled"
    paper = "; in parentheses the paper's value" if in_paper else ""
    shares = f"{explanation(limits)} " if limits is not None else ""
    caption = (
        f"Mean over seeds [95 % bootstrap interval over seeds], {actions} actions, the same test missions for every "
        f"method and seed{paper}. T̄ is the makespan: slots until the last UAV is done. U is the mean utility"
        f"{', which the paper does not print' if in_paper else ''}. Told: bits that each UAV broadcasts in every slot "
        f"so that the others can act as they do. {shares}n: seeds × test episodes."
    )
    return table_of(rows, caption)


def _comparison(results: Results) -> Table | None:
    """Interquartile means, and differences to CTDE-MAPPO with the probability of being better; none without it."""
    base = _base_method(results)
    if base is None:
        return None
    rows = []
    for key in results.methods:
        row = row_of(results, key)
        for name in COMPARED:
            quantity, own, others = QUANTITIES[name], results.scores(key, name), results.scores(base, name)
            difference, better = paired_difference(own, others), probability_of_improvement(own, others)
            if key == base:
                difference = better = UNKNOWN
            row.add(f"{name}_iqm", f"IQM {quantity.heading}", interquartile_mean(own), quantity.fine_decimals)
            row.add(f"{name}_difference", quantity.difference_heading, difference, quantity.fine_decimals)
            row.add(f"{name}_improvement", f"P(better {quantity.symbol})", better, 2)
        row.cells["n"] = sample_of(results, key)
        rows.append(row)
    label = results.methods[base].label
    caption = (
        f"IQM: mean of the middle half of all scores of seeds and missions. Δ: difference to {label} on the same "
        f"missions. P: probability that a seed of the method does better than one of {label} on the same mission, "
        "ties counted half. In brackets 95 % bootstrap intervals over seeds, missions held fixed; with five seeds they "
        "hold the true value in about five of six cases. n: seeds × test episodes."
    )
    return table_of(rows, caption)


def _beside_straight_flight(results: Results) -> tuple[str, ...]:
    """How the reward of the learners compares to that of UAVs which fly straight: a sentence, where both have seeds."""
    straight = next((key for key, method in results.methods.items() if method.player == STRAIGHT), None)
    learners = [key for key, method in results.methods.items() if method.algo is not None]
    learners = [key for key in learners if len(results.seeds(key)) > 1]
    if straight is None or not learners or len(results.seeds(straight)) < 2:
        return ()
    own, *others = (results.scores(key, "reward") for key in (straight, *learners))
    found = {key: crossed_t(theirs, own) for key, theirs in zip(learners, others, strict=True)}
    level = holm([one.p_value for one in found.values()])
    less, more = (
        sum(one.p_value <= level and sign * one.interval.value > 0.0 for one in found.values()) for sign in (-1.0, 1.0)
    )
    best = max(learners, key=lambda key: found[key].interval.value)
    by = f"{results.methods[best].label}, differs by {found[best].interval.text(QUANTITIES['reward'].fine_decimals)}"
    if len(learners) == 1:
        told = "has measurably less" if less else "has measurably more" if more else "cannot be told from them in"
        return (f"Beside UAVs that fly straight, the learner {told} J̄ (t test over seeds and missions); it, {by}.",)
    return (
        f"Beside UAVs that fly straight, {'all' if less == len(learners) else less or 'none'} of the {len(learners)} "
        f"learners {'has' if less == 1 else 'have'} measurably less J̄ and {more or 'none'} more (t tests over "
        f"seeds and missions, Holm's correction over the {len(learners)}); the best, {by}.",
    )


def _base_method(results: Results) -> str | None:
    """Key of CTDE-MAPPO with the paper's critic, or with another one."""
    for policy in BASES:
        for key, method in results.methods.items():
            if method.algo == "mappo" and method.policy == policy:
                return key
    return None
