"""A pin that bounces in a fixed bore: free flights in closed form, impacts integrated to round-off.

Between two impacts the centre of the pin moves along a parabola; the next impact begins at a root
of the polynomial of fourth degree |p + v t + g t^2 / 2|^2 = c^2, for the clearance c. During an
impact the force F = K d^1.5 max(0, 1 + lambda d' / d'_0) acts along the line of centres, with the
initial impact velocity d'_0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from reference.force_law import Pair, effective_modulus, hertz_stiffness, lankarani_nikravesh_factor

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Bounce:
    """One impact: its onset [s], initial impact velocity [m/s], end [s], and the state there."""

    onset: float
    speed: float
    end: float
    place: Array
    velocity: Array


@dataclass(frozen=True)
class Bore:
    """A pin in a bore of the ground; lengths [m], mass [kg], gravity [m/s^2] downwards."""

    clearance: float
    pin_radius: float
    mass: float
    material: object
    length: float = 0.01
    floor: float = 1e-3
    gravity: float = 9.81

    def bounces(self, place: Array, velocity: Array, count: int) -> list[Bounce]:
        """Return the first impacts of a pin that starts apart."""
        found: list[Bounce] = []
        time, p, v = 0.0, np.asarray(place, float), np.asarray(velocity, float)
        for _ in range(count):
            bounce = self._impact(time, p, v)
            found.append(bounce)
            time, p, v = bounce.end, bounce.place, bounce.velocity
        return found

    def flight(self, place: Array, velocity: Array) -> float:
        """Return the time [s] from a place apart, or just parting, to the next onset."""
        p, v, g = place, velocity, np.array([0.0, -self.gravity])
        powers = [g @ g / 4, g @ v, v @ v + g @ p, 2 * p @ v, p @ p - self.clearance**2]
        if abs(powers[-1]) < 1e-3 * self.clearance**2:  # it parts here: a root at zero
            powers.pop()
        scale = self.clearance / np.linalg.norm(v)  # of times, so that roots are about one
        orders = np.arange(len(powers))[::-1]
        roots = np.roots(np.array(powers) * scale**orders) * scale
        real = roots[np.abs(roots.imag) < 1e-9 * np.abs(roots)].real
        return float(min(t for t in real if t > 0.0))

    def _impact(self, time: float, place: Array, velocity: Array) -> Bounce:
        g = np.array([0.0, -self.gravity])
        flight = self.flight(place, velocity)
        p = place + flight * velocity + flight**2 / 2 * g
        v = velocity + flight * g
        bore = self.clearance + self.pin_radius
        modulus = effective_modulus(self.material)
        stiffness = hertz_stiffness(Pair(True, self.pin_radius, bore, self.length, modulus))
        factor = lankarani_nikravesh_factor(self.material.restitution)
        speed = p @ v / np.linalg.norm(p)
        onset = max(speed, self.floor)

        def slope(_: float, y: Array) -> Array:
            distance = np.hypot(y[0], y[1])
            normal = y[:2] / distance
            depth = max(distance - self.clearance, 0.0)
            force = stiffness * depth**1.5 * max(0.0, 1.0 + factor * (normal @ y[2:]) / onset)
            return np.concatenate([y[2:], g - force / self.mass * normal])

        def parts(_: float, y: Array) -> float:
            return float(np.hypot(y[0], y[1]) - self.clearance)

        parts.terminal, parts.direction = True, -1  # type: ignore[attr-defined]
        # Hertz's time of contact, 2.94 d / v at the largest depth d.
        depth = (1.25 * self.mass * speed**2 / stiffness) ** 0.4
        span = 100.0 * depth / speed
        run = solve_ivp(
            slope,
            (0.0, span),
            np.concatenate([p, v]),
            "DOP853",
            events=parts,
            rtol=1e-11,
            atol=[1e-16, 1e-16, 1e-13, 1e-13],
        )
        end = time + flight + run.t[-1]
        return Bounce(time + flight, float(speed), end, run.y[:2, -1], run.y[2:, -1])
