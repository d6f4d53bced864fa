"""Shapes of the bodies of a chain drive."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rustchain import _rustchain
from rustchain.description.drive import ChainDrive
from rustchain.description.ends import AnchoredEnd, LoadedEnd
from rustchain.description.guides import GuideRail, SmoothIdler
from rustchain.plot import outlines
from rustchain.plot.shapes import GROUND_ROW, Bar, Forces, Kind, Shape, Shapes
from rustchain.typing import Array


def shapes_of_drive(drive: ChainDrive) -> Shapes:
    """Return the outlines of a drive."""
    chain, links, hinges = drive.chain, drive.chain.links, drive.hinge_count
    pitch, half = chain.pitch, 0.5 * chain.pitch
    wheels = hinges if chain.roller is None else 2 * hinges
    found: list[Shape | Bar] = []
    for body, sprocket in enumerate(drive.sprockets, wheels):
        found += [
            Shape("sprocket", (body,), _rustchain.tooth_outline(sprocket, chain, 12)),
            Shape("hub", (body,), outlines.circle(half)),
            # Points to gap 0.
            Shape("mark", (body,), pitch * np.array([[0.5, 0.0], [1.1, 0.0]]), closed=False),
        ]
    guides = range(wheels + len(drive.sprockets), wheels + len(drive.sprockets) + len(drive.guides))
    found += _arms(drive, wheels, guides)
    for body, guide in zip(guides, drive.guides, strict=True):
        found.append(Shape("rail", (body,), guide.outline() + _from_bearing(guide)))
    found += _ends(drive)
    # First link, height of the drawn plate over the pitch.
    plates: tuple[tuple[Kind, int, float], ...] = (("inner", 0, 0.8), ("outer", 1, 0.7))
    for kind, first, share in plates:
        plate = outlines.plate(pitch, share * pitch)
        found.append(Shape(kind, tuple(range(first, links, 2)), plate))
    places = hinge_places(drive)
    front = tuple(body for body, sign in places if sign > 0)
    rear = tuple(body for body, sign in places if sign < 0)
    if chain.roller is not None:
        rollers = tuple(hinges + k for k in range(hinges) if drive.ends is None or k != links)
        inner, outer = chain.roller.bore_radius, chain.roller.radius
        found += [
            Shape("roller", rollers, outlines.circle(outer)),
            Shape("roller", rollers, outlines.circle(inner)),
            # Shows how each has turned.
            Shape("roller", rollers, np.array([[inner, 0.0], [outer, 0.0]]), closed=False),
        ]
    circles: tuple[tuple[Kind, float], ...] = (
        ("bushing", chain.bushing_radius),
        ("pin", chain.hinge.pin_radius),
    )
    for kind, radius in circles:
        for bodies, side in ((front, half), (rear, -half)):
            if bodies:
                found.append(Shape(kind, bodies, outlines.circle(radius) + [side, 0.0]))
    anchors = np.array([[sign * half, 0.0] for _, sign in places])
    carriers = tuple(body for body, _ in places)
    forces = [Forces("hinge", "hinge_force_vector", carriers, anchors)]
    if chain.roller is not None:
        bodies = tuple(range(hinges, 2 * hinges))
        forces.append(Forces("tooth", "tooth_force_vector", bodies, np.zeros((hinges, 2))))
    else:
        forces.append(Forces("tooth", "tooth_force_vector", carriers, anchors))
    return Shapes(tuple(found), tuple(forces), pitch)


def hinge_places(drive: ChainDrive) -> list[tuple[int, float]]:
    """Return of each hinge in arrays its link and the end of it: 1 the front, -1 the rear.

    The one of an open chain that is none stands where the hinge before it does.
    """
    links = drive.chain.links
    places = [(link, 1.0) for link in range(links)]
    return places if drive.ends is None else [*places, (links - 1, 1.0), (0, -1.0)]


def load_size(load: LoadedEnd) -> float:
    """Return the radius of a ball of steel with the mass of a load [m]."""
    return float(np.cbrt(load.mass / (7850.0 * 4.0 / 3.0 * np.pi)))


def _arms(drive: ChainDrive, wheels: int, guides: range) -> Iterator[Shape | Bar]:
    """Yield the arms of tensioner and blades, with their pivots: as wide as links are."""
    width = 0.35 * drive.chain.pitch
    tensioner = drive.tensioner
    if tensioner is not None and tensioner.pivot is not None:
        body = wheels + tensioner.sprocket - 1
        ends = np.array([tensioner.pivot, (0.0, 0.0)])
        yield Bar("arm", (GROUND_ROW, body), ends, width)
        yield Shape("pin", (GROUND_ROW,), outlines.circle(0.5 * width) + ends[0])
    for body, guide in zip(guides, drive.guides, strict=True):
        if isinstance(guide, SmoothIdler) or guide.arm is None:
            continue
        # To the nearer end of the blade, or to its middle where that is nearer; the body's frame
        # sits at the pivot.
        reach = guide.end_radius - 0.5 * guide.length
        marks = np.array([[0.0, reach], [0.0, 0.0], [0.0, -reach]]) + _from_bearing(guide)
        nearest = marks[np.argmin(np.hypot(*marks.T))]
        yield Bar("arm", (body, body), np.array([(0.0, 0.0), nearest]), width)
        yield Shape("pin", (body,), outlines.circle(0.5 * width))


def _ends(drive: ChainDrive) -> Iterator[Shape]:
    """Yield what an open chain ends in: hatched anchors, loads that are balls on their hooks."""
    if drive.ends is None:
        return
    links, side = drive.chain.links, 0.55 * drive.chain.pitch
    # The end behind the last link comes first in arrays.
    for body, end, sign in zip((links, links + 1), drive.ends[::-1], (-1.0, 1.0), strict=True):
        if isinstance(end, AnchoredEnd):
            square = side * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
            yield Shape("anchor", (body,), square)
            yield Shape("anchor", (body,), square[[0, 2]], closed=False)
            yield Shape("anchor", (body,), square[[1, 3]], closed=False)
        elif isinstance(end, LoadedEnd):
            yield Shape("load", (body,), outlines.circle(load_size(end)))
            hook = np.array([[sign * end.arm, 0.0], [0.0, 0.0]])
            yield Shape("load", (body,), hook, closed=False)


def _from_bearing(guide: GuideRail | SmoothIdler) -> Array:
    """Return a guide's middle in a frame at its bearing that turns with it [m]."""
    if isinstance(guide, SmoothIdler) or guide.arm is None:
        return np.zeros(2)
    out = np.array(guide.direction) / np.hypot(*guide.direction)
    arm = np.array(guide.center) - np.array(guide.arm.pivot)
    return np.array([arm @ out, out[0] * arm[1] - out[1] * arm[0]])
