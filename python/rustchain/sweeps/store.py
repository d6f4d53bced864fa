"""A store of cases: a file for each, found again by what was run and measured."""

from __future__ import annotations

import builtins
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, overload
from urllib.parse import quote, unquote

import numpy as np

import rustchain.errors
from rustchain import extras
from rustchain.arguments import shown
from rustchain.errors import InvalidInput, RustchainError
from rustchain.paths import path_of, reason
from rustchain.results import netcdf
from rustchain.results.files import load_result
from rustchain.results.result import Result
from rustchain.sweeps.case_run import Case, Looks, Measure, Outcome
from rustchain.sweeps.identity import digest_of
from rustchain.sweeps.measure import numbers_of

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
        numbers = {name: _plain(array) for name, array in numbers_of(value, ()).items()}
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
        _ = extras.xarray, extras.h5netcdf  # missing, they are told before anything runs
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
        parts = [case.scene, case.run["duration"], case.run["report_step"], sorted(groups), energy]
        return self._folder / f"{digest_of([self._of_all, *parts])}.nc"

    def get(self, path: Path) -> Outcome | None:
        """Return what is stored of a case; None: it is to be run."""
        if not path.exists():
            return None
        try:
            data = netcdf.read(path)
            about = json.loads(data.attrs["case"])
            notes = tuple(about["warnings"])
            if about["error"] is not None:
                return None if self._retry else Outcome(error=_error(about["error"]), notes=notes)
            if not self._measured:
                return Outcome(notes=notes)
            found = {unquote(str(name)): _plain(v.values) for name, v in data.variables.items()}
            return Outcome(found if about["mapping"] else found["value"], notes=notes)
        except (InvalidInput, KeyError):  # damaged, or of something else
            return None

    def put(self, path: Path, case: Case, outcome: Outcome) -> None:
        """Write the outcome of a case."""
        from rustchain.extras import xarray as xr

        about: dict[str, Any] = {
            "scene": case.scene.name,
            "run": {name: shown(value) for name, value in case.run.items()},
            "error": None if outcome.error is None else _written(outcome.error),
            "warnings": outcome.notes,
            "mapping": isinstance(outcome.value, Mapping),
        }
        if outcome.error is not None:
            data = xr.Dataset()
        elif isinstance(outcome.value, Result):
            data = outcome.value.to_xarray()
        else:
            arrays = numbers_of(outcome.value, ())
            data = xr.Dataset({quote(n, _SAFE): _variable(n, a) for n, a in arrays.items()})
        netcdf.write(data.assign_attrs(case=json.dumps(about)), path)


def _variable(name: str, array: Any) -> tuple[tuple[str, ...], Any]:  # noqa: ANN401
    """Return dimensions of its own, and the numbers."""
    return tuple(f"{quote(name, _SAFE)}_{k}" for k in range(array.ndim)), array


def _plain(array: Any) -> Any:  # noqa: ANN401
    """Return a single number as Python's, the rest as an array."""
    found = np.asarray(array)
    return found.item() if found.ndim == 0 else found


def _written(error: Exception) -> dict[str, Any]:
    """Return an error as text, and numbers that it has."""
    numbers = {name: getattr(error, name, None) for name in _OF_ERRORS}
    return {"type": type(error).__name__, "message": str(error)} | numbers


def _error(about: Mapping[str, Any]) -> Exception:
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
        if about[each] is not None:
            setattr(error, each, about[each])
    return error
