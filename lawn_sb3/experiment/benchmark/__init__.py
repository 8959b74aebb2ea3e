"""How fast the kit is on this machine: simulator, environments, planning, learning; one core, one torch thread."""

from lawn_sb3.experiment.benchmark.all_speeds import Speeds, benchmark
from lawn_sb3.experiment.benchmark.training_profile import training_profile

__all__ = ["Speeds", "benchmark", "training_profile"]
