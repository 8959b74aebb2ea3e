"""What a recipe must keep that depends on algorithms, players and policies, told before anything runs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from lawn_sb3.envs.observation import NOT_BY_N
from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.experiment.find_policy import find_policy
from lawn_sb3.experiment.registry import ALGORITHMS, PLAYERS, find_algorithm, trait
from lawn_sb3.experiment.settings import constructor_arguments
from lawn_sb3.game.simulator import check_fewest

if TYPE_CHECKING:
    from lawn_sb3.experiment.recipe import Method, Recipe

SHARED = "shared network"


def check_method(method: Method) -> None:
    """Refuse a method that no algorithm or player can carry out; its policy is not looked at.

    :param method: the method
    :raises ValueError: one line that names the method and what is allowed
    """
    what = f"method {method.label!r}"
    if (method.player is None) == (method.algo is None):
        raise ValueError(f"{what} needs either a player or an algo")
    if method.player is not None:
        if method.player not in PLAYERS:
            raise unknown_name("player", method.player, PLAYERS)
        more = sorted(method.model_dump(exclude={"label", "paper_row", "player"}, exclude_defaults=True))
        if more:
            raise ValueError(f"{what} is a player without training: no {', '.join(more)}")
        return
    assert method.algo is not None
    if method.algo not in ALGORITHMS:
        raise unknown_name("algorithm", method.algo, ALGORITHMS)
    if method.env_steps < 1:
        raise ValueError(f"{what} trains and needs env_steps of at least 1")
    needed = trait(method.algo, "continuation")
    if method.continuation != needed:
        raise ValueError(f"{what}: {method.algo} trains with continuation {needed}")
    if method.credit == "team" and method.algo != "mappo-episodes":
        raise ValueError(f"{what}: credit team needs mappo-episodes, where games are whole")
    if method.fewest_uavs is not None:
        if not trait(method.algo, "takes_crowds", False):
            raise ValueError(f"{what}: fewest_uavs needs mappo-episodes or imitate, where games are whole")
        if method.credit == "team":
            raise ValueError(f"{what}: credit team needs the same number of UAVs in every game")
    constructor_arguments(method.algo, method.settings)


def check_policy_fits(method: Method) -> None:
    """Find a method's policy, and refuse it if its algorithm does not take it.

    :param method: the method
    :raises UserError: if there is no such policy, or it is for another algorithm
    """
    if method.algo is not None and method.policy is not None:
        find_algorithm(method.algo, find_policy(method.policy))


def check_recipe(recipe: Recipe) -> None:
    """Refuse a recipe whose methods cannot be trained on its games or scaled out, or are not what their labels say.

    :param recipe: the recipe
    :raises UserError: one line that names what is wrong, where, and what is allowed
    """
    games = [variant.game() for variant in recipe.split().values()]
    for key, method in recipe.methods.items():
        for game in games if method.fewest_uavs is not None else ():
            try:
                check_fewest(method.fewest_uavs or 1, game, method.continuation)
            except UserError as error:
                raise UserError(f"methods.{key}: {error}") from None
        check_policy_fits(method)
        if honest_label(method.label, method.settings) != method.label:
            raise UserError(
                f"methods.{key}: label = {method.label!r}: say {SHARED!r}, as IQL's learners have one there"
            )
    for num_uavs in recipe.scaling.num_uavs if recipe.scaling else ():
        recipe.game().changed(num_uavs=num_uavs)
    for key in recipe.scaling.methods if recipe.scaling else ():
        if not fits_any_num_uavs(recipe.methods[key]):
            raise UserError(
                f"scaling: method {key!r} has networks for single UAVs, and cannot be flown with other numbers of them"
            )


def honest_label(label: str, settings: Mapping[str, Any]) -> str:
    """A label that says so where IQL's learners share a network and are thus not independent.

    :param label: the label
    :param settings: settings of the method
    :return: the label, with ``shared network`` at its end if that is missing
    """
    return f"{label}, {SHARED}" if settings.get("share_parameters") and SHARED not in label else label


def fits_any_num_uavs(method: Method) -> bool:
    """Whether the players of a method can be flown with another number of UAVs than they were trained with.

    :param method: the method
    :return: false if its networks belong to single UAVs, or know them by their index
    """
    if method.algo is None or method.policy is None:
        return True
    return method.algo != "iql" and NOT_BY_N.issuperset(getattr(find_policy(method.policy), "sees", ()))
