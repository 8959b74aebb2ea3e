"""Backends by their names: what is misspelt or missing is said in one line."""

import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.backends import choice
from lawn_sb3.experiment.backends.choice import find_backend
from lawn_sb3.experiment.backends.local import LocalBackend


def test_two_jobs_at_a_time_are_done_here_if_nobody_says_more() -> None:
    found = [find_backend("local"), find_backend("local", 5)]
    assert [one.side_by_side for one in found if isinstance(one, LocalBackend)] == [2, 5]


def test_ray_that_is_not_installed_is_named_with_what_installs_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(choice, "find_spec", lambda name: None)
    with pytest.raises(UserError, match=r"--backend ray needs Ray, .*: pip install 'lawn-sb3\[cluster\]'"):
        find_backend("ray")
