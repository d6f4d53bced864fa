"""Packages of the extras: imported when they are needed, and named with the pip command."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from rustchain.errors import MissingExtra
from rustchain.names import DISTRIBUTION

if TYPE_CHECKING:
    import h5py as h5py
    import matplotlib as matplotlib
    import pandas as pandas
    import typer as typer
    import xarray as xarray
    from scipy import interpolate as interpolate
    from scipy import signal as signal
    from scipy import stats as stats
    from tqdm import auto as auto

MODULES = {
    "matplotlib": ("matplotlib", "plot"),
    "xarray": ("xarray", "io"),
    "h5py": ("h5py", "io"),
    "pandas": ("pandas", "io"),
    "interpolate": ("scipy.interpolate", "analysis"),
    "signal": ("scipy.signal", "analysis"),
    "stats": ("scipy.stats", "analysis"),
    "auto": ("tqdm.auto", "cli"),
    "typer": ("typer", "cli"),
}
"""Each name of this module: the module that it stands for, and the extra that installs it."""


def __getattr__(name: str) -> object:
    """Import the module that `name` stands for.

    Raises
    ------
    MissingExtra
        It is not installed.
    """
    if name not in MODULES:
        msg = f"module {__name__!r} has no attribute {name!r}"
        raise AttributeError(msg)
    module, extra = MODULES[name]
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        msg = (
            f"{error.name} is not installed; it belongs to the extra {extra!r}: "
            f'pip install "{DISTRIBUTION}[{extra}]"'
        )
        raise MissingExtra(msg, name=error.name) from error
