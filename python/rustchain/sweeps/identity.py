"""A hash of scenes, runs and Python functions that is the same in every process."""

from __future__ import annotations

import functools
import hashlib
import json
import pickle
import types
from collections.abc import Mapping
from typing import Any

import numpy as np

from rustchain.arguments import shown
from rustchain.description.base import fields_of
from rustchain.errors import InvalidInput


def digest_of(value: object) -> str:
    """Return a hash of a value that is the same in every process, 32 hexadecimal digits.

    The hash of a Python function covers code, defaults and the values of a closure. It also covers
    numbers, text and functions of the same module that the code refers to, but not other modules.

    Raises
    ------
    InvalidInput
        The value holds something without an identity, such as an open file.
    """
    text = json.dumps(_part(value, ()), sort_keys=True, ensure_ascii=True)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def _part(value: Any, above: tuple[object, ...]) -> Any:  # noqa: ANN401
    """Return a value as JSON has it; `above`: the functions that refer to it."""
    if value is None or isinstance(value, bool | int | float | str):
        return value if type(value) in (type(None), bool, int, float, str) else repr(value)
    if isinstance(value, list | tuple):
        return [type(value).__name__, *(_part(each, above) for each in value)]
    if isinstance(value, set | frozenset):
        return ["set", *sorted(json.dumps(_part(each, above), sort_keys=True) for each in value)]
    if isinstance(value, Mapping):
        return ["mapping", *([_part(k, above), _part(v, above)] for k, v in value.items())]
    if isinstance(value, bytes | complex | slice | type(...)):
        return [type(value).__name__, repr(value)]
    if isinstance(value, np.ndarray) and value.dtype.kind in "biufcSU":
        content = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
        return ["array", str(value.dtype), list(value.shape), content]
    if (fields := fields_of(value)) is not None:
        return [type(value).__name__, _part(fields, above)]
    return _code(value, above)


def _code(value: Any, above: tuple[object, ...]) -> Any:  # noqa: ANN401
    """Return the identity of a function, a class, a module, or any object as pickle has it."""
    if any(value is each for each in above):
        return ["itself", getattr(value, "__qualname__", "")]
    above = (*above, value)
    if isinstance(value, functools.partial):
        return ["partial", *(_part(v, above) for v in (value.func, value.args, value.keywords))]
    if isinstance(value, types.MethodType):
        return ["method", _part(value.__func__, above), _part(value.__self__, above)]
    if isinstance(value, types.FunctionType):
        return ["function", *_function(value, above)]
    if isinstance(value, types.CodeType):
        consts = [_part(each, above) for each in value.co_consts]
        return ["code", value.co_name, value.co_code.hex(), list(value.co_names), consts]
    if isinstance(value, types.ModuleType):
        return ["module", value.__name__]
    if isinstance(value, type | types.BuiltinFunctionType | np.ufunc):
        return [
            "name",
            getattr(value, "__module__", ""),
            getattr(value, "__qualname__", str(value)),
        ]
    try:
        content = hashlib.sha256(pickle.dumps(value, protocol=4)).hexdigest()
    except Exception as error:  # whatever a class of the user's does
        msg = (
            f"store: {shown(value)} has no identity by which a stored case could be found "
            f"({error}); expected functions of numbers, text and arrays"
        )
        raise InvalidInput(msg) from error
    call = vars(type(value)).get("__call__")
    code = _part(call, above) if isinstance(call, types.FunctionType) else None
    return ["object", type(value).__module__, type(value).__qualname__, content, code]


def _function(function: types.FunctionType, above: tuple[object, ...]) -> list[Any]:
    """Return name, code, defaults, closure, and what the code refers to."""
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    known = {
        name: function.__globals__[name]
        for name in sorted(_names(function.__code__))
        if name in function.__globals__
    }
    of_module = {
        name: value
        for name, value in known.items()
        if not isinstance(value, types.FunctionType | type)
        or value.__module__ == function.__module__
    }
    module = "" if function.__module__ == "__main__" else function.__module__
    parts = (function.__code__, function.__defaults__, function.__kwdefaults__, cells, of_module)
    return [module, function.__qualname__, *(_part(each, above) for each in parts)]


def _names(code: types.CodeType) -> set[str]:
    """Return the names that code refers to, and those of the functions in it."""
    inside = (each for each in code.co_consts if isinstance(each, types.CodeType))
    return set(code.co_names).union(*map(_names, inside))
