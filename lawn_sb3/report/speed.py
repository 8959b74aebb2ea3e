"""How the simulator's cost grows, as a figure."""

import pandas as pd
import seaborn as sns
from matplotlib.figure import Figure
from matplotlib.ticker import StrMethodFormatter

from lawn_sb3.report.style import use_house_style

SIZES = {"UAVs and GBSs": "num_uavs", "UAVs": "num_uavs", "GBSs": "num_gbs", "games": "num_games"}
FIXED = {
    "UAVs and GBSs": "as many GBSs as UAVs",
    "UAVs": "256 GBSs",
    "GBSs": "64 UAVs",
    "games": "games of 4 UAVs, 4 GBSs",
}


def growth_figure(growth: pd.DataFrame) -> Figure:
    """Draw agent steps a second against what grows.

    :param growth: what :func:`lawn_sb3.experiment.benchmark.game_speed.growth` returned
    :return: the figure
    """
    use_house_style()
    figure = Figure(figsize=(7, 5.5), layout="constrained")
    ax = figure.subplots()
    palette = sns.color_palette("colorblind")
    for (grows, own), marker, colour in zip(growth.groupby("grows", sort=False), "osD^", palette, strict=False):
        exponent = own["exponent"].iloc[0]
        label = f"{grows} ({FIXED[str(grows)]}): cost of a slot grows as size$^{{{exponent:.2f}}}$"
        ax.plot(own[SIZES[str(grows)]], own["agent_steps_per_s"] / 1e6, marker=marker, color=colour, label=label)
    ax.set_xscale("log", base=2)
    ax.set_yscale("log")
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter(StrMethodFormatter("{x:,g}"))
    ax.set_xlabel("number of what grows")
    ax.set_ylabel("million agent steps a second")
    figure.legend(loc="outside lower center", frameon=False)
    return figure
