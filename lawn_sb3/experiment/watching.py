"""Callbacks that watch a training: mission statistics, greedy evaluation, progress; and the file they fill."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import CSVOutputFormat

from lawn_sb3.experiment.evaluation import evaluate, summarize
from lawn_sb3.experiment.players import ModelPlayer
from lawn_sb3.experiment.recipe import Cell

WATCHED = ("reward", "success_percent", "makespan_slots", "utility_mbps", "rate_mbps")


class ProgressCSV(CSVOutputFormat):
    """SB3's ``progress.csv`` without wall-clock columns, so that equal runs leave equal bytes; goes on after a cut.

    :param path: the file
    :param before: its content up to the checkpoint that the training resumes from
    """

    def __init__(self, path: Path, before: str = "") -> None:
        super().__init__(str(path))
        self.file.write(before)
        self.keys = next(csv.reader([before])) if before else []

    def write(self, key_values: dict[str, Any], key_excluded: dict[str, tuple[str, ...]], step: int = 0) -> None:
        """Write one row.

        :param key_values: names and values
        :param key_excluded: formats that leave a name out
        :param step: agent steps so far
        """
        kept = {key: value for key, value in key_values.items() if key not in ("time/fps", "time/time_elapsed")}
        super().write(kept, key_excluded, step)
        self.file.flush()


class Watch(BaseCallback):
    """Record training missions and greedy evaluations against env steps, and report progress.

    :param cell: what is being trained
    :param progress: called with the env steps done so far
    """

    def __init__(self, cell: Cell, progress: Callable[[int], None]) -> None:
        super().__init__()
        self.cell = cell
        self.progress = progress
        self.next_evaluation = 0
        self._missions: list[tuple[float, bool, int, float]] = []

    @property
    def env_steps(self) -> int:
        """Joint slots played so far, over all games."""
        return self.num_timesteps // self.cell.scenario.num_uavs

    def _on_step(self) -> bool:
        for info in self.locals["infos"]:
            if "episode" in info:
                end = info["episode"]
                self._missions.append((end["r"], info["is_success"], end["l"], info["utility_mbps"]))
        return True

    def _on_rollout_end(self) -> None:
        self.logger.record("time/env_steps", self.env_steps)
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
            rows = evaluate(player, self.cell.scenario, chosen.watch_episodes, chosen.watch_seed)
            summary = summarize(rows)
            for name in WATCHED:
                self.logger.record(f"greedy/{name}", summary[name])
        self.progress(self.env_steps)
