"""What a parameter of a sweep may be called, and what it changes in a scene."""

from __future__ import annotations

import dataclasses
import functools
import inspect
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from types import UnionType
from typing import Any, TypeAlias, Union, get_args, get_origin, get_type_hints

import numpy as np

from rustchain.arguments import shown
from rustchain.description.base import Description
from rustchain.description.drive import (
    ChainDrive,
    PrescribedSpeed,
    Sprocket,
    Tensioner,
)
from rustchain.description.ends import AnchoredEnd, FreeEnd, LoadedEnd
from rustchain.description.guides import GuideRail, SmoothIdler
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.scene import Scene, scene_of
from rustchain.description.solver import Solver
from rustchain.errors import InvalidInput
from rustchain.names import suggest
from rustchain.sweeps.cases import Parameters

System: TypeAlias = (
    Scene | ChainDrive | Mechanism | Callable[..., Scene] | Callable[..., ChainDrive | Mechanism]
)
Path: TypeAlias = tuple[str, ...]

_SOLVER_FIELDS = tuple(field.name for field in dataclasses.fields(Solver))
_SCENE_FIELDS = tuple(field.name for field in dataclasses.fields(Scene)[1:])  # beside the system
RUN_FIELDS = ("duration", "report_step", "record", "energy")
_SHORTHANDS = ("replicate", "pretension", "speed")
_DISTURBANCE = 1e-4  # of a speed at the start


def parameter_names() -> tuple[str, ...]:
    """Return all parameters of a drive by name: shorthands, fields of scene, solver and drive."""
    return (*_SHORTHANDS, *RUN_FIELDS, *_SCENE_FIELDS, *_SOLVER_FIELDS, *_drive_fields())


def check_names(
    system: System, run: Parameters, cases: Sequence[Parameters], where: str = "axes"
) -> None:
    """Raise where a name of the cases means nothing, or the function `system` lacks an argument.

    `where` begins the message.
    """
    if not isinstance(system, Scene | ChainDrive | Mechanism) and not callable(system):
        kind = type(system).__name__
        has = next((name for name in ("scene", "drive") if hasattr(system, name)), None)
        remedy = "" if has is None else f"; use {kind.lower()}.{has}"
        msg = (
            f"scene: got {shown(system) if has is None else kind}; expected a Scene, a ChainDrive, "
            f"a Mechanism or a function that returns one{remedy}"
        )
        raise InvalidInput(msg)
    own, needed, takes_all = _arguments(system)
    known = [*own, *_SHORTHANDS, *run, *_SCENE_FIELDS, *_SOLVER_FIELDS, *_drive_fields()]
    for name in dict.fromkeys(name for case in cases for name in case):
        if takes_all or name in known or _in_scene(name):
            continue
        if re.search(r"\[\d+\]", str(name)):
            dotted = re.sub(r"\[(\d+)\]", lambda found: f".{int(found[1]) + 1}", name)
            near = f"parts are numbered from 1 behind a dot: {dotted!r}"
        else:
            ends = [path for path in known if path.endswith(f".{name}")]
            main = [each for each in known if "." not in each] + ["chain.pitch", "..."]
            near = f"did you mean {ends[0]!r}?" if ends else suggest(name, known, main)
        msg = f"{where}: {shown(name)} is no parameter; {near}"
        raise InvalidInput(msg)
    for case in cases:
        missing = [name for name in needed if name not in case]
        if missing:
            msg = f"scene: the function needs {missing[0]!r}: make it an axis, or give it a default"
            raise InvalidInput(msg)
        twice = _first_twice([name if name in own else _target(name) for name in case])
        if twice is not None:
            msg = f"{where}: {shown(twice)} is there twice, under two names"
            raise InvalidInput(msg)


def case_of(system: System, run: Parameters, parameters: Parameters) -> tuple[Scene, Parameters]:
    """Return the scene and the arguments of the run of one case."""
    own, _, takes_all = _arguments(system)
    known = {*_SHORTHANDS, *run, *_SCENE_FIELDS, *_SOLVER_FIELDS, *_drive_fields()}
    to_function = {
        name: value
        for name, value in parameters.items()
        if name in own or (takes_all and name not in known and not _in_scene(name))
    }
    rest = {name: value for name, value in parameters.items() if name not in to_function}
    made = system(**to_function) if _is_function(system) else system  # type: ignore[operator]
    scene = scene_of(made)
    changed_run = run | {name: value for name, value in rest.items() if name in run}
    of_scene = {name: value for name, value in rest.items() if _in_scene(_target(name))}
    of_system = {n: v for n, v in rest.items() if n not in run and n not in of_scene}
    if of_system:
        scene = replace(scene, system=_with_fields(scene, of_system))
    if of_scene:
        paths = {tuple(_target(name).split(".")): value for name, value in of_scene.items()}
        laws = ("hinge_law", "tooth_law")
        for law in laws:  # a field of a law that is by default that of all contacts
            if any(path[0] == law and len(path) > 1 for path in paths):
                of_law: dict[str, Any] = {law: getattr(scene, law) or scene.force_law}
                scene = replace(scene, **of_law)
        scene = _replaced(scene, paths, "scene")
    return scene, changed_run


def _with_fields(scene: Scene, changes: Parameters) -> ChainDrive | Mechanism:
    """Return the system of a scene with other fields."""
    if isinstance(scene.system, ChainDrive):
        return _drive_with_fields(scene.system, changes)
    others = [name for name in changes if name not in ("replicate", "gravity", "name")]
    if others:
        msg = (
            f"{others[0]}: cannot be changed in a mechanism; expected a function of it that "
            "returns the mechanism"
        )
        raise InvalidInput(msg)
    fields = {name: value for name, value in changes.items() if name != "replicate"}
    return _replicated_mechanism(replace(scene.system, **fields), changes.get("replicate", 0))


def _drive_with_fields(drive: ChainDrive, changes: Parameters) -> ChainDrive:
    """Return `drive` with other fields, all changed at once."""
    seed = changes.get("replicate", 0)
    changes = {name: value for name, value in changes.items() if name != "replicate"}
    fields = {tuple(_target(name).split(".")): value for name, value in changes.items()}
    if "pretension" in changes and fields.get(("tensioner",), drive.tensioner) is None:
        fields["tensioner",] = Tensioner(pretension=changes["pretension"])
    if "speed" in changes:
        driven = (isinstance(s.motion, PrescribedSpeed) for s in drive.sprockets)
        driver = next((number for number, is_driver in enumerate(driven) if is_driver), None)
        if driver is None:
            msg = (
                f"speed = {shown(changes['speed'])}: no sprocket of this drive has a "
                "PrescribedSpeed "
                "that could be changed"
            )
            raise InvalidInput(msg)
        fields["sprockets", str(driver + 1), "motion", "speed"] = fields.pop(("speed",))
    changed: ChainDrive = _replaced(drive, fields, "drive")
    # At 0 N the centres are fixed, as in the generators.
    none = changes.get("pretension") == 0 and changed.tensioner is not None
    return _replicated_drive(replace(changed, tensioner=None) if none else changed, seed)


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
        msg = (
            f"replicate = {seed}: every sprocket has a PrescribedSpeed, so that none can start a "
            "little faster or slower; leave it out, or vary another parameter"
        )
        raise InvalidInput(msg)
    factors = 1.0 + _DISTURBANCE * np.random.default_rng(seed).uniform(-1.0, 1.0, len(free))
    speeds = drive.check().initial_speed
    sprockets = tuple(
        replace(sprocket, initial_speed=float(speed * factor)) if moves else sprocket
        for sprocket, moves, speed, factor in zip(
            drive.sprockets, free, speeds, factors, strict=True
        )
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
    if isinstance(part, tuple):
        parts = {str(place): each for place, each in enumerate(part, 1)}
    else:
        fields = dataclasses.fields(part) if isinstance(part, Description) else ()
        parts = {field.name: getattr(part, field.name) for field in fields}
    for head in below:
        if head not in parts:
            raise InvalidInput(f"{name}.{head}: {_why_not(part, name, head, parts)}")
    changed = {
        head: _replaced(parts[head], deeper, f"{name}.{head}") for head, deeper in below.items()
    }
    if isinstance(part, tuple):
        return tuple((parts | changed).values())
    return replace(part, **changed)


def _why_not(part: object, name: str, head: str, parts: Mapping[str, object]) -> str:
    """Return why `part`, called `name`, has no part `head` that can be changed."""
    if isinstance(part, tuple) and part:
        return f"does not exist; expected a number from 1 to {len(part)} after {name}"
    if isinstance(part, tuple):
        return f"does not exist, for {name} is empty"
    if parts:
        return f"does not exist; {suggest(head, parts)}"
    kind = "None" if part is None else f"a {type(part).__name__}"
    return f"cannot be changed, for {name} is {kind}"


def _target(name: str) -> str:
    """Return the dotted name of what a parameter changes."""
    if name in _SOLVER_FIELDS:
        return f"solver.{name}"
    return "tensioner.pretension" if name == "pretension" else str(name)


def _in_scene(name: str) -> bool:
    """Whether a name is that of a field of the scene, or of what lies in it."""
    return str(name).split(".")[0] in _SCENE_FIELDS


def _first_twice(names: list[str]) -> str | None:
    return next((name for name in names if names.count(name) > 1), None)


def _is_function(system: System) -> bool:
    return not isinstance(system, Scene | ChainDrive | Mechanism)


def _arguments(system: System) -> tuple[list[str], list[str], bool]:
    """Return names that a function takes, those it needs, and whether it takes any other too."""
    if not _is_function(system):
        return [], [], False
    found = inspect.signature(system).parameters.values()  # type: ignore[arg-type]
    named = [p for p in found if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)]
    needed = [p.name for p in named if p.default is p.empty]
    return [p.name for p in named], needed, any(p.kind is p.VAR_KEYWORD for p in found)


@functools.cache
def _drive_fields() -> tuple[str, ...]:
    """Return the dotted names of all fields of a drive."""
    return tuple(_paths(ChainDrive))


def _paths(description: type[Description]) -> Iterator[str]:
    """Yield the dotted names of all fields: whole parts, what is in them, and coordinates."""
    hints = get_type_hints(description)
    for field in dataclasses.fields(description):
        yield field.name
        hint = hints[field.name]
        members = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
        inside = (path for member in members for path in _inside(member))
        yield from (f"{field.name}.{path}" for path in inside)


_MOST_SPROCKETS = 16  # or guides, whose fields have names
_ENDS = (AnchoredEnd | LoadedEnd | FreeEnd,)
_LISTED = ((Sprocket,), (GuideRail | SmoothIdler,), _ENDS)


def _inside(hint: Any) -> Iterator[str]:  # noqa: ANN401
    """Yield the dotted names of what lies within a value of this type; a table is taken whole."""
    if isinstance(hint, type) and issubclass(hint, Description):
        yield from _paths(hint)
    elif get_origin(hint) is tuple or get_args(hint) in _LISTED:
        pair = get_origin(hint) is tuple or get_args(hint) == _ENDS
        count = 2 if pair else _MOST_SPROCKETS  # of coordinates, of ends, of sprockets
        of_one = get_args(hint)[0]
        members = get_args(of_one) or (of_one,)
        inside = dict.fromkeys(path for member in members for path in _inside(member))
        for place in map(str, range(1, count + 1)):
            yield place
            yield from (f"{place}.{path}" for path in inside)
