"""Which learner goes with which policy class: SB3's DQN with action values, sb3-contrib's QRDQN with quantiles."""

from sb3_contrib import QRDQN
from sb3_contrib.qrdqn.policies import QRDQNPolicy
from stable_baselines3 import DQN
from stable_baselines3.common.policies import BasePolicy
from stable_baselines3.dqn.policies import DQNPolicy

from lawn_sb3.algos.iql.double_dqn import DoubleDQN

Learner = DQN | QRDQN

LEARNERS: dict[type[BasePolicy], type[Learner]] = {DQNPolicy: DQN, QRDQNPolicy: QRDQN}
"""The policy classes that IQL takes, subclasses included, and what learns with each."""


def learner_class(policy_class: type[BasePolicy], double_q: bool = False) -> type[Learner]:
    """Find what learns with a policy class.

    :param policy_class: the policy class of each learner
    :param double_q: let the online network pick the next action that the target network judges
    :return: the class of the learners
    :raises ValueError: if nothing learns with such a policy, or nothing with a double-Q target
    """
    base = next((known for known in LEARNERS if issubclass(policy_class, known)), None)
    if base is None:
        allowed = " or ".join(f"{known.__module__}:{known.__name__}" for known in LEARNERS)
        raise ValueError(f"IQL has no learner for a {policy_class.__name__}: its policy must be a {allowed}")
    if double_q and base is not DQNPolicy:
        raise ValueError(
            f"double_q needs a policy that is a DQNPolicy: {policy_class.__name__} is a {base.__name__}, whose learner "
            f"{LEARNERS[base].__name__} has no double-Q target"
        )
    return DoubleDQN if double_q else LEARNERS[base]
