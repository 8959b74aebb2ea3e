"""Nested values as plain JSON and arrays, and back: nothing that is read can run code.

What JSON knows stays as it is. Everything else becomes an object with one key, its kind: a tuple, a deque, a mapping, a
number of NumPy's, an array, a tensor, or one of the kinds that the caller knows.
"""

from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import torch as th
from numpy.typing import NDArray

Arrays = dict[str, NDArray[Any]]
"""Arrays by the names that the plain form has for them."""
Kinds = Mapping[str, tuple[type, Callable[[Any], Any], Callable[[Any], Any]]]
"""What else may be told in plain form: by its kind the type, what it is made of, and how it is made again."""


def to_plain(value: Any, arrays: Arrays, kinds: Kinds) -> Any:
    """The plain form of a value.

    :param value: the value
    :param arrays: gets the arrays and tensors in it
    :param kinds: what it may hold besides numbers, texts, arrays and what is made of them
    :return: what JSON can write
    :raises TypeError: if it holds anything else
    """

    def plain(part: Any) -> Any:
        return to_plain(part, arrays, kinds)

    def kept(array: NDArray[Any]) -> str:
        if array.dtype.hasobject:
            raise TypeError("an array of objects has no plain form")
        name = str(len(arrays))
        arrays[name] = array
        return name

    if value is None or type(value) in (bool, int, float, str):
        return value
    for kind, (of, taken_apart, _) in kinds.items():
        if isinstance(value, of):
            return {kind: plain(taken_apart(value))}
    if isinstance(value, np.generic) and not value.dtype.hasobject:
        return {"number": [value.dtype.str, value.item()]}
    if isinstance(value, np.ndarray):
        return {"array": kept(value)}
    if isinstance(value, th.Tensor):
        return {"tensor": kept(value.detach().cpu().numpy())}
    if isinstance(value, Mapping):
        return {"mapping": [[plain(key), plain(one)] for key, one in value.items()]}
    if isinstance(value, list):
        return [plain(one) for one in value]
    if isinstance(value, tuple):
        return {"tuple": [plain(one) for one in value]}
    if isinstance(value, deque):
        return {"deque": [value.maxlen, [plain(one) for one in value]]}
    raise TypeError(f"a {type(value).__name__} has no plain form")


def from_plain(form: Any, arrays: Mapping[str, NDArray[Any]], kinds: Kinds) -> Any:
    """The value of a plain form.

    :param form: what :func:`to_plain` returned
    :param arrays: the arrays in it
    :param kinds: as for :func:`to_plain`
    :return: the value
    :raises ValueError: if it is no plain form, or a value in it is not allowed
    """

    def value(part: Any) -> Any:
        return from_plain(part, arrays, kinds)

    if isinstance(form, list):
        return [value(one) for one in form]
    if not isinstance(form, dict):
        return form
    ((kind, content),) = form.items()
    if kind in kinds:
        return kinds[kind][2](value(content))
    if kind == "number":
        return np.dtype(content[0]).type(content[1])
    if kind == "array":
        return arrays[content]
    if kind == "tensor":
        return th.as_tensor(arrays[content])
    if kind == "mapping":
        return {value(key): value(one) for key, one in content}
    if kind == "tuple":
        return tuple(value(one) for one in content)
    if kind == "deque":
        return deque([value(one) for one in content[1]], maxlen=content[0])
    raise ValueError(f"{kind!r} is no kind of value")
