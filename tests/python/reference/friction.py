"""Friction at a point of contact of two bodies: of the slip speed, or of bristles."""

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


def bent(law: Any, deflection: Array, slip: Array) -> tuple[Array, Array]:
    """Friction over normal force of bristles bent so far, and its slope with the slip [s/m]."""
    speed = np.abs(slip)
    fall = np.exp(-((speed / law.stribeck_speed) ** law.stribeck_exponent))
    spread = law.static_coefficient - law.kinetic_coefficient
    limit = law.kinetic_coefficient + spread * fall
    rate = slip - law.stiffness * speed * deflection / limit
    damping = law.damping / (1.0 + 0.25 * law.damping * speed / limit)
    part = law.stiffness * deflection + damping * rate + law.viscous_coefficient * slip
    # No steeper: bristles, held, relax by their deflection over the limit, which falls at most so.
    steep = 2.0 * law.stribeck_exponent * spread / limit
    held = 1.0 + law.stiffness * np.abs(deflection) / limit * (1.0 + steep)
    fading = law.damping / limit * np.abs(rate) * (1.0 + steep)
    return part, damping * (held + fading) + law.viscous_coefficient


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
    deflection: Array | None = None,
) -> Friction:
    """Friction of contacts.

    Parameters
    ----------
    law : Coulomb description, or a LuGre one
    normals : ndarray, (contacts, 2)
        Directions of the contacts.
    seen : ndarray, (contacts, 2)
        Velocity of the first bodies' material points, seen from the second's [m/s].
    normal : (ndarray, ndarray), (contacts,)
        Normal forces and what round-off may do to them [N].
    errors : (float, float, ndarray)
        Of lengths [m] and speeds [m/s]; distances that normals come from [m].
    deflection : ndarray, (contacts,), optional
        Of bristles [m].
    """
    force, force_bound = normal
    delta_x, delta_v, distance = errors
    across = np.stack([-normals[:, 1], normals[:, 0]], axis=1)
    slip = np.sum(across * seen, axis=1)
    if hasattr(law, "stiffness"):
        coefficient = 1.0
        part, slope = bent(law, np.zeros_like(slip) if deflection is None else deflection, slip)
    else:
        coefficient = law.coefficient
        part, slope = share(law, slip)
    size = coefficient * force * part
    turned = delta_x / np.maximum(distance, delta_x)
    slip_error = 4.0 * delta_v + np.hypot(seen[:, 0], seen[:, 1]) * turned
    # The share itself is a difference from one near rest.
    bound = coefficient * (
        force_bound * np.abs(part) + force * (slope * slip_error + turned + 1e-15)
    )
    return Friction(-size[:, None] * across, bound, size * slip)
