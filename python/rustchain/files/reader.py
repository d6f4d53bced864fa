"""Drive files: tables of TOML checked by their models and made into descriptions."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from rustchain.arguments import shown
from rustchain.description.laws.force import ForceLaw
from rustchain.errors import InvalidInput
from rustchain.files.models import MAKERS, file_model, makers_of
from rustchain.files.source import Key, Source, text_of
from rustchain.names import suggest
from rustchain.paths import reason
from rustchain.simulation.stop import StopCondition

__all__ = ["Source", "read"]


def read(path: Path) -> tuple[Source, dict[str, Any]]:
    """Return a drive file and what it describes: drive, simulation, run."""
    source = Source.of(path)
    content = _with_tables_read(source, source.content, ())
    try:
        checked = file_model().model_validate(content)
    except ValidationError as error:
        raise _refusal(source, content, error) from None
    found = {name: _made(source, (name,), getattr(checked, name)) for name in content}
    found = {"simulation": {}, "run": {}} | found
    if (out := found["run"].get("out")) is not None:
        found["run"]["out"] = path.parent / out
    return source, found


def _with_tables_read(source: Source, value: Any, key: Key) -> Any:  # noqa: ANN401
    """Return a value with the numbers of other files in place of ``{file = "..."}``."""
    if isinstance(value, list):
        return [_with_tables_read(source, each, (*key, i)) for i, each in enumerate(value)]
    if not isinstance(value, dict):
        return value
    if value.keys() != {"file"}:
        return {k: _with_tables_read(source, each, (*key, k)) for k, each in value.items()}
    path = source.path.parent / str(value["file"])
    try:
        return _rows_of_numbers(path)
    except (OSError, ValueError) as error:
        why = reason(error) if isinstance(error, OSError) else str(error)
        name = shown(str(value["file"]))
        msg = f"{name}: {why}: give a file of rows of numbers with commas between"
        raise source.refusal_at((*key, "file"), msg) from error


def _rows_of_numbers(path: Path) -> list[list[float]]:
    """Return the rows of a table; what stands behind ``#`` is a comment."""
    rows: list[list[float]] = []
    first = 0
    for number, line in enumerate(text_of(path).splitlines(), 1):
        cells = line.partition("#")[0].strip()
        if not cells:
            continue
        row = []
        for cell in cells.split(","):
            try:
                row.append(float(cell))
            except ValueError:
                hint = "; put '#' before a line of names" if not rows else ""
                msg = f"line {number}: {shown(cell.strip())} is no number{hint}"
                raise ValueError(msg) from None
        first = first or number
        if rows and len(row) != len(rows[0]):
            msg = f"line {number} has {len(row)} numbers, line {first} has {len(rows[0])}"
            raise ValueError(msg)
        rows.append(row)
    if not rows:
        msg = "has no row of numbers"
        raise ValueError(msg)
    return rows


def _made(source: Source, key: Key, value: Any) -> Any:  # noqa: ANN401
    """Return what a checked value stands for: descriptions for tables, the rest as it is."""
    if isinstance(value, list | tuple):
        return type(value)(_made(source, (*key, i), each) for i, each in enumerate(value))
    if not isinstance(value, BaseModel):
        return value
    given = value.model_fields_set - {"type"}
    fields = {name: _made(source, (*key, name), getattr(value, name)) for name in given}
    maker = _MAKERS.get(type(value).__name__)
    if maker is None:  # a table of keywords
        return fields
    try:
        return maker(**fields)
    except (InvalidInput, TypeError) as error:
        raise source.refusal(key, str(error)) from error


def _all_makers() -> dict[str, Any]:
    """Return all that makes something of a table, by name."""
    from rustchain.description.base import Description

    names = dict(Description._types)
    for kind in (*MAKERS, ForceLaw, StopCondition):
        names |= makers_of(kind)  # type: ignore[arg-type]
    return names


_MAKERS = _all_makers()


def _refusal(source: Source, content: Mapping[str, Any], error: ValidationError) -> InvalidInput:
    """Return what is wrong first, in the words of this package."""
    # A key that is not known is often what another one is missing for.
    found = sorted(error.errors(), key=lambda each: each["type"] != "extra_forbidden")[0]
    key, model = _key_of(content, found["loc"])
    kind, value = found["type"], found["input"]
    if kind == "extra_forbidden":
        fields = _fields_at(model)
        return source.refusal_at(key, f"means nothing here; {suggest(key[-1], fields)}")
    if kind == "missing":
        return source.refusal_at(key[:-1], f"{key[-1]!r} is missing: it must be given")
    if kind == "type":
        names = found["msg"].split("|")
        given = value.get("type") if isinstance(value, Mapping) else value
        if given is None:
            listed = " or ".join(f"type = {name!r}" for name in names)
            return source.refusal_at(key, f"its keys do not tell what it is: add {listed}")
        message = f"{shown(given)} is not known; {suggest(given, names)}"
        return source.refusal_at((*key, "type"), message)
    message = found["msg"].replace("Input should be", "must be")
    return source.refusal_at(key, f"{shown(value)}: {message}")


def _key_of(content: Any, place: tuple[int | str, ...]) -> tuple[Key, str | None]:  # noqa: ANN401
    """Return the key in the file that pydantic's place stands for, and the last model on the way.

    The names of models are in the place, but not in the file.
    """
    key: Key = ()
    model = None
    for part in place:
        is_model = isinstance(part, str) and part in _MAKERS
        inside = isinstance(content, dict) and part in content
        if is_model and not inside and part != model:
            model = str(part)
            continue
        key = (*key, part)
        try:
            content = content[part]
        except (KeyError, IndexError, TypeError):
            content = None
        if part in ("simulation", "run") and len(key) == 1:
            model = str(part)
    return key, model


def _fields_at(model: str | None) -> list[str]:
    """Return the keys of a model, by its name; without one, those of the file."""
    top = file_model()
    if model in ("simulation", "run"):
        inner = top.model_fields[str(model)].annotation
        return list(inner.model_fields)  # type: ignore[union-attr]
    if model is None:
        return list(top.model_fields)
    from rustchain.files.models import model_of

    return list(model_of(model, _MAKERS[model]).model_fields)
