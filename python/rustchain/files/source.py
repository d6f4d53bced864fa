"""The text of a drive file: where each key stands in it, so that errors can say so."""

from __future__ import annotations

import json
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

from rustchain.errors import InvalidInput
from rustchain.paths import check_regular, reason, shown_path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

Key: TypeAlias = tuple[str | int, ...]

DEEPEST = 32
"""Levels of tables and lists in a file; the deepest that a description has, the points of a tooth's
pieces, are eight. Python's own recursion ends at about a thousand, less the caller's."""

_FIELD = re.compile(r"(?:\w+\.)?(\w+)")  # what a refusal begins with: Sprocket.teeth = ...


@dataclass(frozen=True)
class Source:
    """A drive file.

    Attributes
    ----------
    path : Path
        The file.
    content : dict
        What is in it.
    places : dict
        Line and column of each key and of each item of a list, from 1.
    """

    path: Path
    content: dict[str, Any]
    places: dict[Key, tuple[int, int]] = field(default_factory=dict)

    @classmethod
    def of(cls, path: Path) -> Source:
        """Read a file."""
        try:
            text = text_of(path)
            content = json.loads(text) if path.suffix.lower() == ".json" else tomllib.loads(text)
        except OSError as error:
            where = shown_path(path)
            msg = f"{where}: cannot be read ({reason(error)}): give the path of a drive file"
            raise InvalidInput(msg) from error
        except ValueError as error:  # of TOML, of UTF-8, or an integer of too many digits
            msg = (
                f"{path}: is no TOML ({error}); expected a drive file as in docs/reference/files.md"
            )
            raise InvalidInput(msg) from error
        except RecursionError as error:
            raise cls(path, {}).too_deep() from error
        if not isinstance(content, dict):
            msg = f"{path}: is no table; expected tables drive or mechanism, simulation and run"
            raise InvalidInput(msg)
        if _is_deeper(content, DEEPEST):
            raise cls(path, {}).too_deep()
        places = {} if path.suffix.lower() == ".json" else _Scanner(text).places()
        return cls(path, content, places)

    def too_deep(self) -> InvalidInput:
        """Return the error of tables and lists that are nested without end."""
        return InvalidInput(
            f"{self.path}: has tables or lists nested more than {DEEPEST} deep; expected a drive "
            "file as in docs/reference/files.md; close the brackets where a value ends"
        )

    def refusal(self, key: Key, message: str) -> InvalidInput:
        """Return the error that says where `key` stands, and what is wrong with it or below it."""
        named = _FIELD.match(message)
        # What is refused is mostly a field of the table: its own place is nearer.
        below = (*key, named.group(1)) if named else key
        return InvalidInput(f"{self.place(below)}: {name_of(key)}: {message}")

    def refusal_at(self, key: Key, message: str) -> InvalidInput:
        """Return the error that names `key` and says where it stands."""
        return InvalidInput(f"{self.place(key)}: {name_of(key)}: {message}")

    def place(self, key: Key) -> str:
        """Return the file, and line and column of a key or of the nearest one above it."""
        while key and key not in self.places:
            key = key[:-1]
        if not key:
            return str(self.path)
        line, column = self.places[key]
        return f"{self.path}, line {line}, column {column}"


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
    """Return a key as it is written in a path: drive.sprockets[1].teeth."""
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in key)
    return "".join(parts).removeprefix(".") or "the file"


class _Scanner:
    """Finds the places of the keys in a text that `tomllib` has read, and which is TOML therefore.

    `tomllib` tells no places; https://toml.io/en/v1.0.0 has the grammar.
    """

    _BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
    _PART = re.compile(r'[ \t]*([A-Za-z0-9_-]+|"(?:[^"\\\n]|\\.)*"|\'[^\'\n]*\')[ \t]*')
    _TEXT = re.compile(
        r'"""(?:[^"\\]|\\.|"(?!""))*"{3,5}' r"|'''(?:[^']|'(?!''))*'{3,5}"
        r'|"(?:[^"\\\n]|\\.)*"|\'[^\'\n]*\'',
        re.DOTALL,
    )  # fmt: skip
    # A number, a truth or a time; the date before a time may have a blank behind it.
    _PLAIN = re.compile(r"(?:\d{4}-\d\d-\d\d (?=\d\d:))?[^\s,\]}#]+")

    def __init__(self, text: str) -> None:
        self._text = text
        self._at = 0
        self._starts: dict[Key, int] = {}

    def places(self) -> dict[Key, tuple[int, int]]:
        """Return line and column of each key."""
        table: Key = ()
        last: dict[Key, int] = {}  # place of the last table in each array of tables
        while self._next():
            if self._text[self._at] != "[":
                self._entry(table)
                continue
            start, double = self._at, self._text.startswith("[[", self._at)
            self._at += 2 if double else 1
            parts = self._parts()
            self._at += 2 if double else 1
            table = ()
            for part in parts[:-1]:
                table = (*table, part)
                table = (*table, last[table]) if table in last else table
            table = (*table, parts[-1])
            self._starts.setdefault(table, start)
            if double:
                last[table] = last.get(table, -1) + 1
                table = (*table, last[table])
            self._starts.setdefault(table, start)
        return self._lines()

    def _next(self) -> str:
        """Go to the next character that is neither blank nor remark; return it, "" at the end."""
        blank = self._BLANK.match(self._text, self._at)
        self._at = blank.end() if blank else self._at
        return self._text[self._at : self._at + 1]

    def _parts(self) -> list[str]:
        """Go past a key, and return its parts."""
        parts = []
        while part := self._PART.match(self._text, self._at):
            self._at = part.end()
            name = part.group(1)
            quoted = name[0] in "\"'"
            parts.append(tomllib.loads(f"key = {name}")["key"] if quoted else name)
            if self._text[self._at] != ".":
                break
            self._at += 1
        return parts

    def _entry(self, table: Key) -> None:
        """Go past ``key = value``."""
        start, key = self._at, table
        for part in self._parts():
            key = (*key, part)
            self._starts.setdefault(key, start)
        self._at += 1  # the sign between
        self._next()
        self._value(key)

    def _value(self, key: Key) -> None:
        """Go past a value."""
        opened = self._text[self._at]
        if opened in "[{":
            self._at += 1
            self._inside(key, opened)
            self._at += 1
            return
        text = self._TEXT.match(self._text, self._at) or self._PLAIN.match(self._text, self._at)
        self._at = text.end() if text else len(self._text)

    def _inside(self, key: Key, opened: str) -> None:
        """Go through the items of a list, or the entries of a table, until the closing bracket."""
        count = 0
        while self._next() not in ("]", "}", ""):
            if opened == "{":
                self._entry(key)
            else:
                self._starts[(*key, count)] = self._at
                self._value((*key, count))
                count += 1
            if self._next() == ",":
                self._at += 1

    def _lines(self) -> dict[Key, tuple[int, int]]:
        """Return line and column of each place."""
        found, line, begin = {}, 1, 0
        for key, start in sorted(self._starts.items(), key=lambda item: item[1]):
            line += self._text.count("\n", begin, start)
            begin = max(begin, self._text.rfind("\n", begin, start) + 1)
            found[key] = (line, start - begin + 1)
        return found
