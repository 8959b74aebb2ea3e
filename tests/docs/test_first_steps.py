"""The notebook for newcomers runs from top to bottom, and is kept without what it printed."""

import json
import os
from typing import Any

import pytest

from lawn_sb3.experiment.registry import REPOSITORY

PATH = REPOSITORY / "docs" / "first_steps.ipynb"
MISSING = "the notebook is not run: install nbclient and ipykernel by pip"


def test_it_is_kept_without_outputs() -> None:
    cells = json.loads(PATH.read_text(encoding="utf-8"))["cells"]
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in cells if "outputs" in cell)


@pytest.mark.slow
def test_it_runs_from_top_to_bottom(monkeypatch: pytest.MonkeyPatch) -> None:
    nbformat, nbclient = (pytest.importorskip(name, reason=MISSING) for name in ("nbformat", "nbclient"))
    pytest.importorskip("ipykernel", reason=MISSING)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, [str(REPOSITORY), os.environ.get("PYTHONPATH")])))
    notebook: Any = nbformat.read(PATH, as_version=4)
    nbclient.NotebookClient(notebook, timeout=1200, kernel_name="python3").execute()
    printed = [str(output) for cell in notebook.cells for output in cell.get("outputs", ())]
    assert sum("image/png" in text for text in printed) == 3  # the airspace, the comparison, the replay
    for words in (
        "utility_mbps",
        "uav_0",
        "Welfare",
        "the run is in runs/positions",
        "Δ U (Mbps)",
        "page: replay.html",
    ):
        assert any(words in text for text in printed), words
