"""Recipes whose methods are ablations of others, and policies that join them."""

from pathlib import Path
from typing import Any

import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.ablation import with_policy
from lawn_sb3.experiment.recipe import Recipe, load_recipe
from lawn_sb3.experiment.registry import REPOSITORY
from tests.experiment.test_recipe import written

ABLATION: dict[str, Any] = {
    "name": "own",
    "seeds": [0],
    "methods": {
        "mappo": {"label": "MAPPO", "algo": "mappo", "env_steps": 8, "settings": {"gamma": 0.7}},
        "mappo-state": {
            "label": "V(x)", "algo": "mappo", "policy": "state_critic", "env_steps": 8, "baseline": "mappo",
        },
        "qmix": {"label": "QMIX", "algo": "qmix", "env_steps": 8},
    },
}  # fmt: skip


def test_a_policy_is_added_to_an_ablation_with_the_settings_of_its_algorithms_default() -> None:
    recipe, key = with_policy(Recipe.model_validate(ABLATION), "local_critic")
    added = recipe.methods[key]
    assert (key, added.label, added.algo, added.baseline) == ("local_critic", added.policy, "mappo", "mappo")
    assert added.policy == "local_critic"
    assert added.settings == {"gamma": 0.7}
    recipe, key = with_policy(Recipe.model_validate(ABLATION), "policies.additive_mixer:AdditiveMixerPolicy")
    assert (key, recipe.methods[key].baseline) == ("AdditiveMixerPolicy", "qmix")


def test_a_policy_whose_learners_share_a_network_is_labelled_as_such() -> None:
    shared = {"label": "A shared network", "algo": "iql", "env_steps": 8, "settings": {"share_parameters": True}}
    recipe = Recipe.model_validate({**ABLATION, "methods": {"iql": shared}})
    assert with_policy(recipe, "quantile_q")[0].methods["quantile_q"].label == "quantile_q, shared network"


@pytest.mark.parametrize(
    ("policy", "expected"),
    [
        ("state_critic", "has policy 'state_critic' already: it is the method 'mappo-state'"),
        ("policies.state_critic:StateCriticPolicy", "already: it is the method 'mappo-state'"),
        ("local_q", "policy 'local_q' is for iql; recipe 'own' has default methods of: mappo, qmix"),
        ("stat_critic", "did you mean 'state_critic'"),
    ],
)
def test_a_policy_that_cannot_be_added_is_refused(policy: str, expected: str) -> None:
    with pytest.raises(UserError, match=expected):
        with_policy(Recipe.model_validate(ABLATION), policy)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"baseline": "mapp"}, "unknown baseline 'mapp' .did you mean 'mappo'"),
        ({"baseline": "mappo-state"}, "unknown baseline 'mappo-state'"),
        ({"without_reward": ["navi"]}, "without_reward"),
        ({"policy": "local_q"}, "does not fit mappo: it is a policy for iql"),
    ],
)
def test_an_ablation_that_cannot_be_is_refused(tmp_path: Path, changes: dict[str, Any], expected: str) -> None:
    changed = {**ABLATION["methods"]["mappo-state"], **changes}
    with pytest.raises(UserError, match=expected):
        load_recipe(written(tmp_path, {**ABLATION, "methods": {**ABLATION["methods"], "mappo-state": changed}}))


def test_every_shipped_ablation_differs_from_its_default_in_one_thing() -> None:
    recipe = load_recipe(REPOSITORY / "runs" / "ablation.yaml")
    assert set(recipe.scaling.methods if recipe.scaling else ()) <= set(recipe.methods)
    for key, method in recipe.methods.items():
        if method.baseline is not None:
            own, default = method.model_dump(), recipe.methods[method.baseline].model_dump()
            mine, theirs = own.pop("settings"), default.pop("settings")
            settings = {name for name in {**mine, **theirs} if mine.get(name) != theirs.get(name)}
            changed = {name for name in own if own[name] != default[name]} - {"label", "baseline", "paper_row"}
            assert len(changed) + len(settings) == 1, key


def test_the_defaults_of_the_ablation_are_the_methods_of_the_papers_recipe() -> None:
    ablation, paper = (load_recipe(REPOSITORY / "runs" / f"{name}.yaml") for name in ("ablation", "paper"))
    own = {"label", "paper_row"}
    for key in ("mappo", "qmix", "iql"):
        ours, theirs = (one.methods[key].model_dump(exclude=own) for one in (ablation, paper))
        assert ours == theirs
    assert (ablation.evaluation, ablation.seeds, ablation.game()) == (paper.evaluation, paper.seeds, paper.game())


@pytest.mark.parametrize(
    ("scaling", "expected"),
    [
        ({"num_uavs": [1], "methods": ["mapo"]}, r"scaling: unknown method 'mapo' .did you mean 'mappo'"),
        ({"num_uavs": [4, 151], "methods": ["mappo"]}, "num_uavs = 151"),
        ({"num_uavs": [4], "methods": ["iql"]}, "method 'iql' has networks for single UAVs"),
        ({"num_uavs": [4], "methods": ["own"]}, "method 'own' has networks for single UAVs"),
    ],
)
def test_what_cannot_be_scaled_out_is_refused_before_anything_runs(
    tmp_path: Path, scaling: dict[str, Any], expected: str
) -> None:
    methods = {
        **ABLATION["methods"],
        "iql": {"label": "IQL", "algo": "iql", "env_steps": 8},
        "own": {"label": "Own", "algo": "mappo", "policy": "separate_actors", "env_steps": 8},
    }
    with pytest.raises(UserError, match=expected):
        load_recipe(written(tmp_path, {**ABLATION, "methods": methods, "scaling": scaling}))
