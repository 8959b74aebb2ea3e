"""Every example on a page does what the page says, as it stands there."""

import re
from pathlib import Path

import pytest
import yaml

from lawn_sb3.experiment.build import build_model
from lawn_sb3.experiment.registry import REPOSITORY
from lawn_sb3.experiment.weights import save_tensors
from lawn_sb3.scenario import load_scenario
from tests.cli.running import ABLATED, exit_status, recipe
from tests.docs.pages import PAGES, blocks, prose
from tests.experiment.training import qmix_cell

TRIED = {
    "README.md": ("PositionsCriticPolicy", "make_vec_env"),
    "docs/policies.md": ("NearestCriticPolicy",),
    "docs/other-trainers.md": ("make_vec_env", "ActorPlayer"),
    "docs/run-directory.md": ("load_file",),
    "docs/planners.md": ("PrioritisedPlayer",),
}
"""What the Python examples of each page hold, by which the tests below find them."""


def example(page: str, holds: str) -> str:
    """The only Python example of a page that holds something."""
    (code,) = (code for code in blocks(page, "python") if holds in code)
    return code


def test_every_python_example_is_tried_below() -> None:
    for page in PAGES:
        if page.startswith("docs/trainers/"):  # tried by tests/trainers
            assert len(blocks(page, "python")) == 1, page
            continue
        assert len(blocks(page, "python")) == len(TRIED.get(page, ())), page
        for holds in TRIED.get(page, ()):
            assert example(page, holds)


def test_what_a_trainer_needs_is_pinned_and_belongs_to_a_page() -> None:
    for path in (REPOSITORY / "tests" / "trainers" / "requirements").iterdir():
        assert f"docs/trainers/{path.stem}.md" in PAGES
        assert [
            line for line in path.read_text("utf-8").splitlines() if not re.fullmatch(r"[\w.-]+==[\w.]+", line)
        ] == []


@pytest.fixture(scope="module")
def ablated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("ablated")
    recipe(folder, methods=ABLATED)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert exit_status("reproduce", "tiny.yaml") == 0
    return folder


@pytest.mark.parametrize(
    ("page", "holds"), [("README.md", "PositionsCriticPolicy"), ("docs/policies.md", "NearestCriticPolicy")]
)
def test_a_policy_is_trained_and_compared_by_the_command_beside_it(
    page: str, holds: str, ablated: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (name,) = set(re.findall(r"policies/(\w+)\.py`, in the folder", prose(page)))
    assert f"lawn-sb3 ablate {name}\n" in "".join(blocks(page, ""))
    (ablated / "policies").mkdir(exist_ok=True)
    (ablated / "policies" / f"{name}.py").write_text(example(page, holds), encoding="utf-8")
    monkeypatch.chdir(ablated)
    assert exit_status("ablate", name, "--recipe", "tiny.yaml") == 0
    assert name in (ablated / "tiny" / name / "report" / "effects.md").read_text(encoding="utf-8")


def test_a_scenario_and_a_recipe_of_ones_own_are_flown_by_the_command_beside_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenario, text = blocks("README.md", "yaml")
    assert blocks("docs/scenarios-and-recipes.md", "yaml") == [scenario, text]
    assert "`lawn-sb3 reproduce runs/mine.yaml`" in prose("README.md")
    monkeypatch.chdir(tmp_path)
    Path("mine.yaml").write_text(scenario, encoding="utf-8")
    game = load_scenario("mine.yaml")
    assert (game.num_uavs, game.num_gbs) == (6, 3)
    assert "env_steps: 50000" in text
    shorter = yaml.safe_load(text.replace("env_steps: 50000", "env_steps: 2048"))
    shorter |= {"seeds": shorter["seeds"][:1], "evaluation": {"episodes": 5, "watch_episodes": 5}}
    Path("runs").mkdir()
    Path("runs/mine.yaml").write_text(yaml.safe_dump(shorter), encoding="utf-8")
    assert exit_status("reproduce", "runs/mine.yaml") == 0
    assert "MAPPO" in Path("runs/mine/report/table2.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("page", ["README.md", "docs/other-trainers.md"])
def test_the_environment_is_used_from_python(page: str, capsys: pytest.CaptureFixture[str]) -> None:
    code = example(page, "make_vec_env")
    assert page != "README.md" or len([line for line in code.splitlines() if line]) <= 10
    exec(compile(code, page, "exec"), {})
    assert "flying" in capsys.readouterr().out


def test_a_planner_of_ones_own_is_scored_like_the_others(capsys: pytest.CaptureFixture[str]) -> None:
    exec(compile(example("docs/planners.md", "PrioritisedPlayer"), "planners.md", "exec"), {})
    first, second = (float(text) for text in re.findall(r"mean U (\d+\.\d) Mbps", capsys.readouterr().out))
    assert 30.0 < first < second < 55.0


def test_an_actor_of_any_project_is_scored_like_the_others(capsys: pytest.CaptureFixture[str]) -> None:
    exec(compile(example("docs/other-trainers.md", "ActorPlayer"), "other-trainers.md", "exec"), {})
    assert 0.0 < float(re.findall(r"(\d+\.\d) % arrive", capsys.readouterr().out)[0]) < 100.0


def test_the_weights_of_a_run_are_read_without_the_kit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    cell = qmix_cell(tmp_path / "runs" / "mine")
    model = build_model(cell)
    cell.directory.mkdir(parents=True)
    save_tensors(model, cell.directory / "weights.safetensors")
    monkeypatch.chdir(tmp_path)
    code = example("docs/run-directory.md", "load_file")
    assert "lawn_sb3" not in code
    exec(compile(code, "run-directory.md", "exec"), {})
    lines, shape = capsys.readouterr().out.splitlines(), model.policy.state_dict()["q_net.0.weight"].shape
    assert f"q_net.0.weight {tuple(shape)}" in lines
    assert {line.split(".")[0] for line in lines} == {"q_net", "mixer"}
