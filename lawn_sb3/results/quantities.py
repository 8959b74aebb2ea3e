"""The quantities of an evaluation: what tables, figures and claims call each, its unit, and its digits."""

from typing import NamedTuple


class Quantity(NamedTuple):
    """A mean of an evaluation, as :func:`lawn_sb3.experiment.measures.summarize` names it."""

    symbol: str
    words: str
    """What sentences call it."""
    unit: str
    decimals: int
    """Digits after the point."""
    fine_decimals: int
    """Those of a difference."""
    axis: str
    """What figures call it."""
    more_is_better: bool = True

    @property
    def heading(self) -> str:
        """Heading of a table's column, such as ``Success (%)``."""
        return _with_unit(self.symbol[0].upper() + self.symbol[1:], self.unit)

    @property
    def difference_heading(self) -> str:
        """Heading of a column of differences, such as ``Δ success (points)``."""
        return _with_unit(f"Δ {self.symbol}", self._unit_of_difference)

    @property
    def axis_label(self) -> str:
        """Label of an axis, with the unit."""
        return _with_unit(self.axis, self.unit)

    @property
    def difference_label(self) -> str:
        """Label of an axis of differences, with the unit."""
        return _with_unit(f"Δ {self.axis}", self._unit_of_difference)

    @property
    def level_unit(self) -> str:
        """What stands behind a number, with a space in front."""
        return f" {self.unit}".rstrip()

    @property
    def difference_unit(self) -> str:
        """What stands behind a difference, with a space in front."""
        return f" {self._unit_of_difference}".rstrip()

    @property
    def _unit_of_difference(self) -> str:
        return "points" if self.unit == "%" else self.unit


def _with_unit(text: str, unit: str) -> str:
    return f"{text} ({unit})" if unit else text


QUANTITIES = {
    "reward": Quantity("J̄", "J̄", "", 2, 3, "reward $\\bar{J}$"),
    "rate_mbps": Quantity("R̂", "R̂", "Mbps", 2, 2, "corrected rate $\\hat{R}$"),
    "makespan_slots": Quantity("T̄", "T̄", "slots", 1, 2, "makespan $\\bar{T}$", more_is_better=False),
    "success_percent": Quantity("success", "success", "%", 1, 2, "success"),
    "utility_mbps": Quantity("U", "mean U", "Mbps", 1, 2, "mean utility $U_i$"),
    "collisions": Quantity("collisions", "collisions", "", 2, 3, "collisions a UAV", more_is_better=False),
}
