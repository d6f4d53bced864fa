"""Contact pressure of pins, bushings and teeth by Hertz's line contact, and its cycles."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from rustchain import _rustchain
from rustchain.analysis import rainflow
from rustchain.analysis.circuit import Circuit, path_length
from rustchain.analysis.loads import checked_sprocket, forces_of, in_gaps, nearest_contact
from rustchain.analysis.phases import checked_bins
from rustchain.analysis.window import rows_between
from rustchain.errors import InvalidInput
from rustchain.typing import Array, Count, Number, Time

if TYPE_CHECKING:
    import xarray as xr

    from rustchain.description.chain import Chain
    from rustchain.description.drive import ChainDrive
    from rustchain.description.material import Material
    from rustchain.results.result import Result

Contact = Literal["hinge", "tooth"]
_SMALLEST = 0.01  # of the largest pressure: swings below that are not counted


def line_pressure(
    force: Array, curvature: Array | Number, length: Number, modulus: Array | Number
) -> Array:
    """Return the largest pressure of a line contact [Pa] (Johnson, Contact Mechanics, Eq. 4.45).

    `curvature` [1/m] is the sum of both surfaces', `modulus` [Pa] that of the contact.
    """
    pressure: Array = np.sqrt(np.maximum(force, 0.0) * modulus * curvature / (np.pi * length))
    return pressure


def half_width(
    force: Array, curvature: Array | Number, length: Number, modulus: Array | Number
) -> Array:
    """Return half the width of a line contact [m] (Johnson, Contact Mechanics, Eq. 4.43)."""
    width: Array = np.sqrt(4.0 * np.maximum(force, 0.0) / (np.pi * length * modulus * curvature))
    return width


def contact_pressure(
    result: Result, /, contact: Contact = "hinge", *, start: Time = None, end: Time = None
) -> xr.Dataset:
    """Return the largest pressure in each contact by Hertz's line contact.

    p = sqrt(F E* k / (pi L)), half width b = sqrt(4 F / (pi L E* k)) (Johnson, Contact Mechanics,
    4.2c). F is the force, L the length of contact, 1/E* = 2 (1 - nu^2)/E, and k the sum of the
    curvatures of the surfaces in contact. It holds while b is small beside the radii, whatever law
    gave the force.

    Parameters
    ----------
    contact : {"hinge", "tooth"}
        Pins in bushings, or bushings on teeth.

    Returns
    -------
    Dataset
        ``pressure`` [Pa] and ``half_width`` [m] at the reports, ``peak_pressure`` [Pa] of the
        largest force since the report before; (time, hinge) or (time, bushing).
    """
    from rustchain.extras import xarray as xr

    rows = rows_between(result, start, end)
    chain = result.drive.chain
    modulus: float | Array = contact_modulus(chain)
    curvature: float | Array = hinge_curvature(chain)
    if contact == "tooth":
        curvature, modulus = (array[rows] for array in tooth_contacts(result))
    length = chain.strands * (
        chain.hinge.length if contact == "hinge" else chain.tooth_contact_length
    )
    force, peak, _ = forces_of(result, contact, rows)
    part = "hinge" if contact == "hinge" else "bushing"
    pascal, meter = {"units": "Pa"}, {"units": "m"}
    return xr.Dataset(
        {
            "pressure": (("time", part), line_pressure(force, curvature, length, modulus), pascal),
            "peak_pressure": (
                ("time", part),
                line_pressure(np.maximum(peak, force), curvature, length, modulus),
                pascal,
            ),
            "half_width": (("time", part), half_width(force, curvature, length, modulus), meter),
        },
        {
            "time": ("time", result.time[rows], {"units": "s"}),
            part: np.arange(1, force.shape[1] + 1),
        },
        {"contact": contact, "contact_modulus": contact_modulus(chain), "length": length},
    )


def pressure_cycles(
    result: Result,
    /,
    contact: Contact = "hinge",
    sprocket: Count | None = None,
    *,
    bins: Count = 20,
    start: Time = None,
    end: Time = None,
) -> xr.Dataset:
    """Return how many cycles of contact pressure a part sees per revolution, by range.

    Rainflow counting (ASTM E1049-85) of the pressures at the reports and the peaks between
    them; swings below a hundredth of the largest are left out. A contact that opens and closes
    twice between two reports counts once.

    Parameters
    ----------
    contact : {"hinge", "tooth"}
        Pins in bushings, or bushings on teeth.
    sprocket : int, optional
        With "tooth": count in the gaps of this sprocket, per revolution of it; by default on
        the bushings, per revolution of the chain.
    bins : int
        Number of classes of the range, from 0 to the largest; 1 to 1000.

    Returns
    -------
    Dataset
        ``cycles`` per revolution, (hinge, bushing or tooth; range [Pa]), and ``largest`` [Pa].
    """
    from rustchain.extras import xarray as xr

    bins = checked_bins("pressure_cycles.bins", bins)
    rows = rows_between(result, start, end)
    found = contact_pressure(result, contact, start=start, end=end)
    now, most = found["pressure"].to_numpy(), found["peak_pressure"].to_numpy()
    if sprocket is None:
        part, labels = ("hinge" if contact == "hinge" else "bushing"), found.coords
        numbers = labels[part].to_numpy()
        turns = Circuit.of(result.drive).revolutions(result, rows)
    else:
        if contact != "tooth":
            msg = f"sprocket = {sprocket}: only teeth belong to one; leave it out for hinges"
            raise InvalidInput(msg)
        checked_sprocket(result, sprocket)
        now, most = in_gaps(result, sprocket, rows, (np.maximum, now), (np.maximum, most))
        part, numbers = "tooth", np.arange(now.shape[1])
        turns = path_length(result.array("sprocket_angle")[rows, sprocket - 1]) / (2 * np.pi)
    if turns == 0.0:
        msg = (
            "start, end: nothing turns in this part, so that there are no cycles per revolution; "
            "take a part in which the drive turns; of a drive at rest, Result.contact_pressure has "
            "the pressures"
        )
        raise InvalidInput(msg)
    # Each interval's peak comes before the value of the row that ends it; the first one's is over.
    history = np.stack([most, now], axis=1).reshape(-1, now.shape[1])[1:]
    largest = max(float(history.max()), np.finfo(float).tiny)
    edges = np.linspace(0.0, largest, bins + 1)
    cycles = np.zeros((now.shape[1], bins))
    for k, one in enumerate(history.T):
        ranges, counts = rainflow.count(one, _SMALLEST * largest)
        cycles[k] = np.histogram(ranges, edges, weights=counts)[0]
    return xr.Dataset(
        {
            "cycles": ((part, "range"), cycles / turns, {"units": "1"}),
            "largest": (part, history.max(0), {"units": "Pa"}),
        },
        {
            part: numbers,
            "range": ("range", 0.5 * (edges[1:] + edges[:-1]), {"units": "Pa"}),
        },
        {"contact": contact, "revolutions": turns},
    )


def contact_modulus(chain: Chain, other: Material | None = None) -> float:
    """Return the modulus of the contact of the chain with `other`, or with its own material [Pa].

    1/E* is the sum of (1 - nu^2)/E of both (Johnson, Contact Mechanics, Eq. 4.21).
    """
    pair = (chain.material, other or chain.material)
    return 1.0 / sum((1.0 - m.poisson_ratio**2) / m.elastic_modulus for m in pair)


def hinge_curvature(chain: Chain) -> float:
    """Return the curvature of the pin less that of its bore [1/m]."""
    return 1.0 / chain.hinge.pin_radius - 1.0 / chain.hinge.bore_radius


def surface_curvature(drive: ChainDrive, sprocket: Count) -> Array:
    """Return the curvature of a bushing and each surface of a tooth, from the seat outward [1/m].

    A hollow surface takes its own from the bushing's, a round one adds it.
    """
    radii = np.array(_rustchain.tooth_radii(drive.sprockets[sprocket - 1], drive.chain))
    curvature: Array = 1.0 / drive.chain.contact_radius - 1.0 / radii
    return curvature


def tooth_contacts(result: Result) -> tuple[Array, Array]:
    """Return curvature [1/m] and modulus [Pa] of contacts or last ones, (times, bushings).

    An edge, or a surface that whole teeth do not have, counts as the outermost surface; the round
    ends of a rail count as its face.
    """
    wheel, region = result.array("tooth_sprocket"), result.array("tooth_region")
    drive, chain = result.drive, result.drive.chain
    # Of a bushing that is never in contact at a report: on a seat, or on a flat face.
    never = surface_curvature(drive, 1)[0] if drive.sprockets else 1.0 / chain.contact_radius
    curvature = np.full(wheel.shape, never)
    modulus = np.full(wheel.shape, contact_modulus(chain))
    for k, guide in enumerate(drive.guides, len(drive.sprockets) + 1):
        face = 0.0 if guide.radius is None else 1.0 / guide.radius
        height = guide.plate_height
        own = 1.0 / chain.contact_radius if height is None else 2.0 / height
        curvature[wheel == k] = own + face
        modulus[wheel == k] = contact_modulus(chain, guide.material)
    for k in range(len(drive.sprockets)):
        of = surface_curvature(result.drive, k + 1)
        there = wheel == k + 1
        curvature[there] = of[np.minimum(np.abs(region[there] - len(of)), len(of) - 1)]
    nearest = nearest_contact(result)
    return np.take_along_axis(curvature, nearest, 0), np.take_along_axis(modulus, nearest, 0)
