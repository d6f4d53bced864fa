"""Dotted names of the fields of drives and mechanisms, as parameters have them."""

from __future__ import annotations

import dataclasses
import functools
import re
from collections.abc import Callable, Iterator, Sequence
from types import UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

from rustchain.names import nearest_name, suggest

# Of the many last names of fields, some are like any word: friction is to direction as 0.71.
_LIKENESS_OF_FIELDS = 0.75
_LIKENESS_OF_PARTS = 0.6  # body and bodies
_PARTS = 100  # of a sequence, in which a field is looked for
_NUMBER = re.compile(r"(?<=\.)\d+(?=[.']|$)")


def general(name: str) -> str:
    """Return a dotted name with 1 in place of each number of a part."""
    return _NUMBER.sub("1", name)


@functools.cache
def field_names(kind: type) -> tuple[str, ...]:
    """Return the dotted names of all fields of a description; parts of sequences are number 1."""
    return tuple(_paths(kind))


def nearest(name: str, known: Sequence[str], why: Callable[[str], str | None]) -> str:
    """Return which of the `known` names an unknown one may mean, with its own numbers.

    Each part of it is compared with the fields that exist at its place. Where `why` gives a reason
    against the name found, the same field of another part is proposed, or the reason is returned.
    """
    if re.search(r"\[\d+\]", name):
        dotted = re.sub(r"\[(\d+)\]", lambda found: f".{int(found[1]) + 1}", name)
        return f"parts are numbered from 1 behind a dot: {dotted!r}"
    meant = _meant(name, known)
    if isinstance(meant, list):
        return (any(map(why, meant)) and why(name)) or suggest(None, meant)
    reason = why(meant)
    if reason is not None:
        others = (meant.replace(".1.", f".{number}.", 1) for number in range(2, _PARTS))
        other = next((each for each in others if why(each) is None), None)
        if other is None or why(name):
            return why(name) or reason
        meant = other
    return f"did you mean {meant!r}?"


def _meant(name: str, known: Sequence[str]) -> str | list[str]:
    """Return the name that an unknown one may mean, or what is known at its place."""
    heads = name.split(".")
    shown = ""  # with a dot at its end, as `place`, which has 1 in place of its numbers
    for k, head in enumerate(heads):
        place, rest = general(shown), ".".join(heads[k:])
        paths = (path.removeprefix(place) for path in known if path.startswith(place))
        inside = sorted(paths, key=lambda path: path.count("."))
        if not inside:
            break
        if general(f".{head}")[1:] in inside and head.strip("0"):
            shown += f"{head}."
            continue
        names = [shown + path for path in inside if "." not in path]
        if rest.replace(".", "").isdecimal():  # numbers alone could be those of any part
            return names
        tail = general(f".{rest}")
        skipped = next((path for path in inside if path.endswith(tail)), None)
        if skipped is not None:  # parts before it are missing
            return shown + skipped.removesuffix(tail[1:]) + rest
        if head == rest:
            candidates = {path.split(".")[-1]: path for path in reversed(inside)}
        else:  # parts that have parts
            candidates = {path.split(".")[0]: path.split(".")[0] for path in inside if "." in path}
        if inside == ["1"]:  # numbers only, such as the two of a point
            shown += "2." if head.casefold() == "y" else "1."
            continue
        least = _LIKENESS_OF_FIELDS if head == rest else _LIKENESS_OF_PARTS
        near = "1" if "1" in inside else nearest_name(head, candidates, least)
        if near is None:
            ends = [name.split(".", n)[-1] for n in range(1, len(heads))]
            if k == 0 and (end := next((e for e in ends if general(e) in known), None)):
                return end
            if head != rest:  # parts of parts
                candidates = _places_of_parts(inside)
                near = nearest_name(head, candidates)
        if near is None:
            return names
        shown += f"{candidates[near]}."
    return shown[:-1]


def _places_of_parts(paths: Sequence[str]) -> dict[str, str]:
    """Return the name and the first place of each part that has parts, of sorted paths."""
    places: dict[str, str] = {}
    for path in paths:
        heads = path.split(".")
        for n in range(1, len(heads)):
            if not heads[n - 1].isdecimal():
                places.setdefault(heads[n - 1], ".".join(heads[:n]))
    return places


def missing_part(part: object, name: str, path: Sequence[str]) -> str | None:
    """Return why a path means no part of `part`, called `name`; None where it does.

    A path that begins with no field of `part` is of another object. Fields of a part that is None
    are possible: a pretension adds a tensioner.
    """
    if path[0] not in parts_of(part):
        return None
    for head in path:
        parts = parts_of(part)
        if head not in parts and (part is not None or head.isdecimal()):
            return f"{name}.{head}: {why_not(part, name, head)}"
        part, name = parts.get(head), f"{name}.{head}"
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
