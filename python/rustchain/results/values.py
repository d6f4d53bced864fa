"""Values that hold arrays: read-only, and equal where all of their numbers are."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np


def read_only(value: Any) -> Any:  # noqa: ANN401
    """Return an array, or the arrays of a tuple or a dict, that cannot be written to."""
    if isinstance(value, np.ndarray):
        if not value.flags.writeable:
            return value
        view = value.view()
        view.flags.writeable = False
        return view
    if isinstance(value, tuple):
        return tuple(map(read_only, value))
    if isinstance(value, dict):
        return {name: read_only(each) for name, each in value.items()}
    return value


def equal(one: object, other: object) -> bool:
    """Return whether two values are the same to the last bit; NaN is equal to NaN.

    Exceptions are equal where class and text are.
    """
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        if not (isinstance(one, np.ndarray) and isinstance(other, np.ndarray)):
            return False
        return one.dtype == other.dtype and np.array_equal(
            one, other, equal_nan=one.dtype.kind == "f"
        )
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(equal(one[name], other[name]) for name in one)
    if isinstance(one, list | tuple) and type(one) is type(other):
        return len(one) == len(other) and all(map(equal, one, other))
    if isinstance(one, Exception) and isinstance(other, Exception):
        return type(one) is type(other) and str(one) == str(other)
    if isinstance(one, float) and isinstance(other, float) and math.isnan(one):
        return math.isnan(other)
    return bool(one == other)


_LINE = 100  # characters of a repr


class ArrayValue:
    """A value with arrays among its attributes, which can be compared, copied and pickled."""

    __hash__ = None  # type: ignore[assignment]

    def __init_subclass__(cls) -> None:
        """Keep the short repr, which a dataclass would replace by one with all numbers."""
        if "__repr__" not in vars(cls):
            cls.__repr__ = ArrayValue.__repr__  # type: ignore[method-assign]

    def __repr__(self) -> str:
        """Return the names of the arrays, and the number of rows."""
        arrays = {name: each for name, each in vars(self).items() if isinstance(each, np.ndarray)}
        rows = {len(each) for each in arrays.values()}
        count = f"{rows.pop()} rows of " if len(rows) == 1 else ""
        text = f"<{type(self).__name__}: {count}{', '.join(arrays)}>"
        return text if len(text) <= _LINE else f"{text[: _LINE - 4]}...>"

    def __eq__(self, other: object) -> bool:
        """Return whether all attributes are equal, arrays to the last bit."""
        if type(other) is not type(self):
            return NotImplemented
        return equal(vars(self), vars(other))

    def __setstate__(self, state: Mapping[str, Any]) -> None:
        """Take the attributes of a pickle or a copy, whose arrays are read-only again."""
        self.__dict__.update({name: read_only(value) for name, value in state.items()})
