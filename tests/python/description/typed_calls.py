"""Calls as users write them: type checkers accept each, and each runs.

mypy checks this file with the package; `test_typing` runs it.
"""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path, PurePath

import numpy as np
import numpy.typing as npt

import rustchain as rc

values: npt.NDArray[np.float64] = np.array([0.0, 10.0])
rows: npt.NDArray[np.float64] = np.array([[0.0, 10.0], [1.0, 20.0]])
pair: npt.NDArray[np.float64] = np.array([0.0, 1.0])
number: np.float64 = values.max()
short: np.float32 = np.float32(1e-4)
place: np.intp = values.argmax()  # 1


def describe() -> None:
    """Describe parts with lists and arrays in place of tuples, and read their fields."""
    rc.two_sprocket_drive("ANSI 40", teeth=[17, 25], links=60, speed=rows, gravity=[0.0, -9.81])
    rc.two_sprocket_drive("ANSI 40", teeth=np.array([17, 25]), links=60, speed=short, torque=number)
    rc.two_sprocket_drive(links=60, speed=[[0.0, 0.0], [1.0, 2.0]], pretension=number, gravity=pair)
    sprockets = [
        rc.Sprocket(17, [0.0, 0.0], rc.PrescribedSpeed(rows)),
        rc.Sprocket(17, np.array([0.15, 0.0]), rc.AppliedTorque(short, curve=rows)),
    ]
    drive = rc.chain_drive(
        "ANSI 40", tuple(sprockets), links=42, adjust=2, direction=[1.0, 0.0], gravity=-9.81 * pair
    )
    rc.open_chain("ANSI 40", [rc.AnchoredEnd([0.0, 0.0], velocity=pair), rc.FreeEnd()], 8)
    rc.LoadedEnd(number, position=[0.0, 1.0])
    rc.Tensioner(number, direction=[0.0, 1.0], travel=np.array([0.0, 0.1]))
    rc.Tensioner(number, pivot=pair, arm_inertia=number)
    rc.GuideRail(pair, [0.0, 1.0], 0.1, arm=rc.GuideArm([0.1, 0.0], number, travel=pair * 0.01))
    rc.SmoothIdler(0.02, [0.0, 0.0])
    rc.CustomTooth([rc.ToothLine([0.0, 0.03], (0.001, 0.03))])
    rc.Table(rows), rc.Table([[0, 1], [2, 3]]), rc.Spline(rows), rc.Sines(np.ones((1, 3)))
    dataclasses.replace(drive.chain, elongation=np.zeros(drive.chain.links))
    rc.Johnson().elastic_force(values, [2.22e-3, 2.245e-3], length=number)
    rc.LubricantFilm(0.1).force(1e-5, pair, np.array([2.22e-3, 2.245e-3]), length=number)
    x, y = drive.sprockets[1].center
    east: float = drive.sprockets[1].center[0]
    pitch: float = drive.chain.pitch
    links: int = drive.chain.links
    assert east == x > y
    assert pitch * links > 0.0
    speed: float = rc.rpm(short)
    assert speed > 0.0


def assemble() -> None:
    """Put a mechanism together with arrays."""
    mechanism = rc.Mechanism(gravity=-9.81 * pair)
    mechanism.add_body("a", number, number, position=np.zeros(3), velocity=[0.0, 0.0, 0.0])
    mechanism.add_body("b", 1.0, 1.0, position=(0.5, 0.0, 0.0))
    mechanism.add_revolute("pin", "ground", "a", at=pair)
    mechanism.add_force("pull", "a", pair, point=pair)
    mechanism.add_force("push", "a", [rc.Table(rows), 0.0])
    mechanism.add_spring("spring", "ground", "a", rest_length=number, table=rows)
    mechanism.add_callable("load", "a", lambda t, position, velocity: np.zeros(3))
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [0.0, -0.5]])
    law = rc.LinearContact(number)
    mechanism.add_outline_contact("edge", "ground", "b", corners, 0.1, law, bulges=np.zeros(3))


def simulate() -> rc.Result:
    """Run with times and paths of any kind."""
    drive = rc.paper_drive(number)
    start = rc.Simulation(drive)
    scene = rc.Scene(drive, positions=start.positions, velocities=start.velocities.tolist())
    simulation = rc.Simulation(scene, min_impact_velocity=number)
    simulation.step_to(short)
    simulation.set_speed(place, simulation.time * rows + np.array([[0.0, 12.0], [1.0, 12.0]]))
    simulation.set_tensioner_force(short)
    simulation.evaluate(time=short)
    path: os.PathLike[str] = PurePath("state.npz")
    simulation.save_state(path)
    again = rc.Simulation.load_state(Path("state.npz"))
    result = again.run(
        5e-4 * number, short, record=["hinges", "teeth", "sprockets", "bodies"], progress=False
    )
    result.save(PurePath("run.nc"))
    return rc.load_result(PurePath("run.nc"))


def analyse(result: rc.Result) -> None:
    """Choose parts and times by what NumPy finds."""
    worst = result.peaks.hinge_force.max(axis=0).argmax() + 1
    result.hinge(worst), result.hinge(place), result.bushing(place), result.sprocket(place)
    result.strand(place), result.strand("upper"), result.link_tension(start=short)
    result.between(result.time[2], result.time[-1]).between(end=result.time.max())
    result.hinge_loads(quantiles=[0.5, 0.9], start=short)
    result.tooth_loads(place, quantiles=np.array([0.5, 0.9]), bins_per_pitch=place)
    result.wrap_loads(place), result.engagements(place), result.speed_ripple(place + 1)
    result.strand_motion(place, stations=np.array([0.5]))
    result.plot.hinge_force(1, place), result.plot.drive(time=short)


def vary() -> None:
    """Sweep over arrays."""
    drive = rc.paper_drive()
    found = rc.sweep(
        drive,
        {"pretension": values},
        lambda result: result.time.size,
        duration=2 * short,
        report_step=short,
        threads=np.int64(1),
        store=PurePath("runs"),
        progress=False,
    )
    assert found.success
    speeds = values + 10.0
    rc.loss_map(
        drive, speeds, -values, loaded=place + 1, duration=2e-3, burn_in=short, progress=False
    )


if __name__ == "__main__":
    describe()
    assemble()
    analyse(simulate())
    vary()
