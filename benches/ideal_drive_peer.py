"""A chain of ideal hinges round two wheels, one on a spring: rustchain beside exudyn.

Needs exudyn: ``pip install --group peers``. The wheels have closed outlines of straight flanks, a
notch for each link, and each link carries a roller in its middle that lies on both flanks of a
notch. There, rustchain's outline contact and exudyn's ``ObjectContactCurveCircles`` are the same
model. Where they are not, the scene does not go: over a tip each of exudyn's segments presses on
its own, and circles beside the centres of their bodies all get the lever arm of the first one. A
torque turns one wheel, a damper brakes the other, which slides on a spring. Contacts are linear and
elastic. Each error is the largest distance of a link's centre from where rustchain puts it at an
accuracy of 1e-13 m.
"""

import argparse
import math
import time
from functools import partial

import numpy as np

import rustchain as rc
from exudyn_run import solve

TEETH, LINKS, PITCH = 12, 38, 0.0127
STRAND = (LINKS - TEETH) // 2  # links of each strand
RADIUS = PITCH / (2 * math.sin(math.pi / TEETH))
ROLLER = 0.3 * PITCH
HALF_NOTCH = math.radians(50)  # between a flank and the middle of its notch
# A roller of a link whose hinges are on the pitch circle just touches both flanks of its notch;
# neighbouring notches meet in a tip.
ROOT = RADIUS * math.cos(math.pi / TEETH) - ROLLER / math.sin(HALF_NOTCH)
FLANK = ROOT * math.sin(math.pi / TEETH) / math.sin(HALF_NOTCH - math.pi / TEETH)
TIP = math.hypot(ROOT + FLANK * math.cos(HALF_NOTCH), FLANK * math.sin(HALF_NOTCH))
LINK_MASS, LINK_INERTIA = 7e-3, 1.5e-7
WHEEL_MASS, WHEEL_INERTIA = 0.2, 6e-5
STIFFNESS = 1e6  # of a contact [N/m]
SPRING, PULL, SLIDE_DAMPING = 2e4, 60.0, 20.0  # [N/m], [N], [N s/m]
TORQUE, BRAKE, GRAVITY = 0.3, 0.02, 9.81  # [N m], [N m s], [m/s^2]
DISTANCE = STRAND * PITCH
SPAN = 0.01
FINEST = 1e-13  # accuracy of the reference [m]


def hinge_points():
    """Hinges of the chain laid taut round both wheels, (links, 2)."""
    turns = 2 * math.pi / TEETH * np.arange(TEETH // 2 + 1)
    left = RADIUS * np.stack([np.cos(math.pi / 2 + turns), np.sin(math.pi / 2 + turns)], -1)
    right = RADIUS * np.stack([np.cos(turns - math.pi / 2), np.sin(turns - math.pi / 2)], -1)
    low = [(k * PITCH, -RADIUS) for k in range(1, STRAND)]
    high = [(DISTANCE - k * PITCH, RADIUS) for k in range(1, STRAND)]
    return np.concatenate([left, low, right + [DISTANCE, 0.0], high])


def link_places():
    """Centre and angle of each link, from hinge to hinge."""
    rear = hinge_points()
    front = np.roll(rear, -1, axis=0)
    way = front - rear
    return np.column_stack([0.5 * (rear + front), np.arctan2(way[:, 1], way[:, 0])])


def outline():
    """Roots and tips of a wheel in turn, counterclockwise in its frame, (2 * teeth, 2)."""
    turns = math.pi / TEETH * np.arange(1, 2 * TEETH + 1)
    radii = np.tile([ROOT, TIP], TEETH)
    return radii[:, None] * np.stack([np.cos(turns), np.sin(turns)], -1)


def near_tips(links, wheels):
    """Least distance of a roller from a tip in radii of a roller, by places (.., 3)."""
    nearest = math.inf
    for x, y, angle in wheels:
        cos, sin = math.cos(angle), math.sin(angle)
        tips = [x, y] + outline()[1::2] @ np.array([[cos, sin], [-sin, cos]])
        apart = np.linalg.norm(links[:, None, :2] - tips[None], axis=-1)
        nearest = min(nearest, apart.min() / ROLLER)
    return nearest


def simulated(accuracy, solver=None):
    """Return the drive as a simulation of rustchain: links, then both wheels.

    A `solver` takes the place of one with this accuracy.
    """
    mechanism = rc.Mechanism(gravity=(0.0, -GRAVITY))
    for k, place in enumerate(link_places()):
        mechanism.add_body(f"link {k}", LINK_MASS, LINK_INERTIA, place)
    for k in range(LINKS):
        ends = (f"link {k - 1}" if k else f"link {LINKS - 1}", f"link {k}")
        mechanism.add_revolute(f"hinge {k}", *ends, (PITCH / 2, 0.0), (-PITCH / 2, 0.0))
    for name, x in (("driver", 0.0), ("driven", DISTANCE)):
        mechanism.add_body(name, WHEEL_MASS, WHEEL_INERTIA, (x, 0.0, 0.0))
    mechanism.add_revolute("bearing", "ground", "driver", at=(0.0, 0.0))
    mechanism.add_point_on_line("slide", "ground", "driven", (1.0, 0.0))
    mechanism.add_torque("motor", "driver", TORQUE)
    mechanism.add_torsion_spring("brake", "ground", "driven", damping=BRAKE)
    behind = (DISTANCE - 0.1, 0.0)
    rest = 0.1 + PULL / SPRING
    mechanism.add_spring(
        "spring", "ground", "driven", SPRING, SLIDE_DAMPING, point_a=behind, rest_length=rest
    )
    law = rc.LinearContact(STIFFNESS)
    for wheel in ("driver", "driven"):
        for k in range(LINKS):
            mechanism.add_outline_contact(
                f"{wheel} {k}", wheel, f"link {k}", outline(), ROLLER, law
            )
    solver = solver or rc.Solver(method="pece", accuracy=accuracy, max_step=1e-3)
    return rc.Simulation(mechanism, solver=solver)


def by_rustchain(accuracy, span=SPAN, solver=None):
    """Centres of the links at the end, processor time [s] and steps."""
    simulation = simulated(accuracy, solver)
    begin = time.process_time()
    simulation.step_to(span)
    spent = time.process_time() - begin
    return simulation.positions[:LINKS, :2], spent, simulation.stats["steps"]


def by_exudyn(steps, span=SPAN):
    """Centres of the links at the end and processor time [s], by generalized-alpha."""
    import exudyn as exu
    import exudyn.itemInterface as items

    system = exu.SystemContainer().AddSystem()
    ground = system.AddObject(items.ObjectGround())

    def body(place, mass, inertia):
        node = system.AddNode(items.NodeRigidBody2D(referenceCoordinates=list(place)))
        item = items.ObjectRigidBody2D(physicsMass=mass, physicsInertia=inertia, nodeNumber=node)
        made = system.AddObject(item)
        weight = system.AddMarker(items.MarkerBodyMass(bodyNumber=made))
        system.AddLoad(items.LoadMassProportional(markerNumber=weight, loadVector=[0, -GRAVITY, 0]))
        return node, made

    def rigid(made):
        return system.AddMarker(items.MarkerBodyRigid(bodyNumber=made))

    def coordinate(node, which):
        return system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=which))

    links = [body(place, LINK_MASS, LINK_INERTIA) for place in link_places()]
    ends, rollers = [], []
    for _, made in links:
        rollers.append(rigid(made))
        ends.append(
            [
                system.AddMarker(items.MarkerBodyPosition(bodyNumber=made, localPosition=[x, 0, 0]))
                for x in (-PITCH / 2, PITCH / 2)
            ]
        )
    for k in range(LINKS):
        markers = [ends[k - 1][1], ends[k][0]]
        system.AddObject(items.ObjectJointRevolute2D(markerNumbers=markers))
    fixed = system.AddNode(items.NodePointGround())
    still = coordinate(fixed, 0)
    corners = outline()
    flanks = np.hstack([np.roll(corners, -1, axis=0), corners])  # material on the other side
    wheels = [body((x, 0.0, 0.0), WHEEL_MASS, WHEEL_INERTIA) for x in (0.0, DISTANCE)]
    for node, made in wheels:
        # Its own states of a segment: the circle on it, the gap, the tangential velocity.
        states = items.NodeGenericData(
            initialCoordinates=[-1, 0, 0] * len(flanks), numberOfDataCoordinates=3 * len(flanks)
        )
        system.AddObject(
            items.ObjectContactCurveCircles(
                markerNumbers=[rigid(made), *rollers],
                nodeNumber=system.AddNode(states),
                circlesRadii=[ROLLER] * LINKS,
                segmentsData=exu.MatrixContainer(flanks),
                contactStiffness=STIFFNESS / FLANK,  # of a length of segment [N/m^2]
            )
        )
        held = (0, 1) if node == wheels[0][0] else (1,)
        for which in held:
            system.AddObject(
                items.CoordinateConstraint(markerNumbers=[still, coordinate(node, which)])
            )
    system.AddLoad(items.LoadCoordinate(markerNumber=coordinate(wheels[0][0], 2), load=TORQUE))
    for which, stiffness, damping, offset in (
        (2, 0.0, BRAKE, 0.0),
        (0, SPRING, SLIDE_DAMPING, PULL / SPRING),
    ):
        item = items.CoordinateSpringDamper(
            markerNumbers=[still, coordinate(wheels[1][0], which)],
            stiffness=stiffness,
            damping=damping,
            offset=offset,
        )
        system.AddObject(item)
    del ground
    return solve(system, [node for node, _ in links], steps, span)


def least(run, repetitions):
    """Return the answer of a run and the least processor time [s] of several."""
    answers = [run() for _ in range(repetitions)]
    return answers[0][0], min(answer[1] for answer in answers), *answers[0][2:]


def at_error(error, errors, times):
    """Return the time [s] that an error takes, between the lines of a table that straddle it."""
    logs = np.log(error), np.log(errors[::-1]), np.log(times[::-1])
    return float(np.exp(np.interp(*logs))) if errors[-1] <= error <= errors[0] else math.nan


def main():
    """Print the table, and how much faster rustchain is at the errors of exudyn."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--test", action="store_true", help="the first 1 ms, few steps")
    quick = parser.parse_args().test
    span = 1e-3 if quick else SPAN
    repetitions = 1 if quick else 3
    reference, _, _ = by_rustchain(FINEST, span)
    print("code       setting         error [m]   time [s]   steps")
    own = [[], []]
    for accuracy in (1e-6, 1e-9) if quick else (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11):
        found, spent, steps = least(partial(by_rustchain, accuracy, span), repetitions)
        own[0].append(np.max(np.abs(found - reference)))
        own[1].append(spent)
        print(f"rustchain  {accuracy:<14.0e}  {own[0][-1]:.1e}  {spent:9.4f}  {steps:6}")
    try:
        import exudyn  # noqa: F401
    except ImportError:
        print("exudyn is not installed, so it is left out: pip install --group peers")
        return
    for steps in (100,) if quick else (200, 300, 500, 1000, 3000, 10000):
        found, spent = least(partial(by_exudyn, steps, span), repetitions if steps < 3000 else 1)
        error = np.max(np.abs(found - reference))
        setting = f"{span / steps:.0e} s steps"
        faster = spent / at_error(error, *own)
        print(f"exudyn     {setting:14}  {error:.1e}  {spent:9.4f}  {steps:6}   x {faster:.0f}")


if __name__ == "__main__":
    main()
