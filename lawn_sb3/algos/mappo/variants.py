"""CTDE-MAPPO on sb3-contrib's relatives of PPO: with masked actions, and with memory."""

from typing import Any

from sb3_contrib import MaskablePPO, RecurrentPPO

from lawn_sb3.algos.mappo.centralized_training import CentralizedTraining
from lawn_sb3.algos.mappo.value_normalization import NormalizedMaskableBuffer, NormalizedRecurrentBuffer


class MaskableMAPPO(CentralizedTraining, MaskablePPO):
    """MAPPO that never takes a move out of the airspace: the environment says which moves stay inside.

    Takes what sb3-contrib's ``MaskablePPO`` takes, and what :class:`MAPPO` adds: an entropy coefficient that may be a
    schedule, and ``normalize_value``. ``predict`` needs the ``action_masks`` of the slots.
    """

    default_buffer_class = NormalizedMaskableBuffer


class RecurrentMAPPO(CentralizedTraining, RecurrentPPO):
    """MAPPO whose policy remembers what it saw of the mission so far.

    Takes what sb3-contrib's ``RecurrentPPO`` takes, and what :class:`MAPPO` adds: an entropy coefficient that may be a
    schedule, ``normalize_value`` and ``rollout_buffer_class``.
    """

    default_buffer_class = NormalizedRecurrentBuffer

    def _setup_model(self) -> None:
        super()._setup_model()
        made: Any = self.rollout_buffer  # sb3-contrib lets nobody choose its class
        buffer_class: Any = self.rollout_buffer_class
        self.rollout_buffer = buffer_class(
            made.buffer_size,
            made.observation_space,
            made.action_space,
            made.hidden_state_shape,
            self.device,
            gamma=made.gamma,
            gae_lambda=made.gae_lambda,
            n_envs=made.n_envs,
        )
        if self._value_head is not None:
            self.rollout_buffer.value_head = self._value_head  # type: ignore[attr-defined]

    def memory(self) -> Any:
        """What is not saved with the model: the states of the LSTM."""
        return self._last_lstm_states

    def restore_memory(self, memory: Any) -> None:
        """Take back what :meth:`memory` returned."""
        self._last_lstm_states = memory
