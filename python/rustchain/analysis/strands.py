"""The free strands: tension, motion across the chain, spectrum and natural frequencies."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rustchain import _rustchain
from rustchain.analysis.circuit import Belt, Circuit, fronts_of, remainder
from rustchain.analysis.spectrum import welch
from rustchain.analysis.window import check_finite, rows_between
from rustchain.arguments import count_within, shown
from rustchain.errors import InvalidInput
from rustchain.typing import Array, Count, Number, Numbers, Time

if TYPE_CHECKING:
    import xarray as xr

    from rustchain.description.chain import Chain
    from rustchain.results.result import Result


_STATIONS = (0.25, 0.5, 0.75)


def link_tension(result: Result, /, *, start: Time = None, end: Time = None) -> xr.DataArray:
    """Return the tension of the chain at every hinge [N], (time, hinge).

    The component along the chain of the force between the two links of the hinge. It holds the
    part mu v^2 of the chain's own motion. Needs hinges and bodies recorded.
    """
    from rustchain.extras import xarray as xr

    rows = rows_between(result, start, end)
    if result.drive.ends is not None:
        msg = "ChainDrive.ends: tensions of an open chain are hinge forces; use hinge() and end()"
        raise InvalidInput(msg)
    links = result.drive.chain.links
    table = _rustchain.chain_links(result.drive.chain)
    centers = result.array("positions")[rows, :links, :2]
    along = np.roll(centers, -1, axis=1) - centers
    along /= np.hypot(along[..., 0], along[..., 1])[..., None]
    on_pin = result.array("hinge_force_vector")[rows]
    # The front of a link with bushings takes what its pin does not.
    on_front = np.where(table[:, 3:] > 0.0, -on_pin, on_pin)
    pull = (on_front * along).sum(-1)
    return xr.DataArray(
        pull,
        {"time": ("time", result.time[rows], {"units": "s"}), "hinge": np.arange(1, links + 1)},
        ("time", "hinge"),
        "link_tension",
        {"units": "N"},
    )


def strand_motion(
    result: Result,
    /,
    strand: str | Count,
    *,
    stations: Numbers = _STATIONS,
    start: Time = None,
    end: Time = None,
) -> xr.DataArray:
    """Return how far a strand is off its straight line [m], (time, station).

    Positive away from the inside of the loop. Needs hinges, sprockets and bodies recorded.

    Parameters
    ----------
    strand : str or int
        Its name in `strand_names`, or its number there, from 1.
    stations : sequence of float
        Positions fixed in space, as shares of the distance between the tangent points of the pitch
        circles. They count from the point where a counterclockwise chain leaves its sprocket.
    """
    from rustchain.extras import xarray as xr

    if not len(stations) or not all(0.0 < each < 1.0 for each in stations):
        msg = f"stations = {shown(stations)}: must be shares of the strand's length between 0 and 1"
        raise InvalidInput(msg)
    rows = rows_between(result, start, end)
    drive = result.drive
    name = strand_name(result, strand)
    circuit = Circuit.during(result, rows)
    section = circuit.section(f"strand {name}")
    belt = Belt.around(drive, result.array("sprocket_center")[rows])
    begin, finish = belt.strand(circuit.sections.index(section) // 2)
    way = finish - begin
    length = np.hypot(way[:, 0], way[:, 1])
    along = way / length[:, None]
    outward = np.stack([along[:, 1], -along[:, 0]], axis=1)  # the loop runs counterclockwise
    poses = result.array("positions")[rows, : drive.chain.links]
    hinges = fronts_of(drive.chain, poses) - begin[:, None]
    x = (hinges * along[:, None]).sum(-1) / length[:, None]
    y = (hinges * outward[:, None]).sum(-1)
    # Two pitches to either side hold the ends down; the strands beyond are others.
    middle = 0.5 * (section.begin + section.end)
    apart = remainder(circuit.positions(result)[rows] - middle, circuit.links)
    near = np.abs(apart) < 0.5 * (section.end - section.begin) + 2.0
    if not near.any(axis=1).all():
        msg = (
            f"strand_motion: no hinge is near strand {shown(name)} by the angles of the sprockets, "
            "which have turned against the chain; take a part of the time before that"
        )
        raise InvalidInput(msg)
    motion = np.empty((len(x), len(stations)))
    for row, here in enumerate(near):
        order = np.argsort(x[row, here])
        motion[row] = np.interp(stations, x[row, here][order], y[row, here][order])
    return xr.DataArray(
        motion,
        {
            "time": ("time", result.time[rows], {"units": "s"}),
            "station": ("station", list(stations), {"units": "1"}),
        },
        ("time", "station"),
        "strand_motion",
        {"units": "m", "strand": name, "length": float(length.mean())},
    )


def strand_spectrum(
    result: Result,
    /,
    strand: str | Count,
    *,
    stations: Numbers = _STATIONS,
    modes: Count = 3,
    segment: Number | None = None,
    start: Time = None,
    end: Time = None,
) -> xr.Dataset:
    """Return the spectrum of a strand's transverse motion, and its natural frequencies.

    Needs hinges, sprockets and bodies recorded.

    Parameters
    ----------
    strand, stations
        As in `strand_motion`.
    modes : int
        Number of natural frequencies, at most the number of hinges.
    segment : float, optional
        Length of Welch's segments [s], at least 16 rows; by default one segment, the finest
        resolution.

    Returns
    -------
    Dataset
        ``density`` [m^2/Hz], (station, frequency [Hz]): `scipy.signal.welch`, Hann's window.
        ``natural_frequency`` [Hz], (mode): of a string of rigid links between fixed ends, at
        the strand's mean tension and speed (`rustchain.analysis.strands.natural_frequencies`).
        ``attrs``: mean ``tension`` [N], mean ``speed`` of the chain [m/s], ``pitches``,
        ``tooth_frequency`` [Hz]: that of the engagements, pitches a second.
    """
    from rustchain.extras import xarray as xr

    modes = count_within("strand_spectrum.modes", modes, 1, result.drive.hinge_count)
    motion = strand_motion(result, strand, stations=stations, start=start, end=end)
    time = motion["time"].to_numpy()
    values = motion.to_numpy().T
    check_finite("strand_spectrum: positions", values)
    frequency, density = welch(time, values, segment)
    rows = rows_between(result, start, end)
    name = str(motion.attrs["strand"])
    tension = float(result.strand(name).tension[rows].mean())
    pitch = result.drive.chain.mean_pitch
    # A revolution moves the chain by as many pitches as there are teeth.
    turns = float(np.abs(result.array("sprocket_speed")[rows, 0]).mean()) / (2 * np.pi)
    engaged = result.drive.sprockets[0].teeth * turns
    speed = engaged * pitch
    pitches = motion.attrs["length"] / pitch
    mode = np.arange(1, modes + 1)
    natural = natural_frequencies(result.drive.chain, pitches, tension, speed, modes)
    return xr.Dataset(
        {
            "density": (("station", "frequency"), density, {"units": "m^2/Hz"}),
            "natural_frequency": ("mode", natural, {"units": "Hz"}),
        },
        {
            "station": motion["station"],
            "frequency": ("frequency", frequency, {"units": "Hz"}),
            "mode": mode,
        },
        {
            "strand": name,
            "tension": tension,
            "speed": speed,
            "pitches": pitches,
            "tooth_frequency": engaged,
        },
    )


def natural_frequencies(
    chain: Chain, pitches: Number, tension: Number, speed: Number, modes: Count
) -> Array:
    """Return the natural frequencies of a taut strand of a moving chain [Hz], (modes,).

    f_n = n / (2 L) (c^2 - v^2) / c, c^2 = T / mu, holds for a string between fixed ends that moves
    along itself (Swope and Ames 1963). T includes the centrifugal part mu v^2. The frequency n pi c
    / L of the string is replaced by omega, that of rigid links of mass m and inertia J on hinges a
    pitch p apart. Rollers that are bodies of their own, of mass r, are on the hinges. It follows
    from omega^2 = (T / p) 4 s^2 / (m (1 - s^2) + 4 J s^2 / p^2 + r), s = sin(n pi p / (2 L)). NaN
    where the tension is not positive, or the strand has no more links than modes.
    """
    table = _rustchain.chain_links(chain)
    mass, inertia = table[:, 1].mean(), table[:, 2].mean()
    roller = 0.0 if chain.roller is None else chain.strands * chain.roller.mass
    mode = np.arange(1, modes + 1)
    if tension <= 0.0:
        return np.full(modes, np.nan)
    sine = np.sin(0.5 * np.pi * mode / pitches)
    square = 4.0 * sine**2
    resting = np.sqrt(
        tension
        / chain.mean_pitch
        * square
        / (mass * (1.0 - sine**2) + inertia * square / chain.mean_pitch**2 + roller)
    )
    slowed = 1.0 - speed**2 * ((mass + roller) / chain.mean_pitch) / tension
    found: Array = np.where(
        (mode < pitches) & (slowed > 0.0), slowed * resting / (2 * np.pi), np.nan
    )
    return found


def strand_name(result: Result, strand: str | Count) -> str:
    """Return the name of a strand given by its name or number, or raise."""
    result.strand(strand)
    return strand if isinstance(strand, str) else result.strand_names[strand - 1]
