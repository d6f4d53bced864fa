"""Safety of a chain against breaking, and pressure in its hinges, beside guide values."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from rustchain.analysis.pressure import contact_modulus, hinge_curvature, line_pressure
from rustchain.analysis.window import mean_over_time
from rustchain.catalogue.sizes import SIZES

if TYPE_CHECKING:
    from rustchain.results.result import Result

# Least breaking load over the pull: Diamond Chain's rule for slow drives, chains with press-fit
# connecting links, and chains with slip-fit ones or offset links.
USUAL_SAFETY, USUAL_SAFETY_OFFSET = 6.0, 9.0

# Guide values of the mean pressure in the hinges of roller chains [MPa], with 17 teeth on the small
# sprocket: its speed [rpm], then a value for each pitch. They are those of a textbook, Chernavskii
# and others, Course Design of Machine Elements; edition and page were not checked. No value of a
# standard or of a manufacturer was found. Another table of the same purpose, used in course
# designs, has 34.3 MPa at 50 rpm and 22.0 MPa at 1000 rpm for pitches of 12.7 and 15.875 mm.
_PITCHES = np.array([12.7, 15.875, 19.05, 25.4, 31.75, 38.1, 44.45, 50.8])  # [mm]
_ALLOWED = np.array(
    [
        (50.0, 46.0, 43.0, 39.0, 36.0, 34.0, 31.0, 29.0, 27.0),
        (100.0, 37.0, 34.0, 31.0, 29.0, 27.0, 25.0, 23.0, 22.0),
        (200.0, 29.0, 27.0, 25.0, 23.0, 22.0, 19.0, 18.0, 17.0),
        (300.0, 26.0, 24.0, 22.0, 20.0, 19.0, 17.0, 16.0, 15.0),
        (500.0, 22.0, 20.0, 18.0, 17.0, 16.0, 14.0, 13.0, 12.0),
        (750.0, 19.0, 17.0, 16.0, 15.0, 14.0, 13.0, np.nan, np.nan),
        (1000.0, 17.0, 16.0, 14.0, 13.0, 13.0, np.nan, np.nan, np.nan),
        (1250.0, 16.0, 15.0, 13.0, 12.0, np.nan, np.nan, np.nan, np.nan),
    ]
)
_MORE_TEETH = 0.01  # of the allowed pressure, for each tooth more than 17


@dataclass(frozen=True)
class Safety:
    """Safety of a chain: loads beside the breaking force, and the pressure in its hinges.

    Attributes
    ----------
    breaking_load : float, optional
        Smallest ultimate tensile strength of the chain, all strands [N]; None: not known.
    pull : float
        Largest mean tension of a strand [N].
    largest_pull : float
        Largest tension of a strand at a report [N].
    largest_force : float
        Largest force in a hinge, between reports too [N].
    pressure, largest_pressure : float
        `pull` and `largest_force` over the projected area of a pin in its bushing [Pa].
    allowed_pressure : float, optional
        Guide value of a textbook for the first, at this pitch and speed [Pa]; None: outside the
        table. It is no limit of a standard or a manufacturer.
    hertz_pressure : float
        Largest pressure by Hertz's line contact [Pa].
    usual_safety : float
        Smallest usual ratio of breaking load to tension.
    """

    breaking_load: float | None
    pull: float
    largest_pull: float
    largest_force: float
    pressure: float
    largest_pressure: float
    allowed_pressure: float | None
    hertz_pressure: float
    usual_safety: float


def safety_of(result: Result, breaking_load: float | None = None) -> Safety:
    """Return the safety of a chain drive's chain.

    Parameters
    ----------
    result : Result
        With hinges recorded; of a chain drive.
    breaking_load : float, optional
        Of all strands together [N]; by default the catalogue's, where it has one.

    Raises
    ------
    NotRecorded
        The hinges were not recorded.
    """
    chain = result.drive.chain
    tension = result.array("strand_tension")
    force = float(max(result.array("peak_hinge_force").max(), result.array("hinge_force").max()))
    pull = float(mean_over_time(result.time, tension).max())
    length = chain.strands * chain.hinge.length
    area = 2.0 * chain.hinge.pin_radius * length
    hertz = line_pressure(np.array(force), hinge_curvature(chain), length, contact_modulus(chain))
    if breaking_load is None and chain.name in SIZES:
        breaking_load = SIZES[chain.name].breaking_load(chain.strands)
    has_offset_link = result.drive.ends is None and chain.links % 2 == 1
    return Safety(
        breaking_load,
        pull,
        float(tension.max()),
        force,
        pull / area,
        force / area,
        _allowed(result),
        float(hertz),
        USUAL_SAFETY_OFFSET if has_offset_link else USUAL_SAFETY,
    )


def allowed_pressure(pitch: float, speed: float, teeth: int) -> float | None:
    """Return a textbook's guide value of the mean pressure in hinges of a roller chain [Pa].

    Parameters
    ----------
    pitch : float
        [m].
    speed : float
        Of the small sprocket [rad/s].
    teeth : int
        Of the small sprocket.
    """
    speeds, values = _ALLOWED[:, 0], _ALLOWED[:, 1:]
    at_pitch = np.array([np.interp(1e3 * pitch, _PITCHES, row) for row in values])
    turns = max(abs(speed) * 30.0 / pi, speeds[0])  # the table's first row holds for slower ones
    found = float(np.interp(turns, speeds, at_pitch, right=np.nan))
    inside = _PITCHES[0] <= round(1e3 * pitch, 6) <= _PITCHES[-1]
    factor = 1.0 + _MORE_TEETH * (teeth - 17)
    return 1e6 * factor * found if inside and np.isfinite(found) else None


def _allowed(result: Result) -> float | None:
    """Return the guide value at the mean unsigned speed of the sprocket with the fewest teeth."""
    if "sprocket_speed" not in result.arrays or not result.drive.sprockets:
        return None
    teeth = [sprocket.teeth for sprocket in result.drive.sprockets]
    small = int(np.argmin(teeth))
    speed = np.abs(result.array("sprocket_speed")[:, small])
    mean = float(mean_over_time(result.time, speed))
    return allowed_pressure(result.drive.chain.pitch, mean, teeth[small])
