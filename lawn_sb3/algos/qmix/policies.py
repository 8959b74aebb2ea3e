"""Value networks for centralised training and decentralised execution: each UAV is greedy in a Q over its own o_i.

How the Qs of a game are mixed into one value during training is for a subclass to say.
"""

import copy
from typing import Any, ClassVar

import torch as th
from gymnasium import spaces
from stable_baselines3.common.policies import BasePolicy
from stable_baselines3.common.torch_layers import create_mlp
from stable_baselines3.common.type_aliases import PyTorchObs, Schedule
from torch import nn

from lawn_sb3.algos.common.in_time import InTimeQ, InTimeValues
from lawn_sb3.envs.observation import ObservationLayout, Sight


class QMIXPolicy(BasePolicy):
    """A Q-network over o_i that the UAVs share, a mixer of their Qs, and target copies of both.

    Subclasses override :meth:`make_mixer`. The Q-network has two hidden layers of 256 ReLU units by default, as the
    paper's networks. Acting reads o_i alone; the mixer is for training.

    :param observation_space: the flat observation
    :param action_space: the actions
    :param lr_schedule: learning rate as a function of the progress remaining
    :param layout: where o_i and x lie in the flat observation
    :param net_arch: widths of the Q-network's hidden layers
    :param activation_fn: activation of the hidden layers
    :param optimizer_class: the optimiser
    :param optimizer_kwargs: its arguments but the learning rate
    """

    sees: ClassVar[tuple[Sight, ...]] = ()
    """What the Q-network sees besides o_i."""
    needs_scenario: ClassVar[bool] = False
    """Whether its constructor takes the environment's ``scenario`` and ``slack`` too."""

    action_space: spaces.Discrete

    def __init__(
        self,
        observation_space: spaces.Box,
        action_space: spaces.Discrete,
        lr_schedule: Schedule,
        layout: ObservationLayout,
        net_arch: list[int] | None = None,
        activation_fn: type[nn.Module] = nn.ReLU,
        optimizer_class: type[th.optim.Optimizer] = th.optim.Adam,
        optimizer_kwargs: dict[str, Any] | None = None,
    ) -> None:
        super().__init__(
            observation_space, action_space, optimizer_class=optimizer_class, optimizer_kwargs=optimizer_kwargs
        )
        self.layout = layout
        self.net_arch = [256, 256] if net_arch is None else net_arch
        self.activation_fn = activation_fn
        num_actions = int(action_space.n)
        self.q_net = self.make_q_net(num_actions)
        self.mixer = self.make_mixer()
        self.q_net_target = copy.deepcopy(self.q_net).requires_grad_(False)
        self.mixer_target = copy.deepcopy(self.mixer).requires_grad_(False)
        self.optimizer = optimizer_class(self.trained_parameters(), lr=lr_schedule(1), **self.optimizer_kwargs)  # type: ignore[call-arg]

    def make_q_net(self, num_actions: int) -> nn.Module:
        """Build the Q-network, from what a UAV sees [B, anything] to action values [B, A]."""
        seen = self.layout.seen(self.sees)
        return nn.Sequential(*create_mlp(seen.stop, num_actions, self.net_arch, self.activation_fn))

    def seen(self, flat: th.Tensor) -> th.Tensor:
        """What the Q-network is handed of flat observations [B, flat_dim]: o_i, then what else the policy ``sees``."""
        return flat[:, self.layout.seen(self.sees)]

    def action_values(self, flat: th.Tensor) -> th.Tensor:
        """Each UAV's own Qs [B, A], of flat observations [B, flat_dim]."""
        values: th.Tensor = self.q_net(self.seen(flat))
        return values

    def allowed(self, local: th.Tensor) -> th.Tensor | None:
        """Which moves may be taken at all [B, A], by what is seen [B, at least local_dim]; none if all may."""
        return None

    def make_mixer(self) -> nn.Module:
        """Build the mixer, called as ``mixer(q, x)`` with Qs [B, N] and global states [B, state_dim].

        :return: a module that answers with the games' values [B]
        """
        raise NotImplementedError(f"{type(self).__name__} does not say how Qs are mixed: override make_mixer")

    def trained_parameters(self) -> list[nn.Parameter]:
        """What the optimiser moves: the Q-network and the mixer, not their targets."""
        return [*self.q_net.parameters(), *self.mixer.parameters()]

    def target_parameters(self) -> list[nn.Parameter]:
        """The target copies of :meth:`trained_parameters`, in the same order."""
        return [*self.q_net_target.parameters(), *self.mixer_target.parameters()]

    def game_values(
        self, local: th.Tensor, state: th.Tensor, actions: th.Tensor, flying: th.Tensor, target: bool = False
    ) -> th.Tensor:
        """Values of games: the mix of the Qs of the UAVs that fly.

        The Q of a UAV that does not fly is 0 in the mix, and is never computed.

        :param local: local observations and what else is seen [B, N, anything]
        :param state: global states [B, state_dim]
        :param actions: joint actions [B, N]
        :param flying: who is flying [B, N]
        :param target: ask the target networks
        :return: [B]
        """
        q_net, mixer = (self.q_net_target, self.mixer_target) if target else (self.q_net, self.mixer)
        chosen = local.new_zeros(flying.shape)
        chosen[flying] = q_net(local[flying]).gather(1, actions[flying][:, None])[:, 0]
        values: th.Tensor = mixer(chosen, state)
        return values

    def greedy_actions(self, local: th.Tensor, flying: th.Tensor, target: bool = False) -> th.Tensor:
        """Each UAV's best action by its own Q.

        :param local: local observations and what else is seen [B, N, anything]
        :param flying: who is flying [B, N]; the others get action 0
        :param target: ask the target network
        :return: [B, N]
        """
        actions = th.zeros(flying.shape, dtype=th.long, device=local.device)
        actions[flying] = (self.q_net_target if target else self.q_net)(local[flying]).argmax(dim=1)
        return actions

    def forward(self, obs: th.Tensor, deterministic: bool = True) -> th.Tensor:
        """Greedy actions [B] for flat observations [B, flat_dim]; exploring is the algorithm's."""
        return self._predict(obs, deterministic)

    def _predict(self, observation: PyTorchObs, deterministic: bool = False) -> th.Tensor:
        assert isinstance(observation, th.Tensor)
        return self.action_values(observation).argmax(dim=1)

    def _get_constructor_parameters(self) -> dict[str, Any]:
        return {
            "observation_space": self.observation_space,
            "action_space": self.action_space,
            "lr_schedule": self._dummy_schedule,  # not needed to act
            "layout": self.layout,
            "net_arch": self.net_arch,
            "activation_fn": self.activation_fn,
            "optimizer_class": self.optimizer_class,
            "optimizer_kwargs": self.optimizer_kwargs,
        }


class InTimeQMIXPolicy(InTimeValues, QMIXPolicy):
    """The same with a Q-network over o_i and the clock in the symmetric frame, whose moves are in time.

    Takes what :class:`QMIXPolicy` takes, and what :class:`InTimeValues` and its base do.
    """

    def make_q_net(self, num_actions: int) -> InTimeQ:
        """Build the Q-network."""
        return self.make_layers(num_actions)
