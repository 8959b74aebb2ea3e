"""CTDE-MAPPO (Algorithm 1): SB3's PPO over flattened games, with a centralised critic and value normalisation."""

from stable_baselines3 import PPO

from lawn_sb3.algos.mappo.centralized_training import CentralizedTraining
from lawn_sb3.algos.mappo.value_normalization import NormalizedRolloutBuffer


class MAPPO(CentralizedTraining, PPO):
    """PPO whose policy class decides what the critic reads.

    Takes what SB3's ``PPO`` takes, with the same defaults. In the paper's words ``n_steps`` is the rollout length L in
    slots, ``batch_size`` the minibatch in agent steps, ``n_epochs`` the update epochs K per rollout, ``gae_lambda`` the
    lambda of Eq. (19), ``clip_range`` the epsilon of Eq. (21), eq:ppo_clip, and ``vf_coef`` the weight of
    Eq. (22), eq:critic_loss. ``clip_range_vf`` is in normalised units. What
    :class:`CentralizedTraining` adds is given by keyword.
    """

    default_buffer_class = NormalizedRolloutBuffer
