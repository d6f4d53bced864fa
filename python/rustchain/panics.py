"""Panics of the compiled module, which are defects of it, as `SimulationError`."""

from __future__ import annotations

import functools
from collections.abc import Callable
from types import BuiltinFunctionType, GetSetDescriptorType, MethodDescriptorType, ModuleType
from typing import Any, TypeVar

from rustchain import _rustchain

_Result = TypeVar("_Result")

# PyO3 makes this type, derived from BaseException, and exports it under no name.
_PANIC = "PanicException"


def guard(module: ModuleType) -> None:
    """Let all functions of `module`, and all methods and properties of its classes, raise no panic.

    Constructors contain their panics themselves: no function can stand in for one.
    """
    for name, value in list(vars(module).items()):
        if isinstance(value, BuiltinFunctionType):
            setattr(module, name, guarded(value))
        elif isinstance(value, type) and not issubclass(value, BaseException):
            for attribute, member in list(vars(value).items()):
                if isinstance(member, GetSetDescriptorType):
                    setattr(value, attribute, property(guarded(member.__get__)))
                elif isinstance(member, MethodDescriptorType):
                    setattr(value, attribute, guarded(member))


def guarded(function: Callable[..., _Result]) -> Callable[..., _Result]:
    """Return `function`, whose panics become a `SimulationError` with the time of its object."""

    @functools.wraps(function)
    def call(*args: Any, **keywords: Any) -> _Result:  # noqa: ANN401
        try:
            return function(*args, **keywords)
        except BaseException as error:
            if type(error).__name__ != _PANIC:
                raise
            time = getattr(args[0], "time", None) if args else None
            raise _rustchain.panicked(str(error), time) from None

    return call
