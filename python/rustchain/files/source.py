"""The text of a drive file: where each key stands in it, so that errors can say so."""

from __future__ import annotations

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

_HEADER = re.compile(r"(\[\[?)([^\]]+)\]\]?\s*(#.*)?$")
_ENTRY = re.compile(r"\s*([A-Za-z0-9_.\"'-]+)\s*=")
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
    lines : dict
        Line of each key that begins one, from 1.
    """

    path: Path
    content: dict[str, Any]
    lines: dict[Key, int] = field(default_factory=dict)

    @classmethod
    def of(cls, path: Path) -> Source:
        """Read a file."""
        try:
            text = text_of(path)
            content = tomllib.loads(text)
        except OSError as error:
            where = shown_path(path)
            msg = f"{where}: cannot be read ({reason(error)}): give the path of a drive file"
            raise InvalidInput(msg) from error
        except ValueError as error:  # of TOML, of UTF-8, or an integer of too many digits
            msg = f"{path}: is no TOML ({error}): give a drive file, as docs/files.md has them"
            raise InvalidInput(msg) from error
        except RecursionError as error:
            raise cls(path, {}).too_deep() from error
        source = cls(path, content, _lines_of(text))
        if _is_deeper(content, DEEPEST):
            raise source.too_deep()
        return source

    def too_deep(self) -> InvalidInput:
        """Return the error of tables and lists that are nested without end."""
        return InvalidInput(
            f"{self.path}: has tables or lists nested more than {DEEPEST} deep; expected a drive "
            "file, as docs/files.md has them; close the brackets where a value ends"
        )

    def refusal(self, key: Key, message: str) -> InvalidInput:
        """Return the error that says where `key` stands, and what is wrong with it or below it."""
        named = _FIELD.match(message)
        # What is refused is mostly a field of the table: its own line is nearer.
        below = (*key, named.group(1)) if named else key
        return InvalidInput(f"{self._place(below)}: {name_of(key)}: {message}")

    def refusal_at(self, key: Key, message: str) -> InvalidInput:
        """Return the error that names `key` and says where it stands."""
        return InvalidInput(f"{self._place(key)}: {name_of(key)}: {message}")

    def _place(self, key: Key) -> str:
        """Return the file, and the line of a key or of the nearest one above it."""
        while key and key not in self.lines:
            key = key[:-1]
        return f"{self.path}, line {self.lines[key]}" if key else str(self.path)


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


def _lines_of(text: str) -> dict[Key, int]:
    """Return the line of each header and of each key that begins a line."""
    lines: dict[Key, int] = {}
    counts: dict[Key, int] = {}
    table: Key = ()
    for number, line in enumerate(text.splitlines(), 1):
        if header := _HEADER.match(line.strip()):
            table = _resolved(_parts(header.group(2)), counts)
            if header.group(1) == "[[":
                counts[table] = counts.get(table, -1) + 1
                lines.setdefault(table, number)
                table = (*table, counts[table])
            lines.setdefault(table, number)
        elif entry := _ENTRY.match(line):
            lines.setdefault((*table, *_parts(entry.group(1))), number)
    return lines


def _parts(dotted: str) -> list[str]:
    return [part.strip().strip("\"'") for part in dotted.split(".")]


def _resolved(parts: list[str], counts: dict[Key, int]) -> Key:
    """Return the key of a header; within an array of tables it is of the last one."""
    key: Key = ()
    for place, part in enumerate(parts):
        key = (*key, part)
        if key in counts and place + 1 < len(parts):
            key = (*key, counts[key])
    return key
