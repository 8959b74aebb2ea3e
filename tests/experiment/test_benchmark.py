"""The benchmark measures what it says, and says how far it is; no speed is tested."""

import tracemalloc
from collections import Counter
from functools import partial

import numpy as np
import pytest

from lawn_sb3.experiment.benchmark import training_speed
from lawn_sb3.experiment.benchmark.clock import calls_per_second, peak_memory_mb
from lawn_sb3.experiment.benchmark.game_speed import against_plain, crowded, env_step_ms, growth, table_bytes
from lawn_sb3.experiment.benchmark.planning_speed import planning_speeds
from lawn_sb3.experiment.benchmark.training_profile import PARTS, REST, OwnTime, training_profile
from lawn_sb3.experiment.benchmark.vector_speed import vector_speeds
from lawn_sb3.experiment.recipe import Method, load_recipe
from lawn_sb3.experiment.registry import REPOSITORY
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.scenario import PRESETS
from tests.game.plain_env import PlainLawnEnv


class Parts:
    """Counts the parts that were told, against how many there were to be."""

    def __init__(self) -> None:
        self.told: Counter[str] = Counter()
        self.expected: dict[str, int] = {}

    def __call__(self, what: str, parts: int) -> None:
        self.told[what] += 1
        self.expected[what] = parts

    @property
    def are_all_told(self) -> bool:
        return bool(self.told) and dict(self.told) == self.expected


@pytest.fixture
def parts() -> Parts:
    return Parts()


@pytest.fixture(scope="module")
def learners() -> dict[str, Method]:
    quick = load_recipe(REPOSITORY / "runs" / "quick.yaml").methods
    return {key: method for key, method in quick.items() if method.algo is not None}


def test_what_takes_longer_is_done_less_often_in_a_second(parts: Parts) -> None:
    short, long = (lambda size=size: np.sort(np.arange(size)[::-1] % 7) for size in (10, 1_000_000))
    often, seldom = calls_per_second([short, long], 0.05, parts, "sorting")
    assert often > seldom > 0.0
    assert parts.told == {"sorting": 10}


def test_the_memory_of_a_job_is_its_own_and_not_that_of_who_asks() -> None:
    np.ones(100_000_000)  # 800 MB, here
    small, large = (peak_memory_mb(partial(np.ones, numbers)) for numbers in (1, 50_000_000))
    assert large - small == pytest.approx(400e6 / 2**20, rel=0.1)


def test_the_simulator_is_held_against_a_plain_environment(parts: Parts) -> None:
    figures = against_plain(8, 0.05, parts)
    fast, plain = figures["simulator_agent_steps_per_s"], figures["plain_pettingzoo_agent_steps_per_s"]
    assert figures["simulator_ratio"] == pytest.approx(fast / plain)
    assert parts.are_all_told


def test_the_plain_environment_plays_whole_games() -> None:
    env = PlainLawnEnv(PRESETS["tiny"])
    env.reset(seed=0)
    while env.agents:
        _, _, over, _, infos = env.step(dict.fromkeys(env.agents, 0))
    assert len(env.moves) == 63
    assert all(over.values())
    assert all(info["timed_out"] or info["arrived"] for info in infos.values())


def test_larger_games_have_as_many_voxel_columns_for_each_gbs() -> None:
    scenario = crowded(64, 16)
    assert (scenario.num_uavs, scenario.num_gbs) == (64, 16)
    assert scenario.grid == (20, 20, 3)


def test_the_growth_of_cost_has_one_exponent_for_each_thing_that_grows(parts: Parts) -> None:
    table = growth(16, 0.01, parts)
    assert table.groupby("grows", sort=False)["exponent"].nunique().to_dict() == {"UAVs and GBSs": 1, "games": 1}
    assert (table["agent_steps_per_s"] > 0.0).all()
    assert parts.are_all_told


def test_memory_is_linear_in_voxels_also_while_a_game_is_built() -> None:
    def bytes_per_voxel(size: int) -> tuple[float, float]:
        scenario = crowded(size, size)
        tracemalloc.start()
        simulator = Simulator(scenario, seed=0)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return table_bytes(simulator) / scenario.num_voxels, peak / scenario.num_voxels

    bytes_per_voxel(4)  # whatever is made only once
    small, large = bytes_per_voxel(256), bytes_per_voxel(1024)
    assert large == pytest.approx(small, rel=0.1)
    assert large[0] == pytest.approx(16, rel=0.02)  # the cell and the rate of an RB, 8 bytes each


def test_environments_and_planners_are_timed(parts: Parts, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lawn_sb3.experiment.benchmark.planning_speed.PRESETS", {"paper": PRESETS["tiny"]})
    figures = vector_speeds(0.02, parts) | planning_speeds(2, parts) | {"step_ms": env_step_ms(4, 0.02, parts)}
    assert min(figures.values()) > 0.0
    assert parts.are_all_told


def test_learners_are_timed(parts: Parts, learners: dict[str, Method], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(training_speed, "WARM_UP", 500)
    figures = training_speed.learner_speeds(learners, 500, parts)
    assert figures.keys() == {f"{algo}_env_steps_per_s" for algo in ("iql", "qmix", "mappo")}
    settings = {**learners["mappo"].settings, "n_steps": 4, "batch_size": 512}
    mappo = learners["mappo"].model_copy(update={"settings": settings})
    figures |= training_speed.bfloat16_speeds(mappo, 0.01, parts)
    assert figures["mappo_bfloat16_ratio"] == pytest.approx(
        figures["mappo_bfloat16_env_steps_per_s"] / figures["mappo_float32_env_steps_per_s"]
    )
    figures |= training_speed.update_share(mappo, 0.01, parts)
    assert min(figures.values()) > 0.0
    assert parts.are_all_told


def test_what_a_training_does_not_reach_is_not_a_number(parts: Parts, learners: dict[str, Method]) -> None:
    figures = training_speed.against_stock(learners["mappo"], 2_000, parts)
    for name in ("mappo", "stock_ppo"):
        assert np.isnan(figures[f"{name}_to_95_percent_success_s"])  # so short a training gets nowhere
        assert figures[f"{name}_to_99_percent_of_its_utility_s"] > 0.0
    assert figures["to_99_percent_of_its_utility_ratio"] > 0.0


def test_a_part_has_its_own_time_and_not_that_of_a_part_it_calls(monkeypatch: pytest.MonkeyPatch) -> None:
    ticks = iter([0.0, 1.0, 3.0, 6.0, 10.0, 15.0])  # start; outer begins, inner begins, inner ends, outer ends; the end
    monkeypatch.setattr("time.perf_counter", lambda: next(ticks))
    clock = OwnTime()
    inner = clock.timed("simulator", lambda: None)
    clock.timed("SuperSuit and adapter", inner)()
    clock.switch()
    assert {part: seconds for part, seconds in clock.seconds.items() if seconds} == {
        "simulator": 6.0 - 3.0,
        "SuperSuit and adapter": (3.0 - 1.0) + (10.0 - 6.0),
        REST: 1.0 + (15.0 - 10.0),
    }


def test_a_profile_shares_out_all_of_the_time(learners: dict[str, Method], parts: Parts) -> None:
    table = training_profile({"mappo": learners["mappo"]}, 1_000, parts)
    assert table.index.tolist() == [*PARTS, REST, "seconds"]
    assert table["mappo"].drop("seconds").sum() == pytest.approx(100.0)
    assert (table["mappo"][["simulator", "networks, forward", "networks, backward", "optimiser"]] > 0.0).all()
    assert parts.are_all_told
