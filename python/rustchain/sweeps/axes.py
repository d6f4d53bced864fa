"""Names of the parameters of a sweep, and their effect on a scene."""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeAlias, TypeGuard

import numpy as np

from rustchain.arguments import shown
from rustchain.catalogue.generators import chain_drive
from rustchain.catalogue.standard import catalogue_chain, two_sprocket_drive
from rustchain.description.drive import ChainDrive
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.scene import Scene, instead_of_a_scene, scene_of
from rustchain.description.solver import Solver
from rustchain.description.sprocket import AppliedTorque, Free, PrescribedSpeed
from rustchain.description.tensioner import Tensioner
from rustchain.errors import InvalidInput
from rustchain.sweeps.cases import Parameters, first_twice
from rustchain.sweeps.fields import (
    field_names,
    general,
    missing_part,
    nearest,
    parts_of,
    why_not,
)

System: TypeAlias = (
    Scene | ChainDrive | Mechanism | Callable[..., Scene] | Callable[..., ChainDrive | Mechanism]
)
Path: TypeAlias = tuple[str, ...]

_SOLVER_FIELDS = tuple(field.name for field in dataclasses.fields(Solver))
_SCENE_FIELDS = tuple(field.name for field in dataclasses.fields(Scene)[1:])  # beside the system
_LAW_FIELDS = tuple(name for name in field_names(Scene) if "_law." in name)
_OTHER_LAWS = ("hinge_law", "tooth_law")
_OTHER_NAMES = {"min_approach_speed": "min_impact_velocity"}  # as keywords of Scene and Simulation
RUN_FIELDS = ("duration", "report_step", "record", "energy")
_SHORTHANDS = ("replicate", "pretension", "speed")
_DISTURBANCE = 1e-4  # of a speed at the start
# A sprocket with a lower initial speed [rad/s], such as one at rest, is disturbed as one with this:
# by up to 1e-5 rad/s, or 0.5 um/s at a pitch radius of 50 mm. In a run of a second it moves less
# than clearances, and it is far above rounding, from which a chaotic drive already diverges.
_SLOW = 0.1
_LOAD = re.compile(r"(?:sprockets\.(\d+)\.motion\.)?(torque|curve)")


def parameter_names(system: System | None = None, run: Iterable[str] = RUN_FIELDS) -> list[str]:
    """Return all parameters of a system by name; of any system where it is not known.

    They are shorthands, arguments of the run and fields of scene, solver and system. Numbers of
    parts are 1.
    """
    kinds: tuple[type, ...] = (ChainDrive, Mechanism)
    if isinstance(system, Scene | ChainDrive | Mechanism):
        kinds = (type(scene_of(system).system),)
    of_systems = [name for kind in kinds for name in field_names(kind)]
    of_drives = ChainDrive in kinds
    shorthands, of_laws = (_SHORTHANDS, _LAW_FIELDS) if of_drives else (("replicate",), ())
    names = (*shorthands, *run, *of_systems, *_SCENE_FIELDS, *_SOLVER_FIELDS, *of_laws)
    return list(dict.fromkeys(names))


def check_names(
    system: System, run: Parameters, cases: Sequence[Parameters], where: str = "axes"
) -> None:
    """Raise where a name of the cases means nothing, or the function `system` lacks an argument.

    `where` begins the message.
    """
    try:
        own, needed, takes_all = _arguments(system)
    except (TypeError, ValueError) as error:  # no function, or one without a signature
        got, remedy = instead_of_a_scene(system)
        msg = (
            f"scene: got {got}; expected a Scene, a ChainDrive, a Mechanism or a function of "
            f"named arguments that returns one{remedy}"
        )
        raise InvalidInput(msg) from error
    known = [*own, *parameter_names(system, run)]
    names = {str(name): value for case in cases for name, value in case.items()}
    drive = None if _is_function(system) else scene_of(system).system

    def why_missing(name: str) -> str | None:
        if _is_function(system) or any(name.startswith(f"{each}.") for each in names):
            return None
        scene = scene_of(system)
        return missing_part(scene.system, scene.kind, name.split("."))

    for name, value in names.items():
        near: str | None = None
        if isinstance(drive, ChainDrive) and name not in known:
            near = _other_remedy(drive, name, value, where == "--set")
        if near is None and not (takes_all or _in_scene(name)) and general(name) not in known:
            near = nearest(name, known, why_missing)
        near = near or why_missing(name)
        if near is not None:
            raise InvalidInput(f"{where}: {shown(name)} is no parameter; {near}")
    for case in cases:
        missing = [name for name in needed if name not in case]
        if missing:
            msg = f"scene: the function needs {missing[0]!r}: make it an axis, or give it a default"
            raise InvalidInput(msg)
        twice = first_twice([name if name in own else _target(name) for name in case])
        if twice is not None:
            msg = f"{where}: {shown(twice)} is there twice, under two names"
            raise InvalidInput(msg)


def _other_remedy(drive: ChainDrive, name: str, value: object, on_command_line: bool) -> str | None:
    """Return what to change in place of the torque of a free sprocket, or of no field; or None."""
    motions = {str(number): s.motion for number, s in enumerate(drive.sprockets, 1)}
    if (load := _LOAD.fullmatch(name)) is not None:
        free = [number for number, motion in motions.items() if isinstance(motion, Free)]
        loaded = any(isinstance(motion, AppliedTorque) for motion in motions.values())
        number = load[1] or (free[0] if free and not loaded else None)
        if number in free:
            motion, given = f"sprockets.{number}.motion", shown(value)
            made = f"AppliedTorque({load[2]}={given}), in files {{{load[2]} = {given}}}"
            remedy = f"{motion}={{{load[2]}={given}}}" if on_command_line else f"{motion} to {made}"
            return f"drive.{motion} is a Free; set the whole of it, {remedy}"
        return None
    generators = (two_sprocket_drive, chain_drive) if drive.ends is None else ()
    for generator in generators:
        if name in inspect.signature(generator).parameters:
            place = "change it in the drive file" if on_command_line else "sweep a function of it"
            return f"it is an argument of {generator.__name__}, no field of the drive; {place}"
    return None


def case_of(system: System, run: Parameters, parameters: Parameters) -> tuple[Scene, Parameters]:
    """Return the scene and the arguments of the run of one case."""
    own, _, takes_all = _arguments(system)
    known = set(parameter_names(system, run))
    to_function = {
        name: value
        for name, value in parameters.items()
        if name in own or (takes_all and general(name) not in known and not _in_scene(name))
    }
    rest = {name: value for name, value in parameters.items() if name not in to_function}
    made = system(**to_function) if _is_function(system) else system
    scene = scene_of(made)
    changed_run = run | {name: value for name, value in rest.items() if name in run}
    of_scene = {name: value for name, value in rest.items() if _in_scene(_target(name))}
    of_system = {n: v for n, v in rest.items() if n not in run and n not in of_scene}
    if of_system:
        scene = replace(scene, system=_with_fields(scene, of_system))
    if of_scene:
        paths = {tuple(_target(name).split(".")): value for name, value in of_scene.items()}
        of_laws = {path: value for path, value in paths.items() if path[0] in _OTHER_LAWS}
        others = {path: value for path, value in paths.items() if path not in of_laws}
        scene = _replaced(scene, others, "scene")
        for law in _OTHER_LAWS:  # a field of a law that is by default that of all contacts
            if any(path[0] == law and len(path) > 1 for path in of_laws):
                of_law: dict[str, Any] = {law: getattr(scene, law) or scene.force_law}
                scene = replace(scene, **of_law)
        scene = _replaced(scene, of_laws, "scene")
    return scene, changed_run


def _with_fields(scene: Scene, changes: Parameters) -> ChainDrive | Mechanism:
    """Return the system of a scene with other fields."""
    if changes.get("replicate", 0) != 0 and scene.velocities is not None:
        msg = (
            f"replicate = {shown(changes['replicate'])}: the scene has velocities of its own, and "
            "keeps them; leave them out, or sweep them as an argument of a function"
        )
        raise InvalidInput(msg)
    if isinstance(scene.system, ChainDrive):
        return _drive_with_fields(scene.system, changes)
    fields = {tuple(n.split(".")): value for n, value in changes.items() if n != "replicate"}
    changed: Mechanism = _replaced(scene.system, fields, "mechanism")
    return _replicated_mechanism(changed, changes.get("replicate", 0))


def _drive_with_fields(drive: ChainDrive, changes: Parameters) -> ChainDrive:
    """Return `drive` with other fields, all changed at once."""
    seed = changes.get("replicate", 0)
    changes = {name: value for name, value in changes.items() if name != "replicate"}
    if changes.get("pretension", 0) is None:  # no tensioner, as in the generators
        changes["pretension"] = 0
    fields = {tuple(_target(name).split(".")): value for name, value in changes.items()}
    if isinstance(chain := changes.get("chain"), str):
        fields["chain",] = catalogue_chain(chain, drive.chain.links)
    if "pretension" in changes and fields.get(("tensioner",), drive.tensioner) is None:
        fields["tensioner",] = Tensioner(pretension=changes["pretension"])
    if "speed" in changes:
        driver = driver_of(drive)
        if driver is None:
            msg = (
                f"speed = {shown(changes['speed'])}: no sprocket of this drive has a "
                "PrescribedSpeed that could be changed"
            )
            raise InvalidInput(msg)
        path = ("sprockets", str(driver), "motion", "speed")
        if path in fields:
            msg = (
                f"axes: 'speed' and {shown('.'.join(path))} are one parameter of this drive; "
                "leave one of them out"
            )
            raise InvalidInput(msg)
        fields[path] = fields.pop(("speed",))
    changed: ChainDrive = _replaced(drive, fields, "drive")
    # At 0 N the centres are fixed, as in the generators.
    none = changes.get("pretension") == 0 and changed.tensioner is not None
    return _replicated_drive(replace(changed, tensioner=None) if none else changed, seed)


def driver_of(drive: ChainDrive) -> int | None:
    """Return the number of the first sprocket with a prescribed speed, from 1, or None."""
    numbered = enumerate(drive.sprockets, 1)
    return next((k for k, one in numbered if isinstance(one.motion, PrescribedSpeed)), None)


def _checked_seed(seed: object) -> int:
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        msg = f"replicate = {shown(seed)}: must be a whole number from 0, the seed of the replicate"
        raise InvalidInput(msg)
    return seed


def _replicated_mechanism(mechanism: Mechanism, given: object) -> Mechanism:
    """Return a mechanism with slightly other velocities at the start, as far as joints allow."""
    seed = _checked_seed(given)
    if seed == 0:
        return mechanism
    velocities = np.array([body.velocity for body in mechanism.bodies])
    if not velocities.any():
        msg = (
            f"replicate = {seed}: every body starts at rest, so that none can start a little "
            "faster or slower; leave it out, or vary another parameter"
        )
        raise InvalidInput(msg)
    factors = 1.0 + _DISTURBANCE * np.random.default_rng(seed).uniform(-1.0, 1.0, velocities.shape)
    rows = zip(mechanism.bodies, (velocities * factors).tolist(), strict=True)
    return replace(mechanism, bodies=[replace(body, velocity=row) for body, row in rows])


def _replicated_drive(drive: ChainDrive, given: object) -> ChainDrive:
    """Return `drive` with slightly other speeds at the start of what no motor holds."""
    seed = _checked_seed(given)
    if seed == 0:
        return drive
    free = [not isinstance(sprocket.motion, PrescribedSpeed) for sprocket in drive.sprockets]
    if not any(free):
        why = "every sprocket has a PrescribedSpeed" if free else "the drive has no sprocket"
        msg = (
            f"replicate = {seed}: {why}, so that none can start a "
            "little faster or slower; leave it out, or vary another parameter"
        )
        raise InvalidInput(msg)
    factors = 1.0 + _DISTURBANCE * np.random.default_rng(seed).uniform(-1.0, 1.0, len(free))
    speeds = np.array(drive.check().initial_speed)
    changed = np.where(np.abs(speeds) < _SLOW, speeds + _SLOW * (factors - 1.0), speeds * factors)
    sprockets = tuple(
        replace(sprocket, initial_speed=speed) if moves else sprocket
        for sprocket, moves, speed in zip(drive.sprockets, free, changed.tolist(), strict=True)
    )
    return replace(drive, sprockets=sprockets)


def _replaced(part: Any, changes: Mapping[Path, Any], name: str) -> Any:  # noqa: ANN401
    """Return `part`, called `name`, with the changes at the ends of their paths."""
    if () in changes:
        part = changes[()]
    below: dict[str, dict[Path, Any]] = {}
    for path, value in changes.items():
        if path:
            below.setdefault(path[0], {})[path[1:]] = value
    if not below:
        return part
    parts = parts_of(part)
    for head in below:
        if head not in parts:
            raise InvalidInput(f"{name}.{head}: {why_not(part, name, head)}")
    changed = {
        head: _replaced(parts[head], deeper, f"{name}.{head}") for head, deeper in below.items()
    }
    if isinstance(part, tuple):
        return tuple((parts | changed).values())
    return replace(part, **changed)


def _target(name: str) -> str:
    """Return the dotted name of what a parameter changes."""
    if name in _SOLVER_FIELDS:
        return f"solver.{name}"
    return "tensioner.pretension" if name == "pretension" else _OTHER_NAMES.get(name, str(name))


def _in_scene(name: str) -> bool:
    """Return whether a name is that of a field of the scene or of one of its parts."""
    return _OTHER_NAMES.get(name, str(name)).split(".")[0] in _SCENE_FIELDS


def _is_function(system: System) -> TypeGuard[Callable[..., Any]]:
    return not isinstance(system, Scene | ChainDrive | Mechanism)


def _arguments(system: System) -> tuple[list[str], list[str], bool]:
    """Return names that a function takes, those it needs, and whether it takes any other too."""
    if not _is_function(system):
        return [], [], False
    found = inspect.signature(system).parameters.values()
    named = [p for p in found if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)]
    needed = [p.name for p in named if p.default is p.empty]
    return [p.name for p in named], needed, any(p.kind is p.VAR_KEYWORD for p in found)
