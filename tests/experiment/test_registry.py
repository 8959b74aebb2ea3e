"""Names of algorithms and players, and which class of an algorithm takes which policy."""

import pytest
from sb3_contrib.qrdqn.policies import QRDQNPolicy
from stable_baselines3.common.policies import ActorCriticPolicy, BasePolicy
from stable_baselines3.dqn.policies import DQNPolicy
from stable_baselines3.sac.policies import SACPolicy

from lawn_sb3.algos.iql import IQL
from lawn_sb3.algos.mappo import (
    MAPPO,
    CTDEPolicy,
    MaskableCTDEPolicy,
    MaskableMAPPO,
    RecurrentCTDEPolicy,
    RecurrentMAPPO,
)
from lawn_sb3.algos.qmix import QMIX, QMIXPolicy
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.registry import ALGORITHMS, algorithm_for, find_algorithm, find_player
from lawn_sb3.experiment.settings import accepted_settings

FITS: dict[type[BasePolicy], tuple[str, type]] = {
    ActorCriticPolicy: ("mappo", MAPPO),
    CTDEPolicy: ("mappo", MAPPO),
    MaskableCTDEPolicy: ("mappo", MaskableMAPPO),
    RecurrentCTDEPolicy: ("mappo", RecurrentMAPPO),
    DQNPolicy: ("iql", IQL),
    QRDQNPolicy: ("iql", IQL),
    QMIXPolicy: ("qmix", QMIX),
}


def test_unknown_algorithms_and_players_are_refused() -> None:
    with pytest.raises(UserError, match="did you mean 'mappo'"):
        find_algorithm("mapo", ActorCriticPolicy)
    with pytest.raises(UserError, match="did you mean 'random'"):
        find_player("randon")


@pytest.mark.parametrize("policy", FITS)
def test_the_base_class_of_a_policy_decides_what_trains_it(policy: type[BasePolicy]) -> None:
    algo, expected = FITS[policy]
    assert algorithm_for(policy) == algo
    assert find_algorithm(algo, policy) is expected


@pytest.mark.parametrize("policy", FITS)
def test_another_algorithm_refuses_it_and_says_whose_it_is(policy: type[BasePolicy]) -> None:
    algo = FITS[policy][0]
    for other in {name for name in ALGORITHMS if not issubclass(policy, tuple(ALGORITHMS[name]))}:
        with pytest.raises(UserError, match=f"{policy.__name__} .* does not fit {other}: it is a policy for {algo}; "):
            find_algorithm(other, policy)


def test_a_policy_of_no_algorithm_is_refused_with_what_is_allowed() -> None:
    assert algorithm_for(SACPolicy) is None
    with pytest.raises(UserError, match=r"SACPolicy .* does not fit mappo; mappo takes .*MaskableActorCriticPolicy"):
        find_algorithm("mappo", SACPolicy)


def test_settings_are_those_of_the_constructors_and_of_what_they_hand_on_to() -> None:
    """``normalize_value`` is MAPPO's own, ``clip_range`` SB3's; of DQN's settings IQL and QMIX refuse some."""
    assert {"clip_range", "use_sde", "normalize_value", "ent_coef", "n_steps"} <= accepted_settings("mappo")
    assert {"double_q", "share_parameters", "n_steps", "max_grad_norm"} <= accepted_settings("iql")
    assert {"double_q", "target_update_interval"} <= accepted_settings("qmix")
    for name in ALGORITHMS:
        assert not {"args", "kwargs", "self", "optimize_memory_usage"} & accepted_settings(name)
    assert not {"clip_range", "use_sde", "n_steps"} & accepted_settings("qmix")
