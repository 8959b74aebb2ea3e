"""Recipes: which methods are trained on which scenario with which seeds, and how they are evaluated."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from lawn_sb3.choices import MOST_EPISODES, Continuation, Credit, RewardTerm, check_fewest
from lawn_sb3.config import Whole, read_yaml_mapping, validated
from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.experiment.policy_places import locate
from lawn_sb3.experiment.registry import ALGORITHMS, check_player, find_algorithm
from lawn_sb3.experiment.settings import check_settings
from lawn_sb3.scenario import FILE_ENDINGS, PRESETS, Scenario, load_scenario

SHARED = "shared network"
MOST_ENV_STEPS = 10**12


class Evaluation(BaseModel):
    """How finished players are scored, and how training is watched."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    episodes: Whole = Field(200, ge=1, le=MOST_EPISODES, description="joint episodes per seed")
    seed: Whole = Field(20_000, ge=0, description="picks the test missions, the same for every method and seed")
    deterministic: bool = Field(True, description="greedy actions, as in the paper; otherwise sampled")
    record_every: Whole = Field(1_000, ge=1, description="env steps between two rows of progress.csv, at least")
    watch_every: Whole = Field(5_000, ge=1, description="env steps between two greedy evaluations during training")
    watch_episodes: Whole = Field(100, ge=1, le=MOST_EPISODES, description="joint episodes of each")
    watch_seed: Whole = Field(
        10_000, ge=0, description="picks the missions watched during training, apart from the test's"
    )
    traced_episodes: Whole = Field(4, ge=0, description="joint episodes whose paths are kept")


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
    env_steps: Whole = Field(0, ge=0, le=MOST_ENV_STEPS, description="training budget: joint slots of one game")
    num_games: Whole = Field(64, ge=1, le=100_000, description="games played side by side in training")
    continuation: Continuation = Field("mission", description="how UAVs that are done go on in training")
    settings: dict[str, Any] = Field({}, description="keyword arguments of the algorithm; lin_X anneals X to 0")
    without_reward: tuple[RewardTerm, ...] = Field(
        (), description="terms of the reward that training leaves out; the evaluation counts them all"
    )
    slack: Whole | None = Field(
        None, ge=0, description="in-time moves alone, in training and play: arrival by T_min and so many slots"
    )
    credit: Credit = Field("own", description="whose reward training gives a UAV")
    fewest_uavs: Whole | None = Field(
        None, ge=1, description="train in games of so many to N UAVs, drawn anew for each; in N without a number"
    )
    baseline: str | None = Field(None, description="method of the same recipe that this one is an ablation of")

    @property
    def gpus(self) -> int:
        """How many GPUs its training is to have: one if its settings ask for a device of CUDA."""
        return int(str(self.settings.get("device", "cpu")).startswith("cuda"))

    @model_validator(mode="before")
    @classmethod
    def _defaults_of_the_algorithm(cls, values: Any) -> Any:
        if not isinstance(values, dict) or not isinstance(values.get("algo"), str) or values["algo"] not in ALGORITHMS:
            return values
        algo, policy = ALGORITHMS[values["algo"]], values.get("policy")
        own = {"continuation": algo.continuation}
        return {**own, **values, "policy": algo.default_policy if policy is None else policy}

    @model_validator(mode="after")
    def _check(self) -> Self:
        """Refuse a method that no algorithm or player can carry out; its policy is not looked at."""
        what = f"method {self.label!r}"
        if (self.player is None) == (self.algo is None):
            raise ValueError(f"{what} needs either a player or an algo")
        if self.player is not None:
            check_player(self.player)
            more = sorted(self.model_dump(exclude={"label", "paper_row", "player"}, exclude_defaults=True))
            if more:
                raise ValueError(f"{what} is a player without training: no {', '.join(more)}")
            return self
        assert self.algo is not None
        if self.algo not in ALGORITHMS:
            raise unknown_name("algorithm", self.algo, ALGORITHMS)
        if self.env_steps < 1:
            raise ValueError(f"{what} trains and needs env_steps of at least 1")
        needed = ALGORITHMS[self.algo].continuation
        if self.continuation != needed:
            raise ValueError(f"{what}: {self.algo} trains with continuation {needed}")
        if self.credit == "team" and self.algo != "mappo-episodes":
            raise ValueError(f"{what}: credit team needs mappo-episodes, where games are whole")
        if self.fewest_uavs is not None:
            if not ALGORITHMS[self.algo].takes_crowds:
                raise ValueError(f"{what}: fewest_uavs needs mappo-episodes or imitate, where games are whole")
            if self.credit == "team":
                raise ValueError(f"{what}: credit team needs the same number of UAVs in every game")
        check_settings(self.algo, self.settings)
        return self


Natural = Annotated[Whole, Field(ge=1)]
Episodes = Annotated[Whole, Field(ge=1, le=MOST_EPISODES)]


class Scaling(BaseModel):
    """Trained actors flown among more or fewer UAVs than they were trained with."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    num_uavs: tuple[Natural, ...] = Field(min_length=1, description="numbers of UAVs N to fly with")
    episodes: Episodes | tuple[Episodes, ...] = Field(
        100, description="joint episodes for each N and seed: one number, or one for each N"
    )
    methods: tuple[str, ...] = Field(min_length=1, description="methods of the recipe to fly")
    constant_density: bool = Field(
        False, description="whether the airspace and its grid of GBSs grow with N, or both stay as they are"
    )
    reach: dict[str, Natural] = Field({}, description="of methods that cannot fly with all N: the largest they can")
    costs: bool = Field(False, description="also measure the time that a decision takes, and the memory")

    @model_validator(mode="after")
    def _check(self) -> Self:
        if isinstance(self.episodes, tuple) and len(self.episodes) != len(self.num_uavs):
            raise ValueError(f"episodes = {list(self.episodes)}: one number, or one for each of {list(self.num_uavs)}")
        for key in self.reach:
            if key not in self.methods:
                raise ValueError(f"reach: {unknown_name('method', key, self.methods)}")
        return self

    def flown_by(self, method: str) -> dict[int, int]:
        """How many joint episodes a method flies with each number of UAVs."""
        episodes = self.episodes if isinstance(self.episodes, tuple) else (self.episodes,) * len(self.num_uavs)
        most = self.reach.get(method, max(self.num_uavs))
        return {n: count for n, count in zip(self.num_uavs, episodes, strict=True) if n <= most}

    def game(self, own: Scenario, num_uavs: int) -> Scenario:
        """The game with so many UAVs.

        :param own: the game of the recipe
        :param num_uavs: N
        :return: the game
        :raises UserError: if there can be none
        """
        return own.grown(num_uavs) if self.constant_density else own.changed(num_uavs=num_uavs)


class Recipe(BaseModel):
    """Everything ``reproduce`` needs to know."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str = Field(description="names the folder runs/NAME")
    title: str = Field("", description="what the report calls it")
    scenario: str = Field("paper", description="a preset or a YAML file, beside the recipe or where it is run from")
    set: tuple[str, ...] = Field((), description="changes to the scenario, key=value")
    variants: dict[str, tuple[str, ...]] = Field(
        {}, description="changed games: a name and further changes key=value; all methods are run on each"
    )
    seeds: tuple[Whole, ...] = Field(min_length=1, description="one cell for each method and seed")
    evaluation: Evaluation = Evaluation()
    methods: dict[str, Method] = Field(min_length=1)
    scaling: Scaling | None = Field(None, description="which methods are also flown with other numbers of UAVs")
    regret: bool = Field(False, description="whether to work out what each UAV of a run could gain by deviating alone")

    def game(self) -> Scenario:
        """The scenario with the recipe's changes.

        :return: the scenario
        :raises UserError: if there is no such scenario, or it is impossible
        """
        return load_scenario(self.scenario, self.set, "set")

    def split(self) -> dict[str, "Recipe"]:
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
            if key in ("checks", "report"):
                raise ValueError(f"{key!r}: another name, as that folder is for the recipe's own {key}")
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


def parse_method(values: dict[str, Any]) -> Method:
    """Validate one method that comes from the command line; its policy is found, not imported.

    :param values: its fields
    :return: the method
    :raises UserError: one line naming what is wrong and what is allowed
    """
    method = validated(Method, values, "method")
    if method.policy is not None:
        locate(method.policy)
    return method


def load_recipe(path: Path) -> Recipe:
    """Read a recipe and check all of it before anything runs.

    :param path: a file such as ``runs/paper.yaml``
    :return: the recipe
    :raises UserError: one line naming what is wrong, where, and what is allowed
    """
    recipe = read_recipe(path)
    check_policies(recipe, path)
    return recipe


def read_recipe(path: Path) -> Recipe:
    """The first half of :func:`load_recipe`: all but :func:`check_policies`, so that torch is not loaded for it."""
    recipe = validated(Recipe, {"name": path.stem, **read_yaml_mapping(path, "recipe")}, str(path))
    recipe = recipe.model_copy(update={"scenario": _scenario_beside(path, recipe.scenario)})
    try:
        _check_recipe(recipe)
    except UserError as error:
        raise UserError(f"{path}: {error}") from None
    return recipe


def _scenario_beside(recipe: Path, name: str) -> str:
    """A recipe's scenario: a preset, or its file beside the recipe, or in the working directory if only that has it."""
    if name in PRESETS or Path(name).suffix not in FILE_ENDINGS:
        return name
    beside = recipe.parent / name
    if beside.exists() and not (recipe.exists() and beside.samefile(recipe)):  # which may have the same name
        return str(beside)
    return name if Path(name).exists() else str(beside)


def check_policies(recipe: Recipe, path: Path) -> None:
    """Import the policies of a recipe, and refuse those that their algorithms do not take or that cannot be scaled out.

    :param recipe: what :func:`read_recipe` gave
    :param path: its file, for the error
    :raises UserError: one line naming the first of them
    """
    from lawn_sb3.experiment.find_policy import find_policy  # here, as it brings torch

    try:
        for method in recipe.methods.values():
            if method.algo is not None and method.policy is not None:
                find_algorithm(method.algo, find_policy(method.policy))
        for key in recipe.scaling.methods if recipe.scaling else ():
            if not _fits_any_num_uavs(recipe.methods[key]):
                raise UserError(
                    f"scaling: method {key!r} has networks for single UAVs, and cannot be flown with other numbers of "
                    "them"
                )
        for key in recipe.scaling.methods if recipe.scaling and recipe.scaling.constant_density else ():
            if not fits_all_games(recipe.methods[key]):
                game = recipe.game()
                raise UserError(
                    f"scaling: method {key!r} has networks for {game.num_gbs} GBSs in {game.grid} voxels, and cannot "
                    "be flown at constant density; policies with fits_all_games can, such as knows_cells"
                )
    except UserError as error:
        raise UserError(f"{path}: {error}") from None


def _check_recipe(recipe: Recipe) -> None:
    """Refuse a recipe whose methods cannot be trained on its games, or are not what their labels say."""
    games = [variant.game() for variant in recipe.split().values()]
    for key, method in recipe.methods.items():
        for game in games if method.fewest_uavs is not None else ():
            try:
                check_fewest(method.fewest_uavs or 1, game, method.continuation)
            except UserError as error:
                raise UserError(f"methods.{key}: {error}") from None
        if method.policy is not None:
            locate(method.policy)
        if honest_label(method.label, method.settings) != method.label:
            raise UserError(
                f"methods.{key}: label = {method.label!r}: say {SHARED!r}, as IQL's learners have one there"
            )
    if recipe.scaling is not None:
        for num_uavs in recipe.scaling.num_uavs:
            recipe.scaling.game(recipe.game(), num_uavs)


def honest_label(label: str, settings: Mapping[str, Any]) -> str:
    """A label that says so where IQL's learners share a network by their settings, and are thus not independent."""
    return f"{label}, {SHARED}" if settings.get("share_parameters") and SHARED not in label else label


def fits_all_games(method: Method) -> bool:
    """Whether a method has no networks, or such as are the same for all numbers of UAVs and GBSs in any airspace."""
    from lawn_sb3.experiment.find_policy import find_policy

    return method.policy is None or bool(getattr(find_policy(method.policy), "fits_all_games", False))


def _fits_any_num_uavs(method: Method) -> bool:
    """Whether no network of a method belongs to a single UAV, or knows it by its index."""
    from lawn_sb3.envs.observation import NOT_BY_N
    from lawn_sb3.experiment.find_policy import find_policy

    if method.algo is None or method.policy is None:
        return True
    return method.algo != "iql" and NOT_BY_N.issuperset(getattr(find_policy(method.policy), "sees", ()))
