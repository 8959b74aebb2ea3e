"""How every figure looks: a method has the same colour-blind-safe colour everywhere."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import matplotlib as mpl
import seaborn as sns
from matplotlib.figure import Figure

OKABE_ITO = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#F0E442")
KNOWN = {"random": "#7F7F7F", "mappo": "#0072B2", "mappo-state": "#56B4E9", "qmix": "#009E73", "iql": "#D55E00"}


def colours(methods: Iterable[str]) -> dict[str, str]:
    """The colour of each method.

    :param methods: keys of the methods
    :return: known methods in their own colour, others in the colours that are left, in order
    """
    methods = list(methods)
    taken = {KNOWN[key] for key in methods if key in KNOWN}
    free = [colour for colour in OKABE_ITO if colour not in taken] or list(OKABE_ITO)
    others = [key for key in methods if key not in KNOWN]
    return {key: KNOWN[key] if key in KNOWN else free[others.index(key) % len(free)] for key in methods}


def use_house_style() -> None:
    """Set fonts, sizes and grid for all figures made from here on."""
    sns.set_theme(context="paper", style="whitegrid", font_scale=1.1)
    mpl.rcParams.update({"figure.dpi": 150, "savefig.dpi": 150, "axes.titlesize": "medium", "svg.hashsalt": "lawn"})


def save(figure: Figure, folder: Path, name: str) -> None:
    """Save a figure as PNG and PDF; equal figures give equal bytes.

    :param figure: the figure
    :param folder: where to
    :param name: file name without ending
    """
    figure.savefig(folder / f"{name}.png", metadata={"Software": None})
    figure.savefig(folder / f"{name}.pdf", metadata={"CreationDate": None, "Producer": None, "Creator": None})
