"""One table in every form: nothing is lost or garbled on the way to Markdown, CSV and LaTeX."""

import io
import string
from pathlib import Path

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lawn_sb3.report.table import Row, Table, interval_of, latex_text, table_of
from lawn_sb3.results.statistics import UNKNOWN, Interval

TABLE = Table(
    pd.DataFrame({"method": ["A|B & V_x"], "share": [0.123456789]}),
    pd.DataFrame({"Method": ["A|B & V_x"], "T̄ (%)": ["12.3 ± 0.1"]}),
    "100 % of J̄ ≠ T_min.",
)


def test_markdown_shows_labels_as_they_are_written() -> None:
    heading, _, row = TABLE.as_markdown().splitlines()
    assert [cell.strip() for cell in heading.strip("|").split("|")] == ["Method", "T̄ (%)"]
    assert "A\\|B & V_x" in row  # an unescaped | would begin another cell


def test_csv_keeps_numbers_unrounded_to_six_digits() -> None:
    rows = pd.read_csv(io.StringIO(TABLE.as_csv()))
    assert rows.loc[0, "method"] == "A|B & V_x"
    assert rows.loc[0, "share"] == 0.123457


def test_latex_escapes_what_it_would_read_otherwise() -> None:
    text = TABLE.as_latex()
    assert r"A|B \& V\_x & 12.3 $\pm$ 0.1 \\" in text
    assert r"Method & $\bar{T}$ (\%) \\" in text
    assert r"\caption{100 \% of $\bar{J}$ $\neq$ $T^{\min}$.}" in text
    for rule in ("toprule", "midrule", "bottomrule"):
        assert f"\\{rule}" in text


def test_latex_wraps_a_column_of_long_texts_only() -> None:
    shown = pd.DataFrame({"short": ["x" * 50], "long": ["x" * 51]})
    assert r"\begin{tabular}{lp{0.3\linewidth}}" in Table(shown, shown, "").as_latex()


def test_latex_uses_its_own_cells_where_a_table_has_formulas() -> None:
    own = pd.DataFrame({"Symbol": [r"$\Delta_s$"]})
    assert r"$\Delta_s$" in Table(own, pd.DataFrame({"Symbol": ["Δ_s"]}), "", own).as_latex()


@given(st.text(string.printable + "J̄R̂T̄±×≠≤−–Δ†"))
def test_no_special_sign_of_latex_stays_unescaped(text: str) -> None:
    written = latex_text(text)
    for formula in (r"\bar{J}", r"\bar{T}", r"\hat{R}", r"T^{\min}"):
        written = written.replace(f"${formula}$", "")
    for command in (r"\textbackslash{}", r"\textasciitilde{}", r"\textasciicircum{}"):
        written = written.replace(command, "")
    for escaped in (r"\&", r"\%", r"\$", r"\#", r"\_", r"\{", r"\}"):
        written = written.replace(escaped, "")
    for sign in "&%#_{}~^":
        assert sign not in written.replace(r"$^\dagger$", "")


def test_a_table_is_saved_in_all_its_forms_with_equal_bytes(tmp_path: Path) -> None:
    for folder in ("first", "second"):
        (tmp_path / folder).mkdir()
        TABLE.save(tmp_path / folder, "small")
    for suffix, text in (("md", TABLE.as_markdown() + "\n"), ("csv", TABLE.as_csv()), ("tex", TABLE.as_latex())):
        content = (tmp_path / "first" / f"small.{suffix}").read_bytes()
        assert content == text.encode()
        assert content == (tmp_path / "second" / f"small.{suffix}").read_bytes()


def test_a_row_holds_an_interval_as_columns_and_as_text() -> None:
    row = Row({"key": "a"}, {"Method": "A"})
    row.add("J", "J̄", Interval(3.4349, 3.41, 3.4501), 2, after=" †")
    row.add("U", "U (Mbps)", UNKNOWN._replace(value=1.0), 1)
    row.add("R", "R̂", UNKNOWN, 1)
    table = table_of([row], "A row")
    numbers = table.numbers.iloc[0]
    assert numbers[["key", "J", "J_low", "J_high", "U"]].tolist() == ["a", 3.4349, 3.41, 3.4501, 1.0]
    assert interval_of(numbers, "J") == (3.4349, 3.41, 3.4501)
    assert table.shown.iloc[0].to_dict() == {"Method": "A", "J̄": "3.43 [3.41, 3.45] †", "U (Mbps)": "1.0", "R̂": "–"}


@pytest.mark.parametrize(("text", "expected"), [("a < b", "a $<$ b"), ("\\", r"\textbackslash{}"), ("–", "--")])
def test_single_signs(text: str, expected: str) -> None:
    assert latex_text(text) == expected


def test_a_table_of_many_rows_runs_over_pages_in_latex() -> None:
    shown = pd.DataFrame({"A": ["x"] * 31})
    text = Table(shown, shown, "Many & more").as_latex()
    assert text.startswith(r"\begin{longtable}")
    assert r"\caption{Many \& more}" in text
    assert r"\begin{table}" not in text


def test_columns_are_as_wide_whatever_is_installed_beside() -> None:
    table = Table(pd.DataFrame(), pd.DataFrame({"J̄": ["1.0"], "R̂ (Mbps)": ["36.71"]}), "")
    assert table.as_markdown().splitlines()[0] == "| J̄   | R̂ (Mbps)   |"
