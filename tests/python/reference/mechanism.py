"""Any mechanism in plain NumPy: M a + G^T l = f, G a = gamma, dense, from the description alone.

Written from the equations. Constraints are analytic functions of coordinates and time: G comes by
complex steps; gamma, the second derivative along the motion, by Cauchy's integral over a circle.
Loads of springs and contacts are generalised forces: force times slope of length or of distance.
"""

import numpy as np

from reference.outline import Outline

CIRCLE = np.exp(2j * np.pi * np.arange(32) / 32)
RADIUS = 0.05  # of Cauchy's circle [s]: far from any singularity


def turned(angle, point):
    """A vector of a body's frame in the ground's."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([cos * point[0] - sin * point[1], sin * point[0] + cos * point[1]])


def place(row, point):
    return row[:2] + turned(row[2], point)


class Reference:
    """Accelerations, reactions and forces of a `rustchain.Mechanism` at any state."""

    def __init__(self, mechanism):
        self.m = mechanism
        self.number = {"ground": 0} | {b.name: i + 1 for i, b in enumerate(mechanism.bodies)}
        placed = [(0.0, 0.0, 0.0)] + [b.position for b in mechanism.bodies]
        self.placed = np.array(placed, dtype=float)
        self.free = [i + 1 for i, b in enumerate(mechanism.bodies) if not b.fixed]
        masses = [[b.mass, b.mass, b.inertia] for b in mechanism.bodies if not b.fixed]
        self.mass = np.array(masses).ravel()

    def ends(self, part):
        return self.number[part.body_a], self.number[part.body_b]

    def all(self, q):
        """Rows of all bodies from the free coordinates."""
        rows = self.placed.astype(np.result_type(q, float))
        rows[self.free] = np.reshape(q, (-1, 3))
        return rows

    def quantity(self, joint, rows):
        """What a joint holds, without the value that it is held at."""
        a, b = self.ends(joint)
        d = place(rows[b], joint.point_b) - place(rows[a], joint.point_a)
        angle = rows[b, 2] - rows[a, 2]
        unit = np.array(joint.direction) / np.hypot(*joint.direction)
        along = turned(rows[a, 2], unit) @ d
        across = turned(rows[a, 2], (-unit[1], unit[0])) @ d
        if joint.kind == "gear":
            carrier = rows[self.number[joint.carrier or "ground"], 2]
            gear = (rows[b, 2] - carrier) - joint.value * (rows[a, 2] - carrier)
            return np.array([gear])
        if joint.kind == "distance":
            return np.array([d @ d / (2.0 * self.rod(joint))])
        return np.array(
            {
                "revolute": [*d],
                "fixed": [*d, angle],
                "prismatic": [across, angle],
                "point_on_line": [across],
                "rack": [along - (joint.value or 0.0) * angle],
                "driven_angle": [angle],
                "driven_position": [along],
            }[joint.kind]
        )

    def rod(self, joint):
        """Length of a distance joint; off the constraint the form (d^2 - L^2) / 2L matters."""
        return self.length(joint, self.placed) if joint.value is None else joint.value

    def held(self, joint, t):
        """The values that a joint holds its quantity at."""
        start = self.quantity(joint, self.placed)
        if joint.kind in ("revolute", "point_on_line"):
            return 0.0 * start
        if joint.kind == "fixed":
            return np.array([0.0, 0.0, start[2] if joint.value is None else joint.value])
        if joint.kind == "prismatic":
            return np.array([0.0, start[1] if joint.value is None else joint.value])
        if joint.kind == "distance":
            return np.array([0.5 * self.rod(joint)])
        if joint.kind in ("gear", "rack"):
            return start
        terms = np.array(joint.motion.terms)
        amplitude, frequency, phase = terms.T
        if joint.by_speed:
            waves = amplitude / frequency * (np.cos(phase) - np.cos(frequency * t + phase))
            return start + joint.motion.offset * t + waves.sum()
        return np.array([joint.motion.offset + (amplitude * np.sin(frequency * t + phase)).sum()])

    def constraints(self, q, t):
        rows = self.all(q)
        parts = [self.quantity(joint, rows) - self.held(joint, t) for joint in self.m.joints]
        return np.concatenate(parts) if parts else np.zeros(0)

    def jacobian(self, q, t):
        steps = 1e-30j * np.eye(len(q))
        columns = [self.constraints(q + step, t).imag / 1e-30 for step in steps]
        return np.array(columns).T.reshape(-1, len(q))

    def gamma(self, q, v, t):
        """Less the second derivative of the constraints along q + v s, t + s."""
        values = [self.constraints(q + RADIUS * z * v, t + RADIUS * z) for z in CIRCLE]
        second = 2.0 * np.mean(np.array(values).T / CIRCLE**2, axis=1) / RADIUS**2
        return -second.real

    def slope(self, function, q):
        """Value and gradient of an analytic function of all rows."""
        steps = 1e-30j * np.eye(len(q))
        return function(self.all(q)), np.array(
            [function(self.all(q + step)).imag / 1e-30 for step in steps]
        )

    def length(self, part, rows):
        a, b = self.ends(part)
        d = place(rows[b], part.point_b) - place(rows[a], part.point_a)
        return np.sqrt(d @ d)

    def twist(self, part, rows):
        a, b = self.ends(part)
        return rows[b, 2] - rows[a, 2]

    def loads(self, q, v, t):
        f = np.zeros(len(q))
        rows = self.all(q)
        for axis in range(2):
            f[axis::3] = self.mass[::3] * self.m.gravity[axis]
        for force in self.m.forces:
            if force.kind in ("spring", "torsion_spring"):
                measure = self.length if force.kind == "spring" else self.twist
                value, slope = self.slope(lambda r, p=force, g=measure: g(p, r), q)
                rest = measure(force, self.placed) if force.rest is None else force.rest
                x, rate = value - rest, slope @ v
                elastic = force.stiffness * x + force.cubic * x**3
                if force.table is not None:
                    elastic = np.interp(x, *np.array(force.table).T)
                f -= (elastic + force.damping * rate) * slope
            elif force.kind in ("torque", "torque_by_speed"):
                _, slope = self.slope(lambda r, p=force: self.twist(p, r), q)
                torque = force.x
                if force.kind == "torque_by_speed":
                    torque = np.interp(slope @ v, *np.array(force.table).T)
                f += torque * slope
            elif force.kind == "force":
                b = self.number[force.body_b]
                given = np.array([force.x, force.y])
                push = turned(rows[b, 2], given) if force.follows else given
                _, slope = self.slope(lambda r, p=force, k=b, g=push: place(r[k], p.point_b) @ g, q)
                f += slope
        return f

    def distance(self, contact, rows):
        """Distance of the circle's centre from the surface."""
        a, b = self.ends(contact)
        d = place(rows[b], contact.point_b) - place(rows[a], contact.point_a)
        if contact.kind == "bore":
            return contact.profile_radius - np.sqrt(d @ d)
        if contact.kind == "disc":
            return np.sqrt(d @ d) - contact.profile_radius
        start, end = (np.array(p) for p in contact.points)
        along = (end - start) / np.hypot(*(end - start))
        outward = turned(rows[a, 2], (along[1], -along[0]))
        return outward @ d - np.array([along[1], -along[0]]) @ start

    def center(self, contact, rows):
        """The circle's centre in the frame of the outline."""
        a, b = self.ends(contact)
        d = place(rows[b], contact.point_b) - place(rows[a], contact.point_a)
        return turned(-rows[a, 2], d)

    def is_in_front(self, q):
        """Whether every circle is in front of its outline, and of its ends where these are near."""
        for contact in self.m.contacts:
            if contact.kind in ("polyline", "arcs"):
                point = self.center(contact, self.all(q))
                found, behind_end = Outline(contact).places(point)
                if found is None or behind_end <= contact.radius:
                    return False
        return True

    def distances(self, contact, q):
        """Signs and distances, functions of all rows, of all places where the circle may bear."""
        segment = contact.kind == "polyline" and len(contact.points) == 2
        if segment or contact.kind not in ("polyline", "arcs"):
            return [(1.0, lambda rows: self.distance(contact, rows))]
        found, _ = Outline(contact).places(self.center(contact, self.all(q)))
        return [
            (sign, lambda rows, of=distance: of(self.center(contact, rows)))
            for sign, distance in found
        ]

    def contacts(self, q, v):
        """Force of each contact, the generalised forces of all, and the forces' round-off.

        Distances are known to some digits of the size, and forces by their slope times that.
        """
        forces, f, rounding = [], np.zeros(len(q)), 0.0
        size = 1.0 + np.abs(q).max()
        for contact in self.m.contacts:
            law, total = contact.law, np.zeros(len(q))
            for sign, distance in self.distances(contact, q):
                value, slope = self.slope(distance, q)
                depth, rate = contact.radius - value, -slope @ v
                if depth <= 0.0:
                    continue
                exponent = getattr(law, "exponent", 1.0)
                elastic = law.stiffness * depth**exponent
                if hasattr(law, "exponent"):
                    force = elastic * max(1.0 + law.damping * rate, 0.0)
                else:
                    force = max(elastic + law.damping * rate, 0.0)
                total += sign * force * slope
                stiffness = exponent * elastic / depth + law.damping * (elastic + 1.0)
                rounding += 4e-16 * size * stiffness * (1.0 + abs(rate))
            f += total
            i = 3 * self.free.index(self.number[contact.body_b])
            forces.append(np.hypot(*total[i : i + 2]))
        return np.array(forces), f, rounding

    def solve(self, q, v, t):
        """Accelerations, loads of joints on bodies b at points b, forces, condition, round-off."""
        forces, pushes, rounding = self.contacts(q, v)
        f = self.loads(q, v, t) + pushes
        g, gamma = self.jacobian(q, t), self.gamma(q, v, t)
        n, m = len(q), len(gamma)
        system = np.block([[np.diag(self.mass), g.T], [g, np.zeros((m, m))]])
        solution = np.linalg.solve(system, np.concatenate([f, gamma]))
        rows, reactions, first = self.all(q), [], 0
        for joint in self.m.joints:
            count = len(self.quantity(joint, self.placed))
            b = self.number[joint.body_b]
            part = slice(first, first + count)
            first += count
            i = 3 * self.free.index(b)
            load = -g[part, i : i + 3].T @ solution[n:][part]
            arm = turned(rows[b, 2], joint.point_b)
            load[2] -= arm[0] * load[1] - arm[1] * load[0]
            reactions.append(load)
        return solution[:n], np.array(reactions), forces, np.linalg.cond(system), rounding
