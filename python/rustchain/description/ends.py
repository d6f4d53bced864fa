"""Ends of an open chain: anchored, loaded or free."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rustchain.description.base import Description, description
from rustchain.description.signals import Sines, SmoothStep, Spline, Table, refuse_functions
from rustchain.typing import Point, Rows

if TYPE_CHECKING:
    from rustchain.description.drive import ChainDrive


@description(frozen=True)
class AnchoredEnd(Description):
    """A pin that holds an end of an open chain, at rest or moved.

    Attributes
    ----------
    position : (float, float)
        Position of the pin at the start [m].
    velocity : (x, y) or rows of (time, x, y)
        Velocity of the pin [m/s]: two numbers, rows of (time, value) or signals (`Table`, `Spline`,
        `Sines`, `SmoothStep`); or rows of both. Rows are linear between each other and constant
        outside. The position is the integral.
    links : int, optional
        Links between this end and the first sprocket. By default the smallest number that reaches
        it, or the remaining links if the other end has a number.

    Examples
    --------
    >>> rc.AnchoredEnd((0.0, 0.0), velocity=(0.0, 0.1))  # drawn upward
    AnchoredEnd(position=(0.0, 0.0), velocity=(0.0, 0.1))
    """

    position: Point
    velocity: Sequence[float | Rows | SmoothStep | Table | Spline | Sines] | Rows = (0.0, 0.0)
    links: int | None = None

    def __post_init__(self) -> None:
        """Refuse functions, and let the rest be checked."""
        parts = self.velocity if isinstance(self.velocity, list | tuple) else [self.velocity]
        refuse_functions("AnchoredEnd.velocity", *parts)
        super().__post_init__()


@description(frozen=True)
class LoadedEnd(Description):
    """A body that hangs from an end of an open chain: a hook, a weight.

    Attributes
    ----------
    mass : float
        Mass [kg].
    inertia : float, optional
        Moment of inertia about its centre of mass [kg m^2]; by default that of a ball of steel.
    arm : float
        Distance from its pin to its centre of mass [m].
    position : (float, float), optional
        Position of its pin at the start [m]; by default straight below the last sprocket, or below
        the other end where there is no sprocket.
    links : int, optional
        Links between this end and the nearest sprocket; by default the remaining links.

    Examples
    --------
    >>> rc.LoadedEnd(250.0)  # [kg]
    LoadedEnd(mass=250.0)
    """

    mass: float
    inertia: float | None = None
    arm: float = 0.0
    position: Point | None = None
    links: int | None = None


@description(frozen=True)
class FreeEnd(Description):
    """An end of an open chain that nothing holds.

    Attributes
    ----------
    position : (float, float), optional
        Position of the end at the start [m]; by default straight below the last sprocket, or below
        the other end where there is no sprocket.
    links : int, optional
        Links between this end and the nearest sprocket; by default the remaining links.

    Examples
    --------
    >>> rc.open_chain("ANSI 40", (rc.AnchoredEnd((0.0, 0.0)), rc.FreeEnd()), links=10).ends[1]
    FreeEnd()
    """

    position: Point | None = None
    links: int | None = None


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
