"""Table I: every constant of the game, where its value comes from, and what the paper prints."""

from typing import Any

import pandas as pd

from lawn_sb3.paper.printed_values import TABLE_I
from lawn_sb3.report.section import Section
from lawn_sb3.report.symbols import symbol_of
from lawn_sb3.report.table import Table, latex_text
from lawn_sb3.results.results import Results
from lawn_sb3.scenario import Scenario

HEADINGS = ("Symbol", "Constant", "Value", "Unit", "Source", "Paper's Table I", "What it is")


def section(results: Results) -> Section:
    """List the constants of the recipe's scenario.

    :param results: what the runs left; only the recipe counts
    :return: a table with one row for each constant: ``symbol, constant, value, unit, source, printed, differs, text``
    """
    game = results.recipe.game()
    numbers = pd.DataFrame([_row(game, name) for name in Scenario.model_fields if name != "name"])
    marks = numbers["differs"].map({True: " †", False: ""})
    readable = numbers.assign(value=numbers["value"].map(_text) + marks).drop(columns="differs")
    texts = dict(zip(HEADINGS, (readable[column] for column in readable), strict=True))
    symbols = numbers["symbol"].map(symbol_of)
    shown = pd.DataFrame({**texts, "Symbol": symbols.map(lambda symbol: symbol.text)})
    latex = pd.DataFrame(texts).map(latex_text).assign(Symbol=symbols.map(lambda symbol: symbol.latex))
    caption = (
        f"Constants and readings of the scenario {game.title}. Source: stated in the paper, inferred from the figures "
        "it prints, or chosen here. †: differs from the value that the paper's Table I prints."
    )
    return Section("Table I: constants", {"table1": Table(numbers, shown, caption, latex)})


def _row(game: Scenario, name: str) -> dict[str, object]:
    field, value = Scenario.model_fields[name], getattr(game, name)
    extra: Any = field.json_schema_extra
    printed = TABLE_I.get(name)
    differs = printed is not None and any(own != printed.value for own in _as_printed(game, name))
    source = extra["source"]
    if printed is not None and not differs:
        source = "stated"
    elif value != field.default:  # evidence for the default speaks for no other value
        source = "chosen"
    return {
        "symbol": extra["symbol"],
        "constant": name,
        "value": value,
        "unit": extra["unit"].replace("-", "–"),
        "source": source,
        "printed": printed.printed if printed else "",
        "differs": differs,
        "text": field.description,
    }


def _as_printed(game: Scenario, name: str) -> list[float]:
    """A constant in the terms of the paper's Table I."""
    terms = {"gbs_grid": [game.num_gbs], "max_altitude_m": [game.grid[2]], "rbs_per_gbs": game.num_rbs.tolist()}
    return terms.get(name) or [float(getattr(game, name))]


def _text(value: object) -> str:
    if value is None:
        return "none"
    if isinstance(value, tuple):
        return f"({', '.join(map(_text, value))})"
    return f"{value:,.10g}" if isinstance(value, int | float) else str(value)
