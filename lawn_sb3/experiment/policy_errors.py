"""What goes wrong inside a policy, told in one line with its name, its file and the line there."""

import difflib
import inspect
import sysconfig
import traceback
from contextlib import suppress
from pathlib import Path

from stable_baselines3.common.policies import BasePolicy

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.registry import place

KIT = Path(__file__).resolve().parents[1]
HANDS_OVER = {"forward_actor": "actor_input", "forward_critic": "critic_input"}
"""Methods of the kit's networks, and those of a policy that say what these are handed."""


def policy_error(error: Exception, policy: type[BasePolicy], name: str) -> UserError:
    """Put whatever was raised while a policy was built or asked into one line.

    :param error: the exception, with its traceback
    :param policy: the policy class
    :param name: what the user calls the policy
    :return: the error: name, file, line of the user's code where it happened or that gave what did not fit, and the
        reason's first line
    """
    where, reason = line_of_user(error, policy), next(iter(str(error).strip().splitlines()), "")
    if not isinstance(error, UserError):
        reason = f"{type(error).__name__}: {reason}".removesuffix(": ")
    near = []
    if isinstance(error, AttributeError) and isinstance(error.name, str):
        with suppress(AttributeError):  # of a torch module that is not built yet
            near = difflib.get_close_matches(error.name, dir(error.obj), n=1)
    hint = f" (did you mean {near[0]!r}?)" if near else ""
    return UserError(f"policy {name!r} ({place(policy)}{where}): {reason}{hint}")


def line_of_user(error: Exception, policy: type[BasePolicy]) -> str:
    """The last line of the user's own code that an error passed through, as text; nothing if it passed none.

    That is a line of the policy's file, or of another one that is neither the kit's nor installed, which is then named.
    Where the kit's networks refuse what a policy hands them, it is the line of the method that does so.
    """
    own = _file_of(policy)
    passed = [(frame.f_code, line) for frame, line in traceback.walk_tb(error.__traceback__)]
    for code, line in reversed(passed):
        path = Path(code.co_filename).resolve()
        if path == own:
            return f", line {line}"
        if _is_users(path):
            return f", in {_short(path)}, line {line}"
        method = getattr(policy, HANDS_OVER.get(code.co_name, ""), None)
        if inspect.isfunction(method) and Path(method.__code__.co_filename).resolve() == own:
            return f", line {method.__code__.co_firstlineno}, what {method.__name__} gives"
    return ""


def _file_of(policy: type[BasePolicy]) -> Path | None:
    try:
        return Path(inspect.getfile(policy)).resolve()
    except (TypeError, OSError):
        return None


def _is_users(path: Path) -> bool:
    """Whether a file is neither the kit's nor installed."""
    installed = [Path(sysconfig.get_path(name)).resolve() for name in ("stdlib", "purelib", "platlib")]
    return path.suffix == ".py" and not any(path.is_relative_to(folder) for folder in (*installed, KIT))


def _short(path: Path) -> Path:
    return path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path
