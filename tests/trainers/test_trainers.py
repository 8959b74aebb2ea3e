"""Every trainer's example trains as it stands on its page, in its own environment (``make test-trainers``)."""

import math
import re
import subprocess
import sys
from pathlib import Path

import pytest

from lawn_sb3.experiment.registry import REPOSITORY
from tests.docs.pages import blocks

READS_NO_MASK = {"agilerl", "skrl"}
"""Whose UAVs do not only hover once they are done."""
PAGES = sorted(path.stem for path in (REPOSITORY / "docs" / "trainers").glob("*.md"))
LINE = re.compile(r"^(\w+): (?:(-?[\d.]+) untrained, (-?[\d.]+) after )?(\d+) env steps", re.MULTILINE)


def interpreter(trainer: str) -> str:
    """The Python that has a trainer: that of its environment, or this one if it needs nothing else."""
    if not (REPOSITORY / "tests" / "trainers" / "requirements" / f"{trainer}.txt").exists():
        return sys.executable
    python = REPOSITORY / ".venvs" / trainer / "bin" / "python"
    if not python.exists():
        pytest.fail(f"make .venvs/{trainer}/installed builds what {trainer} needs")
    return str(python)


@pytest.mark.parametrize("trainer", PAGES)
def test_the_example_trains_for_as_long_as_it_says(trainer: str, tmp_path: Path) -> None:
    (code,) = blocks(f"docs/trainers/{trainer}.md", "python")
    done = subprocess.run(
        [interpreter(trainer), "-c", code],
        cwd=tmp_path,
        env={"PATH": "/usr/bin:/bin", "HOME": str(tmp_path), "PYTHONPATH": str(REPOSITORY), "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3_000:]
    lines = LINE.findall(done.stdout)
    named = re.findall(r"\b(?:ENV_STEPS|env_steps)\b[^\n]*?\b(\d+_\d+)\b", code)
    budget = max(int(text.replace("_", "")) for text in named)
    assert len(lines) == (3 if trainer == "benchmarl" else 1)
    for _, untrained, trained, env_steps in lines:
        assert budget <= int(env_steps) < 1.3 * budget
        if trainer != "benchmarl":  # whose three algorithms train too briefly to have learnt
            assert math.isfinite(float(trained))
            assert float(trained) > float(untrained)
    warned = "is done, so its action" in done.stderr
    assert warned == (trainer in READS_NO_MASK), done.stderr[-3_000:]
