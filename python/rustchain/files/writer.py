"""Scenes as text: TOML or JSON in the tables that the reader takes."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

from rustchain.arguments import shown
from rustchain.description.base import fields_of, is_default
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.scene import Scene
from rustchain.errors import InvalidInput

NONE = "none"  # stands for None where that is not the default


def text_of_scene(scene: Scene, form: str) -> str:
    """Return the text of a file that holds a scene; `form` is ".toml" or ".json"."""
    fields = _table("scene", scene)
    fields.pop("type")
    name = "mechanism" if isinstance(scene.system, Mechanism) else "drive"
    tables = {name: fields.pop("system"), "simulation": fields}
    if form == ".json":
        return json.dumps(tables, indent=2) + "\n"
    return "\n".join(_toml((), tables)).lstrip("\n") + "\n"


def _table(where: str, value: object) -> dict[str, Any]:
    """Return a description as a table with its type, without fields that have their defaults."""
    fields = fields_of(value)
    if fields is None:
        what = "a Python function" if callable(value) else f"a {type(value).__name__}"
        msg = f"{where}: is {what}, which a file cannot hold; expected numbers, text, descriptions"
        raise InvalidInput(msg)
    table: dict[str, Any] = {"type": type(value).__name__}
    for field in dataclasses.fields(value):  # type: ignore[arg-type]
        content = fields[field.name]
        if content is None and field.default is not None:
            table[field.name] = NONE
        elif content is not None and not is_default(field, content):
            table[field.name] = _written(f"{where}.{field.name}", content)
    return table


def _written(where: str, value: object) -> Any:  # noqa: ANN401
    """Return a value as files have it: numbers, text, lists and tables."""
    if isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, list | tuple):
        return [_written(f"{where}.{_label(k, v)}", v) for k, v in enumerate(value, 1)]
    return _table(where, value)


def _label(number: int, part: object) -> str:
    """Return the number of a part, with its name where it has one."""
    name = getattr(part, "name", None)
    return f"{number} ({shown(name)})" if name else str(number)


def _toml(path: tuple[str, ...], table: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of a table: its values, then the tables in it."""
    inside = {name: value for name, value in table.items() if _is_inside(value)}
    for name, value in table.items():
        if name not in inside:
            yield f"{_key(name)} = {_value(value)}"
    for name, value in inside.items():
        below = (*path, name)
        header = ".".join(map(_key, below))
        if isinstance(value, Mapping):
            yield from ("", f"[{header}]")
            yield from _toml(below, value)
        else:
            for each in value:
                yield from ("", f"[[{header}]]")
                yield from _toml(below, each)


def _is_inside(value: object) -> bool:
    """Return whether a value is a table or a list of tables."""
    if isinstance(value, list):
        return bool(value) and all(isinstance(each, Mapping) for each in value)
    return isinstance(value, Mapping)


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _value(name)


def _value(value: object) -> str:
    """Return a value in one line of TOML."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # JSON escapes what TOML does, but for DEL.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        pairs = (f"{_key(name)} = {_value(each)}" for name, each in value.items())
        return f"{{ {', '.join(pairs)} }}"
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    return repr(value)  # a number; inf and nan have the same names
