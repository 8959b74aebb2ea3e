"""Which constants the paper's figures allow: every open one replaced by each of its candidates, alone and jointly.

The Random player needs no training, so its row in the paper's Table II tests the game alone. What it cannot tell, the
J of trained players and bounds on the J of any successful method narrow down.
"""

from collections.abc import Callable, Mapping, Sequence
from itertools import count
from types import MappingProxyType

import pandas as pd

from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.game.player import Player, RandomPlayer
from lawn_sb3.paper.identification.allowed import conclusions, examples
from lawn_sb3.paper.identification.bounds import draw_legs
from lawn_sb3.paper.identification.candidates import PAPER, REWARD_CONSTANTS, Candidate, candidates
from lawn_sb3.paper.identification.joint import Reading, joint_search, readings
from lawn_sb3.paper.identification.possible import bounds_table
from lawn_sb3.paper.identification.random_row import random_row
from lawn_sb3.paper.identification.result import DECIMALS, Identification
from lawn_sb3.paper.identification.reward import OTHER_COLUMNS, TERMS, linear_table, other_rows, reward_terms
from lawn_sb3.paper.printed_values import TABLE_II, TEST_EPISODES

MISSIONS_SEED = 50_000
"""Missions apart from those of tests, training and tuning."""

MIN_EPISODES = 20
"""Fewer may hold no arrival at all."""


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
    :return: the tables, their figures with ``DECIMALS`` decimals
    :raises UserError: if there are too few episodes for a standard error, or the paper has no such row
    """
    if episodes < MIN_EPISODES:
        raise UserError(f"episodes = {episodes}: at least {MIN_EPISODES} episodes, for a standard error")
    for name in others:
        if name not in TABLE_II:
            raise unknown_name("row of the paper's Table II", name, TABLE_II)
    tried, read = candidates(), list(readings()) if jointly is None else jointly
    total = 2 + sum(candidate.scenario != PAPER for candidate in tried) + len(others) + len(read)
    done = count(1)

    def advance() -> None:
        progress(next(done), total)

    alone = _one_at_a_time(tried, others, episodes, seed, advance)
    games = joint_search(episodes, seed, advance, read).round(DECIMALS)
    drawn = conclusions(examples(games), min(episodes, TEST_EPISODES), seed) if read else pd.DataFrame()
    tables = {**alone, "games": games, "conclusions": drawn}
    return Identification(episodes, seed, **{name: table.round(DECIMALS) for name, table in tables.items()})


def _one_at_a_time(
    tried: Sequence[Candidate], others: Mapping[str, Player], episodes: int, seed: int, advance: Callable[[], None]
) -> dict[str, pd.DataFrame]:
    """The tables of candidates that replace one constant of the preset each."""
    random = pd.DataFrame(_random_rows(tried, episodes, seed, advance))
    terms = reward_terms(RandomPlayer(), PAPER, episodes, seed)
    advance()
    trained: list[dict[str, object]] = []
    for name, player in others.items():
        weighed = [candidate for candidate in tried if candidate.constant in REWARD_CONSTANTS]
        trained += other_rows(name, player, weighed, TEST_EPISODES, seed)
        advance()
    means = {name: float(terms[name].mean()) for name in TERMS}
    return {
        "random": random,
        "linear": linear_table(terms, PAPER),
        "bounds": bounds_table(draw_legs(PAPER, episodes, seed), means),
        "others": pd.DataFrame(trained, columns=list(OTHER_COLUMNS)),
    }


def _random_rows(
    tried: Sequence[Candidate], episodes: int, seed: int, advance: Callable[[], None]
) -> list[dict[str, object]]:
    """The Random row of each candidate; those with the preset's scenario share its flights."""
    preset_rows = evaluate(RandomPlayer(), PAPER, episodes, seed)
    advance()
    rows = []
    for candidate in tried:
        own = preset_rows
        if candidate.scenario != PAPER:
            own = evaluate(RandomPlayer(), candidate.scenario, episodes, seed)
            advance()
        rows.append(random_row(candidate, own, preset_rows))
    return rows
