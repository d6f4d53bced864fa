"""Drives of any number of sprockets, and open chains, from a handful of numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from rustchain import _rustchain
from rustchain.arguments import admitted, items_within, plain, shown
from rustchain.catalogue.standard import Rollers, Stretch, chain_of
from rustchain.description.chain import Chain
from rustchain.description.drive import ChainDrive, Hinges
from rustchain.description.ends import AnchoredEnd, FreeEnd, LoadedEnd
from rustchain.description.guides import GuideRail, SmoothIdler
from rustchain.description.sprocket import Sprocket
from rustchain.description.tensioner import Tensioner
from rustchain.errors import InvalidInput
from rustchain.names import known_keywords
from rustchain.typing import Point

_MOST_SPROCKETS = 1000  # far more than there are; what has more may have no end
_ANY_LINKS = 100  # of a chain whose links are still to be counted


@known_keywords
def chain_drive(
    chain: str | Chain,
    sprockets: Sequence[Sprocket],
    *,
    links: int | None = None,
    adjust: int | None = None,
    direction: Point | None = None,
    reach: float | None = None,
    tensioner: Tensioner | None = None,
    gravity: Point = (0.0, -9.81),
    name: str = "",
    hinges: Hinges = "clearance",
    guides: Sequence[GuideRail | SmoothIdler] = (),
    rollers: Rollers = "fixed",
    plates: Stretch = "rigid",
) -> ChainDrive:
    """Return a drive of a chain round sprockets: links counted, or a centre moved to fit them.

    Parameters
    ----------
    chain : str or Chain
        Name in the catalogue, such as "ANSI 40", or a chain. The `links` of a chain are not used.
    sprockets : sequence of Sprocket
        Sprockets in their order along the chain path, in either direction. Their teeth have the
        ANSI form for every chain, unless `profile=IsoTooth()` or another form is given.
    links : int, optional
        Number of links, even or odd (the last one is then an offset link). By default the smallest
        even number that closes round the centres.
    adjust : int, optional
        Number of the sprocket whose centre is moved until the chain is taut. By default no centre
        is moved, and one strand has the slack. Without `links`, the links are counted first.
    direction : (float, float), optional
        Direction in which that centre is moved, forward or back; by default the one that tightens
        both strands beside it equally.
    reach : float, optional
        Largest displacement of that centre [m]; by default as far as a belt line exists within 1000
        pitches.
    tensioner, gravity, name, hinges, guides
        See `ChainDrive`.
    rollers : {"fixed", "bodies"}
        For a chain given by its name; see `catalogue_chain`.
    plates : {"rigid", "elastic"}
        For a chain given by its name; see `catalogue_chain`.

    Raises
    ------
    InvalidInput
        No chain path round the sprockets exists, or no place of the moved one fits the links.

    Examples
    --------
    >>> sprockets = [rc.Sprocket(17, motion=rc.PrescribedSpeed(12.0)), rc.Sprocket(25, (0.4, 0.0))]
    >>> rc.chain_drive("ANSI 40", sprockets).chain.links  # counted
    86
    >>> fitted = rc.chain_drive("ANSI 40", sprockets, links=86, adjust=2)
    >>> round(fitted.sprockets[1].center[0], 4)  # [m]; moved until the chain is taut
    0.4124
    """
    listed = items_within("sprockets", sprockets, _MOST_SPROCKETS)
    if listed is None:
        msg = f"sprockets = {shown(sprockets)}: must be a sequence of Sprocket"
        raise InvalidInput(msg)
    sprockets = tuple(listed)
    direction = admitted("chain_drive(direction)", direction, tuple[float, float] | None)
    reach = admitted("chain_drive(reach)", reach, float | None)
    adjust = None if adjust is None else _number(adjust, len(sprockets))
    known = _ANY_LINKS if links is None else links
    if links is None and isinstance(chain, Chain) and chain.offset is not None:
        msg = (
            "links = None: even numbers of links are counted, and the offset link of the chain "
            "needs an odd one; give `links`, or a chain without Chain.offset"
        )
        raise InvalidInput(msg)
    chain = chain_of(chain, known, rollers, plates)
    # Elongations of each link are for the links that are counted below.
    drive = ChainDrive(
        replace(_alike(chain) if links is None else chain, links=known),
        sprockets,
        tensioner,
        gravity,
        name,
        hinges,
        guides,
    )
    if links is None:
        drive = replace(drive, chain=replace(chain, links=_rustchain.links_around(drive)))
    if adjust is None:
        if direction is not None or reach is not None:
            msg = f"direction = {direction}, reach = {reach}: there is no sprocket to adjust"
            raise InvalidInput(msg)
        return drive
    x, y = _rustchain.bisector(drive, adjust) if direction is None else direction
    far = 1000.0 * drive.chain.pitch if reach is None else reach
    move = _rustchain.closing_move(drive, adjust, (x, y), far) / math.hypot(x, y)
    center = sprockets[adjust - 1].center
    moved = replace(sprockets[adjust - 1], center=(center[0] + move * x, center[1] + move * y))
    return replace(drive, sprockets=(*sprockets[: adjust - 1], moved, *sprockets[adjust:]))


@known_keywords
def open_chain(
    chain: str | Chain,
    ends: Sequence[AnchoredEnd | LoadedEnd | FreeEnd],
    links: int,
    sprockets: Sequence[Sprocket] = (),
    *,
    gravity: Point = (0.0, -9.81),
    name: str = "",
    guides: Sequence[GuideRail | SmoothIdler] = (),
    rollers: Rollers = "fixed",
    plates: Stretch = "rigid",
    tensioner: Tensioner | None = None,
    hinges: Hinges = "clearance",
) -> ChainDrive:
    """Return an open chain that hangs between two ends, or runs from one to the other.

    Parameters
    ----------
    chain : str or Chain
        Name in the catalogue, such as "ANSI 40", or a chain. The `links` of a chain are not used.
    ends : (end, end)
        Ends before the first link and behind the last one: each an `AnchoredEnd`, a `LoadedEnd` or
        a `FreeEnd`.
    links : int
        Number of links, even or odd, at least four. Inner and outer links alternate, and the first
        is an inner one. For fewer links, describe bodies of a `Mechanism`.
    sprockets : sequence of Sprocket
        Sprockets in their order from the first end to the second; by default none.
    gravity, name, guides, tensioner, hinges
        See `ChainDrive`.
    rollers : {"fixed", "bodies"}
        For a chain given by its name; see `catalogue_chain`.
    plates : {"rigid", "elastic"}
        For a chain given by its name; see `catalogue_chain`.

    Examples
    --------
    >>> ends = rc.AnchoredEnd((0.0, 0.0)), rc.LoadedEnd(5.0)  # 5 kg hang on ten links
    >>> rc.open_chain("ANSI 40", ends, links=10).chain.links
    10
    """
    chain = replace(chain_of(chain, links, rollers, plates), links=links)
    return ChainDrive(chain, sprockets, tensioner, gravity, name, hinges, guides, ends)


def _number(adjust: object, sprockets: int) -> int:
    """Return the number of the sprocket to adjust, which must be one of so many."""
    adjust = plain(adjust)
    if isinstance(adjust, int) and not isinstance(adjust, bool) and 1 <= adjust <= sprockets:
        return adjust
    msg = f"adjust = {shown(adjust)}: must be the number of a sprocket, 1 to {sprockets}"
    raise InvalidInput(msg)


def _alike(chain: Chain) -> Chain:
    """Return the chain with the mean elongation of its links in each of them, carrying nothing."""
    chain = replace(chain, carried=())
    if isinstance(chain.elongation, tuple) and chain.elongation:
        mean = sum(chain.elongation) / len(chain.elongation)
        return replace(chain, elongation=mean)
    return chain
