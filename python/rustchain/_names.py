"""Unknown names are answered with the nearest known one."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable
from difflib import get_close_matches
from typing import Any, TypeVar

_Target = TypeVar("_Target", bound=Callable[..., object])


def suggest(word: object, known: Iterable[str], main: Iterable[str] | None = None) -> str:
    """Return ``did you mean 'x'?``, or the known names (of many, the `main` ones)."""
    names = list(known)
    folded = {name.casefold(): name for name in names}
    near = get_close_matches(str(word).casefold(), folded, n=1)
    if near:
        return f"did you mean {folded[near[0]]!r}?"
    return f"known: {', '.join(map(repr, names if main is None else main))}"


def known_keywords(target: _Target) -> _Target:
    """Let a function or a class answer an unknown keyword with the nearest known name.

    The decorated object keeps its type, so that type checkers see the signature as it was written.
    On a dataclass, put it above ``@dataclass``.
    """
    if isinstance(target, type):
        target.__init__ = _checked(target.__init__, target.__name__)  # type: ignore[misc]
        return target
    return _checked(target, target.__name__)


def _checked(function: _Target, name: str) -> _Target:
    """Wrap `function` so that unknown keywords raise before it is called."""
    named = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    parameters = inspect.signature(function).parameters.values()
    known = [p.name for p in parameters if p.kind in named and p.name not in ("self", "cls")]

    @functools.wraps(function)
    def checked(*args: Any, **keywords: Any) -> object:  # noqa: ANN401
        for keyword in keywords:
            if keyword not in known:
                msg = f"{name}() has no argument {keyword!r}; {suggest(keyword, known)}"
                raise TypeError(msg)
        return function(*args, **keywords)

    return checked  # type: ignore[return-value]
