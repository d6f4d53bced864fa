"""Planar multibody simulation of chain drives with clearance and compliant contact.

>>> import rustchain as rc
>>> drive = rc.paper_drive(pretension=25.0)
>>> result = rc.Simulation(drive).run(duration=2e-3, progress=False)
>>> force = result.bushing(6).tooth_force  # [N], shape (times,)
"""

from typing import TYPE_CHECKING

from rustchain._rustchain import instruction_set
from rustchain.catalogue.generators import chain_drive, open_chain
from rustchain.catalogue.sizes import ChainSize
from rustchain.catalogue.standard import catalogue, catalogue_chain, paper_drive, two_sprocket_drive
from rustchain.description.drive import (
    AnsiTooth,
    AppliedTorque,
    Chain,
    ChainDrive,
    ClearanceHinge,
    CustomTooth,
    Free,
    IsoTooth,
    Link,
    Plates,
    PrescribedSpeed,
    Roller,
    Sprocket,
    StraightTooth,
    Tensioner,
    ToothArc,
    ToothLine,
)
from rustchain.description.ends import AnchoredEnd, FreeEnd, LoadedEnd
from rustchain.description.guides import GuideArm, GuideRail, SmoothIdler
from rustchain.description.laws.film import LubricantFilm
from rustchain.description.laws.force import (
    EnhancedCylinder,
    Esdu78035,
    ForceLaw,
    Hertz,
    HertzCylinder,
    Johnson,
    LankaraniNikravesh,
    Linear,
    LiuConformal,
    Radzimovsky,
    effective_restitution,
)
from rustchain.description.laws.friction import Coulomb, LuGre
from rustchain.description.material import Material
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.mechanism.functions import Sines, SmoothStep, Spline, Table
from rustchain.description.mechanism.parts import HuntCrossley, LinearContact, SurfaceContact
from rustchain.description.mechanism.report import MechanismReport
from rustchain.description.report import DriveReport
from rustchain.description.scene import Scene
from rustchain.description.solver import Solver
from rustchain.errors import (
    CaseWarning,
    EnergyWarning,
    InvalidInput,
    MissingExtra,
    NoSuchPart,
    NotRecorded,
    RangeWarning,
    RustchainError,
    RustchainWarning,
    SimulationError,
    ToothJumpWarning,
)
from rustchain.files.scene import load_scene, save_scene
from rustchain.names import suggest
from rustchain.results.files import load_result
from rustchain.results.result import Result
from rustchain.simulation.evaluation import Evaluation
from rustchain.simulation.part_stop import ContactForceAbove, JointForceAbove
from rustchain.simulation.simulation import Simulation
from rustchain.simulation.stop import (
    HingeForceAbove,
    StopCondition,
    StrandSlack,
    TimeReached,
    ToothForceAbove,
    ToothJump,
)
from rustchain.sweeps.loss_map import loss_map
from rustchain.sweeps.result import SweepResult
from rustchain.sweeps.samples import samples
from rustchain.sweeps.study import StudyResult, study
from rustchain.sweeps.sweep import sweep
from rustchain.units import rpm

__version__: str

__all__ = [
    "AnchoredEnd",
    "AnsiTooth",
    "AppliedTorque",
    "CaseWarning",
    "Chain",
    "ChainDrive",
    "ChainSize",
    "ClearanceHinge",
    "ContactForceAbove",
    "Coulomb",
    "CustomTooth",
    "DriveReport",
    "EnergyWarning",
    "EnhancedCylinder",
    "Esdu78035",
    "Evaluation",
    "ForceLaw",
    "Free",
    "FreeEnd",
    "GuideArm",
    "GuideRail",
    "Hertz",
    "HertzCylinder",
    "HingeForceAbove",
    "HuntCrossley",
    "InvalidInput",
    "IsoTooth",
    "Johnson",
    "JointForceAbove",
    "LankaraniNikravesh",
    "Linear",
    "LinearContact",
    "Link",
    "LiuConformal",
    "LoadedEnd",
    "LuGre",
    "LubricantFilm",
    "Material",
    "Mechanism",
    "MechanismReport",
    "MissingExtra",
    "NoSuchPart",
    "NotRecorded",
    "Plates",
    "PrescribedSpeed",
    "Radzimovsky",
    "RangeWarning",
    "Result",
    "Roller",
    "RustchainError",
    "RustchainWarning",
    "Scene",
    "Simulation",
    "SimulationError",
    "Sines",
    "SmoothIdler",
    "SmoothStep",
    "Solver",
    "Spline",
    "Sprocket",
    "StopCondition",
    "StraightTooth",
    "StrandSlack",
    "StudyResult",
    "SurfaceContact",
    "SweepResult",
    "Table",
    "Tensioner",
    "TimeReached",
    "ToothArc",
    "ToothForceAbove",
    "ToothJump",
    "ToothJumpWarning",
    "ToothLine",
    "catalogue",
    "catalogue_chain",
    "chain_drive",
    "effective_restitution",
    "instruction_set",
    "load_result",
    "load_scene",
    "loss_map",
    "open_chain",
    "paper_drive",
    "rpm",
    "samples",
    "save_scene",
    "study",
    "sweep",
    "two_sprocket_drive",
]


def __dir__() -> list[str]:
    return __all__


if not TYPE_CHECKING:  # for checkers, other names are none

    def __getattr__(name: str) -> str:
        if name == "__version__":  # reading it takes longer than the package's own modules
            from importlib.metadata import version

            from rustchain.extras import DISTRIBUTION

            return version(DISTRIBUTION)
        msg = f"module 'rustchain' has no attribute {name!r}; {suggest(name, __all__)}"
        raise AttributeError(msg)
