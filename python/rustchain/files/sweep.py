"""Sweeps in files: a drive, its axes or cases, what is measured, and how each case is run."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from math import nan
from pathlib import Path
from typing import Any, TypeAlias, get_type_hints

from rustchain import _rustchain
from rustchain.analysis.jumps import jumps_within
from rustchain.arguments import shown
from rustchain.description.scene import Scene
from rustchain.description.sprocket import PrescribedSpeed
from rustchain.errors import InvalidInput, NotRecorded
from rustchain.files.models import Field
from rustchain.files.reader import ANY, Reader
from rustchain.files.scene import SceneFile
from rustchain.files.source import Key, Source, text_of
from rustchain.names import suggest
from rustchain.results.result import Result
from rustchain.sweeps.cases import cases_of, check_burn_in
from rustchain.sweeps.samples import samples

Axes: TypeAlias = dict[str | tuple[str, ...], Any]

_FIELDS = {
    "drive": Field(str, True),
    "axes": Field(dict, False),
    "cases": Field(list, False),
    "samples": Field(dict, False),
    "measure": Field(object, False),
    "burn_in": Field(float, False),
    "run": Field(dict, False),
}
_KINDS: dict[Any, tuple[Any, str]] = {
    str: (str, "a text"),
    dict: (Mapping, "a table"),
    list: (list, "a list of tables"),
    float: (float | int, "a number"),
}
_OF_SAMPLES = {
    name: Field(hint, name in ("distributions", "count"))
    for name, hint in get_type_hints(samples).items()
    if name != "return"
}


_DEPTHS = {"axes": 2, "cases": 3, "samples": 3}
"""Length of the keys of parameters: axes.speed, cases.1.speed, samples.distributions.speed."""
_FIGURES = (
    "tension_upper", "tension_lower", "tension_upper_std", "tension_lower_std",
    "hinge_contact_share", "hinge_force_p99", "hinge_force_largest", "tooth_force_p99",
    "tooth_force_largest", "joint_force_p99", "joint_force_largest", "contact_force_p99",
    "contact_force_largest", "tooth_jumps", "engagement_force_mean", "engagement_force_p95",
    "transmission_error_2", "ripple_2", "loss", "efficiency",
)  # fmt: skip
"""Figures of `Result.summary` with two sprockets."""
_OF_MORE = re.compile(r"tension_\w+-\w+|transmission_error_([2-9]|[1-9]\d+)|ripple_[1-9]\d*")
"""Figures of further strands and sprockets, and of a first sprocket without a prescribed speed."""
_WITHOUT_JUMPS = re.compile(r"efficiency|transmission_error_([2-9]|[1-9]\d+)")
"""Figures that a chain that jumps teeth does not have."""
_OF_TURNING = re.compile(r"efficiency|ripple_[1-9]\d*")
"""Figures that a drive at rest, or one that turns back and forth, does not have."""


@dataclass(frozen=True)
class Figures:
    """A measure: figures of `Result.summary`, all or those that are named, after a burn-in [s]."""

    names: tuple[str, ...] = ()
    burn_in: float = 0.0

    def __call__(self, result: Result) -> dict[str, float]:
        """Return the figures of a run."""
        found = result.summary(start=self.burn_in)
        jumps = jumps_within(result, self.burn_in)
        jumped = jumps is not None and len(jumps[0]) > 0
        recorded = {"sprockets", "energy"} <= set(result.groups)
        for name in self.names:
            absent = jumped and _WITHOUT_JUMPS.fullmatch(name)
            if absent or (recorded and _OF_TURNING.fullmatch(name)):
                found.setdefault(name, nan)  # the others are kept
            if name not in found:
                msg = f"measure: {shown(name)} is no figure of this run; {suggest(name, found)}"
                raise NotRecorded(msg)
        return {name: found[name] for name in self.names or found}


@dataclass(frozen=True)
class FunctionOfFile:
    """A measure: a function in a Python file, whose text goes with it to other machines.

    Attributes
    ----------
    name : str
        Name of the function.
    file : str
        The file, for tracebacks.
    text : str
        What is in it.
    burn_in : float
        Time that is not measured [s].
    """

    name: str
    file: str
    text: str
    burn_in: float = 0.0

    def _identity_in_store(self) -> tuple[object, ...]:
        """Return what a store finds a case by: the file may lie in any folder."""
        return self.name, self.text, self.burn_in

    def __call__(self, result: Result) -> Any:  # noqa: ANN401
        """Return what the function returns of a run."""
        part = result.between(start=self.burn_in) if self.burn_in > 0.0 else result
        return _names_in(self.text, self.file)[self.name](part)


@functools.cache
def _names_in(text: str, file: str) -> dict[str, Any]:
    """Return what a Python file defines."""
    names: dict[str, Any] = {"__name__": Path(file).stem, "__file__": file}
    exec(compile(text, file, "exec"), names)
    return names


def measure_of(given: object, burn_in: float, folder: Path) -> Callable[[Result], Any]:
    """Return the measure that a text or a list names: figures, or a function ``file.py:function``.

    Raises
    ------
    InvalidInput
        It names no figure or function, or its file raises when it is read.
    """
    if given is None:
        return Figures((), burn_in)
    if isinstance(given, str) and ".py:" in given:
        file, _, name = given.rpartition(":")
        try:
            text = text_of(folder / file)
            names = _names_in(text, str(folder / file))
        except Exception as error:  # a file of the user's may raise anything
            msg = f"measure: {file}: cannot be read ({type(error).__name__}: {error}); mend it"
            raise InvalidInput(msg) from error
        functions = [each for each, value in names.items() if callable(value)]
        if name not in functions:
            msg = f"measure: {file}: has no function {shown(name)}; {suggest(name, functions)}"
            raise InvalidInput(msg)
        return FunctionOfFile(name, str(folder / file), text, burn_in)
    listed = [given] if isinstance(given, str) else given
    if not isinstance(listed, Sequence) or not all(isinstance(each, str) for each in listed):
        msg = (
            f"measure = {shown(given)}: expected names of figures of the summary, such as "
            '["efficiency"], or a function in a file, "measures.py:peak"'
        )
        raise InvalidInput(msg)
    for each in listed:
        if each not in _FIGURES and not _OF_MORE.fullmatch(each):
            msg = f"measure: {shown(each)} is no figure of a summary; {suggest(each, _FIGURES)}"
            raise InvalidInput(msg)
    return Figures(tuple(listed), burn_in)


def check_figures(measure: object, scene: Scene, varied: Collection[str]) -> None:
    """Refuse figures of strands and sprockets that a scene lacks.

    Nothing is refused where an axis changes what a drive consists of: its sprockets or ends.
    """
    names = getattr(measure, "names", ())
    if scene.kind != "drive" or any(n in ("sprockets", "ends", "system") for n in varied):
        return
    strands = [f"tension_{name}" for name in _rustchain.strand_names(scene.drive)]
    numbers = range(2, len(scene.drive.sprockets) + 1)
    own = [f"{kind}_{k}" for kind in ("transmission_error", "ripple") for k in numbers]
    own += [*strands, *(f"{name}_std" for name in strands)]
    moved = [not isinstance(each.motion, PrescribedSpeed) for each in scene.drive.sprockets[:1]]
    own += ["ripple_1"] if "sprockets.1.motion" in varied or any(moved) else []
    for name in names:
        if name not in own and (name.startswith("tension_") or _OF_MORE.fullmatch(name)):
            msg = f"measure: {shown(name)} is no figure of this drive; {suggest(name, own)}"
            raise InvalidInput(msg)


@dataclass(frozen=True)
class SweepFile:
    """The content of a sweep file.

    Attributes
    ----------
    scene : SceneFile
        What is simulated, and how each case is run.
    axes : mapping or list of mappings
        As `sweep` takes them.
    measure : function of a Result
        What is kept of each case.
    """

    scene: SceneFile
    axes: Axes | list[dict[str, Any]]
    measure: Callable[[Result], Any]
    _source: Source = field(repr=False, compare=False)

    @classmethod
    def read(cls, path: Path, drive: Callable[[str], SceneFile]) -> SweepFile:
        """Read a file; `drive` reads the drive that it names.

        Raises
        ------
        InvalidInput
            With a line for each thing that is wrong: file, line, column, key, value, and what is
            allowed.
        """
        made = _SweepReader(Source.of(path, "sweep file")).sweep(drive)
        try:
            cases_of(made.axes)
        except InvalidInput as error:
            raise made.refusal(error) from error
        return made

    def check(self, scene: Scene, duration: object) -> None:
        """Refuse, before anything runs, what no case of a scene can be measured by.

        Raises
        ------
        InvalidInput
            The burn-in leaves nothing of a case, or the drive has no such figure.
        """
        cases = cases_of(self.axes)[1]
        check_burn_in(getattr(self.measure, "burn_in", 0.0), duration, cases)
        check_figures(self.measure, scene, {name for case in cases for name in case})

    def refusal(self, error: InvalidInput) -> InvalidInput:
        """Return an error of the sweep with the place of the parameter that it names."""
        text = str(error)
        for name in ("burn_in", "measure"):
            if text.startswith(name):
                told = text.removeprefix("measure: ").removeprefix("burn_in = ")
                return self._source.refusal_at((name,), told)
        keys = self._keys_of_parameters()
        subject = text.partition("; ")[0]  # behind it are names that may be meant
        named = [name for name in keys if repr(name) in subject]
        if named:
            first = min(named, key=lambda name: subject.index(repr(name)))
            return self._source.refusal_at(keys[first], text)
        last = text.partition(" ")[0].rstrip(":").rpartition(".")[2]  # of "Tensioner.stops = ..."
        varied = [name for name in keys if name.rpartition(".")[2] == last]
        if len(varied) == 1:
            return self._source.refusal_at(keys[varied[0]], text)
        if ("run", last) in self._source.places and not varied:
            return self._source.refusal_at(("run", last), text)
        return self._source.refusal_at(next(iter(keys.values()), ("axes",))[:1], text)

    def _keys_of_parameters(self) -> dict[str, Key]:
        """Return the first place of each parameter that the file varies."""
        keys: dict[str, Key] = {}
        for key in self._source.places:
            if len(key) == _DEPTHS.get(str(key[0])):
                for name in str(key[-1]).split(","):
                    keys.setdefault(name.strip(), key)
        return keys


class _SweepReader(Reader):
    """Makes what a sweep file describes."""

    def sweep(self, drive: Callable[[str], SceneFile]) -> SweepFile:
        """Return the sweep."""
        found = {
            name: value
            for name, value in self.entries(self.source.content, _FIELDS, ())
            if self._is_of_kind(name, value)
        }
        axes, run = self._axes(found), self.section("run", found.get("run", {}))
        run.pop("out", None)
        name, folder = found.get("drive", "paper"), self.source.path.parent
        if name != "paper" and not (folder / name).is_file():
            told = f"{shown(name)}: is no file; expected paper, or a path relative to this file"
            self.refuse(("drive",), told)
        self.check()
        file = drive(name if name == "paper" else str(folder / name)).changed({}, {}, run)
        try:
            measure = measure_of(found.get("measure"), found.get("burn_in", 0.0), folder)
        except InvalidInput as error:
            told = str(error).removeprefix("measure: ")
            raise self.source.refusal_at(("measure",), told) from error
        return SweepFile(file, axes, measure, self.source)

    def _is_of_kind(self, name: str, value: object) -> bool:
        """Return whether a value is of the kind of its key; refuse it where it is not."""
        kind, words = _KINDS.get(_FIELDS[name].hint, (object, ""))
        if isinstance(value, kind) and not isinstance(value, bool):
            return True
        self.refuse((name,), f"{shown(value)}: must be {words}")
        return False

    def _axes(self, found: Mapping[str, Any]) -> Axes | list[dict[str, Any]]:
        """Return the axes with the samples, or the cases."""
        if "cases" in found:
            if "axes" in found or "samples" in found:
                self.refuse(("cases",), "stand in place of axes and samples; take one of them")
            return [
                {n: self.value(v, ANY, ("cases", k, n)) for n, v in case.items()}
                for k, case in enumerate(found["cases"])
                if isinstance(case, Mapping)
                or self.refuse(("cases", k), f"{shown(case)}: must be a table") is None
            ]
        axes: Axes = {}
        for name, values in found.get("axes", {}).items():
            parts = tuple(part.strip() for part in name.split(","))
            key = ("axes", name)
            if not isinstance(values, list):
                self.refuse(key, f"{shown(values)}: must be a list of values, one for each case")
            axes[parts if len(parts) > 1 else parts[0]] = self.value(values, ANY, key)
        if "samples" in found:
            axes |= self._samples(found["samples"])
        if not axes:
            self.refuse((), "has no axes, samples or cases; expected one of them, such as [axes]")
        return axes

    def _samples(self, table: Mapping[str, Any]) -> Axes:
        """Return samples of the distributions in a table."""
        given = dict(self.entries(table, _OF_SAMPLES, ("samples",)))
        laws = given.get("distributions", {})
        if not isinstance(laws, Mapping):
            self.refuse(("samples", "distributions"), f"{shown(laws)}: must be a table")
            laws = {}
        key = ("samples", "distributions")
        made = {name: self._distribution(law, (*key, name)) for name, law in laws.items()}
        self.check()
        try:
            drawn = samples(**(given | {"distributions": made}))
            return {names: list(rows) for names, rows in drawn.items()}
        except InvalidInput as error:
            text = str(error).removeprefix("samples: ")
            raise self.source.refusal_at(("samples",), text) from error

    def _distribution(self, law: object, key: Key) -> Any:  # noqa: ANN401
        """Return a distribution of `scipy.stats` by its name and arguments."""
        from rustchain.extras import stats

        kinds = (stats.rv_continuous, stats.rv_discrete)
        known = [name for name in dir(stats) if isinstance(getattr(stats, name), kinds)]
        main = ["norm", "uniform", "triang", "truncnorm", "randint", "..."]
        if not isinstance(law, Mapping) or len(law) != 1:
            told = "must be a distribution of scipy.stats, such as { norm = [mean, deviation] }"
            return self.refuse(key, f"{shown(law)}: {told}")
        ((name, arguments),) = law.items()
        if name not in known:
            return self.refuse((*key, name), f"is no distribution; {suggest(name, known, main)}")
        make = getattr(stats, name)
        shapes = make.shapes.split(", ") if make.shapes else []
        names = [*shapes, "loc", *["scale"][: isinstance(make, stats.rv_continuous)]]
        given = arguments
        if isinstance(arguments, Sequence) and len(arguments) <= len(names):
            given = dict(zip(names, arguments, strict=False))
        if (
            not isinstance(given, Mapping)
            or not set(shapes) <= given.keys() <= set(names)
            or any(type(number) not in (int, float) for number in given.values())
        ):
            told = f"expected a list or table of numbers: {', '.join(names)}"
            return self.refuse((*key, name), f"{shown(arguments)}: {told}")
        return make(**given)
