"""A path of the drive in time, with the memory each contact keeps from its onset to its end.

SciPy's DOP853 does the steps. Between onsets the right-hand side knows which pairs are in contact,
so that a pair without memory pushes nothing and the equations stay smooth across its onset. After
each step the depths are looked through; the step with an onset is done again to end at the
earliest crossing, where the approach speed is read off and kept.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853
from scipy.optimize import brentq

from reference.dynamics import Memory

if TYPE_CHECKING:
    from reference.dynamics import Array, DriveEquations, Kinematics

CROSSING_TIME = 1e-15  # to which an onset is found [s]


@dataclass
class Path:
    """Where a path ends, and its onsets on the way.

    Attributes
    ----------
    positions, velocities : ndarray, shape (bodies, 3)
        [m, m, rad] and [m/s, m/s, rad/s].
    hinge_onsets : list of (float, int)
        Time [s] and hinge of each onset.
    tooth_onsets : list of (float, int, int)
        Time [s], bushing and sprocket of each onset.
    evaluations : int
        Of the right-hand side.
    """

    positions: Array
    velocities: Array
    hinge_onsets: list[tuple[float, int]] = field(default_factory=list)
    tooth_onsets: list[tuple[float, int, int]] = field(default_factory=list)
    evaluations: int = 0


def follow(
    equations: DriveEquations,
    positions: Array,
    velocities: Array,
    end: float,
    rtol: float = 1e-12,
    atol: float = 1e-14,
    max_step: float = 2e-5,
) -> Path:
    """Integrate from time zero, with nothing in contact, to ``end`` [s]."""
    shape = positions.shape
    hinges, sprockets = equations.links, shape[0] - equations.links
    memory = Memory(
        hinge_speed=np.full(hinges, np.nan),
        tooth_speed=np.full((hinges, sprockets), np.nan),
        tooth_region=np.zeros((hinges, sprockets), dtype=np.int64),
    )
    path = Path(positions, velocities)

    def kinematics(y: Array) -> Kinematics:
        q, v = np.asarray(y, dtype=np.float64).reshape(2, *shape)
        return equations.kinematics(q, v)

    def depths(y: Array) -> Array:
        kin = kinematics(y)
        return np.concatenate([kin.hinge_penetration, kin.tooth_penetration.ravel()])

    def active() -> NDArray[np.bool_]:
        return ~np.isnan(np.concatenate([memory.hinge_speed, memory.tooth_speed.ravel()]))

    def right_hand_side(t: float, y: Array) -> Array:
        q, v = y.reshape(2, *shape)
        path.evaluations += 1
        accelerations = equations.evaluate(q, v, t, memory).accelerations
        return np.concatenate([v.ravel(), accelerations.ravel()])

    def onset(t: float, y: Array, pair: int) -> None:
        kin = kinematics(y)
        if pair < hinges:
            memory.hinge_speed[pair] = max(kin.hinge_rate[pair], equations.floor)
            path.hinge_onsets.append((t, pair))
            return
        k, s = divmod(pair - hinges, sprockets)
        memory.tooth_speed[k, s] = max(kin.tooth_rate[k, s], equations.floor)
        memory.tooth_region[k, s] = kin.tooth_region[k, s]
        path.tooth_onsets.append((t, k, s))

    def separations(depth: Array) -> None:
        ended = active() & (depth <= 0.0)
        memory.hinge_speed[ended[:hinges]] = np.nan
        over = ended[hinges:].reshape(hinges, sprockets)
        memory.tooth_speed[over] = np.nan
        memory.tooth_region[over] = 0

    def solver(t: float, y: Array, bound: float, first: float | None) -> DOP853:
        if first is not None:
            first = min(first, bound - t)
        return DOP853(
            right_hand_side, t, y, bound, max_step, rtol=rtol, atol=atol, first_step=first
        )

    def crossing(before: DOP853, pairs: Array) -> tuple[float, int]:
        """Earliest crossing inside the step just made, by its dense output."""
        dense = before.dense_output()
        found = []
        for pair in pairs:
            root = brentq(
                lambda t, pair=pair: depths(dense(t))[pair],
                before.t_old,
                before.t,
                xtol=CROSSING_TIME,
                rtol=4.0 * np.finfo(float).eps,
            )
            found.append((float(root), int(pair)))
        return min(found)

    t, y = 0.0, np.concatenate([positions.ravel(), velocities.ravel()])
    run = solver(t, y, end, None)
    while t < end:
        y_old = y
        message = run.step()
        if run.status == "failed":
            raise RuntimeError(message)
        depth = depths(run.y)
        new = np.flatnonzero(~active() & (depth > 0.0))
        if len(new) == 0:
            t, y = run.t, run.y
            separations(depth)
            continue
        at, pair = crossing(run, new)
        step = float(run.t - t)
        if at > t:
            # The same step again, to end at the crossing: its last digit matters more than time.
            run = solver(t, y_old, at, at - t)
            while run.status == "running":
                run.step()
            t, y = at, run.y
        onset(t, y, pair)
        run = solver(t, y, end, min(step, 1e-8))
    path.positions, path.velocities = y.reshape(2, *shape)
    return path
