"""The report of a recipe: tables, figures and verdicts, from what the runs left."""

from __future__ import annotations

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.knowledge import has_ladder
from lawn_sb3.experiment.recipe import Cell, Recipe
from lawn_sb3.paper.checks import read_checks
from lawn_sb3.paper.claims import Evidence, judge_all, load_claims
from lawn_sb3.report.document import Report
from lawn_sb3.report.sections import (
    anarchy,
    fairness,
    fairness_tradeoff,
    figures,
    ladder,
    low_utility,
    occupancy,
    regret,
    sampling,
    trajectories,
    trajectories_3d,
)
from lawn_sb3.report.sections.claims import claims_headlines, claims_summary, claims_table, tally
from lawn_sb3.report.sections.comparison import base_method, comparison
from lawn_sb3.report.sections.learning import first_crossing, nearest_to_paper
from lawn_sb3.report.sections.table_one import table_one
from lawn_sb3.report.sections.table_two import table_two
from lawn_sb3.results.results import Results, read_results

SECTIONS = {
    "Table II: performance": ("table2", "comparison"),
    "What a UAV must know": ("ladder", "ladder_table", "ladder_learning"),
    "Claims of the paper": ("claims_headlines", "claims_summary", "claims"),
    "Fig. 2: training": ("fig2_convergence", "first_crossing", "nearest_to_paper"),
    "Fig. 3: utility": ("fig3_utility_cdf",),
    "How far from the optimum": ("anarchy", "regret", "regret_cdf"),
    "Cell loads over time": ("cell_loads",),
    "Who got the low utilities": (
        "fairness",
        "fairness_tradeoff",
        "low_utilities",
        "low_utility_by_load",
        "low_utility_by_delay",
    ),
    "One episode, every method": ("trajectories", "trajectories_3d"),
    "Greedy against sampled play": ("sampling",),
    "Table I: constants": ("table1",),
}


def build_report(recipe: Recipe, cells: list[Cell], command: str) -> tuple[Report, Results]:
    """Work out all tables, figures and verdicts.

    :param recipe: the recipe
    :param cells: its cells
    :param command: the command that makes this report again
    :return: the report, and what it was made of
    :raises UserError: if no run can be used
    """
    results = read_results(recipe, cells)
    if not results.methods:
        raise UserError(f"no finished run to report on: {results.problems[0]}; run: lawn-sb3 reproduce first")
    results.checks = read_checks(recipe, cells, results.problems)
    of_ladder = has_ladder(results.methods.values())
    claims = [claim for claim in load_claims() if claim.needs == "ladder" or not of_ladder]
    judged = judge_all(claims, Evidence(results))
    report = Report(recipe, command, SECTIONS, results.problems, [f"The paper's claims: {tally(judged)}."])
    joint = results.without_bound()
    base = base_method(joint)
    made = {
        "table1": table_one(results),
        "table2": table_two(results),
        "comparison": comparison(joint, base) if base is not None else None,
        "claims_headlines": claims_headlines(judged),
        "claims_summary": claims_summary(judged),
        "claims": claims_table(judged),
        "first_crossing": first_crossing(results),
        "nearest_to_paper": nearest_to_paper(results),
        "anarchy": anarchy.anarchy(results),
        "regret": regret.regret(results) if len(results.regrets) else None,
        "sampling": sampling.sampling(results),
        "ladder_table": ladder.ladder_table(results) if of_ladder else None,
    }
    report.tables = {name: table for name, table in made.items() if table is not None and len(table.shown)}
    report.figures["fig2_convergence"] = figures.convergence(results), figures.CONVERGENCE_CAPTION
    report.figures["fig3_utility_cdf"] = figures.utility_cdf(results), figures.cdf_caption(results)
    if of_ladder:
        report.figures["ladder"] = ladder.ladder(results), ladder.ladder_caption(results)
        report.figures["ladder_learning"] = ladder.learning(results), ladder.LEARNING_CAPTION
    if len(results.regrets):
        report.figures["regret_cdf"] = regret.regret_cdf(results), regret.cdf_caption(results)
    if joint.methods:
        _add_joint_flights(report, joint)
    return report, results


def _add_joint_flights(report: Report, results: Results) -> None:
    """Tables and figures about UAVs that meet."""
    report.tables |= {
        "fairness": fairness.fairness(results),
        "low_utility_by_load": low_utility.low_utility(results, "co_served"),
        "low_utility_by_delay": low_utility.low_utility(results, "detour"),
    }
    report.figures["fairness_tradeoff"] = (
        fairness_tradeoff.fairness_tradeoff(results),
        fairness_tradeoff.caption(results),
    )
    report.figures["low_utilities"] = low_utility.low_utilities(results), low_utility.caption(results)
    if len(results.slots):
        report.figures["cell_loads"] = occupancy.cell_loads(results), occupancy.caption(results)
    if len(results.paths):
        report.figures["trajectories"] = trajectories.from_above(results), trajectories.caption(results)
        report.figures["trajectories_3d"] = trajectories_3d.in_space(results), trajectories.caption(results)
