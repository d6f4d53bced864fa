"""Planar multibody simulation of chain drives with clearance and compliant contact.

>>> import rustchain as rc
>>> drive = rc.paper_drive(pretension=25.0)
>>> result = rc.Simulation(drive).run(duration=2e-3, progress=False)
>>> force = result.bushing(6).tooth_force  # [N], shape (times,)
"""

from importlib.metadata import version

from rustchain._rustchain import instruction_set
from rustchain.catalogue import catalogue, catalogue_chain, paper_drive, two_sprocket_drive
from rustchain.chain_sizes import ChainSize
from rustchain.drive import (
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
from rustchain.ends import Anchor, Load, LooseEnd
from rustchain.errors import (
    EnergyWarning,
    InvalidInput,
    NotRecorded,
    RangeWarning,
    SimulationError,
    ToothJumpWarning,
)
from rustchain.film import Film
from rustchain.force_law import (
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
    restitution_obtained,
)
from rustchain.friction import Coulomb, LuGre
from rustchain.guides import GuideArm, GuideRail, SmoothIdler
from rustchain.layouts import chain_drive, open_chain
from rustchain.loss_map import loss_map
from rustchain.material import Material
from rustchain.mechanism import Mechanism
from rustchain.mechanism_evaluation import MechanismEvaluation
from rustchain.mechanism_parts import (
    HuntCrossley,
    LinearContact,
    Sines,
    SmoothStep,
    Spline,
    SurfaceContact,
    Table,
)
from rustchain.mechanism_report import MechanismReport
from rustchain.mechanism_result import MechanismResult
from rustchain.mechanism_simulation import MechanismSimulation
from rustchain.mechanism_stop import ContactForceAbove, JointForceAbove
from rustchain.report import DriveReport
from rustchain.result import Result
from rustchain.result_file import load_result
from rustchain.scene import Scene, load_scene
from rustchain.simulation import Evaluation, Simulation, Solver
from rustchain.stop import (
    HingeForceAbove,
    StopCondition,
    StrandSlack,
    TimeReached,
    ToothForceAbove,
    ToothJump,
)
from rustchain.study import StudyResult, study
from rustchain.sweep import sweep
from rustchain.sweep_result import SweepResult

__version__ = version("rustchain")

__all__ = [
    "Anchor",
    "AnsiTooth",
    "AppliedTorque",
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
    "Film",
    "ForceLaw",
    "Free",
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
    "Load",
    "LooseEnd",
    "LuGre",
    "Material",
    "Mechanism",
    "MechanismEvaluation",
    "MechanismReport",
    "MechanismResult",
    "MechanismSimulation",
    "NotRecorded",
    "Plates",
    "PrescribedSpeed",
    "Radzimovsky",
    "RangeWarning",
    "Result",
    "Roller",
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
    "instruction_set",
    "load_result",
    "load_scene",
    "loss_map",
    "open_chain",
    "paper_drive",
    "restitution_obtained",
    "study",
    "sweep",
    "two_sprocket_drive",
]
