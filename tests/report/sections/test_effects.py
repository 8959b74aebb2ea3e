"""Effects of ablations: differences seed by seed worked out by hand, and the laws of every comparison."""

from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.figure import Figure

from lawn_sb3.experiment.recipe import Method
from lawn_sb3.report.sections import effects as effects_section
from lawn_sb3.report.sections import learning_speed
from lawn_sb3.report.sections.effects import visible_span
from lawn_sb3.report.table import Table
from lawn_sb3.results.learning import mean_success
from lawn_sb3.results.pairing import EFFECTS, left_out, pair_up
from lawn_sb3.results.results import Results
from tests.handmade import flown, learner, recipe_with, results_of, trained
from tests.report.reading import interval_in, numbers_of, picture_in, shown_of, table_in

BUDGET = 1_000


def part(label: str, baseline: str | None, algo: str = "mappo") -> Method:
    return learner(label, algo=algo).model_copy(update={"baseline": baseline, "env_steps": BUDGET})


RECIPE = recipe_with(
    {
        "qmix": part("QMIX", None, "qmix"),
        "additive": part("Additive", "qmix", "qmix"),
        "mappo": part("MAPPO", None),
        "worse": part("Worse", "mappo"),
        "better": part("Better", "mappo"),
    },
    seeds=[0, 1, 2],
)


def rewards(method: str, *by_seed: float) -> list[pd.DataFrame]:
    return [flown(method, seed, reward=[reward]) for seed, reward in enumerate(by_seed)]


def effects(results: Results) -> Table:
    return table_in(effects_section.section(results), "effects")


def forest(results: Results) -> Figure:
    return picture_in(effects_section.section(results), "effects_forest").figure


def row_of(results: Results, key: str) -> dict[Any, Any]:
    return numbers_of(effects(results))[key]


# Effects


def test_effects_by_hand() -> None:
    # J: differences 1, 2, 3, so 2 -+ 4.3027 / sqrt(3) = 2 -+ 2.484, as in the test of paired_t.
    # Two UAVs: in seed 0 one of the default's fails, so success differs by 50, 0, 0: 16.667 -+ 71.7.
    # Makespan: 3 slots less each time, so the interval has no width and leaves 0 out. Utility: the same.
    default = [
        flown("mappo", 0, 2, reward=[1.0, 1.0], arrived=[True, False], makespan_slots=[9, 9]),
        flown("mappo", 1, 2, reward=[2.0, 2.0], makespan_slots=[8, 8]),
        flown("mappo", 2, 2, reward=[3.0, 3.0], makespan_slots=[7, 7]),
    ]
    better = [
        flown("better", 0, 2, reward=[2.5, 1.5], makespan_slots=[6, 6]),
        flown("better", 1, 2, reward=[4.0, 4.0], makespan_slots=[5, 5]),
        flown("better", 2, 2, reward=[6.0, 6.0], makespan_slots=[4, 4]),
    ]
    shown = shown_of(effects(results_of(RECIPE, *default, *better)))["Better"]
    assert shown["Δ J̄"] == "2.000 [-0.484, 4.484]"
    assert shown["Δ success (points)"] == "16.67 [-55.04, 88.38]"
    assert shown["Δ T̄ (slots)"] == "-3.00 [-3.00, -3.00] ‡"  # all seeds agree, so chance has no part
    assert shown["Δ U (Mbps)"] == "0.00 [0.00, 0.00]"
    # Seeds of the ablation have 2, 4, 6, of the default 1, 2, 3: of nine pairs 2 < 3 loses, 2 = 2 counts half.
    assert shown["P(better J̄)"].startswith(f"{7.5 / 9:.2f} [")
    assert shown["P(better U)"].startswith("0.50 [")
    assert shown["n"] == "3 × 200"


def test_defaults_head_their_groups_mappos_first_and_ablations_go_from_best_to_worst() -> None:
    made = results_of(
        RECIPE,
        *rewards("qmix", 3.0, 3.0, 3.0),
        *rewards("additive", 9.0, 9.0, 9.0),
        *rewards("mappo", 2.0, 2.0, 2.0),
        *rewards("worse", 1.0, 1.0, 1.0),
        *rewards("better", 2.5, 2.5, 2.5),
    )
    table = effects(made)
    assert table.numbers["key"].tolist() == ["mappo", "better", "worse", "qmix", "additive"]
    assert table.numbers["reward"].tolist() == [2.0, 0.5, -1.0, 3.0, 6.0]
    assert table.shown["Method"].tolist() == ["MAPPO (default)", "Better", "Worse", "QMIX (default)", "Additive"]
    assert table.shown["P(better J̄)"].iloc[0] == "–"
    assert not table.shown["Δ J̄"].iloc[0].endswith("‡")  # 2.0 [2.0, 2.0] is no effect
    assert table.shown["Δ J̄"].iloc[1].endswith("‡")


def test_an_effect_is_sure_if_it_passes_the_correction_for_all_of_the_table() -> None:
    # Differences 1, 2, 3: t = 2 sqrt(3), p = 0.074 with 2 degrees of freedom. 1.1, 1, 0.9: t = 10 sqrt(3), p = 0.0033.
    # 1.3, 1, 0.7: t = 10 / sqrt(3), p = 0.029, which alone would count, but not as the second of three: 0.05 / 2.
    made = results_of(
        RECIPE,
        *rewards("mappo", 0.0, 0.0, 0.0),
        *rewards("better", 1.1, 1.0, 0.9),
        *rewards("worse", 1.3, 1.0, 0.7),
        *rewards("qmix", 0.0, 0.0, 0.0),
        *rewards("additive", 1.0, 2.0, 3.0),
    )
    table = effects(made)
    signs = {label: row["Δ J̄"].rpartition("]")[2] for label, row in shown_of(table).items()}
    assert (signs["Better"], signs["Worse"], signs["Additive"]) == (" ‡", " †", "")
    assert "of the 3 effects in which seeds differ 2 do, and about 0 would" in table.caption
    assert "Holm's correction over these 3 at 5 %, as 1 do, or" in table.caption
    numbers = numbers_of(table)
    assert (numbers["better"]["reward_sure"], numbers["worse"]["reward_sure"]) == (True, False)
    assert numbers["worse"]["reward_p"] == pytest.approx(0.0287, abs=1e-4)


def test_a_method_has_no_effect_on_itself() -> None:
    rng = np.random.default_rng(0)
    twin = part("Twin", "mappo")
    recipe = recipe_with({"mappo": RECIPE.methods["mappo"], "twin": twin})
    made = [
        flown("mappo", seed, reward=list(rng.normal(size=9)), utility_mbps=list(rng.uniform(0, 50, size=9)))
        for seed in (0, 1)
    ]
    row = row_of(results_of(recipe, *made, *(rows.assign(method="twin") for rows in made)), "twin")
    for name in EFFECTS:
        assert interval_in(row, name) == [0.0, 0.0, 0.0]
    assert [row[f"{name}_improvement"] for name in ("reward", "utility_mbps")] == pytest.approx([0.5, 0.5])


@given(
    own=st.lists(st.floats(-10, 10), min_size=3, max_size=3),
    other=st.lists(st.floats(-10, 10), min_size=3, max_size=3),
    more=st.floats(-10, 10),
)
@settings(max_examples=25)
def test_a_constant_added_to_all_rewards_is_added_to_the_effect(
    own: list[float], other: list[float], more: float
) -> None:
    default = rewards("mappo", *other)
    before = pair_up(results_of(RECIPE, *default, *rewards("better", *own)))["mappo"][0].effect("reward")
    raised = rewards("better", *(reward + more for reward in own))
    after = pair_up(results_of(RECIPE, *default, *raised))["mappo"][0].effect("reward")
    assert after == pytest.approx(tuple(bound + more for bound in before), abs=1e-9)


def test_the_order_in_which_runs_were_read_does_not_matter() -> None:
    runs = [*rewards("mappo", 1.0, 2.0, 4.0), *rewards("better", 2.0, 2.5, 3.0), *rewards("worse", 0.0, 1.0, 0.0)]
    forward, backward = (effects(results_of(RECIPE, *order)).numbers for order in (runs, runs[::-1]))
    pd.testing.assert_frame_equal(forward, backward)


def test_only_seeds_that_both_have_are_paired() -> None:
    # Seeds 1 and 2 of the ablation: 5 - 2 and 7 - 4; the default's seed 0 has no partner.
    made = results_of(RECIPE, *rewards("mappo", -50.0, 2.0, 4.0), *rewards("better", 0.0, 5.0, 7.0)[1:])
    row = row_of(made, "better")
    assert row["reward"] == 3.0
    assert row["reward_improvement"] == 1.0
    assert row["seeds"] == 2


def test_one_seed_has_an_effect_and_neither_bounds_nor_mark() -> None:
    made = results_of(RECIPE, *rewards("mappo", 1.0), *rewards("better", 2.0))
    table = effects(made)
    assert shown_of(table)["Better"]["Δ J̄"] == "1.000"
    assert "of the 0 effects in which seeds differ 0 do" in table.caption
    forest(made).draw_without_rendering()


def test_ablations_without_an_effect_are_named_with_what_they_lack() -> None:
    made = results_of(RECIPE, *rewards("worse", 1.0), *rewards("qmix", 1.0), *rewards("additive", 2.0, 2.0)[1:])
    assert left_out(made) == [
        "additive: not among the effects, as no seed has whole runs of both additive and qmix",
        "worse: not among the effects, as there is no whole run of mappo",
        "better: not among the effects, as there is no whole run of better and of mappo",
    ]
    assert pair_up(made) == {}


# The figure


def test_an_axis_leaves_out_an_effect_that_would_hide_the_others() -> None:
    small = [np.array([-0.1 * k, 0.2 * k]) for k in (1, 2, 3, 4)]  # up to 0.8
    span = visible_span([*small, np.array([-71.0, -69.0])])
    assert not span.holds(np.array([-69.0]))
    assert span.low < -0.4 < 0.8 < span.high < 2.0


def test_an_axis_holds_effects_of_like_size_and_a_lone_one() -> None:
    like = [np.array([-0.1, 0.3]), np.array([-1.2, -0.4]), np.array([2.0, 3.0]), np.array([0.0, 0.9])]
    lone = [np.zeros(2), np.zeros(2), np.zeros(2), np.array([-40.0, -30.0])]
    for extents in (like, lone, [np.zeros(2)]):
        span = visible_span(extents)
        assert all(span.holds(extent) for extent in extents)
        assert span.low < 0.0 < span.high


def test_the_figure_has_a_row_for_each_row_of_the_table_and_writes_what_lies_beyond() -> None:
    methods = {f"m{k}": part(f"Part {k}", "mappo") for k in range(5)} | {"mappo": RECIPE.methods["mappo"]}
    made = results_of(
        recipe_with(methods, seeds=[0, 1, 2]),
        *rewards("mappo", 3.0, 3.0, 3.0),
        *(run for k in range(4) for run in rewards(f"m{k}", 3.0 + k / 10, 3.1, 2.9)),
        *rewards("m4", -90.0, -91.0, -92.0),
    )
    figure = forest(made)
    labels = [text.get_text() for text in figure.axes[0].get_yticklabels()]
    assert labels == [text.removesuffix(" (default)") for text in effects(made).shown["Method"]]
    written = {text.get_text() for text in figure.axes[0].texts}
    # Differences -93, -94, -95: -94 -+ 2.484.
    assert written == {"3.000", "-94.000 [-96.484, -91.516] ‡"}
    assert figure.axes[0].get_xlim()[0] > -10.0


# Learning


def learnt(**by_method: list[list[float]]) -> Results:
    frames = [trained(method, *seeds, every=100) for method, seeds in by_method.items()]
    runs = [run for method, seeds in by_method.items() for run in rewards(method, *[1.0] * len(seeds))]
    return results_of(RECIPE, *runs, curves=pd.concat(frames, ignore_index=True))


def test_the_median_seed_counts_and_one_that_never_gets_there_is_slower_than_all() -> None:
    made = learnt(
        mappo=[[0.0, 95.0, 90.0, 99.0], [0.0, 0.0, 96.0, 99.0], [0.0, 97.0, 99.0, 99.0]],  # 200, 300, 200
        better=[[0.0, 0.0, 0.0, 98.0], [0.0, 0.0, 0.0, 94.9], [0.0, 96.0, 98.0, 98.0]],  # 400, never, 200
        worse=[[0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 9.0], [95.0, 96.0, 98.0, 98.0]],  # never, never, 100
    )
    table = table_in(learning_speed.section(made), "learning_effects")
    assert {label: row["Env steps to 95 %"] for label, row in shown_of(table).items()} == {
        "MAPPO (default)": "200 [200 to 300]",
        "Better": "400 [200 to > 1,000]",
        "Worse": "> 1,000 [at most 100 to > 1,000]",
    }
    numbers = numbers_of(table)
    assert numbers["better"]["ratio"] == 2.0
    assert numbers["worse"]["reached"] == 1
    assert np.isnan(numbers["worse"]["crossing_env_steps"])
    assert shown_of(effects(made))["Better"]["Env steps to 95 %"] == "400"
    assert len(picture_in(learning_speed.section(made), "learning_curves").figure.axes) == 2


def test_mean_success_is_the_area_under_the_curve() -> None:
    # From 100 to 200 it rises from 0 to 100, 50 on average, and stays there until 300: 75 on the whole. From 150 to 200
    # it rises from 50 to 100: 75 too; from 150 to 250, with as much at 100: 87.5.
    curve = pd.Series([0.0, 100.0, 100.0], index=[100, 200, 300])
    assert mean_success(curve, 100, 300) == pytest.approx(75.0)
    assert mean_success(curve, 150, 200) == pytest.approx(75.0)
    assert mean_success(curve, 150, 250) == pytest.approx(87.5)


def test_learning_is_compared_where_both_were_watched() -> None:
    # From 100 to 200 the default has 50 on average and the ablation 70; what comes after has no counterpart.
    made = learnt(mappo=[[40.0, 60.0, 100.0, 100.0]], better=[[60.0, 80.0]])
    numbers = numbers_of(table_in(learning_speed.section(made), "learning_effects"))
    assert numbers["better"]["mean_success_percent"] == pytest.approx(20.0)


def test_without_curves_effects_are_told_all_the_same() -> None:
    made = results_of(RECIPE, *rewards("mappo", 1.0, 1.0), *rewards("better", 2.0, 2.0))
    assert effects(made).shown["Env steps to 95 %"].tolist() == ["–", "–"]
