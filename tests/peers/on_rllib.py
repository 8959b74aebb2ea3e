"""RLlib's PPO: one network for all UAVs, and V(o), as it has no other critic of its own."""

from typing import Any

import ray
import torch as th
from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.core.columns import Columns
from ray.rllib.core.rl_module.default_model_config import DefaultModelConfig
from ray.rllib.env.wrappers.pettingzoo_env import ParallelPettingZooEnv
from ray.tune.registry import register_env

from lawn_sb3.envs import LawnEnv
from lawn_sb3.envs.observation import Floats32
from tests.peers import watch as peers
from tests.peers.watch import SCENARIO, Watch


def ppo(env_steps: int) -> dict[str, Any]:
    """PPO, all in this process."""
    watch = Watch(env_steps, "ray", "torch")
    ray.init(address="local", num_cpus=1, include_dashboard=False, log_to_driver=False)
    register_env("lawn", lambda _: ParallelPettingZooEnv(LawnEnv(SCENARIO)))
    config = PPOConfig().environment("lawn").env_runners(num_env_runners=0, rollout_fragment_length=peers.ROLLOUT)
    config.multi_agent(policies={"shared"}, policy_mapping_fn=lambda uav, episode, **_: "shared")
    model = DefaultModelConfig(fcnet_hiddens=peers.HIDDEN, fcnet_activation="tanh", vf_share_layers=False)
    config.rl_module(model_config=model)
    config.training(
        train_batch_size_per_learner=peers.ROLLOUT,
        minibatch_size=peers.MINIBATCH,
        num_epochs=peers.EPOCHS,
        lr=peers.LEARNING_RATE,
        gamma=peers.GAMMA,
        lambda_=peers.GAE_LAMBDA,
        clip_param=peers.CLIP,
        entropy_coeff=peers.ENTROPY,
        vf_loss_coeff=peers.VALUE,
        vf_clip_param=float("inf"),
        grad_clip=peers.GRADIENT,
        use_kl_loss=False,
    )
    config.learners(num_learners=0).debugging(seed=peers.SEED, log_level="ERROR")
    algorithm = config.build_algo()

    def actor(o: Floats32) -> Any:
        module = algorithm.get_module("shared")
        with th.no_grad():
            out = module.forward_inference({Columns.OBS: th.as_tensor(o).flatten(0, 1)})
        return out[Columns.ACTION_DIST_INPUTS].argmax(-1).reshape(o.shape[:2])

    watch.begin(actor)
    while watch.trained < env_steps:
        found = algorithm.train()["env_runners"]
        watch.step(int(found["num_env_steps_sampled_lifetime"]), actor)
    result = watch.result(actor)
    ray.shutdown()
    return result
