"""Imitation: the actor first learns a planner's moves by cross-entropy, and is then improved by MAPPO."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import torch as th
from numpy.typing import NDArray
from stable_baselines3.common.type_aliases import GymEnv
from torch.nn import functional

from lawn_sb3.algos.mappo.episodes import EpisodeMAPPO
from lawn_sb3.algos.mappo.framed_policy import FramedPolicy
from lawn_sb3.algos.mappo.precision import networks_in
from lawn_sb3.envs.flatten import FlatVecEnv
from lawn_sb3.errors import unknown_name
from lawn_sb3.game.player import Player
from lawn_sb3.planning import BestRoutePlayer, ForecastPlayer, MeanFieldDestinationsPlayer, MeanFieldPlayer

TEACHERS: dict[str, Callable[[], Player]] = {
    "best-route": partial(BestRoutePlayer, slack=0),
    "forecast": ForecastPlayer,
    "mean-field": MeanFieldPlayer,
    "mean-field-destinations": MeanFieldDestinationsPlayer,
}
"""Planners whose moves can be learned: none sees more than an actor may be told, and all fly in time, without slack."""


class Imitate(EpisodeMAPPO):
    """MAPPO whose actor is first taught a planner's moves, on whole episodes that the planner flies.

    Takes what :class:`EpisodeMAPPO` takes. While it is taught, the critic learns the planner's returns already, so that
    the improvement that follows starts with a fair baseline.

    :param policy: the policy class
    :param env: from :func:`lawn_sb3.envs.make_vec_env` with ``continuation="episode"`` and one copy
    :param teacher: the planner, one of :data:`TEACHERS`
    :param taught_fraction: share of the training in which the planner is imitated
    :param kwargs: what else :class:`EpisodeMAPPO` takes
    :raises UserError: if there is no such planner
    """

    def __init__(
        self,
        policy: str | type[FramedPolicy],
        env: GymEnv | str,
        *,
        teacher: str = "mean-field",
        taught_fraction: float = 0.5,
        **kwargs: Any,
    ) -> None:
        if teacher not in TEACHERS:
            raise unknown_name("teacher", teacher, TEACHERS)
        if not 0.0 < taught_fraction <= 1.0:
            raise ValueError(f"taught_fraction = {taught_fraction}: above 0, at most 1")
        self.teacher, self.taught_fraction = teacher, taught_fraction
        self._planner: Player | None = None
        self._teaching = False
        super().__init__(policy, env, **kwargs)

    def collect_rollouts(self, *args: Any, **kwargs: Any) -> bool:
        """Play one episode of every game: the planner while it is imitated, and then the actor."""
        self._teaching = self.num_timesteps < self.taught_fraction * self._total_timesteps
        self._games_started = False
        return super().collect_rollouts(*args, **kwargs)

    def choose(self, obs: NDArray[np.float32], masks: NDArray[np.bool_], flying: NDArray[np.bool_]) -> Any:
        """The planner's moves while it is imitated; otherwise sampled ones.

        :param obs: flat observations of the UAVs in the air [R, flat_dim]
        :param masks: which actions are allowed [R, A]
        :param flying: who is in the air, of all UAVs [G * N]
        :return: actions [R], values [R] and log-probabilities [R]
        """
        if not self._teaching:
            return super().choose(obs, masks, flying)
        assert isinstance(self.env, FlatVecEnv)
        simulator = self.env.games[0].simulator
        if self._planner is None:
            self._planner = TEACHERS[self.teacher]()
        if not self._games_started:
            self._planner.start(simulator, np.random.default_rng(self.seed))
            self._games_started = True
        actions = self._planner.act(simulator).ravel()[flying]
        with th.no_grad():
            values = self.policy.predict_values(th.as_tensor(obs, device=self.device))
        return actions, values.cpu().numpy().ravel(), np.zeros(len(obs), dtype=np.float32)

    def train(self) -> None:
        """Update actor and critic: by cross-entropy and returns while the planner is imitated, then as PPO does."""
        if not self._teaching:
            super().train()
            return
        with networks_in(self.autocast, self.policy):
            self._learn_moves()

    def _learn_moves(self) -> None:
        """Update the actor by cross-entropy with the planner's moves, the critic by its returns."""
        self.policy.set_training_mode(True)
        self._update_learning_rate(self.policy.optimizer)
        buffer, head = self.rollout_buffer, self._value_head
        if head is not None:
            head.update(buffer.returns)
        losses, hits = [], []
        for _ in range(self.n_epochs):
            for batch in buffer.get(self.batch_size):
                actions = batch.actions.long().flatten()
                policy: Any = self.policy
                logits = policy.get_distribution(batch.observations, batch.action_masks).distribution.logits
                values = self.policy.predict_values(batch.observations).flatten()
                targets = batch.returns
                if head is not None:  # the buffer's returns are in normalised units
                    values = head.normalize(values)
                loss = functional.cross_entropy(logits, actions) + self.vf_coef * functional.mse_loss(values, targets)
                self.policy.optimizer.zero_grad()
                loss.backward()  # type: ignore[no-untyped-call]
                th.nn.utils.clip_grad_norm_(self.policy.parameters(), self.max_grad_norm)
                self.policy.optimizer.step()
                losses.append(loss.item())
                hits.append((logits.argmax(dim=1) == actions).float().mean().item())
        self._n_updates += self.n_epochs
        self.logger.record("train/imitation_loss", np.mean(losses))
        self.logger.record("train/imitation_percent", 100.0 * np.mean(hits))

    def _excluded_save_params(self) -> list[str]:
        return [*super()._excluded_save_params(), "_planner"]
