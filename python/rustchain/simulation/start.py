"""Where a simulation begins: positions and velocities given, laid or at rest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Literal, get_args

from rustchain import _rustchain
from rustchain.arguments import rows_of, shown
from rustchain.description.drive import ChainDrive
from rustchain.errors import InvalidInput

Start = Literal["generated", "static"]


def started(scene: Mapping[str, Any]) -> dict[str, Any]:
    """Return what the start of a scene makes of it: drive, positions, velocities, and its rest."""
    drive, start = scene["drive"], scene["start"]
    given = {name: scene[name] for name in ("positions", "velocities")}
    if not isinstance(start, str) or start not in get_args(Start):
        msg = f"start = {shown(start)}: must be 'generated' or 'static'"
        raise InvalidInput(msg)
    if not isinstance(drive, ChainDrive):  # which the core refuses
        return {"drive": drive, "rest": None} | dict.fromkeys(given)
    if start == "generated":
        rollers = 0 if drive.chain.roller is None else drive.hinge_count
        bodies = drive.hinge_count + rollers + len(drive.sprockets) + len(drive.guides)
        rows = {name: rows_of(name, value, bodies) for name, value in given.items()}
        if rows["positions"] is not None and rows["velocities"] is None:
            msg = (
                "velocities = None: must be given when positions are; those of the generated start "
                "belong to its own positions"
            )
            raise InvalidInput(msg)
        return {"drive": drive, "rest": None} | rows
    if any(value is not None for value in given.values()):
        msg = "start = 'static': there is no room for positions and velocities of one's own"
        raise InvalidInput(msg)
    if drive.hinges == "ideal":
        msg = "start = 'static': only for drives with clearance in their hinges"
        raise InvalidInput(msg)
    if drive.tensioner is not None:  # at full pull from the beginning
        drive = replace(drive, tensioner=replace(drive.tensioner, ramp_time=0.0))
    laws = (scene[name] for name in ("force_law", "hinge_law", "tooth_law", "min_impact_velocity"))
    found = _rustchain.static_start(drive, *laws)
    place = {name: found.pop(name) for name in ("positions", "velocities")}
    return {"drive": drive, "rest": found} | place
