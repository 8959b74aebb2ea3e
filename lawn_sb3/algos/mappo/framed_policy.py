"""Actor-critics in the symmetric frame: what is seen is turned into one octant, and the logits are turned back.

What an actor sees besides o_i is for a subclass to say, and so whether it looks at the cell loads; the critic sees o_i,
the clock, and all others as they lie around the UAV.
"""

from typing import Any, ClassVar

import torch as th
from gymnasium import spaces
from stable_baselines3.common.type_aliases import Schedule
from torch import nn

from lawn_sb3.algos.common.framed import Framed
from lawn_sb3.algos.common.in_time import in_time
from lawn_sb3.algos.mappo.policies import ActorCriticExtractor, MaskableCTDEPolicy
from lawn_sb3.envs.observation import OWN, Sight


class FramedLayers(ActorCriticExtractor):
    """All layers of the actor, whose logits are in the order of the actions, and the critic's hidden layers.

    :param policy: the policy, which says what is seen
    :param net_arch: as for :class:`ActorCriticExtractor`, as is ``activation_fn``
    :param num_actions: A
    """

    encoder: Any
    """As the policy's ``make_encoder`` gives it."""

    def __init__(
        self, policy: "FramedPolicy", net_arch: dict[str, list[int]], activation_fn: type[nn.Module], num_actions: int
    ) -> None:
        encoder = policy.make_encoder(policy.sees, policy.looks_at_loads)
        super().__init__(policy, net_arch, activation_fn, (encoder.width, num_actions))
        self.encoder, self.scenario = encoder, policy.scenario
        self.reluctance = nn.Parameter(th.tensor(float(policy.reluctance))) if policy.reluctance else None

    def forward_actor(self, flat: th.Tensor) -> th.Tensor:
        """Logits [B, A] of what the policy sees of flat observations [B, flat_dim]."""
        seen = self._views[0](flat)
        features, turn = self.encoder(seen)
        logits: th.Tensor = self.encoder.turn_back(self.turned_logits(features), turn)
        if self.reluctance is None:
            return logits
        return logits - self.reluctance * ~in_time(self.scenario, self.encoder.layout, seen, slack=0)

    def turned_logits(self, features: th.Tensor) -> th.Tensor:
        """Logits of the turned moves [B, A], of encoded features [B, width]."""
        logits: th.Tensor = self.policy_net(features)
        return logits


class FramedPolicy(Framed, MaskableCTDEPolicy):
    """An actor over o_i and what else it ``sees``, in the symmetric frame; moves are masked.

    :param args: what sb3-contrib's ``MaskableActorCriticPolicy`` takes, as ``kwargs`` and what :class:`Framed` takes
    :param reluctance: what an untrained actor takes off the logits of moves that use up slack, so that it starts from
        flights without a detour in time; trained like a weight; 0 for none
    """

    looks_at_loads: ClassVar[bool] = True
    """Whether the actor looks at the cell loads that o_i holds, and at the EMA rate that they leave."""
    layers_class: ClassVar[type[FramedLayers]] = FramedLayers

    def __init__(self, *args: Any, reluctance: float = 0.0, **kwargs: Any) -> None:
        self.reluctance = reluctance
        super().__init__(*args, **kwargs)

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
        place = encoder.turned(encoder.voxels(local[:, layout.position]), turn)
        return th.cat([own, *(part.float() for part in encoder.others(places, place, turn))], dim=1)

    def make_critic_encoder(self) -> Any:
        """How o_i and the clock, if the actor sees it, are put to the critic."""
        clock: list[Sight] = [extra for extra in self.layout.extras if extra == "clock"]
        return self.make_encoder(clock)

    def _build_mlp_extractor(self) -> None:
        assert isinstance(self.net_arch, dict)
        assert isinstance(self.action_space, spaces.Discrete)
        self.critic_encoder = self.make_critic_encoder()
        num_actions = int(self.action_space.n)
        self.mlp_extractor = self.layers_class(self, self.net_arch, self.activation_fn, num_actions)

    def _build(self, lr_schedule: Schedule) -> None:
        super()._build(lr_schedule)
        self.action_net = nn.Identity()  # the extractor's last layer answers with logits
        last = self.mlp_extractor.policy_net[-1]
        self.init_weights(last, gain=0.01)
        self.optimizer = self.optimizer_class(self.parameters(), lr=lr_schedule(1), **self.optimizer_kwargs)  # type: ignore[call-arg]

    def _get_constructor_parameters(self) -> dict[str, Any]:
        return {**super()._get_constructor_parameters(), "reluctance": self.reluctance}
