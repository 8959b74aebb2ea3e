"""Small models with policies of tests, for the probe to ask."""

from typing import Any

import torch as th
from stable_baselines3.common.policies import BasePolicy
from torch import nn

from lawn_sb3.algos.mappo import CTDEPolicy
from lawn_sb3.envs import make_vec_env
from lawn_sb3.envs.observation import EXTRAS
from lawn_sb3.experiment.registry import algorithm_for, find_algorithm
from lawn_sb3.scenario import Scenario
from tests.algos.small import NUM_GAMES, SMALL, VECTOR

REPLAY = {"buffer_size": 800, "batch_size": 32, "target_update_interval": 10, "learning_starts": 4 * VECTOR}
SETTINGS: dict[str, dict[str, Any]] = {
    "mappo": {"n_steps": 16, "batch_size": 128, "n_epochs": 2, "policy_kwargs": {"net_arch": [32, 32]}},
    "iql": {**REPLAY, "policy_kwargs": {"net_arch": [32]}},
    "qmix": {**REPLAY, "policy_kwargs": {"net_arch": [32, 32]}},
}


def built(policy: type[BasePolicy], scenario: Scenario = SMALL, **kwargs: Any) -> Any:
    """A small untrained model with a policy, of the algorithm that takes it."""
    name = algorithm_for(policy)
    assert name is not None
    algorithm: Any = find_algorithm(name, policy)
    extras = [sight for sight in getattr(policy, "sees", ()) if sight in EXTRAS]
    env = make_vec_env(scenario, NUM_GAMES, continuation=algorithm.continuation, extras=extras)
    return algorithm(policy, env, seed=0, device="cpu", **{**SETTINGS[name], **kwargs})


class Good(CTDEPolicy):
    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        return th.cat([local, state], dim=1)


class Masking(Good):
    """Rules out every odd action: its logit is minus infinity. Dropout besides, from torch's own random state."""

    def _build_mlp_extractor(self) -> None:
        super()._build_mlp_extractor()
        self.mlp_extractor.policy_net.append(nn.Dropout(0.5))

    def _get_action_dist_from_latent(self, latent_pi: th.Tensor) -> Any:
        odd = th.arange(63) % 2 == 1
        return self.action_dist.proba_distribution(self.action_net(latent_pi).masked_fill(odd, -th.inf))


class NormedCritic(Good):
    """Batch norm: in play it has statistics of its own, in updates it takes those of the batch."""

    def _build_mlp_extractor(self) -> None:
        super()._build_mlp_extractor()
        self.mlp_extractor.value_net.insert(0, nn.BatchNorm1d(self.layout.flat_dim))


def wrong_product(local: th.Tensor) -> th.Tensor:
    return local @ th.zeros(3, 4)
