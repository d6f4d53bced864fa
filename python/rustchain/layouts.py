"""Drives of any number of sprockets from a handful of numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from rustchain import _rustchain
from rustchain._names import known_keywords
from rustchain.catalogue import catalogue_chain
from rustchain.drive import Chain, ChainDrive, Hinges, Point, Sprocket, Tensioner
from rustchain.errors import InvalidInput
from rustchain.guides import GuideRail, SmoothIdler

_ANY_LINKS = 100  # of a chain whose links are still to be counted


@known_keywords
def chain_drive(
    chain: str | Chain,
    sprockets: Sequence[Sprocket],
    links: int | None = None,
    adjust: int | None = None,
    direction: Point | None = None,
    reach: float | None = None,
    tensioner: Tensioner | None = None,
    gravity: Point = (0.0, -9.81),
    name: str = "",
    hinges: Hinges = "clearance",
    guides: Sequence[GuideRail | SmoothIdler] = (),
) -> ChainDrive:
    """Return a drive of a chain round sprockets: links counted, or a centre moved to fit them.

    Parameters
    ----------
    chain : str or Chain
        A name of the catalogue, such as "ANSI 40", or a chain, whose own `links` do not count.
    sprockets : sequence of Sprocket
        In the order in which the chain meets them, one way round or the other.
    links : int, optional
        Number of links, even; by default the smallest that closes round the centres as they are.
    adjust : int, optional
        Number of the sprocket whose centre moves until the chain is taut; by default none does, and
        what is left over hangs in one strand. Without `links`, their number is counted before.
    direction : (float, float), optional
        Direction along which that centre may move, either way; by default the one that tightens
        both strands beside it alike.
    reach : float, optional
        How far it may move [m]; by default as far as there is a belt line within 1000 pitches.
    tensioner, gravity, name, hinges, guides
        See `ChainDrive`.

    Raises
    ------
    InvalidInput
        No chain can be laid round the sprockets, or no place of the moved one suits the links.
    """
    sprockets = tuple(sprockets)
    known = _ANY_LINKS if links is None else links
    found = catalogue_chain(chain, known) if isinstance(chain, str) else replace(chain, links=known)
    drive = ChainDrive(found, sprockets, tensioner, gravity, name, hinges, guides)
    if links is None:
        drive = replace(drive, chain=replace(found, links=_rustchain.links_around(drive)))
    if adjust is None:
        if direction is not None or reach is not None:
            msg = f"direction = {direction}, reach = {reach}: there is no sprocket to adjust"
            raise InvalidInput(msg)
        return drive
    if not 1 <= adjust <= len(sprockets):
        msg = f"adjust = {adjust}: must be the number of a sprocket, 1 to {len(sprockets)}"
        raise InvalidInput(msg)
    x, y = _rustchain.bisector(drive, adjust) if direction is None else direction
    far = 1000.0 * found.pitch if reach is None else reach
    move = _rustchain.closing_move(drive, adjust, (x, y), far) / math.hypot(x, y)
    center = sprockets[adjust - 1].center
    moved = replace(sprockets[adjust - 1], center=(center[0] + move * x, center[1] + move * y))
    return replace(drive, sprockets=(*sprockets[: adjust - 1], moved, *sprockets[adjust:]))
