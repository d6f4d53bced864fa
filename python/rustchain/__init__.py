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
    Material,
    PrescribedSpeed,
    Sprocket,
    StraightTooth,
    Tensioner,
    ToothArc,
    ToothLine,
)
from rustchain.errors import (
    EnergyWarning,
    InvalidInput,
    NotRecorded,
    RangeWarning,
    SimulationError,
)
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
from rustchain.friction import Coulomb
from rustchain.layouts import chain_drive
from rustchain.mechanism import Mechanism
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
from rustchain.mechanism_simulation import MechanismEvaluation, MechanismSimulation
from rustchain.report import DriveReport
from rustchain.result import Result, load_result
from rustchain.simulation import Evaluation, Simulation, Solver
from rustchain.sweep import sweep
from rustchain.sweep_result import SweepResult

__version__ = version("rustchain")

__all__ = [
    "AnsiTooth",
    "AppliedTorque",
    "Chain",
    "ChainDrive",
    "ChainSize",
    "ClearanceHinge",
    "Coulomb",
    "CustomTooth",
    "DriveReport",
    "EnergyWarning",
    "EnhancedCylinder",
    "Esdu78035",
    "Evaluation",
    "ForceLaw",
    "Free",
    "Hertz",
    "HertzCylinder",
    "HuntCrossley",
    "InvalidInput",
    "IsoTooth",
    "Johnson",
    "LankaraniNikravesh",
    "Linear",
    "LinearContact",
    "Link",
    "LiuConformal",
    "Material",
    "Mechanism",
    "MechanismEvaluation",
    "MechanismReport",
    "MechanismResult",
    "MechanismSimulation",
    "NotRecorded",
    "PrescribedSpeed",
    "Radzimovsky",
    "RangeWarning",
    "Result",
    "Simulation",
    "SimulationError",
    "Sines",
    "SmoothStep",
    "Solver",
    "Spline",
    "Sprocket",
    "StraightTooth",
    "SurfaceContact",
    "SweepResult",
    "Table",
    "Tensioner",
    "ToothArc",
    "ToothLine",
    "catalogue",
    "catalogue_chain",
    "chain_drive",
    "instruction_set",
    "load_result",
    "paper_drive",
    "restitution_obtained",
    "sweep",
    "two_sprocket_drive",
]
