"""Key figures of a run in one table."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np

from rustchain.analysis.engagement import impacts
from rustchain.analysis.jumps import jumps_within
from rustchain.analysis.power import mean_powers
from rustchain.analysis.transmission import angle_error, has_ripple, ripple_of
from rustchain.analysis.window import (
    difference_or_zero,
    from_first_row,
    mean_over_time,
    rows_between,
)
from rustchain.description.ends import bushings_of, hinges_of
from rustchain.description.sprocket import Free, PrescribedSpeed
from rustchain.html import HtmlView
from rustchain.typing import Time

if TYPE_CHECKING:
    from rustchain.results.result import Result


class Summary(dict[str, float], HtmlView):
    """Key figures by name; prints as a table with units.

    Attributes
    ----------
    units : dict of str
        Unit of each figure.
    """

    @property
    def units(self) -> dict[str, str]:
        """Unit of each figure; "1" of a ratio or a count."""
        return {name: _unit(name) for name in self}

    def rows(self) -> list[tuple[str, str, str]]:
        """Return name, value and unit of each figure, as text."""
        units = self.units
        return [
            (name, f"{value:.6g}", "" if units[name] == "1" else units[name])
            for name, value in self.items()
        ]

    def __repr__(self) -> str:
        """Return a line for each figure."""
        if not self:
            return "nothing was recorded to sum up"
        width = max(map(len, self))
        lines = (f"{name:<{width}}  {value:>12} {unit}" for name, value, unit in self.rows())
        return "\n".join(map(str.rstrip, lines))


# Of the figures whose names begin so; all others are ratios or counts.
_UNITS = {
    "tension_": "N",
    "hinge_force_": "N",
    "tooth_force_": "N",
    "joint_force_": "N",
    "contact_force_": "N",
    "engagement_force_": "N",
    "transmission_error_": "m",
    "loss": "W",
}


def _unit(name: str) -> str:
    return next((unit for head, unit in _UNITS.items() if name.startswith(head)), "1")


def summary(result: Result, /, *, start: Time = None, end: Time = None) -> Summary:
    """Return key figures of the run by name: the default measures of a study.

    A dict that prints as a table with units; ``.units`` has these.

    Efficiency and transmission errors are left out where the chain jumped teeth. Efficiency is left
    out where no power is delivered, ripple where the sprocket is at rest or turns back and forth.
    """
    rows = rows_between(result, start, end)
    jumps = jumps_within(result, start, end)
    skipped = set() if jumps is None else set(jumps[1].tolist())
    found: dict[str, float] = {}
    if "hinges" in result.groups:
        time, tensions = result.time[rows], result.array("strand_tension")[rows]
        means = mean_over_time(time, tensions)
        for name, tension, mean in zip(result.strand_names, tensions.T, means, strict=True):
            around = difference_or_zero(tension - mean, tension)
            found[f"tension_{name}"] = float(mean)
            found[f"tension_{name}_std"] = float(np.sqrt(mean_over_time(time, around**2)))
        if result.drive.hinges == "clearance":
            depth = result.array("hinge_penetration")[rows][:, hinges_of(result.drive)]
            found["hinge_contact_share"] = float((depth > 0.0).mean())
    parts = {"hinges": "hinge", "teeth": "tooth", "joints": "joint", "contacts": "contact"}
    there = {"hinges": hinges_of, "teeth": bushings_of}
    for group, part in parts.items():
        if group in result.groups and result.array(f"peak_{part}_force").size:
            names = {f"{part}_force", f"peak_{part}_force"} & set(result.arrays)
            arrays = from_first_row({name: result.array(name)[rows] for name in names}, rows)
            peak = arrays[f"peak_{part}_force"]
            if group in there:
                peak = peak[:, there[group](result.drive)]
            found[f"{part}_force_p99"] = float(np.quantile(peak, 0.99))
            found[f"{part}_force_largest"] = float(peak.max())
    if "teeth" in result.groups and jumps is not None:
        found["tooth_jumps"] = float(len(jumps[0]))
    # Engagements need the path of a closed chain.
    if {"sprockets", "teeth"} <= set(result.groups) and not result.drive.ends:
        force = [impact.force for impact in impacts(result, None, 0.5, start, end)]
        if force:
            found["engagement_force_mean"] = float(np.mean(force))
            found["engagement_force_p95"] = float(np.quantile(force, 0.95))
    if "sprockets" in result.groups:
        found |= _transmission(result, start, end, skipped)
    if {"sprockets", "energy"} <= set(result.groups) and rows.stop - rows.start > 1:
        power = mean_powers(result, start, end)
        found["loss"] = float(sum(power.losses.values()))
        motions = [sprocket.motion for sprocket in result.drive.sprockets]
        loaded = result.array("sprocket_torque")[rows, 1 : len(motions)].any()  # as by set_torque
        driven = loaded or not all(isinstance(motion, Free) for motion in motions[1:])
        if driven and not skipped and np.isfinite(power.efficiency):
            found["efficiency"] = power.efficiency
    return Summary(found)


def _transmission(
    result: Result, start: Time, end: Time, skipped: Collection[int]
) -> dict[str, float]:
    """Return transmission error of each sprocket but the first, and ripple of each.

    A first sprocket of prescribed speed has none.
    `skipped`: sprockets whose teeth the chain jumped, which have no transmission error.
    """
    found: dict[str, float] = {}
    rows = rows_between(result, start, end)
    angle = result.array("sprocket_angle")[rows]
    if len(angle) < 8 or not angle.shape[1] or not np.ptp(angle[:, 0]) > 0.0:
        return found
    for number, sprocket in enumerate(result.drive.sprockets, 1):
        if number > 1 and not {1, number} & set(skipped):
            _, error, radius = angle_error(result, number, 1, rows)
            found[f"transmission_error_{number}"] = float(radius * np.ptp(error))
        moved = number > 1 or not isinstance(sprocket.motion, PrescribedSpeed)
        if moved and has_ripple(result, number, rows):
            found[f"ripple_{number}"] = ripple_of(result, number, rows)[2]
    return found
