"""Panics of the compiled module, which are defects of it, as `SimulationError`."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable
from types import BuiltinFunctionType, GetSetDescriptorType, MethodDescriptorType, ModuleType
from typing import Any, TypeVar

from rustchain import _rustchain

_Result = TypeVar("_Result")

# What PyO3 raises, as RuntimeError, when a thread uses an object that another one changes.
_BORROWED = ("Already borrowed", "Already mutably borrowed")
IN_USE = (
    "the simulation is in use by another thread; make a Simulation of the scene for each thread"
)

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
    """Return `function`, whose panics become a `SimulationError` with the time of its object.

    So does the use of a simulation from two threads at once, without a time.
    """

    @functools.wraps(function)
    def call(*args: Any, **keywords: Any) -> _Result:  # noqa: ANN401
        try:
            return function(*args, **keywords)
        except BaseException as error:
            if type(error) is RuntimeError and str(error) in _BORROWED and not _called_back():
                kind = type(_rustchain.panicked("", None))  # SimulationError, of a module above
                raise kind(IN_USE) from None
            if type(error).__name__ != _PANIC:
                raise
            time = getattr(args[0], "time", None) if args else None
            raise _rustchain.panicked(str(error), time) from None

    return call


def _called_back() -> bool:
    """Return whether a function of the scene, which the compiled module called, makes this call."""
    here = sys._getframe(1)
    frame = here.f_back
    while frame is not None and frame.f_code is not here.f_code:
        frame = frame.f_back
    return frame is not None
