"""Accelerations and contacts of one state."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from rustchain.names import named_attributes
from rustchain.results.values import ArrayValue, read_only
from rustchain.typing import Array


@named_attributes
class Evaluation(ArrayValue):
    """Accelerations and contacts of one state; its arrays are those that the scene has.

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
        Region in contact, counted from 1 along the outline of the gap (0: none), and the gap, from
        0 (-1: none). An ANSI gap has seven regions; the fourth is the seat.
    roller_force, roller_penetration : ndarray, (rollers,), optional
        Normal force [N] and penetration [m] of bushings in rollers, where those are bodies.
    roller_force_vector : ndarray, (rollers, 2), optional
        Force of the bushing on the roller, friction and all [N].
    hinge_bristle : ndarray, (hinges,), optional
    tooth_bristle : ndarray, (bushings, sprockets), optional
    roller_bristle : ndarray, (rollers,), optional
        Deflection of the bristles, where friction is `LuGre` [m]; zero at positions that are given.
    joint_reaction : ndarray, (joints, 3)
        Of mechanisms: force and torque on body b about the joint's point [N, N, N m].
    contact_force, contact_penetration : ndarray, (contacts,)
        Of mechanisms: normal force [N] and penetration [m].
    contact_force_vector : ndarray, (contacts, 2)
        Of mechanisms: force on the circle [N].
    contact_gap, contact_region : ndarray of int, (contacts,)
        Of mechanisms, of circles near teeth: the gap, from 0 (-1: none), and its region. Regions
        count from 1 along its outline (0: none); an ANSI gap has seven.

    Examples
    --------
    >>> simulation = rc.Simulation(rc.paper_drive())
    >>> found = simulation.evaluate()
    >>> found.accelerations.shape, found.tooth_force.shape
    ((40, 3), (38, 2))
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
    joint_reaction: Array
    contact_force: Array
    contact_penetration: Array
    contact_force_vector: Array
    contact_gap: npt.NDArray[np.int32]
    contact_region: npt.NDArray[np.int32]

    def __init__(self, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
        self.__dict__.update({name: read_only(array) for name, array in arrays.items()})

    def __setattr__(self, name: str, value: object) -> None:
        """Refuse: an evaluation is a value."""
        msg = f"Evaluation.{name}: cannot be set"
        raise AttributeError(msg)
