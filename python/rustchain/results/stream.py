"""Streamed results: netCDF files to which the rows of a run are appended during the run.

The files use HDF5's mode for a single writer and multiple readers (SWMR). Metadata is written in an
order that keeps the file readable at any time, so that a killed process leaves all flushed rows.
Every number has a checksum: metadata from HDF5's format 3, rows from gzip's format, uncompressed.
"""

from __future__ import annotations

import atexit
import contextlib
import errno
import json
import os
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor, wait
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from rustchain import extras
from rustchain.paths import check_writable, new_file, shown_path, unwritable
from rustchain.results import tables
from rustchain.results.netcdf import add_variable, result_path
from rustchain.results.stored import END, HEADER, IDENTITY, checksum_of, header_of
from rustchain.results.superblock import SIZE, end_of

if TYPE_CHECKING:
    from rustchain.results.result import Result
    from rustchain.results.views import Jumps

Rows = dict[str, npt.NDArray[Any]]

_JUMPS_OF_A_CHUNK = 256

# Level 0 of gzip does not compress; it adds the checksum Adler-32, which is not 0 for zeros. The
# checksum of HDF5, Fletcher-32, is: zeros in the place of a block would be read as its rows.
_CHECKED = {"compression": "gzip", "compression_opts": 0}

_ALL = 2**62
_SLACK = 2**20  # [bytes] of metadata for one piece: the indices of its chunks, below 100 kB


@cache
def _lock_at_exit() -> None:
    """Have the end of Python wait for the lock of h5py, and keep it.

    A further Ctrl-C breaks its wait for threads. They are then stopped where they are; one that had
    the lock would keep it, and the end of h5py's objects would wait for it forever.
    """
    from h5py._objects import phil  # the lock; its wait hears no signals

    atexit.register(phil.acquire)


class Stream:
    """A file that takes the rows of a run in pieces, in a thread of its own.

    Parameters
    ----------
    path : str or Path
        The file; one that is there is replaced.
    result : Result
        A result without rows: scene, names and the shapes of the channels.
    chunk : int
        Rows of a chunk. All pieces but the last have a multiple of it.

    Attributes
    ----------
    channels : tuple of str
        Names of the arrays.
    largest_residual : float
        Largest residual of the energy balance in the rows so far [J].

    Raises
    ------
    OSError
        The file cannot be written.
    """

    def __init__(self, path: object, result: Result, chunk: int) -> None:
        self._result, self._chunk, self._path = result, chunk, result_path(path, "out")
        self._identity = os.urandom(16).hex()
        self.channels = tuple(result.arrays)
        self._rows, self.largest_residual = 0, 0.0
        self._error: Exception | None = None
        self._last: Future[None] | None = None
        self._closed = False
        self._file: Any = None
        # Not in the main thread: h5py's weak references would swallow a Ctrl-C.
        self._thread = ThreadPoolExecutor(1)
        self._thread.submit(int)  # starts it: a Ctrl-C during its start would lose it with its work
        try:
            self._do(self._open)
        except BaseException:
            self._do(self._release)
            raise

    def append(self, take: Callable[[], Rows], jumps: Callable[[], Jumps | None]) -> None:
        """Take a piece of rows and write it during the run.

        The thread takes the rows itself, so that Ctrl-C cannot lose them on their way. The piece
        before is written first: at most two are in memory.

        Raises
        ------
        OSError
            A piece before this one could not be written.
        """
        if self._last is not None:
            self._last.result()
        self._check()
        taken = threading.Event()
        self._last = self._thread.submit(self._append, take, jumps, taken)
        taken.wait()

    def finish(
        self,
        take: Callable[[int], Rows],
        jumps: Callable[[], Jumps | None],
        end: Callable[[float], Mapping[str, Any]],
    ) -> None:
        """Write the last piece and how the run ended, and close the file; later calls do nothing.

        `take` gets the number of rows to take at most, `end` the largest residual of the energy
        balance [J]. Ctrl-C meanwhile is raised when the file is closed.

        Raises
        ------
        OSError
            A piece could not be written.
        """
        self._do(self._finish, take, jumps, end)
        self._check()

    def arrays(self) -> Mapping[str, npt.NDArray[Any]]:
        """Return the written rows, read when they are accessed; none from a file that is gone."""
        if not self._rows or self._is_replaced():
            return self._result.arrays
        found = header_of(self._path).arrays
        empty = {name: a for name, a in self._result.arrays.items() if 0 in a.shape[1:]}
        found.empty = {n: np.zeros((self._rows, *a.shape[1:]), a.dtype) for n, a in empty.items()}
        return found

    def _do(self, work: Callable[..., None], *given: object) -> None:
        """Have the thread do some work, and wait for its end; raise an interrupt only then."""
        doing = self._thread.submit(work, *given)
        interrupt: BaseException | None = None
        while not doing.done():
            try:
                wait([doing])
            except BaseException as error:  # of a signal's handler
                interrupt = error
        if interrupt is not None:
            raise interrupt
        doing.result()

    def _check(self) -> None:
        if self._error is not None:
            raise self._error

    def _open(self) -> None:
        """Make the file with its header, put it in its place, and open it for rows."""
        h5py = extras.h5py
        _lock_at_exit()
        check_writable(self._path, "out")  # in words of the system: those of HDF5 are its own
        with new_file(self._path, "out") as (part, self._path):
            self._write_header(part)
            self._status = part.stat()
        # Without a cache of chunks: closing one that is not written ends the process when the disc
        # is full. Pieces have whole chunks, which are written once.
        self._file = h5py.File(self._path, "r+", libver="v110", rdcc_nbytes=0)
        self._check_ours()
        self._file.swmr_mode = True

    def _write_header(self, part: Path) -> None:
        """Write all that is known before the first row."""
        result = self._result
        channels = {n: a for n, a in result.arrays.items() if 0 not in a.shape[1:]}
        series = tables.variables_of(channels)
        series = {"time": (("time",), result.time, tables.TIME_ATTRIBUTES)} | series
        if result.jumps is not None:
            series |= tables.jumps_of(result.jumps)
        constant = tables.ends_of(result, ("initial",))
        used = {d for dims, *_ in (*series.values(), *constant.values()) for d in dims}
        coordinates = {n: np.asarray(v) for n, v in tables.coordinates_of(result).items()}
        constant = {n: ((n,), v, {}) for n, v in coordinates.items() if n in used} | constant
        attributes = tables.attributes_of(result) | {IDENTITY: self._identity}
        attributes["body_names"] = json.dumps(result.body_names)
        attributes["checksum"] = checksum_of(attributes)
        with extras.h5py.File(part, "w", libver="v110") as file:
            file.attrs.update(attributes)
            for name, (dims, values, notes) in constant.items():
                is_text = values.dtype.kind == "U"  # HDF5 has no checksums of texts
                checked = {} if is_text else {"chunks": values.shape, **_CHECKED}
                add_variable(file, name, dims, values, notes, **checked)
            for name, (dims, values, notes) in series.items():
                rows = self._chunk if dims[0] == "time" else _JUMPS_OF_A_CHUNK
                row = values.shape[1:]
                grows = {"maxshape": (None, *row), "chunks": (rows, *row), **_CHECKED}
                add_variable(file, name, dims, values, notes, **grows)
            known = np.frombuffer(json.dumps(attributes).encode(), np.uint8)
            add_variable(file, HEADER, (HEADER,), known, {}, chunks=known.shape, **_CHECKED)
            grows = {"maxshape": (None,), "chunks": (4096,), **_CHECKED}
            add_variable(file, END, (END,), np.empty(0, np.uint8), {}, **grows)

    def _append(
        self, take: Callable[[], Rows], jumps: Callable[[], Jumps | None], taken: threading.Event
    ) -> None:
        try:
            rows, found = take(), jumps()
        except Exception as error:
            self._error = error
            return
        finally:
            taken.set()
        self._write(rows, found)

    def _write(self, rows: Rows, jumps: Jumps | None) -> None:
        """Write a piece, unless one before it failed."""
        count = len(rows["time"])
        if self._error is not None:
            return
        try:
            self._check_ours()
            if jumps is not None:
                first = self._file[tables.JUMPS[0]].shape[0]  # not yet in the file
                jumps = jumps[0][first:], jumps[1][first:], jumps[2][first:]
            size = sum(array.nbytes for array in rows.values()) // max(count, 1)
            self._reserve(size * (count + self._chunk))
            series = tables.variables_of(rows)
            series |= {} if jumps is None else tables.jumps_of(jumps)
            series["time"] = (("time",), rows["time"], {})  # last: it says how many rows there are
            for name, (_, values, _) in series.items():
                if name in self._file and len(values):
                    self._extend(self._file[name], values)
            self._file.flush()
        except Exception as error:
            self._error = self._told(error)
            return
        self._rows += count
        if (residual := rows.get("energy_residual")) is not None:
            # The rows of a run that failed may end in what is no number.
            largest = np.nanmax(np.abs(residual), initial=0.0)
            self.largest_residual = max(self.largest_residual, float(largest))

    @staticmethod
    def _extend(dataset: Any, values: npt.NDArray[Any]) -> None:  # noqa: ANN401
        first = dataset.shape[0]
        dataset.resize(first + len(values), axis=0)
        dataset[first:] = np.ascontiguousarray(values)

    def _check_ours(self) -> None:
        """Refuse to go on in a file that another run has replaced, or that is gone."""
        if self._is_replaced():
            raise OSError(errno.ESTALE, "was replaced or removed while the run wrote it")

    def _is_replaced(self) -> bool:
        with contextlib.suppress(FileNotFoundError):
            return not os.path.samestat(self._path.stat(), self._status)
        return True

    def _reserve(self, size: int) -> None:
        """Have the disc keep room behind the end of the file, before HDF5 needs it.

        HDF5 is not told of a full disc when it closes a file; see decision 44.
        """
        if not hasattr(os, "posix_fallocate"):
            return
        with self._path.open("r+b") as file:
            try:
                os.posix_fallocate(file.fileno(), self._file.id.get_filesize(), size + _SLACK)
            except OSError as error:
                if error.errno in (errno.ENOSPC, errno.EFBIG, errno.EDQUOT):
                    raise

    def _finish(
        self,
        take: Callable[[int], Rows],
        jumps: Callable[[], Jumps | None],
        end: Callable[[float], Mapping[str, Any]],
    ) -> None:
        if self._closed:
            return
        self._write(take(_ALL), jumps())
        about = dict(end(self.largest_residual))
        if self._error is not None and about["status"] != "failed":  # rows are missing
            about |= {"status": "failed", "message": repr(self._error)}
        text = json.dumps(about).encode()
        try:
            self._check_ours()
            self._reserve(len(text))
            self._extend(self._file[END], np.frombuffer(text, np.uint8))
            self._file.flush()
        except Exception as error:
            self._error = self._error or self._told(error)
        self._release()

    def _release(self) -> None:
        """Close the file and give back the room behind its end."""
        if self._closed or self._file is None:
            return
        self._closed = True
        try:
            self._file.close()
            self._check_ours()
            with self._path.open("r+b") as file:
                file.truncate(end_of(file.read(SIZE)))
                os.fsync(file.fileno())
        except Exception as error:
            self._error = self._error or self._told(error)

    def _told(self, error: Exception) -> OSError:
        """Return an error of the disc or of HDF5 with the file and what is in it."""
        if not isinstance(error, OSError):
            error = OSError(errno.EIO, str(error).splitlines()[0])
        if error.errno == errno.ESTALE:
            msg = f"out = {shown_path(self._path)}: {error.strerror}; give each run its own file"
            return OSError(error.errno, msg)
        told = unwritable(self._path, "out", error)
        return type(told)(f"{told}; its first {self._rows} rows are in {shown_path(self._path)}")
