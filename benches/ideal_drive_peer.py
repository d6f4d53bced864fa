"""A chain of ideal hinges round two wheels, one on a spring: rustchain beside exudyn.

Needs exudyn: ``pip install --group peers``. The wheels' outlines are rings of discs, as of a
lantern pinion, which both codes know as contact of circle with circle; the chain's rollers lie
between two discs each. A torque turns one wheel, a damper brakes the other, which slides on a
spring. Contacts are linear and elastic. Each error is the largest distance of a link's centre from
where rustchain puts it at 1e-12.
"""

import math
import sys
import time

import numpy as np

import rustchain as rc
from exudyn_run import solve

TEETH, LINKS, PITCH = 12, 38, 0.0127
STRAND = (LINKS - TEETH) // 2  # links of each strand
RADIUS = PITCH / (2 * math.sin(math.pi / TEETH))
ROLLER = DISC = 0.3 * PITCH
# A roller on the pitch circle just touches its two discs.
RING = RADIUS * math.cos(math.pi / TEETH) - math.sqrt(
    (ROLLER + DISC) ** 2 - (RADIUS * math.sin(math.pi / TEETH)) ** 2
)
LINK_MASS, LINK_INERTIA = 7e-3, 1.5e-7
WHEEL_MASS, WHEEL_INERTIA = 0.2, 6e-5
STIFFNESS = 1e6  # of a contact [N/m]
SPRING, PULL, SLIDE_DAMPING = 2e4, 60.0, 20.0  # [N/m], [N], [N s/m]
TORQUE, BRAKE, GRAVITY = 0.3, 0.02, 9.81  # [N m], [N m s], [m/s^2]
DISTANCE = STRAND * PITCH
SPAN = 0.01


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


def discs():
    """Centres of the discs of a wheel in its frame."""
    turns = 2 * math.pi / TEETH * (np.arange(TEETH) + 0.5)
    return RING * np.stack([np.cos(turns), np.sin(turns)], -1)


def by_rustchain(tolerance, span=SPAN):
    """Centres of the links at the end, wall time [s] and steps."""
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
        for d, center in enumerate(discs()):
            for k in range(LINKS):
                name, roller = f"{wheel} {d} {k}", (-PITCH / 2, 0.0)
                mechanism.add_disc_contact(
                    name, wheel, f"link {k}", DISC, ROLLER, law, center, roller
                )
    solver = rc.Solver(method="pece", rtol=tolerance, atol=tolerance, max_step=1e-3)
    simulation = rc.Simulation(mechanism, solver=solver)
    begin = time.perf_counter()
    simulation.step_to(span)
    wall = time.perf_counter() - begin
    return simulation.positions[:LINKS, :2], wall, simulation._core.stats()["steps"]


def by_exudyn(steps, span=SPAN):
    """Centres of the links at the end and wall time [s]: generalized-alpha, index 2, sparse."""
    import exudyn as exu
    import exudyn.itemInterface as items

    system = exu.SystemContainer().AddSystem()
    ground = system.AddObject(items.ObjectGround())
    contact = system.AddGeneralContact()
    contact.sphereSphereContact = True
    contact.SetFrictionPairings(np.zeros((1, 1)))
    contact.SetSearchTreeCellSize([32, 16, 1])
    box = ([-2 * RADIUS, -2 * RADIUS, -0.1], [DISTANCE + 2 * RADIUS, 2 * RADIUS, 0.1])
    contact.SetSearchTreeBox(np.array(box[0]), np.array(box[1]))

    def body(place, mass, inertia):
        node = system.AddNode(items.NodeRigidBody2D(referenceCoordinates=list(place)))
        item = items.ObjectRigidBody2D(physicsMass=mass, physicsInertia=inertia, nodeNumber=node)
        made = system.AddObject(item)
        weight = system.AddMarker(items.MarkerBodyMass(bodyNumber=made))
        system.AddLoad(items.LoadMassProportional(markerNumber=weight, loadVector=[0, -GRAVITY, 0]))
        return node, made

    def circle(made, x, y, radius):
        at = items.MarkerBodyRigid(bodyNumber=made, localPosition=[x, y, 0.0])
        # Two springs in series: each is twice as stiff as the contact.
        contact.AddSphereWithMarker(system.AddMarker(at), radius, 2 * STIFFNESS, 0.0, 0)

    def coordinate(node, which):
        return system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=which))

    links = [body(place, LINK_MASS, LINK_INERTIA) for place in link_places()]
    ends = []
    for _, made in links:
        circle(made, -PITCH / 2, 0.0, ROLLER)
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
    wheels = [body((x, 0.0, 0.0), WHEEL_MASS, WHEEL_INERTIA) for x in (0.0, DISTANCE)]
    for node, made in wheels:
        for x, y in discs():
            circle(made, x, y, DISC)
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


def main():
    """Print the table."""
    quick = "--quick" in sys.argv or "--test" in sys.argv
    span = 1e-3 if quick else SPAN
    reference, _, _ = by_rustchain(1e-12, span)
    print("code       setting         error [m]   wall [s]   steps")
    for tolerance in (1e-4, 1e-6) if quick else (1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10):
        found, wall, steps = by_rustchain(tolerance, span)
        error = np.max(np.abs(found - reference))
        print(f"rustchain  {tolerance:<14.0e}  {error:.1e}  {wall:9.4f}  {steps:6}")
    try:
        import exudyn  # noqa: F401
    except ImportError:
        print("exudyn is not installed, so it is left out: pip install --group peers")
        return
    for steps in (100,) if quick else (300, 1000, 3000, 10000, 30000):
        found, wall = by_exudyn(steps, span)
        error = np.max(np.abs(found - reference))
        setting = f"{span / steps:.0e} s steps"
        print(f"exudyn     {setting:14}  {error:.1e}  {wall:9.4f}  {steps:6}")


if __name__ == "__main__":
    main()
