"""Table II: every method's figures over seeds, the paper's beside them."""

from __future__ import annotations

import pandas as pd

from lawn_sb3.experiment.paper import TABLE_II
from lawn_sb3.report.results import Results

COLUMNS = {
    "reward": ("J̄", r"$\bar{J}$", 2),
    "rate_mbps": ("R̂ (Mbps)", r"$\hat{R}$ (Mbps)", 2),
    "makespan_slots": ("T̄ (slots)", r"$\bar{T}$ (slots)", 1),
    "success_percent": ("Success (%)", r"Success (\%)", 1),
    "utility_mbps": ("U (Mbps)", "$U_i$ (Mbps)", 1),
}
"""Column: its heading in text and in LaTeX, and its decimals."""


def table_two(results: Results) -> pd.DataFrame:
    """Mean over seeds of each figure, its standard deviation over seeds, and the paper's value.

    :param results: what the runs left
    :return: one row a method, with the columns ``method, seeds`` and for each figure ``NAME, NAME_sd, NAME_paper``
    """
    by_seed = results.by_seed()
    rows = []
    for key, method in results.methods.items():
        own = by_seed[by_seed["method"] == key]
        printed = TABLE_II[method.paper_row]._asdict() if method.paper_row else {}
        row: dict[str, object] = {"method": method.label, "seeds": len(own)}
        for name in COLUMNS:
            row[name] = own[name].mean()
            row[f"{name}_sd"] = own[name].std(ddof=1) if len(own) > 1 else float("nan")
            row[f"{name}_paper"] = printed.get(name, float("nan"))
        rows.append(row)
    return pd.DataFrame(rows)


def as_text(table: pd.DataFrame, latex: bool = False) -> pd.DataFrame:
    """Format the table for reading: ``mean ± s.d. (paper's value)``.

    :param table: what :func:`table_two` returned
    :param latex: with LaTeX's signs instead of Unicode's
    :return: the same rows, every cell a text
    """
    plus_minus = r" $\pm$ " if latex else " ± "
    shown = pd.DataFrame({"Method": table["method"]})
    for name, (heading, latex_heading, decimals) in COLUMNS.items():
        cells = []
        for mean, sd, printed in zip(table[name], table[f"{name}_sd"], table[f"{name}_paper"], strict=True):
            spread = f"{plus_minus}{sd:.{decimals}f}" if pd.notna(sd) else ""
            paper = f" ({printed:.{decimals}f})" if pd.notna(printed) else ""
            cells.append(f"{mean:.{decimals}f}{spread}{paper}")
        shown[latex_heading if latex else heading] = cells
    shown["Seeds"] = table["seeds"].astype(str)
    return shown


def as_markdown(table: pd.DataFrame) -> str:
    """Write the table for a forge.

    :param table: what :func:`table_two` returned
    :return: a Markdown table
    """
    shown = as_text(table)
    shown["Method"] = shown["Method"].str.replace("|", "\\|")
    return str(shown.to_markdown(index=False, disable_numparse=True))


def as_latex(table: pd.DataFrame, caption: str) -> str:
    """Write the table for a paper, with booktabs' rules.

    :param table: what :func:`table_two` returned
    :param caption: its caption
    :return: a LaTeX table
    """
    shown = as_text(table, latex=True)
    shown["Method"] = shown["Method"].str.replace(r"([&%$#_{}])", r"\\\1", regex=True)
    body = shown.to_latex(index=False, escape=False, column_format="l" + "c" * (len(shown.columns) - 1))
    return f"\\begin{{table}}[t]\n\\centering\n\\caption{{{caption}}}\n{body}\\end{{table}}\n"
