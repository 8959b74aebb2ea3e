"""What is printed while cells run and no bar can be drawn."""

import pytest
from rich.progress import Progress

from lawn_sb3.experiment.reproduce import progress_line


@pytest.mark.parametrize(
    ("env_steps", "expected"),
    [
        (0, "1 of 3 runs, 0 of 2,000 env steps, time left not known yet"),
        (2_000, "1 of 3 runs, 2,000 of 2,000 env steps, all trained, what is left is flying"),
    ],
)
def test_the_time_left_is_told_while_something_trains(env_steps: int, expected: str) -> None:
    bars = Progress(disable=True)
    task = bars.add_task("all 3 runs", total=2_000)
    bars.update(task, completed=env_steps)
    assert progress_line(bars, task, 1, 3) == expected
