"""A learner and games small enough to train in a fraction of a second."""

from typing import Any

import numpy as np
from stable_baselines3.common.vec_env import VecEnv

from lawn_sb3.algos.mappo import MAPPO
from lawn_sb3.envs import make_vec_env
from lawn_sb3.scenario import PRESETS
from policies.centralized_critic import CentralizedCriticPolicy

SMALL = PRESETS["paper"].changed(num_uavs=2, max_slots=20)
NUM_GAMES = 8
N_STEPS = 16
ROLLOUT = N_STEPS * NUM_GAMES * 2
"""Agent steps in one rollout."""


def small_env(**kwargs: Any) -> VecEnv:
    return make_vec_env(SMALL, NUM_GAMES, **kwargs)


def learner(policy: Any = CentralizedCriticPolicy, env: VecEnv | None = None, **kwargs: Any) -> MAPPO:
    """A small MAPPO, untrained."""
    small: dict[str, Any] = {"n_steps": N_STEPS, "batch_size": 128, "n_epochs": 2, "seed": 0, "device": "cpu"}
    if policy != "MlpPolicy":
        small["policy_kwargs"] = {"net_arch": {"pi": [32, 32], "vf": [32, 32]}}
    return MAPPO(policy, env or small_env(), **{**small, **kwargs})


def parameters(model: Any) -> np.ndarray:
    """All parameters and statistics of a policy in one vector."""
    return np.concatenate([tensor.numpy().ravel() for tensor in model.policy.state_dict().values()])


def some_observations(count: int = 64, seed: int = 0) -> np.ndarray:
    """Flat observations of random play."""
    env = small_env(seed=seed)
    rows = [env.reset()]
    rng = np.random.default_rng(seed)
    while sum(map(len, rows)) < count:
        rows.append(env.step(rng.integers(env.action_space.n, size=env.num_envs))[0])  # type: ignore[attr-defined]
    return np.concatenate(rows)[:count]  # type: ignore[arg-type]
