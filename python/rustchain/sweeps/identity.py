"""A hash of scenes, runs and Python functions that is the same in every process."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import io
import json
import pickle
import sys
import types
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from rustchain.arguments import shown
from rustchain.description.base import fields_of
from rustchain.errors import InvalidInput
from rustchain.sweeps.case_run import is_of_user


def digest_of(value: object) -> str:
    """Return a hash of a value that is the same in every process, 32 hexadecimal digits.

    The hash of a Python function covers code, names of arguments, defaults, attributes and the
    values of a closure. It also covers numbers, text, functions and classes that the code refers
    to by name or as an attribute of a module. That of an object covers its class, with the methods
    and values of it, and the functions and classes that it holds, too. Code of rustchain, Python
    and installed packages counts by its name.

    Raises
    ------
    InvalidInput
        The value holds something without an identity, such as an open file or a function that
        `numpy.frompyfunc` made, or itself.
    """
    try:
        text = json.dumps(_part(value, _Seen(None, [])), sort_keys=True, ensure_ascii=True)
    except RecursionError as error:
        msg = (
            f"store: {shown(value)} has no identity by which a stored case could be found: it "
            "holds itself, or more functions that call each other than Python can follow"
        )
        raise InvalidInput(msg) from error
    return hashlib.sha256(text.encode()).hexdigest()[:32]


class _Seen(NamedTuple):
    """What is above a value in what is hashed, and what was before it.

    Attributes
    ----------
    module : str or None
        The module of the function or class that refers to it.
    values : list of object
        Functions, classes and objects that have been hashed.
    described : bool
        Whether it is of a description, in which a whole number is the same as an integer.
    foreign : bool
        Whether it was reached through another module, whose objects may have no identity.
    """

    module: str | None
    values: list[object]
    described: bool = False
    foreign: bool = False

    def inside(self, module: str) -> _Seen:
        """Return the same for what a function or class of a module refers to."""
        foreign = self.foreign or self.module not in (None, module)
        return _Seen(module, self.values, foreign=foreign)

    def has(self, code: Any) -> bool:  # noqa: ANN401
        """Return whether the code of a function or class counts."""
        return self.module in (None, code.__module__) or _is_of_user(code.__module__)


def _part(value: Any, seen: _Seen) -> Any:  # noqa: ANN401
    """Return a value as JSON has it, with its class where that is of the user."""
    kind, content = type(value), _content(value, seen)
    if kind.__module__ == "builtins" or not _is_of_user(kind.__module__):
        return content
    return ["of", content, _part(kind, seen)]


def _content(value: Any, seen: _Seen) -> Any:  # noqa: ANN401
    """Return the content of a value, as JSON has it."""
    if seen.described and isinstance(value, float) and value.is_integer():
        return "-0.0" if str(value) == "-0.0" else int(value)
    if value is None or isinstance(value, bool | int | float | str):
        return value if type(value) in (type(None), bool, int, float, str) else repr(value)
    if isinstance(value, list | tuple):
        return [type(value).__name__, *(_part(each, seen) for each in value)]
    if isinstance(value, set | frozenset):
        # Each for itself: a set has another order in another process.
        parts = (_part(each, seen._replace(values=list(seen.values))) for each in value)
        return ["set", *sorted(json.dumps(part, sort_keys=True) for part in parts)]
    if isinstance(value, Mapping):
        return ["mapping", *([_part(k, seen), _part(v, seen)] for k, v in value.items())]
    if isinstance(value, bytes | complex | slice | type(...)):
        return [type(value).__name__, repr(value)]
    if isinstance(value, np.ndarray) and value.dtype.kind in "biufcSU":
        content = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
        return ["array", str(value.dtype), list(value.shape), content]
    if (fields := fields_of(value)) is not None:
        return [type(value).__name__, _part(fields, seen._replace(described=True))]
    return _code(value, seen)


def _code(value: Any, seen: _Seen) -> Any:  # noqa: ANN401
    """Return the identity of a function, a class, a module, or any object as pickle has it."""
    for place, each in enumerate(seen.values):
        if value is each:
            return ["seen", place]
    seen.values.append(value)
    if isinstance(value, functools.partial):
        if seen.module is None and isinstance(value.func, types.FunctionType):
            seen = seen.inside(value.func.__module__)
        return ["partial", *(_part(v, seen) for v in (value.func, value.args, value.keywords))]
    if isinstance(value, types.MethodType):
        return ["method", _part(value.__func__, seen), _part(value.__self__, seen)]
    # Such as that of a dict or a pattern; a function of a module counts by its name.
    if isinstance(value, types.BuiltinFunctionType) and not isinstance(
        value.__self__, types.ModuleType | None
    ):
        return ["method", value.__name__, _part(value.__self__, seen)]
    if isinstance(value, types.FunctionType):
        return ["function", *_function(value, seen)]
    if isinstance(value, property):
        return ["property", *(_part(v, seen) for v in (value.fget, value.fset, value.fdel))]
    if isinstance(value, functools.cached_property):
        return ["property", _part(value.func, seen)]
    if isinstance(value, types.CodeType):
        consts = [_part(each, seen) for each in value.co_consts]
        arguments = value.co_varnames[: value.co_argcount + value.co_kwonlyargcount]
        names = [list(value.co_names), list(arguments)]
        return ["code", value.co_name, value.co_code.hex(), value.co_flags, *names, consts]
    if isinstance(value, types.ModuleType):
        return ["module", value.__name__]
    if isinstance(value, type) and seen.has(value):
        return ["class", *_class(value, seen)]
    if isinstance(value, np.ufunc):
        _check_named(value)
    if isinstance(value, type | types.BuiltinFunctionType | np.ufunc):
        return [
            "name",
            getattr(value, "__module__", ""),
            getattr(value, "__qualname__", str(value)),
        ]
    if (wrapped := getattr(value, "__wrapped__", None)) is not None:
        return ["wrapped", type(value).__name__, _part(wrapped, seen)]
    return ["object", *_object(value, seen)]


def _object(value: Any, seen: _Seen) -> list[Any]:  # noqa: ANN401
    """Return the class of an object and its content."""
    kind = type(value)
    if (identity := getattr(kind, "_identity_in_store", None)) is not None:
        return [kind.__qualname__, _part(identity(value), seen)]
    try:
        content = hashlib.sha256(_pickled(value, seen)).hexdigest()
    except Exception as error:  # whatever a class of the user's does
        if seen.foreign:
            return [kind.__module__, kind.__qualname__]
        if isinstance(error, InvalidInput):
            raise
        msg = (
            f"store: {shown(value)} has no identity by which a stored case could be found "
            f"({error}); expected functions of numbers, text and arrays"
        )
        raise InvalidInput(msg) from error
    return [kind.__module__, kind.__qualname__, content]


def _pickled(value: Any, seen: _Seen) -> bytes:  # noqa: ANN401
    """Return an object as pickle has it, with the code of the user's functions and classes."""
    own = seen.inside(type(value).__module__) if seen.module is None else seen

    class Pickler(pickle.Pickler):
        def reducer_override(self, each: Any) -> Any:  # noqa: ANN401
            if type(each) is np.vectorize:  # without what its calls have left
                return np.vectorize, (each.pyfunc,), vars(each) | {"_ufunc": {}}
            return NotImplemented

        def persistent_id(self, each: Any) -> Any:  # noqa: ANN401
            code = isinstance(each, types.FunctionType | type) and own.has(each)
            if code or isinstance(each, np.ufunc):
                return json.dumps(_part(each, own), sort_keys=True)
            return None

    file = io.BytesIO()
    Pickler(file, protocol=4).dump(value)
    return file.getvalue()


def _check_named(function: np.ufunc) -> None:
    """Refuse a function that no installed package has: `numpy.frompyfunc` shows no Python code."""
    for module, found in list(sys.modules.items()):
        there = getattr(found, "__dict__", {}).get(function.__name__) is function
        if there and not _is_of_user(module):
            return
    msg = (
        f"store: {shown(function)} has no identity by which a stored case could be found (its "
        "Python code cannot be read); call the function itself, or numpy.vectorize of it"
    )
    raise InvalidInput(msg)


def _function(function: types.FunctionType, seen: _Seen) -> list[Any]:
    """Return name, code, defaults, closure, what the code refers to, and attributes."""
    inside = seen.inside(function.__module__)
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    counting = {
        name: value
        for name, value in _referred(function).items()
        if not (isinstance(value, types.FunctionType | type) or hasattr(value, "__wrapped__"))
        or inside.has(value)
    }
    of_modules = {name: counting.pop(name) for name in list(counting) if "." in name}
    module = "" if function.__module__ == "__main__" else function.__module__
    parts = (function.__code__, function.__defaults__, function.__kwdefaults__, cells, counting)
    return [
        *(module, function.__qualname__),
        *(_part(each, inside) for each in parts),
        *(_part(each, inside._replace(foreign=True)) for each in (of_modules, vars(function))),
    ]


def _referred(function: types.FunctionType) -> dict[str, Any]:
    """Return what code refers to: globals, and what it may read from the user's modules."""
    names = sorted(_names(function.__code__))
    found = {name: function.__globals__[name] for name in names if name in function.__globals__}
    opened: list[types.ModuleType] = []
    waiting = list(found.items())
    for path, module in waiting:
        if isinstance(module, types.ModuleType) and module not in opened:
            opened.append(module)
            if _is_of_user(module.__name__):
                inside = {f"{path}.{n}": vars(module)[n] for n in names if n in vars(module)}
                found |= inside
                waiting += inside.items()
    return found


def _is_of_user(module: str) -> bool:
    """Return whether a module lies neither in rustchain or Python nor in an installed package.

    That of a notebook has no file.
    """
    found = sys.modules.get(module)
    file = getattr(found, "__file__", None)
    # A folder without __init__.py is a package without a file.
    places = [file] if isinstance(file, str) else list(getattr(found, "__path__", ()))
    return module == "__main__" or any(is_of_user(place) for place in places)


def _class(kind: type, seen: _Seen) -> list[Any]:
    """Return the names of a class and its bases, and what those of its module hold."""
    inside = seen.inside(kind.__module__)
    return [
        [each.__qualname__, _members(each, inside) if inside.has(each) else each.__module__]
        for each in kind.__mro__
    ]


def _members(kind: type, seen: _Seen) -> dict[str, Any]:
    """Return the functions of a class, and its values that have an identity."""
    found = {}
    for name, value in vars(kind).items():
        code = isinstance(value, types.FunctionType) or hasattr(value, "__wrapped__")
        if code or not name.startswith("__"):
            # Without an identity are locks and the like; a function always counts.
            quiet = () if isinstance(value, np.ufunc) else (InvalidInput,)
            with contextlib.suppress(*quiet):
                found[name] = _part(value, seen)
    return found


def _names(code: types.CodeType) -> set[str]:
    """Return the names that code refers to, and those of the functions in it."""
    inside = (each for each in code.co_consts if isinstance(each, types.CodeType))
    return set(code.co_names).union(*map(_names, inside))
