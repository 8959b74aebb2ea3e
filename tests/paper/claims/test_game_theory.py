"""Claims about the game: whether it has a potential, and whether a policy collects the welfare that there is."""

import pandas as pd
import pytest

from lawn_sb3.paper.claims import Evidence, Finding
from lawn_sb3.paper.claims.evidence import CannotTellError
from lawn_sb3.paper.claims.game_theory import (
    congestion_game,
    solving_intractable,
    welfare_maximising,
    welfare_uneven,
    welfare_unfair,
)
from lawn_sb3.paper.roles import FORMS
from tests.handmade import (
    PARTS,
    evidence,
    flown,
    flown_by_seed,
    measured,
    player,
    recipe_of_parts,
    responded,
    results_of,
)


def judged(**utilities_mbps: list[list[float]]) -> Finding:
    return welfare_maximising(measured("utility_mbps", **utilities_mbps))


def test_a_policy_that_earns_less_than_a_planner_does_not_maximise() -> None:
    less, level = [[36.0, 38.0]] * 2, [[39.0, 41.0], [41.0, 43.0]]
    planners = {"forecast": [[39.5, 41.5]] * 2, "welfare": [[45.5, 47.5]] * 2}
    below = judged(mappo=less, mappo_o=less, **planners)
    assert below.verdict == "contradicted"
    # -3.5 and -9.5 in both seeds and missions: no spread, so the interval is the difference.
    assert below.figure.startswith(
        "MAPPO: mean U -3.50 [-3.50, -3.50] Mbps against FORECAST, -9.50 [-9.50, -9.50] Mbps against WELFARE; "
    )
    assert below.why.endswith("; MAPPO and MAPPO-O do.")
    # 40 and 42: 0.5 and -5.5 with a standard error of 1, so 12.7 to both sides. Nobody knows the largest welfare.
    reached = judged(mappo=level, mappo_o=level, **planners)
    assert reached.verdict == "not shown"
    assert judged(mappo=less, mappo_o=level, **planners).verdict == "not shown"


@pytest.mark.parametrize("missing", ["welfare", "forecast"])
def test_without_a_planner_nobody_can_tell(missing: str) -> None:
    flights = {role: [[1.0], [1.0]] for role in ("mappo", "mappo_o", "welfare", "forecast") if role != missing}
    with pytest.raises(CannotTellError, match=f"player {missing}"):
        judged(**flights)


# Two UAVs with x and y have the Gini coefficient |x - y| / 2(x + y): 0.25 for 10 and 30, 0 for 20 and 20.
EVEN, UNEVEN = [20.0, 20.0], [10.0, 30.0]


def flown_jointly(**by_role: list[float]) -> Evidence:
    flights = (flown_by_seed(role, 2, utility_mbps=[own] * 2) for role, own in by_role.items())
    return evidence(*flights, recipe=recipe_of_parts(episodes=2))


def test_one_episode_less_even_than_selfish_flights_shows_that_fairness_is_not_guaranteed() -> None:
    assert welfare_unfair(flown_jointly(welfare=EVEN + EVEN, equilibrium=UNEVEN + EVEN)).verdict == "contradicted"
    found = welfare_unfair(flown_jointly(welfare=UNEVEN + EVEN, equilibrium=[*EVEN, 5.0, 35.0]))
    assert found.verdict == "reproduced"
    # Less have the UAV with 10 instead of 20, and the one with 20 instead of 35. Least: 10 and 20, against 20 and 5.
    assert found.figure == (
        "WELFARE against EQUILIBRIUM: 50 % of the episodes are less even, 50 % of the UAVs have less; mean U of the "
        "UAV that has least 15.0 against 12.5 Mbps"
    )


def test_unevenness_on_average_is_judged_against_selfish_and_straight_flights() -> None:
    def verdict(welfare: list[float], equilibrium: list[float], straight: list[float]) -> str:
        return welfare_uneven(flown_jointly(welfare=welfare, equilibrium=equilibrium, straight=straight)).verdict

    assert verdict(UNEVEN + EVEN, EVEN + EVEN, EVEN + EVEN) == "reproduced"
    assert verdict(UNEVEN + EVEN, EVEN + EVEN, UNEVEN + UNEVEN) == "partly"
    assert verdict(EVEN + EVEN, UNEVEN + EVEN, UNEVEN + UNEVEN) == "contradicted"


@pytest.mark.parametrize(
    ("regret", "bound", "verdict"),
    [(0.0, 60.0, "not shown"), (0.5, 60.0, "not shown"), (0.0, 50.0, "contradicted"), (0.5, 50.0, "not shown")],
)
def test_a_game_is_solved_by_certified_equilibria_and_a_welfare_near_its_bound(
    regret: float, bound: float, verdict: str
) -> None:
    methods = {role: PARTS[role] for role in (*FORMS, "welfare", "equilibrium")} | {"bound": player("bound")}
    utilities = {**dict.fromkeys(FORMS, 30.0), "welfare": 49.9, "equilibrium": 45.0, "bound": bound}
    flights = {role: flown(role, 0, 2, utility_mbps=[own] * 2) for role, own in utilities.items()}
    results = results_of(recipe_of_parts(methods, episodes=1), *flights.values())
    results.regrets = responded("equilibrium", 0, flights["equilibrium"], [45.0, 45.0 + regret])
    found = solving_intractable(Evidence(results))
    assert found.verdict == verdict
    assert found.figure.startswith(f"certified equilibria in {1 if regret == 0.0 else 0} of 1 test episodes; ")


def cycles(*gains: tuple[float, float]) -> Evidence:
    rows = pd.DataFrame(gains, columns=["rate_gain_mbps", "log_rate_gain"])
    return evidence(deviation_cycles=rows)


def test_a_potential_needs_all_gains_around_cycles_to_add_up_to_nothing() -> None:
    assert congestion_game(cycles((0.0, 0.0), (1e-15, 0.0))).verdict == "reproduced"
    rates = congestion_game(cycles((0.0, 0.0), (-6.5, 1e-15), (2.0, 0.0)))
    assert rates.verdict == "partly"
    assert rates.figure == (
        "gains around 3 closed cycles of four deviations do not add up to 0 in 2 for rates (by up to 6.5 Mbps), in 0 "
        "for log-rates"
    )
    assert congestion_game(cycles((1.0, 0.1))).verdict == "contradicted"
