"""The typed face of the compiled module."""

from collections.abc import Callable, Sequence
from typing import Any, Literal, final

import numpy as np
import numpy.typing as npt

from rustchain.description.base import Description
from rustchain.description.chain import Chain
from rustchain.description.drive import ChainDrive
from rustchain.description.guides import GuideRail, SmoothIdler
from rustchain.description.laws.film import LubricantFilm
from rustchain.description.laws.force import ForceLaw
from rustchain.description.material import Material
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.scene import Scene
from rustchain.description.solver import Solver
from rustchain.description.sprocket import Sprocket
from rustchain.errors import SimulationError

__all__ = [
    "Case",
    "Core",
    "Ensemble",
    "MechanismCore",
    "bisector",
    "chain_links",
    "closing_center_distance",
    "closing_move",
    "drive_mechanism",
    "effective_restitution",
    "film_forces",
    "fmu_scene",
    "guide_outline",
    "instruction_set",
    "integrate",
    "law_force",
    "layout",
    "link_stiffness",
    "links_around",
    "links_for",
    "mechanism_static_start",
    "panicked",
    "read_toml",
    "static_start",
    "strand_names",
    "tooth_contacts",
    "tooth_outline",
    "tooth_radii",
    "tooth_surfaces",
    "validate",
]

_Array = npt.NDArray[np.float64]

def panicked(message: str, time: float | None) -> SimulationError:
    """Return the exception of a panic caught at the boundary, at a simulated time [s]."""

def validate(description: Description) -> None:
    """Raise InvalidInput, naming the field, its value and what is allowed."""

def instruction_set() -> Literal["avx512", "avx2", "neon", "plain"]:
    """Return the instructions that the kernels run with on this machine.

    "avx512", "avx2" and "neon" give the same bits as each other with the same C library. "plain",
    without fused multiply-add, differs by rounding.
    """

def layout(drive: ChainDrive) -> dict[str, Any]:
    """Return the fields of a DriveReport."""

def static_start(scene: Scene) -> dict[str, Any]:
    """Return positions, velocities and surfaces of a drive at rest, and how well it rests.

    A surface is (bushing, sprocket, surface), each from 0.
    """

def mechanism_static_start(description: Mechanism) -> dict[str, Any]:
    """Return positions, velocities and surfaces of a mechanism at rest, and how well it rests.

    A surface is (contact, side, piece), each from 0.
    """

def fmu_scene(
    scene: Scene,
    positions: _Array | None,
    velocities: _Array | None,
    state: bytes | None,
    inputs: Sequence[tuple[int, str]],
    outputs: Sequence[tuple[str, int | None]],
) -> tuple[bytes, str, list[float]]:
    """Return the scene of an FMU, its instantiation token, and the values of its variables."""

def strand_names(drive: ChainDrive) -> list[str]:
    """Return the names of the strands, in the order of arrays over strands."""

def links_around(drive: ChainDrive) -> int:
    """Return the smallest even number of links that closes round the sprockets where they are."""

def bisector(drive: ChainDrive, number: int) -> tuple[float, float]:
    """Return the unit vector along which a sprocket tightens both strands beside it alike."""

def closing_move(
    drive: ChainDrive, number: int, direction: tuple[float, float], reach: float
) -> float:
    """Return how far [m] sprocket `number` moves along `direction` until the chain is taut."""

def closing_center_distance(pitch: float, teeth: tuple[int, int], links: int) -> float:
    """Return the centre distance [m] at which both strands are taut and straight."""

def links_for(pitch: float, teeth: tuple[int, int], center_distance: float) -> int:
    """Return the smallest even number of links that closes round two sprockets."""

def tooth_outline(sprocket: Sprocket, chain: Chain, points: int) -> _Array:
    """Return the sprocket's closed outline [m], (points_total, 2), in its own frame."""

def guide_outline(guide: GuideRail | SmoothIdler, points: int) -> _Array:
    """Return a guide's closed outline [m], (points_total, 2), x out of its face."""

def tooth_contacts(
    sprocket: Sprocket, chain: Chain, points: _Array, radius: float
) -> tuple[npt.NDArray[np.uint8], _Array, _Array]:
    """Return region, penetration [m] and normal (n, 2) of cylinders at points (n, 2) [m].

    In the frame of the sprocket, its origin in the centre of the teeth; the penetration grows along
    the normal.
    """

def tooth_surfaces(sprocket: Sprocket, chain: Chain) -> list[str]:
    """Return names of the surfaces of whole teeth, from the seat outward."""

def tooth_radii(sprocket: Sprocket, chain: Chain) -> list[float]:
    """Return radii of the surfaces of whole teeth [m]: hollow > 0, round < 0, straight inf."""

def drive_mechanism(
    drive: ChainDrive, force_law: ForceLaw, min_impact_velocity: float
) -> list[tuple[str, dict[str, Any]]]:
    """Return the calls (method of `Mechanism`, keywords) that describe the mechanism of a drive."""

def chain_links(chain: Chain) -> _Array:
    """Return length [m], mass [kg], inertia [kg m^2], 1 for a bushing in front, of each link."""

def link_stiffness(chain: Chain) -> float | None:
    """Return the pull that makes a link longer by a metre [N/m], None where links are rigid."""

def film_forces(
    film: LubricantFilm,
    radii: tuple[float, float],
    length: float,
    eccentricity: npt.NDArray[np.float64],
    velocity: npt.NDArray[np.float64],
) -> _Array:
    """Return the force [N] of a film at each eccentricity [m] and velocity [m/s]."""

def law_force(
    law: ForceLaw,
    kind: Literal["internal", "external", "flat"],
    radius_i: float,
    radius_j: float,
    length: float,
    material: Material,
    penetration: npt.NDArray[np.float64],
) -> _Array:
    """Return the elastic force [N] at each penetration [m]."""

def effective_restitution(damping: str, restitution: float) -> float:
    """Return the restitution that an impact with a damping law really has."""

def read_toml(
    text: str,
) -> tuple[dict[str, Any], dict[tuple[str | int, ...], tuple[int, int]]]:
    """Return the content of a TOML text, and line and column of each key and item in it."""

def integrate(
    fun: Callable[[float, _Array], npt.ArrayLike],
    t_span: tuple[float, float],
    y0: npt.NDArray[np.float64],
    rtol: float,
    atol: float,
    max_step: float,
    max_order: int,
    t_eval: npt.NDArray[np.float64] | None,
) -> dict[str, Any]:
    """Integrate y' = fun(t, y); return t, y, evaluations, steps, rejected."""

@final
class Core:
    """A run of a chain drive, or of a mechanism: model, state and integrator."""

    def __new__(
        cls,
        scene: Scene,
        positions: npt.NDArray[np.float64] | None,
        velocities: npt.NDArray[np.float64] | None,
        surfaces: Sequence[tuple[int, int, int]] = ...,
    ) -> Core: ...
    @property
    def body_names(self) -> list[str]:
        """Names of the bodies, in the order of every (bodies, 3) array."""
    @property
    def joint_names(self) -> list[str]:
        """Names of the joints of a mechanism; none of a drive."""
    @property
    def contact_names(self) -> list[str]:
        """Names of the contacts of a mechanism; none of a drive."""
    def check(self) -> dict[str, Any]:
        """Return the fields of a MechanismReport."""
    @property
    def time(self) -> float:
        """Present time [s]."""
    @property
    def positions(self) -> _Array:
        """Present positions [m, m, rad], (bodies, 3)."""
    @property
    def velocities(self) -> _Array:
        """Present velocities [m/s, m/s, rad/s], (bodies, 3)."""
    def state(self) -> dict[str, Any]:
        """Return all that decides how the run goes on."""
    def restored(self, snapshot: bytes) -> Core:
        """Return the same simulation in the state of `snapshot`; this one stays as it is."""
    def start(self) -> list[_Array]:
        """Return positions and velocities that the simulation was made with."""
    def evaluate(
        self,
        positions: npt.NDArray[np.float64] | None,
        velocities: npt.NDArray[np.float64] | None,
        time: float | None,
    ) -> dict[str, npt.NDArray[Any]]:
        """Return the fields of an Evaluation."""
    def start_recording(
        self,
        duration: float,
        report_step: float,
        groups: list[str] | None = None,
        energy: bool | None = None,
    ) -> None:
        """Begin a recording that ends `duration` [s] from now."""
    def advance(self, wall_budget: float) -> bool:
        """Go on for about `wall_budget` seconds of wall time; return whether the end is reached."""
    def pause_at_reports(self) -> None:
        """Make `advance` return after each report."""
    @property
    def rows(self) -> int:
        """Number of rows in the recording, without those that were taken."""
    def last_row(self, name: str) -> _Array:
        """Return the last row of a channel, flat."""
    def set_input(self, part: int | str, quantity: str, value: object) -> None:
        """Set "speed", "torque" or "tensioner_force" of a sprocket, from 1, or a part by name."""
    def take_recording(self) -> dict[str, npt.NDArray[Any]]:
        """End the recording and return its rows, without those that were taken."""
    def take_rows(self, count: int) -> dict[str, npt.NDArray[Any]]:
        """Remove the first `count` rows, or all of them, and return them; the recording goes on."""
    def step_to(self, t: float, wall_budget: float) -> bool:
        """Go on towards exactly `t` [s]; return whether it is reached."""
    def stats(self) -> dict[str, float]:
        """Return the counts and wall times of the run."""
    def tooth_jumps(self) -> tuple[_Array, npt.NDArray[np.int64], npt.NDArray[np.int64]] | None:
        """Return times [s], sprockets (from 1) and directions of all tooth jumps of a drive."""
    def take_warnings(self) -> tuple[list[str], list[str], list[str]]:
        """Return what is new: laws out of range; the energy balance; tooth jumps."""

@final
class Case:
    """A scene and what to record of it, checked and ready to run."""

    def __new__(
        cls,
        scene: Scene,
        duration: float,
        report_step: float,
        groups: list[str],
        energy: bool,
        positions: npt.NDArray[np.float64] | None,
        velocities: npt.NDArray[np.float64] | None,
        surfaces: Sequence[tuple[int, int, int]] = ...,
    ) -> Case: ...

@final
class Ensemble:
    """Cases on their way, on threads of their own."""

    def __new__(cls, cases: list[Case], threads: int | None) -> Ensemble: ...
    @property
    def simulated(self) -> float:
        """Simulated time that all cases together have behind them [s]."""
    def fetch(self, wall_budget: float) -> tuple[int, Core | None, Exception | None] | None:
        """Wait for about `wall_budget` seconds of wall time for a case that has ended.

        Return its number, its run (None when it did not begin), and what went wrong.
        """
    def close(self) -> None:
        """Stop all cases, and wait until they have."""

def MechanismCore(
    description: Mechanism,
    solver: Solver,
    positions: npt.NDArray[np.float64] | None = ...,
    velocities: npt.NDArray[np.float64] | None = ...,
    surfaces: Sequence[tuple[int, int, int]] = ...,
) -> Core:
    """Assemble a mechanism and return its run."""
