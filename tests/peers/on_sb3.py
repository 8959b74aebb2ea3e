"""Stock Stable-Baselines3 PPO, whose critic sees o_i, and our MAPPO, whose critic sees x too."""

from collections.abc import Callable
from typing import Any

import numpy as np
import torch as th
from gymnasium import spaces
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnvWrapper

from lawn_sb3.algos.mappo import MAPPO
from lawn_sb3.envs import make_vec_env
from lawn_sb3.envs.observation import Floats32
from policies.centralized_critic import CentralizedCriticPolicy
from tests.peers import watch as peers
from tests.peers.watch import SCENARIO, Watch

GAMES = 16
SETTINGS: dict[str, Any] = {
    "n_steps": peers.ROLLOUT // GAMES,
    "batch_size": peers.MINIBATCH,
    "n_epochs": peers.EPOCHS,
    "learning_rate": peers.LEARNING_RATE,
    "gamma": peers.GAMMA,
    "gae_lambda": peers.GAE_LAMBDA,
    "clip_range": peers.CLIP,
    "ent_coef": peers.ENTROPY,
    "vf_coef": peers.VALUE,
    "max_grad_norm": peers.GRADIENT,
    "policy_kwargs": {"net_arch": peers.HIDDEN, "activation_fn": th.nn.Tanh},
    "seed": peers.SEED,
    "device": "cpu",
}


class Local(VecEnvWrapper):
    """The games without x, for PPO that knows no other critic than one that sees what the actor sees."""

    def __init__(self, venv: Any) -> None:
        self.columns = venv.get_attr("layout", [0])[0].local
        low = venv.observation_space.low[self.columns]
        super().__init__(venv, observation_space=spaces.Box(low, -low, dtype=np.float32))

    def reset(self) -> Any:
        return np.asarray(self.venv.reset())[:, self.columns]

    def step_wait(self) -> Any:
        flat, rewards, dones, infos = self.venv.step_wait()
        for info in infos:
            if "terminal_observation" in info:
                info["terminal_observation"] = info["terminal_observation"][self.columns]
        return np.asarray(flat)[:, self.columns], rewards, dones, infos


class Look(BaseCallback):
    def __init__(self, watch: Watch, actor: Callable[[Floats32], Any]) -> None:
        super().__init__()
        self.watch, self.actor = watch, actor

    def _on_training_start(self) -> None:
        self.watch.begin(self.actor)

    def _on_step(self) -> bool:
        return True

    def _on_rollout_start(self) -> None:  # of the next one, so the update is done
        if self.num_timesteps:
            self.watch.step(self.num_timesteps // SCENARIO.num_uavs, self.actor)

    def _on_training_end(self) -> None:
        self.watch.step(self.num_timesteps // SCENARIO.num_uavs, self.actor)


def _learn(model: Any, watch: Watch, columns: int) -> dict[str, Any]:
    def actor(o: Floats32) -> Any:
        flat = np.zeros((*o.shape[:2], columns), dtype=np.float32)
        flat[..., : o.shape[-1]] = o  # the actor does not read x
        return model.predict(flat.reshape(-1, columns), deterministic=True)[0].reshape(o.shape[:2])

    model.learn(watch.env_steps * SCENARIO.num_uavs, callback=Look(watch, actor))
    return watch.result(actor)


def ppo(env_steps: int) -> dict[str, Any]:
    """Stock PPO with one network for all UAVs and V(o)."""
    watch = Watch(env_steps, "stable-baselines3", "torch")
    games = Local(make_vec_env(SCENARIO, GAMES, seed=peers.SEED))
    return _learn(PPO("MlpPolicy", games, **SETTINGS), watch, games.observation_space.shape[0])  # type: ignore[index]


def ours(env_steps: int) -> dict[str, Any]:
    """MAPPO of this kit with its default critic, V(o, x)."""
    watch = Watch(env_steps, "lawn-sb3", "stable-baselines3", "torch")
    games = make_vec_env(SCENARIO, GAMES, seed=peers.SEED)
    return _learn(MAPPO(CentralizedCriticPolicy, games, **SETTINGS), watch, games.observation_space.shape[0])  # type: ignore[index]
