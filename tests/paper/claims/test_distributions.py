"""Distributions of the utility: width, median, evenness, collapse, and what makes utilities low."""

from typing import Any

import pytest

from lawn_sb3.paper.claims import Finding
from lawn_sb3.paper.claims.distributions import collapses, collision_free, larger, uneven_by_congestion
from lawn_sb3.paper.claims.evidence import CannotTellError, Evidence
from lawn_sb3.paper.roles import FORMS
from tests.handmade import evidence, flown_by_seed, measured

TENS = [float(10 * k) for k in range(11)]
"""0, 10 ... 100: 10th percentile 10, median 50, 90th percentile 90."""


def test_the_width_is_that_of_the_middle_eighty_percent() -> None:
    narrow = [40.0 + k for k in range(11)]  # 41 to 49
    found = measured("utility_mbps", mappo=[TENS] * 2, qmix=[narrow] * 2)
    finding = larger(found, "width", ["mappo"], ["qmix"])
    assert finding.verdict == "reproduced"
    assert "MAPPO: 80.0 [80.0, 80.0] Mbps; QMIX: 8.0 [8.0, 8.0] Mbps" in finding.figure
    assert larger(found, "width", ["qmix"], ["mappo"]).verdict == "contradicted"
    assert larger(found, "median", ["mappo"], ["qmix"]).figure == (
        "median of U: MAPPO: 50.0 [50.0, 50.0] Mbps; QMIX: 45.0 [45.0, 45.0] Mbps"
    )


def test_one_of_two_forms_larger_is_partly_and_equal_is_not_larger() -> None:
    more = [value + 1.0 for value in TENS]
    found = measured("utility_mbps", mappo=[TENS] * 2, mappo_o=[more] * 2, qmix=[TENS] * 2)
    finding = larger(found, "median", ["mappo", "mappo-o"], ["qmix"])
    assert finding.verdict == "partly"
    assert finding.why.endswith("1 of 2 does, 1 cannot be told.")


def test_unevenness_is_that_within_an_episode() -> None:
    # Two UAVs: 0 and 30 has a Gini coefficient of 1/2, 15 and 15 of 0, whatever the other episodes have.
    uneven, even = [0.0, 30.0, 0.0, 30.0], [15.0, 15.0, 90.0, 90.0]
    found = measured("utility_mbps", 2, mappo=[uneven] * 2, qmix=[even] * 2)
    finding = larger(found, "gini", ["mappo"], ["qmix"])
    assert finding.verdict == "reproduced"
    assert "MAPPO: 0.500 [0.500, 0.500]; QMIX: 0.000 [0.000, 0.000]" in finding.figure


def test_a_shape_needs_two_seeds() -> None:
    with pytest.raises(CannotTellError, match="two seeds"):
        larger(measured("utility_mbps", mappo=[TENS], qmix=[TENS]), "width", ["mappo"], ["qmix"])


def test_a_collapse_is_nearly_all_utilities_near_zero_in_every_seed() -> None:
    low, some = [0.0] * 9 + [40.0], [0.0] * 8 + [40.0] * 2  # 90 % and 80 % below
    none = [0.0] * 10
    found = measured("utility_mbps", iql=[low, low], random=[none, some], qmix=[some])
    assert collapses(found, ["iql"], 5, 90).verdict == "reproduced"
    assert collapses(found, ["random"], 5, 90).verdict == "contradicted"
    finding = collapses(found, ["iql", "random"], 5, 90)
    assert finding.verdict == "partly"
    assert finding.figure == "IQL: 90.0 [90.0, 90.0] % of the UAVs; RANDOM: 90.0 [80.0, 100.0] % of the UAVs"
    assert finding.why.endswith("less than 5 Mbps: IQL does; RANDOM does not.")
    assert collapses(found, ["qmix"], 5, 80).verdict == "reproduced"  # one seed will do: no interval decides


def test_a_single_collision_breaks_the_constraint() -> None:
    never, once = [[0, 0], [0, 0]], [[0, 0], [0, 3]]

    def judged(*collisions: list[list[int]]) -> Finding:
        return collision_free(measured("collisions", **dict(zip(FORMS, collisions, strict=True)), straight=once))

    assert judged(never, never).verdict == "reproduced"
    assert judged(once, once).verdict == "contradicted"
    assert judged(never, once).verdict == "partly"
    # One UAV of two in one of two seeds; those that fly straight are told beside.
    assert "MAPPO-O: 25.0 [0.0, 50.0] % of the UAVs collide" in judged(never, once).figure
    assert judged(never, never).figure.endswith("STRAIGHT: 25.0 [0.0, 50.0] % of the UAVs collide")


ALONE_AND_CROWDED: dict[str, Any] = {
    "mean_cell_load": [1.0, 1.0, 4.0, 4.0],
    "rate_mbps": [50.0, 50.0, 10.0, 10.0],
    "min_slots": [5, 5, 5, 5],
    "slots": [5, 5, 10, 10],
    "utility_mbps": [50.0, 50.0, 5.0, 5.0],
}


def unevenness(straight_utility: list[float], **changes: list[Any]) -> Evidence:
    """Two equal seeds of both forms in which the crowded have a fifth of the rate and take twice the time."""
    own: dict[str, Any] = {name: [values * 50] * 2 for name, values in {**ALONE_AND_CROWDED, **changes}.items()}
    return evidence(
        *(flown_by_seed(role, **own) for role in FORMS),
        flown_by_seed("straight", utility_mbps=[straight_utility * 50] * 2),
    )


def test_a_policy_that_sacrifices_the_crowded_for_all_is_reproduced() -> None:
    # Width 45 against 0, mean 27.5 against 20 Mbps: differences of 30 and -15 in 100 missions each, whose mean is off
    # by 1.97 times 22.5 / sqrt(199).
    finding = uneven_by_congestion(unevenness([20.0] * 4))
    assert finding.verdict == "reproduced"
    assert "rank correlation of R̂ with cell load -1.00" in finding.figure
    assert "least loaded 2.000 [2.000, 2.000]" in finding.figure
    assert "width of U 45.0 [45.0, 45.0] Mbps, mean U 7.50 [4.35, 10.65] Mbps" in finding.figure
    assert "not found" not in finding.why


@pytest.mark.parametrize(
    ("straight", "changes", "missing"),
    [
        ([40.0] * 4, {}, "a gain for all"),
        ([60.0, 0.0, 0.0, 0.0], {"utility_mbps": [30.0] * 4}, "more unevenness"),
        ([20.0] * 4, {"slots": [5, 5, 5, 5]}, "longer flights"),
    ],
)
def test_what_is_not_shown_is_named(straight: list[float], changes: dict[str, list[Any]], missing: str) -> None:
    finding = uneven_by_congestion(unevenness(straight, **changes))
    assert finding.verdict == "partly"
    assert finding.why.endswith(f"not found: {missing} (MAPPO), {missing} (MAPPO-O).")


def test_that_rates_are_lower_in_loaded_cells_does_not_count() -> None:
    finding = uneven_by_congestion(unevenness([20.0] * 4, rate_mbps=[30.0] * 4))
    assert finding.verdict == "reproduced"
    assert "rank correlation of R̂ with cell load 0.00" in finding.figure  # with what never varies


def test_the_contrary_of_all_of_it_is_contradicted() -> None:
    found = unevenness([60.0, 60.0, 0.0, 0.0], rate_mbps=[30.0] * 4, slots=[5] * 4, utility_mbps=[30.0] * 4)
    assert uneven_by_congestion(found).verdict == "contradicted"


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"mean_cell_load": [1.0] * 4}, "cells of different loads"),
        ({"mean_cell_load": [1.0, 1.0, 1.0, 4.0], "arrived": [True, True, True, False]}, "cells of different loads"),
        ({"arrived": [False] * 4}, "completed missions of MAPPO"),
        # Quarters that cannot be told apart: the first four of five missions flew alone.
        (
            {name: [*values, values[-1]] for name, values in ALONE_AND_CROWDED.items()}
            | {"mean_cell_load": [1.0] * 4 + [4.0]},
            "cells of different loads",
        ),
    ],
)
def test_without_missions_in_different_cells_congestion_cannot_be_told(changes: dict[str, Any], reason: str) -> None:
    with pytest.raises(CannotTellError, match=reason):
        uneven_by_congestion(unevenness([20.0] * 4, **changes))


def test_longer_flights_that_may_be_chance_are_not_shown() -> None:
    # T/T_min of the loaded is 2 and 1.2 times as much, above 1 in both seeds: 1.6 +- 12.71 * 0.4.
    columns: dict[str, Any] = {name: [values * 50] * 2 for name, values in ALONE_AND_CROWDED.items()}
    columns["slots"] = [[5, 5, 10, 10] * 50, [5, 5, 6, 6] * 50]
    flat = flown_by_seed("straight", utility_mbps=[[20.0] * 200] * 2)
    finding = uneven_by_congestion(evidence(*(flown_by_seed(role, **columns) for role in FORMS), flat))
    assert finding.why.endswith("not found: longer flights (MAPPO), longer flights (MAPPO-O).")


def test_failed_missions_do_not_count_as_long_flights() -> None:
    # The only mission that took longer failed.
    changes: dict[str, Any] = {"slots": [5, 5, 5, 100], "arrived": [True, True, True, False]}
    finding = uneven_by_congestion(unevenness([20.0] * 4, **changes))
    assert "longer flights (MAPPO)" in finding.why
