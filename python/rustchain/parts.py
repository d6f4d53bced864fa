"""Parts of a scene by number or name; the error of a missing one names the nearest."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rustchain.arguments import shown
from rustchain.description.ends import FreeEnd
from rustchain.errors import NoSuchPart
from rustchain.names import suggest

if TYPE_CHECKING:
    from rustchain.description.drive import ChainDrive


def position_of(part: str, number: int, count: int) -> int:
    """Return the place in arrays of the part with this number, from 1."""
    if not 1 <= number <= count:
        near = min(max(number, 1), count)
        msg = (
            f"{part} {shown(number)}: {part}s are numbered 1 to {count}; the nearest is {near}"
            if count
            else f"{part} {shown(number)}: there is none"
        )
        raise NoSuchPart(msg)
    return number - 1


def place_of(part: str, name: object, names: Sequence[str]) -> int:
    """Return the place in arrays of the part with this name."""
    if not isinstance(name, str) or name not in names:
        raise NoSuchPart(f"{part}: {shown(name)} is no {part}; {suggest(name, names)}")
    return names.index(name)


def hinges_of(drive: ChainDrive) -> list[int]:
    """Return the places in arrays of the hinges that there are.

    An open chain has none between its ends, and none at a free end.
    """
    absent = {drive.chain.links}.union(place for place, _ in _free_ends(drive))
    return [k for k in range(drive.hinge_count) if k not in absent]


def bushings_of(drive: ChainDrive) -> list[int]:
    """Return the places in arrays of the bushings that there are.

    An open chain has none between its ends, and none where a free end is the pin of an outer link.
    """
    bare = {place for place, link in _free_ends(drive) if link % 2 == 1}  # links from 0: outer
    return [k for k in range(drive.hinge_count) if k not in {drive.chain.links, *bare}]


def _free_ends(drive: ChainDrive) -> list[tuple[int, int]]:
    """Return the place in arrays of the hinge at each free end, and the link there, from 0."""
    links = drive.chain.links
    places = ((links + 1, 0), (links - 1, links - 1))
    return [
        place
        for end, place in zip(drive.ends or (), places, strict=False)
        if isinstance(end, FreeEnd)
    ]
