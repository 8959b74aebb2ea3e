"""Which constants the paper's figures allow: every open one replaced by each of its candidates, alone and jointly.

The Random player needs no training, so its row in the paper's Table II tests the game alone. What it cannot tell, the
J of trained players and bounds on the J of any successful method narrow down.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from types import MappingProxyType
from typing import Any

import pandas as pd

from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.game.player import Player, RandomPlayer
from lawn_sb3.paper.identification.allowed import conclusion_findings, conclusions, examples, joint_findings
from lawn_sb3.paper.identification.bounds import draw_legs
from lawn_sb3.paper.identification.candidates import PAPER, REWARD_CONSTANTS, candidates
from lawn_sb3.paper.identification.findings import findings
from lawn_sb3.paper.identification.joint import Reading, joint_search, readings
from lawn_sb3.paper.identification.possible import bounds_table
from lawn_sb3.paper.identification.random_row import link_budget_interval, random_row
from lawn_sb3.paper.identification.reward import OTHER_COLUMNS, TERMS, linear_table, other_rows, reward_terms
from lawn_sb3.paper.printed_values import TABLE_II, TEST_EPISODES

MISSIONS_SEED = 50_000
"""Missions apart from those of tests, training and tuning."""

MIN_EPISODES = 20
"""Fewer may hold no arrival at all."""


@dataclass(frozen=True, eq=False)
class Identification:
    """What was tried, and the tables that it gave."""

    episodes: int
    """Joint episodes of the Random player in each scenario."""
    seed: int
    """Picks their missions."""
    random: pd.DataFrame
    """One row per candidate: the Random row it gives, and its distance to the paper's in standard errors."""
    link_budget_db: tuple[float | None, float | None]
    """From which to which P_tx + beta_0 - sigma^2 the paper's rate agrees."""
    linear: pd.DataFrame
    """One row per term of Random's J."""
    bounds: pd.DataFrame
    """One row per rate unit, ``nav_weight`` and ``ema_beta``: between which values the J of CTDE-MAPPO must lie."""
    others: pd.DataFrame
    """One row per trained player and candidate for a constant of the reward: its J beside the paper's."""
    findings: dict[str, str]
    """What each constant alone may be, all others as in the preset."""
    games: pd.DataFrame
    """One row per reading and grid, with the constants fitted to it (:mod:`lawn_sb3.paper.identification.joint`)."""
    conclusions: pd.DataFrame
    """One row per example of an allowed game: what planners earn in it."""
    joint_findings: dict[str, str]
    """What holds in all games that the paper's figures are consistent with, and what stays open."""

    def as_json(self) -> dict[str, Any]:
        """All results for machines.

        :return: numbers, texts, and each table as a list of rows; what is not a number is None
        """
        tables = {
            name: getattr(self, name) for name in ("random", "linear", "bounds", "others", "games", "conclusions")
        }
        return {
            "scenario": PAPER.name,
            "episodes": self.episodes,
            "seed": self.seed,
            **{
                name: json.loads(table.to_json(orient="records", double_precision=15)) for name, table in tables.items()
            },
            "link_budget_db": list(self.link_budget_db),
            "findings": self.findings,
            "joint_findings": self.joint_findings,
        }


def identify(
    episodes: int = 2_000,
    seed: int = MISSIONS_SEED,
    others: Mapping[str, Player] = MappingProxyType({}),
    progress: Callable[[int, int], None] = lambda done, total: None,
    jointly: Sequence[Reading] | None = None,
) -> Identification:
    """Try every candidate alone, then every reading with the free constants fitted.

    :param episodes: joint episodes of the Random player in each scenario, at least ``MIN_EPISODES``
    :param seed: picks the missions, the same in all scenarios of the same airspace
    :param others: trained players by their row in the paper's Table II; they should be greedy and trained in the
        preset, and fly ``TEST_EPISODES`` episodes
    :param progress: called with the number of flights and readings done and their total
    :param jointly: readings to fit, which may be none; default: all
    :return: the tables and what they say
    :raises UserError: if there are too few episodes for a standard error, or the paper has no such row
    """
    if episodes < MIN_EPISODES:
        raise UserError(f"episodes = {episodes}: at least {MIN_EPISODES} episodes, for a standard error")
    for name in others:
        if name not in TABLE_II:
            raise unknown_name("row of the paper's Table II", name, TABLE_II)
    tried = candidates()
    weighed = [candidate for candidate in tried if candidate.constant in REWARD_CONSTANTS]
    alone = 2 + sum(candidate.scenario != PAPER for candidate in tried) + len(others)
    read = list(readings()) if jointly is None else list(jointly)
    total = alone + len(read)
    done = count(1)
    preset_rows = evaluate(RandomPlayer(), PAPER, episodes, seed)
    progress(next(done), total)
    rows = []
    for candidate in tried:
        own = preset_rows
        if candidate.scenario != PAPER:
            own = evaluate(RandomPlayer(), candidate.scenario, episodes, seed)
            progress(next(done), total)
        rows.append(random_row(candidate, own, preset_rows))
    terms = reward_terms(RandomPlayer(), PAPER, episodes, seed)
    progress(next(done), total)
    trained: list[dict[str, object]] = []
    for name, player in others.items():
        trained += other_rows(name, player, weighed, TEST_EPISODES, seed)
        progress(next(done), total)
    random, linear = pd.DataFrame(rows), linear_table(terms, PAPER)
    means = {name: float(terms[name].mean()) for name in TERMS}
    tables = {
        "random": random,
        "linear": linear,
        "bounds": bounds_table(draw_legs(PAPER, episodes, seed), means),
        "others": pd.DataFrame(trained, columns=list(OTHER_COLUMNS)),
    }
    interval = link_budget_interval(random)
    games = joint_search(episodes, seed, lambda done, _: progress(alone + done, total), read)
    drawn = conclusions(examples(games), min(episodes, TEST_EPISODES), seed) if read else pd.DataFrame()
    return Identification(
        episodes,
        seed,
        link_budget_db=interval,
        findings=findings(**tables, link_budget_db=interval),
        games=games,
        conclusions=drawn,
        joint_findings=(joint_findings(games) | conclusion_findings(drawn)) if read else {},
        **tables,
    )
