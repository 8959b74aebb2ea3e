"""Scenarios: the constants of the presets, files and overrides, and what is refused."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from pydantic import ValidationError

from lawn_sb3.errors import UserError
from lawn_sb3.scenario import PRESETS, Scenario, load_scenario
from tests.game.random_play import scenarios

PAPER = PRESETS["paper"]


def test_paper_has_the_constants_of_table_i() -> None:
    assert PAPER.name == "paper"
    assert PAPER.num_uavs == 4
    assert PAPER.num_gbs == 4
    assert PAPER.voxel_size_m == 10.0
    assert PAPER.max_voxel_steps == 3
    assert PAPER.max_slots == 100
    assert PAPER.num_rbs.tolist() == [10, 10, 10, 10]
    assert PAPER.rb_bandwidth_hz == 180e3
    assert PAPER.path_loss_exponent == 2.0


def test_paper_has_the_constants_inferred_from_its_figures() -> None:
    assert (PAPER.tx_power_dbm, PAPER.ref_gain_db, PAPER.noise_density_dbm_hz) == (20.0, -30.0, -174.0)
    assert PAPER.ema_beta == 0.1
    assert (PAPER.nav_weight, PAPER.collision_penalty, PAPER.fail_penalty) == (0.5, 1.0, 5.0)
    assert (PAPER.rate_unit, PAPER.bias_horizon) == ("lone-uav", "completion")
    assert (PAPER.out_of_bounds, PAPER.arrived_uav, PAPER.arrival) == ("clip", "leaves", "slot-end")


@pytest.mark.parametrize(("preset", "grid"), [("paper", (10, 10, 3)), ("as-printed", (100, 100, 30))])
def test_presets_read_the_printed_grid_as_metres_or_voxels(preset: str, grid: tuple[int, int, int]) -> None:
    scenario = load_scenario(preset)
    assert scenario.name == preset
    assert scenario.grid == grid
    assert scenario.num_voxels == math.prod(grid)


def test_presets_differ_in_nothing_but_the_airspace() -> None:
    paper, printed = (load_scenario(name).model_dump() for name in ("paper", "as-printed"))
    changed = {key for key in paper if paper[key] != printed[key]}
    assert changed == {"name", "width_voxels", "length_voxels", "max_altitude_m"}


def test_noise_power_is_the_density_over_one_rb() -> None:
    # -174 dBm/Hz + 10 log10(180,000) = -174 + 52.553 = -121.447 dBm
    assert PAPER.noise_power_dbm == pytest.approx(-121.447, abs=5e-4)


def test_snr_at_one_metre_is_transmit_power_times_gain_over_noise() -> None:
    # 20 - 30 + 121.447 = 111.447 dB
    assert 10 * math.log10(PAPER.snr_at_1m) == pytest.approx(111.447, abs=5e-4)


@pytest.mark.parametrize(("preset", "low", "high"), [("paper", 25.0, 75.0), ("as-printed", 250.0, 750.0)])
def test_gbss_stand_on_the_quarter_points_of_the_area(preset: str, low: float, high: float) -> None:
    sites = PRESETS[preset].gbs_positions
    assert sites.tolist() == [[low, low, 0.0], [low, high, 0.0], [high, low, 0.0], [high, high, 0.0]]


def test_gbss_can_stand_in_the_corners() -> None:
    sites = PAPER.changed(gbs_layout="corners", gbs_grid=(2, 3), gbs_height_m=7.0).gbs_positions
    assert sites.tolist() == [[x, y, 7.0] for x in (0.0, 100.0) for y in (0.0, 50.0, 100.0)]


def test_single_gbs_stands_in_the_middle_in_either_layout() -> None:
    for layout in ("tile-centres", "corners"):
        assert PAPER.changed(gbs_layout=layout, gbs_grid=(1, 1)).gbs_positions.tolist() == [[50.0, 50.0, 0.0]]


def test_explicit_gbs_positions_replace_the_grid() -> None:
    scenario = PAPER.changed(gbs_positions_m=[(1, 2, 3), (40, 50, 60)], rbs_per_gbs=[4, 7])
    assert scenario.num_gbs == 2
    assert scenario.gbs_positions.tolist() == [[1.0, 2.0, 3.0], [40.0, 50.0, 60.0]]
    assert scenario.num_rbs.tolist() == [4, 7]


def test_positions_are_voxel_centres() -> None:
    # (2 + 0.5) * 10 = 25, (0 + 0.5) * 10 = 5, and the airspace begins at 60 m: 60 + (1 + 0.5) * 10 = 75
    raised = PAPER.changed(min_altitude_m=60.0, max_altitude_m=90.0)
    assert raised.grid == (10, 10, 3)
    assert raised.voxel_centre((2, 0, 1)).tolist() == [25.0, 5.0, 75.0]
    many = np.array([[2, 0, 1], [0, 0, 0]])
    assert raised.voxel_centre(many).tolist() == [[25.0, 5.0, 75.0], [5.0, 5.0, 65.0]]


def test_scenario_cannot_be_changed_in_place() -> None:
    with pytest.raises(ValidationError):
        PAPER.num_uavs = 5  # type: ignore[misc]


def test_every_constant_says_its_symbol_unit_source_and_meaning() -> None:
    for name, field in Scenario.model_fields.items():
        if name != "name":
            extra: Any = field.json_schema_extra
            assert extra["symbol"], name
            assert extra["unit"], name
            assert extra["source"] in {"stated", "inferred", "chosen"}
            assert field.description, name


@given(scenario=scenarios())
@settings(max_examples=50)
def test_any_scenario_survives_yaml(tmp_path_factory: pytest.TempPathFactory, scenario: Scenario) -> None:
    path = tmp_path_factory.mktemp("scenario") / "copy.yaml"
    path.write_text(scenario.to_yaml(), encoding="utf-8")
    assert load_scenario(str(path)) == scenario


def test_file_needs_only_what_differs_and_is_named_after_itself_and_overrides_go_over_it(tmp_path: Path) -> None:
    path = tmp_path / "crowded.yml"
    path.write_text("num_uavs: 8\nrb_bandwidth_hz: 360e3\n", encoding="utf-8")
    crowded = PAPER.changed(name="crowded", num_uavs=8, rb_bandwidth_hz=360e3)
    assert load_scenario(str(path)) == crowded
    assert load_scenario(str(path), ["num_uavs=6"]) == crowded.changed(num_uavs=6)


def refusal(name: str, *overrides: str) -> str:
    with pytest.raises(UserError) as error:
        load_scenario(name, overrides)
    message = str(error.value)
    assert "\n" not in message
    return message


def missing(words: tuple[str, ...], message: str) -> list[str]:
    return [word for word in words if word not in message]


# Each impossible value, and the field, value and bound that the refusal must name.
IMPOSSIBLE: dict[str, tuple[str, ...]] = {
    "rb_bandwidth_hz=-180e3": ("rb_bandwidth_hz", "-180e3", "greater than 0"),
    "rb_bandwidth_hz=0": ("rb_bandwidth_hz = 0", "greater than 0"),
    "ema_beta=0": ("ema_beta = 0", "greater than or equal to"),
    "ema_beta=1": ("ema_beta = 1", "less than 1"),
    "ema_beta=1.5": ("ema_beta = 1.5", "less than 1"),
    "min_altitude_m=40": ("min_altitude_m = 40", "below max_altitude_m = 30"),
    "min_altitude_m=30": ("min_altitude_m = 30", "below max_altitude_m = 30"),
    "min_altitude_m=-10": ("min_altitude_m = -10", "greater than or equal to 0"),
    "max_altitude_m=35": ("max_altitude_m", "35 m", "whole number of voxels", "10 m"),
    "voxel_size_m=0": ("voxel_size_m = 0", "greater than or equal to 0.001"),
    "width_voxels=0": ("width_voxels = 0", "greater than or equal to 1"),
    "length_voxels=0": ("length_voxels = 0", "greater than or equal to 1"),
    "num_uavs=0": ("num_uavs = 0", "greater than or equal to 1"),
    "num_uavs=2.5": ("num_uavs = 2.5", "whole number"),
    "num_uavs=151": ("num_uavs = 151", "300 voxels", "at most 150"),
    "max_voxel_steps=0": ("max_voxel_steps = 0", "greater than or equal to 1"),
    "max_slots=0": ("max_slots = 0", "greater than or equal to 1"),
    "rbs_per_gbs=0": ("rbs_per_gbs = 0", "1 to 1000000 RBs"),
    "rbs_per_gbs=[10, 0, 10, 10]": ("rbs_per_gbs = (10, 0, 10, 10)", "1 to 1000000 RBs"),
    "rbs_per_gbs=[10, 10]": ("rbs_per_gbs", "2 GBSs", "has 4"),
    "rbs_per_gbs=many": ("rbs_per_gbs", "'many'", "whole number"),
    "gbs_grid=[0, 2]": ("gbs_grid = (0, 2)", "at least 1"),
    "gbs_height_m=-1": ("gbs_height_m = -1", "greater than or equal to 0"),
    "gbs_height_m=15": ("GBS 0", "(25.0, 25.0, 15.0)", "voxel centre"),
    "gbs_positions_m=[[1, 2, 0], [95, 5, 25]]": ("GBS 1", "(95.0, 5.0, 25.0)", "voxel centre"),
    "gbs_positions_m=[]": ("gbs_positions_m", "at least one"),
    "gbs_positions_m=[[1, 2, .nan]]": ("gbs_positions_m.0.2 = nan", "finite"),
    "path_loss_exponent=0": ("path_loss_exponent = 0", "greater than 0"),
    "tx_power_dbm=.nan": ("tx_power_dbm = nan", "finite"),
    "ref_gain_db=.inf": ("ref_gain_db = inf", "finite"),
    "noise_density_dbm_hz=-.inf": ("noise_density_dbm_hz = -inf", "finite"),
    "nav_weight=-0.5": ("nav_weight = -0.5", "greater than or equal to 0"),
    "collision_penalty=-1": ("collision_penalty = -1", "greater than or equal to 0"),
    "fail_penalty=-5": ("fail_penalty = -5", "greater than or equal to 0"),
    "rate_unit=kbps": ("rate_unit = 'kbps'", "'lone-uav' or 'mbps'"),
    "rate_unit=-2": ("rate_unit = -2", "greater than 0"),
    "out_of_bounds=bounce": ("out_of_bounds = 'bounce'", "'clip' or 'hover'"),
    "arrived_uav=parks": ("arrived_uav = 'parks'", "'leaves' or 'stays'"),
    "arrival=soon": ("arrival = 'soon'", "'slot-end' or 'fly-through'"),
    "bias_horizon=never": ("bias_horizon = 'never'", "'completion' or 'deadline'"),
    "gbs_layout=ring": ("gbs_layout = 'ring'", "'tile-centres' or 'corners'"),
    "num_uav=8": ("unknown key 'num_uav' (did you mean 'num_uavs'?); known: arrival,",),
    "num_uavs=true": ("num_uavs = True", "no constant is true or false"),
    "tx_power_dbm=1.0e+6": ("tx_power_dbm", "less than or equal to 100"),
    "tx_power_dbm=-400": ("tx_power_dbm", "greater than or equal to -100"),
    "path_loss_exponent=4000": ("path_loss_exponent", "less than or equal to 10"),
    "ema_beta=1.0e-17": ("ema_beta = 1e-17", "greater than or equal to"),
    "rbs_per_gbs=99999999999999999999999": ("rbs_per_gbs", "1 to 1000000 RBs"),
    "max_slots=99999999999999999999999": ("max_slots", "less than or equal to 1000000"),
    "voxel_size_m=1.0e-320": ("voxel_size_m", "greater than or equal to 0.001"),
    "width_voxels=100000000000": ("width_voxels", "less than or equal to 10000"),
}


@pytest.mark.parametrize(("override", "words"), IMPOSSIBLE.items(), ids=IMPOSSIBLE)
def test_impossible_scenario_is_refused_by_field_value_and_bound(override: str, words: tuple[str, ...]) -> None:
    message = refusal("paper", override)
    assert message.startswith("scenario 'paper': ")
    assert missing(words, message) == []


def test_gbs_outside_the_airspace_may_lie_where_a_centre_would_be() -> None:
    assert PAPER.changed(gbs_positions_m=[(-5, 5, 5), (5, 5, 35)]).num_gbs == 2


def test_all_voxels_may_be_origins_and_destinations() -> None:
    assert PAPER.changed(num_uavs=150).num_uavs == 150


def test_changed_refuses_as_loading_does() -> None:
    with pytest.raises(UserError, match="scenario 'paper': ema_beta = 2: must be less than 1"):
        PAPER.changed(ema_beta=2)


def test_unknown_preset_is_refused_with_a_suggestion() -> None:
    assert missing(("'papr'", "did you mean 'paper'?", "as-printed", ".yaml"), refusal("papr")) == []


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("num_uavs: 4\nmax_slotz: 9\n", ("max_slotz", "did you mean 'max_slots'?")),
        ("num_uavs: 0\n", ("num_uavs = 0", "greater than or equal to 1")),
        ("7: 4\n", ("7", "strings")),
        ("- 4\n", ("keys and values",)),
    ],
    ids=["misspelt", "impossible", "number-as-key", "list"],
)
def test_unusable_file_is_refused_by_name(content: str, words: tuple[str, ...], tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(content, encoding="utf-8")
    assert missing((str(path), *words), refusal(str(path))) == []
