"""Accelerations of a drive of two sprockets, contact by contact, from its description.

Bodies are planar, q = [x, y, theta]: the links first, then rollers where they are bodies, then
the sprockets. A scene with compliant
contacts only has no constraints, so that the equations of motion (Eq. 1) are q'' = M^-1 g.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reference import force_law
from reference.film import lubricant
from reference.force_law import Normal, Pair
from reference.friction import Friction, coulomb, point_velocity
from reference.geometry import (
    Integers,
    ToothProfile,
    ansi_tooth,
    circle_on_sprocket,
    pitch_radius,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rustchain import ChainDrive

Array = NDArray[np.float64]

STEEL_DENSITY = 7850.0  # [kg/m^3]
EPS = float(np.finfo(np.float64).eps)
FLAT_REGIONS = (2, 6)


@dataclass
class Memory:
    """What each contact keeps from its onset to its end; NaN and 0 where there is no contact.

    Attributes
    ----------
    hinge_speed : ndarray, shape (hinges,)
        Approach speed at onset, not below the floor [m/s].
    tooth_speed : ndarray, shape (bushings, sprockets)
        The same for bushing and sprocket [m/s].
    tooth_region : ndarray of int, shape (bushings, sprockets)
        Region at onset, whose elastic law is kept.
    """

    hinge_speed: Array
    tooth_speed: Array
    tooth_region: Integers


@dataclass(frozen=True)
class Kinematics:
    """Penetrations and their rates, forces apart.

    Attributes
    ----------
    hinge_penetration, hinge_rate : ndarray, shape (hinges,)
        [m] and [m/s].
    hinge_normal : ndarray, shape (hinges, 2)
        From the bushing's centre to the pin's.
    tooth_penetration, tooth_rate : ndarray, shape (bushings, sprockets)
        [m], -inf where not near, and [m/s].
    tooth_normal : ndarray, shape (bushings, sprockets, 2)
        Direction in which the penetration grows for the bushing.
    tooth_region, tooth_gap : ndarray of int, shape (bushings, sprockets)
        1 to 7 and 0 to N - 1; 0 and -1 where not near.
    hinge_turning : ndarray, shape (hinges,)
    tooth_turning : ndarray, shape (bushings, sprockets)
        How much the rate changes with the position, because the normal turns: sliding speed over
        the distance of the centres [1/s].
    front, rear : ndarray, shape (links, 2)
        Hinge centres on each link [m].
    on_teeth : ndarray, shape (bushings, 2)
        Centres of what meets the teeth, bushings or rollers [m].
    roller_penetration, roller_rate, roller_normal, roller_turning : ndarray
        Of bushings in rollers, as of the hinges, with normals from the roller's centre to the
        bushing's; empty without rollers.
    """

    hinge_penetration: Array
    hinge_rate: Array
    hinge_normal: Array
    tooth_penetration: Array
    tooth_rate: Array
    tooth_normal: Array
    tooth_region: Integers
    tooth_gap: Integers
    hinge_turning: Array
    tooth_turning: Array
    front: Array
    rear: Array
    on_teeth: Array
    roller_penetration: Array
    roller_rate: Array
    roller_normal: Array
    roller_turning: Array


@dataclass(frozen=True)
class Evaluation:
    """Everything the equations of motion say about one state.

    Forces are normal forces [N], shapes as in `Kinematics`; ``loads`` and ``accelerations`` are
    (bodies, 3). ``hinge`` and ``tooth`` hold the forces with their derivatives, ``energy`` the
    elastic energy [J]. Vectors have friction in them, with bounds of its own;
    ``friction_powers`` is what it dissipates in hinges, on teeth and in rollers, ``film_power``
    what lubricant does [W]. What begins with ``roller`` is of bushings in rollers; vectors act on
    the rollers.
    """

    kinematics: Kinematics
    hinge: Normal
    tooth: Normal
    hinge_force_vector: Array
    tooth_force_vector: Array
    accelerations: Array
    energy: float
    penetration_bound: float
    speed_bound: float
    hinge_force_bound: Array
    tooth_force_bound: Array
    acceleration_bound: Array
    hinge_vector_bound: Array
    tooth_vector_bound: Array
    friction_powers: tuple[float, float, float]
    roller: Normal
    roller_force_vector: Array
    roller_force_bound: Array
    roller_vector_bound: Array
    film_power: float

    @property
    def hinge_force(self) -> Array:
        """Normal force of each hinge, shape (hinges,) [N]."""
        return self.hinge.force

    @property
    def tooth_force(self) -> Array:
        """Normal force of each bushing on each sprocket, shape (bushings, sprockets) [N]."""
        return self.tooth.force


def table_value(law: float | Sequence[Sequence[float]], time: float) -> tuple[float, float]:
    """Value and slope of a number or a table of (time, value), held constant outside."""
    if np.ndim(law) == 0:
        return float(law), 0.0  # type: ignore[arg-type]
    times, values = np.asarray(law, dtype=np.float64).T
    value = float(np.interp(time, times, values))
    if time < times[0] or time >= times[-1]:
        return value, 0.0
    i = int(np.searchsorted(times, time, side="right"))
    return value, float((values[i] - values[i - 1]) / (times[i] - times[i - 1]))


class DriveEquations:
    """Right-hand side of a drive of two sprockets and a bushing chain.

    Parameters
    ----------
    drive : ChainDrive
        The description, in SI units.
    hinge_law, tooth_law : force law descriptions
        Read by their attributes ``elastic``, ``damping`` and ``regions``.
    min_impact_velocity : float
        Floor of the approach speed at onset [m/s].

    Attributes
    ----------
    bristles : tuple of ndarray or None
        How far bristles are bent [m]: (hinges,), (bushings, sprockets) and (rollers,).
    """

    def __init__(
        self, drive: ChainDrive, hinge_law: Any, tooth_law: Any, min_impact_velocity: float = 1e-3
    ) -> None:
        chain = drive.chain
        self.drive = drive
        self.hinge_law, self.tooth_law = hinge_law, tooth_law
        self.floor = min_impact_velocity
        self.bristles: tuple[Array | None, Array | None, Array | None] = (None, None, None)
        self.links = int(chain.links)
        self.pitch = float(chain.pitch)
        self.arms = np.full(self.links, 0.5 * self.pitch)  # of links, [m]
        # Whether bushing k is at the front of link k: even links are inner.
        self.on_front = np.arange(self.links) % 2 == 0
        roller = chain.roller
        self.bushing_radius = float(chain.bushing_radius if roller is None else roller.radius)
        self.rollers = 0 if roller is None else self.links
        self.wheels = self.links + self.rollers  # number of the first sprocket
        self.clearance = float(chain.hinge.bore_radius - chain.hinge.pin_radius)
        self.restitution = chain.material.restitution
        modulus = force_law.effective_modulus(chain.material)
        self.hinge_pair = Pair(
            inside=True,
            radius_i=chain.hinge.pin_radius,
            radius_j=chain.hinge.bore_radius,
            length=chain.hinge.length,
            modulus=modulus,
        )
        self.roller_pair = self.hinge_pair
        # What half of either link gives way by at each hinge [m/N].
        stiffness = drive.chain.axial_stiffness
        self.plates = None if stiffness is None else np.full(drive.chain.links, 1.0 / stiffness)
        self.roller_clearance = np.inf
        if roller is not None:
            self.roller_clearance = float(roller.bore_radius - chain.bushing_radius)
            self.roller_pair = Pair(
                inside=True,
                radius_i=chain.bushing_radius,
                radius_j=roller.bore_radius,
                length=roller.length,
                modulus=modulus,
            )
        self.profiles = [
            ansi_tooth(
                self.pitch,
                sprocket.teeth,
                sprocket.profile.roller_diameter or 2.0 * self.bushing_radius,
                sprocket.profile.seat,
            )
            for sprocket in drive.sprockets
        ]
        self.tooth_pairs = [
            self._tooth_pairs(profile, chain.tooth_contact_length, modulus)
            for profile in self.profiles
        ]
        self.mass, self.inertia = self._masses()
        self.tension_direction, self.tension_force = self._tensioner()

    def _tooth_pairs(self, profile: ToothProfile, length: float, modulus: float) -> dict[int, Pair]:
        """Pair of cylinders of each region: bushing in the seat and the working curve, on the rest.

        The flat has no radius of its own and takes the topping curve's.
        """
        r = self.bushing_radius
        seat = Pair(True, r, profile.seating, length, modulus)
        working = Pair(True, r, profile.working, length, modulus)
        flat = Pair(False, r, profile.topping, length, modulus, flat=True)
        topping = Pair(False, r, profile.topping, length, modulus)
        return {1: topping, 2: flat, 3: working, 4: seat, 5: working, 6: flat, 7: topping}

    def _masses(self) -> tuple[Array, Array]:
        """Masses [kg] and moments of inertia [kg m^2] of all bodies, each of shape (bodies,).

        A sprocket without a mass is a steel disc of its pitch radius, as thick as the contact.
        """
        chain = self.drive.chain
        mass, inertia = [], []
        for i in range(self.links):
            link = chain.inner if i % 2 == 0 else chain.outer
            mass.append(link.mass)
            inertia.append(link.inertia)
        for _ in range(self.rollers):
            mass.append(chain.roller.mass)
            inertia.append(chain.roller.inertia)
        for sprocket in self.drive.sprockets:
            radius = pitch_radius(self.pitch, sprocket.teeth)
            disc = STEEL_DENSITY * np.pi * radius**2 * chain.tooth_contact_length
            disc_mass = disc if sprocket.mass is None else sprocket.mass
            mass.append(disc_mass)
            inertia.append(0.5 * disc * radius**2 if sprocket.inertia is None else sprocket.inertia)
        return np.array(mass), np.array(inertia)

    def _tensioner(self) -> tuple[Array, float]:
        """Direction in which the tensioned sprocket slides, shape (2,), and the full pull [N].

        The pull is the strand pretension's part along the direction, on both strands: the straight
        strands make the angle asin((r_2 - r_1) / C) with the line of centres.
        """
        tensioner = self.drive.tensioner
        if tensioner is None:
            return np.zeros(2), 0.0
        tensioned = tensioner.sprocket - 1
        centers = np.array([sprocket.center for sprocket in self.drive.sprockets], dtype=np.float64)
        away = centers[tensioned] - centers[1 - tensioned]
        distance = float(np.hypot(*away))
        direction = away if tensioner.direction is None else np.asarray(tensioner.direction)
        radii = [pitch_radius(self.pitch, sprocket.teeth) for sprocket in self.drive.sprockets]
        sine = (radii[1] - radii[0]) / distance
        direction = direction / np.hypot(*direction)
        pull = 2.0 * tensioner.pretension * np.sqrt(1.0 - sine**2) * (direction @ away) / distance
        return direction, float(pull)

    def kinematics(self, positions: Array, velocities: Array) -> Kinematics:
        """Penetrations, rates and normals of all pairs in a state; both arrays (bodies, 3)."""
        n = self.links
        link, link_rate = positions[:n], velocities[:n]
        half = self.arms[:, None] * np.stack([np.cos(link[:, 2]), np.sin(link[:, 2])], axis=1)
        turning = link_rate[:, 2:] * np.stack([-half[:, 1], half[:, 0]], axis=1)
        front, rear = link[:, :2] + half, link[:, :2] - half
        front_rate, rear_rate = link_rate[:, :2] + turning, link_rate[:, :2] - turning

        # Hinge k joins the front of link k and the rear of the next link; even links are inner and
        # carry the bushings.
        following = (np.arange(n) + 1) % n
        inner_first = self.on_front[:, None]
        bushing = np.where(inner_first, front, rear[following])
        bushing_rate = np.where(inner_first, front_rate, rear_rate[following])
        pin = np.where(inner_first, rear[following], front)
        pin_rate = np.where(inner_first, rear_rate[following], front_rate)

        eccentricity = pin - bushing
        distance = np.hypot(eccentricity[:, 0], eccentricity[:, 1])
        hinge_normal = eccentricity / np.where(distance > 0.0, distance, 1.0)[:, None]
        hinge_rate = np.sum(hinge_normal * (pin_rate - bushing_rate), axis=1)
        sliding = _across(hinge_normal, pin_rate - bushing_rate)
        hinge_turning = sliding / np.where(distance > 0.0, distance, np.inf)

        met, met_rate = bushing, bushing_rate
        if self.rollers:
            met, met_rate = positions[n : 2 * n, :2], velocities[n : 2 * n, :2]
        roller_offset = (bushing - met)[: self.rollers]
        roller_distance = np.hypot(roller_offset[:, 0], roller_offset[:, 1])
        roller_normal = (
            roller_offset / np.where(roller_distance > 0.0, roller_distance, 1.0)[:, None]
        )
        seen = (bushing_rate - met_rate)[: self.rollers]
        roller_turning = _across(roller_normal, seen)
        roller_turning /= np.where(roller_distance > 0.0, roller_distance, np.inf)

        shape = (n, len(self.profiles))
        penetration, rate = np.empty(shape), np.empty(shape)
        turning_rate, normal = np.empty(shape), np.empty((*shape, 2))
        region, gap = np.empty(shape, dtype=np.int64), np.empty(shape, dtype=np.int64)
        for s, profile in enumerate(self.profiles):
            center, spin = positions[self.wheels + s], velocities[self.wheels + s]
            contact = circle_on_sprocket(profile, center[:2], center[2], met, self.bushing_radius)
            arm = met - center[:2]
            carried = spin[:2] + spin[2] * np.stack([-arm[:, 1], arm[:, 0]], axis=1)
            penetration[:, s] = contact.penetration
            normal[:, s] = contact.normal
            rate[:, s] = np.sum(contact.normal * (met_rate - carried), axis=1)
            sliding = _across(contact.normal, met_rate - carried)
            turning_rate[:, s] = sliding / contact.normal_radius
            region[:, s], gap[:, s] = contact.region, contact.gap
        return Kinematics(
            hinge_penetration=distance - self.clearance,
            hinge_rate=hinge_rate,
            hinge_normal=hinge_normal,
            tooth_penetration=penetration,
            tooth_rate=rate,
            tooth_normal=normal,
            tooth_region=region,
            tooth_gap=gap,
            hinge_turning=hinge_turning,
            tooth_turning=turning_rate,
            front=front,
            rear=rear,
            on_teeth=met,
            roller_penetration=roller_distance - self.roller_clearance,
            roller_rate=np.sum(roller_normal * seen, axis=1),
            roller_normal=roller_normal,
            roller_turning=roller_turning,
        )

    def _force(
        self, law: Any, pair: Pair, depth: Array, rate: Array, speed: Array | None
    ) -> tuple[Normal, float]:
        """Forces of contacts of one pair of radii, arrays of one shape, and their energy [J].

        ``speed`` is the approach speed at onset [m/s]. NaN: no contact, no force. None: no memory,
        so that the present rate is the onset's, not below the floor.
        """
        if speed is not None:
            depth = np.where(np.isnan(speed), -1.0, depth)
        part = force_law.elastic(law.elastic, pair, depth)
        if pair is self.hinge_pair and self.plates is not None and depth.size:
            part = force_law.in_series(law.elastic, pair, depth, self.plates)
        energy = float(np.sum(part.energy))
        if law.damping is None:
            return Normal(part.force, part.stiffness, np.zeros_like(part.force)), energy
        factor = force_law.damping_lambda(law.damping, self.restitution)
        if speed is not None:
            onset = np.where(np.isnan(speed), 1.0, speed)
            return force_law.damped(part, factor, rate, onset), energy
        normal = force_law.damped(part, factor, rate, np.maximum(rate, self.floor))
        # Above the floor the rate is its own onset speed, and the quotient is one.
        return normal._replace(by_rate=np.where(rate > self.floor, 0.0, normal.by_rate)), energy

    def evaluate(
        self, positions: Array, velocities: Array, time: float = 0.0, memory: Memory | None = None
    ) -> Evaluation:
        """Forces and accelerations of a state.

        Parameters
        ----------
        positions, velocities : ndarray, shape (bodies, 3)
            [m, m, rad] and [m/s, m/s, rad/s].
        time : float
            [s].
        memory : Memory, optional
            Without it no contact has memory: a pair in contact takes its present penetration rate,
            not below the floor, as its approach speed, and the present region's stiffness.
        """
        kin = self.kinematics(positions, velocities)
        speed = None if memory is None else memory.hinge_speed
        hinge, energy = self._force(
            self.hinge_law, self.hinge_pair, kin.hinge_penetration, kin.hinge_rate, speed
        )
        roller, stored = self._force(
            self.hinge_law, self.roller_pair, kin.roller_penetration, kin.roller_rate, None
        )
        energy += stored
        shape = kin.tooth_penetration.shape
        tooth = Normal(np.zeros(shape), np.zeros(shape), np.zeros(shape))
        law_region = kin.tooth_region
        if memory is not None and self.tooth_law.regions == "kept":
            law_region = np.where(memory.tooth_region > 0, memory.tooth_region, law_region)
        for s in range(shape[1]):
            for region in range(1, 8):
                here = (law_region[:, s] == region) & (kin.tooth_penetration[:, s] > 0.0)
                if not np.any(here):
                    continue
                part, stored = self._force(
                    self.tooth_law,
                    self.tooth_pairs[s][region],
                    kin.tooth_penetration[here, s],
                    kin.tooth_rate[here, s],
                    None if memory is None else memory.tooth_speed[here, s],
                )
                energy += stored
                for whole, piece in zip(tooth, part, strict=True):
                    whole[here, s] = piece
        return self._assemble(positions, velocities, time, kin, (hinge, tooth, roller), energy)

    def _assemble(
        self,
        positions: Array,
        velocities: Array,
        time: float,
        kin: Kinematics,
        forces: tuple[Normal, Normal, Normal],
        energy: float,
    ) -> Evaluation:
        """Gather the contact forces on the bodies, and beside them what round-off may do."""
        n = self.links
        delta_x = 8.0 * EPS * float(np.max(np.abs(positions[:, :2])))
        delta_v = 8.0 * EPS * float(np.max(np.abs(velocities[:, :2])))
        hinge, tooth, roller = forces
        hinge_bound = self._bound(hinge, kin.hinge_turning, delta_x, delta_v)
        roller_bound = self._bound(roller, kin.roller_turning, delta_x, delta_v)
        tooth_bound = self._bound(tooth, kin.tooth_turning, delta_x, delta_v)

        hinge_vector = -hinge.force[:, None] * kin.hinge_normal  # on the pin
        tooth_vector = -tooth.force[:, :, None] * kin.tooth_normal  # on the bushing or roller
        roller_vector = roller.force[:, None] * kin.roller_normal  # on the roller
        k = np.arange(n)
        following = (k + 1) % n
        inner = np.where(self.on_front, k, following)
        outer = np.where(self.on_front, following, k)
        inner_first = self.on_front[:, None]
        bushing = np.where(inner_first, kin.front, kin.rear[following])
        pin = np.where(inner_first, kin.rear[following], kin.front)

        rollers = n + np.arange(self.rollers)
        meeting = rollers if self.rollers else inner
        loads = np.zeros((self.wheels + len(self.profiles), 3))
        bounds = np.zeros_like(loads)
        loads[:, :2] = self.mass[:, None] * np.asarray(self.drive.gravity)

        def push(bodies: Integers, points: Array, forces: Array, moved: Array) -> None:
            arms = points - positions[bodies, :2]
            moments = arms[:, 0] * forces[:, 1] - arms[:, 1] * forces[:, 0]
            np.add.at(loads, bodies, np.column_stack([forces, moments]))
            ones = np.ones((len(bodies), 2))
            leverage = np.column_stack([ones, np.hypot(arms[:, 0], arms[:, 1])])
            np.add.at(bounds, bodies, moved[:, None] * leverage)

        rubbed = self._rub(positions, velocities, kin, (pin, bushing), forces)
        push(outer, pin, hinge_vector, hinge_bound)
        push(inner, bushing, -hinge_vector, hinge_bound)
        if self.rollers:
            # Along the line of centres, at the rollers' for both.
            push(inner, bushing, -roller_vector, roller_bound)
            push(rollers, kin.on_teeth, roller_vector, roller_bound)
        for s in range(len(self.profiles)):
            wheel = np.full(n, self.wheels + s)
            push(meeting, kin.on_teeth, tooth_vector[:, s], tooth_bound[:, s])
            push(wheel, kin.on_teeth, -tooth_vector[:, s], tooth_bound[:, s])
        hinge_vector_bound, tooth_vector_bound = hinge_bound.copy(), tooth_bound.copy()
        roller_vector_bound = roller_bound.copy()
        powers = [0.0, 0.0, 0.0]
        for bodies, points, friction in rubbed:
            push(bodies[0], points, friction.force, friction.bound)
            push(bodies[1], points, -friction.force, friction.bound)
            second = int(bodies[1][0])  # a link in hinges, a roller, or a sprocket
            if second < n:
                place = 0
                hinge_vector += friction.force
                hinge_vector_bound += friction.bound
            elif second < self.wheels:
                place = 2
                roller_vector -= friction.force
                roller_vector_bound += friction.bound
            else:
                place, s = 1, second - self.wheels
                tooth_vector[:, s] += friction.force
                tooth_vector_bound[:, s] += friction.bound
            powers[place] += float(np.sum(friction.power))
        film_power = 0.0
        if (law := getattr(self.hinge_law, "film", None)) is not None:
            ends = ((outer, pin), (inner, bushing))
            first, second = (point_velocity(positions, velocities, *end) for end in ends)
            spins = velocities[outer, 2], velocities[inner, 2]
            film = lubricant(
                law,
                self.drive.chain.hinge,
                self.drive.chain.hinge.length,
                pin - bushing,
                first - second,
                spins,
                (delta_x, delta_v),
            )
            middle = 0.5 * (pin + bushing)  # half the couple of the two forces to each body
            push(outer, middle, film.force, film.bound)
            push(inner, middle, -film.force, film.bound)
            shear = film.shear * (spins[1] - spins[0])
            np.add.at(loads[:, 2], outer, shear)
            np.add.at(loads[:, 2], inner, -shear)
            hinge_vector += film.force
            hinge_vector_bound += film.bound
            film_power = float(np.sum(film.power))

        self._drive_sprockets(velocities, time, loads, bounds)
        heaviness = np.stack([self.mass, self.mass, self.inertia], axis=1)
        accelerations = loads / heaviness
        acceleration_bounds = (bounds + 1e-12 * np.abs(loads)) / heaviness
        self._support_sprockets(time, accelerations, acceleration_bounds)
        return Evaluation(
            kinematics=kin,
            hinge=hinge,
            tooth=tooth,
            hinge_force_vector=hinge_vector,
            tooth_force_vector=tooth_vector,
            accelerations=accelerations,
            energy=energy,
            penetration_bound=delta_x,
            speed_bound=delta_v,
            hinge_force_bound=hinge_bound,
            tooth_force_bound=tooth_bound,
            acceleration_bound=acceleration_bounds,
            hinge_vector_bound=hinge_vector_bound,
            tooth_vector_bound=tooth_vector_bound,
            friction_powers=(powers[0], powers[1], powers[2]),
            roller=roller,
            roller_force_vector=roller_vector,
            roller_force_bound=roller_bound,
            roller_vector_bound=roller_vector_bound,
            film_power=film_power,
        )

    def _bound(self, force: Normal, turning: Array, delta_x: float, delta_v: float) -> Array:
        """`force_bound`, and what a turned normal does to the rate."""
        turned = np.abs(force.by_rate) * np.abs(turning) * delta_x
        return force_bound(force, delta_x, delta_v) + turned

    def _rub(
        self,
        positions: Array,
        velocities: Array,
        kin: Kinematics,
        centers: tuple[Array, Array],
        forces: tuple[Normal, Normal, Normal],
    ) -> list[tuple[tuple[Integers, Integers], Array, Friction]]:
        """Friction of hinges, in rollers, then of each sprocket's teeth: bodies, points, what acts.

        A hinge's contact is the pin's outermost point, a roller's on its bushing that of the
        bushing, a tooth's that of the bushing or roller.
        """
        n = self.links
        k = np.arange(n)
        following = (k + 1) % n
        inner = np.where(self.on_front, k, following)
        outer = np.where(self.on_front, following, k)
        pin, bushing = centers
        delta_x = 8.0 * EPS * float(np.max(np.abs(positions[:, :2])))
        delta_v = 8.0 * EPS * float(np.max(np.abs(velocities[:, :2])))
        found = []

        def rub(
            law: Any, bodies: tuple[Integers, Integers], points: Array, contact: tuple[Any, ...]
        ) -> None:
            normals, force, bound, distance, deflection = contact
            first, second = (point_velocity(positions, velocities, b, points) for b in bodies)
            errors = (delta_x, delta_v, distance)
            friction = coulomb(law, normals, first - second, (force, bound), errors, deflection)
            found.append((bodies, points, friction))

        if (law := getattr(self.hinge_law, "friction", None)) is not None:
            bound = self._bound(forces[0], kin.hinge_turning, delta_x, delta_v)
            distance = kin.hinge_penetration + self.clearance
            points = pin + self.drive.chain.hinge.pin_radius * kin.hinge_normal
            contact = (kin.hinge_normal, forces[0].force, bound, distance, self.bristles[0])
            rub(law, (outer, inner), points, contact)
            if self.rollers:
                bound = self._bound(forces[2], kin.roller_turning, delta_x, delta_v)
                distance = kin.roller_penetration + self.roller_clearance
                points = bushing + self.drive.chain.bushing_radius * kin.roller_normal
                contact = (
                    kin.roller_normal,
                    forces[2].force,
                    bound,
                    distance,
                    self.bristles[2],
                )
                rub(law, (inner, n + k), points, contact)
        if (law := getattr(self.tooth_law, "friction", None)) is not None:
            bounds = self._bound(forces[1], kin.tooth_turning, delta_x, delta_v)
            for s in range(len(self.profiles)):
                normals = kin.tooth_normal[:, s]
                points = kin.on_teeth + self.bushing_radius * normals
                distance = np.full(n, 1e-4)  # of centres, in the seat
                on_teeth = self.bristles[1]
                deflection = None if on_teeth is None else on_teeth[:, s]
                contact = (normals, forces[1].force[:, s], bounds[:, s], distance, deflection)
                meeting = n + k if self.rollers else inner
                rub(law, (meeting, np.full(n, self.wheels + s)), points, contact)
        return found

    def _drive_sprockets(self, velocities: Array, time: float, loads: Array, bounds: Array) -> None:
        """Add what is applied to the sprockets: torques, and the tensioner's pull and damping."""
        n = self.wheels
        for s, sprocket in enumerate(self.drive.sprockets):
            if hasattr(sprocket.motion, "torque"):
                loads[n + s, 2] += table_value(sprocket.motion.torque, time)[0]
        tensioner = self.drive.tensioner
        if tensioner is None:
            return
        body = n + tensioner.sprocket - 1
        ramp = 1.0
        if tensioner.ramp_time > 0.0:
            ramp = min(max(time / tensioner.ramp_time, 0.0), 1.0)
        pull = self.tension_force * ramp
        drag = tensioner.damping * float(velocities[body, :2] @ self.tension_direction)
        loads[body, :2] += (pull - drag) * self.tension_direction
        bounds[body, :2] += 1e-12 * (abs(pull) + abs(drag))

    def _support_sprockets(self, time: float, accelerations: Array, bounds: Array) -> None:
        """Hold the sprockets in their bearings, on the tensioner's slide and at their speeds."""
        n = self.wheels
        tensioner = self.drive.tensioner
        for s, sprocket in enumerate(self.drive.sprockets):
            body = n + s
            if hasattr(sprocket.motion, "speed"):
                accelerations[body, 2] = table_value(sprocket.motion.speed, time)[1]
                bounds[body, 2] = 1e-12 * abs(accelerations[body, 2])
            if tensioner is not None and tensioner.sprocket == s + 1:
                along = float(accelerations[body, :2] @ self.tension_direction)
                accelerations[body, :2] = along * self.tension_direction
            elif sprocket.bearing == "fixed":
                accelerations[body, :2] = 0.0
                bounds[body, :2] = 0.0


def _across(normals: Array, vectors: Array) -> Array:
    """Size of the part of each vector (n, 2) that is across its normal (n, 2)."""
    return np.abs(normals[:, 0] * vectors[:, 1] - normals[:, 1] * vectors[:, 0])


def force_bound(force: Normal, delta_x: float, delta_v: float) -> Array:
    """How far round-off may move a force [N].

    1e-12 |F| + |dF/d delta| 8 eps |x| + |dF/d delta_dot| 8 eps |v|, where ``delta_x`` [m] and
    ``delta_v`` [m/s] are the two eps terms.
    """
    return np.asarray(
        1e-12 * np.abs(force.force)
        + np.abs(force.by_penetration) * delta_x
        + np.abs(force.by_rate) * delta_v
    )
