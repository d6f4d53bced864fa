"""The right-hand side in NumPy, all hinges and all pairs at once, beside that of the package.

Whole arrays only, no loop over contacts. Accelerations are compared with `Simulation.evaluate`
before anything is timed. The package's time is that of its steps over their evaluations: it
contains prediction, error test and correction, so that the ratio printed is less than that of the
right-hand sides.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import rustchain as rc
from least_times import EqualRuns, step, take_turns

UNDER_WAY, SPAN = 6e-3, 8e-3  # start and duration of the package's steps [s]
DEGREE = np.pi / 180.0
INCH = 0.0254
FLAT, TOPPING = 2, 3  # surfaces: seating 0, working 1


def by_surface(*constants):
    """Table, shape (surfaces, sprockets), of constants of shape (sprockets, 1)."""
    return np.stack(constants)[:, :, 0]


class Teeth:
    """Constants of the gaps of all sprockets, of shape (sprockets, 1) or (surfaces, sprockets)."""

    def __init__(self, drive):
        chain = drive.chain
        n = np.array([[s.teeth] for s in drive.sprockets], dtype=np.float64)
        roller = np.array(
            [[s.profile.roller_diameter or 2.0 * chain.bushing_radius] for s in drive.sprockets]
        )
        standard = np.array([[s.profile.seat == "bottom-diameter"] for s in drive.sprockets])
        allowance = 0.0015 * INCH
        a, b = (35.0 + 60.0 / n) * DEGREE, (18.0 - 56.0 / n) * DEGREE
        seating = 0.5025 * roller + allowance
        self.seat_radius = chain.pitch / (2.0 * np.sin(np.pi / n))
        self.seat_radius = self.seat_radius + np.where(standard, seating - 0.5 * roller, 0.0)
        working = 1.3025 * roller + allowance
        topping = 0.8 * np.cos(b) + 1.4 * np.cos((17.0 - 64.0 / n) * DEGREE) - 1.3025
        topping = roller * topping - allowance
        phi = a - b
        self.gap_angle = 2.0 * np.pi / n
        self.x_u, self.x_v = np.sin(a), np.cos(a)
        self.flat_u, self.flat_v = np.cos(phi), -np.sin(phi)
        wu, wv = -0.8 * roller * np.cos(a), 0.8 * roller * np.sin(a)
        tu, tv = 1.4 * roller * np.cos(np.pi / n), -1.4 * roller * np.sin(np.pi / n)
        # Along the flat: where it begins (normal through the working centre) and ends.
        self.working_end = -self.flat_v * wu + self.flat_u * wv
        self.flat_end = -self.flat_v * tu + self.flat_u * tv
        # The flat is seen as a line at this distance from the gap's origin.
        self.flat_at = self.flat_u * wu + self.flat_v * wv + working - chain.bushing_radius
        zero = np.zeros_like(wu)
        r = chain.bushing_radius
        self.center_u = by_surface(zero, wu, zero, tu)
        self.center_v = by_surface(zero, wv, zero, tv)
        self.touch = by_surface(seating - r, working - r, zero, topping + r)
        radii = [
            r * seating / (seating - r),
            r * working / (working - r),
            np.full_like(working, r),
            r * topping / (r + topping),
        ]
        material = chain.material
        modulus = material.elastic_modulus / (2.0 * (1.0 - material.poisson_ratio**2))
        self.stiffness = 4.0 / 3.0 * modulus * np.sqrt(by_surface(*radii))
        # Where a bushing touches the topping curves on both sides of a tooth, on its centre line.
        half = np.pi / n
        cu, cv = tu, tv + self.seat_radius
        along = np.sin(half) * cu + np.cos(half) * cv
        self.reach = along + np.sqrt((topping + r) ** 2 - (cu**2 + cv**2 - along**2))


class RightHandSide:
    """Accelerations of a drive's bodies by the law of Lankarani and Nikravesh.

    The first sprocket has a constant prescribed speed, the second is free to turn; both have fixed
    bearings.
    """

    def __init__(self, drive, minimum=1e-3):
        chain = drive.chain
        self.links = n = chain.links
        self.half_pitch = 0.5 * chain.pitch
        self.clearance = chain.hinge.bore_radius - chain.hinge.pin_radius
        self.minimum = minimum
        material = chain.material
        self.factor = 0.75 * (1.0 - material.restitution**2)
        modulus = material.elastic_modulus / (2.0 * (1.0 - material.poisson_ratio**2))
        pin, bore = chain.hinge.pin_radius, chain.hinge.bore_radius
        self.hinge_stiffness = 4.0 / 3.0 * modulus * np.sqrt(pin * bore / (bore - pin))
        self.teeth = Teeth(drive)
        self.gravity = np.asarray(drive.gravity)[:, None]
        odd = np.arange(n) % 2 == 1
        self.on_front = ~odd
        self.inverse_mass = 1.0 / np.where(odd, chain.outer.mass, chain.inner.mass)
        inertia = np.where(odd, chain.outer.inertia, chain.inner.inertia)
        self.arm_over_inertia = self.half_pitch / inertia
        self.sprocket_inertia = drive.sprockets[1].inertia
        self.sprockets = np.arange(len(drive.sprockets))[:, None]
        self.out = np.zeros((3, n + 2))

    def __call__(self, q, v):
        """Accelerations (3, bodies) of positions `q` and velocities `v`, both (3, bodies)."""
        n = self.links
        x = q[:2, :n]
        cos, sin = np.cos(q[2]), np.sin(q[2])
        half = self.half_pitch * np.stack((cos[:n], sin[:n]))
        turn = np.stack((-half[1], half[0])) * v[2, :n]
        front, front_v = x + half, v[:2, :n] + turn
        rear, rear_v = np.roll(x - half, -1, axis=1), np.roll(v[:2, :n] - turn, -1, axis=1)

        offset, speed = front - rear, front_v - rear_v
        distance = np.sqrt(offset[0] * offset[0] + offset[1] * offset[1])
        normal = offset / np.maximum(distance, 1e-300)
        rate = normal[0] * speed[0] + normal[1] * speed[1]
        force = self.normal_force(self.hinge_stiffness, distance - self.clearance, rate)
        on_rear = force * normal
        on_front = -on_rear

        bushing = np.where(self.on_front, front, rear)
        bushing_v = np.where(self.on_front, front_v, rear_v)
        arm = bushing[:, None] - q[:2, n:, None]  # (2, sprockets, bushings)
        push = self.tooth_forces(arm, bushing_v, q[2, n:, None], v[:, n:, None])
        on_bushing = push.sum(axis=1)
        on_front -= np.where(self.on_front, on_bushing, 0.0)
        on_rear -= np.where(self.on_front, 0.0, on_bushing)
        on_rear = np.roll(on_rear, 1, axis=1)

        out = self.out
        out[:2, :n] = (on_front + on_rear) * self.inverse_mass + self.gravity
        difference = on_front - on_rear
        out[2, :n] = self.arm_over_inertia * (cos[:n] * difference[1] - sin[:n] * difference[0])
        moment = (arm[0] * push[1] - arm[1] * push[0]).sum(axis=1)
        out[2, n + 1] = moment[1] / self.sprocket_inertia
        return out

    def normal_force(self, stiffness, depth, rate):
        """Force [N] of contacts without memory: the rate, not below the minimum, is the onset's."""
        depth = np.maximum(depth, 0.0)
        damping = 1.0 + self.factor * rate / np.maximum(rate, self.minimum)
        return stiffness * depth * np.sqrt(depth) * np.maximum(damping, 0.0)

    def tooth_forces(self, arm, bushing_v, angle, v):
        """Return the forces of all bushings on all sprockets, (2, sprockets, bushings) [N]."""
        t = self.teeth
        polar = np.arctan2(arm[1], arm[0])
        direction = angle + np.rint((polar - angle) / t.gap_angle) * t.gap_angle
        cos, sin = np.cos(direction), np.sin(direction)
        signed = arm[0] * sin - arm[1] * cos
        u = np.abs(signed)
        radial = arm[0] * cos + arm[1] * sin
        w = radial - t.seat_radius
        along = t.flat_u * w - t.flat_v * u
        past_x = t.x_u * u + t.x_v * w > 0.0
        past_y = past_x & (along > t.working_end)
        past_z = past_y & (along > t.flat_end)
        surface = past_x.astype(np.int8) + past_y + past_z
        of_surface = (surface, self.sprockets)
        du, dv = u - t.center_u[of_surface], w - t.center_v[of_surface]
        distance = np.sqrt(du * du + dv * dv)
        inverse = 1.0 / np.maximum(distance, 1e-300)
        outward = np.where(surface == TOPPING, -1.0, 1.0)
        depth = outward * (distance - t.touch[of_surface])
        normal_u, normal_v = outward * inverse * du, outward * inverse * dv
        flat = surface == FLAT
        depth = np.where(flat, t.flat_u * u + t.flat_v * w - t.flat_at, depth)
        normal_u = np.where(flat, t.flat_u, normal_u) * np.sign(signed)
        normal_v = np.where(flat, t.flat_v, normal_v)
        near = arm[0] * arm[0] + arm[1] * arm[1] < t.reach * t.reach
        depth = np.where(near, depth, 0.0)
        normal = np.stack((normal_u * sin + normal_v * cos, normal_v * sin - normal_u * cos))
        rate = normal[0] * (bushing_v[0] - v[0] + v[2] * arm[1])
        rate += normal[1] * (bushing_v[1] - v[1] - v[2] * arm[0])
        return self.normal_force(t.stiffness[of_surface], depth, rate) * normal


def least_time(call, batches, calls):
    """Least mean time of a call over batches [s]."""
    least = np.inf
    for _ in range(batches):
        begin = time.process_time()
        for _ in range(calls):
            call()
        least = min(least, (time.process_time() - begin) / calls)
    return least


def package_time(drive):
    """Least time of steps over their evaluations [s]."""
    simulation = rc.Simulation(drive)
    simulation.step_to(UNDER_WAY)
    before, state = simulation.stats["evaluations"], simulation.state()

    def run(clock):
        simulation.set_state(state)
        clock.begin()
        step(simulation, SPAN, clock, parts=16)

    runs = EqualRuns(run)
    take_turns([runs])
    return runs.least().seconds / (simulation.stats["evaluations"] - before)


def main():
    """Compare, then time."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--test", action="store_true", help="compare only")
    tried = parser.parse_args().test
    drive = rc.paper_drive()
    right_hand_side = RightHandSide(drive)
    simulation = rc.Simulation(drive)
    worst = touching = 0.0
    states = []
    for t in (0.0, 4.5e-3, 9e-3, 15e-3, UNDER_WAY):
        if t < simulation.time:
            simulation = rc.Simulation(drive)
        simulation.step_to(t)
        positions, velocities = simulation.positions, simulation.velocities
        expected = simulation.evaluate(positions=positions, velocities=velocities, time=t)
        found = right_hand_side(positions.T.copy(), velocities.T.copy()).T
        scale = np.maximum(np.abs(expected.accelerations).max(axis=0), 9.81)
        worst = max(worst, float(np.max(np.abs(found - expected.accelerations) / scale)))
        touching += np.sum(expected.hinge_force > 0.0) + np.sum(expected.tooth_force > 0.0)
        states.append((positions.T.copy(), velocities.T.copy()))
    print(f"NumPy against the package, {touching:.0f} contacts: accelerations differ by", end=" ")
    print(f"{worst:.1e} of the largest")
    # A penetration of 10 nm is a difference of places of 0.1 m, rounded to 1e-17 m.
    if not worst < 1e-8:
        raise SystemExit("error: the right-hand sides differ by more than rounding")
    if tried:
        return
    numpy_time = least_time(lambda: right_hand_side(*states[-1]), 60, 50)
    own = package_time(drive)
    print(f"{'a right-hand side in NumPy':<44}{1e6 * numpy_time:>9.2f} us")
    print(f"{'the package: steps over evaluations':<44}{1e6 * own:>9.2f} us", end=", ")
    print(f"{numpy_time / own:.0f} times as fast")


if __name__ == "__main__":
    main()
