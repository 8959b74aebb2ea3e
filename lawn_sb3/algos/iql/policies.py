"""The learners' policies as one: rows of whole games go in, each learner answers for its own slots."""

from collections.abc import Sequence
from typing import Any

import torch as th
from gymnasium import spaces
from sb3_contrib.qrdqn.policies import QRDQNPolicy
from stable_baselines3.common.policies import BasePolicy
from stable_baselines3.common.type_aliases import PyTorchObs
from stable_baselines3.dqn.policies import DQNPolicy
from torch import nn

from lawn_sb3.algos.iql.views import LearnerViews


class IndependentPolicy(BasePolicy):
    """Every learner's greedy actions for its own slots.

    :param observation_space: the flat observation
    :param action_space: the actions
    :param learners: the learners' policies, each a function of what its learner sees
    :param views: which slots and columns are whose
    """

    def __init__(
        self,
        observation_space: spaces.Box,
        action_space: spaces.Discrete,
        learners: Sequence[BasePolicy],
        views: LearnerViews,
    ) -> None:
        super().__init__(observation_space, action_space)
        self.learners = nn.ModuleList(learners)
        self.views = views

    def forward(self, obs: th.Tensor, deterministic: bool = True) -> th.Tensor:
        """Greedy actions [G * N] for flat observations of whole games; exploring is the algorithm's."""
        return self._predict(obs, deterministic)

    def _predict(self, observation: PyTorchObs, deterministic: bool = True) -> th.Tensor:
        assert isinstance(observation, th.Tensor)
        num_uavs = self.views.layout.num_uavs
        if len(observation) % num_uavs:
            raise ValueError(
                f"{len(observation)} observations are no whole games of {num_uavs} UAVs: give one row per UAV, game by "
                "game, so that each is answered by its own network"
            )
        actions = th.empty(len(observation), dtype=th.long, device=observation.device)
        for learner, policy in enumerate(self.learners):
            assert isinstance(policy, BasePolicy)
            seen = self.views.observe(learner, observation)
            actions[self.views.slots(learner)] = policy(seen, deterministic=deterministic)
        return actions

    def action_values(self, flat: th.Tensor) -> th.Tensor:
        """Each UAV's own action values; of a learner with quantiles their mean.

        :param flat: flat observations of whole games [G * N, flat_dim]
        :return: action values [G * N, A]
        """
        answers = []
        for learner, policy in enumerate(self.learners):
            seen = self.views.observe(learner, flat)
            if isinstance(policy, QRDQNPolicy):
                answers.append(policy.quantile_net(seen).mean(dim=1))
            else:
                assert isinstance(policy, DQNPolicy)
                answers.append(policy.q_net(seen))
        return th.stack(answers, dim=1).flatten(0, 1)  # row g * N + i is UAV i of game g

    def allowed(self, flat: th.Tensor) -> th.Tensor | None:
        """Which moves may be taken at all, where the learners' policies say so.

        :param flat: flat observations of whole games [G * N, flat_dim]
        :return: true for such a move [G * N, A]; none if all may
        """
        policies: list[Any] = list(self.learners)
        if not hasattr(policies[0], "allowed"):
            return None
        num_actions = int(self.action_space.n)  # type: ignore[attr-defined]
        moves = th.zeros(len(flat), num_actions, dtype=th.bool, device=flat.device)
        for learner, policy in enumerate(policies):
            moves[self.views.slots(learner)] = policy.allowed(self.views.observe(learner, flat))
        return moves

    def set_training_mode(self, mode: bool) -> None:
        """Put all learners' policies in training or evaluation mode."""
        for policy in self.learners:
            assert isinstance(policy, BasePolicy)
            if policy.training != mode:  # SB3 asks before every action, and to go through all layers takes a while
                policy.set_training_mode(mode)
        self.training = mode

    def _get_constructor_parameters(self) -> dict[str, Any]:
        spaces_alone = {"observation_space": self.observation_space, "action_space": self.action_space}
        return {**spaces_alone, "learners": list(self.learners), "views": self.views}
