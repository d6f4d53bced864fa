"""Regularised Coulomb friction at a point of contact of two bodies, from its description."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


class Friction(NamedTuple):
    """Friction on the first bodies, shape (contacts, 2) [N], and what round-off may do to it.

    ``power`` is what it dissipates, (contacts,) [W].
    """

    force: Array
    bound: Array
    power: Array


def share(law: Any, slip: Array) -> tuple[Array, Array]:
    """Share of mu F_n at a slip speed [m/s], with its sign, and its slope [s/m]."""
    speed = np.abs(slip)
    if law.regularization == "tanh":
        part = np.tanh(speed / law.speed)
        slope = (1.0 - part**2) / law.speed
    elif law.regularization == "threlfall":
        part = -np.expm1(-3.0 * np.minimum(speed / law.speed, 1.0))
        slope = np.where(speed < law.speed, 3.0 * (1.0 - part) / law.speed, 0.0)
    else:
        width = law.speed - law.dead_speed
        part = np.clip((speed - law.dead_speed) / width, 0.0, 1.0)
        slope = np.where((part > 0.0) & (part < 1.0), 1.0 / width, 0.0)
    return np.sign(slip) * part, slope


def point_velocity(positions: Array, velocities: Array, bodies: Integers, points: Array) -> Array:
    """Velocity of the material points of bodies that are at ``points`` now, (contacts, 2)."""
    arms = points - positions[bodies, :2]
    turned = np.stack([-arms[:, 1], arms[:, 0]], axis=1)
    return np.asarray(velocities[bodies, :2] + velocities[bodies, 2:] * turned)


def coulomb(
    law: Any,
    normals: Array,
    seen: Array,
    normal: tuple[Array, Array],
    errors: tuple[float, float, Array],
) -> Friction:
    """Friction of contacts.

    Parameters
    ----------
    law : Coulomb description
    normals : ndarray, (contacts, 2)
        Directions of the contacts.
    seen : ndarray, (contacts, 2)
        Velocity of the first bodies' material points, seen from the second's [m/s].
    normal : (ndarray, ndarray), (contacts,)
        Normal forces and what round-off may do to them [N].
    errors : (float, float, ndarray)
        Of lengths [m] and speeds [m/s]; distances that normals come from [m].
    """
    force, force_bound = normal
    delta_x, delta_v, distance = errors
    across = np.stack([-normals[:, 1], normals[:, 0]], axis=1)
    slip = np.sum(across * seen, axis=1)
    part, slope = share(law, slip)
    size = law.coefficient * force * part
    turned = delta_x / np.maximum(distance, delta_x)
    slip_error = 4.0 * delta_v + np.hypot(seen[:, 0], seen[:, 1]) * turned
    # The share itself is a difference from one near rest.
    bound = law.coefficient * (
        force_bound * np.abs(part) + force * (slope * slip_error + turned + 1e-15)
    )
    return Friction(-size[:, None] * across, bound, size * slip)
