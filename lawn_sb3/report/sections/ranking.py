"""How the ranking of methods moves from one changed game to the next."""

from collections.abc import Mapping
from itertools import combinations

import pandas as pd
from scipy.stats import rankdata

from lawn_sb3.report.changed_game import game_label
from lawn_sb3.report.section import Section
from lawn_sb3.report.table import Table, sample_text
from lawn_sb3.results.pairing import Marks
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import Interval, welch_difference, welch_p

HEADINGS = {"reward": "Ranking by J̄", "utility_mbps": "Ranking by utility"}


def section(quantity: str, games: Mapping[str, Results]) -> Section:
    """Every method's figure and rank in every changed game, and the pairs that change places.

    :param quantity: a key of ``HEADINGS``
    :param games: results by the key of the game in the recipe, the game as it is first
    :return: a table with one row per game
    """
    chosen = QUANTITIES[quantity]
    numbers, shown, base = [], [], next(iter(games.values()))
    compared = {name: _compared(results, base, quantity) for name, results in games.items()}
    marks = Marks([tested for pairs in compared.values() for tested in pairs.values()])
    apart = {
        name: {pair: found.value for pair, (found, p) in pairs.items() if marks.is_sure(found, p)}
        for name, pairs in compared.items()
    }
    usual = next(iter(apart.values()))
    for name, results in games.items():
        found = {key: results.mean(key, quantity) for key in results.methods}
        ranks = dict(zip(found, rankdata([-own.value for own in found.values()], method="min"), strict=True))
        cells = {"Game": game_label(name, results.recipe.game(), base.recipe.game())}
        for key, own in found.items():
            numbers.append({"game": name, "method": key, **own._asdict(), "rank": int(ranks[key])})
            cells[results.methods[key].label] = f"{own.text(chosen.decimals)} ({ranks[key]:.0f}.)"
        fewest = min(len(results.seeds(key)) for key in results.methods)
        sample = sample_text(fewest, results.recipe.evaluation.episodes)
        labels = {key: method.label for key, method in results.methods.items()}
        moved = [
            " above ".join(labels[key] for key in (pair if lead > 0.0 else pair[::-1]))
            for pair, lead in apart[name].items()
            if lead * usual.get(pair, 0.0) < 0.0
        ]
        places = "–" if results is base else "; ".join(moved) or "none"
        shown.append({**cells, "Changed places": places, "n": sample})
    caption = (
        f"{chosen.heading} by changed game: mean over seeds [95 % bootstrap interval] and rank. Changed places: pairs "
        "that are apart in both games, in opposite order. Apart is a pair whose difference Welch's test over seeds "
        f"finds at 5 % after Holm's correction over all {marks.num_tested} pairs of all games in which seeds vary, as "
        f'{marks.num_sure} are, or that differs where no seed varies; so "none" may mean that too few are apart. '
        "Every method is trained and tested in the changed game; J̄ is in units of that game, so only its order can be "
        "compared from row to row. n: seeds × test episodes, at least."
    )
    table = Table(pd.DataFrame(numbers), pd.DataFrame(shown).fillna("–"), caption)
    return Section(HEADINGS[quantity], {f"ranking_{quantity}": table})


def _compared(results: Results, base: Results, quantity: str) -> dict[tuple[str, str], tuple[Interval, float]]:
    """The differences of all pairs of methods that the game as it is has too, each with its p-value."""
    by_seed = {key: results.scores(key, quantity).mean(axis=1) for key in results.methods if key in base.methods}
    return {
        (one, other): (welch_difference(by_seed[one], by_seed[other]), welch_p(by_seed[one], by_seed[other]))
        for one, other in combinations(by_seed, 2)
    }
