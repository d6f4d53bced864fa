"""What must not matter does not: where the scene stands, how it is turned, its mirror image."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

import rustchain as rc
from reference.compare import assert_within
from reference.dynamics import DriveEquations, Evaluation, force_bound

LN = rc.LankaraniNikravesh()


@dataclass(frozen=True)
class SceneMap:
    """Mirror about the x axis (if asked), turn by ``angle`` [rad], then shift [m]."""

    angle: float = 0.0
    shift: tuple[float, float] = (0.0, 0.0)
    mirrored: bool = False

    @property
    def sense(self) -> float:
        return -1.0 if self.mirrored else 1.0

    @property
    def matrix(self) -> np.ndarray:
        c, s = np.cos(self.angle), np.sin(self.angle)
        return np.array([[c, -s], [s, c]]) @ np.diag([1.0, self.sense])

    def vectors(self, values: np.ndarray) -> np.ndarray:
        """Velocities or accelerations (bodies, 3), or plain vectors (..., 2)."""
        out = np.array(values, dtype=float)
        out[..., :2] = out[..., :2] @ self.matrix.T
        out[..., 2:] *= self.sense
        return out

    def positions(self, values: np.ndarray) -> np.ndarray:
        out = self.vectors(values)
        out[..., :2] += self.shift
        out[..., 2:] += self.angle
        return out

    def drive(self, drive: rc.ChainDrive) -> rc.ChainDrive:
        def moved(sprocket: rc.Sprocket) -> rc.Sprocket:
            motion = sprocket.motion
            if isinstance(motion, rc.PrescribedSpeed):
                motion = rc.PrescribedSpeed(self.sense * motion.speed)
            center = self.positions(np.array(sprocket.center))
            return replace(sprocket, center=tuple(center), motion=motion)

        tensioner = drive.tensioner
        if tensioner is not None:
            one, other = (np.array(sprocket.center) for sprocket in drive.sprockets)
            away = (other - one) / np.hypot(*(other - one))
            tensioner = replace(tensioner, direction=tuple(self.vectors(away)))
        return replace(
            drive,
            sprockets=[moved(sprocket) for sprocket in drive.sprockets],
            tensioner=tensioner,
            gravity=tuple(self.vectors(np.array(drive.gravity))),
        )


MAPS = {
    "turned": SceneMap(angle=0.7),
    "turned far": SceneMap(angle=-2.4),
    "moved": SceneMap(shift=(-0.21, 0.34)),
    "mirrored": SceneMap(mirrored=True),
    "all of it": SceneMap(angle=1.9, shift=(0.15, -0.08), mirrored=True),
}


def spread(evaluation: Evaluation, delta_x: float) -> tuple[np.ndarray, np.ndarray]:
    """How far hinge and tooth forces [N] move when the coordinates move by ``delta_x`` [m].

    The mapped coordinates are rounded, so that both the depth and, as the normal turns, its rate
    move; for a pin 30 um off its bushing's centre the second is no small matter.
    """
    kin, delta_v = evaluation.kinematics, evaluation.speed_bound
    hinge = force_bound(evaluation.hinge, delta_x, delta_v + kin.hinge_turning * delta_x)
    tooth = force_bound(evaluation.tooth, delta_x, delta_v + kin.tooth_turning * delta_x)
    return hinge, tooth


def on_bodies(equations: DriveEquations, hinge: np.ndarray, tooth: np.ndarray) -> np.ndarray:
    """Bound of the accelerations (bodies, 3): forces' bounds with the longest arm, over inertia."""
    n = equations.links
    k = np.arange(n)
    following = (k + 1) % n
    inner, outer = np.where(k % 2 == 0, k, following), np.where(k % 2 == 0, following, k)
    total = np.zeros(n + 2)
    np.add.at(total, inner, hinge + tooth.sum(axis=1))
    np.add.at(total, outer, hinge)
    total[n:] = tooth.sum(axis=0)
    arm = np.append(
        np.full(n, equations.pitch), [profile.reach(0.0) for profile in equations.profiles]
    )
    bound = total / equations.mass
    return np.stack([bound, bound, total * arm / equations.inertia], axis=1)


@pytest.mark.parametrize("name", MAPS)
def test_accelerations_follow_the_scene(name, paper, real_states, states_with_seat):
    scene = MAPS[name]
    drive = scene.drive(paper)
    here = rc.Simulation(paper)
    start, rates = real_states[0]
    there = rc.Simulation(drive, positions=scene.positions(start), velocities=scene.vectors(rates))
    equations_here, equations_there = (DriveEquations(one, LN, LN) for one in (paper, drive))
    for positions, velocities in states_with_seat("pitch-circle"):
        moved, moved_rates = scene.positions(positions), scene.vectors(velocities)
        a = here.evaluate(positions=positions, velocities=velocities, time=0.04)
        b = there.evaluate(positions=moved, velocities=moved_rates, time=0.04)
        one = equations_here.evaluate(positions, velocities, 0.04)
        two = equations_there.evaluate(moved, moved_rates, 0.04)
        delta_x = one.penetration_bound + two.penetration_bound  # both scenes round, and the map
        hinge, tooth = spread(one, delta_x)
        assert_within(b.hinge_penetration, a.hinge_penetration, delta_x, "hinge penetration")
        assert_within(b.tooth_penetration, a.tooth_penetration, delta_x, "tooth penetration")
        assert_within(b.hinge_force, a.hinge_force, hinge, "hinge force")
        assert_within(b.tooth_force, a.tooth_force, tooth, "tooth force")
        bound = on_bodies(equations_here, hinge, tooth)
        bound += 1e-12 * np.max(np.abs(a.accelerations[:, :2]), axis=1, keepdims=True)
        assert_within(b.accelerations, scene.vectors(a.accelerations), bound, "accelerations")


@pytest.mark.parametrize("name", MAPS)
def test_the_path_to_6_ms_follows_the_scene(name):
    # Absolute tolerances: relative ones weigh a coordinate by where the scene stands.
    scene = MAPS[name]
    solver = rc.Solver(rtol=0.0, atol=1e-10)
    drive = rc.paper_drive(pretension=0.0)
    here = rc.Simulation(drive, solver=solver)
    there = rc.Simulation(
        scene.drive(drive),
        positions=scene.positions(here.positions),
        velocities=scene.vectors(here.velocities),
        solver=solver,
    )
    here.step_to(6e-3)
    there.step_to(6e-3)
    off = np.abs(there.positions - scene.positions(here.positions))
    assert np.max(off[:, :2]) <= 1e-9  # [m]; two runs at 1e-10 differ by up to 6e-11
    assert np.max(off[:, 2]) <= 2e-7  # [rad]


def test_momentum_stays_without_gravity_driver_and_supports():
    drive = rc.paper_drive(pretension=0.0)
    start = rc.Simulation(drive)
    positions, velocities = start.positions.copy(), start.velocities.copy()
    # Enough disorder for contacts of all kinds, and linear momentum along both axes.
    rng = np.random.default_rng(7)
    velocities[:, :2] += rng.uniform(-0.1, 0.1, (40, 2)) + [0.05, -0.03]
    free = [
        replace(sprocket, bearing="floating", motion=rc.Free(), mass=0.817, inertia=588.29e-6)
        for sprocket in drive.sprockets
    ]
    drive = replace(drive, sprockets=free, tensioner=None, gravity=(0.0, 0.0))
    simulation = rc.Simulation(
        drive,
        positions=positions,
        velocities=velocities,
        solver=rc.Solver(rtol=1e-10, atol=1e-10),
    )
    equations = DriveEquations(drive, LN, LN)

    def momentum(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        p = equations.mass[:, None] * v[:, :2]
        spin = equations.inertia * v[:, 2]
        return np.array([*p.sum(axis=0), np.sum(q[:, 0] * p[:, 1] - q[:, 1] * p[:, 0] + spin)])

    before = momentum(positions, velocities)
    result = simulation.run(
        duration=8e-3,
        report_step=1e-4,
        record=("hinges", "teeth", "bodies", "energy"),
        progress=False,
    )
    peaks = result.peaks
    assert np.sum(peaks.tooth_force.max(axis=0) > 1.0) >= 5
    assert np.sum(peaks.hinge_force.max(axis=0) > 1.0) >= 10
    history = np.array(
        [
            momentum(q, v)
            for q, v in zip(result.array("positions"), result.array("velocities"), strict=True)
        ]
    )
    drift = np.max(np.abs(history - before), axis=0)
    # Equal and opposite forces along one line, and a multistep method keeps linear invariants:
    # both momenta stay to round-off, measured 4e-15 N s of 0.18 and 1e-15 N m s of 0.009.
    assert np.all(drift[:2] <= 1e-13), drift
    assert drift[2] <= 1e-13, drift
