"""Claims about training curves, seed by seed: greedy evaluations, and training missions smoothed as in Fig. 2."""

from collections.abc import Callable

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import spearmanr

from lawn_sb3.paper.claims.claim import Condition, Finding, Verdict, claim, shared_rule
from lawn_sb3.paper.claims.evidence import CannotTellError, Evidence
from lawn_sb3.paper.claims.rule_parts import combine, counted, held_to, higher, holds_if, join
from lawn_sb3.paper.roles import FORMS
from lawn_sb3.results.learning import GREEDY, THRESHOLD, WINDOW, smoothed

PLAYS = {GREEDY: "greedy", "missions/success_percent": "in training missions"}
"""Column of ``progress.csv`` with a success rate: how it was flown."""


def curve(evidence: Evidence, role: str, column: str = GREEDY) -> list[pd.Series]:
    """A learning curve as Fig. 2 shows it: one series per seed, its index in env steps; training missions are smoothed.

    :raises CannotTellError: if nothing was measured
    """
    key, curves = evidence.key(role), evidence.results.curves
    own = curves[curves["method"] == key] if len(curves) else curves
    if column not in own or own[column].isna().all():
        raise CannotTellError(f"needs the learning curve of {evidence.label(role)}")
    points = smoothed(own, column, WINDOW if column.startswith("missions/") else 1)
    return [rows.set_index("env_steps")["value"].astype(float) for _, rows in points.groupby("seed")]


def _after_crossing(series: pd.Series) -> pd.Series:
    """The curve from its first value at or above the level on; empty if it never gets there."""
    above = np.flatnonzero(series.to_numpy() >= THRESHOLD)
    return series.iloc[above[0] :] if len(above) else series.iloc[:0]


@claim(
    place=540,
    section="V-B, Fig. 2",
    text="CTDE-MAPPO achieves a success rate above 95 % within approximately 150 K environment steps.",
    measure="first point at or above 95 %, of greedy evaluations and of training missions smoothed as in Fig. 2",
    headline=True,
)
def success_within_150k(evidence: Evidence) -> Finding:
    """Whether every seed gets there in time; for each form greedy play and training missions count apart."""
    within, figures, forms = 150_000, [], []
    for role in FORMS:
        parts: list[str] = []
        held: list[Condition] = []
        for column, name in PLAYS.items():
            seeds = curve(evidence, role, column)
            first = [tail.index[0] for own in seeds if len(tail := _after_crossing(own))]
            never = len(seeds) - len(first)
            if never and evidence.method(role).env_steps < within:
                raise CannotTellError(f"needs trainings of {within:,} env steps of {evidence.label(role)}")
            parts.append(f"{f'{max(first):,.0f} env steps' if first else 'never'} {name}")
            parts[-1] += f" ({never} of {len(seeds)} seeds never)" if first and never else ""
            held.append(holds_if(not never and max(first) <= within))
        forms.append(held)
        figures.append(f"{evidence.label(role)}: {', '.join(parts)}")
    return Finding(
        combine(*forms),
        f"slowest seed of each: {'; '.join(figures)}",
        f"Every seed has to reach {THRESHOLD:g} % within {within:,} env steps.",
    )


@claim(
    place=550,
    section="Abstract, V-B, Fig. 2",
    text="The success rate remains stable thereafter.",
    measure="points of the mean over seeds below 95 % once it has been there, of greedy evaluations and of training "
    "missions smoothed as in Fig. 2, up to the end of these trainings",
    headline=True,
)
def stable_thereafter(evidence: Evidence) -> Finding:
    """Whether the mean over seeds, as Fig. 2 draws it, falls below again; greedy and training missions are apart."""
    figures, forms, broken, end = [], [], [], 0
    for role in FORMS:
        parts: list[str] = []
        held: list[Condition] = []
        for column, name in PLAYS.items():
            seeds = curve(evidence, role, column)
            tails = [_after_crossing(own) for own in seeds]
            mean = pd.concat(seeds, axis=1, join="inner").mean(axis=1)
            after, end = _after_crossing(mean), max([end, *mean.index])
            there = len(after) > 0 and all(map(len, tails))
            below = int((after < THRESHOLD).sum())
            held.append(holds_if(there and below == 0))
            alone = min((float(tail.min()) for tail in tails), default=np.nan) if there else np.nan
            parts.append(
                f"{below} of {len(after)} points below {name}, lowest {after.min():.1f} %, of one seed {alone:.1f} %"
                if there
                else f"not every seed there {name}"
            )
            if held[-1] == "fails":
                broken.append(f"{evidence.label(role)} {name}")
        forms.append(held)
        figures.append(f"{evidence.label(role)}: {', '.join(parts)}")
    why = f"No point of the mean after its first at {THRESHOLD:g} % may lie below it"
    why += f"; not so {join(broken)}" if broken else ""
    return Finding(
        combine(*forms), "; ".join(figures), f"{why}. The trainings end after {end:,} env steps: beyond was not looked."
    )


def _steps_up_and_down(series: pd.Series) -> float:
    """Mean absolute change from one point of the second half to the next."""
    values = series.to_numpy()[len(series) // 2 :]
    if len(values) < 2:
        raise CannotTellError("needs learning curves of at least three points")
    return float(np.abs(np.diff(values)).mean())


@shared_rule
def fluctuates_more(evidence: Evidence, role: str, than: list[str]) -> Finding:
    """Whether success goes up and down more in the second half of training than another method's does.

    :param role: the part said to fluctuate
    :param than: the parts of the other method's forms
    """
    return _higher(evidence, "fluctuation", _steps_up_and_down, " points", role, than)


@claim(
    place=480,
    section="IV-B",
    text="Sharing parameters among the UAVs improves sample efficiency.",
    measure="mean greedy success over the whole training, V(o, x) with one actor for all against one for each",
    needs="ablation",
)
def parameter_sharing(evidence: Evidence) -> Finding:
    """Whether the area under the curve is larger with one actor for all."""
    return _higher(evidence, "mean success", lambda series: float(series.mean()), " %", "mappo-o", ["mappo-separate"])


def _higher(
    evidence: Evidence, name: str, figure: Callable[[pd.Series], float], unit: str, of: str, than: list[str]
) -> Finding:
    """Whether a figure of the greedy curve is higher for one part than for each of the others."""
    values = {
        role: np.array([figure(series) for series in curve(evidence, role)], dtype=np.float64) for role in [of, *than]
    }
    return Finding(*higher(evidence, name, values, [of], unit, 2))


@claim(
    place=580,
    section="V-B, Fig. 2",
    text="IQL's success rate improves briefly at the early stage and later degrades.",
    measure="greedy success of each seed where the mean of all others peaks, as its own peak is chance in part, minus "
    "that at its end; by Student's test against five points. Settings that end well were searched for, so that none "
    "that decline are left: that success does not fall speaks of these settings alone",
)
def iql_declines(evidence: Evidence) -> Finding:
    """Whether success peaks in the first half of training and falls back from there; partly if the peak was late."""
    points = 5
    seeds = pd.concat(curve(evidence, "iql"), axis=1, join="inner")
    if not len(seeds):
        raise CannotTellError("needs seeds that were evaluated after the same env steps")
    if seeds.shape[1] < 2:
        raise CannotTellError("needs at least two seeds, of which each peaks where the others do")
    steps, values = seeds.index.to_numpy(dtype=np.float64), seeds.to_numpy()  # [P], [P, S]
    mean = values.mean(axis=1)
    peak = int(mean.argmax())
    lost = [own[np.delete(values, k, axis=1).mean(axis=1).argmax()] - own[-1] for k, own in enumerate(values.T)]
    found = held_to(evidence, "lost from the peak", "iql", np.array(lost), points)
    fell, early = found.reaches(), bool(steps[peak] <= steps[-1] / 2)
    verdicts: dict[Condition, Verdict] = {
        "holds": "reproduced" if early else "partly", "fails": "not shown", "open": "not shown"
    }  # fmt: skip
    words = {"holds": "they are", "fails": "they are not", "open": "they may be"}
    return Finding(
        verdicts[fell],
        f"{evidence.label('iql')}: peak of the mean {mean[peak]:.1f} % at {steps[peak]:,.0f} of {steps[-1]:,.0f} env "
        f"steps, end {mean[-1]:.1f} %, lost {found.text(1)} points",
        f"At least {points} points have to be lost ({words[fell]}), "
        f"after a peak in the first half of training ({'it is' if early else 'it is not'}).",
    )


@claim(
    place=410,
    section="I, IV-A",
    text="The per-step reward approximates the game utility throughout training.",
    measure="rank correlation of J̄ and mean U over the greedy evaluations, of the whole training and of its second "
    "half, and of both over the UAVs of the test missions; by Student's test over seeds",
)
def reward_approximates_utility(evidence: Evidence) -> Finding:
    """Whether both rank evaluations alike, early and late, and in the end single missions: three conditions a form."""
    least, figures, forms = 0.5, [], []
    for role in FORMS:
        pairs = zip(*(curve(evidence, role, f"greedy/{name}") for name in ("reward", "utility_mbps")), strict=True)
        seeds: list[NDArray[np.float64]] = [
            pd.concat(pair, axis=1, join="inner").to_numpy() for pair in pairs
        ]  # [P, 2] each
        late = [points[len(points) // 2 :] for points in seeds]
        rewards = evidence.results.scores(evidence.key(role), "reward", per="uav")  # [S, E, N]
        flown = zip(rewards, evidence.utilities_mbps(role), strict=True)
        pooled = [np.stack([own.ravel(), utility.ravel()], axis=1) for own, utility in flown]
        parts = {"": seeds, "in the second half of training ": late, "over UAVs of the test missions ": pooled}
        found = {
            name: held_to(
                evidence, f"rank correlation {name}", role, np.array(list(map(_rank_correlation, own))), least
            )
            for name, own in parts.items()
        }
        shown = ", ".join(f"{name}{each.text(2)}" for name, each in found.items())
        figures.append(f"{evidence.label(role)}: rank correlation {shown}")
        forms.append([each.reaches() for each in found.values()])
    held = [condition for form in forms for condition in form]
    return Finding(
        combine(*forms),
        "; ".join(figures),
        f"Each has to reach {least:g}, where one ranks much as the other does: {counted(held)}. Over "
        "missions the reward is mostly progress, so that it grows with their length, and utility does not.",
    )


def _rank_correlation(points: NDArray[np.float64]) -> float:
    """Spearman's rank correlation of the two columns of an array [P, 2]."""
    if len(points) < 3 or (np.ptp(points, axis=0) == 0.0).any():
        raise CannotTellError("needs three points that differ, in each half of the learning curves and in the test")
    return float(spearmanr(points[:, 0], points[:, 1])[0])
