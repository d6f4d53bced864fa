"""A store of cases: a file for each, found again by what was run and measured."""

from __future__ import annotations

import ast
import builtins
import errno
import json
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload
from urllib.parse import quote, unquote

import numpy as np

import rustchain.errors
from rustchain import extras
from rustchain.analysis.summary import Summary
from rustchain.arguments import plain, shown
from rustchain.caller import warn_caller
from rustchain.description.base import Description
from rustchain.errors import CaseWarning, InvalidInput, RustchainError
from rustchain.names import known_keywords
from rustchain.paths import path_of, reason, shown_path
from rustchain.results import netcdf
from rustchain.results.files import load_result
from rustchain.results.result import Result
from rustchain.results.values import equal
from rustchain.sweeps.axes import RUN_FIELDS
from rustchain.sweeps.case_run import Case, Looks, Measure, Outcome
from rustchain.sweeps.cases import Axes, Parameters, cases_of
from rustchain.sweeps.identity import digest_of
from rustchain.sweeps.measure import numbers_of
from rustchain.sweeps.result import SweepResult
from rustchain.typing import FilePath

if TYPE_CHECKING:
    import xarray as xr

FORMAT = 1
"""Number of the format of a case's file; it is part of what a case is found by."""

_SAFE = " ()[]<>=+-,.:"  # in the name of a netCDF variable, beside letters and digits
_OF_ERRORS = ("time", "step_size", "contact")


@dataclass(frozen=True)
class Measured:
    """A measure whose values are as a store gives them back: numbers, arrays, dicts of them."""

    measure: Measure

    def __call__(self, result: Result) -> Any:  # noqa: ANN401
        """Return the measured value."""
        value = self.measure(result)
        numbers = numbers_of(value, ())
        numbers.update((name, _plain(array)) for name, array in numbers.items())
        return numbers if isinstance(value, Mapping) else numbers["value"]


class StoredResults(Sequence[Result | None]):
    """The results of a sweep in its store, read when they are accessed; None where there is none.

    Attributes
    ----------
    paths : list of Path or None
        The file of each case, which `load_result` reads, too.
    """

    def __init__(self, paths: list[Path | None]) -> None:
        self.paths = paths

    def __eq__(self, other: object) -> bool:
        """Return whether the results are equal, which are read unless the files are the same."""
        if not isinstance(other, StoredResults):
            return NotImplemented
        return self.paths == other.paths or equal(list(self), list(other))

    __hash__ = None  # type: ignore[assignment]

    def __len__(self) -> int:
        """Return how many cases there are."""
        return len(self.paths)

    @overload
    def __getitem__(self, place: int) -> Result | None: ...
    @overload
    def __getitem__(self, place: slice) -> list[Result | None]: ...
    def __getitem__(self, place: int | slice) -> Result | list[Result | None] | None:
        """Read one result, or several."""
        if isinstance(place, slice):
            return [self[k] for k in range(len(self))[place]]
        path = self.paths[place]
        return None if path is None else load_result(path)


class Store:
    """A folder with a netCDF file for each case, named by a hash of what was run and measured.

    Files are written beside their place and renamed, so that several sweeps may use one folder at
    once. A file that is damaged is as good as none.

    Parameters
    ----------
    folder : Path
        The folder; it is made.
    measure : function of a Result, optional
        What is kept of each case; None: the result.
    looks : Looks
        What may end a run.
    retry : bool
        Whether failed cases are run again.
    """

    def __init__(self, folder: object, measure: Measure | None, looks: Looks, retry: bool) -> None:
        _ = extras.xarray, extras.h5py  # missing, they are told before anything runs
        self._folder = path_of(folder, "store")
        self._measured = measure is not None
        self._retry = retry
        self._of_all = digest_of(
            {
                "format": FORMAT,
                "version": rustchain.__version__,
                "measure": measure,
                "stop": looks.stop,
                "callback": looks.callback,
            }
        )
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            msg = f"store: the folder {self._folder} cannot be made ({reason(error)}): name another"
            raise type(error)(msg) from error

    def path(self, case: Case) -> Path:
        """Return the file of a case."""
        groups, energy = case.groups()
        given = (case.run["duration"], case.run["report_step"])
        times = [float(value) if isinstance(value, int) else value for value in given]
        parts = [case.scene, *times, sorted(groups), energy]
        return self._folder / f"{digest_of([self._of_all, *parts])}.nc"

    def get(self, path: Path) -> Outcome | None:
        """Return what is stored of a case; None: it is to be run."""
        if not path.exists():
            return None
        try:
            data = netcdf.read(path)
            about = json.loads(data.attrs["case"])
            if about["error"] is not None and self._retry:
                return None
            return _outcome(data, about, self._measured)
        except (InvalidInput, KeyError):  # damaged, or of something else
            return None

    def put(self, path: Path, case: Case, outcome: Outcome, parameters: Mapping[str, Any]) -> None:
        """Write the outcome of a case with its parameters."""
        from rustchain.extras import xarray as xr

        about: dict[str, Any] = {
            "scene": case.scene.name,
            "run": {name: shown(value) for name, value in case.run.items()},
            "parameters": {name: _packed(value) for name, value in parameters.items()},
            "error": None if outcome.error is None else _written(outcome.error),
            "warnings": outcome.notes,
            "mapping": isinstance(outcome.value, Mapping),
            "summary": isinstance(outcome.value, Summary),
        }
        if outcome.error is not None:
            data = xr.Dataset()
        elif isinstance(outcome.value, Result):
            data = outcome.value.to_xarray()
        else:
            arrays = numbers_of(outcome.value, ())
            data = xr.Dataset({_quoted(n): _variable(n, a) for n, a in arrays.items()})
        netcdf.write(data.assign_attrs(case=json.dumps(about)), path)


def _axes_of(cases: list[Parameters]) -> Axes | None:
    """Return the axes whose combinations the ordered cases are; None: they are listed."""
    axes: Axes = {n: tuple(dict.fromkeys(case.get(n) for case in cases)) for n in cases[0]}
    if len(axes) < 2 or math.prod(map(len, axes.values())) != len(cases):
        return None
    return axes if cases_of(axes)[1] == cases else None


@known_keywords
def load_sweep(store: FilePath) -> SweepResult:
    """Return the cases in the folder that `sweep` had as its store, of all its sweeps.

    Nothing is run. Cases are ordered by their parameters. All combinations of two parameters or
    more have these as their axes, others are listed; `to_pandas` makes a table of both. Without a
    measure, results are read when they are accessed. An argument of the run, such as "duration", in
    which cases differ is a parameter of each case, unless a measured quantity has its name.
    A case that several sweeps share has the parameters of the one that stored it: those of others
    are missing in it, NaN in tables. Cases of one sweep with the same scene and run are one case,
    with the parameters of the last one that ran. No column has the drive or the law: give the cases
    of each drive and law their own folder.

    Parameters
    ----------
    store : str or Path
        The folder.

    Returns
    -------
    SweepResult
        Parameters that are neither numbers, text nor descriptions are their text.

    Raises
    ------
    OSError
        There is no such folder.
    InvalidInput
        It has no case, or both measured values and results.

    Warns
    -----
    CaseWarning
        Files are damaged, or are no cases: how many, and the first. Or cases have the same
        parameters: of sweeps of different drives, laws or measures.

    Examples
    --------
    >>> _ = rc.sweep(
    ...     rc.paper_drive(),
    ...     {"pretension": [0.0, 25.0]},
    ...     lambda result: result.time.size,
    ...     duration=1e-3,
    ...     store="runs",
    ...     progress=False,
    ... )
    >>> len(rc.load_sweep("runs").cases)
    2
    """
    folder = path_of(store, "store")
    if not folder.is_dir():
        number = errno.ENOTDIR if folder.exists() else errno.ENOENT
        msg = f"store = {shown_path(folder)}: is no folder; give the one that sweep had as store"
        raise OSError(number, msg)
    found: list[tuple[Parameters, Path, bool, Outcome]] = []
    runs, others = [], []
    for path in sorted(folder.glob("*.nc")):
        try:
            data = netcdf.read(path)
            about = json.loads(data.attrs["case"])
            measured = "scene" not in data.attrs
            parameters = {n: _unpacked(v) for n, v in about["parameters"].items()}
            outcome = _outcome(data, about, measured)
            runs.append({name: _value_of(about["run"][name]) for name in RUN_FIELDS})
            found.append((parameters, path, measured and about["error"] is None, outcome))
        except (InvalidInput, LookupError, TypeError, ValueError):
            others.append(path)
    if others:
        which = f"{len(others)} files are damaged or no cases, first {shown_path(others[0])}"
        warn_caller(f"store = {shown_path(folder)}: {which}; they are left out", CaseWarning)
    if not found:
        msg = f"store = {shown_path(folder)}: has no case; give a folder that sweep had as store"
        raise InvalidInput(msg)
    results = [case for case in found if case[3].error is None and not case[2]]
    if results and any(case[2] for case in found):
        msg = (
            f"store = {shown_path(folder)}: has measured values and results; expected one kind: "
            "give each sweep its own folder"
        )
        raise InvalidInput(msg)
    _warn_of_same_parameters(folder, found, runs)
    _add_run_arguments(found, runs)
    found.sort(key=lambda case: _order(case[0]))
    return _swept(found, not results)


def _warn_of_same_parameters(
    folder: Path, found: list[tuple[Parameters, Path, bool, Outcome]], runs: list[Parameters]
) -> None:
    """Warn of cases that neither parameters nor arguments of the run tell apart."""
    alike = Counter(
        repr([sorted(parameters.items()), run])  # values may be lists
        for (parameters, *_), run in zip(found, runs, strict=True)
    )
    if len(alike) < len(found):
        warn_caller(
            f"store = {shown_path(folder)}: {len(found) - len(alike)} of {len(found)} cases have "
            f"the parameters of another: they are of {max(alike.values())} different drives, laws, "
            "stop conditions, measures or versions; give each of these its own folder",
            CaseWarning,
        )


def _add_run_arguments(
    found: list[tuple[Parameters, Path, bool, Outcome]], runs: list[Parameters]
) -> None:
    """Make each argument of the run in which the cases differ a parameter of all of them."""
    values = [outcome.value for *_, outcome in found]
    measured = {name for value in values if isinstance(value, Mapping) for name in value}
    for name in RUN_FIELDS:
        if len({run[name] for run in runs}) > 1 and name not in measured:
            for (parameters, *_), run in zip(found, runs, strict=True):
                parameters.setdefault(name, run[name])


def _value_of(text: str) -> Any:  # noqa: ANN401
    """Return an argument of a run that is stored as Python writes it, or its text."""
    try:
        value = plain(ast.literal_eval(text))
        hash(value)
    except (ValueError, SyntaxError, TypeError, RecursionError, MemoryError):  # cut, or an object
        return text
    return value


def _swept(found: list[tuple[Parameters, Path, bool, Outcome]], measured: bool) -> SweepResult:
    """Return the stored cases as the result of a sweep."""
    paths = [path if outcome.error is None else None for _, path, _, outcome in found]
    values: Any = [outcome.value for *_, outcome in found] if measured else StoredResults(paths)
    cases = [case[0] for case in found]
    swept = SweepResult(cases, _axes_of(cases), values, _measured=measured)
    for number, (*_, outcome) in enumerate(found):
        swept._end(number, outcome.notes, outcome.error)
    return swept


def _outcome(data: xr.Dataset, about: Mapping[str, Any], measured: bool) -> Outcome:
    """Return the stored outcome of a case; a result stays in its file."""
    notes = tuple(about["warnings"])
    if about["error"] is not None:
        return Outcome(error=_error(about["error"]), notes=notes)
    if not measured:
        return Outcome(notes=notes)
    found = {unquote(str(name)): _plain(v.values) for name, v in data.variables.items()}
    if about.get("summary"):
        found = Summary(found)
    return Outcome(found if about["mapping"] else found["value"], notes=notes)


def _packed(value: object) -> Any:  # noqa: ANN401
    """Return a parameter as JSON has it: numbers and text as they are."""
    value = plain(value)
    if isinstance(value, Description):
        return {"description": value.to_json(placeholders=True)}
    if isinstance(value, tuple):
        return [_packed(each) for each in value]
    return value if isinstance(value, bool | int | float | str | None) else {"text": shown(value)}


def _unpacked(value: Any) -> Any:  # noqa: ANN401
    """Return the parameter that `_packed` made JSON of."""
    if isinstance(value, list):
        return tuple(_unpacked(each) for each in value)
    if isinstance(value, dict):
        given = value.get("description")
        return value["text"] if given is None else Description.from_json(given)
    return value


def _order(parameters: Parameters) -> list[tuple[str, bool, float, str]]:
    """Return what cases are sorted by: the name of each parameter, then numbers, then text."""
    return [
        (name, not number, float(value) if number else 0.0, "" if number else repr(value))
        for name, value in parameters.items()
        for number in [isinstance(value, int | float)]
    ]


def _quoted(name: str) -> str:
    """Return a name as netCDF has it; "." alone is the group of all variables."""
    return "%2E" if name == "." else quote(name, _SAFE)


def _variable(name: str, array: Any) -> tuple[tuple[str, ...], Any]:  # noqa: ANN401
    """Return dimensions of its own, and the numbers."""
    return tuple(f"{_quoted(name)}_{k}" for k in range(array.ndim)), array


def _plain(array: Any) -> Any:  # noqa: ANN401
    """Return a single number as Python's, the rest as an array."""
    found = np.asarray(array)
    return found.item() if found.ndim == 0 else found


def _written(error: Exception) -> dict[str, Any]:
    """Return an error as text, and numbers that it has."""
    own = {name: getattr(error, name, None) for name in _OF_ERRORS}
    numbers = {n: value for n, value in own.items() if isinstance(value, float | str | None)}
    notes = [str(note) for note in getattr(error, "__notes__", ())]
    # The text of a KeyError is that of its argument in quotes.
    message = error.args[0] if isinstance(error, KeyError) and len(error.args) == 1 else error
    return {"type": type(error).__name__, "message": str(message), "notes": notes} | numbers


def _error(about: Mapping[str, Any]) -> Exception:
    """Return the error that was written, with its notes."""
    error = _error_of(about)
    error.__notes__ = about.get("notes", [])
    return error


def _error_of(about: Mapping[str, Any]) -> Exception:
    """Return the error that was written: of its own class where that is one of Python or ours."""
    name, message = about["type"], about["message"]
    kind = getattr(rustchain.errors, name, None) or getattr(builtins, name, None)
    if not (isinstance(kind, type) and issubclass(kind, Exception)):
        return RustchainError(f"{name}: {message}")
    try:
        error = kind(message)
    except TypeError:  # some take more than a message
        return RustchainError(f"{name}: {message}")
    for each in _OF_ERRORS:
        if about.get(each) is not None:
            setattr(error, each, about[each])
    return error
