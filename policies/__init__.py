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
SB3's ``DQNPolicy``, sb3-contrib's ``QRDQNPolicy``  the constructor: widths, quantiles          IQL, one per UAV
==================================================  ==========================================  =====================

``FramedPolicy`` is a ``MaskableCTDEPolicy`` for ``algo: mappo-episodes`` and ``algo: imitate``; these take any other
``MaskableCTDEPolicy`` too. ``InTimeQMIXPolicy`` and ``InTimeQPolicy`` give QMIX and IQL the same frame and moves.

**Sees.** ``sees`` names what the actor sees besides o_i: ``clock`` (slots flown), ``memory`` (the loads of four slots),
``destinations`` (how many others in the air head for each cell), ``intents`` (the others' positions and destinations),
``index`` (which of the N UAVs it is, one-hot), ``state`` (all of x). The environment then appends it to o_i. What the
UAVs have to broadcast for it is in every Table II.

**Receives.** The constructor of a MAPPO or QMIX policy gets SB3's ``observation_space``, ``action_space`` and
``lr_schedule``, and ``layout``, an :class:`lawn_sb3.envs.ObservationLayout`, which the base class keeps as
``self.layout``; with ``needs_scenario = True`` also the ``scenario``; further arguments come from the setting
``policy_kwargs``. Then, one row per UAV and slot, each is handed what it may see and nothing else:

- ``actor_input(local)`` and QMIX's Q-network: o_i, followed by what else the policy sees;
- ``critic_input(local, state)``: the same, and x;
- a mixer, called as ``mixer(q, state)``: the Qs of a game's UAVs [B, N], and x;
- an IQL policy: o_i, followed by what else it sees.

``layout`` names the columns: ``local[:, self.layout.destination]``, ``local[:, self.layout.extra("clock")]``,
``state[:, self.layout.state_uavs]``. Whoever changes what it was handed changes a clone of it.

**Gives.** Logits [B, A] and values [B, 1] (MAPPO), action values [B, A] (QMIX, DQN) or quantiles [B, n, A] (QRDQN); a
mixer gives [B]. All are finite, but for an action that the actor rules out, whose logit may be minus infinity; a slot's
answer depends on its own row alone. A few real observations try this out before training and once more after it, and
also whether anything that the actor answers changes by a single bit when x does, as it may only in a policy
that sees ``state``. A policy that fails is refused in one line.

**Named** by its file, by ``package.module:Class``, or by the name under which another package registers it in the
entry-point group ``lawn_sb3.policies``. **Saved and loaded** as in SB3: the model's zip holds the ``state_dict`` of the
policy, so whatever is to be kept must be a parameter or a buffer. The networks are built anew from the run's
configuration before they are loaded: the file must still be there, and it and those of your own modules that it imports
unchanged, or the run counts as another.
"""
