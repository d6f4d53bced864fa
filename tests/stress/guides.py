"""Random guides beside the strands of two sprockets: rails, blades and smooth idlers."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import rustchain as rc
from draw import Draw


@dataclass(frozen=True)
class Strands:
    """Two straight strands between two sprockets."""

    distance: float
    angle: float
    radii: tuple[float, float]  # of the pitch circles
    pitch: float
    roller: float  # radius

    @property
    def mean(self) -> float:
        """Mean of the radii [m]: where the strands are half-way."""
        return 0.5 * sum(self.radii)

    @property
    def slope(self) -> float:
        """Sine of the angle between a strand and the line of centres."""
        return abs(self.radii[0] - self.radii[1]) / self.distance


def guides(draw: Draw, strands: Strands) -> list[rc.GuideRail | rc.SmoothIdler]:
    """Return one guide, or one at each strand."""
    sides = (1, -1) if draw.chance(0.2, "two guides") else (draw.sign(),)
    return [_guide(draw, strands, side) for side in sides]


def _guide(draw: Draw, strands: Strands, side: int) -> rc.GuideRail | rc.SmoothIdler:
    """Return a rail or a blade outside one strand, or a smooth idler inside it."""
    mean, distance = strands.mean, strands.distance
    # Direction of the line of centres, and outward across the strand.
    ux, uy = math.cos(strands.angle), math.sin(strands.angle)
    nx, ny = -side * uy, side * ux
    plastic = rc.Material(elastic_modulus=draw.log_between(3e8, 1e10), poisson_ratio=0.4)
    material = plastic if draw.chance(0.5) else None
    plates = 0.9 * strands.pitch if draw.chance(0.3, "on the plates") else None

    def beside(gap: float) -> tuple[float, float]:
        return (0.5 * distance * ux + gap * nx, 0.5 * distance * uy + gap * ny)

    if draw.chance(0.3, "smooth idler"):
        inertia = draw.one_of((None, draw.log_between(1e-6, 1e-3)))
        radius = mean * draw.between(0.2, 0.4)
        center = beside(mean * draw.between(0.6, 0.95) - radius)
        return rc.SmoothIdler(radius, center, inertia, material, plates)
    draw.features.append("rail")
    length = draw.between(0.2, 0.5) * distance
    radius = draw.one_of((None, length * draw.between(1.0, 4.0)))
    end_radius = draw.one_of((0.005, draw.between(0.1, 0.5) * strands.pitch))
    if draw.chance(0.1, "hollow rail"):
        radius = -length * draw.between(2.0, 10.0)
    # Where it just touches the strand, which lies askew along it.
    half = 0.5 * (plates or 2.0 * strands.roller)
    arch = 0.0 if radius is None else abs(length**2 / (8.0 * radius))
    clear = mean + half + end_radius + arch + 0.5 * length * strands.slope
    if draw.chance(0.5, "blade"):
        center = beside(clear - draw.between(-0.1, 0.3) * strands.pitch)
        pivot = (center[0] + 0.6 * length * ux, center[1] + 0.6 * length * uy)
        arm = _arm(draw, pivot)
    else:
        center, arm = beside(clear + draw.log_between(1e-5, 1e-2)), None
    return rc.GuideRail(center, (-nx, -ny), length, radius, end_radius, arm, material, plates)


def _arm(draw: Draw, pivot: tuple[float, float]) -> rc.GuideArm:
    """Return an arm with a plunger, often with spring, stops, ratchet or check valve."""
    arm = rc.GuideArm(pivot, force=draw.log_between(1.0, 100.0))
    if draw.chance(0.5, "arm of its own"):
        arm = replace(
            arm,
            ramp_time=draw.log_between(1e-3, 0.3),
            stiffness=draw.one_of((0.0, draw.log_between(100.0, 1e5))),
            damping=draw.one_of((0.0, draw.log_between(1.0, 1e4))),
            damping_back=draw.one_of((None, draw.log_between(100.0, 1e5))),
            travel=draw.one_of((None, (draw.log_between(1e-4, 1e-2), 0.01))),
            inertia=draw.log_between(1e-6, 1e-2),
            ratchet=draw.one_of((None, 0.0, draw.log_between(1e-4, 5e-3))),
        )
    return arm
