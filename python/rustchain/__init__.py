"""Planar multibody simulation of chain drives with clearance and compliant contact.

>>> import rustchain as rc
>>> drive = rc.paper_drive(pretension=25.0)
>>> result = rc.Simulation(drive).run(duration=2e-3, progress=False)
>>> force = result.bushing(6).tooth_force  # [N], shape (times,)
"""

from importlib import import_module
from typing import TYPE_CHECKING

from rustchain import _rustchain as _rustchain  # an incomplete installation fails here

if TYPE_CHECKING:
    from rustchain import plot as plot
    from rustchain._rustchain import instruction_set as instruction_set
    from rustchain.catalogue.generators import chain_drive as chain_drive, open_chain as open_chain
    from rustchain.catalogue.sizes import ChainSize as ChainSize
    from rustchain.catalogue.standard import (
        catalogue_chain as catalogue_chain,
        chain_sizes as chain_sizes,
        paper_drive as paper_drive,
        two_sprocket_drive as two_sprocket_drive,
    )
    from rustchain.description.chain import (
        Chain as Chain,
        ClearanceHinge as ClearanceHinge,
        Link as Link,
        Plates as Plates,
        Roller as Roller,
    )
    from rustchain.description.drive import ChainDrive as ChainDrive
    from rustchain.description.ends import (
        AnchoredEnd as AnchoredEnd,
        FreeEnd as FreeEnd,
        LoadedEnd as LoadedEnd,
    )
    from rustchain.description.guides import (
        GuideArm as GuideArm,
        GuideRail as GuideRail,
        SmoothIdler as SmoothIdler,
    )
    from rustchain.description.laws.film import LubricantFilm as LubricantFilm
    from rustchain.description.laws.force import (
        EnhancedCylinder as EnhancedCylinder,
        Esdu78035 as Esdu78035,
        ForceLaw as ForceLaw,
        Hertz as Hertz,
        HertzCylinder as HertzCylinder,
        Johnson as Johnson,
        LankaraniNikravesh as LankaraniNikravesh,
        Linear as Linear,
        LiuConformal as LiuConformal,
        Radzimovsky as Radzimovsky,
        effective_restitution as effective_restitution,
    )
    from rustchain.description.laws.friction import Coulomb as Coulomb, LuGre as LuGre
    from rustchain.description.material import Material as Material
    from rustchain.description.mechanism.builder import Mechanism as Mechanism
    from rustchain.description.mechanism.parts import (
        HuntCrossley as HuntCrossley,
        LinearContact as LinearContact,
        SurfaceContact as SurfaceContact,
    )
    from rustchain.description.mechanism.report import MechanismReport as MechanismReport
    from rustchain.description.report import DriveReport as DriveReport
    from rustchain.description.scene import Scene as Scene
    from rustchain.description.signals import (
        Sines as Sines,
        SmoothStep as SmoothStep,
        Spline as Spline,
        Table as Table,
    )
    from rustchain.description.solver import Solver as Solver
    from rustchain.description.sprocket import (
        AppliedTorque as AppliedTorque,
        Free as Free,
        PrescribedSpeed as PrescribedSpeed,
        Sprocket as Sprocket,
    )
    from rustchain.description.teeth import (
        AnsiTooth as AnsiTooth,
        CustomTooth as CustomTooth,
        IsoTooth as IsoTooth,
        StraightTooth as StraightTooth,
        ToothArc as ToothArc,
        ToothLine as ToothLine,
    )
    from rustchain.description.tensioner import Tensioner as Tensioner
    from rustchain.errors import (
        CaseWarning as CaseWarning,
        EnergyWarning as EnergyWarning,
        InvalidInput as InvalidInput,
        MissingExtra as MissingExtra,
        NoSuchPart as NoSuchPart,
        NotRecorded as NotRecorded,
        RangeWarning as RangeWarning,
        RustchainError as RustchainError,
        RustchainWarning as RustchainWarning,
        SimulationError as SimulationError,
        ToothJumpWarning as ToothJumpWarning,
    )
    from rustchain.files.scene import load_scene as load_scene, save_scene as save_scene
    from rustchain.fmi.export import export_fmu as export_fmu
    from rustchain.results.files import load_result as load_result
    from rustchain.results.result import Result as Result
    from rustchain.simulation.evaluation import Evaluation as Evaluation
    from rustchain.simulation.part_stop import (
        ContactForceAbove as ContactForceAbove,
        JointForceAbove as JointForceAbove,
    )
    from rustchain.simulation.simulation import Simulation as Simulation
    from rustchain.simulation.stop import (
        HingeForceAbove as HingeForceAbove,
        StopCondition as StopCondition,
        StrandSlack as StrandSlack,
        TimeReached as TimeReached,
        ToothForceAbove as ToothForceAbove,
        ToothJump as ToothJump,
    )
    from rustchain.sweeps.loss_map import loss_map as loss_map
    from rustchain.sweeps.result import SweepResult as SweepResult
    from rustchain.sweeps.samples import samples as samples
    from rustchain.sweeps.store import load_sweep as load_sweep
    from rustchain.sweeps.study import StudyResult as StudyResult, study as study
    from rustchain.sweeps.sweep import sweep as sweep
    from rustchain.units import rpm as rpm

# Where each public name is; a module is imported with the first use of one of its names.
_HOMES = {
    "_rustchain": "instruction_set",
    "catalogue.generators": "chain_drive open_chain",
    "catalogue.sizes": "ChainSize",
    "catalogue.standard": "catalogue_chain chain_sizes paper_drive two_sprocket_drive",
    "description.chain": "Chain ClearanceHinge Link Plates Roller",
    "description.drive": "ChainDrive",
    "description.ends": "AnchoredEnd FreeEnd LoadedEnd",
    "description.guides": "GuideArm GuideRail SmoothIdler",
    "description.laws.film": "LubricantFilm",
    "description.laws.force": (
        "EnhancedCylinder Esdu78035 ForceLaw Hertz HertzCylinder Johnson LankaraniNikravesh Linear "
        "LiuConformal Radzimovsky effective_restitution"
    ),
    "description.laws.friction": "Coulomb LuGre",
    "description.material": "Material",
    "description.mechanism.builder": "Mechanism",
    "description.mechanism.parts": "HuntCrossley LinearContact SurfaceContact",
    "description.mechanism.report": "MechanismReport",
    "description.report": "DriveReport",
    "description.scene": "Scene",
    "description.signals": "Sines SmoothStep Spline Table",
    "description.solver": "Solver",
    "description.sprocket": "AppliedTorque Free PrescribedSpeed Sprocket",
    "description.teeth": "AnsiTooth CustomTooth IsoTooth StraightTooth ToothArc ToothLine",
    "description.tensioner": "Tensioner",
    "errors": (
        "CaseWarning EnergyWarning InvalidInput MissingExtra NoSuchPart NotRecorded RangeWarning "
        "RustchainError RustchainWarning SimulationError ToothJumpWarning"
    ),
    "files.scene": "load_scene save_scene",
    "fmi.export": "export_fmu",
    "results.files": "load_result",
    "results.result": "Result",
    "simulation.evaluation": "Evaluation",
    "simulation.part_stop": "ContactForceAbove JointForceAbove",
    "simulation.simulation": "Simulation",
    "simulation.stop": (
        "HingeForceAbove StopCondition StrandSlack TimeReached ToothForceAbove ToothJump"
    ),
    "sweeps.loss_map": "loss_map",
    "sweeps.result": "SweepResult",
    "sweeps.samples": "samples",
    "sweeps.store": "load_sweep",
    "sweeps.study": "StudyResult study",
    "sweeps.sweep": "sweep",
    "units": "rpm",
}

__version__: str

_HOME_OF = {name: home for home, names in _HOMES.items() for name in names.split()}

__all__ = sorted(_HOME_OF)

# The public package of functions beside those names; `import *` would import matplotlib with it.
_PLOT = "plot"


def __dir__() -> list[str]:
    return [*__all__, _PLOT]


if not TYPE_CHECKING:  # for checkers, other names are none

    def __getattr__(name: str) -> object:
        if name in _HOME_OF:
            value = getattr(import_module(f"{__name__}.{_HOME_OF[name]}"), name)
            globals()[name] = value
            return value
        if name == _PLOT:
            return import_module(f"{__name__}.{name}")
        from rustchain.names import DISTRIBUTION, suggest

        if name == "__version__":  # reading it takes longer than the package's own modules
            from importlib.metadata import version

            globals()[name] = value = version(DISTRIBUTION)
            return value
        msg = f"module 'rustchain' has no attribute {name!r}; {suggest(name, __dir__())}"
        raise AttributeError(msg, name=name, obj=None)  # no second suggestion by Python
