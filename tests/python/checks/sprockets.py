"""Chains on sprockets against closed formulae: tooth loads along the wrap, polygon action."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

import rustchain as rc
from checks.check import Check
from checks.strands import PITCH, QUIET, STRANDS, pitch_radius
from rustchain.analysis.transmission import order_spectrum


def chain(links, clearance, elongation=0.0):
    """An ANSI 40 chain of another clearance in its hinges."""
    found = rc.catalogue_chain("ANSI 40", links)
    bore = found.hinge.pin_radius + clearance
    return replace(found, elongation=elongation, hinge=replace(found.hinge, bore_radius=bore))


# Load along the wrap of a frictionless tight chain. A hinge between links of tensions T (towards
# the tight strand) and T', which turn by alpha = 2 pi / N, takes the tooth force P at the pressure
# angle phi to the link of T. Across P: T sin(phi) = T' sin(phi + alpha). On a straight flank at
# gamma to the gap's middle, phi = gamma - alpha / 2 for every tooth: a geometric series.


def wrap_series(teeth, flank):
    """Return the checks of the tooth loads of straight flanks at `flank` [deg], and the loads."""
    links = 2 * math.ceil((teeth + 40) / 2)
    drive = rc.two_sprocket_drive(
        # Elongated, so that every bushing climbs to the flank.
        chain=chain(links, 10e-6, elongation=0.004),
        teeth=(teeth, teeth),
        links=links,
        speed=1e-3,
        torque=-1.0,
        gravity=(0.0, 0.0),
        pretension=20.0,
        profile=rc.StraightTooth(math.radians(flank)),
    )
    result = rc.Simulation(drive, start="static").run(
        1e-5, report_step=1e-5, record=("hinges", "teeth", "sprockets"), **QUIET
    )
    load = result.wrap_loads(1, bins_per_pitch=1)
    place = load["position"].to_numpy()
    tooth = load["quantiles"].sel(quantile=0.5).to_numpy()[place > 0.5]
    alpha, gamma = 2.0 * math.pi / teeth, math.radians(flank)
    ratio = math.sin(gamma - 0.5 * alpha) / math.sin(gamma + 0.5 * alpha)
    test = f"{STRANDS}::test_load_along_the_wrap_is_a_geometric_series"
    name = f"tooth loads, {teeth} teeth, flanks at {flank}°: "
    # Radial play makes every other bushing spacing longer: the ratios alternate about the series'.
    # A longer chain turns by less than alpha at a link, and the last teeth pass the series on to
    # the slack strand: two steps from the second tooth are compared.
    over_two = math.sqrt(tooth[2] / tooth[0])
    return [
        Check(name + "ratio over two teeth, root", over_two, ratio, 0.03, test, relative=True),
        Check(name + "ratio of neighbours", tooth[1] / tooth[0], ratio, 0.08, test, relative=True),
    ], (tooth, ratio)


def upper_strand(teeth, distance, angles):
    """Length of a taut chain over two polygons from a far seat on one to a far seat on the other.

    ``angles``: of a seat of each sprocket near the top. The strand is the common tangent of the
    polygons that the hinges on both pitch circles form.
    """
    seats = np.arange(-6, 7)
    corners = []
    for count, angle, x in zip(teeth, angles, (0.0, distance), strict=True):
        around = angle + 2 * math.pi / count * seats
        corners.append(
            np.array([x, 0.0])
            + pitch_radius(count) * np.stack([np.cos(around), np.sin(around)], -1)
        )
    outward = np.array([0.0, 1.0])
    for _ in range(8):
        one, other = ((c @ outward).argmax() for c in corners)
        strand = corners[0][one] - corners[1][other]
        outward = np.array([strand[1], -strand[0]]) / np.hypot(*strand)
    return np.hypot(*strand) + PITCH * ((6 - seats[one]) + (seats[other] + 6))


def polygon_error(teeth, distance, driver, driven_at_start):
    """Angle of the driven sprocket less the ratio's, at each angle of the driver, by geometry."""
    length = upper_strand(teeth, distance, (driver[0], driven_at_start))
    ratio = teeth[0] / teeth[1]
    even = driven_at_start + ratio * (driver - driver[0])

    def lag(angle, at):
        return upper_strand(teeth, distance, (at, angle)) - length

    return np.array(
        [
            brentq(lag, guess - 0.05, guess + 0.05, args=(at,), xtol=1e-12) - guess
            for at, guess in zip(driver, even, strict=True)
        ]
    )


def seat_near_the_top(angle, teeth):
    step = 2 * math.pi / teeth
    return angle + step * round((0.5 * math.pi - angle) / step)


def polygon_action(teeth, pitches):
    """Return the checks of the transmission error of two polygons, and both errors.

    A slow drive with hardly any radial play, the upper strand of `pitches` pitches taut: the driven
    sprocket follows the tangent of two polygons. Contacts give by 1 um, 3e-5 rad.
    """
    difference = pitch_radius(teeth[1]) - pitch_radius(teeth[0])
    distance = math.hypot((pitches - 0.03) * PITCH, difference)  # 0.8 mm of slack below
    lean = math.asin(difference / distance)
    wraps = sum(n * (math.pi + s * 2 * lean) for n, s in zip(teeth, (-1, 1), strict=True))
    links = math.ceil(2 * pitches + wraps / (2 * math.pi) - 0.01)
    made = chain(links, 1e-6)
    profile = rc.StraightTooth(math.radians(26.0), seat_radius=1.0005 * made.bushing_radius)
    drive = rc.two_sprocket_drive(
        made,
        teeth,
        links=links,
        center_distance=distance,
        speed=3.0,
        gravity=(0.0, 0.0),
        profile=profile,
    )
    speed = 3.0 * teeth[0] / teeth[1]
    brake = rc.AppliedTorque(curve=((-3 * speed, 3.0), (3 * speed, -3.0)))
    driven = replace(drive.sprockets[1], motion=brake, inertia=1e-4)
    drive = replace(drive, sprockets=(drive.sprockets[0], driven))
    tooth = 2 * math.pi / teeth[0] / 3.0  # [s]
    result = rc.Simulation(drive).run(0.3 + 3 * tooth, record=("sprockets", "energy"), **QUIET)
    steady = result.between(0.3)
    angle = steady.array("sprocket_angle")
    start = [seat_near_the_top(angle[0, k], teeth[k]) for k in (0, 1)]
    driver = start[0] + angle[:, 0] - angle[0, 0]
    coarse = driver[::15]
    expected = polygon_error(teeth, distance, coarse, start[1])
    order, by_geometry = order_spectrum(driver - driver[0], np.interp(driver, coarse, expected))
    found = steady.transmission_error()
    at = int(np.abs(found["order"].to_numpy() - teeth[0]).argmin())
    assert abs(order[at] / teeth[0] - 1.0) < 0.02
    amplitude = float(found["amplitude"][at])
    # The speed pulses as the derivative of the error; at the driven sprocket's own tooth order.
    ripple = steady.speed_ripple(2)
    at_driven = int(np.abs(ripple["order"].to_numpy() - teeth[1]).argmin())
    test = f"{STRANDS}::test_polygons_make_the_transmission_error"
    name = f"polygon action, {teeth[0]}:{teeth[1]} teeth, span of {pitches:g} pitches: "
    checks = [
        Check(
            name + "transmission error at the tooth order",
            *(amplitude, by_geometry[at], 4e-5, test, "rad"),
        ),
        Check(
            name + "speed ripple of the driven sprocket",
            *(float(ripple["amplitude"][at_driven]), amplitude * teeth[1], 2.5e-3, test),
        ),
    ]
    error = (angle[:, 1] - angle[0, 1]) - teeth[0] / teeth[1] * (angle[:, 0] - angle[0, 0])
    return checks, (driver - driver[0], error, coarse - coarse[0], expected)
