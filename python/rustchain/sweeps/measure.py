"""Measures of a study: numbers and arrays of numbers, with names that have no other meaning."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from math import nan
from typing import Any

import numpy as np
import numpy.typing as npt

from rustchain.analysis.summary import Summary
from rustchain.arguments import shown
from rustchain.errors import InvalidInput


class NameTaken(InvalidInput):
    """A measured name is that of something else: every case has it, and the sweep ends at once."""


def check_measure(measure: object) -> None:
    """Refuse a measure that is neither a function nor None."""
    if measure is not None and not callable(measure):
        msg = f"measure = {shown(measure)}: must be a function of a Result, or None"
        raise InvalidInput(msg)


def check_names_of(measured: Any, taken: Collection[str]) -> None:  # noqa: ANN401
    """Refuse a measured quantity whose name the tables of a sweep use for something else.

    The dimensions and the numbers of an array have names in tables, too.
    """
    given = measured if isinstance(measured, Mapping) else {"value": measured}
    check_distinct(given)
    for name in given:
        if name in taken:
            known = ", ".join(sorted(map(shown, taken)))
            msg = (
                f"measure: {shown(name)} is the name of a parameter or a column of the sweep too; "
                f"expected another than {known}; name it otherwise"
            )
            raise NameTaken(msg)
    shapes = {str(name): _shape_of(value) for name, value in given.items()}
    for other, shape in (dict.fromkeys(taken, ()) | shapes).items():
        if (array := _array_with(other, len(shape), shapes)) is not None:
            what = "measured quantity" if other in shapes else "parameter or dimension"
            msg = (
                f"measure: in tables, the {what} {shown(other)} and a dimension or a number of the "
                f"array {shown(array)} have the same name; name one of them otherwise"
            )
            raise NameTaken(msg)


def check_distinct(names: Iterable[object]) -> None:
    """Refuse measured names that are the same text, which tables have for each name."""
    texts: dict[str, object] = {}
    for name in names:
        other = texts.setdefault(str(name), name)
        if other is not name:
            msg = (
                f"measure: {shown(other)} and {shown(name)} are one name in tables; name one of "
                "them otherwise"
            )
            raise NameTaken(msg)


def array_of(name: str, value: object) -> npt.NDArray[Any]:
    """Return a measured value as an array, or raise where its rows have unlike lengths."""
    try:
        return np.asarray(value)
    except ValueError as error:
        msg = (
            f"measure: {shown(name)} = {shown(value)} has rows of unlike lengths; expected an "
            "array, or a name for each row"
        )
        raise InvalidInput(msg) from error


def _shape_of(value: Any) -> tuple[int, ...]:  # noqa: ANN401
    """Return the shape of a measured value; () of what is no array."""
    try:
        return np.shape(value)
    except (TypeError, ValueError):  # rows of unlike lengths
        return ()


def _array_with(name: str, dimensions: int, shapes: Mapping[str, tuple[int, ...]]) -> str | None:
    """Return the array with the name of a quantity of so many dimensions in tables, or None.

    Array "a" has the dimensions "a_0", "a_1", and the numbers "a_0_0", "a_0_1", ...
    """
    places: list[int] = []
    head, _, last = name.rpartition("_")
    while last.isdecimal() and str(int(last)) == last:
        places.insert(0, int(last))
        shape = shapes.get(head, ())
        inside = all(place < size for place, size in zip(places, shape, strict=False))
        if (len(places) == 1 and places[0] < len(shape)) or (
            inside and len(places) + dimensions == len(shape)
        ):
            return head
        head, _, last = head.rpartition("_")
    return None


def numbers_of(measured: Any, taken: Collection[str]) -> dict[str, Any]:  # noqa: ANN401
    """Return what a run was measured to be as numbers by name; None is none: NaN.

    A `Summary` remains one, which has units.

    Raises
    ------
    InvalidInput
        A value is no number, or has a name that is `taken`.
    """
    found = measured if isinstance(measured, Mapping) else {"value": measured}
    numbers: dict[str, Any] = Summary() if isinstance(measured, Summary) else {}
    for name, value in found.items():
        if not isinstance(name, str) or not name:
            msg = f"measure: {shown(name)} is no name: give each measured number a text of its own"
            raise InvalidInput(msg)
        if name in taken:
            msg = f"measure: {shown(name)} is what a study calls something else; name it otherwise"
            raise NameTaken(msg)
        array = array_of(name, nan if value is None else value)
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
