"""Reading what users write: YAML files and ``key=value`` changes, checked against a model; mistakes take one line."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, TypeVar

import yaml
from pydantic import BaseModel, BeforeValidator, Field, ValidationError
from pydantic_core import ErrorDetails

from lawn_sb3.errors import UserError, unknown_name

Model = TypeVar("Model", bound=BaseModel)


def _no_switch(value: Any) -> Any:
    if isinstance(value, bool):  # Python would count true as 1
        raise ValueError("must be a number")
    return value


Number = Annotated[float, BeforeValidator(_no_switch)]
"""A number; YAML takes ``1e-3`` for text, so that is one too."""
Whole = Annotated[int, Field(strict=True)]
"""A whole number, neither text nor true."""

MERGE = "tag:yaml.org,2002:merge"
"""Of the key ``<<``."""
IN_YAML = {
    "dict_type": "keys and values",
    "model_type": "keys and values",
    "list_type": "a list",
    "tuple_type": "a list",
    "string_type": "text",
    "int_type": "a whole number",
    "int_parsing": "a whole number",
    "int_from_float": "a whole number",
    "float_type": "a number",
    "float_parsing": "a number",
    "bool_type": "true or false",
    "bool_parsing": "true or false",
}
"""What a value should be, by pydantic's kind of complaint, in the words of those who write YAML."""


class _NoKeyTwice(yaml.SafeLoader):
    """PyYAML's loader, which lets the last of equal keys win, but for that."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        keys = [self.construct_object(key, deep=True) for key, _ in node.value if key.tag != MERGE]
        for k, key in enumerate(keys):
            if key in keys[:k]:
                raise yaml.constructor.ConstructorError(problem=f"key {key!r} twice", problem_mark=node.start_mark)
        mapping: dict[Any, Any] = super().construct_mapping(node, deep)
        return mapping


def read_yaml_mapping(path: Path, what: str) -> dict[str, Any]:
    """Read a YAML file that must hold a mapping.

    :param path: the file
    :param what: what the file should be, for the error
    :return: its content
    :raises UserError: if the file cannot be read, is not YAML, or holds no mapping
    """
    try:
        content = yaml.load(path.read_text(encoding="utf-8"), Loader=_NoKeyTwice)
    except OSError as error:
        raise UserError(f"{what} file {str(path)!r} cannot be read: {error.strerror}") from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:  # a date that does not exist is a ValueError
        mark = getattr(error, "problem_mark", None)
        where = f", line {mark.line + 1}" if mark is not None else ""
        reason = getattr(error, "problem", None) or str(error).splitlines()[0]
        raise UserError(f"{what} file {str(path)!r}{where} is not valid YAML: {reason}") from None
    if not isinstance(content, dict):
        raise UserError(f"{what} file {str(path)!r} must hold keys and values, not {type(content).__name__}")
    return content


def parse_overrides(overrides: Sequence[str], option: str = "--set") -> dict[str, Any]:
    """Read ``key=value`` changes.

    :param overrides: the changes, each value in YAML
    :param option: the command-line option they came from, for the error
    :return: keys and values; of equal keys the last counts
    :raises UserError: if one has no ``=`` or its value is not YAML

    >>> parse_overrides(["num_uavs=8", "rbs_per_gbs=[1, 2, 3, 4]"])
    {'num_uavs': 8, 'rbs_per_gbs': [1, 2, 3, 4]}
    """
    changes: dict[str, Any] = {}
    for text in overrides:
        key, equals, value = text.partition("=")
        if not equals or not key.strip():
            raise UserError(f"{option} {text!r}: expected key=value")
        try:
            changes[key.strip()] = yaml.safe_load(value)
        except (yaml.YAMLError, ValueError):  # a date that does not exist is a ValueError
            raise UserError(f"{option} {text!r}: the value is not valid YAML") from None
    return changes


def validated(model: type[Model], values: Mapping[str, Any], where: str) -> Model:
    """Check values against a model.

    :param model: the pydantic model
    :param values: its fields, as the user gave them
    :param where: the file, preset or option they came from, for the error
    :return: the model
    :raises UserError: one line that names the field, the value given and what is allowed
    """
    try:
        return model.model_validate(values)
    except ValidationError as error:
        raise UserError(f"{where}: {_first_complaint(error, model)}") from None


def _first_complaint(error: ValidationError, model: type[BaseModel]) -> str:
    """Pydantic's first complaint in one line, and how many more there are."""
    first, *others = error.errors()
    errors = [
        first,
        *(other for other in others if other["loc"] != first["loc"][:-1]),
    ]
    same = [other for other in errors if _about_one_value(first, other)]
    loc = first["loc"][:-1] if len(same) > 1 else first["loc"]
    path = ".".join(str(part) for part in loc)
    more = f" (and {len(errors) - len(same)} more)" if len(errors) > len(same) else ""
    if first["type"] == "extra_forbidden":
        return f"{unknown_name('key', str(first['loc'][-1]), _known_keys(model, first['loc']), repr(path))}{more}"
    if first["type"] == "missing":
        return f"{path} is missing{more}"
    if first["loc"][-1:] == ("[key]",):
        return f"{'.'.join(str(part) for part in first['loc'][:-2])}: the key {first['input']!r} must be text{more}"
    message = ", or ".join(dict.fromkeys(map(_complaint, same)))
    if not path:
        return f"{message}{more}"
    given = "" if isinstance(first["input"], dict) else f" = {first['input']!r}"
    return f"{path}{given}: {message}{more}"


def _complaint(error: ErrorDetails) -> str:
    """One complaint, in the words of those who write YAML."""
    if error["type"] == "too_short":
        return f"must hold at least {error['ctx']['min_length']}"
    if error["type"] in IN_YAML:
        return f"must be {IN_YAML[error['type']]}"
    return error["msg"].removeprefix("Value error, ").replace("Input should be", "must be")


def _about_one_value(first: ErrorDetails, other: ErrorDetails) -> bool:
    """Whether two complaints are about one value that fits none of its types; the last part of ``loc`` names a type."""
    if first is other:
        return True
    same_place = len(first["loc"]) > 1 and first["loc"][:-1] == other["loc"][:-1] and first["loc"] != other["loc"]
    return same_place and first["input"] is other["input"] and first["type"] not in ("extra_forbidden", "missing")


def _known_keys(model: type[BaseModel], loc: tuple[int | str, ...]) -> list[str]:
    """Keys allowed where an unknown key was found."""
    current: type[BaseModel] | None = model
    for part in loc[:-1]:
        field = current.model_fields.get(str(part)) if current else None
        current = _model_inside(field.annotation) if field else current
    return list(current.model_fields) if current else []


def _model_inside(annotation: object) -> type[BaseModel] | None:
    """The pydantic model in an annotation such as ``dict[str, Method]``."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    inside = (_model_inside(argument) for argument in getattr(annotation, "__args__", ()))
    return next((found for found in inside if found is not None), None)
