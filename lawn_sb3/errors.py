"""What a user can get wrong, told in one line: what, where, and what is allowed."""

import difflib
from collections.abc import Iterable


class UserError(ValueError):
    """Bad input. The command line prints its one line and ends with status 2."""


class FailedRunsError(RuntimeError):
    """Some runs of a recipe failed; the others are finished and kept."""


class HeldError(Exception):
    """Somebody else is writing there. The command line prints its one line and ends with status 1."""


class Notice(UserWarning):
    """Something that the user should know, though the work goes on. The command line prints its one line."""


def unknown_name(what: str, name: str, known: Iterable[str], path: str | None = None) -> UserError:
    """Refuse a name that is not in a list.

    :param what: what the name stands for, such as ``"scenario"``
    :param name: the name that was given
    :param known: the names that exist
    :param path: how to show the name if it lies deep inside a file
    :return: the error; it suggests a known name if one is close
    """
    options = sorted(known)
    near = difflib.get_close_matches(name, options, n=1)
    hint = f" (did you mean {near[0]!r}?)" if near else ""
    return UserError(f"unknown {what} {path or repr(name)}{hint}; known: {', '.join(options) or 'none'}")


def said(error: BaseException) -> str:
    """What an error says, in one line with its kind; of those that say all themselves, without."""
    return (
        first_line(error)
        if isinstance(error, UserError | HeldError)
        else f"{type(error).__name__}: {first_line(error)}"
    )


def first_line(error: BaseException) -> str:
    """What an error says, in one line; its kind if it says nothing."""
    return next(iter(str(error).strip().splitlines()), type(error).__name__)
