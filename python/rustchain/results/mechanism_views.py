"""One body, joint or contact of a mechanism over time."""

from __future__ import annotations

from dataclasses import dataclass

from rustchain.names import named_attributes
from rustchain.results.values import ArrayValue
from rustchain.typing import Array, IntArray


@named_attributes
@dataclass(frozen=True, eq=False)
class BodyMotion(ArrayValue):
    """One body over time.

    Attributes
    ----------
    time : ndarray, (times,)
        Report times [s].
    position, velocity : ndarray, (times, 3)
        Of centre of mass and angle [m, m, rad], and their rates.
    acceleration : ndarray, (times, 3), optional
        Rates of the velocity [m/s^2, m/s^2, rad/s^2]; only of mechanisms.
    """

    time: Array
    position: Array
    velocity: Array
    acceleration: Array | None = None


@named_attributes
@dataclass(frozen=True, eq=False)
class JointHistory(ArrayValue):
    """One joint over time.

    Attributes
    ----------
    time : ndarray, (times,)
        Report times [s].
    force : ndarray, (times, 2)
        Force on body b [N].
    torque : ndarray, (times,)
        Torque on body b about the joint's point b [N m]; of a driver, the motor's.
    position_residual, velocity_residual : ndarray, (times,)
        Residuals of the joint's equations [m or rad] and their rates.
    peak_force, impulse : ndarray, (times,)
        Largest force [N] and impulse [N s] since the row before.
    """

    time: Array
    force: Array
    torque: Array
    position_residual: Array
    velocity_residual: Array
    peak_force: Array
    impulse: Array


@named_attributes
@dataclass(frozen=True, eq=False)
class ContactHistory(ArrayValue):
    """One contact over time.

    Attributes
    ----------
    time, force, penetration : ndarray, (times,)
        Report times [s], size of the contact force [N], friction and film included, penetration
        [m], negative when apart.
    gap, region : ndarray of int, (times,)
        Near teeth, their gap, from 0 (-1: none), and its region, counted from 1 along its outline
        (0: none; an ANSI gap has seven).
    peak_force, impulse : ndarray, (times,)
        Largest force [N] and impulse [N s] since the row before.
    force_vector : ndarray, (times, 2)
        Force on the circle [N], on body b, in the frame of the ground.
    impact_velocity : ndarray, (times,)
        Largest penetration rate [m/s] at the contact onsets since the row before, also below
        `min_impact_velocity`; zero where there was none.
    """

    time: Array
    force: Array
    penetration: Array
    gap: IntArray
    region: IntArray
    peak_force: Array
    impulse: Array
    force_vector: Array
    impact_velocity: Array
