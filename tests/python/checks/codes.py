"""Other codes: NumPy at random states, DOP853 along a path, Exudyn, one scene each."""

from __future__ import annotations

import json
import warnings

import numpy as np

import rustchain as rc
from checks.check import ROOT, Check, Range
from reference.dynamics import DriveEquations
from reference.path import follow
from reference.random_mechanisms import compare, joined, loaded
from reference.states import State, jiggled

LN = rc.LankaraniNikravesh()
LAWS = {  # of hinges, of teeth
    "Lankarani-Nikravesh": (LN, LN),
    "Johnson, damped": (rc.Johnson(damping="lankarani-nikravesh"),) * 2,
    "enhanced cylinder": (rc.EnhancedCylinder(),) * 2,
    "Liu in hinges, Lankarani-Nikravesh on teeth": (rc.LiuConformal(damping="flores"), LN),
}
DYNAMICS = "python/validation/test_dynamics.py"
PEER = "python/validation/test_peer.py"
EXUDYN = ROOT / "docs" / "validation" / "exudyn.json"


def random_states(drive, count=33):
    """States of a drive, of the first milliseconds of its run with random changes."""
    equations = DriveEquations(drive, LN, LN)
    simulation = rc.Simulation(drive, solver=rc.Solver(method="pece"))
    rng, bases = np.random.default_rng(20101), []
    for time in (4.5e-3, 6e-3, 9e-3):
        simulation.step_to(time)
        bases.append(State(simulation.positions.copy(), simulation.velocities.copy()))
    return [jiggled(equations, bases[k % 3], rng) for k in range(count)]


def drive_forces(count=33):
    """Return the checks of forces and accelerations of a drive beside NumPy, one law each.

    Errors are over the bound of round-off of each number.
    """
    test = f"{DYNAMICS}::test_forces_and_accelerations_agree_to_round_off"
    drive = rc.paper_drive(pretension=25.0)
    states = random_states(drive, count)
    checks = []
    for name, (hinge_law, tooth_law) in LAWS.items():
        simulation = rc.Simulation(drive, hinge_law=hinge_law, tooth_law=tooth_law)
        equations = DriveEquations(drive, hinge_law, tooth_law)
        kinds = ("hinge force", "tooth force", "acceleration")
        worst, largest = dict.fromkeys(kinds, 0.0), dict.fromkeys(kinds, (0.0, 0.0))
        for positions, velocities in states:
            theirs = equations.evaluate(positions, velocities, 0.04)
            ours = simulation.evaluate(positions=positions, velocities=velocities, time=0.04)
            triples = (
                (ours.hinge_force, theirs.hinge_force, theirs.hinge_force_bound),
                (ours.tooth_force, theirs.tooth_force, theirs.tooth_force_bound),
                (ours.accelerations, theirs.accelerations, theirs.acceleration_bound),
            )
            for kind, (found, expected, bound) in zip(kinds, triples, strict=True):
                off = np.abs(found - expected) / np.maximum(bound, np.finfo(float).tiny)
                worst[kind] = max(worst[kind], float(off[found != expected].max(initial=0.0)))
                top = np.abs(expected).argmax()
                pair = (abs(float(found.flat[top])), abs(float(expected.flat[top])))
                largest[kind] = max(largest[kind], pair)
        for kind, unit in zip(kinds, ("N", "N", "m/s² or rad/s²"), strict=True):
            checks.append(
                Check(
                    f"{name}, {count} random states: largest {kind}; worst of all",
                    *(*largest[kind], 1.0, test, unit),
                    error=worst[kind],
                    error_unit="× round-off",
                )
            )
    return checks


def path():
    """Return the checks of the path of the published drive to 4.6 ms beside DOP853."""
    test = f"{DYNAMICS}::test_the_path_past_the_first_contacts_is_the_references"
    drive, end = rc.paper_drive(0.0), 4.6e-3
    simulation = rc.Simulation(drive, solver=rc.Solver(rtol=1e-12, atol=1e-12))
    equations = DriveEquations(drive, LN, LN)
    theirs = follow(equations, simulation.positions, simulation.velocities, end)
    simulation.step_to(end)
    onsets = len(theirs.tooth_onsets) + len(theirs.hinge_onsets)
    off = np.abs(simulation.positions - theirs.positions)
    rates_off = np.abs(simulation.velocities - theirs.velocities)
    name = f"published drive at 4.6 ms, after {onsets} contact onsets: "
    ours, other = simulation.positions, theirs.positions
    rates, other_rates = simulation.velocities, theirs.velocities
    return [
        Check(
            f"{name}{what} of link 9; largest error of any body",
            *(float(found[8, column]), float(expected[8, column]), bound, test, unit),
            error=float(error.max()),
        )
        for what, found, expected, column, bound, unit, error in (
            ("height", ours, other, 1, 1e-12, "m", off[:, :2]),
            ("angle", ours, other, 2, 1e-9, "rad", off[:, 2]),
            ("vertical velocity", rates, other_rates, 1, 1e-7, "m/s", rates_off[:, :2]),
            ("angular velocity", rates, other_rates, 2, 1e-5, "rad/s", rates_off[:, 2]),
        )
    ]


JOINTS = ("revolute", "prismatic", "point_on_line", "distance", "gear", "planet", "rack")
LOADS = ("spring", "torsion spring", "torque by speed")


def mechanism_parts():
    """Return the checks of accelerations of random mechanisms, one kind of part each."""
    file = "python/validation/test_mechanism_reference.py"
    made = [
        (kind, joined, f"{file}::test_a_joint_of_each_kind_is_that_of_the_reference")
        for kind in JOINTS
    ]
    made += [
        (kind, loaded, f"{file}::test_a_load_of_each_kind_is_that_of_the_reference")
        for kind in LOADS
    ]
    checks = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rc.RustchainWarning)
        for kind, make, test in made:
            rng = np.random.default_rng(11)
            worst = max(compare(make(kind, rng), rng)[1] for _ in range(5))
            name = f"{kind}, 40 random states: largest error of an acceleration over its bound"
            checks.append(Range(name, worst, 0.0, 1.0, test))
    return checks


def exudyn():
    """Return the checks of an ideal-hinge drive beside Exudyn, and the stored numbers.

    ``make validation-data`` computes them.
    """
    test = f"{PEER}::test_exudyn_comes_to_the_same_answer_as_its_steps_grow_smaller"
    stored = json.loads(EXUDYN.read_text(encoding="utf-8"))
    errors, moved = stored["errors"], stored["moved"]
    name = "chain of ideal hinges round two wheels, 2 ms: "
    return [
        Range(f"{name}error of 300 steps over that of 100", errors[1] / errors[0], 0.0, 0.25, test),
        Range(f"{name}error of 900 steps over that of 300", errors[2] / errors[1], 0.0, 0.25, test),
        Range(f"{name}difference at 900 steps over the motion", errors[2] / moved, 0, 1e-4, test),
    ], stored
