"""What the tables of an identification say of each constant, in one computed sentence each."""

import numpy as np
import pandas as pd

from lawn_sb3.paper.identification.candidates import LINK_BUDGET
from lawn_sb3.paper.identification.random_row import CEILING, FIGURES, LEAST, TESTED
from lawn_sb3.paper.printed_values import TABLE_II
from lawn_sb3.paper.standard_error import DISFAVOURED_Z
from lawn_sb3.results.quantities import QUANTITIES

MOVED_Z = 1.0
"""A constant moves a figure if its candidates differ in it by more standard errors."""

SYMBOLS = {
    **{name: QUANTITIES[name].symbol for name in FIGURES},
    LEAST: "mean T_min above the T̄ of CTDE-MAPPO",
}


def findings(
    random: pd.DataFrame,
    linear: pd.DataFrame,
    bounds: pd.DataFrame,
    others: pd.DataFrame,
    link_budget_db: tuple[float | None, float | None],
) -> dict[str, str]:
    """Say what is identified.

    :param random: the table of candidates
    :param linear: the terms of Random's J
    :param bounds: which weights can give the J of CTDE-MAPPO
    :param others: what trained players earn; may be empty
    :param link_budget_db: budgets that agree with the rate of Random
    :return: a sentence or two by constant, then for ``reward`` and ``bounds`` what holds of several together
    """
    groups = {str(name): group for name, group in random.groupby("constant", sort=False)}
    moved = {name: _moved(group) for name, group in groups.items()}
    found = {}
    for name, group in groups.items():
        rivals = [other for other in groups if other != name and moved[other] == moved[name]]
        sentences = [_tried(group), _identified_with(moved[name], rivals)]
        if name == LINK_BUDGET:
            sentences.append(_budget(link_budget_db))
        if name == "ema_beta":
            sentences.append(_collisions(bounds))
        if len(others) and name in set(others["constant"]):
            sentences.append(_nearest(others[others["constant"] == name]))
        found[name] = " ".join(sentences)
    return {**found, "reward": _plane(linear), "bounds": _possible(bounds)}


def _tried(group: pd.DataFrame) -> str:
    """Which candidates agree, and what speaks against the others."""
    labels = group["candidate"] + np.where(group["is_preset"], " (preset)", "")
    agreeing = labels[group["verdict"] == "agrees"].tolist()
    only = "only " if len(agreeing) == 1 else ""
    parts = [f"with all others as in the preset, {only}{', '.join(agreeing) or 'no candidate'} agree"]
    parts[0] += "s" if len(agreeing) <= 1 else ": not told apart"
    for word in ("disfavoured", "ruled out"):
        against = [f"{labels[index]} by {_reason(group.loc[index])}" for index in group.index[group["verdict"] == word]]
        if against:
            parts.append(f"{word}: {', '.join(against)}")
    return "; ".join(parts) + "."


def _reason(row: pd.Series) -> str:
    """The figure that lies farthest from the paper's, or the printed rate that cannot be had."""
    worst = max(TESTED, key=lambda name: abs(float(row[f"z_{name}"])))
    if CEILING in row["against"] and abs(row[f"z_{worst}"]) <= DISFAVOURED_Z:
        printed = TABLE_II["CTDE-MAPPO"].rate_mbps
        return f"R̂ of CTDE-MAPPO ({printed:g} Mbps, here at most {row[CEILING]:.1f} in its T̄)"
    return f"{SYMBOLS[worst]} (z = {row[f'z_{worst}']:+.1f})"


def _moved(group: pd.DataFrame) -> tuple[str, ...]:
    """Figures of the Random row that tell the candidates apart."""
    return tuple(name for name in FIGURES if np.ptp(group[f"z_{name}"].to_numpy()) > MOVED_Z)


def _identified_with(moved: tuple[str, ...], rivals: list[str]) -> str:
    if not moved:
        return "It moves no figure of Random."
    if len(moved) > 1:
        return f"It moves {', '.join(SYMBOLS[name] for name in moved)} of Random."
    joint = f", as {', '.join(rivals)} do: one figure identifies them only together" if rivals else ""
    return f"It moves {SYMBOLS[moved[0]]} of Random alone{joint}."


def _budget(interval: tuple[float | None, float | None]) -> str:
    low, high = ("beyond the candidates" if end is None else f"{end:.1f} dB" for end in interval)
    return (
        f"Only the sum P_tx + beta_0 - sigma^2 counts: the paper's R̂ is within {DISFAVOURED_Z:g} standard errors "
        f"from {low} to {high}."
    )


def _collisions(bounds: pd.DataFrame) -> str:
    """How the bounds on J tell values of beta apart."""
    preset = bounds[bounds["is_preset"]].iloc[0]
    own = bounds[(bounds["rate_unit"] == preset["rate_unit"]) & (bounds["nav_weight"] == preset["nav_weight"])]
    needed = ", ".join(
        f"{row['collisions_needed']:.2f} with {row['ema_beta']:g} ({row['verdict']})" for _, row in own.iterrows()
    )
    return f"The J̄ of CTDE-MAPPO takes at least so many collisions a UAV: {needed}."


def _nearest(others: pd.DataFrame) -> str:
    """Which candidate brings the flights of trained players nearest to the paper's figures."""
    parts = []
    for name in ("reward", "rate_mbps"):
        misses = others[f"{name}_difference"].abs().groupby(others["candidate"], sort=False).mean()
        if np.ptp(misses.to_numpy()) > 0:
            parts.append(f"{SYMBOLS[name]} with {misses.idxmin()} (off by {misses.min():.2f})")
    methods = ", ".join(others["method"].unique())
    if not parts:
        return f"Flights of {methods} are worth the same with all."
    return f"Flights of {methods} come nearest to the paper's {' and '.join(parts)}."


def _plane(linear: pd.DataFrame) -> str:
    """The plane of constants that gives Random's J."""
    names = [*linear["constant"][:-1], "1 / rate unit"]
    weighed = " ".join(f"{factor:+.2f} {name}" for factor, name in zip(linear["coefficient"], names, strict=True))
    needed = [
        f"{name} {value:.2f} ({low:.2f} to {high:.2f})"
        for name, value, low, high in zip(
            names[:-1], linear["needed"], linear["needed_low"], linear["needed_high"], strict=False
        )
    ]
    value, low, high = (1.0 / linear[name].iloc[-1] for name in ("needed", "needed_high", "needed_low"))
    above = f"to {high:.0f}" if high > 0 else "up"
    return (
        f"J̄ of Random is {weighed}; the paper's {TABLE_II['Random'].reward:g} fixes this sum alone, so its constants "
        f"are identified only together. With the others as in the preset each would be: {', '.join(needed)}, rate unit "
        f"{value:.0f} Mbps ({low:.0f} {above})."
    )


def _possible(bounds: pd.DataFrame) -> str:
    """Which weights of progress each rate unit leaves, and what Random's J then asks of the penalty."""
    preset = float(bounds.loc[bounds["is_preset"], "ema_beta"].iloc[0])
    bounds = bounds[bounds["ema_beta"] == preset]
    parts = []
    for name, group in bounds.groupby("rate_unit", sort=False):
        row = group.iloc[0]
        if np.isnan(row["nav_weight_to"]):
            parts.append(f"{name}: none")
            continue
        clean = row["nav_weight_to_without_collisions"]
        limit = "never" if np.isnan(clean) else f"up to {clean:.2f}"
        parts.append(f"{name}: {row['nav_weight_from']:.2f} to {row['nav_weight_to']:.2f} ({limit} without collisions)")
    pairs = [
        f"{row['rate_unit_mbps']:.1f} Mbps with {row['nav_weight']:g} and {row['fail_penalty_of_random']:.1f}"
        for _, row in bounds[bounds["verdict"] == "agrees"].iterrows()
    ]
    return (
        f"A method with 100 % success, the R̂ of the paper's CTDE-MAPPO and no more collisions than Random has J̄ = "
        f"{TABLE_II['CTDE-MAPPO'].reward:g} only with these nav_weights, by rate unit: {'; '.join(parts)}. Of the rate "
        "units and nav_weights tried these agree, with the fail_penalty that then gives Random's J̄ too: "
        f"{', '.join(pairs) or 'none'}."
    )
