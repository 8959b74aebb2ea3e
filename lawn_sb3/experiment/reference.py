"""Reference results: what a finished recipe left, without checkpoints, small enough to be kept with the code."""

import shutil
from collections.abc import Collection, Sequence
from pathlib import Path

from lawn_sb3.experiment.build import build_model
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.run_directory.configuration import check_finished
from lawn_sb3.experiment.run_directory.files import CONFIG_FILE, FINISHED_FILE, RESULT_FILES, WEIGHTS_FILE
from lawn_sb3.experiment.run_directory.manifest import check_unaltered, keep_manifest
from lawn_sb3.experiment.weights import load_networks, save_weights


def export_runs(
    cells: Sequence[Cell], root: Path, folder: Path, files: Collection[str] = (*RESULT_FILES, WEIGHTS_FILE)
) -> int:
    """Copy finished runs: their rows, curves and provenance, and the weights of each method's first seed.

    :param cells: the cells of a recipe without changed games
    :param root: the folder of its runs
    :param folder: where the copies go; runs that are there already are replaced
    :param files: the files to keep besides the configuration, of those that a run has
    :return: bytes written
    :raises UserError: naming the first run that is not finished, or not as it was left
    """
    check_finished(cells)
    for cell in cells:
        check_unaltered(cell.directory)
    with_weights: set[str] = set()
    written = 0
    for cell in cells:
        target = folder / cell.directory.relative_to(root)
        shutil.rmtree(target, ignore_errors=True)
        target.mkdir(parents=True)
        for name in (CONFIG_FILE, FINISHED_FILE, *files):
            if (cell.directory / name).exists():
                shutil.copyfile(cell.directory / name, target / name)
        if WEIGHTS_FILE in files and cell.method.algo is not None and cell.key not in with_weights:
            with_weights.add(cell.key)
            model = build_model(cell, device="cpu")
            load_networks(model, cell.directory)
            save_weights(model, target / WEIGHTS_FILE)
        keep_manifest(target, cell.directory)
        written += sum(path.stat().st_size for path in target.iterdir())
    return written
