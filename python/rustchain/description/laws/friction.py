"""Friction laws as values."""

from __future__ import annotations

from typing import Literal

from rustchain.description.base import Description, description

Regularization = Literal["tanh", "threlfall", "ambrosio"]


@description(frozen=True)
class Coulomb(Description):
    """Regularised Coulomb friction, a function of the sliding velocity; it permits creep.

    Attributes
    ----------
    coefficient : float
        Friction force over normal force at full slip.
    regularization : {"tanh", "threlfall", "ambrosio"}
        Dependence of the force on the sliding velocity v. "tanh": tanh(v/speed), smooth.
        "threlfall": 1 - exp(-3 v/speed) up to `speed`, constant above, 0.950 (Threlfall 1978).
        "ambrosio": zero up to `dead_speed`, then a straight line to one at `speed` (Ambrosio 2003).
    speed : float
        Sliding velocity at which the friction force reaches, or nearly reaches, its full value
        [m/s].
    dead_speed : float
        Sliding velocity up to which there is no friction [m/s]; for "ambrosio" only.

    Examples
    --------
    >>> rc.LankaraniNikravesh(friction=rc.Coulomb(0.1)).friction
    Coulomb(coefficient=0.1)
    """

    coefficient: float
    regularization: Regularization = "tanh"
    speed: float = 1e-3
    dead_speed: float = 0.0


@description(frozen=True)
class LuGre(Description):
    """LuGre friction: bristles bend before they slip. A contact can stick.

    With f the normal force, s the sliding velocity and z the deflection of the bristles of a
    contact::

        dz/dt = s - stiffness |s| z / g(s)
        F = f (stiffness z + damping' dz/dt + viscous_coefficient s)
        g(s) = kinetic_coefficient + (static_coefficient - kinetic_coefficient) b(s)
        b(s) = exp(-(|s|/stribeck_speed)^stribeck_exponent)
        damping' = damping / (1 + damping |s| / (4 g)), so that F never drives

    (Canudas de Wit, Olsson, Astrom and Lischinsky 1995; in proportion to the normal force:
    Canudas de Wit and Tsiotras 1999).

    Attributes
    ----------
    static_coefficient : float
        Static friction: largest friction force at rest over the normal force.
    kinetic_coefficient : float
        Kinetic friction: friction force at full slip over the normal force.
    stiffness : float
        Stiffness of the bristles over the normal force [1/m]. The deflection before slip is
        static_coefficient / stiffness.
    damping : float
        Damping of the bristles at rest over the normal force [s/m].
    viscous_coefficient : float
        Friction force proportional to the sliding velocity, over the normal force [s/m].
    stribeck_speed : float
        Sliding velocity about which friction falls from the static to the kinetic coefficient
        [m/s].
    stribeck_exponent : float
        Exponent of that fall, 0.1 to 10: 2 in the first form of the law, 0.5 to 1 for other
        materials.

    Examples
    --------
    >>> rc.Hertz(friction=rc.LuGre(0.12, 0.1)).friction
    LuGre(static_coefficient=0.12, kinetic_coefficient=0.1)
    """

    static_coefficient: float
    kinetic_coefficient: float
    stiffness: float = 1e5
    damping: float = 0.3
    viscous_coefficient: float = 0.0
    stribeck_speed: float = 1e-3
    stribeck_exponent: float = 2.0
