"""Figures on the pages about other games than the paper's, as in ``test_figures.py``."""

import json

import numpy as np
import pandas as pd
import pytest

from lawn_sb3.experiment.recipe import load_recipe
from lawn_sb3.experiment.registry import REPOSITORY
from lawn_sb3.paper.identification import Identification, as_markdown
from lawn_sb3.paper.identification.allowed import consistent
from lawn_sb3.results.statistics import crossed_t
from tests.docs.pages import PAGES, kept, reference, says, table_rows


def test_more_uavs_than_in_training() -> None:
    at_64 = {name: kept("ablation/scaling", name, num_uavs="64") for name in ("success_percent", "collisions")}
    success, collisions = at_64["success_percent"], at_64["collisions"]
    low, high = (kept("ablation/scaling", f"success_percent_{side}", num_uavs="64") for side in ("low", "high"))
    says(
        "docs/scaling.md",
        f"MAPPO falls to {success['mappo']:.0f} % [{low['mappo']:.0f}, {high['mappo']:.0f}], QMIX to "
        f"{success['qmix']:.0f} %",
    )
    assert success["mappo-blind"] == 100.0
    assert collisions["qmix"] / collisions["random"] == pytest.approx(5.0, abs=0.5)


@pytest.mark.parametrize("ranking", ["ranking_reward", "ranking_utility_mbps"])
@pytest.mark.parametrize("name", ["sensitivity", "readings"])
def test_no_two_methods_change_places(name: str, ranking: str) -> None:
    heading, *games = table_rows(reference(f"{name}/{ranking}.md").read_text("utf-8"))
    assert {row[heading.index("Changed places")] for row in games[1:]} == {"none"}
    says("docs/sensitivity.md", f"({len(games)} games, three seeds, a third of the budget;")


def test_in_the_other_games_learners_hardly_have_more_than_straight_flight() -> None:
    rows = pd.read_csv(reference("readings/ranking_utility_mbps.csv")).pivot(
        index="game", columns="method", values="value"
    )
    lead = rows[["iql", "qmix", "mappo", "mappo-state"]].max(axis=1) - rows["shortest-path"]
    lead = lead.drop("as-is")
    assert len(lead) == 7
    says("docs/sensitivity.md", f"at most {lead.max():.1f} Mbps more utility", f"and up to {-lead.min():.1f} less")


def test_who_leads_where_constants_are_halved_and_doubled() -> None:
    rows = pd.read_csv(reference("sensitivity/ranking_utility_mbps.csv")).pivot(
        index="game", columns="method", values="value"
    )
    learners = rows[["iql", "qmix", "mappo-state"]]
    lead, over_last = rows["mappo"] - learners.max(axis=1), rows["mappo"] - rows["qmix"]
    assert (learners.idxmin(axis=1) == "qmix").all()
    says(
        "docs/sensitivity.md",
        f"in all {len(rows)} games, by {lead.min():.1f} to {lead.max():.1f} Mbps, and {over_last.min():.1f} to "
        f"{over_last.max():.1f} more than QMIX",
        f"beside straight flight it has {(rows['mappo'] - rows['shortest-path']).max():.1f} more at most",
    )


def test_the_readings_that_learners_are_trained_in_are_allowed() -> None:
    kept_games = json.loads((REPOSITORY / "runs" / "reference" / "identify" / "identify.json").read_text("utf-8"))
    allowed = consistent(Identification.from_json(kept_games).games)
    _, *variants = load_recipe(REPOSITORY / "runs" / "readings.yaml").split().values()
    assert len(variants) == 7
    for game in (variant.game() for variant in variants):
        same = (allowed["moves"] == game.out_of_bounds) & ((allowed["tx_power_dbm"] - game.tx_power_dbm).abs() < 0.01)
        for name in ("max_voxel_steps", "arrived_uav", "arrival", "gbs_layout", "bias_horizon"):
            same &= allowed[name] == getattr(game, name)
        for name in ("nav_weight", "fail_penalty", "collision_penalty"):
            same &= (allowed[name] - getattr(game, name)).abs() < 1e-3
        assert [tuple(grid) for grid in allowed.loc[same, "grid"]] == [game.grid], game.title


def test_the_games_that_the_papers_figures_allow() -> None:
    folder = REPOSITORY / "runs" / "reference" / "identify"
    found = Identification.from_json(json.loads((folder / "identify.json").read_text("utf-8")))
    assert as_markdown(found) == (folder / "README.md").read_text("utf-8")
    allowed = consistent(found.games)
    grids = set(allowed["grid"])
    says("docs/sensitivity.md", f"It finds {len(allowed)} games, on {len(grids)} of the 48 grids")
    assert (100, 100, 30) not in grids
    for name in ("moves", "arrived_uav", "arrival", "gbs_layout", "bias_horizon"):
        assert set(allowed[name]) == set(found.games[name]) - {"any"}, name
    drawn = found.conclusions
    straight = drawn["straight_utility_mbps"]
    sight, network = ((drawn[f"{name}_utility_mbps"] / straight - 1.0) * 100.0 for name in ("forecast", "welfare"))
    says(
        "docs/sensitivity.md",
        f"earns {sight.min():.0f} to {sight.max():.0f} % more utility than straight flight in all ten",
        f"{network.min():.0f} to {network.max():.0f} %: the network",
        f"in nine ({drawn['straight_reward'].min():.2f} where",
    )
    assert (len(drawn), int((drawn["straight_reward"] > 3.19).sum())) == (10, 9)
    assert (drawn["straight_success_percent"] == 100.0).all()


def test_the_comparison_in_the_airspace_as_printed() -> None:
    rows = {
        row["key"]: row
        for row in json.loads(reference("as_printed/report.json").read_text("utf-8"))["tables"]["table2"]
    }
    learners = ("iql", "qmix", "mappo", "mappo-state", "mappo-local")
    assert all(rows[key]["success_percent"] > 99.9 for key in learners)
    straight, *others = (
        np.stack(
            [
                pd.read_csv(path).groupby("episode")["utility_mbps"].mean()
                for path in sorted((REPOSITORY / "runs/reference/as_printed" / key).glob("seed-*/evaluation.csv"))
            ]
        )
        for key in ("shortest-path", *learners)
    )
    leads = [crossed_t(utilities, straight).interval for utilities in others]
    assert all(lead.low < 0.0 for lead in leads)  # none is measurably ahead
    state, clock = rows["mappo-state"], rows["clock"]
    says(
        "docs/as-printed.md",
        f"has {clock['utility_mbps']:.1f} Mbps where the best route as if alone has "
        f"{rows['best-route']['utility_mbps']:.1f}, and `forecast`, which plans with what it sees, has "
        f"{rows['forecast']['utility_mbps']:.1f}",
        f"| 3.19 | {state['reward']:.2f} |",
        f"| 8.7 | {state['makespan_slots']:.1f} |",
        f"| 35.68 | {state['rate_mbps']:.2f} |",
        f"| 22.4 | {rows['random']['success_percent']:.1f} |",
    )
    flown = [pd.read_csv(path) for path in (REPOSITORY / "runs/reference/as_printed/clock").glob("*/evaluation.csv")]
    assert all((rows["slots"] == rows["min_slots"]).all() for rows in flown)
    assert len(flown) == 5


SWARM = {
    "straight flight": "shortest-path",
    "best route as if alone": "best-route",
    "the map, `cells`": "cells",
    "the map, `mixed`": "mixed",
    "the map and a forecast, `foresees`": "foresees",
    "`forecast`": "forecast",
    "`mean-field`": "mean-field",
}
"""Rows of the table of docs/scaling.md, and the methods of runs/swarm.yaml."""


def test_swarms() -> None:
    at = {
        n: {name: kept("swarm/scaling", name, num_uavs=str(n)) for name in ("utility_mbps", "success_percent")}
        for n in (4, 16, 64, 256, 1024)
    }
    utility = {n: of["utility_mbps"] for n, of in at.items()}
    assert all(value == 100.0 for of in at.values() for value in of["success_percent"].values())
    rows = {row[0]: row[1:] for row in table_rows(PAGES["docs/scaling.md"]) if len(row) == 6}
    for text, key in SWARM.items():
        assert rows[text] == [f"{utility[n][key]:.2f}" if key in utility[n] else "–" for n in at], text
    low, high = (kept("swarm/scaling", f"utility_mbps_{side}", num_uavs="1024") for side in ("low", "high"))
    most, collisions = utility[1024], kept("swarm/scaling", "collisions", num_uavs="1024")
    says(
        "docs/scaling.md",
        f"has {most['foresees']:.2f} [{low['foresees']:.2f}, {high['foresees']:.2f}] Mbps there, in each of the "
        f"five seeds more than the best route as if alone ({most['best-route']:.2f}), and "
        f"{100 * (1 - most['foresees'] / most['forecast']):.1f} % less than `forecast`",
        f"it has {utility[64]['foresees'] - utility[64]['forecast']:.2f} Mbps more than `forecast` among 64",
        f"among 1,024 {collisions['foresees']:.1f} times a mission, `forecast` {collisions['forecast']:.1f} times, "
        f"UAVs on best routes {collisions['best-route']:.1f} times, those that fly straight "
        f"{collisions['shortest-path']:.1f} times",
    )
    assert all(utility[n]["foresees"] < utility[n]["forecast"] for n in (4, 16, 256, 1024))
    assert all(of["mean-field"] == max(of.values()) for n, of in utility.items() if n <= 64)
    watched = [
        pd.read_csv(path)["greedy/utility_mbps"].dropna()
        for path in (REPOSITORY / "runs/reference/swarm/foresees").glob("*/progress.csv")
    ]
    before, after = (np.mean([curve.iloc[k] for curve in watched]) for k in (0, -1))
    says("docs/scaling.md", f"it has {before:.2f} Mbps before the first update and {after:.2f} at the end")
    by_seed = [
        pd.read_csv(path).query("num_uavs == 1024")["utility_mbps"].mean()
        for path in (REPOSITORY / "runs/reference/swarm/foresees").glob("*/scaling.csv")
    ]
    assert len(by_seed) == 5
    assert min(by_seed) > utility[1024]["best-route"]
