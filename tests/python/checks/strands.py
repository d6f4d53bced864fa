"""Strands and open chains against closed formulae: catenary, swing, moving string, T = mu v^2."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq, root

import rustchain as rc
from checks.check import Check

GRAVITY = 9.81
PITCH = rc.chain_sizes()["ANSI 40"].pitch
QUIET = {"progress": False}
J0_ZERO = 2.404825557695773  # first zero of Bessel's J0
STRANDS = "python/analysis/test_outputs_analytic.py"


def pitch_radius(teeth):
    return PITCH / (2.0 * math.sin(math.pi / teeth))


def link_masses(chain):
    """Mass of each link in order, [kg]."""
    return np.resize([chain.inner.mass, chain.outer.mass], chain.links)


# --- an open chain at rest: the polygon of rigid links under gravity


def polygon(ends, lengths, weights):
    """Joints (n + 1, 2) of a polygon of links under gravity, and its tensions (n, 2) [N].

    The tension of a link has the same horizontal part everywhere; its vertical part changes by the
    weights between the middles of neighbours. Both unknowns close the polygon.
    """
    span = np.subtract(*ends[::-1])
    above = np.cumsum(weights) - 0.5 * np.asarray(weights)

    def tensions(unknown):
        return np.stack([np.full(len(lengths), unknown[0]), unknown[1] + above], axis=1)

    def sides(unknown):
        pull = tensions(unknown)
        return pull / np.hypot(*pull.T)[:, None] * np.asarray(lengths)[:, None]

    total = float(np.sum(weights))
    solved = root(lambda u: sides(u).sum(0) - span, (0.5 * total, -0.5 * total), tol=1e-14)
    assert np.abs(solved.fun).max() < 1e-13
    return np.vstack([ends[0], ends[0] + np.cumsum(sides(solved.x), 0)]), tensions(solved.x)


def hanging(links=40, share=0.6, rise=0.0):
    """A chain at rest between two anchors: positions, exact ones, forces, exact ones."""
    along = np.array([1.0, rise]) / math.hypot(1.0, rise)
    ends = np.array([0.2, -0.1]) + np.outer([0.0, share * links * PITCH], along)
    drive = rc.open_chain("ANSI 40", [rc.AnchoredEnd(tuple(end)) for end in ends], links)
    simulation = rc.Simulation(drive, start="static")
    result = simulation.run(1e-9, 1e-9, record=("hinges", "bodies"), **QUIET)
    penetration = np.roll(result.array("hinge_penetration")[0], 1)[: links + 1]
    force = np.roll(result.array("hinge_force")[0], 1)[: links + 1]
    # The pins lie off the middles of their bushings by clearance and penetration: weightless links.
    offsets = drive.chain.hinge.bore_radius - drive.chain.hinge.pin_radius + penetration
    lengths, weights = np.empty(2 * links + 1), np.zeros(2 * links + 1)
    lengths[::2], lengths[1::2] = offsets, PITCH
    weights[1::2] = GRAVITY * link_masses(drive.chain)
    joints, tensions = polygon(ends, lengths, weights)
    middles = 0.5 * (joints[1:-1:2] + joints[2::2])
    return simulation.positions[:links, :2], middles, force, np.hypot(*tensions[::2].T)


def catenary():
    """Return the checks of a hanging chain at rest."""
    test = "layout/open_chains.rs::a_hanging_chain_rests_on_the_exact_catenary_of_its_rigid_links"
    checks = []
    for links, share, rise in ((12, 0.5, 0.0), (40, 0.6, 0.0), (40, 0.95, -0.2), (120, 0.7, 0.4)):
        found, exact, force, tension = hanging(links, share, rise)
        off, length = np.hypot(*(found - exact).T), links * PITCH
        low = int(exact[:, 1].argmin())
        name = f"hanging chain, {links} links, span {share:g} of the length"
        checks += [
            Check(
                f"{name}: height of the lowest link; largest distance",
                *(found[low, 1], exact[low, 1], 2e-7 * length, test, "m"),
                error=off.max(),
            ),
            Check(
                f"{name}: force on the first end; largest difference of any hinge",
                *(force[0], tension[0], 1e-6, test, "N", True),
                error=np.abs(force - tension).max() / tension[0],
            ),
        ]
    return checks


# --- a hanging chain in motion


def swing(links=41):
    """Return the checks of the lowest mode of a chain that hangs from its first link."""
    drive = rc.open_chain("ANSI 40", [rc.AnchoredEnd((0.0, 0.0)), rc.FreeEnd()], links)
    rest = rc.Simulation(drive, start="static")
    depth = rest.evaluate().hinge_penetration
    clearance = drive.chain.hinge.bore_radius - drive.chain.hinge.pin_radius
    radial = clearance + max(float(depth[: links + 1].mean()), 0.0)
    squared, shape, mass = lowest_mode(drive.chain, radial)
    omega = math.sqrt(squared)
    string = 0.5 * J0_ZERO * math.sqrt(GRAVITY / (links * (PITCH + radial)))
    positions = rest.positions.copy()
    x = shape * 2e-3 / shape[-1]  # 2 mm aside at its end
    positions[:links, 0] += 0.5 * (x[::2] + x[1::2])
    positions[:links, 2] += (x[1::2] - x[::2]) / PITCH
    solver = rc.Solver(method="newton", accuracy=1e-9)
    start = {"positions": positions, "velocities": rest.velocities}
    simulation = rc.Simulation(drive, solver=solver, **start)
    period = 2.0 * math.pi / omega
    result = simulation.run(0.8 * period, 1e-3, record=("bodies",), **QUIET)
    body = result.array("positions")[:, :links]
    turn = 0.5 * PITCH * np.sin(body[:, :, 2] + 0.5 * math.pi)
    ends = np.stack([body[:, :, 0] - turn, body[:, :, 0] + turn], axis=-1).reshape(len(body), -1)
    moved = ends @ mass @ shape
    before = np.flatnonzero(moved[:-1] * moved[1:] < 0.0)
    crossings = result.time[before] + 1e-3 * moved[before] / (moved[before] - moved[before + 1])
    test = "chain/open_motion.rs::a_hanging_chain_swings_at_the_zeros_of_bessels_function"
    name = "swinging chain of 41 links: "
    return [
        Check(
            name + "half a period, linear eigenvalue problem of the links",
            *(float(np.diff(crossings)[0]), 0.5 * period, 1e-3, test, "s", True),
        ),
        Check(
            name + "frequency of those links, continuous chain (J0)",
            *(omega / (2 * math.pi), string / (2 * math.pi), 0.01, test, "Hz", True),
        ),
    ], (result.time, moved / moved[0], omega)


def lowest_mode(chain, radial):
    """Squared angular frequency, shape and mass matrix over x of the rears and fronts of all links.

    Links are joined by weightless ones of the length `radial` [m], which a load has taken up.
    """
    masses = link_masses(chain)
    inertias = np.resize([chain.inner.inertia, chain.outer.inertia], chain.links) / PITCH**2
    n = len(masses)
    mass, stiffness = np.zeros((2, 2 * n, 2 * n))
    below = GRAVITY * np.append(np.cumsum(masses[::-1])[::-1], 0.0)
    for i in range(n):
        block = np.s_[2 * i : 2 * i + 2]
        m, j = 0.25 * masses[i], inertias[i]
        mass[block, block] = [[m + j, m - j], [m - j, m + j]]
        along = 0.5 * (below[i] + below[i + 1]) / PITCH
        stiffness[block, block] += along * np.array([[1, -1], [-1, 1]])
        joint = below[i] / radial
        stiffness[2 * i, 2 * i] += joint
        if i:
            stiffness[2 * i - 1, 2 * i - 1] += joint
            stiffness[2 * i - 1, 2 * i] -= joint
            stiffness[2 * i, 2 * i - 1] -= joint
    values, vectors = eigh(stiffness, mass, subset_by_index=[0, 0])
    return values[0], vectors[:, 0], mass


# --- a strand between sprockets


def plucked(pretension, speed):
    """Run of a drive of 17:17 teeth with its upper strand plucked, and its strand spectrum."""
    drive = rc.two_sprocket_drive(
        teeth=(17, 17),
        links=80,
        speed=2 * math.pi * speed / (17 * PITCH),
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
    released = replace(drive, tensioner=replace(drive.tensioner, ramp_time=0.0))
    simulation = rc.Simulation(released, positions=positions, velocities=velocities)
    result = simulation.run(
        0.4, report_step=4e-4, record=("hinges", "sprockets", "bodies", "energy"), **QUIET
    )
    return result.strand_spectrum("upper", stations=(1 / 6, 0.25, 0.5, 0.7))


def moving_strand(pretension, speed, found=None):
    """Return the checks of the first three natural frequencies of a tight moving strand.

    f_n = n (c^2 - v^2) / (2 L c) of discrete links. Ends that roll off the sprockets, and lines
    2.5 Hz wide, leave some per cent.
    """
    test = f"{STRANDS}::test_a_tight_moving_strand_sounds_its_natural_frequencies"
    found = plucked(pretension, speed) if found is None else found
    frequency, density = found["frequency"].to_numpy(), found["density"].sum("station").to_numpy()
    name = f"strand at {pretension:g} N, {speed:g} m/s: "
    checks = [Check(name + "chain speed", found.attrs["speed"], speed, 1e-6, test, "m/s", True)]
    tops = []
    for mode, natural in enumerate(found["natural_frequency"].to_numpy(), 1):
        near = np.flatnonzero(np.abs(frequency / natural - 1.0) < 0.2)
        top = near[density[near].argmax()]
        left, here, right = np.log(density[top - 1 : top + 2])
        tops.append(
            frequency[top] + 0.5 * (left - right) / (left - 2 * here + right) * frequency[1]
        )
        checks.append(Check(f"{name}frequency {mode}", tops[-1], natural, 0.06, test, "Hz", True))
    ratio = float(np.median(tops / found["natural_frequency"].to_numpy()))
    checks.append(Check(name + "median ratio to the formula", ratio, 1.0, 0.035, test))
    return checks


# --- a closed chain that runs along itself


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


def centrifugal(shape, speed):
    """Return the checks of T = mu v^2 at every hinge of a closed chain far from any sprocket."""
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
        0.1 / speed, 0.002 / speed, record=("hinges", "sprockets", "bodies"), **QUIET
    )
    expected = 0.5 * (drive.chain.inner.mass + drive.chain.outer.mass) / PITCH * speed**2
    tension = result.link_tension().to_numpy()
    test = f"{STRANDS}::test_centrifugal_tension_is_independent_of_shape"
    name = f"closed chain on a curve ({shape}), {speed:g} m/s: "
    # Eight pitches along itself; corners of the polygon and unequal links leave a per cent.
    farthest = tension.flat[np.abs(tension - expected).argmax()]
    return [
        Check(name + "mean tension", tension.mean(), expected, 2e-3, test, "N", True),
        Check(name + "tension farthest from it", farthest, expected, 0.015, test, "N", True),
    ]
