"""Identification: the Random row under every candidate, and what follows from it."""

import json
import math

import numpy as np
import pandas as pd
import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.run_directory.columns import evaluation_columns
from lawn_sb3.game.player import RandomPlayer
from lawn_sb3.paper.identification import Identification, as_markdown, identify
from lawn_sb3.paper.identification.candidates import AIRSPACE, LINK_BUDGET, PAPER, TIME, candidates, link_budget_db
from lawn_sb3.paper.identification.findings import findings
from lawn_sb3.paper.identification.joint import Reading
from lawn_sb3.paper.identification.random_row import TESTED, episode_figures, link_budget_interval, z_scores
from lawn_sb3.paper.standard_error import standard_error, verdict
from tests.game.wanderer import Wanderer

FEW = [Reading(PAPER.grid, 3, "clip", leaving, "slot-end") for leaving in ("leaves", "stays")]


@pytest.fixture(scope="module")
def calls() -> list[tuple[int, int]]:
    return []


@pytest.fixture(scope="module")
def result(calls: list[tuple[int, int]]) -> Identification:
    others = {"CTDE-MAPPO": Wanderer()}
    return identify(100, 1, others, lambda done, total: calls.append((done, total)), FEW)


def table(values: dict[str, list[tuple[str, float]]]) -> pd.DataFrame:
    """A table of candidates of which only R-hat is known: constant -> (candidate, z), the preset first."""
    rows = []
    for constant, tried in values.items():
        for index, (candidate, z) in enumerate(tried):
            row = {"constant": constant, "candidate": candidate, "is_preset": index == 0, "against": ""}
            scores = {f"z_{name}": z if name == "rate_mbps" else 0.0 for name in TESTED}
            rows.append({**row, **scores, "verdict": verdict(z)})
    return pd.DataFrame(rows)


def test_every_constant_starts_with_the_value_of_the_preset() -> None:
    tried = pd.DataFrame(candidates())
    firsts = tried.groupby("constant")["is_preset"].first()
    assert firsts.all()
    assert (tried.groupby("constant")["is_preset"].sum() == 1).all()
    assert (tried.groupby("constant").size() > 1).all()


def test_a_candidate_changes_its_own_constant_alone() -> None:
    fields = {
        AIRSPACE: {"width_voxels", "length_voxels", "max_altitude_m"},
        LINK_BUDGET: {"tx_power_dbm"},
        "min_altitude_m": {"min_altitude_m", "max_altitude_m"},
        TIME: set(),
    }
    preset = PAPER.model_dump()
    for candidate in candidates():
        changed = {name for name, value in candidate.scenario.model_dump().items() if value != preset[name]}
        if "with ema_beta" in candidate.label:  # the one joint candidate, which says so
            changed.discard("ema_beta")
        assert changed == (set() if candidate.is_preset else fields.get(candidate.constant, {candidate.constant}))


def test_link_budgets_are_named_by_their_sum() -> None:
    named = [candidate for candidate in candidates() if candidate.constant == LINK_BUDGET]
    assert [candidate.label for candidate in named] == [
        f"{link_budget_db(candidate.scenario):.2f} dB" for candidate in named
    ]
    # 20 - 30 dBm against -174 dBm/Hz over 180 kHz, which is 52.55 dB above 1 Hz.
    assert named[0].label == "111.45 dB"


def test_only_the_sum_of_the_link_budget_counts() -> None:
    shifted = PAPER.changed(tx_power_dbm=PAPER.tx_power_dbm + 7.0, ref_gain_db=PAPER.ref_gain_db - 7.0)
    one, other = (evaluate(RandomPlayer(), scenario, 20, seed=3) for scenario in (PAPER, shifted))
    pd.testing.assert_frame_equal(one, other)


def test_figures_of_an_episode_by_hand() -> None:
    # Two episodes of two UAVs; nobody arrives in the second.
    rows = pd.DataFrame(
        {
            "episode": [0, 0, 1, 1],
            "reward": [1.0, 2.0, 3.0, 5.0],
            "rate_mbps": [10.0, 20.0, 30.0, 50.0],
            "slots": [4, 8, 8, 8],
            "min_slots": [1, 2, 3, 4],
            "arrived": [True, False, False, False],
            "makespan_slots": [8, 8, 8, 8],
        }
    )
    assert set(rows.columns) <= set(evaluation_columns(PAPER, 1))
    figures = episode_figures(rows)
    assert figures["reward"].tolist() == [1.5, 4.0]
    assert figures["success_percent"].tolist() == [50.0, 0.0]
    assert figures["makespan_slots"].tolist() == [8.0, 8.0]
    assert episode_figures(rows, "slots")["makespan_slots"].tolist() == [6.0, 8.0]
    arrivals = episode_figures(rows, "arrived_slots")["makespan_slots"]
    assert arrivals[0] == 4.0
    assert math.isnan(arrivals[1])


def test_standard_error_by_hand() -> None:
    # Variance 4/3 over 4 episodes of ours and 200 of the paper's, half a unit of 0.05: 1/150 + 1/3 + 1/400.
    values = pd.Series([1.0, 3.0, 1.0, 3.0])
    assert standard_error(values, 0.05) == pytest.approx(math.sqrt(1 / 150 + 1 / 3 + 1 / 400))
    # An assumed spread of 2 is larger: 4/200 + 4/4. It also holds where nothing varies.
    assert standard_error(values, 0.0, least_spread=2.0) == pytest.approx(math.sqrt(1.02))
    assert standard_error(pd.Series([7.0] * 4), 0.0, least_spread=2.0) == pytest.approx(math.sqrt(1.02))
    # Half of the episodes have no value: variance 2 over 2 of ours and 100 of the paper's.
    assert standard_error(pd.Series([1.0, 3.0, np.nan, np.nan]), 0.0) == pytest.approx(math.sqrt(2 / 100 + 2 / 2))


def test_the_least_flight_time_speaks_only_against_missions_that_take_too_long() -> None:
    figures = episode_figures(evaluate(RandomPlayer(), PAPER, 20, seed=3))
    assert z_scores(figures, figures)["min_slots"] == 0.0
    longer = figures.assign(min_slots=figures["min_slots"] + 100.0)
    assert z_scores(longer, figures)["min_slots"] > 0.0


@pytest.mark.parametrize(
    ("z", "word"), [(0.0, "agrees"), (-1.9, "agrees"), (2.1, "disfavoured"), (-3.1, "ruled out"), (9.0, "ruled out")]
)
def test_verdict_goes_by_the_distance_on_either_side(z: float, word: str) -> None:
    assert verdict(z) == word


def test_link_budget_interval_by_hand() -> None:
    # z = (budget - 104) / 2 or less, so that |z| = 2 at 100 and 108.
    tried = table({LINK_BUDGET: [("b", 0.0), ("a", -3.0), ("c", 3.0)]}).assign(link_budget_db=[104.0, 98.0, 110.0])
    assert link_budget_interval(tried) == (100.0, 108.0)
    narrow = tried.assign(z_rate_mbps=[0.0, -1.0, 3.0])
    low, high = link_budget_interval(narrow)
    assert low is None
    assert high == 108.0


def test_findings_say_what_agrees_what_does_not_and_what_moves_the_same_figure(result: Identification) -> None:
    tried = table(
        {"one": [("a", 0.5), ("b", 4.0)], "two": [("c", 0.5), ("d", -1.5)], "three": [("e", 0.0), ("f", 0.1)]}
    )
    alone = "with all others as in the preset, "
    told = findings(tried, result.linear, result.bounds, result.others, (None, 112.0))
    assert told["one"].startswith(
        "with all others as in the preset, only a (preset) agrees; ruled out: b by R̂ (z = +4.0)."
    )
    assert "R̂ of Random alone, as two do" in told["one"]
    assert told["two"].startswith(f"{alone}c (preset), d agree: not told apart.")
    assert told["three"].endswith("It moves no figure of Random.")


def test_the_airspace_is_read_in_metres(result: Identification) -> None:
    metres, printed = (row for _, row in result.random[result.random["constant"] == AIRSPACE].iterrows())
    assert metres["verdict"] == "agrees"
    assert printed["verdict"] == "ruled out"
    assert {"success_percent", "rate_mbps", "min_slots"} <= set(printed["against"].split(", "))


def test_a_rate_that_nobody_can_have_in_the_printed_time_rules_a_candidate_out(result: Identification) -> None:
    # With T_max in the bias correction a method that is done after 8.75 slots keeps (1 - 0.9^8.75) / (1 - 0.9^100) of
    # at most 58.3 Mbps: 35.1 Mbps, and the paper prints 35.68.
    deadline = result.random[result.random["candidate"] == "deadline"].iloc[0]
    assert deadline["rate_ceiling_mbps"] == pytest.approx(58.28 * (1 - 0.9**8.75) / (1 - 0.9**100), abs=0.01)
    assert deadline["verdict"] == "ruled out"
    assert "rate_ceiling_mbps" in deadline["against"]


def test_readings_of_the_mean_time_share_all_other_figures(result: Identification) -> None:
    times = result.random[result.random["constant"] == TIME]
    for name in TESTED:
        assert times[name].nunique() == (len(times) if name == "makespan_slots" else 1)


def test_equal_seeds_give_equal_results(result: Identification) -> None:
    again = identify(100, seed=1, others={"CTDE-MAPPO": Wanderer()}, jointly=FEW)
    assert again.as_json() == result.as_json()


def test_progress_counts_every_flight(result: Identification, calls: list[tuple[int, int]]) -> None:
    total = calls[0][1]
    assert calls == [(done, total) for done in range(1, total + 1)]


def test_json_holds_every_table_and_nothing_but_numbers_and_texts(result: Identification) -> None:
    content = json.loads(json.dumps(result.as_json(), allow_nan=False))
    random = pd.DataFrame(**content["random"])
    assert len(random) == len(candidates())
    assert random["reward"][0] == result.random["reward"][0]
    assert set(content["findings"]) == {candidate.constant for candidate in candidates()} | {"reward", "bounds"}


def test_what_is_kept_gives_the_same_page_and_is_kept_the_same(result: Identification) -> None:
    again = Identification.from_json(json.loads(result.as_text()))
    assert as_markdown(again) == as_markdown(result)
    assert again.as_text() == result.as_text()
    assert "## Jointly" in as_markdown(again)


def test_page_shows_every_candidate_with_its_verdict(result: Identification) -> None:
    lines = as_markdown(result).splitlines()
    for _, row in result.random.iterrows():
        name = f"{row['candidate']} (preset)" if row["is_preset"] else row["candidate"]
        own = [line for line in lines if f"| {name} " in line and f" {row['verdict']} " in line]
        assert any(f"{row['rate_mbps']:.2f} ({row['z_rate_mbps']:+.1f})" in line for line in own), name


def test_too_few_episodes_are_refused() -> None:
    with pytest.raises(UserError, match="episodes = 19: at least 20"):
        identify(19)


def test_a_player_needs_a_row_in_the_paper() -> None:
    with pytest.raises(UserError, match=r"'MAPPO'.*CTDE-MAPPO"):
        identify(20, others={"MAPPO": Wanderer()})
