"""An identification as a Markdown page."""

import math

import pandas as pd

from lawn_sb3.paper.identification.candidates import PAPER
from lawn_sb3.paper.identification.findings import SYMBOLS
from lawn_sb3.paper.identification.identify import Identification
from lawn_sb3.paper.identification.random_row import FIGURES, LEAST
from lawn_sb3.paper.printed_values import TABLE_II, TEST_EPISODES
from lawn_sb3.paper.standard_error import DISFAVOURED_Z, RULED_OUT_Z


def as_markdown(result: Identification) -> str:
    """An identification as a Markdown page."""
    printed = TABLE_II["Random"]
    row = ", ".join(f"{SYMBOLS[name]} {getattr(printed, name):g}" for name in FIGURES)
    parts = [
        "# What the paper's figures identify",
        f"Every open constant replaced by each candidate, the others as in scenario `{PAPER.name}`; "
        f"{result.episodes:,} joint episodes of the Random player each, missions seed {result.seed}.",
        "\n".join(f"- **{name}**: {text}" for name, text in result.findings.items()),
        "## The Random row",
        f"The paper: {row}. In parentheses z, the distance to it in standard errors: those of a mean of "
        f"{TEST_EPISODES} episodes, with our own and the rounding of the printed figure. Above {RULED_OUT_Z:g} a "
        f"candidate is ruled out, above {DISFAVOURED_Z:g} disfavoured. Success and T̄ may not vary at all: the spread "
        "in the preset is the least that is assumed.",
        _table(_random_text(result.random), 2),
        "## The terms of Random's J̄",
        _table(result.linear, 4),
        "## Which J̄ a method with 100 % success can have",
        "By rate unit, nav_weight and ema_beta, with R̂ and T̄ of the paper's CTDE-MAPPO and no collision; its J̄ is "
        f"{TABLE_II['CTDE-MAPPO'].reward:g}.",
        _table(result.bounds.drop(columns="is_preset"), 2),
    ]
    if len(result.others):
        parts += [
            "## The J̄ of trained players",
            "Their flights in the preset, paid with other constants: evidence, no proof, for they were trained on the "
            "preset's.",
            _table(result.others.drop(columns=["is_preset", "reward_paper", "rate_mbps_paper"]), 2),
        ]
    return "\n\n".join(parts) + "\n"


def _random_text(random: pd.DataFrame) -> pd.DataFrame:
    labels = random["candidate"].where(~random["is_preset"], random["candidate"] + " (preset)")
    shown = pd.DataFrame({"constant": random["constant"].where(~random["constant"].duplicated(), ""), "value": labels})
    for name in FIGURES:
        pairs = zip(random[name], random[f"z_{name}"], strict=True)
        shown[SYMBOLS[name]] = [f"{mean:.2f} ({z:+.1f})" for mean, z in pairs]
    shown["mean T_min"] = random[LEAST].map("{:.1f}".format)
    return shown.assign(verdict=random["verdict"])


def _table(frame: pd.DataFrame, decimals: int) -> str:
    text = frame.map(lambda cell: _cell(cell, decimals)).rename(columns=lambda name: name.replace("_", " "))
    return str(text.to_markdown(index=False, disable_numparse=True))


def _cell(cell: object, decimals: int) -> str:
    if not isinstance(cell, float):
        return str(cell)
    return "-" if math.isnan(cell) else f"{cell:.{decimals}f}"
