"""How the ranking of methods moves from one changed game to the next."""

from collections.abc import Mapping
from itertools import combinations

import pandas as pd
from scipy.stats import rankdata

from lawn_sb3.report.changed_game import game_label
from lawn_sb3.report.section import Section
from lawn_sb3.report.table import Table, sample_text
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import paired_difference

HEADINGS = {"reward": "Ranking by J̄", "utility_mbps": "Ranking by utility"}


def section(quantity: str, games: Mapping[str, Results]) -> Section:
    """Every method's figure and rank in every changed game, and the pairs that change places.

    :param quantity: a key of ``HEADINGS``
    :param games: results by the key of the game in the recipe, the game as it is first
    :return: a table with one row per game
    """
    chosen = QUANTITIES[quantity]
    numbers, shown, base = [], [], next(iter(games.values()))
    for name, results in games.items():
        found = {key: results.mean(key, quantity) for key in results.methods}
        ranks = dict(zip(found, rankdata([-own.value for own in found.values()], method="min"), strict=True))
        cells = {"Game": game_label(name, results.recipe.game(), base.recipe.game())}
        for key, own in found.items():
            numbers.append({"game": name, "method": key, **own._asdict(), "rank": int(ranks[key])})
            cells[results.methods[key].label] = f"{own.text(chosen.decimals)} ({ranks[key]:.0f}.)"
        fewest = min(len(results.seeds(key)) for key in results.methods)
        sample = sample_text(fewest, results.recipe.evaluation.episodes)
        moved = _changed_places(base, results, quantity) if results is not base else "–"
        shown.append({**cells, "Changed places": moved, "n": sample})
    caption = (
        f"{chosen.heading} by changed game: mean over seeds [95 % bootstrap interval] and rank. Changed places: pairs "
        "that are apart in both games, by intervals of the paired difference that leave 0 out, in opposite order. "
        "Every method is trained and tested in the changed game; J̄ is in units of that game, so only its order can be "
        "compared from row to row. n: seeds × test episodes, at least."
    )
    table = Table(pd.DataFrame(numbers), pd.DataFrame(shown).fillna("–"), caption)
    return Section(HEADINGS[quantity], {f"ranking_{quantity}": table})


def _changed_places(base: Results, results: Results, quantity: str) -> str:
    """Pairs of methods whose order is another than in the game as it is, beyond what seeds explain."""
    common = [key for key in results.methods if key in base.methods]
    moved = []
    for one, other in combinations(common, 2):
        before, after = (_order(game, one, other, quantity) for game in (base, results))
        if before * after < 0:
            first, second = (one, other) if after > 0 else (other, one)
            moved.append(f"{results.methods[first].label} above {results.methods[second].label}")
    return "; ".join(moved) or "none"


def _order(results: Results, one: str, other: str, quantity: str) -> int:
    """1 if the first is apart above the second, -1 if below, 0 if they cannot be told apart."""
    found = paired_difference(results.scores(one, quantity), results.scores(other, quantity))
    return int(found.low > 0.0) - int(found.high < 0.0)
