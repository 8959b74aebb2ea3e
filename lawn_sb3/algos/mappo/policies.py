"""Actor-critics for centralised training and decentralised execution: the actor sees o_i.

What the critic sees is for a subclass to say. The flat observation is cut up here, for all of them: a subclass is
handed what its actor may see, and for its critic x besides.
"""

from typing import Any, ClassVar

import torch as th
from gymnasium import spaces
from sb3_contrib.common.maskable.policies import MaskableActorCriticPolicy
from stable_baselines3.common.policies import ActorCriticPolicy, BasePolicy
from stable_baselines3.common.torch_layers import create_mlp
from stable_baselines3.common.type_aliases import Schedule
from torch import nn

from lawn_sb3.algos.mappo.value_normalization import NormalizedValueHead
from lawn_sb3.envs.observation import ObservationLayout, Sight


class ActorCriticExtractor(nn.Module):
    """Hidden layers of actor and critic, each fed by its own view of the flat observation.

    :param policy: the policy, which says who sees what
    :param net_arch: widths of the hidden layers of the actor (``pi``) and of the critic (``vf``)
    :param activation_fn: activation of the hidden layers
    :param actor_ends: widths of what the actor's layers are given and answer with, if these are not its view and a
        hidden layer
    """

    def __init__(
        self,
        policy: "CTDEViews",
        net_arch: dict[str, list[int]],
        activation_fn: type[nn.Module],
        actor_ends: tuple[int, int] | None = None,
    ) -> None:
        super().__init__()
        # Bound methods in a plain tuple: the policy must not become a submodule of its own part.
        self._views = (policy.actor_view, policy.critic_view)
        seen_by_actor, seen_by_critic = (view(th.zeros(1, policy.layout.flat_dim)).shape[1] for view in self._views)
        given, answer = actor_ends or (seen_by_actor, -1)
        self.policy_net = nn.Sequential(*create_mlp(given, answer, net_arch["pi"], activation_fn))
        self.value_net = nn.Sequential(*create_mlp(seen_by_critic, -1, net_arch["vf"], activation_fn))
        self.latent_dim_pi = actor_ends[1] if actor_ends else [given, *net_arch["pi"]][-1]
        self.latent_dim_vf = [seen_by_critic, *net_arch["vf"]][-1]

    def forward(self, flat: th.Tensor) -> tuple[th.Tensor, th.Tensor]:
        """Features of the actor [B, latent_dim_pi] and of the critic [B, latent_dim_vf]."""
        return self.forward_actor(flat), self.forward_critic(flat)

    def forward_actor(self, flat: th.Tensor) -> th.Tensor:
        """The actor's features [B, latent_dim_pi] of flat observations [B, flat_dim]."""
        out: th.Tensor = self.policy_net(self._views[0](flat))
        return out

    def forward_critic(self, flat: th.Tensor) -> th.Tensor:
        """The critic's features [B, latent_dim_vf] of flat observations [B, flat_dim]."""
        out: th.Tensor = self.value_net(self._views[1](flat))
        return out


class CTDEViews(BasePolicy):
    """Mixin for an actor-critic of SB3 or sb3-contrib over the flat observation [o_i | x]: the actor sees o_i.

    Subclasses override :meth:`critic_input`, and :meth:`actor_input` if the actor is to see less, or something else
    made of o_i. Networks are the paper's by default: two hidden layers of 256 ReLU units each.

    :param observation_space: the flat observation
    :param action_space: the actions
    :param lr_schedule: learning rate as a function of the progress remaining
    :param layout: where o_i and x lie in the flat observation
    :param net_arch: widths of the hidden layers, for both or for the actor (``pi``) and the critic (``vf``)
    :param activation_fn: activation of the hidden layers
    :param kwargs: what else that actor-critic takes
    """

    sees: ClassVar[tuple[Sight, ...]] = ()
    """What the actor sees besides o_i; nothing else can reach it."""

    needs_scenario: ClassVar[bool] = False
    """Whether its constructor takes the environment's ``scenario`` too."""

    net_arch: list[int] | dict[str, list[int]]
    activation_fn: type[nn.Module]
    mlp_extractor: Any
    value_net: Any

    def __init__(
        self,
        observation_space: spaces.Box,
        action_space: spaces.Discrete,
        lr_schedule: Schedule,
        layout: ObservationLayout,
        net_arch: list[int] | dict[str, list[int]] | None = None,
        activation_fn: type[nn.Module] = nn.ReLU,
        **kwargs: Any,
    ) -> None:
        self.layout = layout
        net_arch = [256, 256] if net_arch is None else net_arch
        widths = net_arch if isinstance(net_arch, dict) else {"pi": net_arch, "vf": net_arch}
        super().__init__(observation_space, action_space, lr_schedule, widths, activation_fn, **kwargs)
        self.value_net = NormalizedValueHead(self.value_net)

    def actor_view(self, flat: th.Tensor) -> th.Tensor:
        """What :meth:`actor_input` makes of the columns that the policy ``sees`` of flat observations [B, flat_dim]."""
        return self.actor_input(flat[:, self.layout.seen(self.sees)])

    def critic_view(self, flat: th.Tensor) -> th.Tensor:
        """What :meth:`critic_input` makes of the same columns and of x."""
        return self.critic_input(flat[:, self.layout.seen(self.sees)], flat[:, self.layout.state])

    def actor_input(self, local: th.Tensor) -> th.Tensor:
        """What the actor makes of what it sees: all of it, as it is.

        :param local: local observations o_i, followed by what else the policy ``sees`` [B, at least local_dim]
        :return: the actor's input [B, anything]
        """
        return local

    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        """What the critic makes of what the actor sees and of x.

        :param local: local observations o_i, followed by what else the policy ``sees`` [B, at least local_dim]
        :param state: global states x [B, state_dim]
        :return: the critic's input [B, anything]
        """
        raise NotImplementedError(f"{type(self).__name__} does not say what its critic sees: override critic_input")

    def _build_mlp_extractor(self) -> None:
        assert isinstance(self.net_arch, dict)
        self.mlp_extractor = ActorCriticExtractor(self, self.net_arch, self.activation_fn)

    def _get_constructor_parameters(self) -> dict[str, Any]:
        return {**super()._get_constructor_parameters(), "layout": self.layout}


class CTDEPolicy(CTDEViews, ActorCriticPolicy):
    """SB3's actor-critic with an actor that sees o_i alone: what most policies derive from."""


class MaskableCTDEPolicy(CTDEViews, MaskableActorCriticPolicy):
    """The same for sb3-contrib's actor-critic, which takes masks of the actions too."""
