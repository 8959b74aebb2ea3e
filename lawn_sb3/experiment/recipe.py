"""Recipes: which methods are trained on which scenario with which seeds, and how they are evaluated."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator
from stable_baselines3.common.utils import LinearSchedule

from lawn_sb3.config import read_yaml_mapping, validated
from lawn_sb3.envs.observation import NOT_BY_N
from lawn_sb3.envs.training_env import Credit
from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.experiment.find_policy import find_policy, policy_digest
from lawn_sb3.experiment.registry import (
    ALGORITHMS,
    DEFAULT_POLICIES,
    PLAYERS,
    accepted_settings,
    find_algorithm,
)
from lawn_sb3.game.simulator import Continuation, check_fewest
from lawn_sb3.game.state import RewardTerm
from lawn_sb3.scenario import Scenario, load_scenario

GIVEN_BY_THE_KIT = {"self", "policy", "env", "seed", "tensorboard_log", "verbose", "_init_setup_model"}
SHARED = "shared network"
RESULTS_SINCE = "0.1.0"
"""The last version of the kit that changed a byte of what a run leaves; raised with such a change and only then."""
NOT_IN_RESULTS = ("label", "paper_row", "baseline")
"""Fields of a method that change nothing in what its runs leave."""


class Evaluation(BaseModel):
    """How finished players are scored, and how training is watched."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    episodes: int = Field(200, ge=1, description="joint episodes per seed")
    seed: int = Field(20_000, ge=0, description="picks the test missions, the same for every method and seed")
    deterministic: bool = Field(True, description="greedy actions, as in the paper; otherwise sampled")
    record_every: int = Field(1_000, ge=1, description="env steps between two rows of progress.csv, at least")
    watch_every: int = Field(5_000, ge=1, description="env steps between two greedy evaluations during training")
    watch_episodes: int = Field(100, ge=1, description="joint episodes of each")
    watch_seed: int = Field(
        10_000, ge=0, description="picks the missions watched during training, apart from the test's"
    )
    traced_episodes: int = Field(4, ge=0, description="joint episodes whose paths are kept")


class Method(BaseModel):
    """An algorithm with a policy and its settings, or a player that needs no training."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    label: str = Field(description="what tables and figures call it")
    paper_row: Literal["Random", "IQL", "QMIX", "CTDE-MAPPO"] | None = Field(
        None, description="row of the paper's Table II"
    )
    player: str | None = Field(None, description="a player without training")
    algo: str | None = Field(None, description="an algorithm")
    policy: str | None = Field(None, description="its policy: NAME of policies/NAME.py, or package.module:Class")
    env_steps: int = Field(0, ge=0, description="training budget: joint slots of one game")
    num_games: int = Field(64, ge=1, le=100_000, description="games played side by side in training")
    continuation: Continuation = Field("mission", description="how UAVs that are done go on in training")
    settings: dict[str, Any] = Field({}, description="keyword arguments of the algorithm; lin_X anneals X to 0")
    without_reward: tuple[RewardTerm, ...] = Field(
        (), description="terms of the reward that training leaves out; the evaluation counts them all"
    )
    slack: int | None = Field(
        None, ge=0, description="in-time moves alone, in training and play: arrival by T_min and so many slots"
    )
    credit: Credit = Field("own", description="whose reward training gives a UAV")
    fewest_uavs: int | None = Field(
        None, ge=1, description="train in games of so many to N UAVs, drawn anew for each; in N without a number"
    )
    baseline: str | None = Field(None, description="method of the same recipe that this one is an ablation of")

    @model_validator(mode="before")
    @classmethod
    def _default_policy(cls, values: Any) -> Any:
        if not isinstance(values, dict) or not isinstance(values.get("algo"), str) or values["algo"] not in ALGORITHMS:
            return values
        algo, values = values["algo"], dict(values)
        if values.get("policy") is None and algo in DEFAULT_POLICIES:
            values["policy"] = DEFAULT_POLICIES[algo]
        needed = getattr(ALGORITHMS[algo], "continuation", None)
        if needed is not None:
            values.setdefault("continuation", needed)
        return values

    @model_validator(mode="before")
    @classmethod
    def _label_a_shared_network(cls, values: Any) -> Any:
        """Every table says so where IQL's learners are not independent."""
        if not isinstance(values, dict) or values.get("algo") != "iql" or not isinstance(values.get("label"), str):
            return values
        settings = values.get("settings")
        if not isinstance(settings, dict) or not settings.get("share_parameters") or SHARED in values["label"]:
            return values
        return {**values, "label": f"{values['label']}, {SHARED}"}

    @model_validator(mode="after")
    def _check(self) -> Self:
        if (self.player is None) == (self.algo is None):
            raise ValueError(f"method {self.label!r} needs either a player or an algo")
        if self.player is not None:
            if self.player not in PLAYERS:
                raise unknown_name("player", self.player, PLAYERS)
            trains = self.env_steps or self.settings or self.policy or self.without_reward or self.baseline
            if trains or self.slack is not None or self.credit != "own" or self.fewest_uavs is not None:
                raise ValueError(
                    f"method {self.label!r} is a player without training: no policy, env_steps, settings, "
                    "without_reward, slack, credit, fewest_uavs or baseline"
                )
            return self
        assert self.algo is not None
        if self.algo not in ALGORITHMS:
            raise unknown_name("algorithm", self.algo, ALGORITHMS)
        if self.env_steps < 1:
            raise ValueError(f"method {self.label!r} trains and needs env_steps of at least 1")
        needed = getattr(ALGORITHMS[self.algo], "continuation", self.continuation)
        if self.continuation != needed:
            raise ValueError(f"method {self.label!r}: {self.algo} trains with continuation {needed}")
        if self.credit == "team" and self.algo != "mappo-episodes":
            raise ValueError(f"method {self.label!r}: credit team needs mappo-episodes, where games are whole")
        if self.fewest_uavs is not None and not getattr(ALGORITHMS[self.algo], "takes_crowds", False):
            raise ValueError(
                f"method {self.label!r}: fewest_uavs needs mappo-episodes or imitate, where games are whole"
            )
        if self.fewest_uavs is not None and self.credit == "team":
            raise ValueError(f"method {self.label!r}: credit team needs the same number of UAVs in every game")
        known = accepted_settings(self.algo) - GIVEN_BY_THE_KIT
        for key in self.settings:
            if key not in known:
                raise unknown_name(f"setting of {self.algo}:", key, known)
        self.arguments()
        return self

    def arguments(self) -> dict[str, Any]:
        """Keyword arguments for the algorithm's constructor.

        :return: the settings, schedules turned into functions of the progress remaining
        :raises UserError: if a schedule cannot be read
        """
        return {key: _argument(key, value) for key, value in self.settings.items()}


def _argument(key: str, value: Any) -> Any:
    if not isinstance(value, str):
        return value
    kind, _, start = value.partition("_")
    if kind != "lin":
        try:
            return float(value)  # YAML takes 1e-3, without a point, for text
        except ValueError:
            return value
    try:
        return LinearSchedule(float(start), 0.0, 1.0)
    except ValueError:
        raise UserError(f"setting {key} = {value!r}: a linear schedule is written lin_X with a number X") from None


class Scaling(BaseModel):
    """Trained actors flown among more or fewer UAVs than they were trained with."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    num_uavs: tuple[Annotated[int, Field(ge=1)], ...] = Field(min_length=1, description="numbers of UAVs N to fly with")
    episodes: int = Field(100, ge=1, description="joint episodes for each N and seed")
    methods: tuple[str, ...] = Field(min_length=1, description="methods of the recipe to fly")


class Recipe(BaseModel):
    """Everything ``reproduce`` needs to know."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str = Field(description="names the folder runs/NAME")
    title: str = Field("", description="what the report calls it")
    scenario: str = Field("paper", description="a preset or a YAML file")
    set: tuple[str, ...] = Field((), description="changes to the scenario, key=value")
    variants: dict[str, tuple[str, ...]] = Field(
        {}, description="changed games: a name and further changes key=value; all methods are run on each"
    )
    seeds: tuple[int, ...] = Field(min_length=1, description="one cell for each method and seed")
    evaluation: Evaluation = Evaluation()
    methods: dict[str, Method] = Field(min_length=1)
    scaling: Scaling | None = Field(None, description="which methods are also flown with other numbers of UAVs")
    regret: bool = Field(False, description="whether to work out what each UAV of a run could gain by deviating alone")

    def game(self) -> Scenario:
        """The scenario with the recipe's changes.

        :return: the scenario
        :raises UserError: if there is no such scenario, or it is impossible
        """
        return load_scenario(self.scenario, self.set)

    def split(self) -> dict[str, Recipe]:
        """One recipe for each changed game.

        :return: variant: its recipe, which has no variants; a recipe without any is its own, under the empty name
        """
        if not self.variants:
            return {"": self}
        return {
            name: self.model_copy(update={"set": (*self.set, *changes), "variants": {}})
            for name, changes in self.variants.items()
        }

    @model_validator(mode="after")
    def _check(self) -> Self:
        if len(set(self.seeds)) < len(self.seeds) or min(self.seeds) < 0:
            raise ValueError(f"seeds = {list(self.seeds)}: whole numbers from 0 up, none twice")
        for key in (self.name, *self.variants, *self.methods):
            if not key.replace("-", "").replace("_", "").isalnum():
                raise ValueError(f"{key!r}: letters, digits, - and _ only, as it names a folder")
        for key, method in self.methods.items():
            if method.baseline is not None and (method.baseline not in self.methods or method.baseline == key):
                others = [name for name in self.methods if name != key]
                raise ValueError(f"methods.{key}: {unknown_name('baseline', method.baseline, others)}")
        for key in self.scaling.methods if self.scaling else ():
            if key not in self.methods:
                raise ValueError(f"scaling: {unknown_name('method', key, self.methods)}")
        return self

    @property
    def is_ablation(self) -> bool:
        """Whether any of its methods is compared with another one that it is an ablation of."""
        return any(method.baseline is not None for method in self.methods.values())


@dataclass(frozen=True)
class Cell:
    """One (method, seed) of a recipe.

    :param key: name of the method in the recipe
    :param method: the method
    :param seed: the seed
    :param scenario: the game
    :param evaluation: how it is scored
    :param directory: where its run goes
    :param variant: the recipe's name for the changed game, if it has several
    :param regret: whether regrets are worked out, in training too
    """

    key: str
    method: Method
    seed: int
    scenario: Scenario
    evaluation: Evaluation
    directory: Path
    variant: str = ""
    regret: bool = False

    @property
    def title(self) -> str:
        """What messages call it."""
        return f"{self.variant + ' ' if self.variant else ''}{self.key} seed {self.seed}"

    def configuration(self) -> dict[str, Any]:
        """All that the run depends on, ready for YAML."""
        return {
            "key": self.key,
            "policy_file": self._policy_digest(),
            "seed": self.seed,
            "method": self.method.model_dump(mode="json"),
            "scenario": self.scenario.model_dump(mode="json"),
            "evaluation": self.evaluation.model_dump(mode="json"),
            "version": RESULTS_SINCE,
        }

    def _policy_digest(self) -> str | None:
        """Hash of the policy's file: an edited policy is another configuration."""
        return None if self.method.policy is None else policy_digest(self.method.policy)

    def fingerprint(self) -> str:
        """Hash of what the result depends on: labels do not count, nor do fields that keep their default value."""
        configuration: dict[str, Any] = {
            "policy_file": self._policy_digest(),
            "seed": self.seed,
            "method": self.method.model_dump(mode="json", exclude_defaults=True),
            "scenario": self.scenario.model_dump(mode="json", exclude_defaults=True),
            "evaluation": self.evaluation.model_dump(mode="json", exclude_defaults=True),
            "version": RESULTS_SINCE,
        }
        for name in NOT_IN_RESULTS:
            configuration["method"].pop(name, None)
        return hashlib.sha256(json.dumps(configuration, sort_keys=True).encode()).hexdigest()[:16]


def parse_method(values: dict[str, Any]) -> Method:
    """Validate one method that comes from the command line.

    :param values: its fields
    :return: the method
    :raises UserError: one line naming what is wrong and what is allowed
    """
    method = validated(Method, values, "method")
    _check_policy_fits(method)
    return method


def _check_policy_fits(method: Method) -> None:
    if method.algo is not None and method.policy is not None:
        find_algorithm(method.algo, find_policy(method.policy))


def load_recipe(path: Path) -> Recipe:
    """Read a recipe and check all of it before anything runs.

    :param path: a file such as ``runs/paper.yaml``
    :return: the recipe
    :raises UserError: one line naming what is wrong, where, and what is allowed
    """
    recipe = validated(Recipe, {"name": path.stem, **read_yaml_mapping(path, "recipe")}, str(path))
    for variant in recipe.split().values():
        game = variant.game()
        for key, method in recipe.methods.items():
            if method.fewest_uavs is not None:
                _check_crowds(method.fewest_uavs, game, method.continuation, f"methods.{key}")
    for method in recipe.methods.values():
        _check_policy_fits(method)
    if recipe.scaling is not None:
        _check_scaling(recipe, recipe.scaling)
    return recipe


def _check_crowds(fewest_uavs: int, game: Scenario, continuation: Continuation, where: str) -> None:
    try:
        check_fewest(fewest_uavs, game, continuation)
    except UserError as error:
        raise UserError(f"{where}: {error}") from None


def fits_any_num_uavs(method: Method) -> bool:
    """Whether the players of a method can be flown with another number of UAVs than they were trained with.

    :param method: the method
    :return: false if its networks belong to single UAVs, or know them by their index
    """
    if method.algo is None or method.policy is None:
        return True
    policy = find_policy(method.policy)
    return method.algo != "iql" and NOT_BY_N.issuperset(getattr(policy, "sees", ()))


def _check_scaling(recipe: Recipe, scaling: Scaling) -> None:
    for num_uavs in scaling.num_uavs:
        recipe.game().changed(num_uavs=num_uavs)
    for key in scaling.methods:
        if not fits_any_num_uavs(recipe.methods[key]):
            raise UserError(
                f"scaling: method {key!r} has networks for single UAVs, and cannot be flown with other numbers of them"
            )


def cells(recipe: Recipe, root: Path) -> list[Cell]:
    """The cells of a recipe, seed by seed, so that an early stop leaves all methods comparable.

    :param recipe: the recipe
    :param root: the folder of its runs
    :return: one cell for each method, seed and variant
    """
    games = {name: variant.game() for name, variant in recipe.split().items()}
    return [
        Cell(
            key,
            method,
            seed,
            scenario,
            recipe.evaluation,
            root / variant / key / f"seed-{seed}",
            variant,
            recipe.regret,
        )
        for seed in recipe.seeds
        for variant, scenario in games.items()
        for key, method in recipe.methods.items()
    ]
