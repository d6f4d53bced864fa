"""Dotted names of the fields of drives and mechanisms, as parameters have them."""

from __future__ import annotations

import dataclasses
import functools
import re
from collections.abc import Iterator, Sequence
from types import UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

from rustchain.names import suggest

_NUMBER = re.compile(r"(?<=\.)\d+(?=[.']|$)")


def general(name: str) -> str:
    """Return a dotted name with 1 in place of each number of a part."""
    return _NUMBER.sub("1", name)


@functools.cache
def field_names(kind: type) -> tuple[str, ...]:
    """Return the dotted names of all fields of a description; parts of sequences are number 1."""
    return tuple(_paths(kind))


def nearest(name: str, known: Sequence[str], example: str) -> str:
    """Return which of the `known` names an unknown one may mean, with its own numbers."""
    if re.search(r"\[\d+\]", name):
        dotted = re.sub(r"\[(\d+)\]", lambda found: f".{int(found[1]) + 1}", name)
        return f"parts are numbered from 1 behind a dot: {dotted!r}"
    tails = (name.split(".", k)[-1] for k in range(1, name.count(".") + 1))
    of_ends = [path for path in known if path.endswith(f".{name}")]
    ends = [tail for tail in tails if tail in known] or of_ends
    if ends:
        return f"did you mean {ends[0]!r}?"
    main = [each for each in known if "." not in each] + [example, "..."]
    found = suggest(general(name), known, main)
    if "did you mean" not in found:
        return found
    numbers = iter(number for number in _NUMBER.findall(name) if int(number) > 0)
    return _NUMBER.sub(lambda _: next(numbers, "1"), found)


def missing_part(part: object, name: str, path: Sequence[str]) -> str | None:
    """Return why a number in a path means no part of `part`, called `name`; None where it does."""
    for head in path:
        if isinstance(part, tuple):
            if head not in (parts := parts_of(part)):
                return f"{name}.{head}: {why_not(part, name, head)}"
            part = parts[head]
        else:
            part = getattr(part, head, None)
        name = f"{name}.{head}"
    return None


def parts_of(value: object) -> dict[str, Any]:
    """Return what a parameter can change in a value: the parts of a tuple by number, or fields."""
    if isinstance(value, tuple):
        return {str(place): each for place, each in enumerate(value, 1)}
    if not dataclasses.is_dataclass(value):
        return {}
    return {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}


def why_not(part: object, name: str, head: str) -> str:
    """Return why `part`, called `name`, has no part `head` that can be changed."""
    if isinstance(part, tuple) and part:
        return f"does not exist; expected a number from 1 to {len(part)} after {name}"
    if isinstance(part, tuple):
        return f"does not exist, for {name} is empty"
    if parts := parts_of(part):
        return f"does not exist; {suggest(head, parts)}"
    kind = "None" if part is None else f"a {type(part).__name__}"
    return f"cannot be changed, for {name} is {kind}"


def _paths(kind: type) -> Iterator[str]:
    """Yield the dotted names of all fields: whole parts, what is in them, and coordinates."""
    hints = get_type_hints(kind)
    for field in dataclasses.fields(kind):
        yield field.name
        inside = dict.fromkeys(path for each in _members(hints[field.name]) for path in _in(each))
        yield from (f"{field.name}.{path}" for path in inside)


def _members(hint: Any) -> tuple[Any, ...]:  # noqa: ANN401
    return get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)


def _in(hint: Any) -> Iterator[str]:  # noqa: ANN401
    """Yield the dotted names of what lies within a value of this type; a table is taken whole."""
    if isinstance(hint, type) and dataclasses.is_dataclass(hint):
        yield from _paths(hint)
    elif get_origin(hint) in (tuple, Sequence):
        members = _members(get_args(hint)[0])
        if not any(get_origin(each) in (tuple, Sequence) for each in members):
            yield "1"
            yield from dict.fromkeys(f"1.{path}" for each in members for path in _in(each))
