"""Finished runs read back: whose players stand for the rows of the paper's Table II."""

from __future__ import annotations

from pathlib import Path

from lawn_sb3.cli.tools import ASKED
from lawn_sb3.experiment.finished_run import trained_players
from lawn_sb3.experiment.registry import REPOSITORY


def test_the_paper_s_own_critic_stands_for_ctde_mappo_among_the_reference_results() -> None:
    players = trained_players(REPOSITORY / "runs/reference/paper", ASKED)
    assert {row: player.name for row, player in players.items()} == {"CTDE-MAPPO": "mappo-state", "QMIX": "qmix"}


def test_methods_without_kept_networks_are_left_out(tmp_path: Path) -> None:
    (tmp_path / "qmix" / "seed-0").mkdir(parents=True)
    assert trained_players(tmp_path, {"QMIX": "qmix", "IQL": "iql"}) == {}
    assert trained_players(tmp_path / "nowhere", {"QMIX": "qmix"}) == {}
