"""Swapping a policy on the command line: one file, one command, a comparison; a broken one is refused in one line."""

import json
import shutil
import sys
from pathlib import Path

import pandas as pd
import pytest

from lawn_sb3.cli import main
from tests.cli.test_cli import QUICK, TINY_RECIPE, recipe
from tests.cli.test_results import Command, lawn  # noqa: F401  # a fixture

MAPPO = TINY_RECIPE["methods"]["mappo"]  # type: ignore[index]
METHODS = {**TINY_RECIPE["methods"], "raw": {**MAPPO, "label": "V(o)", "policy": "local_critic", "baseline": "mappo"}}  # type: ignore[dict-item]
SCALING = {"num_uavs": [2, 5], "episodes": 3, "methods": ["random", "mappo"]}

OWN = '''
import torch as th
from lawn_sb3.algos.mappo import CTDEPolicy

class OwnPolicy(CTDEPolicy):
    """A critic that sees nothing but the loads."""

    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        return local[:, self.layout.{columns}]
'''
READS_X = """
    def actor_view(self, flat: th.Tensor) -> th.Tensor:
        return flat
"""


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a tiny ablation, kept as reference results alone."""
    folder = tmp_path_factory.mktemp("ablation")
    recipe(folder, methods=METHODS, scaling=SCALING)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for command in ("reproduce", "export"):
            patch.setattr(sys, "argv", ["lawn-sb3", command, "tiny.yaml"])
            with pytest.raises(SystemExit) as end:
                main()
            assert not end.value.code
    shutil.rmtree(folder / "tiny")
    return folder


@pytest.fixture
def folder(kept: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of it to work in, with a policy of one's own."""
    shutil.copytree(kept, tmp_path / "work")
    monkeypatch.chdir(tmp_path / "work")
    Path("policies").mkdir()
    return tmp_path / "work"


@pytest.mark.usefixtures("folder")
def test_what_is_kept_of_an_ablation_rebuilds_its_report(lawn: Command) -> None:  # noqa: F811
    report = Path("reference/tiny/report")
    before = {path.name: path.read_bytes() for path in report.iterdir()}
    assert {"effects.md", "effects_forest.png", "scaling_out.png", "scaling.csv"} <= set(before)
    assert json.loads(before["report.json"])["problems"] == []
    shutil.rmtree(report)
    assert lawn("report", "tiny.yaml", "--runs", "reference/tiny").status == 0
    assert {path.name: path.read_bytes() for path in report.iterdir()} == before


@pytest.mark.usefixtures("folder")
def test_a_file_and_a_command_give_a_policys_effect_beside_the_others(lawn: Command) -> None:  # noqa: F811
    Path("policies/cli_own.py").write_text(OWN.format(columns="cell_loads"), encoding="utf-8")
    done = lawn("ablate", "cli_own", "--recipe", "tiny.yaml")
    assert done.status == 0, done.err
    assert "cli_own" in done.out
    effects = pd.read_csv("tiny/cli_own/report/effects.csv")
    assert dict(zip(effects["key"], effects["seeds"], strict=True)) == {"mappo": 2, "raw": 2, "cli_own": 2}
    assert sorted(path.name for path in Path("tiny").iterdir()) == ["cli_own"]  # nothing else was trained
    again = lawn("ablate", "cli_own", "--recipe", "tiny.yaml")
    assert "2 of 2 runs are finished already" in again.err


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        (OWN.format(columns="cell_loads") + READS_X, "reads the global state"),
        (OWN.format(columns="cel_loads"), "cel_loads"),
        ("import nothing_of_that_name", "ModuleNotFoundError"),
        (OWN.format(columns="cell_loads").replace("(CTDEPolicy)", "(object)"), "must hold one policy class, found 0"),
    ],
)
@pytest.mark.usefixtures("folder")
def test_a_broken_policy_is_refused_in_one_line_before_anything_is_written(
    lawn: Command,  # noqa: F811
    source: str,
    expected: str,
) -> None:
    name = f"cli_broken_{abs(hash(source))}"  # a module is imported once a process
    Path(f"policies/{name}.py").write_text(source, encoding="utf-8")
    for command in (["ablate", name, "--recipe", "tiny.yaml"], ["train", "--policy", name, "--out", "run"]):
        refused = lawn(*command)
        assert refused.status == 2
        assert expected in refused.err
        assert name in refused.err
        assert len(refused.err.splitlines()) == 1
    assert not Path("tiny").exists()
    assert not Path("run").exists()


@pytest.mark.usefixtures("folder")
def test_without_runs_of_the_default_nothing_is_trained(lawn: Command) -> None:  # noqa: F811
    Path("policies/cli_alone.py").write_text(OWN.format(columns="cell_loads"), encoding="utf-8")
    shutil.rmtree("reference")
    refused = lawn("ablate", "cli_alone", "--recipe", "tiny.yaml")
    assert refused.status == 2
    assert "no finished run of 'mappo' to compare with: run lawn-sb3 reproduce tiny.yaml first" in refused.err
    assert not Path("tiny").exists()


@pytest.mark.usefixtures("folder")
def test_a_trained_actor_is_evaluated_with_any_number_of_uavs(lawn: Command) -> None:  # noqa: F811
    run = "run"
    lawn("train", "--env-steps", "128", "--num-games", "2", *QUICK, "--out", run)
    figures = json.loads(lawn("evaluate", "--run", run, "--episodes", "3", "--set", "num_uavs=9", "--json").out)
    assert figures["welfare_mbps"] == pytest.approx(9 * figures["utility_mbps"])


@pytest.mark.usefixtures("folder")
def test_the_shipped_ablations_are_compared_with_from_any_folder(lawn: Command) -> None:  # noqa: F811
    """A shipped policy is refused, as the shipped recipe has it already: the recipe was found."""
    refused = lawn("ablate", "state_critic")
    assert refused.status == 2
    assert "recipe 'ablation' has policy 'state_critic' already" in refused.err
