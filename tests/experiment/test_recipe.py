"""Recipes: checked as a whole before anything runs, with one clear line for what is wrong."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell, cells
from lawn_sb3.experiment.recipe import Method, honest_label, load_recipe
from lawn_sb3.experiment.registry import REPOSITORY
from lawn_sb3.scenario import PRESETS

GOOD = {
    "scenario": "paper",
    "seeds": [0, 1],
    "methods": {
        "random": {"label": "Random", "player": "random"},
        "mappo": {"label": "MAPPO", "algo": "mappo", "env_steps": 100, "settings": {"gamma": 0.9}},
    },
}


def written(folder: Path, content: object) -> Path:
    path = folder / "mine.yaml"
    path.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    return path


def learner(**values: object) -> dict[str, object]:
    return {"label": "M", "algo": "mappo", "env_steps": 1, **values}


def changed(**methods: object) -> dict[str, object]:
    return {**GOOD, "methods": {**GOOD["methods"], **methods}}  # type: ignore[dict-item]


@pytest.mark.parametrize("name", ["paper", "quick"])
def test_shipped_recipes_are_valid(name: str) -> None:
    recipe = load_recipe(REPOSITORY / "runs" / f"{name}.yaml")
    assert {"random", "mappo", "mappo-state"} <= set(recipe.methods)


def test_paper_recipe_has_five_seeds_and_watches_other_missions_than_it_tests() -> None:
    recipe = load_recipe(REPOSITORY / "runs" / "paper.yaml")
    assert len(recipe.seeds) == 5
    assert recipe.evaluation.episodes == 200
    assert recipe.evaluation.watch_seed != recipe.evaluation.seed


def test_a_recipe_is_named_after_its_file_and_has_one_cell_for_each_method_and_seed(tmp_path: Path) -> None:
    recipe = load_recipe(written(tmp_path, GOOD))
    assert recipe.name == "mine"
    made = cells(recipe, tmp_path / "mine")
    assert [(cell.key, cell.seed) for cell in made] == [("random", 0), ("mappo", 0), ("random", 1), ("mappo", 1)]
    assert made[3].directory == tmp_path / "mine" / "mappo" / "seed-1"


def test_every_method_is_run_on_every_changed_game(tmp_path: Path) -> None:
    content = {**GOOD, "set": ["num_uavs=2"], "variants": {"as-is": [], "loud": ["tx_power_dbm=30", "num_uavs=3"]}}
    recipe = load_recipe(written(tmp_path, content))
    todo = cells(recipe, tmp_path / "mine")
    assert len(todo) == 2 * 2 * 2  # seeds, games, methods
    loud = next(cell for cell in todo if cell.variant == "loud" and cell.key == "mappo")
    assert loud.directory == tmp_path / "mine" / "loud" / "mappo" / "seed-0"
    assert (loud.scenario.tx_power_dbm, loud.scenario.num_uavs) == (30.0, 3)  # the variant has the last word
    assert {cell.scenario.num_uavs for cell in todo if cell.variant == "as-is"} == {2}
    assert loud.title == "loud mappo seed 0"


def test_an_impossible_changed_game_is_refused_before_anything_runs(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="rb_bandwidth_hz = -1"):
        load_recipe(written(tmp_path, {**GOOD, "variants": {"odd": ["rb_bandwidth_hz=-1"]}}))


@pytest.mark.parametrize(
    ("algo", "policy", "continuation"),
    [("mappo", "centralized_critic", "mission"), ("iql", "local_q", "mission"), ("qmix", "monotonic_mixer", "episode")],
)
def test_the_algorithms_own_policy_and_continuation_are_the_default(algo: str, policy: str, continuation: str) -> None:
    method = Method(label="M", algo=algo, env_steps=1)
    assert (method.policy, method.continuation) == (policy, continuation)
    assert Method(label="M", algo=algo, env_steps=1, policy="own").policy == "own"


@pytest.mark.parametrize(
    ("label", "settings", "expected"),
    [
        ("IQL", {}, "IQL"),
        ("IQL", {"share_parameters": False}, "IQL"),
        ("IQL", {"share_parameters": True}, "IQL, shared network"),
        ("One shared network", {"share_parameters": True}, "One shared network"),
    ],
)
def test_a_label_says_that_a_network_is_shared(label: str, settings: dict[str, bool], expected: str) -> None:
    assert honest_label(label, settings) == expected
    assert Method(label=label, algo="iql", env_steps=1, settings=settings).label == label  # never rewritten


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        ({**GOOD, "seeds": []}, "seeds"),
        ({**GOOD, "seeds": [1, 1]}, "none twice"),
        ({**GOOD, "sedes": [1]}, "did you mean 'seeds'"),
        ({**GOOD, "scenario": "papre"}, "did you mean 'paper'"),
        ({**GOOD, "set": ["num_uavs=0"]}, "num_uavs = 0"),
        ({**GOOD, "set": ["num_uav=5"]}, "did you mean 'num_uavs'"),
        ({**GOOD, "evaluation": {"episode": 5}}, "did you mean 'episodes'"),
        (changed(mappo=learner(algo="mapo")), "did you mean 'mappo'"),
        (changed(mappo=learner(env_steps=0)), "env_steps"),
        (changed(mappo=learner(env_steps=-1)), "env_steps = -1"),
        (changed(mappo=learner(env_stesp=1)), "did you mean 'env_steps'"),
        (changed(mappo=learner(settings={"gama": 1})), "did you mean 'gamma'"),
        (changed(mappo=learner(settings={"ent_coef": "lin_x"})), "lin_X"),
        (changed(mappo=learner(policy="centralized")), "centralized_critic"),
        (changed(nobody={"label": "M"}), "either a player or an algo"),
        (changed(both=learner(player="random")), "either a player or an algo"),
        (changed(idle={"label": "M", "player": "random", "env_steps": 5}), "without training"),
        (changed(idle={"label": "M", "player": "random", "fewest_uavs": 2}), "without training"),
        (changed(mappo=learner(fewest_uavs=2)), "fewest_uavs needs mappo-episodes or imitate"),
        (
            changed(mappo=learner(algo="mappo-episodes", fewest_uavs=2, credit="team")),
            "credit team needs the same number of UAVs",
        ),
        (
            changed(mappo=learner(algo="mappo-episodes", fewest_uavs=5)),
            "methods.mappo: fewest_uavs = 5: from 1 to num_uavs = 4",
        ),
        (
            changed(iql=learner(algo="iql", settings={"share_parameters": True})),
            "methods.iql: label = 'M': say 'shared network', as IQL's learners have one there",
        ),
        ({**GOOD, "seeds": ["one"]}, "seeds.0 = 'one': must be a whole number"),
        ({**GOOD, "evaluation": 5}, "evaluation = 5: must be keys and values"),
        ({**GOOD, "set": ["num_uavs"]}, "set 'num_uavs': expected key=value"),
        ({**GOOD, "methods": {7: {"label": "M", "player": "random"}}}, "methods: the key 7 must be text"),
        (changed(**{"../up": {"label": "M", "player": "random"}}), "names a folder"),
    ],
)
def test_a_bad_recipe_is_refused_in_one_line(tmp_path: Path, content: object, expected: str) -> None:
    with pytest.raises(UserError) as refusal:
        load_recipe(written(tmp_path, content))
    assert str(refusal.value).startswith(f"{tmp_path / 'mine.yaml'}: ")
    assert expected in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("named", "there", "uavs"),
    [
        ("game.yaml", {"runs/game.yaml": 3, "game.yaml": 5}, 3),
        ("../game.yaml", {"game.yaml": 5}, 5),
        ("game.yaml", {"game.yaml": 5}, 5),  # the working directory's, where the recipe's folder has none
        ("mine.yaml", {"mine.yaml": 5}, 5),  # not the recipe itself
    ],
)
def test_a_scenario_is_sought_beside_the_recipe_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, named: str, there: dict[str, int], uavs: int
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("runs").mkdir()
    for path, num_uavs in there.items():
        Path(path).write_text(f"num_uavs: {num_uavs}\n", encoding="utf-8")
    recipe = load_recipe(written(Path("runs"), {**GOOD, "scenario": named}))
    assert recipe.game().num_uavs == uavs
    assert recipe.game().name == Path(named).stem


def test_a_scenario_that_is_nowhere_is_missed_beside_the_recipe(tmp_path: Path) -> None:
    with pytest.raises(UserError) as refusal:
        load_recipe(written(tmp_path, {**GOOD, "scenario": "game.yaml"}))
    assert f"{str(tmp_path / 'game.yaml')!r} cannot be read" in str(refusal.value)


def test_the_fingerprint_depends_on_settings_and_seed_but_not_on_labels(small_cell: Cell) -> None:
    relabelled = replace(small_cell, method=small_cell.method.model_copy(update={"label": "another"}))
    assert relabelled.fingerprint() == small_cell.fingerprint()
    assert replace(small_cell, seed=4).fingerprint() != small_cell.fingerprint()
    longer = replace(small_cell, method=small_cell.method.model_copy(update={"env_steps": 512}))
    assert longer.fingerprint() != small_cell.fingerprint()
    crowded = replace(small_cell, scenario=small_cell.scenario.changed(num_uavs=5))
    assert crowded.fingerprint() != small_cell.fingerprint()


def test_a_run_of_an_earlier_version_counts_only_where_it_left_something_that_no_report_reads(small_cell: Cell) -> None:
    assert small_cell.fingerprint() in small_cell.fingerprints()
    assert len(small_cell.fingerprints()) == 2  # MAPPO leaves other rollout/ columns since
    random = replace(small_cell, method=Method(label="Random", player="random"))
    assert random.fingerprints() == {random.fingerprint()}


@pytest.mark.parametrize("name", ["sensitivity", "readings"])
def test_changed_games_have_the_papers_methods_with_a_smaller_budget(name: str) -> None:
    paper, other = (load_recipe(REPOSITORY / "runs" / f"{key}.yaml") for key in ("paper", name))
    for key, method in other.methods.items():
        same = paper.methods[key].model_copy(update={"env_steps": method.env_steps})
        assert method == same, key
    assert next(iter(other.variants.values())) == ()  # the game as it is comes first


def test_bfloat16_is_held_against_the_papers_mappo_with_nothing_else_changed() -> None:
    paper, other = (load_recipe(REPOSITORY / "runs" / f"{name}.yaml") for name in ("paper", "bfloat16"))
    assert (other.game(), other.seeds) == (paper.game(), paper.seeds)
    full, lower = other.methods["mappo"], other.methods["mappo-bfloat16"]
    assert full.settings == paper.methods["mappo"].settings
    assert lower == full.model_copy(
        update={"label": lower.label, "baseline": "mappo", "settings": {**full.settings, "autocast": "bfloat16"}}
    )


@pytest.mark.parametrize("name", ["eight", "six", "tiny"])
def test_the_ladder_in_other_games_has_the_settings_of_the_ladder(name: str) -> None:
    ladder, other = (load_recipe(REPOSITORY / "runs" / f"{key}.yaml") for key in ("ladder", name))
    assert other.game() != ladder.game()
    assert {"shortest-path", "blind", "clock", "intents"} <= set(other.methods)
    for key, method in other.methods.items():
        theirs = ladder.methods["clock" if key == "mixed" else key]
        assert (method.algo, method.policy, method.player) == (theirs.algo, theirs.policy, theirs.player), key
        assert (method.credit, method.without_reward) == (theirs.credit, theirs.without_reward), key
        mine, same = (
            {setting: value for setting, value in one.settings.items() if setting != "policy_kwargs"}
            for one in (method, theirs)
        )
        assert mine == same, key
        if method.algo is not None:
            networks = [one.settings["policy_kwargs"]["net_arch"] for one in (method, theirs)]
            assert networks[0] == networks[1], key


def test_in_the_airspace_as_printed_only_what_its_size_asks_for_is_other_than_in_the_ladder_and_the_comparison() -> (
    None
):
    ladder, paper, printed = (
        load_recipe(REPOSITORY / "runs" / f"{key}.yaml") for key in ("ladder", "paper", "as_printed")
    )
    assert printed.game() == PRESETS["as-printed"]
    for key in ("iql", "qmix"):
        assert printed.methods[key].settings == paper.methods[key].settings
    mine, theirs = printed.methods["clock"], ladder.methods["clock"]
    own, others = ({k: v for k, v in one.settings.items() if k != "policy_kwargs"} for one in (mine, theirs))
    assert own == others
    assert (mine.policy, mine.slack, mine.credit) == (theirs.policy, theirs.slack, theirs.credit)
    learners = [method for method in printed.methods.values() if method.algo in ("iql", "qmix", "mappo")]
    assert {method.env_steps for method in learners} == {paper.methods["mappo"].env_steps}
    assert {method.slack for method in learners} == {None}  # all moves


def test_a_swarm_is_flown_at_the_density_of_its_training() -> None:
    recipe = load_recipe(REPOSITORY / "runs" / "swarm.yaml")
    assert recipe.scaling is not None
    games = [recipe.scaling.game(recipe.game(), num_uavs) for num_uavs in recipe.scaling.num_uavs]
    assert [(game.num_uavs, game.num_gbs) for game in games] == [(4, 1), (16, 4), (64, 16), (256, 64), (1024, 256)]
    assert {game.num_voxels / game.num_uavs for game in games} == {1200 / 64}
    assert recipe.scaling.flown_by("mean-field") == {4: 1000, 16: 250, 64: 64}
    assert recipe.scaling.flown_by("forecast")[1024] == 4


@pytest.mark.parametrize(
    ("scaling", "expected"),
    [
        ({"num_uavs": [4, 8], "constant_density": True}, "num_uavs = 8 at the density of .* must be whole"),
        ({"num_uavs": [4, 16], "episodes": [5]}, r"episodes = \[5\]: one number, or one for each of \[4, 16\]"),
        ({"num_uavs": [4], "reach": {"welfare": 4}}, "reach: .*'welfare'"),
        (
            {"num_uavs": [16], "constant_density": True, "methods": ["mappo"]},
            "'mappo' has networks for 4 GBSs .* cannot be flown at constant density",
        ),
    ],
)
def test_what_cannot_be_scaled_is_refused(tmp_path: Path, scaling: dict[str, Any], expected: str) -> None:
    methods = {
        "random": {"label": "Random", "player": "random"},
        "mappo": {"label": "MAPPO", "algo": "mappo", "env_steps": 100},
    }
    content = {"seeds": [0], "methods": methods, "scaling": {"methods": ["random"], **scaling}}
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(UserError, match=expected):
        load_recipe(path)
