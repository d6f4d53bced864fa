"""Outputs of a result outside the program: figures, animations, reports, tables, files."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from rustchain.results import tables
from rustchain.typing import FilePath, Time

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from rustchain.plot import Plots
    from rustchain.plot.animation import Animation
    from rustchain.results.result import Result


class Exports:
    """Methods of a `Result` that make figures, pages, tables and files of it."""

    @property
    def plot(self) -> Plots:
        """Figures; see `rustchain.plot.Plots`."""
        from rustchain.plot import Plots

        return Plots(cast("Result", self))

    def animate(
        self,
        path: FilePath | None = None,
        *,
        start: Time = None,
        end: Time = None,
        slow_motion: float | None = None,
        fps: float = 25.0,
        camera: str = "scene",
        view: float | None = None,
        forces: bool = True,
        width: int = 900,
    ) -> Animation:
        """Show the motion that was recorded, in a notebook or as a file.

        ``record`` must have "bodies" in it; contact forces and joint reactions that were recorded
        are arrows. Between the rows GIF and MP4 have cubic interpolation, the player has linear.

        Parameters
        ----------
        path : str or Path, optional
            File to write: ``.gif``, ``.mp4`` (needs the program ffmpeg) or ``.html``, a page with
            the player. Without one nothing is written, and a notebook shows the player.
        start, end : float, optional
            Part of the time [s], by default all of it.
        slow_motion : float, optional
            Seconds of animation for one of simulation; by default such that it lasts ten seconds.
        fps : float
            Frames a second. A GIF has delays of whole hundredths of a second.
        camera : str
            "scene", or the name of the body that stays in the middle: "sprocket_1", "link_6".
        view : float, optional
            Width of the view [m]; by default the whole scene, a sprocket, or eight pitches.
        forces : bool
            Whether forces are drawn.
        width : int
            Width of a frame [pixels], 100 to 4000.

        Returns
        -------
        Animation
            The frames, which `Animation.save` writes.

        Raises
        ------
        NotRecorded
            The bodies were not recorded.
        InvalidInput
            An option is out of its range.
        MissingExtra
            matplotlib is not installed, or of ".mp4" the program ffmpeg.
        OSError
            The file cannot be written.
        """
        from rustchain.plot.animation import Animation

        found = Animation(
            cast("Result", self),
            start=start,
            end=end,
            slow_motion=slow_motion,
            fps=fps,
            camera=camera,
            view=view,
            forces=forces,
            width=width,
        )
        if path is not None:
            found.save(path)
        return found

    def report(
        self,
        path: FilePath,
        *,
        start: Time = None,
        end: Time = None,
        breaking_load: float | None = None,
    ) -> None:
        """Write a report: one page that needs no network, with figures and the player.

        It has layout and inputs, key figures with their confidence, the safety of the chain beside
        what is usual, warnings, plots, and the moving drive where bodies were recorded.

        Parameters
        ----------
        path : str or Path
            File to write, ``.html``.
        start, end : float, optional
            Part of the time [s] that is reported, by default all of it.
        breaking_load : float, optional
            Of the chain, all strands together [N]; by default the catalogue's.

        Raises
        ------
        InvalidInput
            The name does not end in .html, or no rows lie between `start` and `end`.
        MissingExtra
            matplotlib or xarray is not installed.
        OSError
            The file cannot be written.
        """
        from rustchain.report.page import write_report

        write_report(cast("Result", self), path, start=start, end=end, breaking_load=breaking_load)

    def to_xarray(self) -> xr.Dataset:
        """Return everything as a dataset with units; the scene is in its attributes."""
        return tables.dataset_of(cast("Result", self))

    def to_pandas(self) -> pd.DataFrame:
        """Return a row for each time and a column for each number: ``hinge_force_vector_6_x``."""
        return tables.table_of(self.to_xarray())

    def save(self, path: FilePath) -> None:
        """Write everything to a netCDF file, for `load_result`.

        The file is there whole or not at all: an existing one is replaced when the new one is
        complete, with the same permissions. A process that is killed meanwhile may leave a hidden
        file that ends in ``.part``. Ctrl-C is answered when the content is packed. To save in a
        function of `atexit`, import h5py, and dask where it is installed, before.

        Parameters
        ----------
        path : str or Path
            The file, such as ``run.nc``: its name ends in ``.nc``, ``.nc4``, ``.cdf``, ``.h5`` or
            ``.hdf5``, or has no ending. A symbolic link is followed.

        Raises
        ------
        OSError
            The file cannot be written, or is a directory, a device or a FIFO.
        InvalidInput
            `path` is no name of a file, such as an open file, has a NUL character, or has another
            ending.
        """
        from rustchain.results import netcdf  # with hashes and threads, which nothing else needs

        where = netcdf.result_path(path)
        netcdf.write(self.to_xarray(), where)
