"""The text of a drive or sweep file: where each key stands in it, so that errors can say so."""

from __future__ import annotations

import json
import re
from bisect import bisect_left
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

from rustchain import _rustchain
from rustchain.arguments import shown
from rustchain.errors import InvalidInput
from rustchain.paths import check_regular, path_of, reason, shown_path
from rustchain.results.superblock import is_hdf5

Key: TypeAlias = tuple[str | int, ...]

DEEPEST = 32
"""Levels of tables and lists in a file; the deepest that a description has, the points of a tooth's
pieces, are eight. Readers of JSON and TOML have limits of their own, all larger."""
# Of well-formed JSON: a text, with the colon behind a key; a bracket or comma; a number or word.
_TOKEN = re.compile(r'(?P<text>"(?:[^"\\]|\\.)*")(?P<colon>\s*:)?|[][{},]|[^][{},:"\s]+')


@dataclass(frozen=True)
class Source:
    """A drive or sweep file.

    Attributes
    ----------
    path : Path
        The file.
    content : dict
        What is in it.
    places : dict
        Line and column of each key and of each item of a list, from 1.
    kind : str
        "drive file" or "sweep file", for messages.
    """

    path: Path
    content: dict[str, Any]
    places: dict[Key, tuple[int, int]] = field(default_factory=dict)
    kind: str = "drive file"

    @classmethod
    def of(cls, path: Path, kind: str = "drive file") -> Source:
        """Read a file."""
        form = "JSON" if path.suffix.lower() == ".json" else "TOML"
        places: dict[Key, tuple[int, int]] = {}
        path = path_of(path)
        try:
            text = text_of(path)
            if form == "JSON":
                content, places = _read_json(text)
            else:
                content, places = _rustchain.read_toml(text)
        except OSError as error:
            where = shown_path(path)
            msg = f"{where}: cannot be read ({reason(error)}): give the path of a {kind}"
            raise type(error)(msg) from error
        except ValueError as error:  # of the form, of UTF-8, or an integer of too many digits
            msg = f"{path}: is no {form} ({error}); expected a {kind} as in docs/reference/files.md"
            if is_hdf5(path):
                msg = (
                    f"{path}: is a result file; expected a {kind}; rustchain plot and rustchain "
                    "report take results"
                )
            raise InvalidInput(msg) from error
        except RecursionError as error:
            raise cls(path, {}, kind=kind).too_deep() from error
        if not isinstance(content, dict):
            msg = f"{path}: is no table; expected a {kind} as in docs/reference/files.md"
            raise InvalidInput(msg)
        if _is_deeper(content, DEEPEST):
            raise cls(path, {}, kind=kind).too_deep()
        return cls(path, content, places, kind)

    def too_deep(self) -> InvalidInput:
        """Return the error of tables and lists that are nested without end."""
        return InvalidInput(
            f"{self.path}: has tables or lists nested more than {DEEPEST} deep; expected a "
            f"{self.kind} as in docs/reference/files.md; close the brackets where a value ends"
        )

    def refusal(self, key: Key, message: str) -> InvalidInput:
        """Return the error with the place of `key`, for a fault in it or below it."""
        # What is refused is mostly a field of the table, as in "Sprocket.teeth = 3: ...", or in
        # "catalogue_chain(links): ...": its own place is nearer.
        where = message.split(" ", 1)[0].rstrip("),:").replace("(", ".")
        fields = where.split(".")[1:] or [where]
        below = (*key, *(int(each) - 1 if each.isdecimal() else each for each in fields))
        return InvalidInput(f"{self.place(below)}: {name_of(key)}: {message}")

    def refusal_at(self, key: Key, message: str) -> InvalidInput:
        """Return the error with the name and the place of `key`."""
        return InvalidInput(f"{self.place(key)}: {name_of(key)}: {message}")

    def place(self, key: Key) -> str:
        """Return the file, and line and column of a key or of the nearest one above it."""
        while key and key not in self.places:
            key = key[:-1]
        if not key:
            return str(self.path)
        line, column = self.places[key]
        return f"{self.path}, line {line}, column {column}"


def _read_json(text: str) -> tuple[Any, dict[Key, tuple[int, int]]]:
    """Return the content of JSON, and line and column of each key and item, from 1.

    A key that is there twice in one object is refused, as in TOML.
    """
    try:
        content = json.loads(text)
    except json.JSONDecodeError as error:
        msg = f"{error.msg}, at line {error.lineno}, column {error.colno}"
        raise ValueError(msg) from error
    places: dict[Key, tuple[int, int]] = {}
    ends = [-1, *(found.start() for found in re.finditer("\n", text))]  # of lines
    inside: list[str | int] = []  # the present key of each open object, the place in each open list
    for found in _TOKEN.finditer(text):
        token = found[0]
        if token in "}]":
            del inside[-1]
        elif token == ",":
            if isinstance(inside[-1], int):
                inside[-1] += 1
        else:
            key = found["colon"] is not None
            if key:
                inside[-1] = json.loads(found["text"])
            if inside and (key or isinstance(inside[-1], int)) and len(inside) <= DEEPEST:
                line = bisect_left(ends, found.start())
                place = line, found.start() - ends[line - 1]
                if places.setdefault(tuple(inside), place) != place:
                    msg = (
                        f"{shown(inside[-1])} is there twice in one object, at line {line}, "
                        f"column {place[1]}; give it once"
                    )
                    raise ValueError(msg)
            if token in "{[":
                inside.append("" if token == "{" else 0)
    return content, places


def text_of(path: Path) -> str:
    """Return the text of a regular file, or raise `OSError` or `UnicodeDecodeError`."""
    check_regular(path)
    return path.read_text(encoding="utf-8-sig")


def _is_deeper(content: object, levels: int) -> bool:
    """Return whether tables and lists are nested more than `levels` deep."""
    inside = [content]
    for _ in range(levels):
        inside = [
            each
            for value in inside
            if isinstance(value, dict | list)
            for each in (value.values() if isinstance(value, dict) else value)
        ]
    return any(isinstance(value, dict | list) for value in inside)


def name_of(key: Key) -> str:
    """Return a key as ``--set`` has it, items counted from 1: drive.sprockets.2.teeth."""
    parts = (str(part + 1) if isinstance(part, int) else part for part in key)
    return ".".join(parts) or "the file"
