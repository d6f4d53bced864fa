"""A falling chain of ideal hinges: rustchain beside exudyn, error and time of both.

Needs exudyn: ``pip install --group peers``. Each error is the largest distance of a bar's centre
from where rustchain puts it at 1e-12, whose own error shows in the line at 1e-11. Fails when
rustchain is not at least 20 times faster at equal error. Processor times of one run, each the least
of three; exudyn's of 3000 steps and more are of one run.
"""

import argparse
import math
import sys
import time

import numpy as np

import rustchain as rc
from exudyn_run import solve

LENGTH, MASS, GRAVITY, SPAN = 0.1, 0.02, 9.81, 0.3
FACTOR = 20.0
REPEATS = 3


def places(bars):
    """Centre and angle of each bar of a zigzag that begins at the origin."""
    end, rows = np.zeros(2), []
    for k in range(bars):
        angle = 0.3 if k % 2 else -0.3
        step = LENGTH * np.array([math.cos(angle), math.sin(angle)])
        rows.append((*(end + 0.5 * step), angle))
        end = end + step
    return rows


def by_rustchain(bars, tolerance):
    """Centres at the end, processor time [s] and steps."""
    mechanism = rc.Mechanism(gravity=(0.0, -GRAVITY))
    for k, place in enumerate(places(bars)):
        mechanism.add_body(f"bar {k}", MASS, MASS * LENGTH**2 / 12, place)
        before, point = ("ground", (0.0, 0.0)) if k == 0 else (f"bar {k - 1}", (LENGTH / 2, 0.0))
        mechanism.add_revolute(f"hinge {k}", before, f"bar {k}", point, (-LENGTH / 2, 0.0))
    solver = rc.Solver(rtol=tolerance, atol=tolerance, max_step=0.01)
    simulation = rc.Simulation(mechanism, solver=solver)
    begin = time.process_time()
    simulation.step_to(SPAN)
    spent = time.process_time() - begin
    return simulation.positions[:, :2], spent, simulation.stats["steps"]


def by_exudyn(bars, steps):
    """Centres at the end and processor time [s]: generalized-alpha, index 2, sparse."""
    import exudyn as exu
    import exudyn.itemInterface as items

    system = exu.SystemContainer().AddSystem()
    ground = system.AddObject(items.ObjectGround())
    before = system.AddMarker(items.MarkerBodyPosition(bodyNumber=ground))
    nodes = []
    for place in places(bars):
        nodes.append(system.AddNode(items.NodeRigidBody2D(referenceCoordinates=list(place))))
        body = system.AddObject(
            items.ObjectRigidBody2D(
                physicsMass=MASS, physicsInertia=MASS * LENGTH**2 / 12, nodeNumber=nodes[-1]
            )
        )
        rear, front = (
            system.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=[x, 0, 0]))
            for x in (-LENGTH / 2, LENGTH / 2)
        )
        system.AddObject(items.ObjectJointRevolute2D(markerNumbers=[before, rear]))
        weight = system.AddMarker(items.MarkerBodyMass(bodyNumber=body))
        system.AddLoad(items.LoadMassProportional(markerNumber=weight, loadVector=[0, -GRAVITY, 0]))
        before = front
    return solve(system, nodes, steps, SPAN)


def least(run, repeats=REPEATS):
    """Return what a run returns, with the least processor time of several."""
    results = [run() for _ in range(repeats)]
    return min(results, key=lambda result: result[1])


def times_faster(own, others):
    """Least factor of times at equal error, of rows (error, time).

    The error of generalized-alpha falls with the square of its step: the other code's time at an
    error is reckoned from its row whose error is nearest.
    """
    factors = []
    for error, spent in own:
        near = min(others, key=lambda other: abs(math.log(other[0] / error)))
        factors.append(near[1] * math.sqrt(near[0] / error) / spent)
    return min(factors)


def main():
    """Print the table; return whether rustchain is faster by the factor at all lengths."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--test", action="store_true", help="two chains, long steps")
    quick = parser.parse_args().test
    try:
        import exudyn  # noqa: F401
    except ImportError:
        sys.exit("error: exudyn is not installed: pip install --group peers")
    fast_enough = True
    print("bars  code       setting         error [m]   time [s]   steps")
    for bars in (11, 31) if quick else (11, 17, 25, 31, 37, 100):
        reference, _, _ = by_rustchain(bars, 1e-12)
        own, others = [], []
        for tolerance in (1e-4, 1e-6, 1e-8, 1e-11):
            found, spent, steps = least(lambda n=bars, tol=tolerance: by_rustchain(n, tol))
            error = np.max(np.abs(found - reference))
            print(f"{bars:4}  rustchain  {tolerance:<14.0e}  {error:.1e}  {spent:9.4f}  {steps:6}")
            # What is nearer than this to the reference is as wrong as that.
            if tolerance > 1e-9:
                own.append((error, spent))
        for steps in (300, 1000) if quick else (300, 1000, 3000, 10000):
            repeats = REPEATS if steps < 3000 else 1
            found, spent = least(lambda n=bars, k=steps: by_exudyn(n, k), repeats)
            error = np.max(np.abs(found - reference))
            setting = f"{SPAN / steps:.0e} s steps"
            print(f"{bars:4}  exudyn     {setting:14}  {error:.1e}  {spent:9.4f}  {steps:6}")
            others.append((error, spent))
        factor = times_faster(own, others)
        fast_enough &= factor >= FACTOR
        print(f"{bars:4}  rustchain is {factor:.0f} times faster at equal error, or more")
    return fast_enough


if __name__ == "__main__":
    sys.exit(0 if main() else f"less than {FACTOR:.0f} times faster than exudyn at equal error")
