"""How fast the kit is on this machine: simulator, environments, planning, learning; one core, one torch thread."""

from lawn_sb3.experiment.benchmark.benchmark import Speeds, benchmark

__all__ = ["Speeds", "benchmark"]
