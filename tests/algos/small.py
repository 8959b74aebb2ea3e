"""Learners and games small enough to train in a fraction of a second; the learners are ``Any``: tests look inside."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv

from lawn_sb3.algos.iql import IQL
from lawn_sb3.algos.mappo import MAPPO
from lawn_sb3.algos.qmix import QMIX
from lawn_sb3.envs import make_vec_env
from lawn_sb3.scenario import PRESETS
from policies.centralized_critic import CentralizedCriticPolicy
from policies.local_q import LocalQPolicy
from policies.monotonic_mixer import MonotonicMixerPolicy

SMALL = PRESETS["paper"].changed(num_uavs=2, max_slots=20)
NUM_GAMES = 8
VECTOR = NUM_GAMES * SMALL.num_uavs
"""Agent steps in one vector step."""
N_STEPS = 16
ROLLOUT = N_STEPS * VECTOR
"""Agent steps in one rollout."""


def small_env(**kwargs: Any) -> VecEnv:
    return make_vec_env(SMALL, NUM_GAMES, **kwargs)


def whole_games(**kwargs: Any) -> VecEnv:
    return make_vec_env(SMALL, NUM_GAMES, continuation="episode", **kwargs)


def learner(policy: Any = CentralizedCriticPolicy, env: VecEnv | None = None, **kwargs: Any) -> Any:
    """A small MAPPO, untrained."""
    small: dict[str, Any] = {"n_steps": N_STEPS, "batch_size": 128, "n_epochs": 2, "seed": 0, "device": "cpu"}
    if policy != "MlpPolicy":
        small["policy_kwargs"] = {"net_arch": {"pi": [32, 32], "vf": [32, 32]}}
    return MAPPO(policy, env or small_env(), **{**small, **kwargs})


def independent(policy: Any = LocalQPolicy, env: VecEnv | None = None, **kwargs: Any) -> Any:
    """A small IQL, untrained."""
    small: dict[str, Any] = {
        "learning_rate": 1e-3, "buffer_size": 400, "learning_starts": 64, "batch_size": 32, "gamma": 0.9,
        "train_freq": 2, "target_update_interval": 80, "policy_kwargs": {"net_arch": [32]}, "seed": 0, "device": "cpu",
    }  # fmt: skip
    return IQL(policy, env or small_env(), **{**small, **kwargs})


def team(policy: Any = MonotonicMixerPolicy, env: VecEnv | None = None, **kwargs: Any) -> Any:
    """A small QMIX, untrained."""
    small: dict[str, Any] = {
        "buffer_size": 800, "learning_starts": 4 * VECTOR, "batch_size": 32, "target_update_interval": 10,
        "policy_kwargs": {"net_arch": [32, 32]}, "seed": 0, "device": "cpu",
    }  # fmt: skip
    return QMIX(policy, env or whole_games(), **{**small, **kwargs})


def parameters(model: Any) -> NDArray[Any]:
    """All parameters and statistics of a policy in one vector; of a learner of IQL those of its target network too."""
    return np.concatenate([tensor.numpy().ravel() for tensor in model.policy.state_dict().values()])


def acts(model: Any, observations: Any) -> list[int]:
    actions: list[int] = model.predict(observations, deterministic=True)[0].tolist()
    return actions


def some_observations(count: int = 64, seed: int = 0) -> NDArray[np.float32]:
    env: Any = small_env(seed=seed)
    rows, rng = [env.reset()], np.random.default_rng(seed)
    while sum(map(len, rows)) < count:
        rows.append(env.step(rng.integers(env.action_space.n, size=env.num_envs))[0])
    return np.concatenate(rows)[:count]


def replaced(flat: NDArray[np.float32], columns: slice) -> NDArray[np.float32]:
    changed, rng = flat.copy(), np.random.default_rng(0)
    changed[:, columns] = rng.normal(scale=3.0, size=changed[:, columns].shape)
    return changed
