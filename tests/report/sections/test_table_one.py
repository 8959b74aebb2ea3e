"""Table I: all constants, what the paper prints, and a mark where ours differs."""

import pandas as pd
import pytest

from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.paper.printed_values import TABLE_I
from lawn_sb3.report.sections.table_one import section
from lawn_sb3.report.symbols import SYMBOLS
from lawn_sb3.report.table import Table
from lawn_sb3.results.results import Results
from lawn_sb3.scenario import Scenario
from tests.handmade import recipe_of
from tests.report.reading import table_in


def table_of(recipe: Recipe) -> Table:
    return table_in(section(Results(recipe)), "table1")


def numbers_of(scenario: str = "paper", *changes: str) -> pd.DataFrame:
    recipe = recipe_of(4, ("a",)).model_copy(update={"scenario": scenario, "set": changes})
    return table_of(recipe).numbers.set_index("constant")


def test_every_constant_of_the_scenario_is_there_once() -> None:
    assert list(numbers_of().index) == [name for name in Scenario.model_fields if name != "name"]


def test_every_symbol_has_a_form_in_text_and_in_latex() -> None:
    assert set(numbers_of()["symbol"]) <= set(SYMBOLS)


def test_every_value_of_the_papers_table_belongs_to_a_constant() -> None:
    assert set(TABLE_I) <= set(Scenario.model_fields)


def test_the_grid_alone_differs_from_the_papers_table() -> None:
    # Ours is 10 x 10 x 3 voxels (30 m / 10 m), the paper prints 100 x 100 x 30.
    numbers = numbers_of()
    marked = numbers[numbers["differs"]]
    assert list(marked.index) == ["width_voxels", "length_voxels", "max_altitude_m"]
    assert list(marked["value"]) == [10, 10, 30.0]
    assert list(marked["printed"]) == ["100", "100", "H = 30"]
    assert set(marked["source"]) == {"inferred"}


def test_as_printed_nothing_differs_and_the_grid_is_stated() -> None:
    numbers = numbers_of("as-printed")
    assert not numbers["differs"].any()
    assert numbers.loc["max_altitude_m", "value"] == 300.0  # 30 voxels of 10 m
    assert (numbers.loc[list(TABLE_I), "source"] == "stated").all()


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ("num_uavs=8", "num_uavs"),
        ("gbs_grid=[3, 2]", "gbs_grid"),  # six GBSs
        ("rbs_per_gbs=[10, 10, 10, 9]", "rbs_per_gbs"),
        ("gbs_positions_m=[[1, 2, 0], [9, 9, 0]]", "gbs_grid"),  # two GBSs
    ],
)
def test_a_changed_constant_is_marked(change: str, name: str) -> None:
    assert numbers_of("paper", change).loc[name, "differs"]
    assert not numbers_of().loc[name, "differs"]


def test_equal_counts_written_otherwise_do_not_differ() -> None:
    numbers = numbers_of("paper", "gbs_grid=[4, 1]", "rbs_per_gbs=[10, 10, 10, 10]")
    assert not numbers.loc[["gbs_grid", "rbs_per_gbs"], "differs"].any()


def test_evidence_for_the_default_speaks_for_no_other_value() -> None:
    assert numbers_of().loc["ema_beta", "source"] == "chosen"
    assert numbers_of("paper", "ema_beta=0.2").loc["ema_beta", "source"] == "chosen"


def test_markdown_and_latex_show_symbols_units_and_marks() -> None:
    table = table_of(recipe_of(4, ("a",)))
    rows = table.shown.set_index("Constant")
    assert rows.loc["width_voxels", "Value"] == "10 †"
    assert rows.loc["rb_bandwidth_hz", "Value"] == "180,000"
    assert rows.loc["rb_bandwidth_hz", "Unit"] == "Hz"
    assert rows.loc["noise_density_dbm_hz", "Symbol"] == "σ²"
    assert r"$\sigma^2$ & noise\_density\_dbm\_hz & -174 & dBm/Hz & inferred" in table.as_latex()
    assert r"$W$ & width\_voxels & 10 $^\dagger$ & voxels & inferred & 100" in table.as_latex()


def test_the_caption_names_the_scenario() -> None:
    assert "scenario paper, num_uavs=8" in table_of(recipe_of(8, ("a",))).caption
