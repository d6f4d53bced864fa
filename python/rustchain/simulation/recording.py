"""A run under way: it advances the simulation, and its rows end in memory or in a file."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from functools import partial
from itertools import starmap
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rustchain.errors import SimulationError, attach
from rustchain.results.result import Result, Status
from rustchain.simulation.run import seconds_bar
from rustchain.typing import Array, FilePath

if TYPE_CHECKING:
    from rustchain.results.stream import Stream
    from rustchain.simulation.simulation import Simulation
    from rustchain.simulation.stop import Look

_BETWEEN_PIECES = 2.0  # [s] of wall time; with twice as many, a killed process loses more rows


class Piece(NamedTuple):
    """Numbers of rows that are written to a file at once.

    Attributes
    ----------
    chunk : int
        Rows of a chunk of the file; a piece has a multiple of it.
    most : int
        Rows in memory at which they are written.
    """

    chunk: int
    most: int


class Recording:
    """The recording of a run.

    Parameters
    ----------
    simulation : Simulation
        The simulation that runs.
    start : tuple of ndarray, (bodies, 3)
        Positions and velocities at the start of the run.
    before : dict
        Counts and times of the simulation then.
    """

    def __init__(
        self, simulation: Simulation, start: tuple[Array, Array], before: Mapping[str, float]
    ) -> None:
        self._simulation, self._core = simulation, simulation._core
        self._start, self._before = start, before
        self._stream: Stream | None = None
        self._piece, self._written = Piece(1, 1), 0.0
        self._taken: list[dict[str, Any]] = []
        self._end: tuple[Status, str, dict[str, Any]]  # status, message and stats in the file

    def stream_to(self, out: FilePath, piece: Piece) -> None:
        """Have the rows written to a file during the run."""
        from rustchain.results.stream import Stream  # with threads, which nothing else needs

        self._piece, self._written = piece, time.monotonic()
        empty = self._result_of(self._core.take_rows(0), "interrupted", "", {})
        self._stream = Stream(out, empty, piece.chunk)

    def run(self, duration: float, progress: bool, looks: Sequence[Look]) -> Result:
        """Advance to the end of the recording and return the result, as `Simulation.run`.

        What ends it otherwise, such as an exception of a callback or `SystemExit`, has the rows as
        ``result``; so has a warning that is raised.
        """
        try:
            try:
                reason = self._advance(duration, progress, looks)
                result = self.result("finished" if reason is None else "stopped", reason)
            except KeyboardInterrupt:
                result = self.result("interrupted")
        except BaseException as error:  # also Ctrl-C again, while the result is made
            told = str(error) if isinstance(error, SimulationError) else repr(error)
            status: Status = "failed" if isinstance(error, Exception) else "interrupted"
            attach(error, "result", self.result(status, told))
            raise
        self._core.take_recording()  # by which the energy balance of a file is judged, too
        try:
            self._simulation._warn()
        except Warning as warning:
            attach(warning, "result", result)
            raise
        return result

    def _advance(self, duration: float, progress: bool, looks: Sequence[Look]) -> str | None:
        """Advance to the end of the recording, or return why to stop at a report before it."""
        simulation, core = self._simulation, self._core
        start, rows = simulation.time, 0
        if looks:
            core.pause_at_reports()
        with seconds_bar(duration, progress) as bar:
            finished = False
            while not finished:
                finished = simulation._slice()
                bar.update(simulation.time - start - bar.n)
                if looks and core.rows != rows:
                    # All of them look: those that wait for something to last must not miss a row.
                    reasons = [reason for look in looks if (reason := look()) is not None]
                    if reasons:
                        return "; ".join(reasons)
                self._hand_over()
                rows = core.rows
        return None

    def _hand_over(self) -> None:
        """Have a piece written where memory is full or some time has passed."""
        chunk, most = self._piece
        while self._stream is not None and (rows := self._core.rows) >= chunk:
            if rows < most and time.monotonic() < self._written + _BETWEEN_PIECES:
                return
            count = min(rows - rows % chunk, most)
            self._stream.append(partial(self._core.take_rows, count), self._core.tooth_jumps)
            self._written = time.monotonic()

    def result(self, status: Status, reason: str | None = None) -> Result:
        """Return the result, with all rows.

        The file has one end. After an interrupt during `Stream.finish` it is that of the first
        call, and a later call returns the result of that one.
        """
        now = f"t = {self._simulation.time:.6g} s"
        messages = {
            "finished": f"reached {now}",
            "interrupted": f"interrupted at {now}",
            "stopped": f"stopped at {now}: {reason}",
            "failed": reason or "",
        }
        message, stats = messages[status], self._stats()
        if self._stream is None:
            if not self._taken:
                # No line of Python runs between the core and the list, so that Ctrl-C loses no row.
                self._taken.extend(starmap(self._core.take_recording, [()]))
            arrays = self._taken[0]
            if (residual := arrays.get("energy_residual")) is not None and residual.size:
                # The rows of a run that failed may end in what is no number.
                stats["largest_residual"] = float(np.nanmax(np.abs(residual), initial=0.0))
            return self._result_of(arrays, status, message, stats)
        energy = "energy_residual" in self._stream.channels

        def end(largest_residual: float) -> dict[str, Any]:
            if energy:
                stats["largest_residual"] = largest_residual
            states = {
                name: getattr(self._simulation, name).tolist()
                for name in ("positions", "velocities")
            }
            self._end = status, message, stats
            return {"status": status, "message": message, "stats": stats} | states

        try:
            self._stream.finish(self._core.take_rows, self._core.tooth_jumps, end)
        except Exception:
            if status != "failed":
                raise
            if energy:
                stats["largest_residual"] = self._stream.largest_residual
            self._end = status, message, stats
        return self._result_of(self._stream.arrays(), *self._end)

    def _stats(self) -> dict[str, float]:
        """Return the counts and times of this run."""
        return {name: n - self._before.get(name, 0) for name, n in self._core.stats().items()}

    def _result_of(
        self, arrays: Mapping[str, Any], status: Status, message: str, stats: dict[str, Any]
    ) -> Result:
        simulation = self._simulation
        return Result(
            arrays=arrays,
            scene=simulation.scene,
            body_names=tuple(simulation.body_names),
            joint_names=tuple(simulation.joint_names),
            contact_names=tuple(simulation.contact_names),
            initial_positions=self._start[0],
            initial_velocities=self._start[1],
            final_positions=simulation.positions,
            final_velocities=simulation.velocities,
            status=status,
            message=message,
            stats=stats,
            jumps=self._core.tooth_jumps(),
        )
