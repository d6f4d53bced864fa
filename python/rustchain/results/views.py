"""The parts of a result over time: hinges, bushings, rollers, strands, sprockets, ends, energy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import numpy.typing as npt

from rustchain.names import named_attributes
from rustchain.results.values import ArrayValue
from rustchain.typing import Array, IntArray

if TYPE_CHECKING:
    from rustchain.results.result import Result

Jumps: TypeAlias = tuple[Array, npt.NDArray[np.int64], npt.NDArray[np.int64]]
"""Times [s], sprockets from 1 and directions of tooth jumps."""


@named_attributes
@dataclass(frozen=True, eq=False)
class Hinge(ArrayValue):
    """One hinge over time.

    Attributes
    ----------
    time : ndarray, (times,)
        Report times [s].
    force, penetration : ndarray, (times,)
        Normal force [N] and penetration [m]; penetration is negative when apart. With a lubricant
        film, the size of the whole force. Of an ideal hinge, the force that it transmits and the
        distance of its two ends, which is an error of the integration.
    force_vector : ndarray, (times, 2)
        Force on the pin, friction and film included [N].
    eccentricity : ndarray, (times, 2)
        Pin centre seen from the bushing [m].
    film_force : ndarray, (times,), optional
        Size of the film's force [N], where there is a film.
    onset_speed : ndarray, (times,), optional
        Initial impact velocity of the present contact [m/s], not below the minimum; 0
        when apart. Not with ideal hinges.
    """

    time: Array
    force: Array
    force_vector: Array
    penetration: Array
    eccentricity: Array
    film_force: Array | None = None
    onset_speed: Array | None = None


@named_attributes
@dataclass(frozen=True, eq=False)
class Bushing(ArrayValue):
    """The contact of largest penetration of one bushing with a tooth, over time.

    Attributes
    ----------
    time : ndarray, (times,)
        Report times [s].
    tooth_force, tooth_penetration : ndarray, (times,)
        Contact force [N] and penetration [m]; penetration is -inf far from all teeth.
    sprocket, tooth, region : ndarray of int, (times,)
        Sprocket from 1 (0: none), tooth gap from 0 (-1: none), region of the gap from 1
        (0: none); an ANSI gap has seven, the fourth is the seat.
    tooth_force_vector : ndarray, (times, 2), optional
        Force on the bushing, friction included [N].
    tooth_onset_speed : ndarray, (times,), optional
        Initial impact velocity of the present contact [m/s], not below the minimum; 0
        when apart.
    """

    time: Array
    tooth_force: Array
    tooth_penetration: Array
    sprocket: IntArray
    tooth: IntArray
    region: IntArray
    tooth_force_vector: Array | None = None
    tooth_onset_speed: Array | None = None


@named_attributes
@dataclass(frozen=True, eq=False)
class RollerOnBushing(ArrayValue):
    """One roller on its bushing over time.

    Attributes
    ----------
    time : ndarray, (times,)
        Report times [s].
    force, penetration : ndarray, (times,)
        Normal force of the bushing in the bore [N] and penetration [m], negative when apart.
    force_vector : ndarray, (times, 2)
        Force of the bushing on the roller, friction included [N].
    eccentricity : ndarray, (times, 2)
        Bushing's centre seen from the roller's [m].
    position, velocity : ndarray, (times, 3), optional
        The roller itself [m, m, rad] and [m/s, m/s, rad/s], where bodies were recorded.
    onset_speed : ndarray, (times,), optional
        Initial impact velocity of the present contact [m/s], not below the minimum; 0
        when apart.
    """

    time: Array
    force: Array
    force_vector: Array
    penetration: Array
    eccentricity: Array
    position: Array | None = None
    velocity: Array | None = None
    onset_speed: Array | None = None


@named_attributes
@dataclass(frozen=True, eq=False)
class Strand(ArrayValue):
    """One strand over time.

    Attributes
    ----------
    time : ndarray, (times,)
        Report times [s].
    tension : ndarray, (times,)
        Mean tension of the strand's hinges [N].
    """

    time: Array
    tension: Array


@named_attributes
@dataclass(frozen=True, eq=False)
class SprocketMotion(ArrayValue):
    """One sprocket over time.

    Attributes
    ----------
    time : ndarray, (times,)
        Report times [s].
    angle, speed, torque : ndarray, (times,)
        Angle [rad], speed [rad/s] and torque on the shaft [N m], counterclockwise positive.
    center : ndarray, (times, 2)
        Centre [m].
    """

    time: Array
    angle: Array
    speed: Array
    torque: Array
    center: Array


@named_attributes
@dataclass(frozen=True, eq=False)
class ChainEnd(ArrayValue):
    """One end of an open chain over time.

    Attributes
    ----------
    time : ndarray, (times,)
        Report times [s].
    force : ndarray, (times, 2)
        Force of the chain on its end [N]: the reaction of an anchor, with the other sign.
    position, velocity : ndarray, (times, 2)
        Pin of that end [m], [m/s]. A free end has none: its position is that at the start.
    """

    time: Array
    force: Array
    position: Array
    velocity: Array


@named_attributes
@dataclass(frozen=True, eq=False)
class Energy(ArrayValue):
    """The energy balance over time.

    Attributes
    ----------
    kinetic, gravity, elastic : ndarray, (times,)
        Energy stored [J].
    dissipated, external_work : ndarray, (times,)
        Energy lost in contacts and dashpots, and work of motors, loads and tensioner, since the
        first row [J]. ``worked_in`` is another name of the external work.
    residual : ndarray, (times,)
        Residual of the energy balance [J]: the error measure of a long run.
    hinge_contact, tooth_contact, hinge_friction, tooth_friction : ndarray, (times,), optional
        Parts of `dissipated` [J]: damping of contacts and friction, of pins in bushings and of
        bushings on teeth. With those of rollers and film below, the remainder is that of dashpots.
        Only of chain drives; those of hinges only with clearance.
    roller_contact, roller_friction : ndarray, (times,), optional
        The same of bushings in rollers, where those are bodies.
    hinge_film : ndarray, (times,), optional
        The same of lubricant between pins and bushings [J], where there is any.
    """

    kinetic: Array
    gravity: Array
    elastic: Array
    dissipated: Array
    external_work: Array
    residual: Array
    hinge_contact: Array | None = None
    tooth_contact: Array | None = None
    hinge_friction: Array | None = None
    tooth_friction: Array | None = None
    roller_contact: Array | None = None
    roller_friction: Array | None = None
    hinge_film: Array | None = None

    @property
    def worked_in(self) -> Array:
        """Another name of `external_work` [J], (times,)."""
        return self.external_work


@named_attributes
@dataclass(frozen=True, eq=False)
class Peaks(ArrayValue):
    """Largest forces [N] and impulses [N s] within each report interval; row i ends at time i.

    An impact lasts 15 to 80 us, so that most of them fall between two rows of the other arrays.
    """

    _result: Result

    def __repr__(self) -> str:
        """Return whose peaks these are."""
        return f"<Peaks of {self._result!r}>"

    @property
    def hinge_force(self) -> Array:
        """Largest force of each hinge [N], (times, hinges)."""
        return self._result.array("peak_hinge_force")

    @property
    def hinge_impulse(self) -> Array:
        """Impulse of each hinge [N s], (times, hinges)."""
        return self._result.array("peak_hinge_impulse")

    @property
    def roller_force(self) -> Array:
        """Largest force of each bushing in its roller [N], (times, rollers)."""
        return self._result.array("peak_roller_force")

    @property
    def roller_impulse(self) -> Array:
        """Impulse of each bushing in its roller [N s], (times, rollers)."""
        return self._result.array("peak_roller_impulse")

    @property
    def tooth_force(self) -> Array:
        """Largest tooth force of each bushing [N], (times, bushings)."""
        return self._result.array("peak_tooth_force")

    @property
    def tooth_impulse(self) -> Array:
        """Impulse of the teeth on each bushing [N s], (times, bushings)."""
        return self._result.array("peak_tooth_impulse")

    @property
    def joint_force(self) -> Array:
        """Largest force of each joint [N], (times, joints)."""
        return self._result.array("peak_joint_force")

    @property
    def joint_impulse(self) -> Array:
        """Impulse of each joint [N s], (times, joints)."""
        return self._result.array("peak_joint_impulse")

    @property
    def contact_force(self) -> Array:
        """Largest force of each contact [N], (times, contacts)."""
        return self._result.array("peak_contact_force")

    @property
    def contact_impulse(self) -> Array:
        """Impulse of each contact [N s], (times, contacts)."""
        return self._result.array("peak_contact_impulse")
