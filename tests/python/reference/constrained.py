"""The constrained equations of motion in plain NumPy: M a + G^T l = f, G a = gamma, dense.

Written from the equations: G by complex steps of the constraint functions, gamma by differences of
G v along the motion.
"""

import numpy as np


def turned(angle, point):
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([cos * point[0] - sin * point[1], sin * point[0] + cos * point[1]])


class Chain:
    """Bars hinged one to the next, from the ground; the last one slides on a line."""

    def __init__(self, masses, inertias, lengths, line):
        self.masses, self.inertias, self.lengths, self.line = masses, inertias, lengths, line

    def constraints(self, q):
        values, before = [], np.zeros(2)
        for k, length in enumerate(self.lengths):
            x, angle = q[3 * k : 3 * k + 2], q[3 * k + 2]
            values.extend(x + turned(angle, (-length / 2, 0.0)) - before)
            before = x + turned(angle, (length / 2, 0.0))
        point, direction = self.line
        values.append(
            -direction[1] * (before[0] - point[0]) + direction[0] * (before[1] - point[1])
        )
        return np.array(values)

    def jacobian(self, q):
        columns = []
        for i in range(len(q)):
            step = np.zeros(len(q), dtype=complex)
            step[i] = 1e-30j
            columns.append(self.constraints(q + step).imag / 1e-30)
        return np.array(columns).T

    def solve(self, q, v, gravity):
        """Accelerations and multipliers, and the condition number of the system."""
        mass = np.diag(np.repeat(self.masses, 3))
        for k, inertia in enumerate(self.inertias):
            mass[3 * k + 2, 3 * k + 2] = inertia
        force = np.zeros(len(q))
        force[1::3] = -gravity * np.array(self.masses)
        g = self.jacobian(q)
        h = 1e-4
        rates = [self.jacobian(q + k * h * v) @ v for k in (-2, -1, 1, 2)]
        gamma = -(rates[0] - 8 * rates[1] + 8 * rates[2] - rates[3]) / (12 * h)
        m = len(gamma)
        system = np.block([[mass, g.T], [g, np.zeros((m, m))]])
        solution = np.linalg.solve(system, np.concatenate([force, gamma]))
        return solution[: len(q)], solution[len(q) :], np.linalg.cond(system)
