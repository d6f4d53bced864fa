"""Other units than those of the SI, converted."""

from __future__ import annotations

import math
from typing import overload

import numpy as np
import numpy.typing as npt

from rustchain.arguments import checked
from rustchain.typing import Array, Number


@overload
def rpm(speed: Number) -> float: ...
@overload
def rpm(speed: npt.ArrayLike) -> Array: ...
@checked
def rpm(speed: npt.ArrayLike) -> float | Array:
    """Return a speed in revolutions per minute as an angular velocity [rad/s].

    Parameters
    ----------
    speed : float or array_like
        [1/min], counterclockwise positive.

    Examples
    --------
    >>> round(rc.rpm(1500), 3)
    157.08
    """
    converted = np.asarray(speed, dtype=np.float64) * math.tau / 60.0
    return converted if converted.ndim else float(converted)
