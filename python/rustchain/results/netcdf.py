"""Results in netCDF files: written with a checksum, and read back."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from rustchain import extras
from rustchain.errors import InvalidInput
from rustchain.paths import check_there, shown_path, write_whole

if TYPE_CHECKING:
    import xarray as xr

_Given = TypeVar("_Given")
_Made = TypeVar("_Made")


WRITER = "Result.save or Simulation.run(out=...)"
"""What writes the files of results."""


def write(dataset: xr.Dataset, path: object) -> None:
    """Write a dataset to a file with a checksum behind it."""
    write_whole(path, beside(_image, dataset).getbuffer())


def read(path: object) -> xr.Dataset:
    """Return the dataset in a file that `Result.save` wrote."""
    _ = extras.xarray, extras.h5netcdf  # missing, they are no damage to the file
    content = check_there(path, WRITER).read_bytes()
    try:
        return beside(_dataset, content)
    except Exception as error:  # what no file of this package is raises what it likes
        raise damaged(path, error) from error


def damaged(path: object, error: object) -> InvalidInput:
    """Return the error with the reason why a file has no complete result."""
    return InvalidInput(
        f"path = {shown_path(path)}: is no result, or is damaged ({error}): give a file "
        f"that {WRITER} wrote, which is netCDF whatever its name, or copy or save it again"
    )


def _checksum(body: bytes | memoryview) -> bytes:
    """Return the line behind the end of an HDF5 file, which its readers leave unread."""
    return f"\nrustchain sha256 {hashlib.sha256(body).hexdigest()}\n".encode()


def beside(work: Callable[[_Given], _Made], given: _Given) -> _Made:
    """Return what `work` makes of `given` in a thread of its own.

    Python raises KeyboardInterrupt in the main thread only. There h5py's many weak references would
    swallow it: exceptions in their callbacks are printed and ignored. It ends the wait; the thread
    then ends its work for nobody.
    """
    try:
        from concurrent.futures import ThreadPoolExecutor

        thread = ThreadPoolExecutor(1)
        made = thread.submit(work, given)
    except RuntimeError:  # in a function of `atexit`: no thread begins any more
        return work(given)
    try:
        return made.result()
    finally:
        thread.shutdown(wait=False)


def _dataset(content: bytes) -> xr.Dataset:
    """Return what is in the bytes of a file."""
    from rustchain.extras import xarray as xr

    body = memoryview(content)[: -len(_checksum(b""))]
    # HDF5 does not see a damaged file: it reads some as another content, and fails in many ways.
    if content[len(body) :] != _checksum(body):
        msg = "it holds no result that matches its checksum"
        raise ValueError(msg)
    return xr.load_dataset(io.BytesIO(content), engine="h5netcdf", decode_times=False)


def _image(dataset: xr.Dataset) -> io.BytesIO:
    """Return the bytes of a netCDF file and the checksum behind it.

    HDF5 writes to memory because it does not survive a failing disc: the process ends with a
    segmentation fault when the file is closed.
    """
    from xarray.backends import H5NetCDFStore

    from rustchain.extras import h5netcdf

    image = io.BytesIO()
    with h5netcdf.File(image, "w") as file:
        dataset.dump_to_store(H5NetCDFStore(file))
    checksum = _checksum(image.getbuffer())
    image.seek(0, io.SEEK_END)
    image.write(checksum)
    return image
