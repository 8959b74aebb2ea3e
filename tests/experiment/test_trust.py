"""Whose code a run's files can make run: the kit's, that of installed packages, and what the user vouches for."""

from dataclasses import replace
from pathlib import Path

import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.run_directory.configuration import load_run, write_configuration

EVIL = "from pathlib import Path\nPath('ran').touch()\n"


@pytest.mark.parametrize("policy", ["evil", "evil_module:Policy"])
def test_a_policy_that_a_run_names_is_imported_only_if_it_is_trusted(
    policy: str, small_cell: Cell, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "policies").mkdir()
    for path in (tmp_path / "policies" / "evil.py", tmp_path / "evil_module.py"):
        path.write_text(EVIL)
    small_cell.directory.mkdir(parents=True)
    method = small_cell.method.model_copy(update={"policy": policy})
    write_configuration(replace(small_cell, method=method))
    with pytest.raises(UserError, match=f"--trust {policy} allows it"):
        load_run(small_cell.directory)
    assert load_run(small_cell.directory, [policy]).method.policy == policy
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("policy", ["state_critic", "stable_baselines3.ppo:MlpPolicy"])
def test_what_comes_with_the_kit_needs_no_word(policy: str, small_cell: Cell) -> None:
    small_cell.directory.mkdir(parents=True)
    method = small_cell.method.model_copy(update={"policy": policy})
    write_configuration(replace(small_cell, method=method))
    assert load_run(small_cell.directory).method.policy == policy
