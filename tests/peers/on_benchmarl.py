"""BenchMARL's MAPPO, whose critic is V(x), and its QMIX; one network for all UAVs."""

import tempfile
from typing import Any

import torch as th
from benchmarl.algorithms import MappoConfig, QmixConfig
from benchmarl.environments.pettingzoo.common import PettingZooClass
from benchmarl.experiment import Callback, Experiment, ExperimentConfig
from benchmarl.models.mlp import MlpConfig
from tensordict import TensorDict
from torchrl.envs.libs.pettingzoo import PettingZooWrapper
from torchrl.envs.utils import ExplorationType, set_exploration_type

from lawn_sb3.envs import LawnEnv
from lawn_sb3.envs.observation import Floats32
from tests.peers import watch as peers
from tests.peers.watch import SCENARIO, Watch

GAMES = 16


class Lawn(PettingZooClass):  # type: ignore[misc]
    def get_env_fun(self, num_envs: int, continuous_actions: bool, seed: int | None, device: Any) -> Any:
        how = {"return_state": True, "categorical_actions": True, "seed": seed, "device": device}
        return lambda: PettingZooWrapper(LawnEnv(SCENARIO, leaving=False), **how)

    def supports_continuous_actions(self) -> bool:
        return False

    def supports_discrete_actions(self) -> bool:
        return True

    def has_state(self) -> bool:
        return True

    def has_render(self, env: Any) -> bool:
        return False

    def max_steps(self, env: Any) -> int:
        return SCENARIO.max_slots

    @staticmethod
    def env_name() -> str:
        return "lawn"


class Look(Callback):  # type: ignore[misc]
    def __init__(self, watch: Watch) -> None:
        super().__init__()
        self.watch = watch

    def actor(self, o: Floats32) -> Any:
        actions = self.experiment.action_spec["uav", "action"].space.n
        seen = {"observation": th.as_tensor(o), "action_mask": th.ones(*o.shape[:2], actions, dtype=th.bool)}
        with th.no_grad(), set_exploration_type(ExplorationType.DETERMINISTIC):
            return self.experiment.policy(TensorDict({"uav": seen}, o.shape[:1]))["uav", "action"]

    def on_train_end(self, training_td: Any, group: str) -> None:
        self.watch.step(self.experiment.total_frames, self.actor)


def _learn(algorithm: Any, env_steps: int) -> dict[str, Any]:
    watch = Watch(env_steps, "benchmarl", "torchrl", "torch")
    look = Look(watch)
    config = ExperimentConfig.get_from_yaml()
    config.max_n_frames, config.gamma, config.lr = env_steps, peers.GAMMA, peers.LEARNING_RATE
    config.clip_grad_norm, config.clip_grad_val = True, peers.GRADIENT
    config.on_policy_collected_frames_per_batch, config.on_policy_n_envs_per_worker = peers.ROLLOUT, GAMES
    config.on_policy_n_minibatch_iters = peers.EPOCHS
    config.on_policy_minibatch_size = peers.MINIBATCH // SCENARIO.num_uavs  # in env steps
    config.off_policy_collected_frames_per_batch, config.off_policy_n_envs_per_worker = GAMES * 4, GAMES
    config.off_policy_n_optimizer_steps, config.off_policy_train_batch_size = 2, peers.MINIBATCH // SCENARIO.num_uavs
    config.off_policy_memory_size, config.exploration_anneal_frames = 50_000, env_steps // 3
    config.evaluation, config.loggers, config.create_json = False, [], False
    with tempfile.TemporaryDirectory() as folder:
        config.save_folder = folder
        model = MlpConfig(num_cells=peers.HIDDEN, layer_class=th.nn.Linear, activation_class=th.nn.Tanh)
        experiment = Experiment(Lawn("paper", {}), algorithm, model, peers.SEED, config, callbacks=[look])
        watch.begin(look.actor)
        experiment.run()
    return watch.result(look.actor)


def mappo(env_steps: int) -> dict[str, Any]:
    """MAPPO."""
    algorithm = MappoConfig.get_from_yaml()
    algorithm.clip_epsilon, algorithm.entropy_coef, algorithm.lmbda = peers.CLIP, peers.ENTROPY, peers.GAE_LAMBDA
    algorithm.critic_coef = peers.VALUE
    return _learn(algorithm, env_steps)


def qmix(env_steps: int) -> dict[str, Any]:
    """QMIX."""
    return _learn(QmixConfig.get_from_yaml(), env_steps)
