"""What may stand in a drive file, as pydantic models made from the descriptions' own fields."""

from __future__ import annotations

import dataclasses
import functools
import inspect
from collections.abc import Callable, Mapping, Sequence
from types import GenericAlias, NoneType, UnionType
from typing import (
    Annotated,
    Any,
    Literal,
    TypeAlias,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, create_model

from rustchain.catalogue.generators import chain_drive, open_chain
from rustchain.catalogue.standard import catalogue_chain, paper_drive, two_sprocket_drive
from rustchain.description.base import Description
from rustchain.description.drive import Chain, ChainDrive
from rustchain.description.laws.force import ForceLaw
from rustchain.simulation.simulation import Simulation
from rustchain.simulation.stop import StopCondition

Maker: TypeAlias = Callable[..., Any]
_VALUE = "value"  # tag of what is no table
_STRICT = ConfigDict(extra="forbid", strict=True, arbitrary_types_allowed=True)
_LEAVES = (float, int, str, bool)


def chain_of_catalogue(**keywords: Any) -> Chain:  # noqa: ANN401
    """Return a chain of the catalogue, with what else is given in place of its own."""
    own = {name: keywords.pop(name) for name in _fields(catalogue_chain) if name in keywords}
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
    concrete = kind.__subclasses__() if kind in (ForceLaw, StopCondition) else [kind]
    return {each.__name__: each for each in concrete}


def _fields(maker: Maker) -> dict[str, tuple[Any, bool]]:
    """Return annotation of each field of a maker, and whether it must be given."""
    if maker is chain_of_catalogue:
        own, others = _fields(catalogue_chain), _fields(Chain)
        # With a pitch it would be a chain of one's own.
        return {name: (hint, False) for name, (hint, _) in others.items() if name != "pitch"} | own
    hints = get_type_hints(maker)
    if dataclasses.is_dataclass(maker):
        no_default = (dataclasses.MISSING, dataclasses.MISSING)
        return {
            f.name: (hints[f.name], (f.default, f.default_factory) == no_default)
            for f in dataclasses.fields(maker)
        }
    parameters = inspect.signature(maker).parameters.values()
    return {p.name: (hints[p.name], p.default is p.empty) for p in parameters}


@functools.cache
def model_of(name: str, maker: Maker) -> type[BaseModel]:
    """Return the model of a table that `maker` is called with."""
    fields: dict[str, Any] = {"type": (Literal[name], name)}
    for field, (hint, needed) in _fields(maker).items():
        fields[field] = (annotation_of(hint), ... if needed else None)
    return create_model(name, __config__=_STRICT, **fields)


def annotation_of(hint: Any) -> Any:  # noqa: ANN401
    """Return what pydantic is to check of a field; ranges and shapes are the descriptions' own."""
    members = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    members = tuple(member for member in members if member is not NoneType)
    kinds = [m for m in members if isinstance(m, type) and issubclass(m, Description)]
    if kinds:
        return _tables_of(kinds)
    if len(members) == 1 and (members[0] in _LEAVES or get_origin(members[0]) is Literal):
        return members[0]
    if len(members) == 1 and get_origin(members[0]) is Sequence:
        inside = annotation_of(get_args(members[0])[0])
        return Any if inside is Any or inside in _LEAVES else _list_of(inside)
    return Any


def _list_of(inside: Any) -> Any:  # noqa: ANN401
    return GenericAlias(list, (inside,))


def _tables_of(kinds: Sequence[type]) -> Any:  # noqa: ANN401
    """Return a union of the tables that make one of `kinds`, told apart by ``type``."""
    makers = {name: make for kind in kinds for name, make in makers_of(kind).items()}
    members = [Annotated[model_of(name, make), Tag(name)] for name, make in makers.items()]
    tagged = Union[(*members, Annotated[Any, Tag(_VALUE)])]  # type: ignore[valid-type]
    return Annotated[
        tagged,
        Discriminator(
            lambda value: _tag(value, makers),
            custom_error_type="type",
            custom_error_message="|".join(makers),
        ),
    ]


def _tag(value: object, makers: Mapping[str, Maker]) -> str | None:
    """Return which table this is: the one it names, or the only one that its keys fit, or touch."""
    if not isinstance(value, Mapping):
        return _VALUE
    if "type" in value:
        return value["type"] if value["type"] in list(makers) else None  # a list has no hash
    if len(makers) == 1:
        return next(iter(makers))
    return _only([name for name, make in makers.items() if _fits(value, _fields(make))]) or _only(
        [name for name, make in makers.items() if set(value) & set(_fields(make))]
    )


def _fits(value: Mapping[str, object], fields: Mapping[str, tuple[Any, bool]]) -> bool:
    needed = {name for name, (_, is_needed) in fields.items() if is_needed}
    return needed <= set(value) <= set(fields)


def _only(names: Sequence[str]) -> str | None:
    return names[0] if len(names) == 1 else None


def _keywords(function: Callable[..., Any], *left_out: str) -> dict[str, Any]:
    """Return the keywords of a method as fields of a model."""
    hints = get_type_hints(function, localns={"StopCondition": StopCondition})
    return {
        name: (annotation_of(hint), None)
        for name, hint in hints.items()
        if name not in ("return", *left_out)
    }


@functools.cache
def file_model() -> type[BaseModel]:
    """Return the model of a whole file."""
    simulation = _keywords(Simulation.__init__, "drive")
    run = _keywords(Simulation.run, "progress", "callback", "stop", "record")
    stop = _list_of(_tables_of([StopCondition]))
    run |= {"stop": (stop, None), "record": (list[str], None)}
    run |= {"out": (str, None)}
    return create_model(
        "file",
        __config__=_STRICT,
        drive=(_tables_of([ChainDrive]), ...),
        simulation=(
            create_model("simulation", __config__=_STRICT, **simulation),
            Field(default_factory=dict),
        ),
        run=(create_model("run", __config__=_STRICT, **run), Field(default_factory=dict)),
    )
