"""Checks of the arguments of `Mechanism`: names, numbers, rows, outlines."""

from __future__ import annotations

import json
from contextlib import suppress

import numpy as np
import numpy.typing as npt

from rustchain.arguments import finite_array, shown
from rustchain.description.signals import Signal, refuse_functions
from rustchain.errors import InvalidInput
from rustchain.typing import Numbers, Rows

_LONGEST_NAME = 200  # characters: two lines of a message, and the width of a legend


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


def one_of(name: str, first: str, one: Signal | None, second: str, other: object) -> Signal:
    """Return the one of two that is given."""
    if (one is None) == (other is None):
        msg = f"{first}, {second} of {shown(name)}: exactly one of them must be given"
        raise InvalidInput(msg)
    for field, given in ((first, one), (second, other)):
        setter = f"set_{field}" if field in ("speed", "torque") else ""
        kinds = {"by_speed": "curve", "angle": "position", "position": "position"}
        kind = kinds.get(field, "signal")
        refuse_functions(f"{field} of {shown(name)}", given, kind=kind, setter=setter)
    return one if one is not None else other  # type: ignore[return-value]


def numbers(field: str, given: object, count: int, names: str) -> tuple[float, ...]:
    """Return `given` as `count` finite numbers, or raise `InvalidInput`."""
    values = finite_array(given)
    if values is None or values.shape != (count,):
        words = {2: "two", 3: "three"}[count]
        msg = f"{field} = {shown(given)}: must be {words} finite numbers {names}"
        raise InvalidInput(msg)
    return tuple(map(float, values))


def point(field: str, part: str, name: str, given: object) -> tuple[float, ...]:
    """Return `given` as a point of a part: a joint, a force or a contact."""
    return numbers(f"{field} of {part} {shown(name)}", given, 2, "(x, y) [m]")


def rows(field: str, given: object, width: int) -> npt.NDArray[np.float64]:
    """Return `given` as rows of finite numbers, or raise `InvalidInput`."""
    values = finite_array(given)
    if values is None or (values.shape[1:] != (2,) if width == 2 else values.ndim != 1):
        kind = "rows of two finite numbers (x, y) [m]" if width == 2 else "a list of finite numbers"
        msg = f"{field} = {shown(given)}: must be {kind}"
        raise InvalidInput(msg)
    return values


def arcs(name: str, points: Rows, bulges: Numbers, closed: bool) -> list[tuple[float, ...]]:
    """Return pieces (from, to, centre, 1 convex, -1 concave or 0 straight) of a bulged outline."""
    corners = rows(f"points of contact {shown(name)}", points, 2)
    pieces = len(corners) if closed else len(corners) - 1
    given = rows(f"bulges of contact {shown(name)}", bulges, 1)
    if len(given) != pieces:
        msg = (
            f"bulges of contact {shown(name)} = {shown(bulges)}: must be {pieces} numbers, one "
            "for each piece between two points (0 for a straight one)"
        )
        raise InvalidInput(msg)
    found: list[tuple[float, ...]] = []
    for k, bulge in enumerate(map(float, given)):
        start, end = corners[k], corners[(k + 1) % len(corners)]
        center = 0.5 * (start + end)
        if bulge != 0.0:
            chord = end - start
            left = np.array([-chord[1], chord[0]])
            center += left * (1.0 - bulge**2) / (4.0 * bulge)
        found.append((*map(float, (*start, *end, *center)), float(np.sign(bulge))))
    return found
