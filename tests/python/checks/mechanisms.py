"""Standard problems of mechanisms: pendula, slider-crank, Andrews' squeezing mechanism, parts."""

from __future__ import annotations

import math

import numpy as np

import rustchain as rc
from checks.andrews import andrews
from checks.check import Check, Range
from checks.strands import GRAVITY, QUIET

CRANK, ROD, SLIDER = 0.05, 0.12, 0.14  # [m], [m], [kg]
RUST = "multibody/mechanism.rs"
CLEARANCE = "multibody/clearance.rs"
JOINTS = "multibody/joints.rs"


def solver(tolerance, max_step=0.05):
    return rc.Solver(rtol=tolerance, atol=tolerance, max_step=max_step)


def bar(mechanism, name, start, end, mass=1.0, velocity=(0.0, 0.0, 0.0)):
    """Add a uniform bar from `start` to `end` [m]."""
    start, end = np.array(start), np.array(end)
    way = end - start
    inertia = mass * float(way @ way) / 12.0
    place = (*(0.5 * (start + end)), math.atan2(way[1], way[0]))
    mechanism.add_body(name, mass, inertia, place, velocity)


def bars(count, angle):
    """A chain of uniform bars of 1 m and 1 kg from the origin, at `angle` [rad]."""
    mechanism = rc.Mechanism()
    step = np.array([math.cos(angle), math.sin(angle)])
    for k in range(count):
        bar(mechanism, f"bar {k}", k * step, (k + 1) * step)
        before = "ground" if k == 0 else f"bar {k - 1}"
        mechanism.add_revolute(f"hinge {k}", before, f"bar {k}", at=tuple(k * step))
    return mechanism


def pendula():
    """Return the checks of the period of a bar from level, and of two bars' energy."""
    # A bar of 1 m swings as a point at 2/3 m; from level, its amplitude is 90 degrees.
    a, g = 1.0, math.cos(0.25 * math.pi)
    for _ in range(10):
        a, g = 0.5 * (a + g), math.sqrt(a * g)
    period = 2.0 * math.pi * math.sqrt(2.0 / 3.0 / GRAVITY) / a
    checks = []
    for tolerance, bound in ((1e-7, 3e-6), (1e-10, 5e-9)):
        simulation = rc.Simulation(bars(1, 0.0), solver=solver(tolerance))
        simulation.step_to(period)
        x, y, angle = simulation.positions[0]
        checks.append(
            Check(
                f"pendulum from level, one period, tolerance {tolerance:g}: place; largest error",
                *(x, 0.5, bound, f"{RUST}::a_pendulum_comes_back_after_its_period", "m"),
                error=max(abs(x - 0.5), abs(y), abs(angle)),
            )
        )
    test = f"{RUST}::a_double_pendulum_keeps_its_energy_as_the_tolerance_asks"
    for tolerance, bound in ((1e-7, 3e-4), (1e-9, 3e-6), (1e-11, 5e-8)):
        simulation = rc.Simulation(bars(2, 0.3), solver=solver(tolerance))
        energy = simulation.run(5.0, 0.05, **QUIET).energy
        worst = float(np.abs(energy.residual).max())
        name = f"double pendulum, 5 s, tolerance {tolerance:g}: largest energy residual"
        checks.append(Check(name, worst, 0.0, bound, test, "J"))
    return checks


# --- slider-crank


def slider_crank(speed, clearance=None, offset=0.0):
    """A crank at `speed` [rad/s]; with `clearance` [m], a pin in a bore for the wrist joint."""
    m = rc.Mechanism(gravity=(0.0, 0.0))
    pin, slider = (CRANK, 0.0), (CRANK + ROD, 0.0)
    bar(m, "crank", (0.0, 0.0), pin, 0.3, (0.0, 0.5 * CRANK * speed, speed))
    bar(m, "rod", pin, slider, 0.21, (0.0, 0.5 * CRANK * speed, -speed * CRANK / ROD))
    m.add_body("slider", SLIDER, 1e-4, (slider[0] + offset, 0.0, 0.0))
    m.add_revolute("bearing", "ground", "crank", at=(0.0, 0.0))
    m.add_revolute("crank pin", "crank", "rod", at=pin)
    m.add_prismatic("guide", "ground", "slider", direction=(1.0, 0.0))
    m.add_driver("motor", "ground", "crank", speed=speed)
    if clearance is None:
        m.add_revolute("wrist pin", "rod", "slider", at=slider)
    else:
        law = rc.SurfaceContact(length=0.015, material=rc.Material(restitution=0.9))
        joint = ("wrist pin", "slider", "rod", 0.01, 0.01 - clearance, law)
        m.add_clearance_joint(*joint, pin_point=(0.5 * ROD, 0.0))
    return m


def slider_motion(speed, t):
    """Position, velocity and acceleration of the slider of an ideal slider-crank, closed form."""
    sin, cos = np.sin(speed * t), np.cos(speed * t)
    root = np.sqrt(ROD**2 - CRANK**2 * sin**2)
    slope = -(CRANK**2) * sin * cos / root
    bend = -(CRANK**2) * (cos**2 - sin**2) / root - slope**2 / root
    return CRANK * cos + root, speed * (-CRANK * sin + slope), speed**2 * (-CRANK * cos + bend)


def ideal_slider_crank():
    """Return the checks of three turns of a slider-crank at 10 Hz."""
    speed = 20.0 * math.pi
    simulation = rc.Simulation(slider_crank(speed), solver=solver(1e-10))
    result = simulation.run(0.3, 1e-3, **QUIET)
    body, exact = result.body("slider"), slider_motion(speed, result.time)
    test = f"{RUST}::a_slider_crank_follows_its_closed_form"
    found = (body.position[:, 0], body.velocity[:, 0], body.acceleration[:, 0])
    kinds = (
        ("position", "m", 1e-13),
        ("velocity", "m/s", 1e-12 * speed),
        ("acceleration", "m/s²", 1e-11 * speed**2),
    )
    at = 40
    return [
        Check(
            f"slider-crank, ideal: {kind} of the slider at 0.04 s; largest error in 0.3 s",
            *(values[at], expected[at], bound, test, unit),
            error=float(np.abs(values - expected).max()),
        )
        for (kind, unit, bound), values, expected in zip(kinds, found, exact, strict=True)
    ]


SPEED = 5000.0 * 2.0 * math.pi / 60.0
TURN = 60.0 / 5000.0


def with_clearance(clearance):
    """Time [s] and acceleration [m/s^2] of the slider at 5000 rpm in two turns, and the result."""
    simulation = rc.Simulation(slider_crank(SPEED, clearance), solver=solver(1e-9))
    result = simulation.run(2.0 * TURN, TURN / 720.0, **QUIET)
    return result.time, result.body("slider").acceleration[:, 0], result


def departures(clearances=(5e-4, 5e-5, 5e-6)):
    """Return the checks that the acceleration tends to the ideal one with the clearance.

    The departure is the root mean square of the difference over that of the ideal acceleration.
    """
    test = f"{CLEARANCE}::acceleration_peaks_follow_the_ideal_curve_and_shrink_with_the_clearance"
    found = []
    for clearance in clearances:
        time, acceleration, _ = with_clearance(clearance)
        late = time > TURN
        ideal = slider_motion(SPEED, time[late])[2]
        apart = np.sqrt(np.mean((acceleration[late] - ideal) ** 2) / np.mean(ideal**2))
        found.append(float(apart))
    pairs = zip(clearances, clearances[1:], found, found[1:], strict=False)
    return [
        Range(
            f"slider-crank at 5000 rpm: departure from the ideal acceleration at {1e6 * small:g} "
            f"over that at {1e6 * large:g} µm",
            *(less / more, 0.0, 0.7, test),
        )
        for large, small, more, less in pairs
    ]


def peaks():
    """Return the checks of the largest acceleration over the ideal one's, mean of four starts."""
    test = f"{CLEARANCE}::the_largest_accelerations_come_down_to_the_ideal_ones_with_the_clearance"
    ideal = SPEED**2 * CRANK * (1.0 + CRANK / ROD)
    excess = []
    for clearance in (5e-4, 1e-4, 2e-5, 2e-6):
        ratios = []
        for start in range(4):
            scene = slider_crank(SPEED, clearance, offset=0.2 * clearance * start)
            run = rc.Simulation(scene, solver=solver(1e-8)).run(2.0 * TURN, TURN / 72.0, **QUIET)
            force = run.array("peak_contact_force")[72:].max()
            ratios.append(float(force) / SLIDER / ideal)
            assert abs(run.energy.residual[-1]) < 1e-3 * run.energy.dissipated[-1]
        excess.append(np.mean(ratios) - 1.0)
    name = "slider-crank at 5000 rpm: largest acceleration over the ideal one, "
    pairs = zip((100, 20, 2), (500, 100, 20), excess[1:], excess, strict=False)
    return [
        Range(f"{name}clearance 500 µm", 1.0 + excess[0], 3.0, math.inf, test),
        Range(f"{name}clearance 2 µm", 1.0 + excess[3], 0.99, 1.01, test),
        *(
            Range(f"{name}excess at {small} µm over {large} µm", less / more, 0.0, 0.4, test)
            for small, large, less, more in pairs
        ),
    ]


# --- Andrews' squeezing mechanism, singular positions


def squeezing(tolerance=1e-12, bound=1e-9):
    """Return the checks of the seven angles at 0.03 s beside those of the test set."""
    mechanism, end = andrews()
    simulation = rc.Simulation(mechanism, solver=solver(tolerance))
    simulation.step_to(0.03)
    k = simulation.positions[:, 2]
    own = (k[0], k[1] - k[0], k[2], k[3] - k[4], k[4], k[5] - k[6], k[6])
    test = f"{RUST}::andrews_squeezing_mechanism_meets_the_test_set_to_nine_digits"
    return [
        Check(f"Andrews' mechanism at 0.03 s: {name}", found, given, bound, test, "rad", True)
        for name, found, given in zip("βΘγΦδΩε", own, end, strict=True)
    ]


def four_bars(windows):
    """Return the checks of a row of parallelograms that passes singular positions for 10 s."""
    m = rc.Mechanism()
    for k in range(windows + 1):
        bar(m, f"post {k}", (k, 0.0), (k, 1.0), velocity=(0.5, 0.0, -1.0))
        m.add_revolute(f"foot {k}", "ground", f"post {k}", at=(k, 0.0))
        if k:
            bar(m, f"coupler {k}", (k - 1.0, 1.0), (k, 1.0), velocity=(1.0, 0.0, 0.0))
            for x, post in ((k - 1.0, k - 1), (k, k)):
                name = f"coupler {k} on post {post}"
                m.add_revolute(name, f"post {post}", f"coupler {k}", at=(x, 1.0))
    result = rc.Simulation(m, solver=solver(1e-10)).run(10.0, 0.01, **QUIET)
    angles = np.stack([result.body(f"post {k}").position[-1, 2] for k in range(windows + 1)])
    height = result.body("post 0").position[:, 1]
    passages = int((np.sign(height[1:]) != np.sign(height[:-1])).sum())
    test = f"{RUST}::a_row_of_four_bars_passes_its_singular_positions_for_ten_seconds"
    name = f"{windows} four-bars in a row, 10 s, {passages} singular positions: "
    residual = float(np.abs(result.energy.residual).max())
    assert passages >= 8
    return [
        Check(name + "largest energy residual", residual, 0.0, 1e-5, test, "J"),
        Check(name + "angle between posts", np.ptp(angles), 0.0, 1e-9, test, "rad"),
    ]


# --- parts with closed forms


def oscillator():
    """Return the check of a mass on a spring and damper, over 2 s."""
    mass, stiffness, damping, x0 = 2.0, 300.0, 4.0, 0.1
    m = rc.Mechanism(gravity=(0.0, 0.0))
    m.add_body("block", mass, 0.1, (0.5 + x0, 0.0, 0.0))
    m.add_prismatic("guide", "ground", "block", direction=(1.0, 0.0))
    m.add_spring("spring", "ground", "block", stiffness, damping, rest_length=0.5)
    result = rc.Simulation(m, solver=solver(1e-11)).run(2.0, 0.05, **QUIET)
    decay = damping / (2.0 * mass)
    omega = math.sqrt(stiffness / mass - decay**2)
    t, x = result.time, result.body("block").position[:, 0] - 0.5
    exact = x0 * np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t))
    test = f"{JOINTS}::a_body_on_a_spring_and_damper_follows_its_closed_form"
    error = float(np.abs(x - exact).max())
    name = "mass on a spring and damper: displacement at 1 s; largest error in 2 s"
    return [Check(name, x[20], exact[20], 1e-9, test, "m", error=error)]


def gears():
    """Return the check of two wheels in mesh under a torque."""
    ratio, inertia_a, inertia_b = -0.4, 0.02, 0.5
    m = rc.Mechanism(gravity=(0.0, 0.0))
    for name, inertia in (("a", inertia_a), ("b", inertia_b)):
        m.add_body(name, 1.0, inertia)
        m.add_revolute(f"bearing {name}", "ground", name, at=(0.0, 0.0))
    m.add_gear("mesh", "a", "b", ratio=ratio)
    m.add_torque("torque", "a", 3.0)
    simulation = rc.Simulation(m, solver=solver(1e-10))
    simulation.step_to(1.0)
    angle = 0.5 * 3.0 / (inertia_a + ratio**2 * inertia_b)
    test = f"{JOINTS}::gears_share_their_inertia_by_the_square_of_the_ratio"
    name = "pair of gears under a torque: angle after 1 s"
    return [Check(name, simulation.positions[0, 2], angle, 1e-8, test, "rad", True)]


def rolling_wheel():
    """Return the check of a wheel that rolls down an incline."""
    radius, slope = 0.2, 0.3
    down = (math.cos(slope), -math.sin(slope))
    start = radius * np.array([math.sin(slope), math.cos(slope)])
    m = rc.Mechanism()
    m.add_body("wheel", 3.0, 0.5 * 3.0 * radius**2, (*start, 0.0))
    m.add_rack("rolls", "ground", "wheel", down, radius=-radius)
    m.add_point_on_line("stays on", "ground", "wheel", down, tuple(start))
    simulation = rc.Simulation(m, solver=solver(1e-10))
    simulation.step_to(1.0)
    moved = float((simulation.positions[0, :2] - start) @ down)
    exact = 0.5 * GRAVITY * math.sin(slope) * 2.0 / 3.0
    test = f"{JOINTS}::a_wheel_rolls_down_with_two_thirds_of_the_free_acceleration"
    return [Check("wheel that rolls down: distance after 1 s", moved, exact, 1e-9, test, "m")]
