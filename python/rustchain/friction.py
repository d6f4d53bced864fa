"""Friction laws as values, and how they join the normal force laws."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from rustchain._description import Description
from rustchain._names import known_keywords

Regularization = Literal["tanh", "threlfall", "ambrosio"]


@known_keywords
@dataclass(frozen=True)
class Coulomb(Description):
    """Coulomb's friction made a function of the slip speed; none sticks, what would stick creeps.

    Attributes
    ----------
    coefficient : float
        Friction force over normal force at full slip.
    regularization : {"tanh", "threlfall", "ambrosio"}
        How the force grows with the slip speed v. "tanh": tanh(v/speed), smooth. "threlfall":
        1 - exp(-3 v/speed) up to `speed`, and what it is there, 0.950, above (Threlfall 1978).
        "ambrosio": zero up to `dead_speed`, then a straight line to one at `speed` (Ambrosio 2003).
    speed : float
        Slip speed at which friction is (nearly) full [m/s].
    dead_speed : float
        Slip speed up to which there is none [m/s]; of "ambrosio" alone.
    """

    coefficient: float
    regularization: Regularization = "tanh"
    speed: float = 1e-3
    dead_speed: float = 0.0
