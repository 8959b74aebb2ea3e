"""Swapping a policy on the command line: one file, one command, a comparison; a broken one is refused in one line."""

import json
import shutil
from pathlib import Path

import pandas as pd
import pytest

from tests.cli.running import ABLATED, QUICK, Lawn, exit_status, recipe

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
    recipe(folder, methods=ABLATED, scaling=SCALING)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for command in ("reproduce", "export"):
            assert exit_status(command, "tiny.yaml") == 0
    shutil.rmtree(folder / "tiny")
    return folder


@pytest.fixture(autouse=True)
def _folder(kept: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A copy of it to work in, with a policy of one's own."""
    shutil.copytree(kept, tmp_path / "work")
    monkeypatch.chdir(tmp_path / "work")
    Path("policies").mkdir()


def test_what_is_kept_of_an_ablation_rebuilds_its_report(lawn: Lawn) -> None:
    report = Path("reference/tiny/report")
    before = {path.name: path.read_bytes() for path in report.iterdir()}
    assert {"effects.md", "effects_forest.png", "scaling_out.png", "scaling.csv"} <= set(before)
    assert json.loads(before["report.json"])["problems"] == []
    shutil.rmtree(report)
    lawn("report", "tiny.yaml", "--runs", "reference/tiny")
    assert {path.name: path.read_bytes() for path in report.iterdir()} == before


def test_a_file_and_a_command_give_a_policys_effect_beside_the_others(lawn: Lawn) -> None:
    Path("policies/cli_own.py").write_text(OWN.format(columns="cell_loads"), encoding="utf-8")
    assert "cli_own" in lawn("ablate", "cli_own", "--recipe", "tiny.yaml").out
    effects = pd.read_csv("tiny/cli_own/report/effects.csv")
    assert dict(zip(effects["key"], effects["seeds"], strict=True)) == {"mappo": 2, "raw": 2, "cli_own": 2}
    assert sorted(path.name for path in Path("tiny").iterdir()) == ["cli_own"]  # nothing else was trained
    assert "2 of 2 runs are finished already" in lawn("ablate", "cli_own", "--recipe", "tiny.yaml").err


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        (OWN.format(columns="cell_loads") + READS_X, "reads the global state"),
        (OWN.format(columns="cel_loads"), "cel_loads"),
        ("import nothing_of_that_name", "ModuleNotFoundError"),
        (OWN.format(columns="cell_loads").replace("(CTDEPolicy)", "(object)"), "must hold one policy class, found 0"),
    ],
)
def test_a_broken_policy_is_refused_in_one_line_before_anything_is_written(
    lawn: Lawn,
    source: str,
    expected: str,
) -> None:
    name = f"cli_broken_{abs(hash(source))}"  # a module is imported once a process
    Path(f"policies/{name}.py").write_text(source, encoding="utf-8")
    for command in (["ablate", name, "--recipe", "tiny.yaml"], ["train", "--policy", name, "--out", "run"]):
        said = lawn(*command, status=2).err
        assert expected in said
        assert name in said
    assert not Path("tiny").exists()
    assert not Path("run").exists()


def test_without_runs_of_the_default_it_is_trained_too(lawn: Lawn) -> None:
    Path("policies/cli_alone.py").write_text(OWN.format(columns="cell_loads"), encoding="utf-8")
    shutil.rmtree("reference")
    lawn("ablate", "cli_alone", "--recipe", "tiny.yaml")
    effects = pd.read_csv("tiny/cli_alone/report/effects.csv")
    assert dict(zip(effects["key"], effects["seeds"], strict=True)) == {"mappo": 2, "cli_alone": 2}


def test_a_trained_actor_is_evaluated_with_any_number_of_uavs(lawn: Lawn) -> None:
    lawn("train", "--env-steps", "128", "--num-games", "2", *QUICK, "--out", "run")
    figures = json.loads(lawn("evaluate", "--run", "run", "--episodes", "3", "--set", "num_uavs=9", "--json").out)
    assert figures["welfare_mbps"] == pytest.approx(9 * figures["utility_mbps"])
