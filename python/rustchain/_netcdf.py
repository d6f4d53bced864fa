"""Results in netCDF files: written with a checksum, and read back."""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from rustchain._paths import check_there, shown, write_whole
from rustchain.errors import InvalidInput

if TYPE_CHECKING:
    from pathlib import Path

    import xarray as xr

_Given = TypeVar("_Given")
_Made = TypeVar("_Made")


def write(dataset: xr.Dataset, path: object) -> None:
    """Write a dataset to a file, lightly packed."""
    write_whole(path, _beside(_image, dataset.assign_attrs(checksum=_checksum(dataset))))


def read(path: object, writer: str, other: str) -> xr.Dataset:
    """Return the dataset in a file that `writer` wrote, a result of `other`."""
    where = check_there(path, writer)
    try:
        dataset = _beside(_dataset, where)
        given = dataset.attrs.pop("checksum", None)
        is_whole = str(given) == _checksum(dataset)
    except Exception as error:  # what is no netCDF file, or is damaged, raises what it likes
        raise damaged(path, writer, other, error) from error
    if "rustchain_version" not in dataset.attrs:
        msg = f"path = {shown(path)}: holds no result of rustchain: give a file that {writer} wrote"
        raise InvalidInput(msg)
    if not is_whole:
        raise damaged(path, writer, other, "its content does not match its checksum")
    return dataset


def damaged(path: object, writer: str, other: str, error: object) -> InvalidInput:
    """Return the error that says why a file holds no whole result."""
    return InvalidInput(
        f"path = {shown(path)}: is no result of {other}, or is damaged ({error}): give a file that "
        f"{writer} wrote, which is netCDF whatever its name, or copy or save it again"
    )


def _beside(work: Callable[[_Given], _Made], given: _Given) -> _Made:
    """Return what `work` makes of `given` in a thread of its own, whose end is waited for.

    Python raises KeyboardInterrupt in the main thread only. There h5py's many weak references would
    swallow it: exceptions in their callbacks are printed and ignored.
    """
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(work, given).result()


def _dataset(path: Path) -> xr.Dataset:
    """Return what is in a file."""
    import xarray as xr

    return xr.load_dataset(path, engine="h5netcdf", decode_times=False)


def _image(dataset: xr.Dataset) -> memoryview:
    """Return the bytes of a netCDF file.

    HDF5 writes to memory because it does not survive a failing disc: the process ends with a
    segmentation fault when the file is closed.
    """
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    packed = {name: {"zlib": True, "complevel": 1} for name in dataset.data_vars}
    image = io.BytesIO()
    with h5netcdf.File(image, "w") as file:
        dataset.dump_to_store(H5NetCDFStore(file), encoding=packed)
    return image.getbuffer()


def _checksum(dataset: xr.Dataset) -> str:
    """Return the SHA-256 of all that a dataset says, in hexadecimal.

    It is of the content and not of the file, in which a changed byte may also have no effect:
    attributes and, by their names, each variable's dimensions, attributes, type and values.
    """
    digest = hashlib.sha256(_text(dataset.attrs))
    for name, variable in sorted(dataset.variables.items()):
        values = variable.values
        numbers = values.dtype.kind in "biuf"
        kind = values.dtype.str if numbers else "text"
        digest.update(_text([name, variable.dims, values.shape, kind, variable.attrs]))
        # Text has another type in memory than after a file.
        digest.update(np.ascontiguousarray(values).data if numbers else _text(values.tolist()))
    return digest.hexdigest()


def _text(value: object) -> bytes:
    """Return what JSON says of a value; NumPy's numbers are Python's."""
    return json.dumps(value, sort_keys=True, default=np.generic.item).encode()
