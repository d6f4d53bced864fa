"""Recorded groups, size of a record and progress of runs."""

from __future__ import annotations

import math
import os
import shutil
import sys
import time
import warnings
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np

from rustchain import extras
from rustchain.arguments import finite_number, items_within, shown
from rustchain.caller import log
from rustchain.errors import InvalidInput, MissingExtra
from rustchain.names import suggest
from rustchain.paths import path_of

if TYPE_CHECKING:
    from rustchain.description.drive import ChainDrive
    from rustchain.description.scene import Scene
    from rustchain.simulation.simulation import Simulation


Group = Literal["hinges", "teeth", "sprockets", "bodies", "joints", "contacts", "energy"]

GROUPS: dict[str, tuple[str, ...]] = {
    "drive": ("hinges", "teeth", "sprockets", "bodies", "energy"),
    "mechanism": ("bodies", "joints", "contacts", "energy"),
}
"""What can be recorded of each kind of scene; by default all but the bodies of a drive."""

_MOST_GROUPS = 100  # far more than there are; what has more may have no end
_MOST_ROWS = 1e9  # more are refused whatever they hold
_SHARE = 0.8  # of the memory for rows; the rest is for all other programs
_BETWEEN_LINES = 30.0  # [s] of wall time, so that a run of a minute has one line, one of days 100
WALL_BUDGET = 0.05  # [s] between looks at the keyboard and the progress bar


def known_groups(
    scene: Scene, record: Sequence[str] | None, energy: bool | None
) -> tuple[list[str], bool]:
    """Return the groups to record, each of which the scene must have, and whether energy is one."""
    known, mechanism = GROUPS[scene.kind], scene.kind == "mechanism"
    if record is None:
        groups: list[str] | None = [each for each in known if mechanism or each != "bodies"]
    elif isinstance(record, str):
        groups = [record]
    else:
        groups = items_within("record", record, _MOST_GROUPS)
    if groups is None:
        raise InvalidInput(f"record = {shown(record)}: must be a sequence of {', '.join(known)}")
    for group in groups:
        if not isinstance(group, str) or group not in known:
            msg = f"record: {shown(group)} is no group; {suggest(group, known)}"
            raise InvalidInput(msg)
    if energy is not None:
        check_truth("energy", energy)
    wanted = "energy" in groups if energy is None else bool(energy)
    return [group for group in groups if group != "energy"], wanted


def numbers_of_a_row(simulation: Simulation, groups: Sequence[str], energy: bool) -> int:
    """Return how many numbers a row of the result has, about."""
    scene, bodies = simulation.scene, len(simulation.body_names)
    joints, contacts = len(simulation.joint_names), len(simulation.contact_names)
    if scene.kind == "drive":
        return numbers_of_drive_row(scene.drive, groups, energy)
    each = {"bodies": 9 * bodies, "joints": 7 * joints, "contacts": 9 * contacts}
    return 1 + sum(each.get(group, 0) for group in groups) + (6 if energy else 0)


def numbers_of_drive_row(drive: ChainDrive, groups: Sequence[str], energy: bool) -> int:
    """Return how many numbers a row of the result of a drive has, about."""
    links, sprockets = drive.hinge_count, len(drive.sprockets)
    rollers = 0 if drive.chain.roller is None else links
    each = {"hinges": 10 * links + 9 * rollers, "teeth": 9 * links, "sprockets": 5 * sprockets}
    each["bodies"] = 6 * (links + rollers + sprockets + len(drive.guides))
    return 1 + sum(each.get(group, 0) for group in groups) + (6 if energy else 0)


def check_rows_fit(duration: object, report_step: object, numbers: int, out: object = None) -> None:
    """Refuse more rows of so many numbers each than memory holds, or the disc with the file `out`.

    Values that are no positive numbers, and names of files that are none, are refused elsewhere.
    """
    duration, report_step = finite_number(duration), finite_number(report_step)
    if duration is None or report_step is None or min(duration, report_step) <= 0.0:
        return
    rows, size = duration / report_step, 8 * numbers
    room = _SHARE * _memory() if out is None else _free_space(out)
    if rows <= _MOST_ROWS and rows * size > room:
        gigabytes = f"{room / 2**30:.3g} GiB"
        if out is None:
            limit, other = f"memory has {gigabytes} for them", "run it in pieces"
        else:
            limit, other = f"the disc has {gigabytes} free", "name a file on another disc"
        msg = (
            f"report_step = {report_step:g}: gives {rows:.3g} rows of {size} bytes in {duration:g} "
            f"s, {rows * size / 2**30:.3g} GiB, where {limit}: take "
            f"{duration * size / max(room, size):.1e} s or more, record less, or {other}"
        )
        raise InvalidInput(msg)


def _free_space(out: object) -> float:
    """Return the free space of the disc [bytes], with that of the file that `out` replaces."""
    try:
        path = path_of(out)
        replaced = path.stat().st_size if path.is_file() else 0
        return float(shutil.disk_usage(path.parent).free + replaced)
    except (InvalidInput, OSError):
        return math.inf


def _memory() -> float:
    """Return the memory of this machine [bytes]."""
    try:
        found = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):  # not everywhere
        found = 0
    return float(found) if found > 0 else 2.0**36


def check_truth(name: str, value: object) -> None:
    """Refuse what is neither True nor False."""
    if not isinstance(value, bool | np.bool_):
        raise InvalidInput(f"{name} = {shown(value)}: must be True or False")


def read_once(record: Any) -> Any:  # noqa: ANN401
    """Return the items of an iterator of groups, which several runs read; all else unchanged."""
    return items_within("record", record, _MOST_GROUPS) if isinstance(record, Iterator) else record


class Bar(Protocol):
    """A progress bar: what is done of its total."""

    n: float
    total: Any

    def update(self, n: float) -> object:
        """Count on."""

    def set_description(self, desc: str) -> None:
        """Name what is under way."""


class _NoBar:
    """Progress counter where no bar is shown."""

    def __init__(self, total: float = 0.0) -> None:
        self.n, self.total = 0.0, total

    def update(self, n: float) -> None:
        """Count on."""
        self.n += n

    def set_description(self, desc: str) -> None:
        """Do nothing."""


class _Lines(_NoBar):
    """Progress as lines on the standard error, where no terminal shows a bar."""

    def __init__(self, total: float, description: str | None) -> None:
        super().__init__(total)
        self._description = description or "run"
        self._start = self._written = time.monotonic()
        self._counted = 0.0

    def update(self, n: float) -> None:
        """Count on; write a line where enough time has passed and enough is done."""
        super().update(n)
        now = time.monotonic()
        if now - self._written < _BETWEEN_LINES or self.n - self._counted < 0.01 * self.total:
            return
        self._written, self._counted = now, self.n
        share = f" ({self.n / self.total:.0%})" if self.total > 0.0 else ""
        line = (
            f"{self._description}: {self.n:.4f} of {self.total:.4f} s simulated{share} "
            f"in {now - self._start:.0f} s"
        )
        with suppress(OSError, ValueError):  # closed by whoever read it
            print(line, file=sys.stderr, flush=True)

    def set_description(self, desc: str) -> None:
        """Name what is under way."""
        self._description = desc


@contextmanager
def seconds_bar(total: float, progress: bool, description: str | None = None) -> Iterator[Bar]:
    """Give a bar of simulated seconds [s], and log start and end of the run or sweep.

    A notebook shows a widget. Without a terminal or without tqdm there are lines.
    """
    what = "run" if description is None else "sweep"
    log.info("%s of %.6g s starts", what, total)
    with _bar(total, description) if progress else nullcontext(_NoBar()) as bar:
        try:
            yield bar
        except BaseException as error:
            log.info("%s ended after %.6g of %.6g s: %r", what, bar.n, total, error)
            raise
    log.info("%s ended after %.6g of %.6g s", what, bar.n, total)


def _bar(total: float, description: str | None) -> AbstractContextManager[Bar]:
    """Return a progress bar, or lines where there is no tqdm or neither terminal nor notebook."""
    if sys.stderr is None:  # of a program without a console
        return nullcontext(_NoBar(total))
    lines = nullcontext(_Lines(total, description))
    try:
        with warnings.catch_warnings():
            # A notebook without ipywidgets has a bar of text, which needs no warning.
            warnings.filterwarnings("ignore", "IProgress not found")
            tqdm = extras.auto.tqdm
    except MissingExtra:
        return lines
    form = "{l_bar}{bar}| {n:.4f}/{total:.4f} s simulated [{elapsed}<{remaining}, {rate_noinv_fmt}]"
    bar = tqdm(desc=description, total=total, unit=" s", bar_format=form, disable=None)
    return lines if bar.disable else bar
