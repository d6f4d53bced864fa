"""Parts of a scene by number or name; the error of a missing one names the nearest."""

from __future__ import annotations

from collections.abc import Sequence

from rustchain.arguments import shown
from rustchain.errors import NoSuchPart
from rustchain.names import suggest
from rustchain.typing import Count


def position_of(part: str, number: Count, count: int) -> int:
    """Return the place in arrays of the part with this number, from 1."""
    if not 1 <= number <= count:
        near = min(max(number, 1), count)
        msg = (
            f"{part} {shown(number)}: {part}s are numbered 1 to {count}; the nearest is {near}"
            if count
            else f"{part} {shown(number)}: there is none"
        )
        raise NoSuchPart(msg)
    return int(number) - 1


def place_of(part: str, name: object, names: Sequence[str]) -> int:
    """Return the place in arrays of the part with this name."""
    if not isinstance(name, str) or name not in names:
        raise NoSuchPart(f"{part}: {shown(name)} is no {part}; {suggest(name, names)}")
    return names.index(name)
