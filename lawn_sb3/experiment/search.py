"""What a search for settings searches: its file, checked before anything of it is trained."""

from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field

from lawn_sb3.config import Whole, read_yaml_mapping, validated
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.recipe import Method, check_policies, parse_method, read_recipe

Setting = str | int | float | bool


class Search(BaseModel):
    """What is searched: methods of a recipe, each with the values its settings may take."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    recipe: str = Field("paper.yaml", description="recipe beside this file that holds the methods")
    trials: Whole = Field(12, ge=1, description="settings tried for each method with the first seed, at least")
    cpu_minutes: float = Field(0.0, ge=0, description="CPU time given to them, for each method, at least")
    finalists: Whole = Field(1, ge=1, description="how many of them, the best, are trained with all seeds")
    env_steps: Whole = Field(50_000, ge=1, description="budget of a training")
    seeds: tuple[Whole, ...] = Field((100,), min_length=1, description="seeds of trainings; none is reported")
    episodes: Whole = Field(200, ge=1, description="joint episodes each training is scored on")
    missions_seed: Whole = Field(30_000, ge=0, description="picks their missions, apart from the test's")
    space: dict[str, dict[str, list[Setting]]] = Field(
        min_length=1, description="method: setting: values in order; the first is the recipe's where that names none"
    )


def load_search(path: Path) -> tuple[Search, dict[str, Method]]:
    """Read a search and the methods that it is about.

    :param path: a file such as ``runs/tuning.yaml``
    :return: the search, and its methods as the recipe has them
    :raises UserError: one line naming what is wrong
    """
    search = validated(Search, read_yaml_mapping(path, "search"), str(path))
    recipe_path = path.parent / search.recipe
    recipe = read_recipe(recipe_path)
    if set(search.seeds) & set(recipe.seeds):
        raise UserError(f"{path}: seeds {list(search.seeds)} are among those that {search.recipe} reports")
    if search.missions_seed == recipe.evaluation.seed:
        raise UserError(f"{path}: missions_seed = {search.missions_seed} is that of the test missions")
    for key in search.space:
        if key not in recipe.methods or recipe.methods[key].algo is None:
            raise UserError(f"{path}: space: {key!r} is no method of {search.recipe} that trains")
        for setting, choices in search.space[key].items():
            for choice in choices:
                values = recipe.methods[key].model_dump()
                try:
                    parse_method({**values, "settings": {**values["settings"], setting: choice}})
                except UserError as error:
                    raise UserError(f"{path}: space.{key}: {error}") from None
    check_policies(recipe, recipe_path)
    return search, {key: recipe.methods[key] for key in search.space}
