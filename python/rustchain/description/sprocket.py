"""Sprockets and their motion: prescribed speed, applied torque, free."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt

from rustchain import _rustchain
from rustchain.arguments import checked, plain, shown
from rustchain.description.base import Description, description
from rustchain.description.chain import Chain
from rustchain.description.signals import Curve, Signal, refuse_functions
from rustchain.description.teeth import AnsiTooth, ToothForm
from rustchain.errors import InvalidInput
from rustchain.typing import Point

Side = Literal["inside", "outside"]


def _refuse_other_forms(where: str, axis: str, given: object, setter: str = "") -> None:
    """Refuse functions; tell a list of numbers as it was given and not by its first one."""
    kind = "signal" if axis == "time" else "curve"
    refuse_functions(where, given, kind=kind, setter=setter)
    values = plain(given)
    if isinstance(values, tuple) and values and not any(isinstance(v, tuple) for v in values):
        expected = "one number, or rows" if axis == "time" else "rows"
        raise InvalidInput(f"{where} = {shown(given)}: must be {expected} of ({axis}, value)")


@description(frozen=True)
class PrescribedSpeed(Description):
    """A sprocket that turns at a prescribed speed, at any torque.

    Attributes
    ----------
    speed : float, rows of (time, speed), Table, Spline, Sines or SmoothStep
        Speed [rad/s] over time [s], counterclockwise positive. The angle is its exact integral.

    Examples
    --------
    >>> rc.PrescribedSpeed(12.566)  # constant
    PrescribedSpeed(speed=12.566)
    >>> rc.PrescribedSpeed([(0.0, 0.0), (0.5, 12.566)])  # from rest in half a second
    PrescribedSpeed(speed=((0.0, 0.0), (0.5, 12.566)))
    """

    speed: Signal

    def __post_init__(self) -> None:
        """Refuse functions and numbers in a row, and let the rest be checked."""
        _refuse_other_forms("PrescribedSpeed.speed", "time", self.speed, "set_speed")
        super().__post_init__()


@description(frozen=True)
class AppliedTorque(Description):
    """A sprocket under a given torque.

    Attributes
    ----------
    torque : float, rows of (time, torque), Table, Spline, Sines or SmoothStep
        Torque [N m] over time [s], counterclockwise positive.
    curve : rows of (speed, torque) or Table, optional
        Additional torque [N m] over the speed of the sprocket [rad/s]: the curve of a motor or a
        load. It is linear between the rows and constant outside them.

    Examples
    --------
    >>> rc.AppliedTorque(-2.0)
    AppliedTorque(torque=-2.0)
    >>> rc.AppliedTorque(0.0, curve=[(0.0, 0.0), (10.0, -3.0)])  # falls with the speed
    AppliedTorque(curve=((0.0, 0.0), (10.0, -3.0)))
    """

    torque: Signal = 0.0
    curve: Curve | None = None

    def __post_init__(self) -> None:
        """Refuse functions and numbers in a row, and let the rest be checked."""
        _refuse_other_forms("AppliedTorque.torque", "time", self.torque, "set_torque")
        _refuse_other_forms("AppliedTorque.curve", "speed", self.curve)
        super().__post_init__()


@description(frozen=True)
class Free(Description):
    """A sprocket that only the chain turns.

    Examples
    --------
    >>> rc.Sprocket(25, (0.25, 0.0)).motion
    Free()
    """


@description(frozen=True)
class Sprocket(Description):
    """A toothed wheel.

    Attributes
    ----------
    teeth : int
        Number of teeth: 5 to 1000, with ISO teeth 9 to 150.
    center : (float, float)
        Centre at the start [m].
    motion : PrescribedSpeed, AppliedTorque or Free
        Prescribed speed, applied torque, or neither.
    profile : AnsiTooth, IsoTooth, StraightTooth or CustomTooth
        Tooth form. The default is that of ANSI chains, also with a chain of ISO 606: give
        `IsoTooth` for the teeth of that standard.
    mass, inertia : float, optional
        Mass [kg] and moment of inertia [kg m^2]; by default those of a steel disc of the pitch
        radius, as thick as the chain's `tooth_contact_length`.
    initial_speed : float, optional
        Speed at the start [rad/s]; by default that of the motion, or that which follows from the
        chain.
    bearing : {"fixed", "floating"}
        "fixed": the centre is held, or moved by the tensioner. "floating": it is free in the plane.
    side : {"inside", "outside"}
        Side of the chain on which the sprocket is: a sprocket outside is a reverse idler, which
        presses the chain inward and turns against the driver.
    load_inertia : float
        Moment of inertia of the parts that turn with the sprocket [kg m^2]: shaft, load, motor.
    eccentricity : float
        Distance between the centre of the teeth and the centre of the bore [m], half of the full
        radial runout. The centre of gravity is in the bore.
    eccentricity_angle : float
        Direction of the centre of the teeth, from the direction of gap 0 [rad].
    damaged_teeth : sequence of (int, float)
        Damaged teeth, and the share of their height above the bottom of the gap that is left; 0:
        the tooth is missing. Tooth k, from 0, lies between gaps k and k + 1.

    Examples
    --------
    >>> motor = rc.Sprocket(17, motion=rc.PrescribedSpeed(rc.rpm(120)))
    >>> load = rc.Sprocket(25, (0.25, 0.0), rc.AppliedTorque(-2.0), load_inertia=0.01)
    >>> load.teeth / motor.teeth
    1.4705882352941178
    """

    teeth: int
    center: Point = (0.0, 0.0)
    motion: PrescribedSpeed | AppliedTorque | Free = Free()
    profile: ToothForm = AnsiTooth()  # frozen
    mass: float | None = None
    inertia: float | None = None
    initial_speed: float | None = None
    bearing: Literal["fixed", "floating"] = "fixed"
    side: Side = "inside"
    load_inertia: float = 0.0
    eccentricity: float = 0.0
    eccentricity_angle: float = 0.0
    damaged_teeth: Sequence[tuple[int, float]] = ()

    @checked
    def outline(self, chain: Chain, points: int = 24) -> npt.NDArray[np.float64]:
        """Return the closed outline of the teeth for `chain`, about their centre.

        Parameters
        ----------
        chain : Chain
            The chain they are cut for.
        points : int
            Points on each curve, 2 to 1000.

        Returns
        -------
        ndarray, shape (points in all, 2)
            Counterclockwise [m]; gap 0 lies along x.
        """
        return _rustchain.tooth_outline(self, chain, points)
