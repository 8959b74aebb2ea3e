"""Callbacks that watch a training: mission statistics, greedy evaluation, progress; and the file they fill."""

from __future__ import annotations

import csv
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import KVWriter
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm

from lawn_sb3.algos.mappo import EpisodeMAPPO
from lawn_sb3.experiment.evaluation import fly, summarize
from lawn_sb3.experiment.players import ModelPlayer
from lawn_sb3.experiment.recipe import Cell
from lawn_sb3.experiment.regret import regrets, summarize_regrets

WATCHED = ("reward", "success_percent", "makespan_slots", "utility_mbps", "rate_mbps")
WATCHED_REGRETS = ("regret_mbps", "nash_gap_mbps")
"""Where a recipe asks for regrets."""

NOT_REPEATABLE = {"time/fps", "time/time_elapsed", "time/iterations"}
"""Columns that differ between equal trainings, of which one was cut and resumed."""


class ProgressCSV(KVWriter):
    """``progress.csv`` as SB3 writes it, with sorted columns and none of wall-clock time: equal runs, equal bytes.

    :param path: the file
    :param before: its content up to the checkpoint that the training resumes from
    """

    def __init__(self, path: Path, before: str = "") -> None:
        self.path = path
        self.rows: list[dict[str, str]] = list(csv.DictReader(before.splitlines()))
        self.columns = list(self.rows[0]) if self.rows else []
        path.write_text(before, encoding="utf-8")

    def write(self, key_values: dict[str, Any], key_excluded: dict[str, tuple[str, ...]], step: int = 0) -> None:
        """Append one row.

        :param key_values: names and values
        :param key_excluded: formats that leave a name out
        :param step: agent steps so far
        """
        row = {key: str(value) for key, value in key_values.items() if key not in NOT_REPEATABLE}
        self.rows.append(row)
        new = sorted(set(row) - set(self.columns))
        self.columns += new
        with self.path.open("w" if new else "a", encoding="utf-8", newline="") as file:
            table = csv.DictWriter(file, self.columns, restval="", lineterminator="\n")
            if new:  # rows written before lack the new columns
                table.writeheader()
            table.writerows(self.rows if new else [row])

    def close(self) -> None:
        """Nothing is kept open."""


class WatchState(NamedTuple):
    """What a checkpoint keeps of a watch."""

    next_record: int
    next_evaluation: int
    missions: list[tuple[float, bool, int, float]]
    seconds: float


class Watch(BaseCallback):
    """Record training missions and greedy evaluations against env steps, and report progress.

    :param cell: what is being trained
    :param progress: called with the env steps done so far
    """

    def __init__(self, cell: Cell, progress: Callable[[int], None]) -> None:
        super().__init__()
        self.cell = cell
        self.progress = progress
        self.next_record = 0
        self.next_evaluation = 0
        self._missions: list[tuple[float, bool, int, float]] = []
        self._start = time.perf_counter()

    @property
    def seconds(self) -> float:
        """Wall time of the training so far, that before a cut included."""
        return time.perf_counter() - self._start

    @property
    def env_steps(self) -> int:
        """Joint slots played so far, over all games."""
        return self.num_timesteps // self.cell.scenario.num_uavs

    def state(self) -> WatchState:
        """What a resumed training needs to watch on as if it had not been cut.

        :return: when the next row and evaluation are due, the missions not written yet, and the seconds so far
        """
        return WatchState(self.next_record, self.next_evaluation, list(self._missions), self.seconds)

    def restore(self, state: WatchState) -> None:
        """Go on from there.

        :param state: what :meth:`state` returned
        """
        self.next_record, self.next_evaluation, self._missions, seconds = state
        self._start = time.perf_counter() - seconds

    def _on_step(self) -> bool:
        for info in self.locals["infos"]:
            if "episode" in info:
                end = info["episode"]
                self._missions.append((end["r"], info["is_success"], end["l"], info["utility_mbps"]))
        return True

    def _on_rollout_end(self) -> None:
        self.progress(self.env_steps)
        if self.env_steps < self.next_record:
            return
        self.next_record = self.env_steps + self.cell.evaluation.record_every
        self.logger.record("time/env_steps", self.env_steps)
        slots_so_far = self.num_timesteps // self.training_env.num_envs
        whole = isinstance(self.model, EpisodeMAPPO)  # no mission is left out there
        if slots_so_far <= self.cell.scenario.max_slots and not whole:
            self._missions.clear()  # until the first deadline only successful missions can have ended
        if self._missions:
            reward, success, slots, utility = np.mean(self._missions, axis=0)
            self.logger.record("missions/reward", reward)
            self.logger.record("missions/success_percent", 100.0 * success)
            self.logger.record("missions/slots", slots)
            self.logger.record("missions/utility_mbps", utility)
            self.logger.record("missions/count", len(self._missions))
            self._missions.clear()
        if self.env_steps >= self.next_evaluation:
            self.next_evaluation = self.env_steps + self.cell.evaluation.watch_every
            chosen = self.cell.evaluation
            player = ModelPlayer(self.model, self.cell.key)
            traced = chosen.watch_episodes if self.cell.regret else 0
            flights = fly(player, self.cell.scenario, chosen.watch_episodes, chosen.watch_seed, traced=traced)
            summary = summarize(flights.rows)
            for name in WATCHED:
                self.logger.record(f"greedy/{name}", summary[name])
            if traced:
                found = summarize_regrets(regrets(flights, self.cell.scenario, chosen.watch_seed), flights.rows)
                for name in WATCHED_REGRETS:
                    self.logger.record(f"greedy/{name}", found[name])
        assert isinstance(self.model, OnPolicyAlgorithm | OffPolicyAlgorithm)
        self.model.dump_logs()
