"""Learning curves as figures and claims read them."""

import pandas as pd

from lawn_sb3.results.learning import smoothed


def test_smoothing_averages_the_last_points_of_each_seed() -> None:
    curves = pd.DataFrame(
        {"method": "m", "seed": [0, 0, 0, 1], "time/env_steps": [1, 2, 3, 1], "value": [0.0, 2.0, 4.0, 8.0]}
    )
    assert smoothed(curves, "value", 2)["value"].tolist() == [0.0, 1.0, 3.0, 8.0]
