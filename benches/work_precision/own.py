"""The project's own integrator as installed: its methods, and runs of the published drive."""

from __future__ import annotations

import dataclasses
import time
import warnings

import rustchain as rc

from .peers import Run


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
    begin = time.thread_time()
    try:
        with warnings.catch_warnings():
            # What is missing is in the table.
            warnings.simplefilter("ignore", rc.EnergyWarning)
            result = sim.run(end, end, record=(), energy=energy, progress=False)
    except rc.SimulationError as error:
        result = error.result
    wall = time.thread_time() - begin
    names = ("steps", "evaluations", "jacobians", "onsets")
    done = Run(
        wall=wall,
        **{name: int(result.stats[name]) for name in names},
        reached=sim.time,
        finished=result.success,
        positions=result.final_positions,
        why="" if result.success else result.message,
    )
    if energy and done.finished:
        done.residual = result.energy.residual[-1]
        done.dissipated = result.energy.dissipated[-1]
    return done


def long_run(start, method, tolerance, duration):
    """Return the result of a run with hinge and tooth forces every 0.1 ms, and its wall time."""
    sim = simulation(start, solver(method, tolerance))
    begin = time.thread_time()
    result = sim.run(duration, 1e-4, record=("hinges", "teeth", "energy"), progress=False)
    return result, time.thread_time() - begin
