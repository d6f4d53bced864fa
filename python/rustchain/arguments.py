"""Arguments at the border: converted and checked by the types that signatures declare."""

from __future__ import annotations

import contextlib
import functools
import inspect
import math
import os
import re
import types
import typing
from collections.abc import Callable, Collection, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, Literal, TypeVar, Union, get_args, get_origin

import numpy as np
import numpy.typing as npt

from rustchain.errors import InvalidInput
from rustchain.names import known_keywords, suggest
from rustchain.typing import Array

_Class = TypeVar("_Class", bound=type)
_Function = TypeVar("_Function", bound=Callable[..., Any])

# What a path may be, as messages have it.
PATH_WORDS = "the name of a file, str or Path; open files and buffers are not supported"

_Bytes = bytes | bytearray | memoryview  # sequences of integers that are meant as none

_LONGEST = 80  # characters of a value in a message: one line of a terminal; src/error.rs has it too
_DEEPEST = 4  # levels of lists in an argument; rows of a table are two, no argument has more


def shown(value: object) -> str:
    """Return `value` as a message shows it: one line of at most 80 characters."""
    try:
        text = repr(value)
    except Exception:
        text = f"<{type(value).__name__}>"
    if len(text) <= _LONGEST and "\n" not in text:
        return text
    text = re.sub(r"\s+", " ", text[: 100 * _LONGEST])
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."


def plain(value: Any) -> Any:  # noqa: ANN401
    """Return `value` with arrays and lists as tuples, and numbers of any kind as Python's.

    What is nested deeper than any argument, or within itself, and what is no number is returned
    unchanged, for a check to refuse.
    """
    return _plain(value, _DEEPEST)


class _NoNumber:
    """A date, a record or a masked value of NumPy, or a number beyond the range of float."""

    def __init__(self, value: object) -> None:
        self._shown = shown(value)

    def __repr__(self) -> str:
        return self._shown


def _plain(value: Any, levels: int) -> Any:  # noqa: ANN401
    if isinstance(value, np.ndarray | np.generic):
        if value.dtype.kind in "mMV" or np.ma.is_masked(value):
            return _NoNumber(value)
        value = value.tolist()
    if isinstance(value, list | tuple):
        return tuple(_plain(each, levels - 1) for each in value) if levels > 0 else value
    if type(value) in (float, int, bool, str) or not hasattr(type(value), "__float__"):
        return value
    try:
        number = int(value) if isinstance(value, int) else float(value)
    except Exception:
        return value
    overflow = number in (math.inf, -math.inf) and value != number  # of a longer type
    return _NoNumber(value) if overflow else number


def checked(function: _Function, only: Collection[Any] | None = None) -> _Function:
    """Let a function check its arguments by their names and annotations before it is called.

    Numbers are converted to Python's exactly once; they have to be finite. What an annotation does
    not say, such as a range, is left to the function; with `only`, so are all other types.
    """
    function = known_keywords(function)

    @functools.wraps(function)
    def called(*args: Any, **keywords: Any) -> object:  # noqa: ANN401
        try:
            bound = _signature(function).bind(*args, **keywords)
        except TypeError:  # the function says what is missing, or too much
            return function(*args, **keywords)
        hints = _hints(function)
        for name, value in bound.arguments.items():
            if name not in hints or (only is not None and hints[name] not in only):
                continue
            where = f"{function.__name__}({name})"
            if _signature(function).parameters[name].kind is inspect.Parameter.VAR_POSITIONAL:
                bound.arguments[name] = tuple(admitted(where, each, hints[name]) for each in value)
            else:
                bound.arguments[name] = admitted(where, value, hints[name])
        return function(*bound.args, **bound.kwargs)

    return called  # type: ignore[return-value]  # it has the signature of the function


def checked_methods(owner: _Class) -> _Class:
    """Let all public methods of a class check their arguments, those that it inherits too."""
    for name in dir(owner):
        method = inspect.getattr_static(owner, name)
        if not name.startswith("_") and inspect.isfunction(method):
            setattr(owner, name, checked(method))
    return owner


def admitted(where: str, value: Any, hint: Any) -> Any:  # noqa: ANN401
    """Return `value` as the type `hint` has it.

    Raises
    ------
    InvalidInput
        It is no such value; the message begins with `where`.
    """
    if hint is Any or hint is object or isinstance(hint, TypeVar):
        return value
    if hint in _READERS:
        found = _READERS[hint](value)
        if found is not None:
            return found
    elif get_origin(hint) in (Union, types.UnionType):
        return _one_of(where, value, get_args(hint))
    elif get_origin(hint) is Literal:
        if isinstance(value, str | None) and value in get_args(hint):
            return value
        if isinstance(value, str):
            near = suggest(value, [word for word in get_args(hint) if word], [])
            expected = f"{_words(hint)}; {near}" if "'" in near else _words(hint)
            raise InvalidInput(f"{where}: got {shown(value)}; expected {expected}")
    elif _is_row(hint):
        return _row(where, value, hint)
    elif _is_instance(value, hint):
        return value
    broken = hint is str and isinstance(value, str)
    expected = "text without lone surrogates" if broken else _words(hint)
    if hint is int:
        expected += as_int(value)
    raise InvalidInput(f"{where}: got {shown(value)}; expected {expected}")


def _one_of(where: str, value: Any, hints: tuple[Any, ...]) -> Any:  # noqa: ANN401
    """Return `value` as the first type that has it."""
    if value is None and type(None) in hints:
        return None
    rows = [hint for hint in hints if _is_row(hint)]
    if rows and isinstance(value, list | tuple | np.ndarray):
        return admitted(where, value, rows[0])
    for hint in hints:
        try:
            return admitted(where, value, hint)
        except InvalidInput:
            continue
    if Path in hints:  # text is a path, too
        hints = tuple(hint for hint in hints if hint is not str)
    expected = " or ".join(dict.fromkeys(map(_words, hints)))
    raise InvalidInput(f"{where}: got {shown(value)}; expected {expected}")


def _row(where: str, value: Any, hint: Any) -> Any:  # noqa: ANN401
    """Return a sequence with each of its values as its type has it."""
    if isinstance(value, str | _Bytes) or not isinstance(value, Sequence | np.ndarray):
        raise InvalidInput(f"{where}: got {shown(value)}; expected {_words(hint)}")
    arguments = get_args(hint)
    each = arguments[0] if arguments else Any
    try:
        listed = list(value)
    except Exception as error:
        raise InvalidInput(f"{where}: got {shown(value)}; expected {_words(hint)}") from error
    fixed = get_origin(hint) is tuple and Ellipsis not in arguments
    if fixed and len(listed) != len(arguments):
        raise InvalidInput(f"{where}: got {shown(value)}; expected {len(arguments)} values")
    head, end = (where[:-1], ")") if where.endswith(")") else (where, "")
    return tuple(admitted(f"{head}.{k}{end}", one, each) for k, one in enumerate(listed, 1))


def items_within(where: str, values: Any, most: int) -> list[Any] | None:  # noqa: ANN401
    """Return the items of an iterable, which may have no end, or None where it is none.

    Raises
    ------
    InvalidInput
        There are more than `most`; the message begins with `where`.
    """
    if isinstance(values, str | bytes | Mapping):
        return None
    try:
        items = list(islice(values, most + 1))
    except Exception:
        return None
    if len(items) > most:
        raise InvalidInput(f"{where}: got more than {most} values; expected at most {most}")
    return items


def count_within(where: str, value: object, least: int, most: int) -> int:
    """Return a whole number from `least` to `most`, or raise `InvalidInput`."""
    count = _count(value)
    if count is not None and least <= count <= most:
        return count
    msg = f"{where} = {shown(value)}: must be a whole number from {least} to {most}"
    raise InvalidInput(msg)


def finite_number(value: object) -> float | None:
    """Return a finite real number as Python's, or None."""
    given = plain(value)
    if isinstance(given, bool) or not isinstance(given, int | float):
        return None
    try:
        return given if math.isfinite(given) else None
    except OverflowError:  # an integer beyond every float
        return None


def as_int(value: object) -> str:
    """Return how to write a whole number that is a float or text; nothing of all else."""
    text = float.__repr__(value).removesuffix(".0") if isinstance(value, float) else value
    digits = isinstance(text, str) and text.isascii() and text.isdecimal()
    return f" as an int, {text}" if digits else ""


def _count(value: object) -> int | None:
    """Return an integer as Python's, or None."""
    given = plain(value)
    return given if isinstance(given, int) and not isinstance(given, bool) else None


def _truth(value: object) -> bool | None:
    """Return True or False, or None."""
    return bool(value) if isinstance(value, bool | np.bool_) else None


def _text(value: object) -> str | None:
    """Return text that can be encoded, or None."""
    if not isinstance(value, str):
        return None
    return value if value.encode(errors="replace").decode() == value else None


def _path(value: object) -> object | None:
    """Return what names a file, or None."""
    return value if isinstance(value, str | os.PathLike) else None


def finite_array(value: Any) -> npt.NDArray[np.float64] | None:  # noqa: ANN401
    """Return finite real numbers of any shape, or None."""
    try:
        kind = getattr(getattr(value, "dtype", None), "kind", "")
        listed = isinstance(value, list | tuple) or kind == "O" or np.ma.is_masked(value)
        given = np.asarray(plain(value) if listed else value)  # a long array is not made a list
        numbers = given.dtype.kind in "iuf" and not isinstance(value, _Bytes)
        array = given.astype(np.float64) if numbers else None
    except Exception:
        return None
    return array if array is not None and np.isfinite(array).all() else None


def rows_of(name: str, values: npt.ArrayLike | None, bodies: int | str) -> Array | None:
    """Return `values` in the form of the compiled module: (bodies, 3) real numbers."""
    if values is None:
        return None
    try:
        listed = isinstance(values, list | tuple) or np.ma.is_masked(values)
        given = np.asarray(plain(values) if listed else values)
        array = np.ascontiguousarray(given, dtype=float) if given.dtype.kind in "iuf" else None
    except Exception:
        given, array = np.empty(0, dtype=object), None
    if array is None or array.ndim != 2:
        said = shown(values) if array is None else f"an array of shape {given.shape}"
        msg = f"{name} = {said}, {given.dtype}: must be numbers of shape ({bodies}, 3)"
        raise InvalidInput(msg)
    return array


_READERS: dict[Any, Callable[[object], Any]] = {
    float: finite_number,
    int: _count,
    bool: _truth,
    str: _text,
    Path: _path,
    npt.ArrayLike: finite_array,
}
_WORDS = {
    float: "a finite number",
    int: "a whole number",
    bool: "True or False",
    str: "text",
    Path: PATH_WORDS,
    npt.ArrayLike: "finite numbers",
    type(None): "None",
}


def _is_row(hint: Any) -> bool:  # noqa: ANN401
    return get_origin(hint) in (tuple, list, Sequence)


def _is_instance(value: object, hint: Any) -> bool:  # noqa: ANN401
    """Return whether a value is of a class or of a generic type's origin; else return True."""
    if hint is type(None):
        return value is None
    kind = get_origin(hint) or hint
    if kind is Callable:
        return callable(value)
    return isinstance(value, kind) if isinstance(kind, type) else True


def _words(hint: Any) -> str:  # noqa: ANN401
    """Return a type as text."""
    if hint in _WORDS:
        return _WORDS[hint]
    if get_origin(hint) is Literal:
        return " or ".join(map(repr, get_args(hint)))
    if get_origin(hint) in (Union, types.UnionType):
        return " or ".join(map(_words, get_args(hint)))
    if _is_row(hint):
        return "a sequence"
    kind = get_origin(hint) or hint
    if kind is Callable:
        return "a function"
    name = getattr(kind, "__name__", str(kind))
    return f"{'an' if name[:1] in 'AEIOU' else 'a'} {name}"


@functools.cache
def _signature(function: Callable[..., object]) -> inspect.Signature:
    return inspect.signature(function)


@functools.cache
def _hints(function: Any) -> dict[str, Any]:  # noqa: ANN401
    """Return the types of the arguments that are known when a program runs."""
    inner: Any = inspect.unwrap(function)
    found: dict[str, Any] = {}
    for name, written in inner.__annotations__.items():
        one = types.SimpleNamespace(__annotations__={name: written})
        with contextlib.suppress(NameError):  # a type that only type checkers import
            found |= typing.get_type_hints(one, inner.__globals__)
    found.pop("return", None)
    return found
