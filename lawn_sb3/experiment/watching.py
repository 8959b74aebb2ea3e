"""Watching a training: mission statistics and greedy evaluations, recorded against env steps."""

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm

from lawn_sb3.algos.common.mission_statistics import deadline_passed
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import fly
from lawn_sb3.experiment.measures import regrets, summarize, summarize_regrets
from lawn_sb3.experiment.players import ModelPlayer

WATCHED = ("reward", "success_percent", "makespan_slots", "utility_mbps", "rate_mbps")
WATCHED_REGRETS = ("regret_mbps", "nash_gap_mbps")
"""Where a recipe asks for regrets."""


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
        """Wall time of the training so far, that before an interruption included."""
        return time.perf_counter() - self._start

    @property
    def env_steps(self) -> int:
        """Joint slots played so far, over all games."""
        return self.num_timesteps // self.cell.scenario.num_uavs

    def state(self) -> WatchState:
        """What a resumed training needs to watch on as if it had not been interrupted.

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
        whole = getattr(self.model, "whole_batches", False)
        if not (whole or deadline_passed(self.training_env, self.num_timesteps)):
            self._missions.clear()
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
