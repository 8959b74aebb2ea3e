"""What greedy play is worth: the test missions flown greedily, and once more with sampled actions."""

from lawn_sb3.report.section import Section
from lawn_sb3.report.table import interval_columns, row_of, sample_text, table_of
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.results import Results, score_matrix
from lawn_sb3.results.statistics import mean_interval

DECIMALS = {"success_percent": 1, "reward": 3, "makespan_slots": 1}
"""The quantities compared; both plays have nearly the same reward."""
CAPTION = (
    "Greedy actions / sampled ones (IQL and QMIX: epsilon-greedy with the last epsilon of their training) on the same "
    "test missions, means over seeds. Δ: greedy minus sampled, seed by seed, with a 95 % bootstrap interval over "
    "seeds. T̄ is the makespan. n: seeds × test episodes."
)


def section(results: Results) -> Section:
    """Greedy against sampled play of each method that has both, seed by seed on the same missions."""
    rows, episodes = [], results.recipe.evaluation.episodes
    for key in results.methods_in(results.sampled):
        flown = results.sampled[results.sampled["method"] == key]
        both = results.episodes[results.episodes["seed"].isin(flown["seed"])], flown
        row, seeds = row_of(results, key), flown["seed"].nunique()
        for name, decimals in DECIMALS.items():
            heading = QUANTITIES[name].heading
            greedy, sampled = (score_matrix(rows_of, key, name).mean(axis=1) for rows_of in both)  # [S] each
            plays = {f"{name}_greedy": mean_interval(greedy), f"{name}_sampled": mean_interval(sampled)}
            row.numbers |= interval_columns(plays)
            row.cells[heading] = f"{greedy.mean():.{decimals}f} / {sampled.mean():.{decimals}f}"
            row.add(f"{name}_difference", f"Δ {heading}", mean_interval(greedy - sampled), decimals)
        row.numbers |= {"seeds": seeds, "episodes": episodes}
        row.cells["n"] = sample_text(seeds, episodes)
        rows.append(row)
    return Section("Greedy against sampled play", {"sampling": table_of(rows, CAPTION)})
