"""How every figure looks: a method has the same colour-blind-safe colour, line and marker everywhere."""

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import cycle
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import seaborn as sns
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import ArrayLike

from lawn_sb3.results.statistics import Interval
from lawn_sb3.whole_files import whole_file

LineStyle = str | tuple[float, tuple[float, ...]]

OKABE_ITO = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#F0E442")
NOBODYS = ("#FF9DA7", "#44AA99", "#BCBD22", "#F0E442")
"""Colours that no known method has, for those beside it."""
KNOWN = {
    "random": "#7F7F7F",
    "shortest-path": "#333333",
    "iql": "#D55E00",
    "qmix": "#009E73",
    "mappo": "#0072B2",
    "mappo-state": "#56B4E9",
    "mappo-local": "#CC79A7",
    "mappo-blind": "#E69F00",
    "best-route": "#8C6D31",
    "forecast": "#A0D060",
    "worst-equilibrium": "#9F8FEF",
    "equilibrium": "#332288",
    "welfare": "#882255",
    "bound": "#000000",
}
LADDER = {
    "blind": "#E69F00",
    "loads": "#CC79A7",
    "clock": "#0072B2",
    "memory": "#56B4E9",
    "destinations": "#009E73",
    "intents": "#D55E00",
    "intents-in-time": "#F0A070",
    "state": "#A33B3B",
    "taught": "#5D7BD6",
    "destinations-taught": "#7FBF3F",
    "mean-field": "#6A3D9A",
    "mean-field-memory": "#B58BD0",
    "mean-field-destinations": "#1B6B5C",
}
"""The learners of the ladder, hardly ever beside those of the paper, whose colours some share; and their planners."""
COLOURS = KNOWN | LADDER
LINES: dict[str, LineStyle] = {
    "best-route": (0, (6, 1.5)),
    "forecast": (0, (6, 1.2, 1.2, 1.2)),
    "worst-equilibrium": (0, (3, 1)),
    "equilibrium": (0, (3, 1, 1, 1)),
    "welfare": (0, (6, 1, 1, 1, 1, 1)),
    "bound": (0, (1, 1)),
    "mean-field": (0, (4, 1.5, 1, 1.5, 1, 1.5)),
    "mean-field-memory": (0, (2, 1.5)),
    "mean-field-destinations": (0, (8, 1.5, 1, 1.5)),
}
"""Players that plan are never solid; all other methods are."""
MARKERS = "osD^vPX*<>hdp8H"
ENV_STEPS = "env steps (joint slots of one game)"
"""Label of an axis."""
DATED = {".png": ("Software",), ".pdf": ("CreationDate", "Producer", "Creator"), ".svg": ("Date", "Creator")}
"""What each kind of picture says of its making, which is left out."""
MOST_PANELS_A_ROW = 4
MOST_ROWS = 3
"""With more panels than these rows hold, rows take one more."""


def colours(methods: Iterable[str]) -> dict[str, str]:
    """The colour of each method: known ones have their own, others beside them in order what no known one has."""
    methods = list(methods)
    spare = (*NOBODYS, *OKABE_ITO) if any(key in COLOURS for key in methods) else OKABE_ITO
    return _dealt(methods, COLOURS, spare)


def mark_cut(ax: Axes, x: bool = False, y: bool = False) -> None:
    """Mark axes that do not begin where the quantity does by two strokes across their lower end."""
    boxed: dict[str, Any] = {"bbox": {"facecolor": "white", "edgecolor": "none", "pad": 0.6}, "transform": ax.transAxes}
    if x:
        ax.text(0.03, 0.0, "//", ha="center", va="center", fontsize="medium", color="0.2", zorder=6, **boxed)
    if y:
        ax.text(0.0, 0.05, "//", ha="center", va="center", rotation=-90, fontsize="medium", color="0.2", **boxed)


def line_of(method: str) -> LineStyle:
    """How the line of a method is drawn; the method by its key."""
    return LINES.get(method, "-")


def markers(methods: Iterable[str]) -> dict[str, str]:
    """The marker of each method, given as colours are; of all methods of a recipe, so that its figures agree."""
    return _dealt(methods, dict(zip(KNOWN, MARKERS, strict=False)), MARKERS)


def _dealt(methods: Iterable[str], known: Mapping[str, str], spare: Sequence[str]) -> dict[str, str]:
    """Known methods get their own, unless an earlier one has it; the others in order what none of those has."""
    methods = list(methods)
    own: dict[str, str] = {}
    for key in methods:
        if key in known and known[key] not in own.values():
            own[key] = known[key]
    left = cycle([look for look in spare if look not in own.values()] or spare)
    return {key: own[key] if key in own else next(left) for key in methods}


def use_house_style() -> None:
    """Set fonts, sizes and grid for all figures made from here on."""
    sns.set_theme(context="paper", style="whitegrid", font_scale=1.1)
    mpl.rcParams.update({"figure.dpi": 150, "savefig.dpi": 150, "axes.titlesize": "medium", "svg.hashsalt": "lawn"})


def save(figure: Figure, folder: Path, name: str, endings: Iterable[str] = (".png", ".pdf")) -> None:
    """Save a figure under a file name without ending; equal figures give equal bytes."""
    for ending in endings:
        with whole_file(folder / f"{name}{ending}") as part:
            figure.savefig(part, metadata=dict.fromkeys(DATED[ending]))


def title_of(ax: Axes, label: str, colour: str, height: float = 1.0) -> None:
    """Head a panel with the name of its method beside a mark in its colour, at a share of the panel's height."""
    mark = Patch(facecolor=colour, label=label)
    # A legend, since a title has but one colour, and pale ones are hard to read.
    place = (0.5, height)
    ax.legend(
        handles=[mark], loc="lower center", bbox_to_anchor=place, borderaxespad=0.1, handlelength=1, frameon=False
    )


def grid_shape(count: int) -> tuple[int, int]:
    """Rows and columns of so many small multiples, rows as even as can be."""
    longest = MOST_PANELS_A_ROW + (count > MOST_PANELS_A_ROW * MOST_ROWS)
    rows = math.ceil(count / longest)
    return rows, math.ceil(count / rows)


def panels(figure: Figure, count: int, width: float, height: float, xlabel: str, ylabel: str) -> list[Axes]:
    """Lay out small multiples with shared axes, rows as even as can be, and set the figure's size.

    :param figure: an empty figure
    :param count: number of panels
    :param width: of a panel, in inches
    :param height: of a panel, in inches
    :param xlabel: what the x-axes show
    :param ylabel: what the y-axes show
    :return: the panels, row by row; only the outer ones carry labels
    """
    rows, columns = grid_shape(count)
    figure.set_size_inches(1.0 + width * columns, 0.5 + height * rows)
    axes: list[Axes] = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel().tolist()
    for ax in axes[count:]:
        ax.remove()
    for k, ax in enumerate(axes[:count]):
        if k + columns >= count:
            ax.tick_params(labelbottom=True)
            ax.set_xlabel(xlabel)
        if k % columns == 0:
            ax.set_ylabel(ylabel)
    return axes[:count]


def error_bars(interval: Interval) -> list[list[float]] | None:
    """The bars of an interval as :meth:`Axes.errorbar` takes them; none if its bounds are unknown."""
    value, low, high = interval
    return [[value - low], [high - value]] if interval.is_known else None


def band(values: ArrayLike) -> tuple[float, float]:
    """What seaborn draws around a mean with ``errorbar=("ci", 95), seed=0``, with all resamples in one go.

    :param values: one a seed [S]
    :return: the bounds of 95 % of the means of 1,000 resamples
    """
    drawn = np.asarray(values, dtype=np.float64)
    means = drawn[np.random.default_rng(0).integers(0, len(drawn), (1_000, len(drawn)))].mean(axis=-1)
    low, high = np.percentile(means, [2.5, 97.5])
    return float(low), float(high)


def in_thousands(ax: Axes) -> None:
    """Write env steps on the x-axis as ``150K``."""
    ax.xaxis.set_major_formatter(lambda value, _: f"{value / 1000:.0f}K")


def legend_below(figure: Figure, handles: Sequence[Artist], column_inches: float) -> None:
    """Put a legend below all panels, in as many columns of this width as fit, and make it taller by its rows."""
    width, height = figure.get_size_inches()
    columns = min(len(handles), max(int(width // column_inches), 1))
    rows = math.ceil(len(handles) / columns)
    figure.set_size_inches(width, height + 0.2 + 0.2 * rows)
    figure.legend(handles=handles, loc="outside lower center", ncols=columns, frameon=False, borderaxespad=0.0)
