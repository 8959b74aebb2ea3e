"""lawn-sb3: a Stable-Baselines3 kit for game-theoretic trajectory planning of UAV swarms."""

__version__ = "0.2.0"
