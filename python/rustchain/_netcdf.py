"""Results in netCDF files: written, and read back."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rustchain.errors import InvalidInput

if TYPE_CHECKING:
    import xarray as xr


def write(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a dataset to a file, lightly packed."""
    packed = {name: {"zlib": True, "complevel": 1} for name in dataset.data_vars}
    dataset.to_netcdf(path, engine="h5netcdf", encoding=packed)


def read(path: str | Path, damaged: str) -> xr.Dataset:
    """Return the dataset in a file; `damaged` says what is no such file, with one {} for why."""
    import xarray as xr

    try:
        return xr.load_dataset(path, engine="h5netcdf", decode_times=False)
    except Exception as error:  # what is no netCDF file, or is damaged, raises what it likes
        if isinstance(error, OSError) and not Path(path).is_file():
            raise  # which names the path
        raise InvalidInput(f"path = {path}: " + damaged.format(error)) from error
