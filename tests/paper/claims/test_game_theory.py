"""Claims about the game: whether it has a potential, and whether a policy collects the welfare that there is."""

import pandas as pd
import pytest

from lawn_sb3.paper.claims import Evidence, Finding
from lawn_sb3.paper.claims.evidence import CannotTellError
from lawn_sb3.paper.claims.game_theory import congestion_game, welfare_maximising, welfare_unfair
from tests.handmade import evidence, flown_by_seed, measured, recipe_of_parts


def judged(**utilities_mbps: list[list[float]]) -> Finding:
    return welfare_maximising(measured("utility_mbps", **utilities_mbps))


def test_a_policy_that_earns_less_than_the_planner_does_not_maximise() -> None:
    less, level, welfare = [[36.0, 38.0]] * 2, [[45.0, 47.0], [47.0, 49.0]], [[46.0, 47.0]] * 2
    below = judged(mappo=less, mappo_o=less, welfare=welfare)
    assert below.verdict == "not reproduced"
    # 37 against 46.5 in both seeds: no spread, so the interval is the difference.
    assert below.figure.startswith("WELFARE: mean U 46.50 Mbps; MAPPO: -9.50 [-9.50, -9.50] Mbps against it; ")
    assert below.why.endswith("; MAPPO and MAPPO-O do.")
    # 46 and 48 against 46.5: 0.5 with a standard error of 1, so 12.7 to both sides.
    reached = judged(mappo=level, mappo_o=level, welfare=welfare)
    assert reached.verdict == "reproduced"
    assert "0.50 [-12.21, 13.21]" in reached.figure
    mixed = judged(mappo=less, mappo_o=level, welfare=welfare)
    assert mixed.verdict == "partly"
    assert mixed.why.endswith("; MAPPO does.")


def test_without_the_planner_nobody_can_tell() -> None:
    with pytest.raises(CannotTellError, match="player welfare"):
        judged(mappo=[[1.0], [1.0]])


def test_fairness_is_judged_on_average_and_episode_by_episode() -> None:
    # Two UAVs with x and y have the Gini coefficient |x - y| / 2(x + y): 0.25 for 10 and 30, 0 for 20 and 20.
    even, uneven = [20.0, 20.0], [10.0, 30.0]
    recipe = recipe_of_parts(episodes=2)

    def evenness(welfare: list[float], equilibrium: list[float]) -> Finding:
        flights = {"welfare": welfare, "equilibrium": equilibrium}
        return welfare_unfair(
            evidence(*(flown_by_seed(role, 2, utility_mbps=[own] * 2) for role, own in flights.items()), recipe=recipe)
        )

    assert evenness(uneven + uneven, even + even).verdict == "reproduced"
    assert evenness(even + even, uneven + even).verdict == "not reproduced"
    sometimes = evenness(uneven + even, [8.0, 32.0, *even])  # 0.125 against 0.15 on average
    assert sometimes.verdict == "not reproduced"
    mixed = evenness(uneven + even, [*even, 5.0, 35.0])  # 0.25 and 0 against 0 and 0.375
    assert mixed.verdict == "partly"
    assert "difference -0.062 [-0.062, -0.062]; in 50 % of the episodes WELFARE is the less even one" in mixed.figure


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
    assert congestion_game(cycles((1.0, 0.1))).verdict == "not reproduced"
