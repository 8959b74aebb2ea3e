"""skrl's MAPPO: a network of its own for each UAV, a critic V(x) each, one game at a time."""

from typing import Any

import torch as th
from skrl.envs.wrappers.torch import wrap_env
from skrl.utils.runner.torch import Runner

from lawn_sb3.envs import LawnEnv
from lawn_sb3.envs.observation import Floats32
from tests.peers import watch as peers
from tests.peers.watch import SCENARIO, Watch


def mappo(env_steps: int) -> dict[str, Any]:
    """MAPPO."""
    watch = Watch(env_steps, "skrl", "torch")
    env = wrap_env(LawnEnv(SCENARIO, leaving=False), verbose=False)
    hidden = {"name": "hidden", "layers": peers.HIDDEN, "activations": "tanh"}
    policy = {"class": "CategoricalMixin", "network": [hidden | {"input": "OBSERVATIONS"}], "output": "ACTIONS"}
    value = {"class": "DeterministicMixin", "network": [hidden | {"input": "STATES"}], "output": "ONE"}
    agent = {
        "class": "MAPPO",
        "rollouts": peers.ROLLOUT,
        "learning_epochs": peers.EPOCHS,
        "mini_batches": peers.ROLLOUT * SCENARIO.num_uavs // peers.MINIBATCH,
        "learning_rate": peers.LEARNING_RATE,
        "discount_factor": peers.GAMMA,
        "gae_lambda": peers.GAE_LAMBDA,
        "ratio_clip": peers.CLIP,
        "entropy_loss_scale": peers.ENTROPY,
        "value_loss_scale": peers.VALUE,
        "grad_norm_clip": peers.GRADIENT,
        "learning_rate_scheduler_kwargs": ({}, {}),  # skrl 2.1 rejects its own default
        "experiment": {"write_interval": 0, "checkpoint_interval": 0},
    }
    runner = Runner(
        env,
        {
            "seed": peers.SEED,
            "models": {"separate": True, "policy": policy, "value": value},
            "memory": {"class": "RandomMemory", "memory_size": -1},
            "agent": agent,
            "trainer": {"class": "SequentialTrainer", "timesteps": env_steps, "headless": True},
        },
    )

    def actor(o: Floats32) -> Any:
        policies = [runner.agent.policies[uav] for uav in env.possible_agents]
        with th.no_grad():
            own = [
                policy.act({"observations": th.as_tensor(o[:, i])}, role="policy") for i, policy in enumerate(policies)
            ]
        return th.stack([outputs["net_output"].argmax(-1) for _, outputs in own], dim=1)

    after = runner.agent.post_interaction

    def post_interaction(*, timestep: int, timesteps: int) -> None:
        after(timestep=timestep, timesteps=timesteps)
        if (timestep + 1) % peers.ROLLOUT == 0:
            watch.step(timestep + 1, actor)

    runner.agent.post_interaction = post_interaction
    watch.begin(actor)
    runner.run()
    return watch.result(actor)
