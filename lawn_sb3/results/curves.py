"""Learning curves as figures and claims read them."""

from __future__ import annotations

from collections.abc import Hashable

import pandas as pd

WINDOW = 30
"""Points a smoothed curve averages over, as in the paper."""


def smoothed(curves: pd.DataFrame, column: str, window: int) -> pd.DataFrame:
    """Rolling mean of a curve, seed by seed.

    :param curves: rows of ``progress.csv`` with the columns ``method`` and ``seed``
    :param column: what to smooth; rows without it are left out
    :param window: points to average over, fewer at the start
    :return: the columns ``method, seed, env_steps, value``
    """
    parts = []
    for (method, seed), rows in curves.dropna(subset=[column]).groupby(["method", "seed"], sort=False):
        value = rows[column].rolling(window, min_periods=1).mean()
        keys: dict[str, Hashable | pd.Series] = {"method": method, "seed": seed}
        parts.append(pd.DataFrame({**keys, "env_steps": rows["time/env_steps"], "value": value}))
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame()
