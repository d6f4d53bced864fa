"""Results in netCDF files: written, and read back."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rustchain._paths import check_there, unwritable
from rustchain.errors import InvalidInput

if TYPE_CHECKING:
    import xarray as xr


def write(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a dataset to a file, lightly packed."""
    packed = {name: {"zlib": True, "complevel": 1} for name in dataset.data_vars}
    try:
        dataset.to_netcdf(path, engine="h5netcdf", encoding=packed)
    except OSError as error:
        raise type(error)(f"path = {path}: {unwritable(error)}") from error


def read(path: str | Path, writer: str, other: str) -> xr.Dataset:
    """Return the dataset in a file that `writer` wrote, a result of `other`."""
    import xarray as xr

    check_there(path, writer)
    try:
        return xr.load_dataset(path, engine="h5netcdf", decode_times=False)
    except Exception as error:  # what is no netCDF file, or is damaged, raises what it likes
        raise damaged(path, writer, other, error) from error


def damaged(path: str | Path, writer: str, other: str, error: Exception) -> InvalidInput:
    """Return the error that says why a file holds no whole result."""
    return InvalidInput(
        f"path = {path}: is no result of {other}, or is damaged ({error}): give a file that "
        f"{writer} wrote, which is netCDF whatever its name, or copy or save it again"
    )
