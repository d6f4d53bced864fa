"""What all descriptions share: plain frozen values, one check when made, JSON there and back."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias, TypeVar

from rustchain import _rustchain
from rustchain.arguments import plain as plain
from rustchain.arguments import shown
from rustchain.errors import InvalidInput

_Class = TypeVar("_Class")

Point: TypeAlias = tuple[float, float]


@dataclass(frozen=True)
class Description:
    """Base of the frozen dataclasses, in SI units, that describe a scene."""

    _types: ClassVar[dict[str, type[Any]]] = {}

    def __init_subclass__(cls) -> None:
        """Remember the class by its name, for `from_json`."""
        Description._types[cls.__name__] = cls

    def __post_init__(self) -> None:
        """Turn lists and arrays into tuples, then have the compiled module check every field."""
        for field in dataclasses.fields(self):
            object.__setattr__(self, field.name, plain(getattr(self, field.name)))
        _rustchain.validate(self)

    def to_json(self) -> str:
        """Return the description as JSON; floats keep every bit."""
        return json.dumps(self, default=_tagged)

    @staticmethod
    def from_json(text: str) -> Any:  # noqa: ANN401
        """Return the description that `to_json` wrote."""
        return json.loads(text, object_hook=_revived)


def described(kind: type[_Class]) -> type[_Class]:
    """Let a dataclass that is no `Description` be a part of one, in JSON too."""
    Description._types[kind.__name__] = kind
    return kind


def fields_of(value: object) -> dict[str, Any] | None:
    """Return the fields of a description by their names; None of all else."""
    if Description._types.get(type(value).__name__) is not type(value):
        return None
    names = (field.name for field in dataclasses.fields(value))  # type: ignore[arg-type]
    return {name: getattr(value, name) for name in names}


def _tagged(value: object) -> dict[str, object]:
    """Return the fields of a description beside the name of its type."""
    fields = fields_of(value)
    if fields is None:
        msg = f"{shown(value)}: is no description, which alone can be written as JSON"
        raise InvalidInput(msg)
    return {"type": type(value).__name__} | fields


def _revived(fields: dict[str, Any]) -> object:
    """Return the description whose tagged fields these are."""
    return Description._types[fields.pop("type")](**fields)
