"""Outputs of runs against closed formulae: wrap, polygon, moving strand, centrifugal tension."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import rustchain as rc
from rustchain.analysis.strands import natural_frequencies
from rustchain.analysis.transmission import order_spectrum

PITCH = rc.chain_sizes()["ANSI 40"].pitch


def chain(links, clearance, elongation=0.0):
    """An ANSI 40 chain of another clearance in its hinges."""
    found = rc.catalogue_chain("ANSI 40", links)
    bore = found.hinge.pin_radius + clearance
    return replace(found, elongation=elongation, hinge=replace(found.hinge, bore_radius=bore))


def pitch_radius(teeth):
    return PITCH / (2.0 * math.sin(math.pi / teeth))


# Load along the wrap of a frictionless tight chain. A hinge between links of tensions T (towards
# the tight strand) and T', which turn by alpha = 2 pi / N, takes the tooth force P at the pressure
# angle phi to the link of T. Across P: T sin(phi) = T' sin(phi + alpha). On a straight flank at
# gamma to the gap's middle, phi = gamma - alpha / 2 for every tooth: a geometric series.


@pytest.mark.parametrize(
    ("teeth", "flank"), [(13, 30), (17, 20), (17, 25), (17, 30), (25, 20), (25, 25), (40, 30)]
)
def test_load_along_the_wrap_is_a_geometric_series(teeth, flank):
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
        1e-5, report_step=1e-5, record=("hinges", "teeth", "sprockets", "energy"), progress=False
    )
    load = result.wrap_loads(1, bins_per_pitch=1)
    place = load["position"].to_numpy()
    tooth = load["quantiles"].sel(quantile=0.5).to_numpy()[place > 0.5]
    alpha, gamma = 2.0 * math.pi / teeth, math.radians(flank)
    ratio = math.sin(gamma - 0.5 * alpha) / math.sin(gamma + 0.5 * alpha)
    # Play makes every other bushing spacing longer: the ratios alternate about the series'. A
    # longer chain turns by less than alpha at a link, and the last teeth pass the series on to the
    # slack strand: two steps from the second tooth are looked at.
    over_two = math.sqrt(tooth[2] / tooth[0])
    assert over_two == pytest.approx(ratio, rel=0.03)
    assert tooth[1] / tooth[0] == pytest.approx(ratio, rel=0.08)


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


@pytest.mark.parametrize("teeth", [(13, 13), (17, 25), (25, 17)])
@pytest.mark.parametrize("pitches", [16.0, 16.5])
def test_polygons_make_the_transmission_error(teeth, pitches):
    """Whole and half pitches of span, a slow drive with hardly any play, the upper strand taut.

    The driven sprocket follows the tangent of two polygons. Amplitudes at the driver's tooth order:
    5e-5 to 2e-3 rad; contacts give by 1 um, 3e-5 rad.
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
    result = rc.Simulation(drive).run(
        0.3 + 3 * tooth, record=("sprockets", "energy"), progress=False
    )
    steady = result.between(0.3)
    angle = steady.array("sprocket_angle")
    start = [seat_near_the_top(angle[0, k], teeth[k]) for k in (0, 1)]
    driver = start[0] + angle[:, 0] - angle[0, 0]
    coarse = driver[::15]
    expected = polygon_error(teeth, distance, coarse, start[1])
    order, by_geometry = order_spectrum(driver - driver[0], np.interp(driver, coarse, expected))
    found = steady.transmission_error()
    at = int(np.abs(found["order"].to_numpy() - teeth[0]).argmin())
    assert order[at] == pytest.approx(teeth[0], rel=0.02)
    amplitude = float(found["amplitude"][at])
    assert amplitude == pytest.approx(by_geometry[at], abs=4e-5)
    if teeth == (13, 13) and pitches == 16.5:  # the textbook's worst case, far above the bound
        assert amplitude > 1.5e-3
    # The speed pulses as the error's derivative; at the driven sprocket's own tooth order.
    ripple = steady.speed_ripple(2)
    at = int(np.abs(ripple["order"].to_numpy() - teeth[1]).argmin())
    pulse = amplitude * teeth[0] / (teeth[0] / teeth[1])
    assert float(ripple["amplitude"][at]) == pytest.approx(pulse, abs=2.5e-3)


@pytest.mark.parametrize(
    ("pretension", "speed"), [(100.0, 0.4), (400.0, 0.4), (200.0, 6.0)], ids=str
)
def test_a_tight_moving_strand_sounds_its_natural_frequencies(pretension, speed):
    """A strand that is plucked: peaks of its spectrum at n (c^2 - v^2) / (2 L c), discrete links.

    At 6 m/s the motion lowers the frequencies by a tenth. Ends that roll off the sprockets, and
    lines 2.5 Hz wide, leave some per cent.
    """
    drive = rc.two_sprocket_drive(
        teeth=(17, 17),
        links=80,
        speed=speed / pitch_radius(17),
        gravity=(0.0, 0.0),
        pretension=pretension,
    )
    assert drive.tensioner is not None
    before = rc.Simulation(replace(drive, tensioner=replace(drive.tensioner, ramp_time=0.02)))
    before.step_to(0.05)
    positions, velocities = before.positions.copy(), before.velocities.copy()
    links, span = drive.chain.links, positions[-1, 0]
    x = positions[:links, 0] / span
    upper = (positions[:links, 1] > 0.8 * pitch_radius(17)) & (x > 0.0) & (x < 1.0)
    for mode, share in ((1, 0.3), (2, 0.21), (3, 0.15)):  # [m/s]
        phase = mode * math.pi * x[upper]
        velocities[:links, 1][upper] += share * np.sin(phase)
        velocities[:links, 2][upper] += share * mode * math.pi / span * np.cos(phase)
    plucked = replace(drive, tensioner=replace(drive.tensioner, ramp_time=0.0))
    simulation = rc.Simulation(plucked, positions=positions, velocities=velocities)
    result = simulation.run(
        0.4, report_step=4e-4, record=("hinges", "sprockets", "bodies", "energy"), progress=False
    )
    found = result.strand_spectrum("upper", stations=(1 / 6, 0.25, 0.5, 0.7))
    assert found.attrs["speed"] == pytest.approx(speed, rel=0.02)
    frequency = found["frequency"].to_numpy()
    density = found["density"].sum("station").to_numpy()
    ratios = []
    for natural in found["natural_frequency"].to_numpy():
        near = np.flatnonzero(np.abs(frequency / natural - 1.0) < 0.2)
        top = near[density[near].argmax()]
        left, here, right = np.log(density[top - 1 : top + 2])
        shift = 0.5 * (left - right) / (left - 2.0 * here + right)
        ratios.append((frequency[top] + shift * frequency[1]) / natural)
    np.testing.assert_allclose(ratios, 1.0, atol=0.06)
    assert np.median(ratios) == pytest.approx(1.0, abs=0.035)


@pytest.mark.parametrize("modes", [1, 4])
@pytest.mark.parametrize(("tension", "speed"), [(50.0, 0.0), (50.0, 5.0), (400.0, 12.0)])
def test_long_strands_have_the_frequencies_of_a_string(modes, tension, speed):
    """f_n = n / (2 L) (c^2 - v^2) / c, c^2 = T / mu; short ones are lower."""
    made = rc.catalogue_chain("ANSI 40", 100)
    density = 0.5 * (made.inner.mass + made.outer.mass) / made.pitch
    wave = math.sqrt(tension / density)
    for pitches, bound in ((2000.0, 1e-4), (200.0, 1e-2)):
        mode = np.arange(1, modes + 1)
        length = pitches * made.pitch
        string = mode / (2 * length) * (wave**2 - speed**2) / wave
        found = natural_frequencies(made, pitches, tension, speed, modes)
        np.testing.assert_allclose(found, string, rtol=bound)
    assert np.isnan(natural_frequencies(made, 20.0, tension, 1.01 * wave, 1)).all()
    assert np.isnan(natural_frequencies(made, 20.0, -1.0, 0.0, 1)).all()


def ring(shape, links):
    """Hinges a pitch apart on a closed curve, scaled to close, and tangents, (links, 2) each."""

    def walk(scale):
        angles, points = [0.0], [scale * shape(0.0)]
        for _ in range(links):
            here = points[-1]

            def beyond(t, here=here):
                return np.hypot(*(scale * shape(t) - here)) - PITCH

            far = angles[-1]
            while beyond(far) < 0.0:
                far += 0.005
            angles.append(brentq(beyond, angles[-1], far, xtol=1e-14))
            points.append(scale * shape(angles[-1]))
        return angles, points

    fine = np.array([shape(t) for t in np.linspace(0.0, 2 * math.pi, 4001)])
    guess = links * PITCH / np.hypot(*np.diff(fine, axis=0).T).sum()
    scale = brentq(lambda s: walk(s)[0][-1] - 2 * math.pi, 0.995 * guess, 1.02 * guess, xtol=1e-13)
    angles, points = walk(scale)
    tangents = np.array([shape(t + 1e-6) - shape(t - 1e-6) for t in angles[:-1]])
    return np.array(points[:-1]), tangents / np.hypot(*tangents.T)[:, None]


SHAPES = {
    "circle": lambda t: np.array([math.cos(t), math.sin(t)]),
    "ellipse": lambda t: np.array([3.0 * math.cos(t), math.sin(t)]),
    "waist": lambda t: (1.0 + 0.3 * math.cos(2 * t)) * np.array([1.4 * math.cos(t), math.sin(t)]),
    "egg": lambda t: np.array([1.5 * math.cos(t) + 0.25 * math.cos(2 * t), math.sin(t)]),
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("speed", [3.0, 12.0])
def test_centrifugal_tension_is_independent_of_shape(shape, speed):
    """A closed chain that runs along itself, far from any sprocket: T = mu v^2 at every hinge."""
    links = 120
    drive = rc.two_sprocket_drive(
        teeth=(11, 11), links=links, gravity=(0.0, 0.0), hinges="ideal", speed=0.0
    )
    hinges, tangents = ring(SHAPES[shape], links)
    hinges = hinges + [0.0, 3.0]
    along = np.roll(hinges, -1, axis=0) - hinges
    along /= np.hypot(*along.T)[:, None]
    # A rigid link has one speed along itself, which both its hinges share.
    behind = (tangents * along).sum(1)
    ahead = (np.roll(tangents, -1, axis=0) * along).sum(1)
    speeds = np.cumprod(np.concatenate([[1.0], (behind / ahead)[:-1]]))
    moving = tangents * (speed * speeds / speeds.mean())[:, None]

    positions, velocities = np.zeros((2, links + 2, 3))
    positions[:links, :2] = 0.5 * (hinges + np.roll(hinges, -1, axis=0))
    positions[:links, 2] = np.unwrap(np.arctan2(along[:, 1], along[:, 0]))
    positions[links:, :2] = [sprocket.center for sprocket in drive.sprockets]
    velocities[:links, :2] = 0.5 * (moving + np.roll(moving, -1, axis=0))
    change = np.roll(moving, -1, axis=0) - moving
    velocities[:links, 2] = (along[:, 0] * change[:, 1] - along[:, 1] * change[:, 0]) / PITCH
    result = rc.Simulation(drive, positions=positions, velocities=velocities).run(
        0.1 / speed, 0.002 / speed, record=("hinges", "sprockets", "bodies"), progress=False
    )
    density = 0.5 * (drive.chain.inner.mass + drive.chain.outer.mass) / PITCH
    share = result.link_tension() / (density * speed**2)
    # Eight pitches along itself; corners of the polygon and unequal links leave a per cent.
    assert float(share.mean()) == pytest.approx(1.0, abs=2e-3)
    np.testing.assert_allclose(share, 1.0, atol=0.015)
