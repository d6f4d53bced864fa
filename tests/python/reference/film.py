"""Lubricant in hinges: the pressure of a long bearing, integrated where it is positive."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Gauss-Legendre, in a variable that spreads the places where the film is thin.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(200)


class Lubricant(NamedTuple):
    """What a film does to the one body, with what round-off may do to it.

    ``force`` and ``bound`` [N], (hinges, 2) and (hinges,); ``shear``, torque over the other body's
    spin seen from it [N m s]; ``power`` dissipated [W], both (hinges,).
    """

    force: Array
    bound: Array
    shear: Array
    power: Array


def _weight(law: Any, ratio: Array) -> Array:
    """What the hand-over to dry contact leaves of the film."""
    part = np.clip((1.0 - ratio) / (1.0 - law.handover), 0.0, 1.0)
    return part**3 * (10.0 - 15.0 * part + 6.0 * part**2)


def _force(law: Any, hinge: Any, length: float, offset: Array, velocity: Array) -> Array:
    """Force on the eccentric body in the plane, shapes (hinges, 2)."""
    clearance = hinge.bore_radius - hinge.pin_radius
    distance = np.hypot(offset[:, 0], offset[:, 1])
    far = np.where(distance > 0.0, distance, 1.0)[:, None]
    along = np.where(distance[:, None] > 0.0, offset / far, [1.0, 0.0])
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    ratio = np.minimum(distance / clearance, 1.0)
    weight = _weight(law, ratio)
    wet = np.where(weight > 0.0, ratio, 0.0)[:, None]
    radial = np.sum(velocity * along, axis=1)[:, None]
    tangential = np.sum(velocity * across, axis=1)[:, None]
    slanted = 2.0 * tangential / (2.0 + wet**2)
    scale = 6.0 * law.viscosity * hinge.pin_radius**2 / clearance**3
    narrow = np.sqrt((1.0 - wet) * (1.0 + wet)) + 1e-12

    def half(middle: Array) -> tuple[Array, Array]:
        """Of the half of the pressure about ``middle``, along and across."""
        first, last = (np.arcsinh((middle + side) / narrow) for side in (-0.5 * np.pi, 0.5 * np.pi))
        spread = 0.5 * (first + last) + 0.5 * (last - first) * _POINTS
        angle = narrow * np.sinh(spread)
        spacing = 0.5 * (last - first) * narrow * np.cosh(spread) * _WEIGHTS
        cos, sin = np.cos(angle), np.sin(angle)
        thin = (1.0 - wet) + 2.0 * wet * np.sin(0.5 * angle) ** 2
        pressure = scale * (1.0 + thin) / thin**2 * (radial * cos + slanted * sin)
        area = spacing * length * hinge.pin_radius * weight[:, None]
        push = -np.sum(pressure * cos * area, axis=1)[:, None]
        return push, -np.sum(pressure * sin * area, axis=1)[:, None]

    positive = half(np.arctan2(slanted, radial))
    negative = half(np.arctan2(-slanted, -radial))
    weak = law.tension / np.maximum(
        np.hypot(law.tension, scale * np.hypot(radial, slanted)), 1e-300
    )
    push, drag = (p + weak * n for p, n in zip(positive, negative, strict=True))
    return np.asarray(push * along + drag * across)


def lubricant(
    law: Any,
    hinge: Any,
    length: float,
    offset: Array,
    velocity: Array,
    spins: tuple[Array, Array],
    errors: tuple[float, float],
) -> Lubricant:
    """LubricantFilm of all hinges.

    Parameters
    ----------
    law : LubricantFilm description
    hinge : ClearanceHinge description
    length : float
        Length of contact [m].
    offset, velocity : ndarray, (hinges, 2)
        Of the one body's centre seen from the other's [m], [m/s].
    spins : (ndarray, ndarray), (hinges,)
        Of the one body and of the other [rad/s].
    errors : (float, float)
        Of lengths [m] and speeds [m/s].
    """
    length = length if law.length is None else law.length
    clearance = hinge.bore_radius - hinge.pin_radius
    mean = 0.5 * (spins[0] + spins[1])[:, None]
    seen = velocity - mean * np.stack([-offset[:, 1], offset[:, 0]], axis=1)

    def force(of: Array, at: Array) -> Array:
        return _force(law, hinge, length, of, at)

    found = force(offset, seen)
    bound = 1e-12 * np.hypot(found[:, 0], found[:, 1])
    for axis in np.eye(2):
        step = 1e-5 * clearance * axis
        moved = (force(offset + step, seen) - force(offset - step, seen)) / (2e-5 * clearance)
        speed = 1e-6 * axis
        faster = (force(offset, seen + speed) - force(offset, seen - speed)) / 2e-6
        slip = errors[1] + np.abs(mean[:, 0]) * errors[0]
        bound += np.hypot(*moved.T) * errors[0] + np.hypot(*faster.T) * slip
    ratio = np.minimum(np.hypot(offset[:, 0], offset[:, 1]) / clearance, 1.0)
    weight = _weight(law, ratio)
    around = np.sqrt(np.where(weight > 0.0, 1.0 - ratio**2, 1.0))
    scale = 2.0 * np.pi * law.viscosity * length * hinge.pin_radius**3 / clearance
    shear = scale * weight / around
    power = shear * (spins[1] - spins[0]) ** 2 - np.sum(found * seen, axis=1)
    return Lubricant(found, bound, shear, np.asarray(power))
