"""What the paper leaves open: each constant and reading in doubt, with the values that might be meant."""

from typing import Any, Literal, NamedTuple

from lawn_sb3.scenario import PRESETS, Scenario

PAPER = PRESETS["paper"]
PRINTED = PRESETS["as-printed"]

AIRSPACE = "airspace"
LINK_BUDGET = "link_budget"
TIME = "mean_time"

TimeReading = Literal["makespan_slots", "slots", "arrived_slots"]
"""What the column T-bar averages: the slots of an episode's last UAV, of all UAVs, or of those that arrive."""

ALTERNATIVES: dict[str, tuple[Any, ...]] = {
    "gbs_layout": ("corners",),
    "gbs_height_m": (10.0, 20.0, 30.0),  # over the quarter points, heights of 5, 15 and 25 m are voxel centres
    "ema_beta": (0.01, 0.05, 0.2, 0.5, 0.9),
    "nav_weight": (0.0, 0.25, 1.0),
    "collision_penalty": (0.0, 0.5, 2.0, 5.0),
    "fail_penalty": (1.0, 2.5, 10.0),
    "rate_unit": ("mbps", 10.0, 100.0),
    "out_of_bounds": ("hover",),
    "arrived_uav": ("stays",),
    "arrival": ("fly-through",),
    "bias_horizon": ("deadline",),
}
"""Fields of the scenario and the values to try besides the preset's."""

POWER_STEPS_DB = (-6.0, -3.0, -1.0, 1.0, 3.0, 6.0)
FLOORS_M = (10.0, 20.0, 50.0, 100.0)

REWARD_CONSTANTS = ("nav_weight", "collision_penalty", "fail_penalty", "rate_unit", "ema_beta", "bias_horizon")
"""Constants that change what a flight is worth, never where it goes."""


class Candidate(NamedTuple):
    """One value for one open constant, all others as in the preset ``paper``."""

    constant: str
    label: str
    scenario: Scenario
    is_preset: bool
    time: TimeReading = "makespan_slots"


def link_budget_db(scenario: Scenario) -> float:
    """The signal-to-noise ratio at 1 m, P_tx + beta_0 - sigma^2 in dB: all that Eq. (2), eq:rate, knows of them."""
    return scenario.tx_power_dbm + scenario.ref_gain_db - scenario.noise_power_dbm


def candidates() -> list[Candidate]:
    """All candidates, those of a constant side by side, the preset's value first."""
    found = []
    for constant, choices in _choices().items():
        for label, changes in choices.items():
            scenario = PAPER.changed(**changes)
            found.append(Candidate(constant, label, scenario, is_preset=scenario == PAPER))
    return [*found, *_times()]


def _choices() -> dict[str, dict[str, dict[str, Any]]]:
    """Constant: label: changes of the preset."""
    sizes = ("width_voxels", "length_voxels", "max_altitude_m")
    power_dbm, thickness_m = PAPER.tx_power_dbm, PAPER.max_altitude_m - PAPER.min_altitude_m
    choices: dict[str, dict[str, dict[str, Any]]] = {
        AIRSPACE: {
            f"{_size(PAPER)} (metres)": {},
            f"{_size(PRINTED)} (as printed)": {name: getattr(PRINTED, name) for name in sizes},
        },
        LINK_BUDGET: {
            f"{link_budget_db(PAPER) + step:.2f} dB": {"tx_power_dbm": power_dbm + step}
            for step in (0.0, *POWER_STEPS_DB)
        },
        "min_altitude_m": {
            _label(floor): {"min_altitude_m": floor, "max_altitude_m": floor + thickness_m}
            for floor in (PAPER.min_altitude_m, *FLOORS_M)
        },
    }
    for name, values in ALTERNATIVES.items():
        choices[name] = {_label(value): {name: value} for value in (getattr(PAPER, name), *values)}
    # A horizon that this EMA rules out another may allow.
    choices["bias_horizon"]["deadline, with ema_beta 0.2"] = {"bias_horizon": "deadline", "ema_beta": 0.2}
    return choices


def _times() -> list[Candidate]:
    readings: dict[str, TimeReading] = {
        "the last UAV's (makespan)": "makespan_slots",
        "all UAVs'": "slots",
        "the arriving UAVs'": "arrived_slots",
    }
    return [
        Candidate(TIME, label, PAPER, is_preset=reading == "makespan_slots", time=reading)
        for label, reading in readings.items()
    ]


def _size(scenario: Scenario) -> str:
    return " x ".join(map(str, scenario.grid))


def _label(value: Any) -> str:
    return value if isinstance(value, str) else f"{value:g}"
