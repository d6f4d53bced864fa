"""Counts that arguments ask for, checked before anything is made of them."""

from __future__ import annotations

import itertools
import reprlib
from collections.abc import Iterable
from typing import TypeVar

import numpy as np

from rustchain.errors import InvalidInput

_Item = TypeVar("_Item")


def count_within(where: str, value: object, least: int, most: int) -> int:
    """Return `value`, a whole number from `least` to `most`, or raise InvalidInput."""
    whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if whole and least <= value <= most:  # type: ignore[operator]
        return int(value)  # type: ignore[call-overload, no-any-return]
    msg = f"{where} = {reprlib.repr(value)}: must be a whole number from {least} to {most}"
    raise InvalidInput(msg)


def items_within(where: str, values: Iterable[_Item], most: int) -> list[_Item]:
    """Return the items of `values`, which may have no end, or raise where they are too many."""
    items = list(itertools.islice(values, most + 1))
    if len(items) > most:
        msg = f"{where}: got more than {most} values; expected at most {most}"
        raise InvalidInput(msg)
    return items
