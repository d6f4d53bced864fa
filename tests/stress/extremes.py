"""Ten rich scenes, each with one of its numbers times 1e-9 to 1e9."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import rustchain as rc
import tree
from rustchain.description.mechanism.builder import Mechanism
from scenes import Trial

FACTORS = (1e-9, 1e-3, 1e3, 1e9)
DURATION = 4e-3  # [s]

_STEEL = rc.LankaraniNikravesh()


def published() -> rc.Scene:
    """Return the published drive with friction, lubricant, and a tensioner with all it may have."""
    drive = rc.paper_drive(pretension=100.0)
    pull = replace(
        drive.tensioner,
        stiffness=1e3,
        travel=(1e-3, 1e-3),
        damping_back=4e3,
        ratchet=1e-4,
        direction=(1.0, 0.1),
    )
    law = replace(_STEEL, friction=rc.Coulomb(0.1))
    oil = replace(law, film=rc.LubricantFilm(0.1, length=0.01))
    return rc.Scene(replace(drive, tensioner=pull), law, hinge_law=oil)


def rollers() -> rc.Scene:
    """Return a drive with rollers, elastic plates, bristles, eccentric and damaged teeth."""
    drive = rc.two_sprocket_drive(
        "ANSI 40", (17, 25), links=60, speed=20.0, torque=-5.0, rollers="bodies", plates="elastic"
    )
    teeth = rc.IsoTooth(0.5, tip_diameter=0.0745, edge_radius=2e-4, roller_diameter=0.008)
    first = replace(
        drive.sprockets[0],
        profile=teeth,
        eccentricity=5e-5,
        eccentricity_angle=0.3,
        damaged_teeth=[(3, 0.5)],
        load_inertia=1e-3,
    )
    chain = replace(drive.chain, carried=[(1, 0.1)], pitch_spread=1e-5, elongation=1e-3)
    drive = replace(drive, chain=chain, sprockets=(first, drive.sprockets[1]))
    return rc.Scene(drive, replace(_STEEL, friction=rc.LuGre(0.15, 0.1, viscous_coefficient=0.01)))


def layout() -> rc.Scene:
    """Return three sprockets with signals, a load curve and a pivoted tensioner."""
    wave = rc.Sines([(2.0, 30.0, 0.5)], offset=20.0)
    curve = ((-50.0, 3.0), (50.0, -3.0))
    sprockets = [
        rc.Sprocket(17, (0.0, 0.0), rc.PrescribedSpeed(wave)),
        rc.Sprocket(21, (0.3, 0.02), rc.AppliedTorque(rc.Table([(0.0, 0.0), (0.01, -2.0)]), curve)),
        rc.Sprocket(11, (0.15, 0.2), rc.Free(), mass=0.2, inertia=1e-4),
    ]
    pull = rc.Tensioner(50.0, 3, pivot=(0.3, 0.25), arm_inertia=1e-3)
    drive = rc.chain_drive("ISO 08B", sprockets, adjust=3, tensioner=pull)
    return rc.Scene(drive, rc.Johnson(damping="flores"), tooth_law=rc.EnhancedCylinder())


def guided() -> rc.Scene:
    """Return a drive with a blade on an arm, a rail under the plates and a smooth idler."""
    drive = rc.two_sprocket_drive("ANSI 40", (17, 17), links=60, speed=30.0, pretension=50.0)
    middle = 0.5 * drive.sprockets[1].center[0]
    plastic = rc.Material(elastic_modulus=3e9, poisson_ratio=0.4)
    arm = rc.GuideArm(
        (middle + 0.06, 0.045),
        20.0,
        stiffness=1e3,
        damping_back=1e3,
        travel=(5e-3, 0.01),
        ratchet=5e-4,
    )
    blade = rc.GuideRail((middle, 0.045), (0.0, -1.0), 0.1, 0.2, 0.004, arm, plastic)
    rail = rc.GuideRail((middle, -0.05), (0.0, 1.0), 0.1, material=plastic, plate_height=0.011)
    idler = rc.SmoothIdler(0.01, (middle - 0.04, -0.018), inertia=1e-5, material=plastic)
    return rc.Scene(replace(drive, guides=[blade, rail, idler]))


def hoist() -> rc.Scene:
    """Return an open chain over a driven wheel between two loads."""
    ends = (rc.LoadedEnd(5.0, 1e-2, arm=0.02), rc.LoadedEnd(2.0, 1e-3))
    speed = rc.SmoothStep(0.0, 0.01, 0.0, 10.0)
    wheel = rc.Sprocket(13, (0.0, 0.0), rc.PrescribedSpeed(speed), rc.StraightTooth(0.3))
    return rc.Scene(rc.open_chain("ANSI 50", ends, 30, [wheel]), start="static")


def hanging() -> rc.Scene:
    """Return a chain with single worn links between a moved anchor and one at rest."""
    rows = ((0.0, 0.0, 0.0), (2e-3, 0.2, 0.5), (4e-3, 0.0, 0.0))
    ends = (rc.AnchoredEnd((0.0, 0.0), rows), rc.AnchoredEnd((0.1, -0.02)))
    chain = rc.catalogue_chain("ISO 06B", 12)
    wear = [1e-3 * (k % 3) for k in range(12)]
    chain = replace(chain, elongation=wear, carried=[(5, 0.2)], link_stiffness=1e7)
    law = rc.LiuConformal(damping="hunt-crossley")
    return rc.Scene(rc.open_chain(chain, ends, 12), law, solver=rc.Solver("newton", 1e-6, 1e-7))


def ideal() -> rc.Scene:
    """Return a drive with ideal hinges."""
    teeth = rc.AnsiTooth("pitch-circle", tip="cut", edge_radius=3e-4)
    drive = rc.two_sprocket_drive(
        "ANSI 35", (11, 13), links=34, speed=30.0, torque=-0.5, pretension=40.0, profile=teeth
    )
    return rc.Scene(replace(drive, hinges="ideal"), rc.Linear(damping="hu-guo", stiffness=1e8))


def slider_crank() -> rc.Scene:
    """Return a slider-crank with clearance, lubricant and friction."""
    m = Mechanism()
    m.add_body("crank", 0.3, 1e-4, (0.025, 0.0, 0.0))
    m.add_body("rod", 0.5, 2e-3, (0.15, 0.0, 0.0))
    m.add_body("slider", 0.4, 1e-4, (0.25, 0.0, 0.0))
    m.add_revolute("main", "ground", "crank", at=(0.0, 0.0), friction=rc.Coulomb(0.1), radius=0.01)
    m.add_revolute("big end", "crank", "rod", at=(0.05, 0.0))
    m.add_prismatic("guide", "ground", "slider", (1.0, 0.0), at=(0.25, 0.0))
    m.add_driver("motor", "ground", "crank", speed=rc.Spline([(0.0, 50.0), (0.01, 60.0)]))
    law = replace(_STEEL, friction=rc.LuGre(0.15, 0.1), film=rc.LubricantFilm(0.05))
    surface = rc.SurfaceContact(law, 0.02, rc.Material(1e11, 0.29, 0.6), 1e-3)
    m.add_clearance_joint("wrist", "rod", "slider", 0.01005, 0.01, surface, bore_point=(0.1, 0.0))
    return rc.Scene(m)


def train() -> rc.Scene:
    """Return gears, a rack, springs, forces and a driven angle."""
    m = Mechanism(gravity=(0.5, -9.81))
    m.add_body("a", 1.0, 1e-3, velocity=(0.0, 0.0, 10.0))
    m.add_body("b", 0.5, 5e-4, (0.1, 0.0, 0.3), (0.0, 0.0, -20.0))
    m.add_body("rack", 1.0, 1e-2, (0.0, -0.05, 0.0), (0.5, 0.0, 0.0))
    m.add_body("bob", 0.2, 1e-4, (0.3, 0.1, 0.0))
    m.add_body("arm", 0.2, 1e-4, (0.0, 0.3, 0.2))
    m.add_revolute("pin a", "ground", "a", at=(0.0, 0.0))
    m.add_revolute("pin b", "ground", "b", at=(0.1, 0.0))
    m.add_gear("mesh", "a", "b", -2.0)
    m.add_prismatic("slide", "ground", "rack", (1.0, 0.0), at=(0.0, -0.05))
    m.add_rack("teeth", "rack", "a", (1.0, 0.0), 0.05)
    m.add_distance("string", "ground", "bob", point_a=(0.2, 0.3), point_b=(0.01, 0.0))
    m.add_point_on_line("slot", "ground", "arm", (1.0, 0.2), at=(0.0, 0.3))
    wave = rc.Sines([(0.3, 40.0, 0.0)], offset=0.2)
    m.add_driver("rocker", "ground", "arm", angle=wave)
    m.add_spring("spring", "bob", "rack", 200.0, 2.0, rest_length=0.2, cubic=1e3)
    m.add_torsion_spring("twist", "ground", "b", 2.0, 0.01, rest_angle=0.1)
    m.add_torque("brake", "b", by_speed=[(-50.0, 1.0), (50.0, -1.0)])
    m.add_force("push", "bob", (rc.SmoothStep(0.0, 2e-3, 0.0, 3.0), -1.0), (0.01, 0.0))
    return rc.Scene(m)


def bouncing() -> rc.Scene:
    """Return discs on an outline with linear, power and surface contacts."""
    m = Mechanism()
    m.add_body("a", 0.5, 1e-4, (0.0, 0.0203, 0.0), (0.3, -0.5, 10.0))
    m.add_body("b", 0.2, 5e-5, (0.001, 0.051, 0.0), (0.0, -0.4, 0.0))
    sides = [(0.3, 0.0), (-0.3, 0.0), (-0.3, -0.1), (0.3, -0.1)]
    floor = rc.LinearContact(1e6, 100.0, friction=rc.Coulomb(0.2, "ambrosio", 1e-2, 1e-4))
    law = rc.HuntCrossley(1e8, 1.5, 0.3)
    m.add_outline_contact(
        "floor a", "ground", "a", sides, 0.02, floor, bulges=(0.01, 0.0, 0.0, 0.0)
    )
    m.add_outline_contact("floor b", "ground", "b", sides, 0.01, floor)
    m.add_disc_contact("pair", "a", "b", 0.02, 0.01, law)
    m.add_body("pin", 0.3, 1e-4, (0.5, 0.0, 0.0), (0.1, 0.2, 0.0))
    surface = rc.SurfaceContact(rc.Hertz(damping="gonthier"), 0.01)
    m.add_clearance_joint("bore", "ground", "pin", 0.0101, 0.01, surface, bore_point=(0.5, 0.0))
    return rc.Scene(m)


RICH: tuple[Callable[[], rc.Scene], ...] = (
    published,
    rollers,
    layout,
    guided,
    hoist,
    hanging,
    ideal,
    slider_crank,
    train,
    bouncing,
)


@dataclass(frozen=True)
class Extreme:
    """A rich scene with the number at a path times a factor, or the factor in place of zero."""

    kind: str
    path: tree.Path
    factor: float

    @property
    def name(self) -> str:
        """Scene, place of the number and factor."""
        return f"{self.kind} {'.'.join(map(str, self.path))} x {self.factor:g}"

    def trial(self) -> Trial:
        """Return the scene, which may be refused."""
        make = next(make for make in RICH if make.__name__ == self.kind)
        whole = tree.tree_of(make())
        value = dict(tree.numbers(whole))[self.path]
        changed = value * self.factor if value else self.factor
        if isinstance(value, int):
            changed = math.floor(changed)
        return Trial(tree.scene_of(tree.with_value(whole, self.path, changed)), DURATION)


def jobs() -> list[Extreme]:
    """Return a job for every number of every rich scene and every factor."""
    return [
        Extreme(make.__name__, path, factor)
        for make in RICH
        for path, _ in tree.numbers(tree.tree_of(make()))
        for factor in FACTORS
    ]
