"""Networks that can be swapped: one file, one policy class; ``--policy NAME`` finds ``policies/NAME.py``.

What a policy class derives from says which algorithm trains it:

==================================================  ==========================================  =====================
base class                                          what a policy overrides                     trained by
==================================================  ==========================================  =====================
``lawn_sb3.algos.mappo.CTDEPolicy``                 ``critic_input``, ``actor_input``           MAPPO on PPO
``lawn_sb3.algos.mappo.MaskableCTDEPolicy``         the same; impossible moves are masked       MAPPO on MaskablePPO
``lawn_sb3.algos.mappo.RecurrentCTDEPolicy``        the same; an LSTM follows ``actor_input``   MAPPO on RecurrentPPO
``lawn_sb3.algos.mappo.FramedPolicy``               ``sees``, ``looks_at_loads``                MAPPO on whole games
``lawn_sb3.algos.qmix.QMIXPolicy``                  ``make_mixer``                              QMIX
SB3's ``DQNPolicy``, sb3-contrib's ``QRDQNPolicy``  the constructor: widths, quantiles          IQL, one a UAV
==================================================  ==========================================  =====================

``FramedPolicy`` is a ``MaskableCTDEPolicy`` for ``algo: mappo-episodes`` and ``algo: imitate``; these take any other
``MaskableCTDEPolicy`` too. ``InTimeQMIXPolicy`` and ``InTimeQPolicy`` give QMIX and IQL the same frame and moves.

**Sees.** ``sees`` names what the actor sees besides o_i: ``clock`` (slots flown), ``memory`` (the loads of four slots),
``destinations`` (how many others in the air head for each cell), ``intents`` (the others' positions and destinations),
``state`` (all of x). The environment then appends it to o_i, and ``actor_input(local)`` is handed these columns alone;
nothing else can reach the actor. What the UAVs have to broadcast for it is in every Table II.

**Receives.** The constructor of a MAPPO or QMIX policy gets SB3's ``observation_space``, ``action_space`` and
``lr_schedule``, and ``layout``, an :class:`lawn_sb3.envs.ObservationLayout`, which the base class keeps as
``self.layout``; with ``needs_scenario = True`` also the ``scenario``; further arguments come from the setting
``policy_kwargs``. Every slot's observation is the flat vector [o_i | what else it sees | x]; ``flat[:,
self.layout.local]`` is o_i, ``flat[:, self.layout.state]`` is x, and ``layout`` names all their parts. A policy with
``needs_index = True`` finds the UAV's index, one-hot, in ``flat[:, self.layout.index]``. An IQL policy gets o_i alone.

**Gives.** Logits [B, A] and values [B, 1] (MAPPO), action values [B, A] (QMIX, DQN) or quantiles [B, n, A] (QRDQN); a
mixer, called with Qs [B, N] and states [B, state_dim], gives [B]. All are finite; a slot's answer depends on its own
row alone; the actor does not read x, unless it says that it sees ``state``. All this is tried out before training and
once more after it: x is replaced by other values, and no answer of the actor may change in a single bit. A policy that
fails is refused in one line.

**Named** by its file, by ``package.module:Class``, or by the name under which another package registers it in the
entry-point group ``lawn_sb3.policies``. **Saved and loaded** as in SB3: the model's zip holds the ``state_dict`` of the
policy, so whatever is to be kept must be a parameter or a buffer. The networks are built anew from the run's
configuration before they are loaded: the file must still be there, and unchanged, or the run counts as another.
"""
