"""What goes wrong inside a policy, told in one line with its name, its file and the line there."""

import difflib
import inspect
import traceback
from contextlib import suppress
from pathlib import Path

from stable_baselines3.common.policies import BasePolicy

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.registry import place


def policy_error(error: Exception, policy: type[BasePolicy], name: str) -> UserError:
    """Put whatever was raised while a policy was built or asked into one line.

    :param error: the exception, with its traceback
    :param policy: the policy class
    :param name: what the user calls the policy
    :return: the error: name, file, line in this file if the error passed through it, and the reason's first line
    """
    line, reason = line_in_own_file(error, policy), next(iter(str(error).strip().splitlines()), "")
    if not isinstance(error, UserError):
        reason = f"{type(error).__name__}: {reason}".removesuffix(": ")
    near = []
    if isinstance(error, AttributeError) and isinstance(error.name, str):
        with suppress(AttributeError):  # of a torch module that is not built yet
            near = difflib.get_close_matches(error.name, dir(error.obj), n=1)
    hint = f" (did you mean {near[0]!r}?)" if near else ""
    return UserError(f"policy {name!r} ({place(policy)}{'' if line is None else f', line {line}'}): {reason}{hint}")


def line_in_own_file(error: Exception, policy: type[BasePolicy]) -> int | None:
    """The last line of a policy's own file that an error passed through; none if it passed elsewhere."""
    try:
        own = Path(inspect.getfile(policy)).resolve()
    except (TypeError, OSError):
        return None
    passed = [(Path(frame.f_code.co_filename), line) for frame, line in traceback.walk_tb(error.__traceback__)]
    return next((line for path, line in reversed(passed) if path.resolve() == own), None)
