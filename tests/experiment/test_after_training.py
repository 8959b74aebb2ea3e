"""What finished runs get once they are there: regrets, and flights with other numbers of UAVs."""

import io
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from rich.console import Console

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.after_training import add_costs, add_regrets, add_scaling, fly_scaled, has_regrets
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.measures import summarize
from lawn_sb3.experiment.players import load_player
from lawn_sb3.experiment.recipe import Method, Scaling
from lawn_sb3.experiment.run_directory.files import COSTS_FILE, REGRET_FILE, SCALING_FILE
from lawn_sb3.experiment.run_directory.reading import read_costs
from lawn_sb3.experiment.train import run_cell
from tests.experiment.training import ignore

SCALING = Scaling(num_uavs=(1, 4, 6), episodes=5, methods=("mappo", "shortest-path"))
QUIET = Console(quiet=True)
Add = Callable[[Sequence[Cell], Console], None]


def scale(cells: Sequence[Cell], console: Console) -> None:
    add_scaling(cells, SCALING, console)


BOTH = pytest.mark.parametrize(("add", "name"), [(add_regrets, REGRET_FILE), (scale, SCALING_FILE)])


def planned(cell: Cell, player: str) -> Cell:
    folder = cell.directory.parent.parent / player
    return replace(cell, key=player, method=Method(label=player, player=player), directory=folder)


@pytest.fixture
def trained(small_cell: Cell) -> Cell:
    run_cell(small_cell, ignore)
    return small_cell


@pytest.fixture
def flown(small_cell: Cell) -> Cell:
    cell = planned(small_cell, "shortest-path")
    run_cell(cell, ignore)
    return cell


@BOTH
def test_finished_runs_get_the_file_once(flown: Cell, add: Add, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    unfinished = replace(flown, seed=4, directory=flown.directory.with_name("unfinished"))
    add([flown, unfinished], QUIET)
    assert (flown.directory / name).exists()
    assert not unfinished.directory.exists()
    for work in ("fly", "fly_scaled"):
        monkeypatch.setattr(f"lawn_sb3.experiment.after_training.{work}", None)  # flying again would fail
    add([flown], QUIET)


@BOTH
def test_a_damaged_file_is_made_anew(flown: Cell, add: Add, name: str) -> None:
    add([flown], QUIET)
    path: Path = flown.directory / name
    whole = path.read_bytes()
    rows = pd.read_csv(path)
    changed = rows.assign(**{column: 0.5 for column in ("best_mbps", "welfare_mbps") if column in rows})
    for damaged in (whole[: len(whole) // 2], b"", changed.to_csv(index=False).encode()):
        path.write_bytes(damaged)
        add([flown], QUIET)
        assert path.read_bytes() == whole


@BOTH
def test_a_run_without_its_model_is_named_and_the_others_get_theirs(
    trained: Cell, flown: Cell, add: Add, name: str
) -> None:
    told = io.StringIO()
    (trained.directory / "model.zip").unlink()
    add([trained, flown], Console(file=told))
    assert told.getvalue().startswith(f"no {name} of {trained.title}: ")
    assert "model.zip' is missing" in told.getvalue()
    assert (flown.directory / name).exists()
    assert not (trained.directory / name).exists()


@BOTH
def test_a_run_made_anew_has_nothing_of_the_old_one(flown: Cell, add: Add, name: str) -> None:
    add([flown], QUIET)
    run_cell(replace(flown, evaluation=flown.evaluation.model_copy(update={"seed": 1})), ignore)
    assert not (flown.directory / name).exists()


def test_regrets_are_of_the_flights_that_were_evaluated(trained: Cell) -> None:
    add_regrets([trained], QUIET)
    rows, evaluation = (pd.read_csv(trained.directory / name) for name in (REGRET_FILE, "evaluation.csv"))
    own = ["episode", "uav", "utility_mbps"]
    assert (rows[own] == evaluation[own]).all(axis=None)


def test_whose_uavs_never_meet_has_no_regrets(small_cell: Cell) -> None:
    bound = planned(small_cell, "bound")
    run_cell(bound, ignore)
    add_regrets([bound], QUIET)
    assert not has_regrets(bound)
    assert not (bound.directory / REGRET_FILE).exists()


def test_at_the_n_of_training_it_is_the_evaluation_itself(trained: Cell) -> None:
    rows = fly_scaled(trained, SCALING)
    assert list(rows["num_uavs"]) == [1, 4, 6]
    flown = evaluate(load_player(trained), trained.scenario, 5, trained.evaluation.seed, trained.seed)
    at_four = rows[rows["num_uavs"] == 4].iloc[0]
    for name, value in summarize(flown).items():
        assert at_four[name] == value
    assert rows.set_index("num_uavs").loc[1, "collisions"] == 0.0  # alone in the air


@pytest.mark.parametrize("changes", [{"episodes": 6}, {"num_uavs": (1, 4)}])
def test_what_is_asked_anew_is_flown_anew(flown: Cell, changes: dict[str, object]) -> None:
    scale([flown], QUIET)
    other = SCALING.model_copy(update=changes)
    add_scaling([flown], other, QUIET)
    rows = pd.read_csv(flown.directory / SCALING_FILE)
    assert tuple(rows["num_uavs"]) == other.num_uavs
    assert set(rows["episodes"]) == {other.episodes}


def test_methods_that_were_not_chosen_are_not_flown(flown: Cell) -> None:
    scale([replace(flown, key="other")], QUIET)
    assert not (flown.directory / SCALING_FILE).exists()


def test_more_uavs_than_fit_are_refused(flown: Cell) -> None:
    with pytest.raises(UserError, match=r"num_uavs = 151 .* at most 150 UAVs"):
        fly_scaled(flown, Scaling(num_uavs=(151,), episodes=1, methods=("shortest-path",)))


def test_an_actor_for_all_games_flies_at_constant_density_where_there_are_other_cells(small_cell: Cell) -> None:
    method = Method(label="Cells", algo="mappo-episodes", policy="knows_cells", env_steps=20, num_games=2, slack=0)
    cell = replace(small_cell, method=method)
    run_cell(cell, ignore)
    swarm = Scaling(
        num_uavs=(1, 4, 16),
        episodes=(4, 2, 1),
        methods=("mappo",),
        constant_density=True,
        costs=True,
        reach={"mappo": 4},
    )
    everywhere = swarm.model_copy(update={"reach": {}})
    rows = fly_scaled(cell, everywhere).set_index("num_uavs")
    assert dict(rows["episodes"]) == {1: 4, 4: 2, 16: 1}
    assert set(rows["success_percent"]) == {100.0}  # in time, whatever it has learned
    big = small_cell.scenario.grown(16)
    assert big.num_gbs == 4 * small_cell.scenario.num_gbs
    flown = evaluate(load_player(cell, cell.evaluation.deterministic, big), big, 1, cell.evaluation.seed, cell.seed)
    assert rows.loc[16, "utility_mbps"] == summarize(flown)["utility_mbps"]

    add_costs([cell], swarm, QUIET)
    costs = read_costs(cell, swarm)
    assert list(costs["num_uavs"]) == [1, 4]  # no more than it reaches
    assert (costs[["decision_ms", "memory_mb"]] > 0.0).all(axis=None)
    before = (cell.directory / COSTS_FILE).read_bytes()
    add_costs([cell], swarm, QUIET)
    assert (cell.directory / COSTS_FILE).read_bytes() == before
    add_scaling([cell], swarm, QUIET)
    assert list(pd.read_csv(cell.directory / SCALING_FILE)["num_uavs"]) == [1, 4]
    with pytest.raises(UserError, match=r"costs.csv is of 1, 4 UAVs: must be 1, 4, 16|costs.csv is cut off"):
        read_costs(cell, everywhere)
