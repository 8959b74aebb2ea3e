"""Comparisons: intervals decide, and every part of a verdict can be worked out by hand."""

import pytest

from lawn_sb3.paper.claims import Finding
from lawn_sb3.paper.claims.comparisons import (
    better_than,
    both_factors,
    loads_suffice,
    mixer_limits,
    rate_comparable,
    value_decomposition,
)
from lawn_sb3.paper.claims.evidence import CannotTellError
from lawn_sb3.paper.claims.rule_parts import join
from lawn_sb3.paper.roles import FORMS, cast
from tests.handmade import evidence, flown_by_seed, measured, method_of, recipe_of_parts


def lead(own: list[list[float]], other: list[list[float]]) -> Finding:
    return better_than(measured("utility_mbps", mappo=own, qmix=other), "utility_mbps", ["mappo"], ["qmix"])


def test_a_lead_with_its_whole_interval_is_reproduced() -> None:
    # Seeds mean 29 and 31; QMIX 4 and 4. The variance of 2 over two seeds makes a standard error of 1: 26 +- 12.71.
    found = lead([[28.0, 30.0], [31.0, 31.0]], [[4.0, 4.0], [3.0, 5.0]])
    assert found.verdict == "reproduced"
    assert found.figure == "MAPPO: mean U 26.00 [13.29, 38.71] Mbps against QMIX"
    assert found.why == "Every difference has to lie on the claimed side of 0, and does."


@pytest.mark.parametrize(
    ("own", "verdict", "word"),
    [
        ([[3.0], [5.0]], "not shown", "MAPPO cannot be told from QMIX"),  # differences -1 and 1
        ([[15.0], [17.0]], "not shown", "MAPPO cannot be told from QMIX"),  # 12 +- 12.71, though both seeds are ahead
        ([[4.0], [4.0]], "not shown", "MAPPO is level with QMIX"),  # equal in every seed and mission: who leads?
        ([[-10.0], [-8.0]], "contradicted", "MAPPO does worse than QMIX"),  # -13 +- 12.71
    ],
)
def test_a_lead_may_be_contradicted_or_not_shown(own: list[list[float]], verdict: str, word: str) -> None:
    found = lead(own, [[4.0], [4.0]])
    assert found.verdict == verdict
    assert found.why == f"Every difference has to lie on the claimed side of 0; {word}."


def test_rounding_is_no_lead() -> None:
    assert lead([[0.1 + 0.2], [0.1 + 0.2]], [[0.3], [0.3]]).verdict == "not shown"


def test_one_of_two_forms_ahead_is_partly() -> None:
    found = measured("utility_mbps", mappo=[[1.0]] * 2, mappo_o=[[9.0]] * 2, qmix=[[4.0]] * 2)
    finding = better_than(found, "utility_mbps", ["mappo", "mappo-o"], ["qmix"])
    assert finding.verdict == "partly"
    assert "MAPPO: mean U -3.00 [-3.00, -3.00] Mbps against QMIX; MAPPO-O: mean U 5.00" in finding.figure


def test_a_form_has_to_beat_every_rival() -> None:
    found = measured("utility_mbps", mappo=[[5.0]] * 2, qmix=[[4.0]] * 2, iql=[[6.0]] * 2)
    finding = better_than(found, "utility_mbps", ["mappo"], ["qmix", "iql"])
    assert finding.verdict == "contradicted"
    assert "MAPPO does worse than IQL" in finding.why
    assert "QMIX" not in finding.why


def test_of_times_less_is_better() -> None:
    found = measured("makespan_slots", mappo=[[5]] * 2, qmix=[[40]] * 2)
    assert better_than(found, "makespan_slots", ["mappo"], ["qmix"], lower=True).verdict == "reproduced"
    assert better_than(found, "makespan_slots", ["qmix"], ["mappo"], lower=True).verdict == "contradicted"


@pytest.mark.parametrize(("slots", "verdict"), [(7.4, "reproduced"), (7.42, "partly")])
def test_a_sizeable_lead_is_at_least_a_tenth_of_the_papers(slots: float, verdict: str) -> None:
    # The paper: 8.7 against 34.6 slots, a lead of 25.9; a tenth is 2.59. Here 10 - 7.4 = 2.6 and 10 - 7.42 = 2.58.
    found = measured("makespan_slots", mappo=[[slots]] * 2, qmix=[[10]] * 2)
    finding = better_than(found, "makespan_slots", ["mappo"], ["qmix"], lower=True, sizeable=True)
    assert finding.verdict == verdict
    noted = "the lead is below a tenth of the paper's for MAPPO over QMIX (paper -25.90)" in finding.why
    assert noted == (verdict == "partly")


def test_success_is_in_points() -> None:
    # Three of four missions against one: differences 0, 100, 100, 0, mean 50, and 3.182 times 100 / sqrt(3) / sqrt(4).
    found = measured("arrived", mappo=[[True, True, True, False]] * 2, qmix=[[True, False, False, False]] * 2)
    assert "success 50.00 [-41.87, 141.87] points" in better_than(found, "success_percent", ["mappo"], ["qmix"]).figure


def test_one_seed_gives_no_interval_and_no_verdict() -> None:
    with pytest.raises(CannotTellError, match="at least two seeds"):
        lead([[5.0]], [[4.0]])


def test_methods_may_have_different_numbers_of_seeds() -> None:
    # Variance 1 over three seeds: standard error 0.577. With 2 degrees of freedom 4.303 of them count: 2 +- 2.48.
    found = lead([[5.0], [6.0], [7.0]], [[4.0], [4.0]])
    assert found.figure == "MAPPO: mean U 2.00 [-0.48, 4.48] Mbps against QMIX"


def test_what_makes_missions_hard_for_both_does_not_widen_an_interval() -> None:
    found = lead([[1.0, 101.0], [101.0, 1.0]], [[0.0, 100.0], [100.0, 0.0]])
    assert found.figure == "MAPPO: mean U 1.00 [1.00, 1.00] Mbps against QMIX"


@pytest.mark.parametrize(
    ("rate", "verdict"),
    [(33.0, "reproduced"), (27.0, "reproduced"), (33.12, "reproduced"), (26.88, "reproduced"), (33.2, "contradicted")],
)
def test_rates_are_comparable_within_the_papers_own_difference(rate: float, verdict: str) -> None:
    # The paper: 35.68 against 38.80 Mbps, 3.12 apart; QMIX here has 30.
    finding = rate_comparable(measured("rate_mbps", **dict.fromkeys(FORMS, [[rate]] * 2), qmix=[[30.0]] * 2))
    assert finding.verdict == verdict
    assert "a difference of 3.12 Mbps comparable" in finding.why


def test_rates_are_not_comparable_because_seeds_do_not_tell_them_apart() -> None:
    # Both forms 0 +- 12.71 * 1: nothing is found, and nothing beyond 3.12 is excluded.
    rates = {role: [[29.0], [31.0]] for role in FORMS}
    assert rate_comparable(measured("rate_mbps", **rates, qmix=[[30.0]] * 2)).verdict == "not shown"


def test_bounds_that_are_no_0_are_tested_among_all_others() -> None:
    # CTDE-MAPPO is ahead by 0.4, 0.5 and 0.6: standard error 0.1 / sqrt(3) = 0.058 with 2 degrees of freedom. Against
    # 0.18 that is t = (0.5 - 0.18) / 0.058 = 5.5, p = 0.03: enough alone, and not among two.
    found = measured("reward", **{role: [[3.4], [3.5], [3.6]] for role in FORMS}, qmix=[[3.0]] * 3)
    assert value_decomposition(found).verdict == "reproduced"
    assert set(found.tests.p_values) == {("reward", role, "qmix", "0.18") for role in FORMS}
    found.tests.correct()  # 0.03 > 0.05 / 2
    assert value_decomposition(found).verdict == "not shown"


def test_comparable_needs_rows_of_the_paper() -> None:
    own = {"mappo": method_of("mappo", paper_row=None), "qmix": method_of("qmix")}
    found = evidence(*(flown_by_seed(key, rate_mbps=[[30.0]] * 2) for key in own), recipe=recipe_of_parts(own))
    with pytest.raises(CannotTellError, match="row in the paper's Table II"):
        rate_comparable(found)


@pytest.mark.parametrize(
    ("destinations", "verdict"),
    [
        ([30.0, 30.0], "reproduced"),
        ([30.5, 30.5], "reproduced"),  # a tenth of an RB is 0.547 Mbps
        ([29.5, 29.5], "reproduced"),
        ([30.6, 30.6], "contradicted"),
        ([29.4, 29.4], "not shown"),  # it is told more and earns less, which says nothing of the loads
        ([30.0, 30.04], "reproduced"),  # 0.02 +- 12.71 * 0.02, within
        ([29.9, 30.1], "not shown"),  # 0 +- 12.71 * 0.1, and so 0 may or may not be the whole difference
        ([30.98, 31.02], "contradicted"),  # 1 +- 12.71 * 0.02
        ([30.5, 30.7], "not shown"),
    ],
)
def test_loads_suffice_if_being_told_more_is_of_no_use(destinations: list[float], verdict: str) -> None:
    # With the loads 30 Mbps in every seed, without 20.
    utilities = {"knows-nothing": [20.0] * 2, "knows-loads": [30.0] * 2, "knows-destinations": destinations}
    flights = (flown_by_seed(role, utility_mbps=[[own] for own in by_seed]) for role, by_seed in utilities.items())
    finding = loads_suffice(evidence(*flights))
    assert finding.verdict == verdict
    assert finding.figure.endswith("KNOWS-LOADS: 10.00 [10.00, 10.00] Mbps against KNOWS-NOTHING")


@pytest.mark.parametrize(("qmix", "verdict"), [(3.0, "reproduced"), (3.05, "contradicted"), (3.5, "contradicted")])
def test_ruled_out_is_a_method_as_far_behind_as_in_the_paper(qmix: float, verdict: str) -> None:
    # The paper: 3.19 against 3.01. CTDE-MAPPO has 3.2 here: 0.2 and 0.15 ahead.
    finding = value_decomposition(measured("reward", **dict.fromkeys(FORMS, [[3.2]] * 2), qmix=[[qmix]] * 2))
    assert finding.verdict == verdict
    assert "(paper +0.18); success of QMIX 100.0 %" in finding.figure


def test_a_lead_that_may_or_may_not_be_the_papers_is_not_shown() -> None:
    # 0.1 and 0.3 behind: 0.2 +- 1.27.
    finding = value_decomposition(measured("reward", **dict.fromkeys(FORMS, [[3.2]] * 2), qmix=[[3.1], [2.9]]))
    assert finding.verdict == "not shown"
    assert finding.why.endswith("by 0.18 at least: 0 of 2 do, 2 cannot be told.")


@pytest.mark.parametrize(
    ("qmix", "additive", "verdict"),
    [(4.0, 3.0, "reproduced"), (4.0, 4.5, "partly"), (6.0, 3.0, "partly"), (6.0, 7.0, "contradicted")],
)
def test_a_mixer_limits_if_qmix_is_behind_and_a_simpler_mixer_further(
    qmix: float, additive: float, verdict: str
) -> None:
    rewards = {**dict.fromkeys(("mappo", "mappo_o"), 5.0), "qmix": qmix, "qmix_additive": additive}
    assert mixer_limits(measured("reward", **{role: [[own]] * 2 for role, own in rewards.items()})).verdict == verdict


def test_lists_are_written_as_in_a_sentence() -> None:
    assert [join(list("abc")[:count]) for count in (1, 2, 3)] == ["a", "a and b", "a, b and c"]


def punctual(rates_mbps: list[float], slots: list[int]) -> Finding:
    """Both forms of CTDE-MAPPO with these rates and flight times on missions of nine slots, beside straight flight."""
    flights = {
        role: flown_by_seed(role, rate_mbps=[rates_mbps] * 2, slots=[slots] * 2, min_slots=[[9] * 2] * 2)
        for role in FORMS
    }
    straight = flown_by_seed("straight", rate_mbps=[[30.0, 32.0]] * 2, reward=[[3.0, 4.0]] * 2)
    return both_factors(evidence(*flights.values(), straight, recipe=recipe_of_parts(episodes=2)))


@pytest.mark.parametrize(
    ("rates_mbps", "slots", "verdict"),
    [
        ([40.0, 42.0], [9, 9], "reproduced"),  # in time, and 10 Mbps more than straight flight in both missions
        ([30.0, 32.0], [9, 9], "partly"),  # in time, with the rate that comes by itself
        ([40.0, 42.0], [90, 90], "partly"),  # the rate alone: T_min/T is a tenth
        ([20.0, 22.0], [90, 90], "contradicted"),
    ],
)
def test_both_factors_have_to_be_achieved(rates_mbps: list[float], slots: list[int], verdict: str) -> None:
    finding = punctual(rates_mbps, slots)
    assert finding.verdict == verdict
    assert finding.figure.endswith(", whose J̄ is 3.50")


def test_no_entropy_bonus_is_told_from_the_default() -> None:
    methods = {"base": method_of("mappo-o", settings={"ent_coef": "lin_0.02"}), "without": method_of("no-entropy")}
    found = evidence(recipe=recipe_of_parts(methods)).results.recipe.methods
    assert cast(found) | {"mappo-o": "base", "no-entropy": "without"} == cast(found)
