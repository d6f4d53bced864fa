"""The project's own integrator as installed: its methods, and runs of the published drive."""

from __future__ import annotations

import dataclasses
import warnings

import numpy as np

import rustchain as rc
from least_times import Clock, EqualRuns, each_row, step

from .peers import Run

# Of simulated time, between two readings of the clock; at pretension the explicit corrector takes
# thousands of steps in a millisecond [s].
PART, EXPLICIT_PART = 5e-4, 2.5e-5
ROW = 1e-4  # between two rows of a long run [s]


def simulation(start, solver):
    """Return the published drive with a start's pretension, from there."""
    drive = rc.paper_drive(pretension=start.pretension)
    if start.positions is None:
        return rc.Simulation(drive, solver=solver)
    if drive.tensioner is not None:
        tensioner = dataclasses.replace(drive.tensioner, ramp_time=start.ramp_time)
        drive = dataclasses.replace(drive, tensioner=tensioner)
    return rc.Simulation(
        drive, solver=solver, positions=start.positions, velocities=start.velocities
    )


def solver(method, tolerance):
    """`tolerance` is an accuracy in metres, or rtol = atol of "pece, rtol"."""
    if method == "pece, rtol":
        return rc.Solver(method="pece", rtol=tolerance, atol=tolerance)
    return rc.Solver(method=method, accuracy=tolerance)


def run(start, method, tolerance, end, energy):
    """Run to `end`, with the energy balance metered or without; the path is the same."""
    sim = simulation(start, solver(method, tolerance))
    clock, why, energies = Clock(), "", None
    try:
        with warnings.catch_warnings():
            # What is missing is in the table.
            warnings.simplefilter("ignore", rc.EnergyWarning)
            if energy:
                energies = sim.run(end, end, record=(), energy=True, progress=False).energy
                clock.mark()
            else:
                stiff = method.startswith("pece") and start.pretension > 0.0
                step(sim, end, clock, max(1, round(end / (EXPLICIT_PART if stiff else PART))))
    except rc.SimulationError as error:
        clock.mark()
        why = str(error)
    parts = np.diff(clock.marks)
    names = ("steps", "evaluations", "jacobians", "onsets")
    done = Run(
        wall=parts.sum(),
        **{name: int(sim.stats[name]) for name in names},
        reached=sim.time,
        finished=not why,
        positions=sim.positions,
        why=why,
        parts=parts,
    )
    if energies is not None:
        done.residual = energies.residual[-1]
        done.dissipated = energies.dissipated[-1]
    return done


class LongRun:
    """A run with hinge and tooth forces every 0.1 ms, several times, and its result."""

    def __init__(self, start, method, tolerance, duration):
        self.method, self.tolerance, self.start = method, tolerance, start
        self.duration = duration
        self.equal = EqualRuns(self.run)

    def run(self, clock):
        """Run once."""
        sim = simulation(self.start, solver(self.method, self.tolerance))
        clock.begin()
        self.result = sim.run(
            self.duration,
            ROW,
            record=("hinges", "teeth", "energy"),
            progress=False,
            callback=each_row(clock, round(PART / ROW)),
        )
