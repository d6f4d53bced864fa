"""Sizes that become an allocation or a number of turns of a loop are refused beyond their bound."""

from __future__ import annotations

import itertools
import re
from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc
from rustchain import _rustchain

DRIVE = rc.paper_drive()
CHAIN = DRIVE.chain
FAR_IDLER = rc.SmoothIdler(0.01, (0.0, -5.0))


def two(distance, **keywords):
    return rc.two_sprocket_drive("ANSI 40", (17, 17), center_distance=distance, **keywords)


def three(distance):
    places = [(0.0, 0.0), (distance, 0.0), (0.0, 0.3)]
    return rc.chain_drive("ANSI 40", [rc.Sprocket(17, place) for place in places])


def open_chain(links):
    ends = (rc.AnchoredEnd((0.0, 0.0), links=links), rc.AnchoredEnd((0.4, 0.0), links=links))
    return rc.open_chain("ANSI 40", ends, 60, [rc.Sprocket(17, (0.2, -0.1))])


def integrate(times, values):
    times, values = np.linspace(0.0, 1.0, times), np.zeros(values)
    return _rustchain.integrate(lambda t, y: -y, (0.0, 1.0), values, 1e-3, 1e-3, 1.0, 5, times)


def long_rows():
    return rc.sweep(DRIVE, {"speed": [1.0]}, duration=100.0, report_step=1.1e-7)


# What asks for too much, and where the refusal says it is and what is allowed.
CALLS = {
    "links": (
        lambda: replace(CHAIN, links=100_001),
        "links = 100001: must be between 4 and 100000",
    ),
    **{
        f"center at {distance:g} m": (
            lambda distance=distance: two(distance, links=60),
            "ChainDrive.sprockets.2.center",
        )
        for distance in (1e6, 1e308)
    },
    "links counted from centers": (lambda: two(1e308), "center_distance = 1e308: must be between"),
    "three centers": (lambda: three(1e6), "must lie within 1270 m of (0.0, 0.0), 100000 pitches"),
    "place of a guide": (
        lambda: replace(DRIVE, guides=[replace(FAR_IDLER, center=(0.0, -5e9))]),
        "ChainDrive.guides.1.center",
    ),
    "length of a guide": (
        lambda: replace(
            DRIVE, guides=[rc.GuideRail((0.0, -5.0), (0.0, 1.0), 1e9, end_radius=0.01)]
        ),
        "ChainDrive.guides.1, its largest extent",
    ),
    "guides": (
        lambda: replace(DRIVE, guides=[FAR_IDLER] * 300_000),
        "hinges times sprockets and guides",
    ),
    "links of ends": (lambda: open_chain(2**31), "must be at most the chain's, 60"),
    "reach": (
        lambda: rc.chain_drive("ANSI 40", DRIVE.sprockets, links=40, adjust=2, reach=1e300),
        "reach = 1e300: must be between 0 and 1270",
    ),
    "points": (
        lambda: DRIVE.sprockets[0].outline(CHAIN, points=1001),
        "points = 1001: must be between 2 and 1000",
    ),
    "integrated values": (lambda: integrate(10**5, 10**5), "t_eval times y0 = 10000000000"),
    "rows of a sweep": (long_rows, "report_step = 1.1e-07: gives"),
    "runs": (
        lambda: rc.study(DRIVE, runs=10**12, duration=1e-3),
        "runs = 1000000000000: must be a whole number from 2 to 100000",
    ),
    "an axis": (
        lambda: rc.sweep(DRIVE, {"speed": itertools.count()}, duration=1e-3),
        "axes['speed']: got more than 100000 values",
    ),
    "cases": (
        lambda: rc.sweep(DRIVE, itertools.repeat({"speed": 1.0}), duration=1e-3),
        "axes: got more than 100000 values",
    ),
    "product of axes": (
        lambda: rc.sweep(DRIVE, {"speed": range(10**4), "pretension": range(10**4)}, duration=1e-3),
        "cases of the sweep = 100000000: must be a whole number from 1 to 100000",
    ),
}


@pytest.mark.parametrize("what", CALLS)
def test_what_asks_for_too_much_is_refused_with_its_bound(what):
    call, message = CALLS[what]
    with pytest.raises(rc.InvalidInput, match=re.escape(message)):
        call()


@pytest.fixture(scope="module")
def result():
    record = ("hinges", "teeth", "sprockets", "bodies", "energy")
    return rc.Simulation(DRIVE).run(1e-3, record=record)


OUTPUTS = {
    "hinge_loads.bins_per_pitch": (lambda r, n: r.hinge_loads(bins_per_pitch=n), 1000),
    "tooth_loads.bins_per_pitch": (lambda r, n: r.tooth_loads(bins_per_pitch=n), 1000),
    "wrap_loads.bins_per_pitch": (lambda r, n: r.wrap_loads(bins_per_pitch=n), 1000),
    "pressure_cycles.bins": (lambda r, n: r.pressure_cycles("hinge", bins=n), 1000),
    "strand_spectrum.modes": (lambda r, n: r.strand_spectrum("upper", modes=n), 38),
}


@pytest.mark.parametrize("where", OUTPUTS)
def test_an_output_of_too_many_parts_is_refused_with_its_bound(result, where):
    output, most = OUTPUTS[where]
    call, argument = where.split(".")
    bound = {
        n: f"{where} = {n}: must be a whole number from 1 to {most}" for n in (0, most + 1, 10**9)
    }
    kind = {n: f"{call}({argument}): got {n}; expected a whole number" for n in (1e9, True)}
    for count, message in (*bound.items(), *kind.items()):
        with pytest.raises(rc.InvalidInput, match=re.escape(message)):
            output(result, count)
