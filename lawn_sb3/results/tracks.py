"""Single episodes slot by slot, from the raw rows and paths of an evaluation: what replays are drawn from."""

from collections.abc import Collection, Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.evaluation import evaluation_missions
from lawn_sb3.experiment.measures import summarize
from lawn_sb3.experiment.run_directory.columns import EPISODE_KEY, PATH_KEY
from lawn_sb3.game.airspace import Missions
from lawn_sb3.game.payoff import corrected_rate, ema_rate
from lawn_sb3.results.results import Results
from lawn_sb3.scenario import Scenario

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


class Track(NamedTuple):
    """One episode as one player flew it, from slot 0, the start, to slot T, in which the last of the N UAVs is done."""

    episode: int
    """Which of the test episodes, from 0."""
    rows: pd.DataFrame
    """The raw rows of the episode, one per UAV."""
    voxels: Ints
    """Where each UAV is [T + 1, N, 3]; who is done stays where it ended."""
    flying: Bools
    """Whether it flew in the slot [T + 1, N]; at the start all do."""
    cell: Ints
    """The GBS that serves it [T + 1, N], or did in its last slot."""
    cell_load: Ints
    """UAVs that each GBS serves in the slot [T + 1, M]."""
    rate_mbps: Floats
    """Its rate in the slot [T + 1, N]; NaN at the start and once it is done."""
    ema_rate_mbps: Floats
    """Its bias-corrected moving average of the rate so far [T + 1, N]; NaN at the start, at the end that of its row."""
    utility_mbps: Floats
    """Its utility [T + 1, N]; NaN until it is done."""

    @property
    def slots(self) -> int:
        """T, the slots until the last UAV is done."""
        return len(self.voxels) - 1


def tracks_of(game: Scenario, rows: pd.DataFrame, paths: pd.DataFrame, episodes: Collection[int]) -> Iterator[Track]:
    """Put episodes of an evaluation together, slot by slot.

    :param game: the game that was flown, by UAVs that meet
    :param rows: its raw rows, one per episode and UAV
    :param paths: its paths, one row per slot and UAV; the chosen episodes have to be among them
    :param episodes: which episodes
    :return: a track of each, in the order asked for
    :raises UserError: if an episode has no paths
    """
    for episode in episodes:
        own = rows[rows["episode"] == episode].sort_values(EPISODE_KEY)
        traced = paths[paths["episode"] == episode].sort_values(PATH_KEY)
        if not len(own) or not len(traced):
            raise UserError(f"episode {episode} has no paths: {_traced(paths)}")
        yield _track(game, episode, own, traced)


def _traced(paths: pd.DataFrame) -> str:
    known = paths["episode"].unique().tolist() if len(paths) else []
    return f"from {min(known)} to {max(known)} have some" if known else "none has any"


def _track(game: Scenario, episode: int, rows: pd.DataFrame, paths: pd.DataFrame) -> Track:
    last = rows["slots"].to_numpy()
    shape = (int(last.max()) + 1, game.num_uavs)
    at = paths["slot"].to_numpy(), paths["uav"].to_numpy()
    flying, rate = np.zeros(shape, dtype=np.bool_), np.full(shape, np.nan)
    voxels, cell = np.zeros((*shape, 3), dtype=np.int64), np.zeros(shape, dtype=np.int64)
    flying[at], rate[at] = True, paths["rate_mbps"].to_numpy()
    voxels[at], cell[at] = paths[["x", "y", "z"]].to_numpy(), paths["cell"].to_numpy()
    rate[0] = np.nan
    slot = np.arange(shape[0])[:, None]
    shown, uav = np.minimum(slot, last), np.arange(shape[1])
    voxels, cell = voxels[shown, uav], cell[shown, uav]
    served = flying if game.arrived_uav == "leaves" else np.ones_like(flying)
    loads = np.stack([((cell == gbs) & served).sum(axis=1) for gbs in range(game.num_gbs)], axis=1)
    return Track(
        episode=episode,
        rows=rows,
        voxels=voxels,
        flying=flying,
        cell=cell,
        cell_load=loads,
        rate_mbps=rate,
        ema_rate_mbps=_averages(game, rate)[shown, uav],
        utility_mbps=np.where(slot >= last, rows["utility_mbps"].to_numpy(), np.nan),
    )


def _averages(game: Scenario, rate_mbps: Floats) -> Floats:
    """Bias-corrected moving averages of rates [T + 1, N], by the game's own equations."""
    averages = np.full(rate_mbps.shape, np.nan)
    for uav, rates in enumerate(rate_mbps.T):
        ema = 0.0
        for slot, rate in enumerate(rates[1:], start=1):
            ema = ema_rate(ema, float(rate), game.ema_beta)
            horizon = game.max_slots if game.bias_horizon == "deadline" else slot
            averages[slot, uav] = corrected_rate(ema, game.ema_beta, horizon)
    return averages


class Flown(NamedTuple):
    """What one player flew of a replay."""

    key: str
    """Its method in a recipe, or the player's name: what its colour goes by."""
    title: str
    """What it is called."""
    tracks: list[Track]
    """The episodes that are shown."""
    means: dict[str, float]
    """Mean figures over all test episodes, by name."""


class Replay(NamedTuple):
    """Some episodes as one player or several fly them, on the same missions."""

    game: Scenario
    seed: int
    """Picks the missions."""
    total: int
    """Test episodes that were flown."""
    missions: Missions
    """Those of all of them."""
    flown: list[Flown]

    @property
    def episodes(self) -> list[int]:
        """The episodes that are shown."""
        return [track.episode for track in self.flown[0].tracks]


def replay_of(game: Scenario, seed: int, total: int, flown: list[Flown]) -> Replay:
    """Put together what several players flew on the missions of a seed.

    :param game: the game that all flew
    :param seed: picks the missions
    :param total: test episodes
    :param flown: what each player flew, the same episodes
    :return: the replay
    """
    return Replay(game, seed, total, evaluation_missions(game, total, seed), flown)


def replay_of_results(results: Results) -> Replay | None:
    """The test episodes whose paths the runs of a recipe hold, as every method flew them whose UAVs meet.

    :param results: what the runs left
    :return: the episodes that all methods have paths of, each method by its first seed; none if there are none
    """
    joint, flown = results.without_bound(), []
    methods = joint.methods_in(joint.paths)
    traced = {key: joint.paths[joint.paths["method"] == key] for key in methods}
    first = {key: paths[paths["seed"] == paths["seed"].min()] for key, paths in traced.items()}
    episodes = sorted(set.intersection(*(set(paths["episode"]) for paths in first.values()))) if first else []
    if not episodes:
        return None
    game, chosen = results.recipe.game(), results.recipe.evaluation
    for key, paths in first.items():
        seed, rows = int(paths["seed"].iloc[0]), joint.episodes
        own = rows[(rows["method"] == key) & (rows["seed"] == seed)]
        tracks = list(tracks_of(game, own, paths, episodes))
        flown.append(Flown(key, f"{methods[key].label}, seed {seed}", tracks, summarize(own)))
    return replay_of(game, chosen.seed, chosen.episodes, flown)
