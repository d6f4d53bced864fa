"""Contact of a circle with the tooth of ANSI/ASME B29.1: three arcs and a flat on either side.

A gap has its own frame: ``v`` points radially outward, ``u`` is ``v`` turned clockwise by 90
degrees, the origin is the seat centre ``a``. The regions are counted in the direction of ``u``: 1
topping, 2 flat, 3 working, 4 seating, 5 working, 6 flat, 7 topping.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

INCH = 0.0254  # [m]
SEATING = 4


@dataclass(frozen=True)
class ToothProfile:
    """The curves of one gap; points are those of the side ``u > 0``, in the gap's frame [m].

    Attributes
    ----------
    teeth : int
        Number of teeth, N.
    roller_diameter : float
        Dr, the diameter the tooth is cut for [m].
    seat_radius : float
        Distance of the seat centre from the sprocket's centre [m].
    seating, working, topping : float
        Radii R, E and F [m].
    seating_angle, flat_angle : float
        A, where the seating curve ends, and phi = A - B, where the working curve ends [rad].
    working_center, topping_center : ndarray, shape (2,)
        Points c and b [m].
    """

    teeth: int
    roller_diameter: float
    seat_radius: float
    seating: float
    working: float
    topping: float
    seating_angle: float
    flat_angle: float
    working_center: Array
    topping_center: Array

    @property
    def gap_angle(self) -> float:
        """Angle from one gap to the next, 2 pi / N [rad]."""
        return 2.0 * np.pi / self.teeth

    @property
    def flat_normal(self) -> Array:
        """Unit normal of the flat, into the tooth, shape (2,)."""
        return np.array([np.cos(self.flat_angle), -np.sin(self.flat_angle)])

    @property
    def junctions(self) -> tuple[Array, Array, Array]:
        """Points x, y, z where seating, working, flat and topping meet, each of shape (2,) [m]."""
        along = np.array([np.cos(self.seating_angle), -np.sin(self.seating_angle)])
        x = self.seating * along
        y = self.working_center + self.working * self.flat_normal
        z = self.topping_center - self.topping * self.flat_normal
        return x, y, z

    def reach(self, radius: float) -> float:
        """Radius on the tooth's centre line where a circle touches the topping on both sides [m].

        Beyond it a circle of that ``radius`` [m] can touch no tooth.
        """
        half = np.pi / self.teeth
        line = np.array([np.sin(half), np.cos(half)])
        center = self.topping_center + np.array([0.0, self.seat_radius])
        # |rho line - center| = F + r, the outer root.
        along = float(line @ center)
        across_squared = float(center @ center) - along**2
        return along + float(np.sqrt((self.topping + radius) ** 2 - across_squared))


def pitch_radius(pitch: float, teeth: int) -> float:
    """Return the pitch radius, p / (2 sin(pi / N)) [m]."""
    return pitch / (2.0 * np.sin(np.pi / teeth))


def ansi_tooth(pitch: float, teeth: int, roller_diameter: float, seat: str) -> ToothProfile:
    """Build the tooth of ANSI/ASME B29.1 from pitch [m], tooth count and roller diameter [m].

    ``seat`` is "bottom-diameter" (the standard: a seated roller's centre is on the pitch circle
    and just touches) or "pitch-circle" (the seat centre itself is on the pitch circle).
    """
    degree = np.pi / 180.0
    dr, n = roller_diameter, teeth
    allowance = 0.0015 * INCH
    angle_a = (35.0 + 60.0 / n) * degree
    angle_b = (18.0 - 56.0 / n) * degree
    seating = 0.5025 * dr + allowance
    radius = pitch_radius(pitch, teeth)
    if seat == "bottom-diameter":
        radius += seating - 0.5 * dr  # (Ds - Dr) / 2 with Ds = 2 R
    elif seat != "pitch-circle":
        raise ValueError(seat)
    topping = 0.8 * np.cos(angle_b) + 1.4 * np.cos((17.0 - 64.0 / n) * degree) - 1.3025
    return ToothProfile(
        teeth=n,
        roller_diameter=dr,
        seat_radius=radius,
        seating=seating,
        working=1.3025 * dr + allowance,
        topping=dr * topping - allowance,
        seating_angle=angle_a,
        flat_angle=angle_a - angle_b,
        working_center=np.array([-0.8 * dr * np.cos(angle_a), 0.8 * dr * np.sin(angle_a)]),
        topping_center=np.array([1.4 * dr * np.cos(np.pi / n), -1.4 * dr * np.sin(np.pi / n)]),
    )


@dataclass(frozen=True)
class GapContact:
    """Circles against the curves of a gap, in the gap's frame.

    Attributes
    ----------
    region : ndarray of int, shape (points,)
        1 to 7.
    penetration : ndarray, shape (points,)
        Positive in contact [m].
    normal : ndarray, shape (points, 2)
        Unit direction in which the penetration grows.
    normal_radius : ndarray, shape (points,)
        Distance over which the normal turns, from the curve's centre; infinite on the flat [m].
    """

    region: Integers
    penetration: Array
    normal: Array
    normal_radius: Array


def circle_in_gap(profile: ToothProfile, points: Array, radius: float) -> GapContact:
    """Contact of circles of ``radius`` [m] about ``points`` (points, 2) [m] with their gap.

    The region is the one whose curve has its normal through the circle's centre: the junctions are
    tangent, so the normals at x, y and z part the plane.
    """
    side = np.where(points[:, 0] >= 0.0, 1.0, -1.0)
    p = points * np.stack([side, np.ones_like(side)], axis=1)  # mirrored onto u >= 0

    sin_a, cos_a = np.sin(profile.seating_angle), np.cos(profile.seating_angle)
    normal_flat = profile.flat_normal
    upward = np.array([-normal_flat[1], normal_flat[0]])  # along the flat, towards the tip
    _, _, z = profile.junctions

    past_x = p @ np.array([sin_a, cos_a]) > 0.0
    past_y = (p - profile.working_center) @ upward > 0.0
    past_z = (p - z) @ upward > 0.0
    step = past_x.astype(np.int64) + (past_x & past_y) + (past_x & past_y & past_z)

    penetration = np.empty(len(p))
    normal = np.empty_like(p)
    normal_radius = np.full(len(p), np.inf)

    seated = step == 0
    distance = np.hypot(p[seated, 0], p[seated, 1])
    normal_radius[seated] = distance
    penetration[seated] = distance - (profile.seating - radius)
    normal[seated] = _unit(p[seated], distance)

    on_working = step == 1
    offset = p[on_working] - profile.working_center
    distance = np.hypot(offset[:, 0], offset[:, 1])
    normal_radius[on_working] = distance
    penetration[on_working] = distance - (profile.working - radius)
    normal[on_working] = _unit(offset, distance)

    on_flat = step == 2
    penetration[on_flat] = (p[on_flat] - z) @ normal_flat + radius
    normal[on_flat] = normal_flat

    on_topping = step == 3
    offset = profile.topping_center - p[on_topping]
    distance = np.hypot(offset[:, 0], offset[:, 1])
    normal_radius[on_topping] = distance
    penetration[on_topping] = (profile.topping + radius) - distance
    normal[on_topping] = _unit(offset, distance)

    normal[:, 0] *= side
    region = SEATING + side.astype(np.int64) * step
    return GapContact(region, penetration, normal, normal_radius)


def point_touching(profile: ToothProfile, region: int, fraction: float, radius: float) -> Array:
    """Centre of a circle that just touches a region, in the gap's frame, shape (2,) [m].

    ``fraction`` runs from 0 to 1 through the region in the direction of rising ``|u|`` (through
    the seating region: of rising ``u``).
    """
    a, phi = profile.seating_angle, profile.flat_angle
    step = abs(region - SEATING)
    _, y, z = profile.junctions
    if step == 0:
        angle = -np.pi + a + fraction * (np.pi - 2.0 * a)
        point = (profile.seating - radius) * np.array([np.cos(angle), np.sin(angle)])
        return np.asarray(point, dtype=np.float64)
    if step == 1:
        angle = -a + fraction * (a - phi)
        along = np.array([np.cos(angle), np.sin(angle)])
        point = profile.working_center + (profile.working - radius) * along
    elif step == 2:
        point = y + fraction * (z - y) - radius * profile.flat_normal
    else:
        # From the flat's end to the tooth's centre line.
        half = np.pi / profile.teeth
        rho = profile.reach(radius)
        tip = rho * np.array([np.sin(half), np.cos(half)]) - np.array([0.0, profile.seat_radius])
        away = tip - profile.topping_center
        last = np.arctan2(away[1], away[0])
        angle = np.pi - phi + fraction * (last - (np.pi - phi))
        along = np.array([np.cos(angle), np.sin(angle)])
        point = profile.topping_center + (profile.topping + radius) * along
    return np.asarray(point * np.array([np.sign(region - SEATING), 1.0]), dtype=np.float64)


@dataclass(frozen=True)
class SprocketContact:
    """Circles against a whole sprocket, in the frame of the scene.

    Attributes
    ----------
    near : ndarray of bool, shape (points,)
        Within the reach of the teeth.
    gap : ndarray of int, shape (points,)
        The nearest gap in angle, 0 to N - 1; -1 where not near.
    region : ndarray of int, shape (points,)
        1 to 7; 0 where not near.
    penetration : ndarray, shape (points,)
        [m]; -inf where not near.
    normal : ndarray, shape (points, 2)
        Unit direction in which the penetration grows; zero where not near.
    normal_radius : ndarray, shape (points,)
        Distance over which the normal turns [m]; infinite on a flat and where not near.
    """

    near: NDArray[np.bool_]
    gap: Integers
    region: Integers
    penetration: Array
    normal: Array
    normal_radius: Array


def circle_on_sprocket(
    profile: ToothProfile, center: Array, angle: float, points: Array, radius: float
) -> SprocketContact:
    """Contact of circles about ``points`` (points, 2) [m] with a sprocket at ``center``, ``angle``.

    Gap g lies at the body angle g 2 pi / N, counterclockwise from the sprocket's x axis.
    """
    arm = points - center
    near = np.hypot(arm[:, 0], arm[:, 1]) < profile.reach(radius)
    bearing = np.arctan2(arm[:, 1], arm[:, 0]) - angle
    gap = np.rint(bearing / profile.gap_angle).astype(np.int64) % profile.teeth

    gap_direction = angle + gap * profile.gap_angle
    outward = np.stack([np.cos(gap_direction), np.sin(gap_direction)], axis=1)
    sideways = np.stack([outward[:, 1], -outward[:, 0]], axis=1)
    local = np.stack(
        [np.sum(arm * sideways, axis=1), np.sum(arm * outward, axis=1) - profile.seat_radius],
        axis=1,
    )
    contact = circle_in_gap(profile, local, radius)
    normal = contact.normal[:, :1] * sideways + contact.normal[:, 1:] * outward
    return SprocketContact(
        near=near,
        gap=np.where(near, gap, -1),
        region=np.where(near, contact.region, 0),
        penetration=np.where(near, contact.penetration, -np.inf),
        normal=np.where(near[:, None], normal, 0.0),
        normal_radius=np.where(near & (contact.normal_radius > 0.0), contact.normal_radius, np.inf),
    )


def _unit(vectors: Array, lengths: Array) -> Array:
    """Divide vectors (n, 2) by their lengths (n,); zero vectors stay zero."""
    safe = np.where(lengths > 0.0, lengths, 1.0)
    return vectors / safe[:, None]
