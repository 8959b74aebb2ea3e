"""Players of finished runs: whose stand for the rows of the paper's Table II."""

from pathlib import Path

from lawn_sb3.cli.tools import ASKED
from lawn_sb3.experiment.players import ModelPlayer, kept_player
from lawn_sb3.experiment.registry import REPOSITORY


def test_the_paper_s_own_critic_stands_for_ctde_mappo_among_the_reference_results() -> None:
    assert list(ASKED.items()) == [("CTDE-MAPPO", "mappo-state"), ("QMIX", "qmix")]  # the order of the tables
    for method in ASKED.values():
        player = kept_player(REPOSITORY / "runs" / "reference" / "paper" / method)
        assert isinstance(player, ModelPlayer)
        assert player.name == method


def test_a_method_without_kept_networks_has_no_player(tmp_path: Path) -> None:
    (tmp_path / "qmix" / "seed-0").mkdir(parents=True)
    assert kept_player(tmp_path / "qmix") is None
    assert kept_player(tmp_path / "nowhere") is None
