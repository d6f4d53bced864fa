"""Models of drive files: tables, from fields and annotations of the descriptions."""

from __future__ import annotations

import dataclasses
import functools
import inspect
from collections.abc import Callable, Mapping, Sequence
from types import NoneType, UnionType
from typing import Any, Literal, NamedTuple, TypeAlias, Union, get_args, get_origin, get_type_hints

from rustchain.catalogue.generators import chain_drive, open_chain
from rustchain.catalogue.standard import catalogue_chain, paper_drive, two_sprocket_drive
from rustchain.description.base import Description
from rustchain.description.chain import Chain
from rustchain.description.drive import ChainDrive
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.scene import Scene
from rustchain.simulation import part_stop as part_stop  # subclasses of StopCondition
from rustchain.simulation.simulation import Simulation
from rustchain.simulation.stop import StopCondition

Maker: TypeAlias = Callable[..., Any]


def chain_of_catalogue(**keywords: Any) -> Chain:  # noqa: ANN401
    """Return a chain of the catalogue, with what else is given in place of its own."""
    own = {name: keywords.pop(name) for name in fields_of(catalogue_chain) if name in keywords}
    return dataclasses.replace(catalogue_chain(**own), **keywords)


MAKERS: dict[type, tuple[tuple[str, Maker], ...]] = {
    ChainDrive: (
        ("ChainDrive", ChainDrive),
        ("chain_drive", chain_drive),
        ("open_chain", open_chain),
        ("two_sprocket_drive", two_sprocket_drive),
        ("paper_drive", paper_drive),
    ),
    Chain: (("Chain", Chain), ("catalogue_chain", chain_of_catalogue)),
}
"""What makes a value of a class, beside the class itself, by the name that ``type`` gives it."""


def makers_of(kind: type) -> dict[str, Maker]:
    """Return what makes a value of `kind`, by name: the class, or those below an abstract one."""
    if kind in MAKERS:
        return dict(MAKERS[kind])
    makers: dict[str, Maker] = {}
    for each in _concrete(kind):
        makers |= MAKERS.get(each, ((each.__name__, each),))
    return makers


def _concrete(kind: type) -> list[type]:
    """Return the classes that make a value of `kind`: itself, or those below an abstract one.

    Classes that a user derives are no part of files, and leave those above them as they are.
    """
    package = __name__.partition(".")[0]
    derived: list[type] = kind.__subclasses__()
    below = [each for each in derived if each.__module__.partition(".")[0] == package]
    return [one for each in below for one in _concrete(each)] if below else [kind]


class Field(NamedTuple):
    """A key of a table: its annotation, whether it must be given, and its default."""

    hint: Any
    needed: bool
    default: Any = None


@functools.cache
def fields_of(maker: Maker) -> dict[str, Field]:
    """Return the fields of a table that `maker` is called with."""
    if maker is chain_of_catalogue:
        own, others = fields_of(catalogue_chain), fields_of(Chain)
        # With a pitch it would be a chain that is not in the catalogue.
        optional = {name: Field(f.hint, False) for name, f in others.items() if name != "pitch"}
        return optional | own
    plain = isinstance(maker, type) and not dataclasses.is_dataclass(maker)
    hints = get_type_hints(
        maker.__init__ if plain else maker, localns={"StopCondition": StopCondition}
    )
    return {
        p.name: Field(
            hints.get(p.name, Any),
            p.default is p.empty,
            None if p.default is p.empty or repr(p.default) == "<factory>" else p.default,
        )
        for p in inspect.signature(maker).parameters.values()
    }


def members_of(hint: Any) -> tuple[Any, ...]:  # noqa: ANN401
    """Return the members of a union but None; of all else, itself."""
    members = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    return tuple(member for member in members if member is not NoneType)


def tables_of(hint: Any) -> dict[str, Maker]:  # noqa: ANN401
    """Return what makes a value of `hint` from a table, by the name that ``type`` gives it."""
    # Python 3.10 counts `Sequence[float]` among the types.
    classes = [m for m in members_of(hint) if isinstance(m, type) and get_origin(m) is None]
    kinds = [m for m in classes if issubclass(m, _DESCRIBED)]
    return {name: make for kind in kinds for name, make in makers_of(kind).items()}


_DESCRIBED = (Description, StopCondition, Mechanism)


def item_of(hint: Any) -> Any:  # noqa: ANN401
    """Return the annotation of each item of a list of tables; None of all else."""
    for member in members_of(hint):
        arguments = get_args(member)
        if get_origin(member) in (Sequence, list) and tables_of(arguments[0]):
            return arguments[0]
    return None


def tag_of(value: Mapping[str, object], makers: Mapping[str, Maker]) -> str | None:
    """Return which table this is: the one it names, or the only one that its keys fit, or touch."""
    if "type" in value:
        return next((name for name in makers if name == value["type"]), None)
    if len(makers) == 1:
        return next(iter(makers))
    fit = [name for name, make in makers.items() if _fits(value, fields_of(make))]
    near = [name for name, make in makers.items() if set(value) & set(fields_of(make))]
    return next((names[0] for names in (fit, near) if len(names) == 1), None)


def _fits(value: Mapping[str, object], fields: Mapping[str, Field]) -> bool:
    needed = {name for name, field in fields.items() if field.needed}
    return needed <= set(value) <= set(fields)


def may_be_none(hint: Any) -> bool:  # noqa: ANN401
    """Return whether an annotation permits None, for which files have a word."""
    return NoneType in get_args(hint)


@functools.cache
def sections() -> dict[str, dict[str, Field]]:
    """Return the fields of the tables ``simulation`` and ``run``."""
    simulation = {name: f for name, f in fields_of(Scene).items() if name != "system"}
    simulation["min_approach_speed"] = simulation["min_impact_velocity"]
    run = {
        name: field
        for name, field in fields_of(Simulation.run).items()
        if name not in ("self", "progress", "callback")
    }
    run["stop"] = Field(list[StopCondition], False, ())
    run["record"] = Field(list[str], False)
    run["out"] = Field(str, False)
    return {
        "simulation": {name: field._replace(needed=False) for name, field in simulation.items()},
        "run": {name: field._replace(needed=False) for name, field in run.items()},
    }


def leaf_problem(value: object, hint: Any) -> str | None:  # noqa: ANN401
    """Return what a number, text or truth must be instead; None where it may be, or is unknown.

    Ranges and shapes are checked by the descriptions.
    """
    members = members_of(hint)
    if len(members) != 1:
        return None
    (kind,) = members
    if get_origin(kind) is Literal:
        words = get_args(kind)
        if value in words and isinstance(value, str):
            return None
        *others, last = map(repr, words)
        return f"{', '.join(others)} or {last}" if others else last
    if kind not in _LEAVES:
        return None
    allowed, expected = _LEAVES[kind]
    right = isinstance(value, allowed) and (kind is bool or not isinstance(value, bool))
    return None if right else str(expected)


_LEAVES: dict[Any, tuple[Any, str]] = {
    float: (int | float, "a number"),
    int: (int, "an integer"),
    str: (str, "a text"),
    bool: (bool, "true or false"),
}
