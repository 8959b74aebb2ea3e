"""Actor-critics in the symmetric frame: what is seen is turned into one octant, and the logits are turned back.

What an actor sees besides o_i is for a subclass to say, and so whether it looks at the cell loads; the critic sees o_i,
the clock, and all others as they lie around the UAV.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, ClassVar

import torch as th
from gymnasium import spaces
from stable_baselines3.common.torch_layers import create_mlp
from stable_baselines3.common.type_aliases import Schedule
from torch import nn

from lawn_sb3.algos.common.encoder import Encoder, Inputs
from lawn_sb3.algos.common.in_time import in_time
from lawn_sb3.algos.mappo.policies import MaskableCTDEPolicy
from lawn_sb3.envs.observation import OWN, ObservationLayout, Sight
from lawn_sb3.scenario import Scenario


class FramedLayers(nn.Module):
    """All layers of the actor, whose logits are in the order of the actions, and the critic's hidden layers.

    :param policy: the policy, which says what is seen
    :param net_arch: widths of the hidden layers of the actor (``pi``) and of the critic (``vf``)
    :param activation_fn: activation of the hidden layers
    :param num_actions: A
    """

    def __init__(
        self, policy: FramedPolicy, net_arch: dict[str, list[int]], activation_fn: type[nn.Module], num_actions: int
    ) -> None:
        super().__init__()
        # Bound methods in a plain tuple: the policy must not become a submodule of its own part.
        self._views = (policy.actor_view, policy.critic_view)
        self.encoder = policy.make_encoder(policy.sees, policy.looks_at_loads)
        self.policy_net = nn.Sequential(*create_mlp(self.encoder.width, num_actions, net_arch["pi"], activation_fn))
        probe = self._views[1](th.zeros(1, policy.layout.flat_dim))
        self.value_net = nn.Sequential(*create_mlp(probe.shape[1], -1, net_arch["vf"], activation_fn))
        self.latent_dim_pi, self.latent_dim_vf = num_actions, net_arch["vf"][-1]
        self.max_slots = policy.scenario.max_slots
        self.reluctance = nn.Parameter(th.tensor(policy.reluctance)) if policy.reluctance else None

    def forward(self, flat: th.Tensor) -> tuple[th.Tensor, th.Tensor]:
        """Run both.

        :param flat: flat observations [B, flat_dim]
        :return: logits [B, A] and the critic's features [B, latent_dim_vf]
        """
        return self.forward_actor(flat), self.forward_critic(flat)

    def forward_actor(self, flat: th.Tensor) -> th.Tensor:
        """Run the actor on what its policy sees.

        :param flat: flat observations [B, flat_dim]
        :return: logits [B, A]
        """
        seen = self._views[0](flat)
        features, turn = self.encoder(seen)
        logits = self.encoder.turn_back(self.policy_net(features), turn)
        if self.reluctance is None:
            return logits
        return logits - self.reluctance * ~in_time(self.encoder, seen, self.max_slots, slack=0)

    def forward_critic(self, flat: th.Tensor) -> th.Tensor:
        """Run the critic's hidden layers.

        :param flat: flat observations [B, flat_dim]
        :return: its features [B, latent_dim_vf]
        """
        features: th.Tensor = self.value_net(self._views[1](flat))
        return features


class FramedPolicy(MaskableCTDEPolicy):
    """An actor over o_i and what else it ``sees``, in the symmetric frame; moves are masked.

    :param observation_space: the flat observation
    :param action_space: the actions
    :param lr_schedule: learning rate as a function of the progress remaining
    :param layout: where o_i and x lie in the flat observation
    :param scenario: the game, for its airspace, cells and RBs
    :param symmetric: turn the airspace so that the own position lies in one octant; refused where the scenario has not
        the symmetries of a square
    :param inputs: places ``one-hot``, or as numbers ``relative`` to the own position
    :param reluctance: what an untrained actor takes off the logits of moves that use up slack, so that it starts from
        flights without a detour in time; trained like a weight; 0 for none
    :param kwargs: what else sb3-contrib's ``MaskableActorCriticPolicy`` takes
    """

    needs_scenario: ClassVar[bool] = True
    looks_at_loads: ClassVar[bool] = True
    """Whether the actor looks at the cell loads that o_i holds, and at the EMA rate that they leave."""
    sees: ClassVar[tuple[Sight, ...]] = ("clock",)

    def __init__(
        self,
        observation_space: spaces.Box,
        action_space: spaces.Discrete,
        lr_schedule: Schedule,
        layout: ObservationLayout,
        scenario: Scenario,
        symmetric: bool = True,
        inputs: Inputs = "one-hot",
        reluctance: float = 0.0,
        **kwargs: Any,
    ) -> None:
        self.scenario, self.symmetric, self.inputs, self.reluctance = scenario, symmetric, inputs, reluctance
        super().__init__(observation_space, action_space, lr_schedule, layout, **kwargs)

    def make_encoder(self, sees: Collection[Sight], loads: bool = True) -> Encoder:
        """How what is seen is put to a network.

        :param sees: what is seen besides o_i
        :param loads: whether the cell loads are looked at, and the EMA rate that they leave
        :return: the encoder
        """
        return Encoder(self.scenario, self.layout, sees, loads, symmetric=self.symmetric, inputs=self.inputs)

    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        """What the critic sees: o_i, the clock if the actor sees it, and the others as they lie around the UAV.

        :param local: local observations o_i, followed by what else the policy ``sees`` [B, at least local_dim]
        :param state: global states x [B, state_dim]
        :return: the critic's input [B, anything]
        """
        encoder, layout = self.critic_encoder, self.layout
        own: th.Tensor
        own, turn = encoder(local)
        if layout.num_uavs == 1:
            return own
        uavs = state[:, layout.state_uavs].reshape(len(state), -1, OWN)
        itself = (uavs == local[:, None, :OWN]).all(dim=-1).long().argmax(dim=1, keepdim=True)
        others = (itself + th.arange(1, layout.num_uavs, device=local.device)) % layout.num_uavs  # [B, N - 1]
        rows = th.arange(len(local), device=local.device)[:, None]
        places = encoder.voxels(uavs[rows, others, :6].reshape(len(local), -1, 2, 3))
        place = encoder.turned_position(local, turn)
        return th.cat([own, *(part.float() for part in encoder.others(places, place, turn))], dim=1)

    def _build_mlp_extractor(self) -> None:
        assert isinstance(self.net_arch, dict)
        assert isinstance(self.action_space, spaces.Discrete)
        clock: list[Sight] = [extra for extra in self.layout.extras if extra == "clock"]
        self.critic_encoder = self.make_encoder(clock)
        num_actions = int(self.action_space.n)
        self.mlp_extractor = FramedLayers(self, self.net_arch, self.activation_fn, num_actions)

    def _build(self, lr_schedule: Schedule) -> None:
        super()._build(lr_schedule)
        self.action_net = nn.Identity()  # the extractor's last layer answers with logits
        last = self.mlp_extractor.policy_net[-1]
        self.init_weights(last, gain=0.01)
        self.optimizer = self.optimizer_class(self.parameters(), lr=lr_schedule(1), **self.optimizer_kwargs)  # type: ignore[call-arg]

    def _get_constructor_parameters(self) -> dict[str, Any]:
        own = {name: getattr(self, name) for name in ("scenario", "symmetric", "inputs", "reluctance")}
        return {**super()._get_constructor_parameters(), **own}
