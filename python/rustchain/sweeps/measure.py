"""Measures of a study: numbers and arrays of numbers, with names that have no other meaning."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from math import nan
from typing import Any

import numpy as np

from rustchain.arguments import shown
from rustchain.errors import InvalidInput


class NameTaken(InvalidInput):
    """A measured name is that of something else: every case has it, and the sweep ends at once."""


def check_names_of(measured: Any, taken: Collection[str]) -> None:  # noqa: ANN401
    """Refuse a measured quantity whose name the tables of a sweep use for something else."""
    for name in measured if isinstance(measured, Mapping) else ("value",):
        if name in taken:
            known = ", ".join(sorted(map(shown, taken)))
            msg = (
                f"measure: {shown(name)} is the name of a parameter or a column of the sweep too; "
                f"expected another than {known}; name it otherwise"
            )
            raise NameTaken(msg)


def numbers_of(measured: Any, taken: Collection[str]) -> dict[str, Any]:  # noqa: ANN401
    """Return what a run was measured to be as numbers by name; None is none: NaN.

    Raises
    ------
    InvalidInput
        A value is no number, or has a name that is `taken`.
    """
    found = measured if isinstance(measured, Mapping) else {"value": measured}
    numbers = {}
    for name, value in found.items():
        if not isinstance(name, str) or not name:
            msg = f"measure: {shown(name)} is no name: give each measured number a text of its own"
            raise InvalidInput(msg)
        if name in taken:
            msg = f"measure: {shown(name)} is what a study calls something else; name it otherwise"
            raise NameTaken(msg)
        array = np.asarray(nan if value is None else value)
        if not (np.issubdtype(array.dtype, np.number) or np.issubdtype(array.dtype, np.bool_)):
            what = "" if name == "value" and measured is value else f" for {shown(name)}"
            msg = (
                f"measure: gave {shown(value)}{what}: must be a number, an array of numbers or "
                "a dict of them"
            )
            raise InvalidInput(msg)
        if np.issubdtype(array.dtype, np.complexfloating):
            msg = (
                f"measure: gave complex numbers for {shown(name)}: take their sizes and angles "
                "apart"
            )
            raise InvalidInput(msg)
        numbers[name] = array
    return numbers
