"""Reference results: whole, playable, without checkpoints."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from rich.console import Console

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.after_training import add_regrets
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.players import load_player
from lawn_sb3.experiment.reference import export_runs
from lawn_sb3.experiment.run_directory.configuration import is_finished, load_run
from lawn_sb3.experiment.run_directory.files import COSTS_FILE, RESULT_FILES, SCALING_FILE
from lawn_sb3.experiment.run_directory.manifest import read_manifest, write_manifest
from lawn_sb3.experiment.train import run_cell
from lawn_sb3.experiment.verification import verify_run
from tests.experiment.training import ignore


@pytest.fixture
def finished(small_cell: Cell) -> list[Cell]:
    """Two seeds of one method; the second a copy of the first but for its marker."""
    run_cell(small_cell, ignore)
    add_regrets([small_cell], Console(quiet=True))
    second = replace(small_cell, seed=4, directory=small_cell.directory.with_name("seed-4"))
    shutil.copytree(small_cell.directory, second.directory)
    (second.directory / "finished").write_text(second.fingerprint())
    return [small_cell, second]


def test_rows_curves_and_one_models_weights_are_kept(finished: list[Cell], tmp_path: Path) -> None:
    written = export_runs(finished, tmp_path, tmp_path / "reference")
    first, second = (tmp_path / "reference" / cell.directory.relative_to(tmp_path) for cell in finished)
    names = {"config.yaml", "finished", "manifest.json", *RESULT_FILES} - {SCALING_FILE, COSTS_FILE}
    assert {path.name for path in first.iterdir()} == names | {"weights.npz"}
    assert {path.name for path in second.iterdir()} == names
    assert written == sum(path.stat().st_size for folder in (first, second) for path in folder.iterdir())


def test_the_kept_model_plays_as_its_run_was_evaluated(finished: list[Cell], tmp_path: Path) -> None:
    export_runs(finished[:1], tmp_path, tmp_path / "reference")
    kept = load_run(tmp_path / "reference" / finished[0].directory.relative_to(tmp_path))
    assert is_finished(kept)
    one, other = (evaluate(load_player(cell), cell.scenario, 5, 7) for cell in (kept, finished[0]))
    assert one.equals(other)


def test_a_run_that_is_not_finished_is_named_and_nothing_is_written(finished: list[Cell], tmp_path: Path) -> None:
    (finished[1].directory / "finished").unlink()
    with pytest.raises(UserError, match=r"seed-4'?: not finished"):
        export_runs(finished, tmp_path, tmp_path / "reference")
    assert not (tmp_path / "reference").exists()


def test_runs_made_before_there_were_safetensors_and_cards_are_finished_verified_and_kept(
    finished: list[Cell], tmp_path: Path
) -> None:
    for cell in finished:
        manifest = read_manifest(cell.directory)
        assert manifest is not None
        for name in ("weights.safetensors", "README.md"):
            (cell.directory / name).unlink()
        write_manifest(cell.directory, manifest["made"])
        assert is_finished(cell)
    assert verify_run(finished[0].directory).passed
    export_runs(finished, tmp_path, tmp_path / "reference")
    kept = tmp_path / "reference" / finished[0].directory.relative_to(tmp_path)
    assert verify_run(kept).passed
    assert not list(kept.glob("*.safetensors"))
