"""Training: what Fig. 2 draws of players that do not learn, and milestones of the curves worked out by hand."""

import pandas as pd
from matplotlib.axes import Axes

from lawn_sb3.report.sections.training import section
from lawn_sb3.report.style import KNOWN
from lawn_sb3.results.results import Results
from tests.handmade import flown, learner, player, recipe_with, results_of
from tests.report.reading import picture_in, table_in

PLAYERS = ("random", "shortest-path", "best-route", "equilibrium", "welfare", "bound")
CURVE = {"method": ["learner"], "seed": [0], "time/env_steps": [1], "greedy/success_percent": [50.0]}


def results_with(*players: str) -> Results:
    """One mission each, with rewards 0, 1, 2..."""
    recipe = recipe_with({key: player(key) for key in players})
    flights = (flown(key, 0, reward=[float(k)]) for k, key in enumerate(players))
    return results_of(recipe, *flights, curves=pd.DataFrame(CURVE))


def levels(ax: Axes) -> dict[str, float]:
    """Colour and height of the horizontal lines of a panel."""
    return {str(line.get_color()): float(line.get_ydata()[0]) for line in ax.lines}  # type: ignore[index, arg-type]


def test_of_the_planners_fig_2_draws_one_so_that_no_lines_lie_on_top_of_each_other() -> None:
    figure = picture_in(section(results_with(*PLAYERS)), "fig2_convergence").figure
    expected = {KNOWN["random"]: 0.0, KNOWN["shortest-path"]: 1.0, KNOWN["welfare"]: 4.0}
    assert levels(figure.axes[0]) == levels(figure.axes[2]) == expected  # of training missions, of greedy play
    (legend,) = figure.legends
    labels = [text.get_text() for text in legend.get_texts()]
    assert labels == ["Random", "Shortest-path", "Welfare"]  # none of them has a row in the paper


def test_panels_have_letters_of_their_own_and_close_ups_are_marked_as_cut() -> None:
    results = results_with(*PLAYERS)
    numbers = {"greedy/reward": [-50.0, 3.0], "greedy/success_percent": [1.0, 99.0], "greedy/utility_mbps": [1.0, 30.0]}
    results.curves = pd.DataFrame({"method": "learner", "seed": 0, "time/env_steps": [1, 1000], **numbers})
    results.recipe.methods["learner"] = learner("Learner")
    figure = picture_in(section(results), "fig2_convergence").figure
    assert [ax.get_title()[:3] for ax in figure.axes] == ["(a)", "(b)", "(c)", "(d)", "(e)", "(f)"]
    cut = [ax for ax in figure.axes if "//" in [text.get_text() for text in ax.texts]]
    assert cut == figure.axes[4:]
    assert cut[0].get_ylim()[0] == 90.0
    assert cut[1].get_ylim() == (29.5, 30.5)  # after the first quarter
    assert figure.axes[2].get_ylim()[0] <= -50.0  # nothing is cut off
    results.curves["greedy/success_percent"] = [99.0, 50.0]
    (close_by,) = picture_in(section(results), "fig2_convergence").figure.axes[4:]
    assert close_by.get_title() == "(e) actions greedy, utility"  # nobody stayed above 90 %
    bare = picture_in(section(results_with(*PLAYERS)), "fig2_convergence").figure
    assert len(bare.axes) == 4  # no utilities were recorded, and success is 50 %


def test_only_in_its_own_game_are_the_papers_values_marked() -> None:
    def legend(*changes: str) -> list[str]:
        recipe = LEARNER.model_copy(update={"set": changes})
        shown = section(results_of(recipe, flown("mappo", 0), curves=pd.DataFrame({**CURVE, "method": ["mappo"]})))
        picture = picture_in(shown, "fig2_convergence")
        labels = [text.get_text() for text in picture.figure.legends[0].get_texts()]
        assert ("the paper's values" in picture.caption) == ("paper, after training" in labels)
        return labels

    assert legend() == ["CTDE-MAPPO", "paper, after training"]
    assert legend("num_uavs=5") == ["CTDE-MAPPO"]


def test_without_curves_there_are_neither_fig_2_nor_milestones() -> None:
    without = results_with(*PLAYERS)
    without.curves = pd.DataFrame()
    assert section(without) is None


LEARNER = recipe_with({"mappo": learner("CTDE-MAPPO", paper_row="CTDE-MAPPO")})
ONE = {"method": "mappo", "seed": [0, 0, 1, 1], "time/env_steps": [1000, 2000, 1000, 2000]}


def made(**columns: list[float]) -> Results:
    """Two seeds with two points each."""
    curves = pd.DataFrame({**ONE, **{name.replace("__", "/"): values for name, values in columns.items()}})
    return results_of(LEARNER, flown("mappo", 0), curves=curves)


def test_first_crossing_is_that_of_the_slowest_seed() -> None:
    both = made(missions__success_percent=[95.0, 90.0, 80.0, 96.0], greedy__success_percent=[10.0, 20.0, 97.0, 98.0])
    row = table_in(section(both), "first_crossing").shown.iloc[0]
    assert row["training missions"] == "2,000"  # seed 0 at 1,000, seed 1 at 2,000
    assert row["greedy evaluation"] == "1 of 2 seeds"
    assert row["n"] == "2"


def test_a_first_point_that_is_high_already_bounds_the_crossing() -> None:
    high = made(missions__success_percent=[95.0, 96.0, 99.0, 96.0])
    row = table_in(section(high), "first_crossing").shown.iloc[0]
    assert row["training missions"] == "at most 1,000"
    assert row["greedy evaluation"] == "not measured"


def test_nearest_to_the_paper_is_the_evaluation_with_the_nearest_mean_success() -> None:
    # Means over the two seeds: 50 % at 1,000 env steps, 99 % at 2,000; the paper's CTDE-MAPPO has 100 %.
    others = {f"greedy__{name}": [1.0, 2.0, 3.0, 4.0] for name in ("reward", "rate_mbps", "makespan_slots")}
    results = made(greedy__success_percent=[20.0, 99.0, 80.0, 99.0], **others)
    row = table_in(section(results), "nearest_to_paper").shown.iloc[0]
    assert row["env steps"] == "2,000"
    assert row["Success (%)"] == "99.0 (100.0)"
    assert row["J̄"] == "3.00 (3.19)"
