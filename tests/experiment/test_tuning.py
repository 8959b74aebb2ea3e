"""The search for settings: apart from the reported seeds, equal for all, and continued where it stopped."""

import json
from pathlib import Path

import pytest
import yaml
from rich.console import Console

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.backends.local import LocalBackend
from lawn_sb3.experiment.recipe import load_recipe
from lawn_sb3.experiment.registry import REPOSITORY
from lawn_sb3.experiment.search import load_search
from lawn_sb3.experiment.tuning import ranked_settings, read_trainings, run_search

SETTINGS = {"n_steps": 32, "batch_size": 64, "n_epochs": 1, "gamma": 0.8}
RECIPE = {
    "seeds": [0],
    "methods": {
        "random": {"label": "Random", "player": "random"},
        "mappo": {"label": "MAPPO", "algo": "mappo", "env_steps": 1000, "num_games": 2, "settings": SETTINGS},
    },
}
SEARCH = {
    "recipe": "small.yaml",
    "trials": 2,
    "env_steps": 64,
    "episodes": 3,
    "space": {"mappo": {"gamma": [0.8, 0.9], "n_epochs": [1, 2]}},
}


def written(folder: Path, **changes: object) -> Path:
    (folder / "small.yaml").write_text(yaml.safe_dump(RECIPE), encoding="utf-8")
    path = folder / "search.yaml"
    path.write_text(yaml.safe_dump({**SEARCH, **changes}), encoding="utf-8")
    return path


def test_a_search_tries_the_recipes_settings_first_and_goes_on_where_it_stopped(tmp_path: Path) -> None:
    console, file = Console(record=True, width=200), tmp_path / "search.csv"
    search, methods = load_search(written(tmp_path))
    run_search(search, methods, file, LocalBackend(1), console)
    assert "{'gamma': 0.8, 'n_epochs': 1}" in console.export_text().splitlines()[0]
    first = file.read_bytes()
    longer, methods = load_search(written(tmp_path, trials=3, seeds=[100, 101], finalists=1))
    run_search(longer, methods, file, LocalBackend(1), console)
    assert file.read_bytes().startswith(first)
    assert len(read_trainings(file)) == 4  # three settings with the first seed, the best of them with the other
    ranked = ranked_settings(longer, file)
    assert ranked["seeds"].tolist() == [2, 1, 1]
    assert ranked["settings"].map(str).nunique() == 3
    by_first_seed = read_trainings(file).query("seed == 100").set_index("settings")["reward"]
    assert by_first_seed.idxmax() == json.dumps(ranked["settings"][0])


def test_every_value_is_tried_once_and_no_more_where_there_are_fewer_than_trials(tmp_path: Path) -> None:
    file, space = tmp_path / "search.csv", {"mappo": {"n_epochs": [1, 2, 3]}}
    search, methods = load_search(written(tmp_path, trials=9, space=space))
    run_search(search, methods, file, LocalBackend(2), Console(quiet=True))
    ranked = ranked_settings(search, file)
    assert sorted(settings["n_epochs"] for settings in ranked["settings"]) == [1, 2, 3]
    edges = {
        settings["n_epochs"]: at_edge for settings, at_edge in zip(ranked["settings"], ranked["at_edge"], strict=True)
    }
    assert edges == {1: ["n_epochs"], 2: [], 3: ["n_epochs"]}


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"seeds": [0, 100]}, "are among those that small.yaml reports"),
        ({"missions_seed": 20_000}, "is that of the test missions"),
        ({"space": {"random": {"gamma": [0.8]}}}, "no method of small.yaml that trains"),
        ({"trails": 3}, "did you mean 'trials'"),
        ({"space": {"mappo": {"gama": [0.8]}}}, "did you mean 'gamma'"),
    ],
)
def test_a_search_that_would_spoil_the_comparison_is_refused(
    tmp_path: Path, changes: dict[str, object], expected: str
) -> None:
    with pytest.raises(UserError, match=expected):
        load_search(written(tmp_path, **changes))


def test_the_shipped_search_is_valid_and_gives_every_learner_as_many_trials() -> None:
    search, methods = load_search(REPOSITORY / "runs" / "tuning.yaml")
    assert search.trials >= 12
    recipe = load_recipe(REPOSITORY / "runs" / "paper.yaml")
    learners = {method.algo for method in recipe.methods.values() if method.algo}
    assert {method.algo for method in methods.values()} == learners
