"""The report of a recipe: tables, figures and the page that holds them, all pure functions of what the runs left."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.paper import TABLE_II, PaperRow
from lawn_sb3.experiment.provenance import write_text
from lawn_sb3.experiment.recipe import Cell, Recipe
from lawn_sb3.report.figures import WINDOW, convergence, utility_cdf
from lawn_sb3.report.results import Results, read_results
from lawn_sb3.report.style import save
from lawn_sb3.report.table_two import COLUMNS, as_latex, as_markdown, table_two

SHOWN = {name: (COLUMNS[name][0], COLUMNS[name][2]) for name in PaperRow._fields}
"""The figures of the paper's Table II: heading and decimals."""

THRESHOLD = 95.0
"""Success in percent whose crossing the paper reports."""


def write_report(recipe: Recipe, cells: list[Cell], folder: Path, source: Path) -> Results:
    """Write tables, figures and page.

    :param recipe: the recipe
    :param cells: its cells
    :param folder: where to
    :param source: the recipe's file, for the command that the page shows
    :return: what the report was made of, problems included
    :raises UserError: if no run can be used
    """
    results = read_results(recipe, cells)
    if not results.methods:
        raise UserError(f"no finished run to report on: {results.problems[0]}; run: lawn-sb3 reproduce first")
    folder.mkdir(parents=True, exist_ok=True)
    table = table_two(results)
    write_text(folder / "table2.md", as_markdown(table) + "\n")
    write_text(folder / "table2.csv", table.to_csv(index=False, float_format="%.6g", lineterminator="\n"))
    write_text(folder / "table2.tex", as_latex(table, table_caption(results)))
    save(convergence(results), folder, "fig2_convergence")
    save(utility_cdf(results), folder, "fig3_utility_cdf")
    write_text(folder / "README.md", page(results, table, source))
    return results


def table_caption(results: Results) -> str:
    """What Table II shows.

    :param results: what the runs left
    :return: one paragraph
    """
    chosen = results.recipe.evaluation
    actions = "greedy" if chosen.deterministic else "sampled"
    return (
        f"Mean over seeds (with the standard deviation over seeds) of {chosen.episodes} test episodes each, "
        f"{actions} actions, the same missions for every method and seed; the paper's value in parentheses."
    )


def first_crossing(results: Results) -> pd.DataFrame:
    """When each training first reached 95 % success.

    :param results: what the runs left
    :return: one row for each method that learns: env steps at the slowest seed, for training missions and greedy play
    """
    rows = []
    for key, method in results.methods.items():
        if method.algo is None or not len(results.curves):
            continue
        own = results.curves[results.curves["method"] == key]
        row: dict[str, object] = {"Method": method.label}
        for source, heading in (("missions", "training missions"), ("greedy", "greedy evaluation")):
            column = f"{source}/success_percent"
            if column not in own or own[column].isna().all():
                row[heading] = "not measured"
                continue
            first = [
                seed_rows.loc[seed_rows[column] >= THRESHOLD, "time/env_steps"].min()
                for _, seed_rows in own.groupby("seed")
            ]
            reached = [value for value in first if pd.notna(value)]
            measured = own.dropna(subset=[column]).groupby("seed")["time/env_steps"].min().max()
            slowest = f"{len(reached)} of {len(first)} seeds"
            if len(reached) == len(first):
                slowest = f"{'at most ' if max(reached) <= measured else ''}{max(reached):,.0f}"
            row[heading] = slowest
        rows.append(row)
    return pd.DataFrame(rows)


def nearest_to_paper(results: Results) -> pd.DataFrame:
    """Where on its learning curve a method comes nearest to the success of its row in the paper.

    :param results: what the runs left
    :return: one row for each method that learns and has a row in the paper: env steps, and the figures there
    """
    rows = []
    for key, method in results.methods.items():
        if method.algo is None or method.paper_row is None or "greedy/success_percent" not in results.curves:
            continue
        own = results.curves[results.curves["method"] == key].dropna(subset=["greedy/success_percent"])
        curve = own.groupby("time/env_steps")[[f"greedy/{name}" for name in SHOWN]].mean()
        printed = TABLE_II[method.paper_row]
        distance = (curve["greedy/success_percent"] - printed.success_percent).abs()
        at = int(distance.to_numpy().argmin())
        nearest = curve.iloc[at]
        cells = {
            heading: f"{nearest[f'greedy/{name}']:.{decimals}f} ({getattr(printed, name):.{decimals}f})"
            for name, (heading, decimals) in SHOWN.items()
        }
        rows.append({"Method": method.label, "env steps": f"{curve.index[at]:,.0f}", **cells})
    return pd.DataFrame(rows)


def baseline_verdicts(results: Results) -> list[str]:
    """How each learning baseline stands to the best CTDE-MAPPO of the recipe, by the reward J.

    :param results: what the runs left
    :return: one sentence a baseline: the mean difference over the seeds both have, and its standard deviation
    """
    rewards = results.by_seed().pivot(index="seed", columns="method", values="reward")
    rows = {key: method.paper_row for key, method in results.methods.items() if method.algo is not None}
    own = [key for key, row in rows.items() if row == "CTDE-MAPPO"]
    if not own:
        return []
    best = str(rewards[own].mean().idxmax())
    verdicts = []
    for key, row in rows.items():
        difference = (rewards[key] - rewards[best]).dropna()
        if row in ("IQL", "QMIX") and len(difference) > 1:
            mean, spread = float(difference.mean()), float(difference.std(ddof=1))
            word = "as good as" if abs(mean) <= spread else ("better than" if mean > 0 else "worse than")
            verdicts.append(
                f"{results.methods[key].label} is {word} {results.methods[best].label}: "
                f"J̄ differs by {mean:+.3f} ± {spread:.3f} (mean and standard deviation over {len(difference)} seeds)."
            )
    return verdicts


def page(results: Results, table: pd.DataFrame, source: Path) -> str:
    """The report as Markdown.

    :param results: what the runs left
    :param table: Table II
    :param source: the recipe's file
    :return: the page
    """
    name = results.recipe.name
    command = f"lawn-sb3 reproduce {source.as_posix()}"
    seeds = ", ".join(map(str, results.recipe.seeds))
    crossing = first_crossing(results)
    parts = [
        f"# {results.recipe.title or name}",
        f"Made by `{command}`, scenario `{results.recipe.game().title}`, seeds {seeds}.",
    ]
    if results.problems:
        parts += ["**Not in this report:**", "\n".join(f"- {problem}" for problem in results.problems)]
    parts += [
        "## Table II",
        as_markdown(table),
        f"{table_caption(results)} T̄ is the makespan: slots until the last UAV is done. U is the mean utility; "
        "the paper prints none.",
    ]
    verdicts = baseline_verdicts(results)
    if verdicts:
        parts.append("\n".join(f"- {verdict}" for verdict in verdicts))
    if len(crossing):
        parts += [
            f"Env steps until the first rollout (or greedy evaluation) with {THRESHOLD:.0f} % success, slowest seed; "
            "the paper: about 150 K. *At most*: that was the first figure there is.",
            str(crossing.to_markdown(index=False, disable_numparse=True)),
        ]
    nearest = nearest_to_paper(results)
    if len(nearest):
        parts += [
            "Where on its learning curve each learner comes nearest to its success in the paper (greedy evaluation "
            "during training, mean over seeds; the paper's final values in parentheses):",
            str(nearest.to_markdown(index=False, disable_numparse=True)),
        ]
    parts += [
        "## Fig. 2: training",
        "![Reward and success against env steps](fig2_convergence.png)",
        f"Top: missions flown in training, {WINDOW}-point window. A mission that fails takes T_max slots to end and "
        "short ones end often, so this row counts too few failures; it begins once the first mission can have failed. "
        "Bottom: greedy play on missions apart from the test's, not smoothed; it has no such bias. "
        "Bands: 95 % interval of the mean over seeds. Dashed: players that do not learn. "
        "Diamonds: the paper's values after training. Rewards below the axis are those of the first rollouts.",
        "## Fig. 3: utility",
        "![Distribution of the utility](fig3_utility_cdf.png)",
        "All UAVs of all test episodes and seeds; bands: range over seeds.",
    ]
    return "\n\n".join(parts) + "\n"
