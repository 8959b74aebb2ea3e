"""What a user can get wrong, said in one line: what, where, and what is allowed."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails


class UserError(ValueError):
    """Bad input. The command line prints its one line and ends with status 2."""


def unknown_name(what: str, name: str, known: Iterable[str], path: str | None = None) -> UserError:
    """Build the refusal of a name that is not in a list.

    :param what: what the name should have named, such as ``"scenario"``
    :param name: the name that was given
    :param known: the names that exist
    :param path: how to show the name, if it lies deep inside a file
    :return: the error, naming the nearest known name where one is near
    """
    options = sorted(known)
    near = difflib.get_close_matches(name, options, n=1)
    hint = f" (did you mean {near[0]!r}?)" if near else ""
    return UserError(f"unknown {what} {path or repr(name)}{hint}; known: {', '.join(options)}")


def explain(error: ValidationError, model: type[BaseModel], where: str) -> UserError:
    """Put pydantic's first complaint into one line.

    :param error: what pydantic raised
    :param model: the model that refused, for the list of its keys
    :param where: the file or preset that the values came from
    :return: the error: place, field, value given and what is allowed
    """
    errors = error.errors()
    first = errors[0]
    same = [other for other in errors if _one_of_several(first, other)]
    loc = first["loc"][:-1] if len(same) > 1 else first["loc"]
    path = ".".join(str(part) for part in loc)
    more = f" (and {len(errors) - len(same)} more)" if len(errors) > len(same) else ""
    if first["type"] == "extra_forbidden":
        owner, key = _owner(model, first["loc"])
        return UserError(f"{where}: {unknown_name('key', key, owner, repr(path))}{more}")
    message = ", or ".join(dict.fromkeys(other["msg"].removeprefix("Value error, ") for other in same))
    if first["type"] == "missing":
        return UserError(f"{where}: {path} is missing{more}")
    if not path:
        return UserError(f"{where}: {message}{more}")
    given = "" if isinstance(first["input"], dict) else f" = {first['input']!r}"
    return UserError(f"{where}: {path}{given}: {message}{more}")


def _one_of_several(first: ErrorDetails, other: ErrorDetails) -> bool:
    """Whether two complaints are about one value, which fits none of the types it may have.

    Pydantic then names each type at the end of the place.
    """
    if first is other:
        return True
    same_place = len(first["loc"]) > 1 and first["loc"][:-1] == other["loc"][:-1] and first["loc"] != other["loc"]
    return same_place and first["input"] is other["input"] and first["type"] not in ("extra_forbidden", "missing")


def _owner(model: type[BaseModel], loc: tuple[int | str, ...]) -> tuple[list[str], str]:
    """Keys allowed at the place an unknown key was found, and that key."""
    current: type[BaseModel] | None = model
    for part in loc[:-1]:
        field = current.model_fields.get(str(part)) if current else None
        inner = _model_inside(field.annotation) if field else current
        current = inner
    return (list(current.model_fields) if current else []), str(loc[-1])


def _model_inside(annotation: object) -> type[BaseModel] | None:
    """The pydantic model in an annotation such as ``dict[str, Method]``."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    for argument in getattr(annotation, "__args__", ()):
        found = _model_inside(argument)
        if found is not None:
            return found
    return None
