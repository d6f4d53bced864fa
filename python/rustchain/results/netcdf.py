"""Results in netCDF files: written with a checksum, and read back."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Callable, Hashable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import numpy.typing as npt

from rustchain import extras
from rustchain.errors import InvalidInput
from rustchain.paths import check_there, path_with_ending, shown_path, write_whole

if TYPE_CHECKING:
    import xarray as xr

_Given = TypeVar("_Given")
_Made = TypeVar("_Made")


WRITER = "Result.save or Simulation.run(out=...)"
"""What writes the files of results."""


ENDINGS = (".nc", ".nc4", ".cdf", ".h5", ".hdf5")
"""Endings of the names of files of results; a name may also have none."""


def result_path(path: object, field: str = "path") -> Path:
    """Return the path of a file of a result, or refuse the name of another kind of file."""
    more = "; result.to_pandas().to_csv(...) writes a table"
    return path_with_ending(path, field, ENDINGS, "results are netCDF files", more)


def write(dataset: xr.Dataset, path: object) -> None:
    """Write a dataset to a file with a checksum behind it."""
    write_whole(path, beside(_image, dataset).getbuffer())


def read(path: object) -> xr.Dataset:
    """Return the dataset in a file that `Result.save` wrote."""
    _ = extras.xarray, extras.h5py  # missing, they are no damage to the file
    content = check_there(path, WRITER).read_bytes()
    try:
        return beside(_dataset, content)
    except Exception as error:  # what no file of this package is raises what it likes
        raise damaged(path, error) from error


def damaged(path: object, error: object) -> InvalidInput:
    """Return the error with the reason why a file has no complete result."""
    if shown_path(path).lower().endswith(".toml"):
        return InvalidInput(
            f"path = {shown_path(path)}: is a TOML file; expected a result, as rustchain run and "
            "Simulation.run write it"
        )
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
    from rustchain.extras import h5py
    from rustchain.extras import xarray as xr

    body = memoryview(content)[: -len(_checksum(b""))]
    # HDF5 does not see a damaged file: it reads some as another content, and fails in many ways.
    if content[len(body) :] != _checksum(body):
        msg = "it holds no result that matches its checksum"
        raise ValueError(msg)
    with h5py.File(io.BytesIO(content), "r") as file:
        dims = _dims(file)
        names = [name for name in file if not _is_bare(file[name])]
        variables = {
            name.removeprefix(_NO_COORDINATES): _variable(file[name], dims) for name in names
        }
        found = xr.Dataset(variables, attrs=_attributes(file))
    return xr.decode_cf(found, decode_times=False).load()


def _image(dataset: xr.Dataset) -> io.BytesIO:
    """Return the bytes of a netCDF file and the checksum behind it.

    HDF5 writes to memory because it does not survive a failing disc: the process ends with a
    segmentation fault when the file is closed.
    """
    from xarray import conventions

    from rustchain.extras import h5py

    names = [*dataset.variables, *dataset.dims]
    dataset = dataset.rename({n: str(n).replace("/", "%2F") for n in names if "/" in str(n)})
    variables, attributes = conventions.encode_dataset_coordinates(dataset)
    variables, attributes = conventions.cf_encoder(variables, attributes)
    image = io.BytesIO()
    with h5py.File(image, "w", track_order=True) as file:
        file.attrs.update(attributes)
        for name in sorted(variables, key=lambda name: variables[name].dims != (name,)):
            found = variables[name]
            clashes = name in dataset.dims and found.dims != (name,)
            stored = f"{_NO_COORDINATES if clashes else ''}{name}"
            add_variable(file, stored, found.dims, found.values, found.attrs)
    checksum = _checksum(image.getbuffer())
    image.seek(0, io.SEEK_END)
    image.write(checksum)
    return image


# --- netCDF-4 in HDF5: each dimension is a dimension scale, with its coordinates or without values

_BARE = "This is a netCDF dimension but not a netCDF variable."
_NO_COORDINATES = "_nc4_non_coord_"  # before the name of a variable that a dimension has, too
_INTERNAL = {"CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST"}  # attributes of HDF5
_INTERNAL |= {"_NCProperties", "_Netcdf4Dimid", "_Netcdf4Coordinates"}  # and of netCDF


def add_variable(
    file: Any,  # noqa: ANN401
    name: str,
    dims: Sequence[Hashable],
    values: npt.NDArray[Any],
    attributes: Mapping[Any, Any],
    **storage: Any,  # noqa: ANN401
) -> None:
    """Add a variable to an HDF5 file, with the dimensions that are not there yet.

    A variable with the name of its only dimension has the coordinates of that dimension, and is
    added before all others. `storage` is passed to `h5py.Group.create_dataset`.
    """
    is_text = values.dtype.kind in "UO"
    kind = extras.h5py.string_dtype() if is_text else values.dtype
    made = file.create_dataset(name, data=values.astype(kind, copy=False), **storage)
    made.attrs.update(attributes)
    if tuple(dims) == (name,):
        made.make_scale(_last(name))
        return
    for axis, dim in enumerate(dims):
        if dim not in file:
            length, most = made.shape[axis], made.maxshape[axis]
            bare = file.create_dataset(dim, (length,), ">f4", maxshape=(most,))
            bare.make_scale(f"{_BARE}{length:10}")
        made.dims[axis].attach_scale(file[dim])


def _is_bare(dataset: Any) -> bool:  # noqa: ANN401
    """Return whether a dataset stands for a dimension without coordinates."""
    return _is_scale(dataset) and dataset.attrs["NAME"].startswith(_BARE.encode())


def _is_scale(dataset: Any) -> bool:  # noqa: ANN401
    """Return whether a dataset is a dimension scale; h5py's `is_scale` can end the process.

    HDF5 2.0 frees the same memory twice where the attribute is damaged.
    """
    return bool(dataset.attrs.get("CLASS", b"") == b"DIMENSION_SCALE")


def _dims(file: Any) -> dict[tuple[str, int], str]:  # noqa: ANN401
    """Return the dimension of each axis of the variables, by the variable's name.

    They are read from the scales. The lists of the variables have a length of any size where they
    are damaged, and HDF5 2.0 takes as much memory.
    """
    found = {}
    for name in file:
        for place, axis in file[name].attrs.get("REFERENCE_LIST", ()):
            found[file[place].name, int(axis)] = _last(name)
    return found


def _variable(
    dataset: Any,  # noqa: ANN401
    dims: Mapping[tuple[str, int], str],
) -> tuple[tuple[str, ...], npt.NDArray[Any], dict[str, Any]]:
    """Return dimensions, values and attributes of a variable."""
    name = dataset.name
    scale = _is_scale(dataset)
    of = (_last(name),) if scale else tuple(dims[name, axis] for axis in range(dataset.ndim))
    is_text = dataset.dtype.kind == "O"
    values = np.asarray(dataset.asstr()[...], str) if is_text else np.asarray(dataset[...])
    return of, values, _attributes(dataset)


def _attributes(place: Any) -> dict[str, Any]:  # noqa: ANN401
    """Return the attributes of a file or dataset, without those of HDF5 and netCDF."""
    # Not by `items`, here and above: an error on the way would leave all of h5py locked.
    names = (name for name in place.attrs if name not in _INTERNAL)
    return {name: place.attrs[name] for name in names}


def _last(name: str) -> str:
    """Return a name without those of its groups."""
    return name.rpartition("/")[2]
