"""Functions of time, and what all parts of a mechanism share: plain fields, names."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Sequence
from contextlib import suppress
from typing import TypeAlias, get_type_hints

from rustchain.arguments import admitted, shown
from rustchain.description.base import Description, description, plain
from rustchain.errors import InvalidInput

Point: TypeAlias = Sequence[float]
Rows: TypeAlias = Sequence[Sequence[float]]

_LONGEST_NAME = 200  # characters: two lines of a message, and the width of a legend


class Part(Description):
    """A part of a mechanism, which is checked when the mechanism is put together."""

    def __post_init__(self) -> None:
        """Turn lists and arrays into tuples."""
        for field in dataclasses.fields(self):
            object.__setattr__(self, field.name, plain(getattr(self, field.name)))
        check_part_name(f"name of a {type(self).__name__.lower()}", getattr(self, "name", None))


def check_part_name(field: str, name: object) -> None:
    """Raise `InvalidInput` unless `name` can identify a part."""
    if not isinstance(name, str):
        raise InvalidInput(f"{field} = {shown(name)}: must be text")
    if not name.strip():
        quoted = json.dumps(name[:_LONGEST_NAME])
        msg = f"{field} = {quoted}: must not be blank: results and messages are by name"
        raise InvalidInput(msg)
    if len(name) > _LONGEST_NAME:
        msg = (
            f"{field} = {shown(name)}: has {len(name)} characters; expected at most {_LONGEST_NAME}"
        )
        raise InvalidInput(msg)
    check_name(field, name)


def check_name(field: str, name: object) -> None:
    """Refuse a name that a file of results cannot hold; what is no text is refused elsewhere."""
    if not isinstance(name, str):
        return
    with suppress(UnicodeEncodeError):
        if b"\0" not in name.encode():
            return
    msg = f"{field} = {name!r}: cannot be saved; expected text without NUL and lone surrogates"
    raise InvalidInput(msg)


class Function(Part):
    """A function of time or of penetration: the types of its fields are checked at once."""

    def __post_init__(self) -> None:
        """Turn lists and arrays into tuples, and check the type of every field."""
        types = get_type_hints(type(self))
        for field in dataclasses.fields(self):
            where = f"{type(self).__name__}.{field.name}"
            value = admitted(where, getattr(self, field.name), types[field.name])
            object.__setattr__(self, field.name, value)


@description(frozen=True)
class SmoothStep(Function):
    """From one value to another with two continuous derivatives.

    Attributes
    ----------
    start, end : float
        When it changes [s].
    before, after : float
        Values.
    """

    start: float
    end: float
    before: float
    after: float


@description(frozen=True)
class Table(Function):
    """Straight lines between rows of (time [s], value), held at both ends; a ramp has two rows.

    Attributes
    ----------
    rows : sequence of (time, value)
        At least one; times increase.
    """

    rows: Rows


@description(frozen=True)
class Spline(Function):
    """A cubic spline with free ends through rows of (time [s], value).

    Attributes
    ----------
    rows : sequence of (time, value)
        At least two; times increase.
    """

    rows: Rows


@description(frozen=True)
class Sines(Function):
    """A sum of sines: offset + sum of amplitude * sin(frequency * t + phase).

    Attributes
    ----------
    terms : sequence of (amplitude, angular frequency, phase)
        The sines [rad/s], [rad].
    offset : float
        Mean value.
    """

    terms: Rows
    offset: float = 0.0


TimeFunction: TypeAlias = float | SmoothStep | Table | Spline | Sines
