"""Other solvers on the same compiled right-hand side: called from Rust, or from SciPy."""

from __future__ import annotations

import ctypes as c
import importlib.metadata
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

WHY = ["out of time at {:.3g} s", "", "failed at {:.3g} s"]
HERE = Path(__file__).parent.parent / "compiled_rhs"
_POINTER = c.POINTER(c.c_double)
MOST_PARTS = 2**16  # of a run


class _Outcome(c.Structure):
    _fields_ = [
        ("steps", c.c_uint64),
        ("evaluations", c.c_uint64),
        ("jacobians", c.c_uint64),
        ("onsets", c.c_uint64),
        ("finished", c.c_uint64),
        ("reached", c.c_double),
        ("wall", c.c_double),
        ("uncharged", c.c_double),
        ("residual", c.c_double),
        ("dissipated", c.c_double),
        ("deducted", c.c_double),
        ("parts", c.c_uint64),
    ]


class _Tableau(c.Structure):
    _fields_ = [
        ("stages", c.c_size_t),
        ("order", c.c_double),
        ("a", _POINTER),
        ("b", _POINTER),
        ("c", _POINTER),
        ("error", _POINTER),
        ("error_3", _POINTER),
    ]


@dataclass
class Run:
    """Result of one run; times in s, energies in J.

    `parts` are the times of parts of the run, and `deducted` what is not charged of their sum.
    """

    wall: float
    steps: int = 0
    evaluations: int = 0
    jacobians: int = 0
    onsets: int = 0
    reached: float = np.inf
    finished: bool = True
    residual: float = np.nan
    dissipated: float = np.nan
    positions: np.ndarray | None = None
    error: float = np.nan
    why: str = ""
    parts: np.ndarray | None = None
    deducted: float = 0.0


@dataclass(frozen=True)
class Start:
    """The published drive with a pretension [N], and where it starts; None: as it is laid."""

    pretension: float
    positions: np.ndarray | None = None
    velocities: np.ndarray | None = None

    @property
    def ramp_time(self):
        """Time in which the pretension grows [s]: none where the start is already under load."""
        return 0.1 if self.positions is None else 0.0


def _array(values):
    return np.ascontiguousarray(values, dtype=np.float64)


def _pointer(array):
    return None if array is None else array.ctypes.data_as(_POINTER)


def _library():
    path = HERE / "target/release/libcompiled_rhs.so"
    if not path.exists():
        raise SystemExit(f"error: {path} is missing; `make reference-solvers` builds it")
    library = c.CDLL(str(path))
    library.drive_system.restype = c.c_void_p
    library.drive_system.argtypes = [c.c_double] * 3 + [_POINTER] * 2 + [c.c_size_t, c.c_bool]
    library.kepler_system.restype = c.c_void_p
    library.pin_system.restype = c.c_void_p
    library.pin_system.argtypes = [c.c_double]
    library.system_free.argtypes = [c.c_void_p]
    library.system_dimension.argtypes = [c.c_void_p]
    library.system_dimension.restype = c.c_size_t
    library.system_start.argtypes = [c.c_void_p, c.c_void_p, c.c_void_p]
    library.right_hand_side.argtypes = [c.c_double] + [c.c_void_p] * 3
    library.accepted_step.argtypes = [c.c_void_p, c.c_double, c.c_void_p]
    library.drive_balance.argtypes = [c.c_void_p, c.c_double, c.c_void_p, c.c_void_p]
    library.drive_positions.argtypes = [c.c_void_p, c.c_double, c.c_void_p, c.c_void_p]
    library.pin_error.argtypes = [c.c_void_p, c.c_void_p]
    library.pin_error.restype = c.c_double
    library.integrate.argtypes = [
        c.c_void_p,
        c.c_int32,
        c.c_double,
        c.c_double,
        c.c_double,
        c.POINTER(_Tableau),
        c.c_char_p,
        c.c_void_p,
        c.c_void_p,
        c.c_size_t,
        c.POINTER(_Outcome),
    ]
    return library


def _cvode_library():
    """Path of the CVODE that scikit-sundae brings along."""
    try:
        files = importlib.metadata.files("scikit-sundae") or []
    except importlib.metadata.PackageNotFoundError:
        raise SystemExit(
            "error: scikit-sundae is missing; `make reference-solvers` installs it"
        ) from None
    found = [file for file in files if "libsundials_cvode" in file.name]
    if not found:
        raise SystemExit("error: scikit-sundae has no libsundials_cvode; install its wheel")
    return str(found[0].locate()).encode()


class System:
    """A problem behind the C interface; ends with the `with` block.

    `metered` drives sum their energies along every step, which takes time.
    """

    def __init__(self, problem, metered=False):
        self.library = LIBRARY
        self.problem = problem
        self.metered = metered

    def __enter__(self):
        problem = self.problem
        if problem == "kepler":
            self.handle = self.library.kepler_system()
        elif isinstance(problem, float):
            self.handle = self.library.pin_system(problem)
        else:
            self.kept = [
                None if rows is None else _array(rows)
                for rows in (problem.positions, problem.velocities)
            ]
            bodies = 0 if self.kept[0] is None else len(self.kept[0])
            self.handle = self.library.drive_system(
                problem.pretension,
                problem.ramp_time,
                1e-3,
                *map(_pointer, self.kept),
                bodies,
                self.metered,
            )
        if not self.handle:
            raise SystemExit(f"error: no system for {problem}")
        self.dimension = self.library.system_dimension(self.handle)
        self.y, self.scale = np.empty(self.dimension), np.empty(self.dimension)
        self.library.system_start(self.handle, self.y.ctypes.data, self.scale.ctypes.data)
        return self

    def __exit__(self, *_):
        self.library.system_free(self.handle)

    def positions(self, t, y):
        """x, y, θ of all bodies of a drive, (bodies, 3)."""
        out = np.empty((40, 3))
        self.library.drive_positions(self.handle, t, y.ctypes.data, out.ctypes.data)
        return out

    def slope(self, t, y):
        """dy/dt."""
        out = np.empty(self.dimension)
        self.library.right_hand_side(t, y.ctypes.data, out.ctypes.data, self.handle)
        return out


def _tableau(method):
    """Coefficients of one of SciPy's embedded pairs, as they stand there; keeps the arrays."""
    stages = method.n_stages
    a = np.zeros((stages, stages))
    given = method.A[:stages, :stages]
    a[:, : given.shape[1]] = given
    b, nodes = _array(method.B), _array(method.C[:stages])
    if hasattr(method, "E5"):
        error, error_3 = _array(method.E5), _array(method.E3)
    else:
        error, error_3 = _array(method.E), None
    kept = (a, b, nodes, error, error_3)
    return _Tableau(stages, method.error_estimator_order + 1.0, *map(_pointer, kept)), kept


def compiled(problem, method, tolerance, end, wall=1e9, metered=False):
    """Integrate with `method` of `COMPILED`, no Python in between; `Run` and the final y."""
    with System(problem, metered) as system:
        outcome, y, marks = _Outcome(), np.empty(system.dimension), np.empty(MOST_PARTS)
        number, pair = COMPILED[method]
        tableau, _kept = _tableau(pair) if pair else (None, None)
        failed = LIBRARY.integrate(
            system.handle,
            number,
            tolerance,
            end,
            wall,
            tableau,
            CVODE,
            y.ctypes.data,
            marks.ctypes.data,
            MOST_PARTS,
            outcome,
        )
        if failed:
            raise SystemExit(f"error: {method} cannot be run from {CVODE.decode()}")
        finished = outcome.finished == 1
        run = Run(
            wall=outcome.wall,
            steps=outcome.steps,
            evaluations=outcome.evaluations,
            jacobians=outcome.jacobians,
            onsets=outcome.onsets,
            reached=outcome.reached,
            finished=finished,
            residual=outcome.residual,
            dissipated=outcome.dissipated,
            why=WHY[outcome.finished].format(outcome.reached),
            parts=np.diff(marks[: outcome.parts], prepend=0.0),
            deducted=outcome.deducted,
        )
        if isinstance(problem, Start) and finished:
            run.positions = system.positions(end, y)
        if isinstance(problem, float):
            run.error = LIBRARY.pin_error(system.handle, y.ctypes.data)
        return run, y


def scipy_solver(problem, method, tolerance, end, wall):
    """Integrate with one of SciPy's solvers, step by step, the right-hand side through ctypes."""
    solver_class = SCIPY[method]
    with System(problem, metered=True) as system:
        begin = time.thread_time()
        solver = solver_class(
            system.slope, 0.0, system.y.copy(), end, rtol=max(tolerance, 3e-14), atol=tolerance
        )
        steps, uncharged, why = 0, 0.0, ""
        while solver.status == "running":
            message = solver.step()
            steps += 1
            now = time.thread_time()
            if solver.status == "failed":
                why = str(message)
                break
            system.library.accepted_step(system.handle, solver.t, solver.y.ctypes.data)
            uncharged += time.thread_time() - now
            if now - begin > wall:
                why = WHY[0].format(solver.t)
                break
        run = Run(
            wall=time.thread_time() - begin - uncharged,
            steps=steps,
            evaluations=int(solver.nfev),
            jacobians=int(getattr(solver, "njev", 0) or 0),
            reached=float(solver.t),
            finished=not why,
            why=why,
        )
        if isinstance(problem, Start) and run.finished:
            y = np.ascontiguousarray(solver.y)
            run.positions = system.positions(end, y)
            balance = np.empty(3)
            system.library.drive_balance(system.handle, end, y.ctypes.data, balance.ctypes.data)
            run.residual, run.dissipated, run.onsets = balance[0], balance[1], int(balance[2])
        return run, solver.y


def load():
    """Load the compiled right-hand side and the other solvers; what is missing is said at once."""
    global LIBRARY, CVODE, COMPILED, SCIPY
    from scipy import integrate

    LIBRARY, CVODE = _library(), _cvode_library()
    COMPILED = {
        "RK4": (0, None),
        "Dormand-Prince 5(4)": (1, integrate.RK45),
        "DOP853": (1, integrate.DOP853),
        "CVODE Adams, functional": (2, None),
        "CVODE Adams": (3, None),
        "CVODE BDF": (4, None),
    }
    names = ("RK45", "DOP853", "LSODA", "Radau", "BDF")
    SCIPY = {f"SciPy {name}": getattr(integrate, name) for name in names}
