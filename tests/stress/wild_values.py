"""Values that no argument should be, by kind: what `calls` passes to every public callable."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

import rustchain as rc


class _Raising:
    """An object of which one special method raises."""

    def __init__(self, method: str) -> None:
        def raising(*_: object) -> object:
            msg = f"{method} of a hostile object"
            raise RuntimeError(msg)

        self.__class__ = type(f"Raising{method.strip('_').title()}", (), {method: raising})


class _Wrong:
    """An object whose conversions return what they must not."""

    __float__ = __index__ = __len__ = lambda self: "no number"  # type: ignore[assignment]
    __array__ = lambda self, *_, **__: "no array"  # noqa: E731


class _Wordy:
    """An object whose representation fills many screens."""

    def __repr__(self) -> str:
        return "wordy " * 100_000


class _HostileFloat(float):
    """A float whose representation raises."""

    def __repr__(self) -> str:
        msg = "__repr__ of a hostile float"
        raise RuntimeError(msg)


class _HalfIterable:
    """An iterable that raises after two values."""

    def __iter__(self) -> Any:
        yield 1.0
        yield 2.0
        msg = "__iter__ of a hostile object"
        raise RuntimeError(msg)


def _cyclic_list() -> list[Any]:
    cycle: list[Any] = [1.0]
    cycle.append(cycle)
    return cycle


def _cyclic_dict() -> dict[str, Any]:
    cycle: dict[str, Any] = {}
    cycle["self"] = cycle
    return cycle


def _deep(depth: int) -> list[Any]:
    nested: list[Any] = []
    for _ in range(depth):
        nested = [nested]
    return nested


_SPECIAL = (
    "float",
    "index",
    "array",
    "repr",
    "str",
    "eq",
    "iter",
    "bool",
    "hash",
    "len",
    "getattr",
)

# What is no real number, whatever is asked for.
NO_NUMBERS: dict[str, Callable[[], Any]] = {
    "NaN": lambda: math.nan,
    "complex": lambda: 1j,
    "text": lambda: "x",
    "empty text": str,
    "number as text": lambda: "1",
    "text with a null": lambda: "a\0b",
    "long text": lambda: "x" * 5000,
    "lone surrogate": lambda: "\ud800",
    "bytes": lambda: b"x",
    "decimal NaN": lambda: Decimal("nan"),
    "signalling NaN": lambda: Decimal("snan"),
    "decimal beyond float": lambda: Decimal("1e5000"),
    "fraction beyond float": lambda: Fraction(10**400, 3),
    "integer beyond float": lambda: 10**400,
    "negative beyond float": lambda: -(10**400),
    "integer beyond text": lambda: 10**6000,
    "longdouble beyond float": lambda: np.longdouble("1e4000"),
    "NumPy NaN": lambda: np.float32("nan"),
    "date": lambda: np.datetime64("2020-01-01"),
    "duration": lambda: np.timedelta64(3, "s"),
    "array of text": lambda: np.array(["a", "b"]),
    "array of objects": lambda: np.array([None, 1.0, object()]),
    "array of shape (2, 2, 2)": lambda: np.zeros((2, 2, 2)),
    "empty array": lambda: np.zeros(0),
    "array of NaN": lambda: np.full((40, 3), math.nan),
    "structured array": lambda: np.zeros(2, dtype=[("a", float), ("b", int)]),
    "empty list": list,
    "ragged list": lambda: [[1.0, 2.0], [3.0]],
    "cyclic list": _cyclic_list,
    "cyclic dict": _cyclic_dict,
    "nested list": lambda: _deep(100_000),
    "huge list": lambda: list(range(100_000)),
    "list of text": lambda: ["a", "b"],
    "list of None": lambda: [None, None],
    "set": lambda: {1.0, 2.0},
    "dict": lambda: {"a": 1.0},
    "generator": lambda: (x for x in (1.0, 2.0)),
    "endless iterator": itertools.count,
    "object": object,
    "class": lambda: dict,
    "description class": lambda: rc.Hertz,
    "function": lambda: lambda *_, **__: None,
    "ellipsis": lambda: ...,
    "path": lambda: Path("/nowhere/at/all"),
    "material": rc.Material,
    "sprocket": lambda: rc.Sprocket(17, (0.0, 0.0), rc.Free()),
    "law": rc.Hertz,
    "drive": rc.paper_drive,
    "mechanism": rc.Mechanism,
    "wrong conversions": _Wrong,
    "wordy": _Wordy,
    "list of wordy": lambda: [_Wordy()] * 3,
    "iterable that raises": _HalfIterable,
    **{f"raising {name}": lambda name=name: _Raising(f"__{name}__") for name in _SPECIAL},
}

# Numbers that some arguments may be, and others not.
NUMBERS: dict[str, Callable[[], Any]] = {
    "zero": lambda: 0,
    "minus one": lambda: -1,
    "two": lambda: 2,
    "99": lambda: 99,
    "a broken number": lambda: 3.7e-3,
    "minus zero": lambda: -0.0,
    "infinity": lambda: math.inf,
    "minus infinity": lambda: -math.inf,
    "huge": lambda: 1e308,
    "tiny": lambda: 1e-308,
    "2**63": lambda: 2**63,
    "decimal": lambda: Decimal("0.001"),
    "fraction": lambda: Fraction(1, 1000),
    "longdouble": lambda: np.longdouble("0.001"),
    "NumPy integer": lambda: np.int64(2),
    "array of one number": lambda: np.array(1e-3),
    "float with a hostile repr": lambda: _HostileFloat(1e-3),
}

OTHERS: dict[str, Callable[[], Any]] = {
    "None": lambda: None,
    "True": lambda: True,
    "False": lambda: False,
    "NumPy True": lambda: np.True_,
    "array of three": lambda: np.zeros(3),
    "two numbers": lambda: (1.0, 2.0),
    "rows": lambda: [(0.0, 1.0), (1.0, 2.0)],
}

ALL = NO_NUMBERS | NUMBERS | OTHERS
