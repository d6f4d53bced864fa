"""Names: that of the distribution, and unknown ones answered with the nearest known one."""

from __future__ import annotations

import functools
import inspect
import re
from collections.abc import Callable, Iterable, Mapping
from difflib import get_close_matches
from itertools import accumulate
from typing import Any, TypeVar, get_args, overload

DISTRIBUTION = "rustchain-dynamics"
"""Name in the package index, where ``rustchain`` is another project's."""

_FEWEST = 3  # known names that are listed, however long
_LONGEST = 160  # [characters] of the list of known names: two lines of a terminal

_Target = TypeVar("_Target", bound=Callable[..., object])
_Class = TypeVar("_Class", bound=type)


def suggest(word: object, known: Iterable[str], main: Iterable[str] | None = None) -> str:
    """Return ``did you mean 'x'?``, or the known names (of many, the `main` ones)."""
    names = list(known)
    if (near := nearest_name(word, names)) is not None:
        return f"did you mean {near!r}?"
    listed = list(map(repr, names if main is None else main))
    lengths = accumulate(len(text) + 2 for text in listed)
    kept = listed[: max(_FEWEST, sum(length <= _LONGEST for length in lengths))]
    if not kept:
        return "there is none"
    return f"known: {', '.join(kept)}{', ...' if len(kept) < len(listed) else ''}"


def nearest_name(word: object, known: Iterable[str], least: float = 0.6) -> str | None:
    """Return the known name that is spelt most like `word`; None where none is near.

    `least` is the least likeness, from 0 to 1.
    """
    folded = {name.casefold(): name for name in known}
    near = get_close_matches(word.casefold(), folded, 1, least) if isinstance(word, str) else []
    return folded[near[0]] if near else None


def counted(number: int, plural: str) -> str:
    """Return a number of things in words: "2 bodies", but "1 body"."""
    if number != 1:
        return f"{number} {plural}"
    return f"1 {plural[:-3]}y" if plural.endswith("ies") else f"1 {plural[:-1]}"


def named_attributes(target: _Class) -> _Class:
    """Let a class answer an unknown attribute with the nearest known one."""

    def missing(self: object, name: str) -> object:
        kind = type(self).__name__
        if name.startswith("_"):  # what copying and pickling look for
            raise AttributeError(f"{kind} has no attribute {name!r}")
        known = [each for each in dir(self) if not each.startswith("_")]
        msg = f"{kind} has no attribute {name!r}; {suggest(name, known)}"
        raise AttributeError(msg, name=name, obj=None)  # no second suggestion by Python

    target.__getattr__ = missing  # type: ignore[attr-defined]
    return target


@overload
def known_keywords(target: _Target, /) -> _Target: ...
@overload
def known_keywords(**other_names: str) -> Callable[[_Target], _Target]: ...
def known_keywords(target: Any = None, /, **other_names: str) -> Any:
    """Let a function or a class answer an unknown keyword with the nearest known name.

    The decorated object keeps its type, so that type checkers see the signature as it was written.
    On a dataclass, put it above ``@dataclass``. `other_names` maps other names of keywords to them.
    """
    if target is None:
        return functools.partial(_known_keywords, other_names=other_names)
    return _known_keywords(target, {})


def _known_keywords(target: _Target, other_names: Mapping[str, str]) -> _Target:
    if isinstance(target, type):
        elsewhere = getattr(target, "_elsewhere", {})
        checked = _checked(target.__init__, target.__name__, other_names, elsewhere)  # type: ignore[misc]
        target.__init__ = checked  # type: ignore[misc]
        return target
    return _checked(target, target.__name__, other_names, {})


@functools.cache
def _keywords(function: Callable[..., object]) -> list[str] | None:
    """Return the names of the keywords, None if any is allowed.

    Most functions of an import are never called: their signatures are not read.
    """
    named = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    parameters = inspect.signature(function).parameters.values()
    if any(p.kind is inspect.Parameter.VAR_KEYWORD for p in parameters):
        return None
    return [p.name for p in parameters if p.kind in named and p.name not in ("self", "cls")]


def _too_many(function: Callable[..., object], given: int) -> str | None:
    """Return what a function takes by position where it was `given` more; None: it was not."""
    parameters = inspect.signature(function).parameters.values()
    named = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    places = [p.name for p in parameters if p.kind in named]
    if given <= len(places) or any(p.kind is inspect.Parameter.VAR_POSITIONAL for p in parameters):
        return None
    # Methods of `Result` are functions with the result as the first argument, by position only.
    names = [
        p.name
        for p in parameters
        if p.kind in named
        and p.name not in ("self", "cls")
        and (p.name, p.kind) != ("result", inspect.Parameter.POSITIONAL_ONLY)
    ]
    others = "; give the others by name" if len(places) < len(parameters) else ""
    given -= len(places) - len(names)
    return f"takes {', '.join(names) or 'nothing'} by position, got {given} values{others}"


def _field_of_returned(function: Callable[..., object], keyword: str) -> str | None:
    """Return how to set a field of the description that a function returns; None: it has none."""
    made: Any = inspect.unwrap(function)
    kind = made.__globals__.get(made.__annotations__.get("return"))
    if keyword not in getattr(kind, "__dataclass_fields__", ()):
        return None
    name = f"{made.__name__}(...)"
    return f"it is a field of {kind.__name__}: dataclasses.replace({name}, {keyword}=...)"


def _field_of_scene(function: Callable[..., object], keyword: str) -> str | None:
    """Return how to set a field of the scene that a function takes; None: it has none."""
    made: Any = inspect.unwrap(function)
    words = re.findall(r"\w+", str(made.__annotations__.get("scene", "")))
    kinds = [kind for word in words if (kind := made.__globals__.get(word)) is not None]
    kinds += [kind for union in kinds for kind in get_args(union)]
    scenes = (kind for kind in kinds if getattr(kind, "__name__", "") == "Scene")
    if not any(keyword in kind.__dataclass_fields__ for kind in scenes):
        return None
    return f"it is a field of the scene: {made.__name__}(rc.Scene(drive, {keyword}=...), ...)"


def _checked(
    function: _Target, name: str, other_names: Mapping[str, str], elsewhere: Mapping[str, str]
) -> _Target:
    """Wrap `function` so that unknown keywords raise before it is called.

    `elsewhere` has the remedy for keywords that belong to another object.
    """

    @functools.wraps(function)
    def checked(*args: Any, **keywords: Any) -> object:  # noqa: ANN401
        for other in other_names.keys() & keywords.keys():
            if (proper := other_names[other]) in keywords:
                msg = f"{name}() got {proper!r} twice, once by its other name {other!r}"
                raise TypeError(msg)
            keywords[proper] = keywords.pop(other)
        for keyword in keywords:
            known = _keywords(function)
            if known is not None and keyword not in known:
                remedy = (
                    elsewhere.get(keyword)
                    or _field_of_returned(function, keyword)
                    or _field_of_scene(function, keyword)
                    or suggest(keyword, known)
                )
                msg = f"{name}() has no argument {keyword!r}; {remedy}"
                raise TypeError(msg)
        try:
            return function(*args, **keywords)
        except TypeError:
            if (why := _too_many(function, len(args))) is None:
                raise
        raise TypeError(f"{name}() {why}")

    return checked  # type: ignore[return-value]
