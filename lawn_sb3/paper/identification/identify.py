"""Which constants the paper's figures identify: every open one replaced by each of its candidates, one at a time.

The Random player needs no training, so its row in the paper's Table II tests the game alone. What it cannot tell, the
J of trained players and bounds on the J of any successful method narrow down.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import pandas as pd

from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.game.player import Player, RandomPlayer
from lawn_sb3.paper.identification.bounds import bounds_table, draw_legs
from lawn_sb3.paper.identification.candidates import PAPER, REWARD_CONSTANTS, candidates
from lawn_sb3.paper.identification.findings import SYMBOLS, findings
from lawn_sb3.paper.identification.random_row import FIGURES, LEAST, link_budget_interval, random_row
from lawn_sb3.paper.identification.reward import OTHER_COLUMNS, TERMS, linear_table, other_rows, reward_terms
from lawn_sb3.paper.printed_values import TABLE_II, TEST_EPISODES
from lawn_sb3.paper.standard_error import DISFAVOURED_Z, RULED_OUT_Z

MISSIONS_SEED = 50_000
"""Missions apart from those of tests, training and tuning."""

MIN_EPISODES = 20
"""Fewer may hold no arrival at all."""


@dataclass(frozen=True, eq=False)
class Identification:
    """What was tried, and what came of it."""

    episodes: int
    """Joint episodes of the Random player in each scenario."""
    seed: int
    """Picks their missions."""
    random: pd.DataFrame
    """One row a candidate: the Random row it gives, and its distance to the paper's in standard errors."""
    link_budget_db: tuple[float | None, float | None]
    """From which to which P_tx + beta_0 - sigma^2 the paper's rate agrees."""
    linear: pd.DataFrame
    """One row a term of Random's J."""
    bounds: pd.DataFrame
    """One row a rate unit, ``nav_weight`` and ``ema_beta``: between which values the J of CTDE-MAPPO must lie."""
    others: pd.DataFrame
    """One row a trained player and candidate for a constant of the reward: its J beside the paper's."""
    findings: dict[str, str]
    """What is identified, by constant."""

    def as_json(self) -> dict[str, Any]:
        """All results for machines.

        :return: numbers, texts, and each table as a list of rows; what is not a number is None
        """
        tables = {name: getattr(self, name) for name in ("random", "linear", "bounds", "others")}
        return {
            "scenario": PAPER.name,
            "episodes": self.episodes,
            "seed": self.seed,
            **{
                name: json.loads(table.to_json(orient="records", double_precision=15)) for name, table in tables.items()
            },
            "link_budget_db": list(self.link_budget_db),
            "findings": self.findings,
        }


def _silent(done: int, total: int) -> None:
    """Report nothing."""


def identify(
    episodes: int = 2_000,
    seed: int = MISSIONS_SEED,
    others: Mapping[str, Player] = MappingProxyType({}),
    progress: Callable[[int, int], None] = _silent,
) -> Identification:
    """Try every candidate.

    :param episodes: joint episodes of the Random player in each scenario, at least ``MIN_EPISODES``
    :param seed: picks the missions, the same in all scenarios of the same airspace
    :param others: trained players by their row in the paper's Table II; they should be greedy and trained in the
        preset, and fly ``TEST_EPISODES`` episodes
    :param progress: called with the number of flights done and their total
    :return: the tables and what they say
    :raises UserError: if there are too few episodes for a standard error, or the paper has no such row
    """
    if episodes < MIN_EPISODES:
        raise UserError(f"episodes = {episodes}: at least {MIN_EPISODES} episodes, for a standard error")
    for name in others:
        if name not in TABLE_II:
            raise unknown_name("row of the paper's Table II", name, TABLE_II)
    tried = candidates()
    total = 2 + sum(candidate.scenario != PAPER for candidate in tried) + len(others)
    done = 0

    def tick() -> None:
        nonlocal done
        done += 1
        progress(done, total)

    preset_rows = evaluate(RandomPlayer(), PAPER, episodes, seed)
    tick()
    rows = []
    for candidate in tried:
        own = preset_rows
        if candidate.scenario != PAPER:
            own = evaluate(RandomPlayer(), candidate.scenario, episodes, seed)
            tick()
        rows.append(random_row(candidate, own, preset_rows))
    terms = reward_terms(RandomPlayer(), PAPER, episodes, seed)
    tick()
    trained: list[dict[str, object]] = []
    for name, player in others.items():
        weighed = [candidate for candidate in tried if candidate.constant in REWARD_CONSTANTS]
        trained += other_rows(name, player, weighed, TEST_EPISODES, seed)
        tick()
    random, linear = pd.DataFrame(rows), linear_table(terms, PAPER)
    means = {name: float(terms[name].mean()) for name in TERMS}
    bounds = bounds_table(draw_legs(PAPER, episodes, seed), means)
    beside = pd.DataFrame(trained, columns=list(OTHER_COLUMNS))
    interval = link_budget_interval(random)
    said = findings(random, beside, bounds, linear, interval)
    return Identification(episodes, seed, random, interval, linear, bounds, beside, said)


def as_markdown(result: Identification) -> str:
    """Write an identification for reading.

    :param result: the identification
    :return: a Markdown page
    """
    printed = TABLE_II["Random"]
    row = ", ".join(f"{SYMBOLS[name]} {getattr(printed, name):g}" for name in FIGURES)
    parts = [
        "# What the paper's figures identify",
        f"Every open constant replaced by each candidate, the others as in scenario `{PAPER.name}`; "
        f"{result.episodes:,} joint episodes of the Random player each, missions seed {result.seed}.",
        "\n".join(f"- **{name}**: {sentence}" for name, sentence in result.findings.items()),
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
