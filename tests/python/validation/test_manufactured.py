"""The constraint solver against manufactured solutions.

Motion and reactions are chosen as functions of time; the loads that make them a solution follow
from the equations of Newton and Euler. The simulation gets the loads, and has to return both.
"""

import math

import numpy as np
import pytest

import rustchain as rc

MASSES = (1.3, 0.7, 2.1)  # [kg]
INERTIAS = (0.02, 0.011, 0.05)  # [kg m^2]
LENGTHS = (0.4, 0.9, 0.3)  # [m]
DRIVEN = (0.7, 3.0, 0.2), (0.3, 7.0, 1.0)  # amplitude [rad], frequency [rad/s], phase


def waves(terms, t):
    """Return a sum of sines and two derivatives."""
    value = sum(a * math.sin(w * t + p) for a, w, p in terms)
    rate = sum(a * w * math.cos(w * t + p) for a, w, p in terms)
    return np.array([value, rate, -sum(a * w * w * math.sin(w * t + p) for a, w, p in terms)])


def arm(length, angle):
    """Return a vector of constant length at an angle, with two derivatives, (3, 2)."""
    a, rate, change = angle
    along, across = np.array([math.cos(a), math.sin(a)]), np.array([-math.sin(a), math.cos(a)])
    return length * np.array([along, across * rate, across * change - along * rate**2])


def reaction(joint, t):
    """Return the chosen force of a joint on its second body [N]."""
    x = waves([(20.0, 5.0 + joint, 0.3 * joint)], t)[0] + 10.0
    return np.array([x, waves([(15.0, 4.0 - joint, 1.0)], t)[0]])


def cross(a, b):
    return a[0] * b[1] - a[1] * b[0]


class Pendulum:
    """Three rods one behind the other, each joined in its ends."""

    def motion(self, t):
        """Return centres, (3 bodies, derivatives, 2), and angles, (3 bodies, derivatives)."""
        angles = [waves(DRIVEN[: 1 + k % 2], (1.0 + 0.3 * k) * t) for k in range(3)]
        for k, angle in enumerate(angles):
            angle *= (1.0 + 0.3 * k) ** np.arange(3)  # time runs faster
        base, centers = np.zeros((3, 2)), []
        for length, angle in zip(LENGTHS, angles, strict=True):
            centers.append(base + arm(0.5 * length, angle))
            base = base + arm(length, angle)
        return centers, angles

    def reactions(self, t):
        """Return point, force and couple of each joint on the body behind it, at time t."""
        _, angles = self.motion(t)
        point = np.zeros(2)
        for k, (length, angle) in enumerate(zip(LENGTHS, angles, strict=True)):
            yield point, reaction(k, t), 0.0
            point = point + arm(length, angle)[0]

    def join(self, mechanism):
        ends = [(0.0, 0.0), *((0.5 * length, 0.0) for length in LENGTHS)]
        names = ["ground", *(body.name for body in mechanism.bodies)]
        for k, length in enumerate(LENGTHS):
            points = {"point_a": ends[k], "point_b": (-0.5 * length, 0.0)}
            mechanism.add_revolute(f"joint {k}", names[k], names[k + 1], **points)


class SliderCrank:
    """A crank that turns more than once, a rod and a slider: a closed loop."""

    def motion(self, t):
        crank = waves(DRIVEN, t) + np.array([5.0 * t, 5.0, 0.0])
        ratio = LENGTHS[0] / LENGTHS[1]
        a, rate, change = crank
        rod = math.asin(-ratio * math.sin(a))
        turns = -ratio * math.cos(a) * rate / math.cos(rod)
        bends = -ratio * (math.cos(a) * change - math.sin(a) * rate**2)
        angle = np.array([rod, turns, (bends + math.sin(rod) * turns**2) / math.cos(rod)])
        pin = arm(LENGTHS[0], crank)
        slider = pin + arm(LENGTHS[1], angle)
        centers = [0.5 * pin, pin + arm(0.5 * LENGTHS[1], angle), slider]
        return centers, [crank, angle, np.zeros(3)]

    def reactions(self, t):
        centers, _ = self.motion(t)
        yield np.zeros(2), reaction(0, t), 0.0
        yield 2.0 * centers[0][0], reaction(1, t), 0.0
        yield centers[2][0], reaction(2, t), 0.0
        # Nothing along the guide.
        yield centers[2][0], np.array([0.0, reaction(3, t)[1]]), waves([(2.0, 6.0, 0.5)], t)[0]

    def join(self, mechanism):
        crank, rod, slider = (body.name for body in mechanism.bodies)
        half = [0.5 * length for length in LENGTHS]
        mechanism.add_revolute("joint 0", "ground", crank, point_b=(-half[0], 0.0))
        mechanism.add_revolute(
            "joint 1", crank, rod, point_a=(half[0], 0.0), point_b=(-half[1], 0.0)
        )
        mechanism.add_revolute("joint 2", rod, slider, point_a=(half[1], 0.0))
        mechanism.add_prismatic("joint 3", "ground", slider, (1.0, 0.0), angle=0.0)


ENDS = {Pendulum: ((None, 0), (0, 1), (1, 2)), SliderCrank: ((None, 0), (0, 1), (1, 2), (None, 2))}


def loads(case, t):
    """Return force and torque on each body, (3, 3), by the equations of Newton and Euler."""
    centers, angles = case.motion(t)
    found = np.zeros((3, 3))
    for k in range(3):
        found[k, :2] = MASSES[k] * centers[k][2]
        found[k, 2] = INERTIAS[k] * angles[k][2]
    for (first, second), (point, force, couple) in zip(
        ENDS[type(case)], case.reactions(t), strict=True
    ):
        for body, sign in ((first, -1.0), (second, 1.0)):
            if body is not None:
                found[body, :2] -= sign * force
                found[body, 2] -= sign * (cross(point - centers[body][0], force) + couple)
    return found


def built(case):
    mechanism = rc.Mechanism(name="manufactured", gravity=(0.0, 0.0))
    centers, angles = case.motion(0.0)
    for k in range(3):
        position, velocity = ((*centers[k][i], angles[k][i]) for i in range(2))
        mechanism.add_body(f"body {k}", MASSES[k], INERTIAS[k], position, velocity)
    case.join(mechanism)
    for k in range(3):
        mechanism.add_callable(
            f"load {k}", f"body {k}", lambda t, *_, k=k: tuple(loads(case, t)[k])
        )
    return mechanism


def errors(case, duration=1.0, **solver):
    """Return the largest errors of positions [m or rad] and of reactions [N or N m]."""
    scene = rc.Scene(built(case), solver=rc.Solver(**solver))
    result = rc.Simulation(scene).run(duration, 0.05, energy=False, progress=False)
    place, force = 0.0, 0.0
    for row, t in enumerate(result.time):
        centers, angles = case.motion(t)
        exact = [(*center[0], angle[0]) for center, angle in zip(centers, angles, strict=True)]
        place = max(place, np.abs(result.array("positions")[row] - exact).max())
        for k, (_, pressed, couple) in enumerate(case.reactions(t)):
            history = result.joint(f"joint {k}")
            found = np.array([*history.force[row], history.torque[row]])
            force = max(force, np.abs(found - (*pressed, couple)).max())
    return place, force


@pytest.mark.parametrize("accuracy", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("method", ["pece", "newton"])
@pytest.mark.parametrize("case", [Pendulum(), SliderCrank()], ids=["pendulum", "slider crank"])
def test_motion_and_reactions_are_those_that_were_chosen(case, method, accuracy):
    place, force = errors(case, method=method, accuracy=accuracy, max_step=1.0)
    # Measured: at most 8.3e3 and 1.8e5 times the accuracy, of 32 N at most in a joint.
    assert place <= 3e4 * accuracy
    assert force <= 6e5 * accuracy


@pytest.mark.parametrize(
    ("method", "max_order", "expected"),
    [("pece", 1, 2), ("pece", 2, 3), ("newton", 2, 2), ("newton", 3, 3), ("newton", 4, 4)],
)
@pytest.mark.parametrize("case", [Pendulum(), SliderCrank()], ids=["pendulum", "slider crank"])
def test_the_error_falls_with_the_power_of_the_step_size(case, method, max_order, expected):
    """A tolerance that no step exceeds: all steps but the first ones have the largest size."""
    control = {"method": method, "max_order": max_order, "rtol": 0.1, "atol": 0.1}
    coarse, fine = (errors(case, 0.3, max_step=step, **control)[0] for step in (2e-3, 1e-3))
    # Measured: 1.87 to 2.08, 2.97 to 3.00 and 3.98 to 4.01.
    assert abs(math.log2(coarse / fine) - expected) < 0.2
