"""An actor with memory: an LSTM over what it sees of its mission, beside a critic without one."""

from collections.abc import Callable
from typing import Any

import torch as th
from gymnasium import spaces
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor, create_mlp
from stable_baselines3.common.type_aliases import Schedule
from torch import nn

from lawn_sb3.algos.mappo.policies import CTDEViews


class View(BaseFeaturesExtractor):
    """What one of the two networks sees of the flat observation.

    :param observation_space: the flat observation
    :param view: takes flat observations [B, flat_dim], gives what is seen of them [B, F]
    """

    def __init__(self, observation_space: spaces.Box, view: Callable[[th.Tensor], th.Tensor]) -> None:
        super().__init__(observation_space, view(th.zeros(1, *observation_space.shape)).shape[1])
        self._view = view

    def forward(self, flat: th.Tensor) -> th.Tensor:
        """What is seen [B, F] of flat observations [B, flat_dim]."""
        return self._view(flat)


class LayersAfterMemory(nn.Module):
    """The actor's hidden layers after its LSTM, and all of the critic's.

    :param actor_dim: units of the LSTM
    :param critic_dim: length of the critic's input
    :param net_arch: widths of the hidden layers of the actor (``pi``) and of the critic (``vf``)
    :param activation_fn: activation of the hidden layers
    """

    def __init__(
        self, actor_dim: int, critic_dim: int, net_arch: dict[str, list[int]], activation_fn: type[nn.Module]
    ) -> None:
        super().__init__()
        self.forward_actor = nn.Sequential(*create_mlp(actor_dim, -1, net_arch["pi"], activation_fn))
        self.forward_critic = nn.Sequential(*create_mlp(critic_dim, -1, net_arch["vf"], activation_fn))
        self.latent_dim_pi = net_arch["pi"][-1] if net_arch["pi"] else actor_dim
        self.latent_dim_vf = net_arch["vf"][-1] if net_arch["vf"] else critic_dim


class RecurrentCTDEPolicy(CTDEViews, RecurrentActorCriticPolicy):
    """sb3-contrib's recurrent actor-critic: an LSTM over ``actor_input``, no memory over ``critic_input``.

    By default as deep and wide as the others: an LSTM of 256 units and a hidden layer of 256 ReLU units in the actor,
    two such layers in the critic.

    :param observation_space: the flat observation
    :param action_space: the actions
    :param lr_schedule: learning rate as a function of the progress remaining
    :param net_arch: widths of the hidden layers, for both or for the actor (``pi``, after its LSTM) and the critic
        (``vf``)
    :param kwargs: what else :class:`CTDEViews` and sb3-contrib's ``RecurrentActorCriticPolicy`` take
    """

    def __init__(
        self,
        observation_space: spaces.Box,
        action_space: spaces.Discrete,
        lr_schedule: Schedule,
        net_arch: list[int] | dict[str, list[int]] | None = None,
        **kwargs: Any,
    ) -> None:
        net_arch = {"pi": [256], "vf": [256, 256]} if net_arch is None else net_arch
        kwargs |= {"share_features_extractor": False, "enable_critic_lstm": False}
        super().__init__(observation_space, action_space, lr_schedule, net_arch=net_arch, **kwargs)
        # sb3-contrib gives both networks the same features; here each has its own view.
        self.pi_features_extractor = View(observation_space, self.actor_view)
        self.vf_features_extractor = View(observation_space, self.critic_view)
        layers, _, units = self.lstm_hidden_state_shape
        self.lstm_actor = nn.LSTM(self.pi_features_extractor.features_dim, units, layers, **self.lstm_kwargs)
        self.critic = nn.Identity()  # type: ignore[assignment]
        self.optimizer = self.optimizer_class(self.parameters(), lr=lr_schedule(1), **self.optimizer_kwargs)  # type: ignore[call-arg]

    def _build_mlp_extractor(self) -> None:
        assert isinstance(self.net_arch, dict)
        critic_dim = self.critic_view(th.zeros(1, self.layout.flat_dim)).shape[1]
        self.mlp_extractor = LayersAfterMemory(self.lstm_output_dim, critic_dim, self.net_arch, self.activation_fn)
