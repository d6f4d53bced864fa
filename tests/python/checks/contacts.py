"""Single contacts against closed formulae: impacts, Hertz, elongation, the lubricant film."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.linalg import solve_banded
from scipy.optimize import brentq

import rustchain as rc
from checks.check import Check
from checks.strands import GRAVITY, QUIET, link_masses

HERE = "python/validation/test_checks.py"
RADII, LENGTH = (2.22e-3, 2.245e-3), 0.011  # of the published drive [m]
CLEARANCE = RADII[1] - RADII[0]

# --- impacts


def impact(law, mass=0.01, speed=0.5, restitution=0.71, rows=2000):
    """Return time [s], penetration [m] and rate [m/s] of a steel ball that hits a fixed one.

    Both have a radius of 10 mm, so that the relative radius is 5 mm.
    """
    gap = 1e-6
    mechanism = rc.Mechanism(gravity=(0.0, 0.0))
    mechanism.add_body("ball", mass, 1e-6, (0.02 + gap, 0.0, 0.0), (-speed, 0.0, 0.0))
    surfaces = rc.SurfaceContact(law, material=rc.Material(restitution=restitution))
    mechanism.add_disc_contact("contact", "ground", "ball", 0.01, 0.01, surfaces)
    solver = rc.Solver(rtol=1e-12, atol=1e-12)
    span = gap / speed + 2.0 * hertz_duration(mass, speed)
    result = rc.Simulation(mechanism, solver=solver).run(span, span / rows, **QUIET)
    body = result.body("ball")
    return result.time, 0.02 - body.position[:, 0], -body.velocity[:, 0]


def hertz_stiffness():
    """Return 4/3 E* sqrt(R) of two steel balls of 10 mm radius, [N/m^1.5]."""
    return 4.0 / 3.0 * 2.07e11 / (2.0 * (1.0 - 0.3**2)) * math.sqrt(0.005)


def hertz_depth(mass, speed):
    """Return the largest penetration [m]: m v^2 / 2 = (2/5) K d^2.5."""
    return (1.25 * mass * speed**2 / hertz_stiffness()) ** 0.4


def hertz_duration(mass, speed):
    """Return 2 d/v times the integral of 1/sqrt(1 - u^2.5) over 0..1, [s]."""
    integral = math.sqrt(math.pi) * math.gamma(1.4) / math.gamma(0.9)
    return 2.0 * hertz_depth(mass, speed) / speed * integral


def hertz_impact():
    """Return the checks of an elastic impact: duration and largest penetration."""
    test = f"{HERE}::test_an_elastic_impact_has_hertz_s_duration_and_penetration"
    checks = []
    for mass, speed in ((0.01, 0.5), (0.1, 0.05), (1.0, 3.0)):
        time, depth, _ = impact(rc.Hertz(), mass, speed)
        inside = np.flatnonzero(depth > 0.0)
        first, last = inside[0], inside[-1]
        cross = [np.interp(0.0, sorted(depth[k : k + 2]), (0.0, 1.0)) for k in (first - 1, last)]
        begin = time[first - 1] + cross[0] * (time[1] - time[0])
        end = time[last] + (1.0 - cross[1]) * (time[1] - time[0])
        top = depth.argmax()
        left, here, right = depth[top - 1 : top + 2]
        largest = here + (left - right) ** 2 / (8.0 * (2.0 * here - left - right))
        name = f"elastic impact, {mass:g} kg at {speed:g} m/s: "
        # Rows are interpolated, 1000 of them in the impact; measured: at most 1.1e-11.
        checks += [
            Check(
                name + "duration",
                *(1e6 * (end - begin), 1e6 * hertz_duration(mass, speed), 1e-9, test, "µs", True),
            ),
            Check(
                name + "largest penetration",
                *(1e6 * largest, 1e6 * hertz_depth(mass, speed), 1e-9, test, "µm", True),
            ),
        ]
    return checks


def restitutions(damping):
    """Return the checks of the restitution of one damping law at 0.3, 0.71 and 0.9."""
    test = f"{HERE}::test_an_impact_returns_the_effective_restitution"
    checks = []
    for given in (0.3, 0.71, 0.9):
        _, _, rate = impact(rc.Hertz(damping=damping), restitution=given, rows=4)
        expected = rebound(damping, given)
        name = f"{damping}, restitution {given:g}: ratio of velocities"
        checks.append(Check(name, -rate[-1] / rate[0], expected, 1e-8, test))  # measured: 2e-9
    return checks


# Damping factor lambda of each law, from its restitution c and nothing else of the impact.
FACTORS = {
    "hunt-crossley": lambda c: 1.5 * (1 - c),
    "lankarani-nikravesh": lambda c: 0.75 * (1 - c**2),
    "herbert-mcwhannell": lambda c: 6 * (1 - c) / ((2 * c - 1) ** 2 + 3),
    "lee-wang": lambda c: 0.75 * (1 - c),
    "flores": lambda c: 1.6 * (1 - c) / c,
    "gonthier": lambda c: (1 - c**2) / c,
    "hu-guo": lambda c: 1.5 * (1 - c) / c,
    "zhiying-qishao": lambda c: 0.75 * (1 - c**2) * math.exp(2 * (1 - c)),
}


def rebound(damping, given):
    """Return e of lambda (1 + e) = ln[(1 + lambda)/(1 - lambda e)], at any stiffness and speed."""
    factor = FACTORS[damping](given)
    return brentq(
        lambda e: factor * (1 + e) - math.log((1 + factor) / (1 - factor * e)),
        *(1e-9, min(1.0, 1.0 / factor) - 1e-12),
    )


# --- elastic links


def elongation():
    """Return the checks of a loaded hanging chain: F n / k longer than with rigid links."""
    test = f"{HERE}::test_a_loaded_chain_is_longer_by_the_elongation_of_its_links"
    checks = []
    for links, stiffness, load in ((4, 1e7, 20.0), (41, 5e7, 1000.0)):
        chain = rc.catalogue_chain("ANSI 40", links)
        ends = [rc.AnchoredEnd((0.0, 0.0)), rc.LoadedEnd(load, 1e-4 * load)]
        low = []
        for given in (stiffness, None):
            drive = rc.open_chain(replace(chain, link_stiffness=given), ends, links)
            law = rc.Linear(stiffness=2e8)
            low.append(-rc.Simulation(drive, force_law=law, start="static").positions[links, 1])
        masses = np.append(link_masses(chain), load)
        tension = GRAVITY * np.cumsum(masses[::-1])[::-1]
        expected = 0.5 * (tension[:-1] + tension[1:]).sum() / stiffness
        name = f"chain of {links} links of {stiffness:g} N/m under {load:g} kg: elongation"
        mm = (1e3 * (low[0] - low[1]), 1e3 * expected)
        checks.append(Check(name, *mm, 1e-5, test, "mm", True))
    return checks


# --- the lubricant film


def reynolds(viscosity: float, ratio: float, velocity: np.ndarray, cells: int) -> np.ndarray:
    """Return force along the eccentricity and left of it, from Reynolds' equation by cells.

    Flow over the walls between cells balances what the pin displaces of each; the periodic solution
    is known but for a constant, which makes it zero at two opposite places; what is then negative
    is cut off (Guembel).
    """
    step = 2.0 * np.pi / cells
    middle = (np.arange(cells) + 0.5) * step
    wall = np.arange(1, cells) * step
    thickness = CLEARANCE * (1.0 - ratio * np.cos(wall))
    flow = thickness**3 / (12.0 * viscosity * RADII[0] ** 2 * step)
    sinks = -(velocity[0] * np.cos(middle) + velocity[1] * np.sin(middle)) * step
    # Pressure zero in the first cell; the wall between the last cell and the first closes the ring.
    closing = (CLEARANCE * (1.0 - ratio)) ** 3 / (12.0 * viscosity * RADII[0] ** 2 * step)
    banded = np.zeros((3, cells - 1))
    banded[0, 1:] = banded[2, :-1] = flow[1:]
    banded[1] = -flow - np.append(flow[1:], closing)
    pressure = np.append(0.0, solve_banded((1, 1), banded, sinks[1:]))
    # Where it is as high as on the other side: there the half that counts begins.
    across = pressure - np.roll(pressure, cells // 2)
    following = np.roll(across, -1)
    k = int(np.argmax((across < 0.0) & (following >= 0.0)))
    part = -across[k] / (following[k] - across[k])
    level = pressure[k] + part * (np.roll(pressure, -1)[k] - pressure[k])
    film = np.clip(pressure - level, 0.0, None)
    normal = np.stack([np.cos(middle), np.sin(middle)])
    return -(normal @ film) * step * RADII[0] * LENGTH


def film():
    """Return the checks of the force of a long film, largest error over 24 directions."""
    test = "python/validation/test_film.py::test_force_is_that_of_reynolds_equation"
    return [
        film_at(ratio, viscosity, test) for ratio in (0.05, 0.4, 0.8, 0.9) for viscosity in (0.01,)
    ]


def film_at(ratio, viscosity, test=""):
    """Return the check of one eccentricity ratio, of the velocity along it and 24 others."""
    made = rc.LubricantFilm(viscosity, tension=0.0)
    worst, size = 0.0, np.hypot(*made.force(ratio * CLEARANCE, (2e-3, 0.0), RADII, LENGTH))
    shown = (0.0, 0.0)
    for angle in np.linspace(0.0, 2.0 * np.pi, 25):  # squeeze at 0, suction at pi, wedges between
        velocity = 2e-3 * np.array([np.cos(angle), np.sin(angle)])
        found = made.force(ratio * CLEARANCE, velocity, RADII, LENGTH)
        coarse, fine = (reynolds(viscosity, ratio, velocity, cells) for cells in (2000, 4000))
        expected = fine + (fine - coarse) / 3.0  # the cells' error is of order two
        worst = max(worst, float(np.hypot(*(found - expected)) / size))
        shown = shown if angle else (float(np.hypot(*found)), float(np.hypot(*expected)))
    name = (
        f"film at eccentricity ratio {ratio:g}, {viscosity:g} Pa s: force; worst of 25 directions"
    )
    return Check(name, *shown, 2e-6, test, "N", True, worst)  # measured: at most 2.2e-7
