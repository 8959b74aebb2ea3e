"""Names of algorithms and players, and which class of an algorithm takes which policy."""

import inspect

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
from lawn_sb3.experiment.evaluation import flies_alone
from lawn_sb3.experiment.find_policy import find_policy
from lawn_sb3.experiment.registry import ALGORITHMS, PLAYERS, algorithm_for, classes_of, find_algorithm, find_player
from lawn_sb3.experiment.settings import Bounds

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
    for other in {name for name in ALGORITHMS if not issubclass(policy, tuple(classes_of(name)))}:
        with pytest.raises(UserError, match=f"{policy.__name__} .* does not fit {other}: it is a policy for {algo}; "):
            find_algorithm(other, policy)


def test_a_policy_of_no_algorithm_is_refused_with_what_is_allowed() -> None:
    assert algorithm_for(SACPolicy) is None
    with pytest.raises(UserError, match=r"SACPolicy .* does not fit mappo; mappo takes .*MaskableActorCriticPolicy"):
        find_algorithm("mappo", SACPolicy)


GIVEN_BY_THE_KIT = {"self", "policy", "env", "seed", "tensorboard_log", "verbose", "_init_setup_model"}


def arguments_of(algorithm: type) -> set[str]:
    """Constructor arguments, those that a class hands on to the next included."""
    names: set[str] = set()
    for owner in (base for base in algorithm.__mro__ if "__init__" in vars(base)):
        parameters = inspect.signature(vars(owner)["__init__"]).parameters.values()
        handed_on = {one.name for one in parameters if one.kind in (one.VAR_POSITIONAL, one.VAR_KEYWORD)}
        names |= {one.name for one in parameters} - handed_on
        if not handed_on:
            break
    return names - GIVEN_BY_THE_KIT


@pytest.mark.parametrize("name", ALGORITHMS)
def test_what_is_known_of_an_algorithm_before_it_is_imported_is_what_its_classes_say(name: str) -> None:
    known, classes = ALGORITHMS[name], set(classes_of(name).values())
    assert known.settings == set().union(*(arguments_of(one) - getattr(one, "not_taken", set()) for one in classes))
    assert {one.continuation for one in classes} == {known.continuation}  # type: ignore[attr-defined]
    assert {getattr(one, "takes_crowds", False) for one in classes} == {known.takes_crowds}
    assert any(issubclass(find_policy(known.default_policy), base) for base in classes_of(name))


@pytest.mark.parametrize("name", PLAYERS)
def test_what_is_known_of_a_player_before_it_is_imported_is_what_its_class_says(name: str) -> None:
    player, known = find_player(name), PLAYERS[name]
    assert tuple(inspect.signature(type(player)).parameters) == known.settings
    assert flies_alone(player) == known.flies_alone


def test_every_setting_of_an_algorithm_has_bounds_and_no_other() -> None:
    assert set(Bounds.model_fields) == set().union(*(one.settings for one in ALGORITHMS.values()))
