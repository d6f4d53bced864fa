"""Accelerations and contacts of one state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rustchain.names import named_attributes
from rustchain.typing import Array


@named_attributes
@dataclass(frozen=True, eq=False)
class Evaluation:
    """Accelerations and contacts of one state.

    Attributes
    ----------
    accelerations : ndarray, (bodies, 3)
        Accelerations [m/s^2, m/s^2, rad/s^2].
    hinge_force, hinge_penetration : ndarray, (hinges,)
        Normal force [N] and penetration [m] of each hinge; penetration is negative when apart.
    hinge_force_vector : ndarray, (hinges, 2)
        Force on the pin, friction and all [N].
    tooth_force, tooth_penetration : ndarray, (bushings, sprockets)
        Normal force [N] and penetration [m] of each bushing; penetration is -inf when not near.
    tooth_force_vector : ndarray, (bushings, sprockets, 2)
        Force on the bushing, friction and all [N].
    tooth_region, tooth_index : ndarray of int, (bushings, sprockets)
        Region of the gap in contact, counted from 1 along its outline (0: none; an ANSI gap has
        seven, the fourth is the seat), and the gap, from 0 (-1: none).
    roller_force, roller_penetration : ndarray, (rollers,), optional
        Normal force [N] and penetration [m] of bushings in rollers, where those are bodies.
    roller_force_vector : ndarray, (rollers, 2), optional
        Force of the bushing on the roller, friction and all [N].
    hinge_bristle : ndarray, (hinges,), optional
    tooth_bristle : ndarray, (bushings, sprockets), optional
    roller_bristle : ndarray, (rollers,), optional
        How far bristles are bent, where friction is `LuGre` [m]; zero at positions that are given.
    """

    accelerations: Array
    hinge_force: Array
    hinge_penetration: Array
    hinge_force_vector: Array
    tooth_force: Array
    tooth_penetration: Array
    tooth_force_vector: Array
    tooth_region: npt.NDArray[np.int32]
    tooth_index: npt.NDArray[np.int32]
    roller_force: Array | None = None
    roller_penetration: Array | None = None
    roller_force_vector: Array | None = None
    hinge_bristle: Array | None = None
    tooth_bristle: Array | None = None
    roller_bristle: Array | None = None
