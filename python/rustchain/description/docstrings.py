"""Text and units of the fields of descriptions, as their docstrings give them."""

from __future__ import annotations

import dataclasses
import functools
import inspect
import re
from collections.abc import Callable, Iterator
from typing import Any, get_args, get_type_hints

from rustchain.description.drive import ChainDrive
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.scene import Scene
from rustchain.description.solver import Solver

_OF_ARGUMENTS = {  # of runs, and of functions that make drives
    "duration": "s",
    "report_step": "s",
    "speed": "rad/s",
    "pretension": "N",
    "torque": "N m",
}


def descriptions_of(target: Callable[..., Any]) -> dict[str, str]:
    """Return the docstrings' text of each parameter, those of base classes included."""
    return {name: text for names, text in _entries(target) for name in names}


def unit_of(parameter: str) -> str | None:
    """Return the unit of a parameter of a sweep; None where it has none or depends on the part."""
    heads = parameter.split(".")
    if parameter in _OF_ARGUMENTS:
        return _OF_ARGUMENTS[parameter]
    numbers = [head for head in heads if head.isdecimal()]
    *above, last = [head for head in heads if not head.isdecimal()] or [""]
    kinds: set[Any] = {Scene, ChainDrive, Mechanism, Solver}
    for head in above:
        kinds = {each for kind in kinds for each in _classes(get_type_hints(kind).get(head))}
    units = {_units(kind)[last] for kind in kinds if last in _units(kind)}
    unit = units.pop() if len(units) == 1 else None
    if unit and "," in unit:  # of the coordinates
        coordinates = unit.split(", ")
        place = int(numbers[-1]) - 1 if heads[-1].isdecimal() else len(coordinates)
        return coordinates[place] if 0 <= place < len(coordinates) else unit
    return unit


@functools.cache
def _units(kind: Callable[..., Any]) -> dict[str, str | None]:
    """Return the unit of each field of a class; None of no unit, or of more than one."""
    found: dict[str, str | None] = {}
    for names, text in _entries(kind):
        value = re.sub(r"(\[[^]]*\]) over [^[]*\[[^]]*\]", r"\1", text)  # as of rows over time
        units = re.findall(r"\[([^]]*)\]", value)
        if len(units) == len(names) and not (" or " in value and len(units) > 1):
            found |= zip(names, units, strict=True)
        else:
            one = units[0] if len(units) == 1 and "," not in units[0] else None
            found |= dict.fromkeys(names, one)
    return found


def _entries(target: Callable[..., Any]) -> Iterator[tuple[list[str], str]]:
    """Yield names and text of each entry of the parameters, those of base classes first."""
    for each in reversed(getattr(target, "__mro__", (target,))):
        text = inspect.cleandoc(each.__doc__ or "")
        section = re.search(r"(?:Attributes|Parameters)\n-+\n(.*?)(?:\n\n\w+\n-+|\Z)", text, re.S)
        for entry in re.split(r"\n(?=\S)", section.group(1)) if section else []:
            names, *lines = entry.split("\n")
            yield names.split(" : ")[0].split(", "), " ".join(line.strip() for line in lines)


def _classes(hint: Any) -> Iterator[type]:  # noqa: ANN401
    """Yield the descriptions that a value of this type may hold."""
    if isinstance(hint, type) and dataclasses.is_dataclass(hint):
        yield hint
    for inside in get_args(hint):
        yield from _classes(inside)
