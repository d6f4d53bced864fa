"""Random mechanisms beside Exudyn: open trees and closed loops, joints, drivers, springs, loads.

A seed alone makes a mechanism. Exudyn's method is of order two: the difference of two answers with
steps of h and h/2 bounds the error of the second one, and `Compared.share` is the distance of the
answer of rustchain from it, over that difference. It is 1/3 where the two codes agree, as h falls,
and the answers extrapolated to a step of zero are much nearer. Where they are not, DOP853 of SciPy
integrates the dense equations of `reference.mechanism` and decides.
"""

from __future__ import annotations

import argparse
import math
import sys
import warnings
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

import rustchain as rc
from draw import Draw

ROOT = Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "benches"), str(ROOT / "tests" / "python")]  # as pytest has them

from exudyn_system import Translated  # noqa: E402
from reference.mechanism import Reference  # noqa: E402

Array = npt.NDArray[np.float64]
Point = tuple[float, float]

# Times [s] at which answers are compared: some radians of the rods. The next one is taken where the
# steps of Exudyn do not converge until the one before, as of rods that spin or move chaotically.
SPANS = (0.4, 0.2, 0.1, 0.05)
STEPS = (500, 1000, 2000, 4000)
# Steps are halved until the difference of two answers is below this [m, rad] and the codes agree.
FINE = 1e-3
# Allowed distance over the difference of two answers of Exudyn: 1/3 of order two, 1 of order one;
# and that of the extrapolated answer.
ALLOWED, EXTRAPOLATED = 0.5, 0.1
# Round-off of both codes [m, rad]: Exudyn's Newton iterations stop at about 1e-10.
ROUNDING = 1e-8
# Of the joints at the start; above it they are redundant, or nearly singular.
WORST_CONDITION = 1e4
# Of rustchain and of the third answer.
TOLERANCE, THIRD = 1e-11, 1e-8

# Kinds of joints that hold a rod to the one before, and what each takes of its three freedoms.
HELD = {"revolute": 2, "prismatic": 2, "line": 1, "distance": 1, "fixed": 3, "none": 0}
KINDS = ("revolute",) * 5 + tuple(HELD)


def _rod(draw: Draw, mechanism: rc.Mechanism, name: str, a: Point, b: Point) -> None:
    length, mass = math.dist(a, b), draw.log_between(0.1, 5.0)
    middle = (0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), math.atan2(b[1] - a[1], b[0] - a[0]))
    mechanism.add_body(name, mass, draw.between(0.5, 2.0) * mass * length**2 / 12.0, middle)


def _join(draw: Draw, mechanism: rc.Mechanism, kind: str, ends: tuple[str, str], at: Point) -> None:
    name = f"{kind} {len(mechanism.joints)}"
    angle = draw.between(-math.pi, math.pi)
    direction = (math.cos(angle), math.sin(angle))
    match kind:
        case "revolute":
            mechanism.add_revolute(name, *ends, at=at)
        case "prismatic":
            mechanism.add_prismatic(name, *ends, direction, at=at)
        case "line":
            mechanism.add_point_on_line(name, *ends, direction, at=at)
        case "distance":
            far = (draw.between(0.05, 0.2), draw.between(0.05, 0.2))
            mechanism.add_distance(name, *ends, point_a=far, point_b=(-0.05, 0.02))
        case "fixed":
            mechanism.add_fixed(name, *ends, at=at)


def _load(draw: Draw, mechanism: rc.Mechanism, name: str, before: str) -> None:
    def point() -> Point:
        return (draw.between(-0.2, 0.2), draw.between(-0.2, 0.2))

    if draw.chance(0.5, "spring"):
        cubic = draw.one_of((0.0, draw.log_between(10.0, 1e4)))
        rest = draw.one_of((None, draw.between(0.05, 0.5)))
        ends = (f"spring {name}", draw.one_of(("ground", before)), name)
        stiffness, damping = draw.log_between(10.0, 1e3), draw.between(0.0, 10.0)
        far = (draw.between(0.3, 1.0), draw.between(0.3, 1.0))
        mechanism.add_spring(
            *ends, stiffness, damping, point_a=far, point_b=point(), cubic=cubic, rest_length=rest
        )
    if draw.chance(0.3, "torsion spring"):
        cubic = draw.one_of((0.0, draw.between(0.0, 5.0)))
        turned = mechanism.bodies[-1].position[2] - _angle(mechanism, before)
        rest = draw.one_of((None, turned + draw.between(-1.0, 1.0)))
        stiffness, damping = draw.between(0.1, 10.0), draw.between(0.0, 0.1)
        ends = (f"torsion {name}", before, name)
        mechanism.add_torsion_spring(*ends, stiffness, damping, rest_angle=rest, cubic=cubic)
    if draw.chance(0.3, "force"):
        force = (draw.between(-10.0, 10.0), draw.between(-10.0, 10.0))
        mechanism.add_force(f"force {name}", name, force, point(), draw.chance(0.5, "follows"))
    if draw.chance(0.3, "torque"):
        mechanism.add_torque(f"torque {name}", name, draw.between(-1.0, 1.0), reaction=before)


def _angle(mechanism: rc.Mechanism, name: str) -> float:
    return next((b.position[2] for b in mechanism.bodies if b.name == name), 0.0)


def mechanism_of(seed: int) -> tuple[rc.Mechanism, list[str]]:
    """Return the mechanism of a seed, and what is special in it."""
    draw = Draw(seed)
    mechanism = rc.Mechanism(gravity=(draw.between(-3.0, 3.0), -9.81))
    tips: list[tuple[str, Point]] = [("ground", (0.0, 0.0))]
    freedoms, pinned = 0, []
    for k in range(draw.integer(2, 7)):
        before, at = tips[-1] if draw.chance(0.7) else draw.one_of(tips)
        angle, length = draw.between(-math.pi, math.pi), draw.between(0.1, 0.5)
        tip = (at[0] + length * math.cos(angle), at[1] + length * math.sin(angle))
        name, kind = f"rod {k}", draw.one_of(KINDS)
        draw.features.append(kind)
        _rod(draw, mechanism, name, at, tip)
        _join(draw, mechanism, kind, (before, name), at)
        _load(draw, mechanism, name, before)
        freedoms += 3 - HELD[kind]
        pinned += [(before, name)] if kind == "revolute" else []
        tips.append((name, tip))
    if len(tips) > 3 and draw.chance(0.5):
        kind = draw.one_of(("revolute", "line", "distance"))
        if freedoms > HELD[kind]:
            draw.features.append("closed loop")
            freedoms -= HELD[kind]
            (other, _), (name, at) = draw.one_of(tips[:-2]), tips[-1]
            _join(draw, mechanism, kind, (other, name), at)
    if pinned and freedoms > 1 and draw.chance(0.3, "driver"):
        freedoms -= 1
        wave = rc.Sines([(draw.between(0.5, 5.0), draw.between(3.0, 20.0), 0.0)])
        mechanism.add_driver("driver", *draw.one_of(pinned), speed=wave)
    if len(tips) > 2 and freedoms > 1 and draw.chance(0.2, "gear"):
        ratio = draw.sign() * draw.between(0.5, 2.0)
        mechanism.add_gear("gear", tips[1][0], tips[2][0], ratio)
    _drop_redundant(mechanism)
    return mechanism, draw.features


def _drop_redundant(mechanism: rc.Mechanism) -> None:
    """Leave out the last joints while the joints are redundant: Exudyn needs independent ones."""
    placed = np.array([body.position for body in mechanism.bodies]).ravel()
    while mechanism.joints:
        held = Reference(mechanism).jacobian(placed, 0.0)
        if np.linalg.cond(held) < WORST_CONDITION:
            return
        mechanism.joints = mechanism.joints[:-1]


def simulated(seed: int) -> rc.Simulation:
    """Return the simulation of a seed, with random velocities that its joints admit."""
    mechanism, _ = mechanism_of(seed)
    draw, equations = Draw(-seed - 1), Reference(mechanism)
    velocity = np.array([draw.between(-1.0, 1.0) for _ in range(3 * len(mechanism.bodies))])
    placed = np.array([body.position for body in mechanism.bodies]).ravel()
    held = equations.jacobian(placed, 0.0)
    velocity -= np.linalg.pinv(held) @ (held @ velocity)
    rows = velocity.reshape(-1, 3)
    mechanism.bodies = [
        replace(body, velocity=tuple(map(float, row)))
        for body, row in zip(mechanism.bodies, rows, strict=True)
    ]
    solver = rc.Solver(method="pece", rtol=TOLERANCE, atol=TOLERANCE, max_step=1e-2)
    return rc.Simulation(mechanism, solver=solver)


def third_answer(mechanism: rc.Mechanism, span: float) -> Array:
    """Return the places and angles after `span` by SciPy and the dense equations."""
    equations = Reference(mechanism)
    start = [
        np.array([getattr(b, what) for b in mechanism.bodies]).ravel()
        for what in ("position", "velocity")
    ]
    count = len(start[0])

    def rates(t: float, y: Array) -> Array:
        return np.concatenate([y[count:], equations.solve(y[:count], y[count:], t)[0]])

    found = solve_ivp(rates, (0.0, span), np.concatenate(start), "DOP853", rtol=THIRD, atol=THIRD)
    return found.y[:count, -1].reshape(-1, 3)


@dataclass
class Compared:
    """A mechanism in both codes."""

    seed: int
    features: list[str]
    span: float = 0.0
    steps: int = 0
    difference: float = np.inf
    """Of Exudyn's answers with the last two step sizes [m, rad]."""
    distance: float = np.inf
    """Of its last answer from that of rustchain [m, rad]."""
    extrapolated: float = np.inf
    """The same, of the answers extrapolated to a step of zero."""
    moved: float = 0.0
    """Largest displacement or rotation of a body [m, rad]."""
    third: tuple[float, float] = field(default=(np.nan, np.nan))
    """Where they disagree: distances of rustchain and of Exudyn from the third answer."""

    @property
    def share(self) -> float:
        """Distance over difference, where neither is of round-off."""
        return max(self.distance - ROUNDING, 0.0) / max(self.difference, ROUNDING)

    @property
    def agrees(self) -> bool:
        """Whether the codes agree to the tolerance of Exudyn."""
        near = self.extrapolated < EXTRAPOLATED * self.difference + ROUNDING
        return near and self.difference < FINE and self.share < ALLOWED

    def __str__(self) -> str:
        told = f"seed {self.seed}: {self.span} s, moved {self.moved:.2g}, {self.steps} steps, "
        told += f"difference {self.difference:.1e}, distance {self.distance:.1e}, "
        told += f"extrapolated {self.extrapolated:.1e}"
        if not self.agrees:
            told += ", DISAGREE: from the third answer rustchain {:.1e}, Exudyn {:.1e}".format(
                *self.third
            )
        return f"{told}; {', '.join(self.features)}"


def compare(seed: int) -> Compared:
    """Return how the mechanism of a seed comes out in both codes."""
    features = mechanism_of(seed)[1]
    for span in SPANS:
        simulation = simulated(seed)
        mechanism = simulation.scene.system
        simulation.step_to(span)
        ours, before = simulation.positions, None
        placed = np.array([body.position for body in mechanism.bodies])
        compared = Compared(seed, features, span, moved=float(np.abs(ours - placed).max()))
        for compared.steps in STEPS:
            theirs = Translated(mechanism).solve(span, compared.steps)
            if before is not None:
                compared.difference = float(np.abs(theirs - before).max())
                compared.distance = float(np.abs(theirs - ours).max())
                limit = theirs + (theirs - before) / 3.0
                compared.extrapolated = float(np.abs(limit - ours).max())
                if compared.agrees:
                    return compared
            before = theirs
    third = third_answer(mechanism, span)
    compared.third = float(np.abs(ours - third).max()), float(np.abs(before - third).max())
    return compared


def main() -> int:
    """Compare the seeds asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, nargs=2, default=(0, 100), help="first, one behind")
    given = parser.parse_args()
    warnings.simplefilter(
        "ignore"
    )  # names that older versions of Exudyn need; bodies without joints
    found = []
    for seed in range(*given.seeds):
        found.append(compare(seed))
        print(found[-1], flush=True)
    worst = max(found, key=lambda c: c.distance)
    failed = [c for c in found if not c.agrees]
    loops = sum("closed loop" in c.features for c in found)
    print(
        f"{len(found)} mechanisms, {loops} with closed loops, {len(failed)} disagree; at "
        f"{SPANS[0]} s: {sum(c.span == SPANS[0] for c in found)}, the others earlier; "
        f"largest distance {worst.distance:.1e} (seed {worst.seed}), extrapolated "
        f"{max(c.extrapolated for c in found):.1e}, motions {min(c.moved for c in found):.2g} "
        f"to {max(c.moved for c in found):.2g}"
    )
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
