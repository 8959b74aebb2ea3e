"""The paper's Sections II and III: the game of Eq. (6), <N, S, {A_i}, P, {U_i}>, knowing nothing of learning."""

from lawn_sb3.game.airspace import Missions, draw_missions
from lawn_sb3.game.simulator import Simulator

__all__ = ["Missions", "Simulator", "draw_missions"]
