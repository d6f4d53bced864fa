"""What all descriptions share: plain frozen values, one check when made, JSON there and back."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias

from rustchain import _rustchain
from rustchain.arguments import plain as plain

Point: TypeAlias = tuple[float, float]


@dataclass(frozen=True)
class Description:
    """Base of the frozen dataclasses, in SI units, that describe a scene."""

    _types: ClassVar[dict[str, type[Description]]] = {}

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


def _tagged(description: object) -> dict[str, object]:
    """Return the fields of a description beside the name of its type."""
    if not isinstance(description, Description):
        msg = f"{type(description).__name__} is no description"
        raise TypeError(msg)
    fields = dataclasses.fields(description)
    return {"type": type(description).__name__} | {
        f.name: getattr(description, f.name) for f in fields
    }


def _revived(fields: dict[str, Any]) -> Description:
    """Return the description whose tagged fields these are."""
    return Description._types[fields.pop("type")](**fields)
