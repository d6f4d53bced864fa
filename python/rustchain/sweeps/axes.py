"""What a parameter of a sweep may be called, and what it changes in a scene."""

from __future__ import annotations

import dataclasses
import functools
import inspect
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from types import UnionType
from typing import Any, TypeAlias, Union, get_args, get_origin, get_type_hints

import numpy as np

from rustchain.arguments import items_within, shown
from rustchain.description.base import Description, plain
from rustchain.description.drive import (
    ChainDrive,
    PrescribedSpeed,
    Sprocket,
    Tensioner,
    drive_inside,
)
from rustchain.description.ends import AnchoredEnd, FreeEnd, LoadedEnd
from rustchain.description.guides import GuideRail, SmoothIdler
from rustchain.description.solver import Solver
from rustchain.errors import InvalidInput
from rustchain.names import suggest

Drive: TypeAlias = ChainDrive | Callable[..., ChainDrive]
Parameters: TypeAlias = dict[str, Any]
Path: TypeAlias = tuple[str, ...]

_SOLVER_FIELDS = tuple(field.name for field in dataclasses.fields(Solver))
_SHORTHANDS = ("disturbance", "pretension", "speed")
# Each case holds its scene and its result: a few kilobytes at the least.
MOST_CASES = 100_000
_DISTURBANCE = 1e-4  # of a speed at the start


def axes_of(axes: Mapping[str, Iterable[Any]]) -> dict[str, tuple[Any, ...]]:
    """Return the values of each axis as a tuple."""
    found = {}
    for name, values in axes.items():
        listed = items_within(f"axes[{shown(name)}]", values, MOST_CASES)
        if listed is None:
            msg = (
                f"axes[{shown(name)}] = {shown(values)}: must be a sequence of values, one for "
                "each case"
            )
            raise InvalidInput(msg)
        found[name] = tuple(map(plain, listed))
        if not found[name]:
            msg = f"axes[{shown(name)}] = {shown(values)}: must hold at least one value"
            raise InvalidInput(msg)
    return found


def cases_of(cases: object) -> list[Parameters]:
    """Return the parameters of each case of a list of cases."""
    listed = items_within("axes", cases, MOST_CASES) or []
    if not listed or not all(isinstance(case, Mapping) for case in listed):
        msg = (
            f"axes = {shown(cases)}: must map names to sequences of values, "
            "or be a list with a mapping of names to values for each case"
        )
        raise InvalidInput(msg)
    return [{name: plain(value) for name, value in case.items()} for case in listed]


def check_names(drive: Drive, scene: Parameters, cases: Sequence[Parameters]) -> None:
    """Raise where a name of the cases means nothing, or the function `drive` lacks an argument."""
    if drive_inside(drive) is not None:
        msg = f"drive: a {type(drive).__name__} is no drive but has one: take its .drive"
        raise InvalidInput(msg)
    if not isinstance(drive, ChainDrive) and not callable(drive):
        msg = f"drive = {shown(drive)}: must be a ChainDrive, or a function that returns one"
        raise InvalidInput(msg)
    own, needed, takes_all = _arguments(drive)
    known = [*own, *_SHORTHANDS, *scene, *_SOLVER_FIELDS, *_drive_fields()]
    for name in dict.fromkeys(name for case in cases for name in case):
        if not takes_all and _dotted(name) not in known:
            ends = [path for path in known if path.endswith(f".{name}")]
            main = [each for each in known if "." not in each] + ["chain.pitch", "..."]
            near = f"did you mean {ends[0]!r}?" if ends else suggest(name, known, main)
            msg = f"axes: {shown(name)} is no parameter of this sweep; {near}"
            raise InvalidInput(msg)
    for case in cases:
        missing = [name for name in needed if name not in case]
        if missing:
            msg = f"drive: the function needs {missing[0]!r}: make it an axis, or give it a default"
            raise InvalidInput(msg)
        twice = _first_twice([name if name in own else _target(name) for name in case])
        if twice is not None:
            msg = f"axes: {shown(twice)} is there twice, under two names"
            raise InvalidInput(msg)


def scene_of(drive: Drive, scene: Parameters, parameters: Parameters) -> Parameters:
    """Return `scene` with its drive, changed by the parameters of one case."""
    own, _, takes_all = _arguments(drive)
    known = {*_SHORTHANDS, *scene, *_SOLVER_FIELDS, *_drive_fields()}
    to_function = {
        name: value
        for name, value in parameters.items()
        if name in own or (takes_all and _dotted(name) not in known)
    }
    rest = {name: value for name, value in parameters.items() if name not in to_function}
    changed = scene | {name: value for name, value in rest.items() if name in scene}
    steps = {name: value for name, value in rest.items() if name in _SOLVER_FIELDS}
    if steps and isinstance(changed["solver"], Solver):
        changed["solver"] = replace(changed["solver"], **steps)
    made = drive if isinstance(drive, ChainDrive) else drive(**to_function)
    fields = {n: value for n, value in rest.items() if n not in changed and n not in steps}
    return changed | {"drive": _with_fields(made, fields) if fields else made}


def _with_fields(drive: ChainDrive, changes: Parameters) -> ChainDrive:
    """Return `drive` with other fields, all changed at once."""
    if not isinstance(drive, ChainDrive):
        msg = f"drive = {shown(drive)}: the function must return a ChainDrive"
        raise InvalidInput(msg)
    seed = changes.get("disturbance", 0)
    changes = {name: value for name, value in changes.items() if name != "disturbance"}
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
        fields["sprockets", str(driver), "motion", "speed"] = fields.pop(("speed",))
    changed: ChainDrive = _replaced(drive, fields, "drive")
    # At 0 N the centres are fixed, as in the generators.
    none = changes.get("pretension") == 0 and changed.tensioner is not None
    return _disturbed(replace(changed, tensioner=None) if none else changed, seed)


def _disturbed(drive: ChainDrive, seed: object) -> ChainDrive:
    """Return `drive` with slightly other speeds at the start of what no motor holds."""
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        msg = (
            f"disturbance = {shown(seed)}: must be a whole number from 0, the seed of the "
            "disturbance"
        )
        raise InvalidInput(msg)
    if seed == 0:
        return drive
    free = [not isinstance(sprocket.motion, PrescribedSpeed) for sprocket in drive.sprockets]
    if not any(free):
        msg = (
            f"disturbance = {seed}: every sprocket has a PrescribedSpeed, so that none can start a "
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
        parts = {str(place): each for place, each in enumerate(part)}
    else:
        fields = dataclasses.fields(part) if isinstance(part, Description) else ()
        parts = {field.name: getattr(part, field.name) for field in fields}
    for head in below:
        if head not in parts:
            kind = "None" if part is None else f"a {type(part).__name__}"
            msg = f"{name}.{head}: cannot be changed, for {name} is {kind}"
            raise InvalidInput(msg)
    changed = {
        head: _replaced(parts[head], deeper, f"{name}.{head}") for head, deeper in below.items()
    }
    if isinstance(part, tuple):
        return tuple((parts | changed).values())
    return replace(part, **changed)


def _dotted(name: str) -> str:
    """Return the name of a field with dots alone: ``sprockets[1].teeth`` is sprockets.1.teeth."""
    return re.sub(r"\[(\d+)\]", r".\1", str(name))


def _target(name: str) -> str:
    """Return the dotted name of what a parameter changes."""
    return "tensioner.pretension" if name == "pretension" else _dotted(name)


def _first_twice(names: list[str]) -> str | None:
    return next((name for name in names if names.count(name) > 1), None)


def _arguments(drive: Drive) -> tuple[list[str], list[str], bool]:
    """Return names that a function takes, those it needs, and whether it takes any other too."""
    if isinstance(drive, ChainDrive):
        return [], [], False
    found = inspect.signature(drive).parameters.values()
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
        for place in map(str, range(count)):
            yield place
            yield from (f"{place}.{path}" for path in inside)
