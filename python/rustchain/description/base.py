"""Base of the descriptions: frozen values, checked when made, written and read as JSON."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn, TypeVar, get_type_hints

from rustchain import _rustchain
from rustchain.arguments import admitted, as_int, plain, shown
from rustchain.errors import InvalidInput
from rustchain.names import known_keywords, suggest

__all__ = [  # without it, type checkers do not export `description`, a second name of `dataclass`
    "Description",
    "Typed",
    "class_named",
    "described",
    "description",
    "fields_of",
    "is_default",
]

if TYPE_CHECKING:  # which read the fields of a dataclass by this name alone
    from dataclasses import dataclass as description
else:

    def description(**options: bool) -> Callable[[type], type]:
        """Make a class a dataclass that answers unknown keywords with the nearest known name."""
        return lambda kind: known_keywords(dataclass(**options)(kind))


_Class = TypeVar("_Class")

_LINE = 100  # characters of a repr
_WHOLE = ("int", "int | None")  # annotations of fields


@dataclass(frozen=True)
class Description:
    """Base of the frozen dataclasses, in SI units, that describe a scene."""

    _types: ClassVar[dict[str, type[Any]]] = {}

    def __init_subclass__(cls) -> None:
        """Register the class by its name, for `from_json`; give it the short repr."""
        Description._types[cls.__name__] = cls
        if "__repr__" not in vars(cls):  # before the dataclass makes its own
            cls.__repr__ = short_repr  # type: ignore[method-assign]

    def __post_init__(self) -> None:
        """Turn lists and arrays into tuples, then have the compiled module check every field."""
        for field in dataclasses.fields(self):
            value = plain(getattr(self, field.name))
            object.__setattr__(self, field.name, value)
            if field.type in _WHOLE and (meant := as_int(value)):
                msg = f"{type(self).__name__}.{field.name} = {value!r}: must be a whole number"
                raise InvalidInput(msg + meant)
        _rustchain.validate(self)

    def to_json(self, *, placeholders: bool = False) -> str:
        """Return the description as JSON; floats keep every bit.

        Python functions are refused, or with `placeholders` replaced by what raises when called.
        """
        return json.dumps(self, default=_with_placeholders if placeholders else _tagged)

    @staticmethod
    def from_json(text: str) -> Any:  # noqa: ANN401
        """Return the description that `to_json` wrote.

        Raises
        ------
        InvalidInput
            The text names a type that is no description.
        """
        return json.loads(text, object_hook=_revived)


def short_repr(description: Any) -> str:  # noqa: ANN401
    """Return a dataclass on one line: the fields that differ from their defaults.

    Nested descriptions and long sequences are abbreviated where the line gets too long.
    """
    values = {
        f.name: value
        for f in dataclasses.fields(description)
        if f.repr and not is_default(f, value := getattr(description, f.name))
    }
    name = type(description).__name__
    for longest in (_LINE, _LINE // 3, 0):
        text = f"{name}({', '.join(f'{n}={_brief(v, longest)}' for n, v in values.items())})"
        if len(text) <= _LINE:
            return text
    return f"{text[: _LINE - 4]}...)"


def is_default(field: dataclasses.Field[Any], value: object) -> bool:
    """Return whether a field has its default."""
    default = field.default
    if field.default_factory is not dataclasses.MISSING:
        default = field.default_factory()
    try:
        return bool(type(value) is type(default) and value == default)
    except ValueError:  # arrays
        return False


def _brief(value: object, longest: int) -> str:
    """Return a repr of `longest` characters, or an abbreviation; numbers are not shortened."""
    text = repr(value)
    if len(text) <= longest or isinstance(value, int | float | bool | None):
        return text
    if isinstance(value, list | tuple):
        kinds = {type(each).__name__ for each in value if dataclasses.is_dataclass(each)}
        return f"<{len(value)} {' and '.join(sorted(kinds)) or 'values'}>"
    if isinstance(value, str):
        return f"{text[: max(longest, 20)]}..." if len(text) > max(longest, 20) else text
    return f"{type(value).__name__}(...)"


class Typed(Description):
    """A description whose fields are checked by their annotations when it is made."""

    def __post_init__(self) -> None:
        """Turn lists and arrays into tuples, and check the type of every field."""
        types = get_type_hints(type(self))
        for field in dataclasses.fields(self):
            where = f"{type(self).__name__}.{field.name}"
            value = admitted(where, getattr(self, field.name), types[field.name])
            object.__setattr__(self, field.name, value)


def described(kind: type[_Class]) -> type[_Class]:
    """Let a dataclass that is no `Description` be a part of one, in JSON too."""
    Description._types[kind.__name__] = kind
    return kind


def class_named(name: object) -> type[Any] | None:
    """Return the class of a description or of a part by its name; None where there is none."""
    return Description._types.get(name) if isinstance(name, str) else None


def fields_of(value: object) -> dict[str, Any] | None:
    """Return the fields of a description by their names; None of all else."""
    if class_named(type(value).__name__) is not type(value):
        return None
    names = (field.name for field in dataclasses.fields(value))  # type: ignore[arg-type]
    return {name: getattr(value, name) for name in names}


class LostFunction:
    """The place of a Python function that a file could not hold."""

    def __init__(self, name: str = "") -> None:
        self.name = name

    def __call__(self, *_: object) -> NoReturn:
        """Raise: the function is lost."""
        msg = f"{self.name}: was a Python function, which files do not hold; set the function again"
        raise InvalidInput(msg)

    def __eq__(self, other: object) -> bool:
        """Return whether the same function was lost."""
        return isinstance(other, LostFunction) and other.name == self.name

    def __hash__(self) -> int:
        """Return the hash of the name."""
        return hash((LostFunction, self.name))


def _with_placeholders(value: object) -> dict[str, object]:
    """Return the tagged fields of a description, or the name of a function."""
    if callable(value):
        name = value.name if isinstance(value, LostFunction) else shown(value)
        return {"type": LostFunction.__name__, "name": name}
    return _tagged(value)


def _tagged(value: object) -> dict[str, object]:
    """Return the fields of a description beside the name of its type."""
    fields = fields_of(value)
    if fields is None:
        if callable(value):
            msg = (
                f"{shown(value)}: is a Python function, which files cannot hold; expected a "
                "description, such as a Table; Simulation.state() keeps a state in memory"
            )
        else:
            msg = f"{shown(value)}: cannot be written as JSON; expected a description"
        raise InvalidInput(msg)
    return {"type": type(value).__name__} | fields


def _revived(fields: dict[str, Any]) -> object:
    """Return the description whose tagged fields these are."""
    name = fields.pop("type", None)
    if name == LostFunction.__name__:
        return LostFunction(**fields)
    if class_named(name) is None:
        import_module("rustchain.description.scene")  # and with it all descriptions of a scene
    made = class_named(name)
    if made is None:
        known = suggest(name, Description._types)
        raise InvalidInput(f"type = {shown(name)}: is no description; expected one; {known}")
    return made(**fields)
