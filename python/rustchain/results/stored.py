"""Streamed results as they are read: arrays come from the file when they are accessed."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import Any, NamedTuple, TypeVar, cast
from weakref import WeakValueDictionary

import numpy as np
import numpy.typing as npt

from rustchain import extras
from rustchain.errors import InvalidInput
from rustchain.paths import check_there, shown_path
from rustchain.results import netcdf
from rustchain.results.channels import VARIABLES
from rustchain.results.superblock import SIGNATURE, Unmarked, is_marked
from rustchain.results.tables import JUMPS, array_of
from rustchain.results.values import read_only

HEADER, END = "run/header", "run/end"
"""Names of the texts of bytes, in JSON, that say what runs and how the run ended."""

IDENTITY = "run_id"
"""Name, in the header, of a random number by which a file that was replaced is found out."""

_Made = TypeVar("_Made")
_PAUSE = 0.05  # [s] between attempts; a piece is written in less


class Header(NamedTuple):
    """Contents of a streamed file beside its rows."""

    attributes: dict[str, Any]
    arrays: StoredArrays
    constants: dict[str, npt.NDArray[Any]]
    end: dict[str, Any] | None


def is_streamed(path: object) -> bool:
    """Return whether the file at `path` was streamed."""
    with check_there(path, netcdf.WRITER).open("rb") as file:
        return file.read(len(SIGNATURE)) == SIGNATURE


def checksum_of(attributes: Mapping[str, Any]) -> str:
    """Return the checksum of the header of a file."""
    own = {name: attributes[name] for name in sorted(attributes) if name != "checksum"}
    return hashlib.sha256(json.dumps(own).encode()).hexdigest()


def header_of(path: Path) -> Header:
    """Return all but the rows of a streamed file."""

    def read(file: Any) -> Header:  # noqa: ANN401
        attributes = _attributes_of(file)
        text = file[END][:].tobytes()
        series = {name: file[name] for name in file if _is_series(file[name])}
        arrays = StoredArrays(path, str(attributes[IDENTITY]), *_rows_of(series))
        constants = {
            name: file[name][...]
            for name in file
            if name not in series and getattr(file[name], "dtype", np.dtype("O")).kind in "fi"
        }
        found = {name: file[name] for name in JUMPS if name in file}
        complete = min((dataset.shape[0] for dataset in found.values()), default=0)
        jumps = {name: dataset[:complete] for name, dataset in found.items()}
        # Zeros behind it: the process was killed before all of it was written.
        end = json.loads(text) if text and not text.endswith(b"\0") else None
        return Header(attributes, arrays, constants | jumps, end)

    return _opened(path, read)


def _attributes_of(file: Any) -> dict[str, Any]:  # noqa: ANN401
    """Return the attributes of a file from its header.

    The attributes themselves are texts of variable length, which HDF5 keeps without a checksum: it
    reads a damaged one without end.
    """
    attributes: dict[str, Any] = json.loads(file[HEADER][:].tobytes())
    if attributes.get("checksum") != checksum_of(attributes):
        msg = "its header does not match its checksum"
        raise ValueError(msg)
    return attributes


def _is_series(dataset: Any) -> bool:  # noqa: ANN401
    """Return whether a dataset has a row for each report."""
    lengths = getattr(dataset, "maxshape", None) or (1,)
    return lengths[0] is None and not dataset.name.startswith("/jump")


def _rows_of(series: Mapping[str, Any]) -> tuple[npt.NDArray[Any], tuple[str, ...]]:
    """Return the times of the complete rows, and the names of the arrays.

    The datasets of a process that was killed may differ by the piece that it was writing.
    """
    rows = min(dataset.shape[0] for dataset in series.values())
    times = series["time"][:rows]
    if not rows:
        msg = "no row has been written yet"
        raise ValueError(msg)
    if not np.all(np.isfinite(times)):
        msg = "its times are no finite numbers"
        raise ValueError(msg)
    stays = np.flatnonzero(np.diff(times) <= 0.0)
    times = times[: stays[0] + 1] if stays.size else times
    names = [n for n, v in VARIABLES.items() if all(p in series for p, *_ in v.parts(n))]
    return times, ("time", *names)


def _opened(path: Path, read: Callable[[Any], _Made], identity: str | None = None) -> _Made:
    """Return what `read` makes of the open file."""
    h5py = extras.h5py  # missing, it is no damage to the file
    where = check_there(path, netcdf.WRITER)

    def made(path: Path) -> _Made:
        marked = is_marked(path)
        locking = None if marked else "best-effort"
        with (
            Unmarked(path) if marked else nullcontext(path) as there,
            h5py.File(there, "r", locking=locking) as file,
        ):
            if identity is not None and not (
                is_streamed(path) and _attributes_of(file)[IDENTITY] == identity
            ):
                msg = f"path = {shown_path(path)}: was replaced since it was loaded; load it again"
                raise InvalidInput(msg)
            return read(file)

    for last in (False, False, True):
        try:
            return netcdf.beside(made, where)
        except InvalidInput:
            raise
        except Exception as error:  # so does what is damaged within
            if last or not is_marked(where):
                told = next(iter(str(error).splitlines()), "") or repr(error)
                raise netcdf.damaged(path, told[:200]) from error
        time.sleep(_PAUSE)  # another process may be in the middle of writing
    raise AssertionError


class StoredArrays(Mapping[str, npt.NDArray[Any]]):
    """The arrays of a result in a streamed file.

    An array is read when it is accessed, and again when it is accessed after it was let go.

    Attributes
    ----------
    path : Path
        The file.
    empty : dict of ndarray
        Arrays without numbers, which the file does not have.
    """

    def __init__(
        self, path: Path, identity: str, times: npt.NDArray[Any], names: tuple[str, ...]
    ) -> None:
        self.path = path.absolute()
        self.empty: dict[str, npt.NDArray[Any]] = {}
        self._identity, self._names = identity, names
        self._time = read_only(times)
        self._read: WeakValueDictionary[str, npt.NDArray[Any]] = WeakValueDictionary()

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        """Return all rows of an array."""
        if name == "time" or name in self.empty:
            return self.part(name, slice(None))
        if name not in self._names:
            raise KeyError(name)
        found = self._read.get(name)
        if found is None:
            self._read[name] = found = self.part(name, slice(None))
        return found

    def __iter__(self) -> Iterator[str]:
        """Go through the names."""
        return iter((*self._names, *self.empty))

    def __len__(self) -> int:
        """Return how many arrays there are."""
        return len(self._names) + len(self.empty)

    def __contains__(self, name: object) -> bool:
        """Return whether there is such an array, without reading it."""
        return name in self._names or name in self.empty

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the name of the file, not its content."""
        made = (self.path, self._identity, self._time, self._names)
        return type(self), made, {"empty": self.empty}

    def part(self, name: str, rows: slice, column: int | None = None) -> npt.NDArray[Any]:
        """Return some rows of an array, or of one of its columns; only they are read."""
        first, last, _ = rows.indices(len(self._time))
        place = slice(first, last) if column is None else (slice(first, last), column)
        there = {"time": self._time} | self.empty
        if name in there:
            found = there[name][place]
        else:

            def read(file: Mapping[str, Any]) -> npt.NDArray[Any] | None:
                return array_of(file, name, place=place)

            found = _opened(self.path, read, self._identity)
        return cast("npt.NDArray[Any]", read_only(found))


def part_of(
    arrays: Mapping[str, npt.NDArray[Any]], name: str, rows: slice, column: int | None = None
) -> npt.NDArray[Any]:
    """Return some rows of an array, or of one of its columns, wherever the arrays are."""
    if isinstance(arrays, StoredArrays):
        return arrays.part(name, rows, column)
    return arrays[name][rows] if column is None else arrays[name][rows, column]
