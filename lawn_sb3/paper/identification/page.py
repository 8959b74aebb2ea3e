"""An identification as a Markdown page."""

import math
from collections.abc import Mapping

import pandas as pd

from lawn_sb3.paper.identification.allowed import FITTED, READ, examples, success_by_reading
from lawn_sb3.paper.identification.candidates import PAPER
from lawn_sb3.paper.identification.findings import SYMBOLS
from lawn_sb3.paper.identification.joint import FAR_DB, FAR_FACTOR, FAR_OFF_Z, FEW
from lawn_sb3.paper.identification.random_row import FIGURES, LEAST
from lawn_sb3.paper.identification.result import Identification
from lawn_sb3.paper.printed_values import TABLE_II, TEST_EPISODES
from lawn_sb3.paper.standard_error import DISFAVOURED_Z, RULED_OUT_Z
from lawn_sb3.results.markdown import markdown_table


def as_markdown(result: Identification) -> str:
    """An identification as a Markdown page."""
    printed = TABLE_II["Random"]
    row = ", ".join(f"{SYMBOLS[name]} {getattr(printed, name):g}" for name in FIGURES)
    parts = [
        "# What the paper's figures allow",
        "The paper leaves most constants of its game open, and its text can be read in more than one way. Which games "
        "are its figures consistent with? Of each method its Table II prints the accumulated reward J̄, the corrected "
        "rate R̂, the time T̄ until the last UAV is done, and success. Each candidate game is flown by the Random "
        f"player, which needs no training: {result.episodes:,} joint episodes, missions seed {result.seed}.",
        *(_jointly(result) if len(result.games) else []),
        "## One at a time",
        f"Every open constant replaced by each candidate, **the others as in scenario `{PAPER.name}`**: what is ruled "
        "out here may be rescued by a change of the others, as above.",
        _list(result.findings),
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


def _jointly(result: Identification) -> list[str]:
    """The part about all readings with the free constants fitted."""
    few = min(FEW, result.episodes)
    return [
        "## Jointly",
        f"Every reading on a range of grids, with the free constants fitted to {few:,} episodes: the link budget to R̂ "
        "of Random, then nav_weight, fail_penalty and if need be collision_penalty, as near to the preset's as they "
        "can be, to J̄ of Random and to what J̄ of CTDE-MAPPO is possible. So R̂ and J̄ of Random test nothing here. "
        "What does: success and T̄ of Random and the least possible T̄, none of which may lie more than "
        f"{DISFAVOURED_Z:g} standard errors off; CTDE-MAPPO must be able to have its R̂ in its T̄; and the constants "
        f"must be such as could be meant: a link budget within {FAR_DB:g} dB of the preset's, weights from 0 to "
        f"{FAR_FACTOR:g} times the preset's. Games that pass are called consistent. None of them *is* the paper's "
        "game: that cannot be told.",
        "The readings: a move out of the airspace ends at its border (clip), is refused (hover), or Random draws moves "
        "that stay inside alone (feasible); a UAV that is done frees its RBs and its voxel (leaves) or keeps them "
        "(stays); the destination counts at the end of a slot (slot-end) or on the way too (fly-through); GBSs stand "
        "in the centres of their tiles (tile-centres) or in the corners of the airspace (corners); the bias correction "
        "of R̂ runs to T_i (completion) or to T_max (deadline). In parentheses are numbers of games.",
        _list({READ.get(name, name): text for name, text in result.joint_findings.items()}),
        f"Success (%) of Random, the paper's being {TABLE_II['Random'].success_percent:g}; bold: consistent, with at "
        "least one reading of the rest. It does not depend on the rates, nor on whether UAVs that are done leave. Mean "
        f"of {result.episodes:,} episodes; of {few:,} where these put success, T̄ or the least T̄ more than "
        f"{FAR_OFF_Z:g} standard errors off, so that nothing was fitted.",
        _table(success_by_reading(result.games), 1),
        "Examples: the preset, for each other reading the consistent game that departs least from the preset, and the "
        "smallest and the largest airspace, with what was fitted; beside the success z, its distance to the paper's in "
        "standard errors.",
        _table(_example_text(result.games), 2),
        "What planners earn in these games: which conclusions need the preset, and which do not.",
        _table(_conclusion_text(result.conclusions), 2),
    ]


def _list(findings: Mapping[str, str]) -> str:
    return "\n".join(f"- **{name}**: {text}" for name, text in findings.items())


def _example_text(games: pd.DataFrame) -> pd.DataFrame:
    chosen = examples(games)
    grid = [" x ".join(map(str, one)) for one in chosen["grid"]]
    z = zip(chosen["success_percent"], chosen["z_success_percent"], strict=True)
    return chosen.assign(grid=grid, success=[f"{value:.1f} ({off:+.1f})" for value, off in z])[
        [*READ, *FITTED, "success"]
    ].rename(columns=READ)


def _conclusion_text(conclusions: pd.DataFrame) -> pd.DataFrame:
    grid = [" x ".join(map(str, one)) for one in conclusions["grid"]]
    names = {
        "straight_reward": "J̄, straight flight",
        "straight_success_percent": "success (%)",
        "straight_utility_mbps": "U (Mbps), straight flight",
        "forecast_utility_mbps": "U, forecast",
        "welfare_utility_mbps": "U, welfare ascent",
    }
    return conclusions.assign(grid=grid).rename(columns=READ | names)


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
    return markdown_table(text)


def _cell(cell: object, decimals: int) -> str:
    if not isinstance(cell, float):
        return str(cell)
    return "-" if math.isnan(cell) else f"{cell:.{decimals}f}"
