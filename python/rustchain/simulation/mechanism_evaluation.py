"""What one evaluation of a mechanism's equations gives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rustchain.names import named_attributes
from rustchain.typing import Array


@named_attributes
@dataclass(frozen=True, eq=False)
class MechanismEvaluation:
    """Accelerations, reactions and contacts of one state.

    Attributes
    ----------
    accelerations : ndarray, (bodies, 3)
        [m/s^2, m/s^2, rad/s^2].
    joint_reaction : ndarray, (joints, 3)
        Force and torque on body b about the joint's point [N, N, N m].
    contact_force, contact_penetration : ndarray, (contacts,)
        [N] and [m].
    contact_force_vector : ndarray, (contacts, 2)
        Force on the circle [N].
    contact_gap, contact_region : ndarray of int, (contacts,)
        Of circles near teeth the gap, from 0 (-1: none), and its region, counted from 1 along its
        outline (0: none; an ANSI gap has seven).
    """

    accelerations: Array
    joint_reaction: Array
    contact_force: Array
    contact_penetration: Array
    contact_force_vector: Array
    contact_gap: npt.NDArray[np.int32]
    contact_region: npt.NDArray[np.int32]
