"""Other units than those of the SI, converted."""

from __future__ import annotations

import math

from rustchain.arguments import checked


@checked
def rpm(speed: float) -> float:
    """Return a speed in revolutions per minute as an angular velocity [rad/s].

    Parameters
    ----------
    speed : float
        [1/min], counterclockwise positive.

    Examples
    --------
    >>> round(rc.rpm(1500), 3)
    157.08
    """
    return speed * math.tau / 60.0
