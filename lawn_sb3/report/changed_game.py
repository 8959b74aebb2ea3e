"""What reports call a changed game."""

from typing import Any

from lawn_sb3.report.symbols import NO_SYMBOL, symbol_of
from lawn_sb3.scenario import Scenario

ABBREVIATIONS = {"ema", "gbs", "uav"}
UNIT_OF_A_NUMBER = {"rate_unit": "Mbps"}
"""Of readings that have no unit, and may be a number too."""


def game_label(name: str, game: Scenario, usual: Scenario) -> str:
    """Its name in words and all that is changed in it, such as ``link budget halved (P_tx = 16.99 dBm)``.

    :param name: its key in the recipe
    :param game: the changed game
    :param usual: the game as it is
    :return: the name in words alone, if nothing is changed
    """
    fields = [key for key in Scenario.model_fields if key != "name" and getattr(game, key) != getattr(usual, key)]
    changes = ", ".join(_change(key, getattr(game, key)) for key in fields)
    return _in_words(name) + (f" ({changes})" if changes else "")


def _change(key: str, value: Any) -> str:
    """A number with its symbol and unit; a reading, and what has no symbol, by its key in words."""
    extra = Scenario.model_fields[key].json_schema_extra
    assert isinstance(extra, dict)
    symbol, unit = symbol_of(str(extra["symbol"])).text, str(extra["unit"]).replace("1/", "per ")
    if not isinstance(value, int | float):
        return f"{_in_words(key)} = {_in_words(value) if isinstance(value, str) else value}"
    unit = UNIT_OF_A_NUMBER.get(key, "" if unit == "-" else unit)
    return f"{_in_words(key) if symbol == NO_SYMBOL else symbol} = {value:g} {unit}".rstrip()


def _in_words(key: str) -> str:
    words = key.replace("-", " ").replace("_", " ").split()
    return " ".join(word.upper() if word in ABBREVIATIONS else word for word in words)
