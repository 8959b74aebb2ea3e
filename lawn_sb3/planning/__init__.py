"""Players that need no learning: they know the game's rules and plan with them."""

from lawn_sb3.planning.shortest_path import ShortestPathPlayer

__all__ = ["ShortestPathPlayer"]
