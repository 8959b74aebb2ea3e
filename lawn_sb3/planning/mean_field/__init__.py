"""Planners that know only what experience says of the cells: no UAV's plan, only what to expect of each cell."""

from lawn_sb3.planning.mean_field.mean_field import MeanFieldDestinationsPlayer, MeanFieldMemoryPlayer, MeanFieldPlayer

__all__ = ["MeanFieldDestinationsPlayer", "MeanFieldMemoryPlayer", "MeanFieldPlayer"]
