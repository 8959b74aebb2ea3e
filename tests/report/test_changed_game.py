"""Changed games are named for readers: in words, with all that is changed, by symbol and unit where there are any."""

import pytest

from lawn_sb3.report.changed_game import game_label
from lawn_sb3.scenario import Scenario


@pytest.mark.parametrize(
    ("name", "changes", "label"),
    [
        ("as-is", {}, "as is"),
        ("link-budget-halved", {"tx_power_dbm": 16.99}, "link budget halved (P_tx = 16.99 dBm)"),
        ("fail-penalty-halved", {"fail_penalty": 2.5}, "fail penalty halved (r_fail = 2.5)"),
        ("ema_beta_halved", {"ema_beta": 0.05}, "EMA beta halved (β = 0.05)"),
        ("nav-weight-doubled", {"nav_weight": 1.0}, "nav weight doubled (ω = 1 per voxel)"),
        ("rate-unit-halved", {"rate_unit": 27.35}, "rate unit halved (rate unit = 27.35 Mbps)"),
        ("in-mbps", {"rate_unit": "mbps"}, "in mbps (rate unit = mbps)"),
        (
            "stays",
            {"arrived_uav": "stays", "tx_power_dbm": 25.94, "width_voxels": 9},
            "stays (W = 9 voxels, P_tx = 25.94 dBm, arrived UAV = stays)",
        ),
        ("mixed", {"rbs_per_gbs": (10, 10, 5, 5)}, "mixed (rbs per GBS = (10, 10, 5, 5))"),
    ],
)
def test_a_changed_game_is_named_in_words_with_what_is_changed(
    name: str, changes: dict[str, object], label: str
) -> None:
    assert game_label(name, Scenario().changed(**changes), Scenario()) == label


def test_what_the_recipe_changes_in_every_game_is_not_named() -> None:
    usual = Scenario().changed(num_uavs=8)
    assert game_label("loud", usual.changed(tx_power_dbm=30.0), usual) == "loud (P_tx = 30 dBm)"
