"""A chain drive as the description of a mechanism: links, sprockets and tensioner as parts."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from rustchain import _rustchain
from rustchain.arguments import admitted
from rustchain.description.laws.force import ForceLaw, LankaraniNikravesh
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.mechanism.parts import SurfaceContact

if TYPE_CHECKING:
    from rustchain.description.drive import ChainDrive, Hinges


def drive_mechanism(
    drive: ChainDrive,
    hinges: Hinges,
    force_law: ForceLaw | None,
    min_impact_velocity: float,
) -> Mechanism:
    """Return the mechanism that `ChainDrive.to_mechanism` promises."""
    force_law = admitted("to_mechanism(force_law)", force_law, ForceLaw | None)
    drive = replace(drive, hinges=hinges)
    law = force_law or LankaraniNikravesh()
    dry = wet = replace(law, film=None)
    if (film := law.film) is not None:
        # A given length is that of one strand.
        length = None if film.length is None else drive.chain.strands * film.length
        wet = replace(law, film=replace(film, length=length))
    mechanism = Mechanism(drive.gravity, drive.name)
    for method, keywords in _rustchain.drive_mechanism(drive, law, min_impact_velocity):
        if (length := keywords.pop("length", None)) is not None:
            material = drive.chain.material
            # Teeth have no film.
            own = dry if "sprocket" in keywords else wet
            keywords["law"] = SurfaceContact(own, length, material, min_impact_velocity)
        if (number := keywords.get("sprocket")) is not None:
            keywords |= {"sprocket": drive.sprockets[number], "chain": drive.chain}
        getattr(mechanism, method)(**keywords)
    return mechanism
