"""The game as a learner sees it."""

from lawn_sb3.envs.actor_player import ActorPlayer
from lawn_sb3.envs.flatten import FlatVecEnv, make_vec_env
from lawn_sb3.envs.observation import ObservationLayout, Observer
from lawn_sb3.envs.parallel_env import LawnEnv
from lawn_sb3.envs.training_env import TrainingEnv

__all__ = ["ActorPlayer", "FlatVecEnv", "LawnEnv", "ObservationLayout", "Observer", "TrainingEnv", "make_vec_env"]
