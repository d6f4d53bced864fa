"""Engagement impacts: force and place of each contact onset of a bushing on a sprocket."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rustchain.analysis.circuit import Circuit
from rustchain.analysis.guides import guide_number
from rustchain.analysis.loads import checked_sprocket, nearest_contact
from rustchain.analysis.window import rows_between
from rustchain.arguments import shown
from rustchain.errors import InvalidInput
from rustchain.typing import Array, Count, Number, Time

if TYPE_CHECKING:
    import numpy.typing as npt
    import pandas as pd

    from rustchain.results.result import Result

# Longest flight between two impacts of one engagement [pitches]. In a drive of 17 and 25 teeth with
# 0 to 100 N, flights in the wraps are below 0.5 at 120 rpm, 1.4 at 1000 rpm, 2.2 at 2000 rpm. Those
# along a strand are as long as it; those along a shorter strand are divided in the middle. Half or
# twice the value changes mean forces there by 0.3 % at most, a quarter by 10 % at 2000 rpm.
_FLIGHT = 3.0


def engagements(
    result: Result,
    /,
    sprocket: Count | str | None = None,
    *,
    within: Number = 0.5,
    start: Time = None,
    end: Time = None,
) -> pd.DataFrame:
    """Return a row for each contact onset of a bushing in a tooth gap or on a guide.

    Parameters
    ----------
    sprocket : int or str, optional
        Number of the sprocket, from 1, or the name of a guide: "guide_1". By default all sprockets,
        without guides, which have many contact onsets. The numbers of guides follow those of the
        sprockets, and ``tooth`` is 0 for the face, 1 for the back.
    within : float
        Length of the impact: the first so many pitches along the chain path.

    Returns
    -------
    DataFrame
        ``time`` [s] of the first report after the contact onset, from `start` to `end`;
        ``bushing``, ``sprocket``. ``tooth`` (gap from 0) and ``region`` are those of the first
        report that shows the contact. ``force`` [N] and ``impulse`` [N s] of the impact are from
        the peaks between reports. ``largest_force`` [N] and length ``pitches``, forward and back,
        are those of the contact episode. A bushing that returns to the same gap continues its
        episode, which needs a report that shows the contact. Of a result from `between`, a bushing
        that is in a wrap at the first row is taken to have begun before; with `start`, the rows
        before decide.
    """
    from rustchain.extras import pandas as pd

    found = impacts(result, sprocket, within, start, end)
    return pd.DataFrame(found, columns=list(Impact._fields)).sort_values("time", ignore_index=True)


class Impact(NamedTuple):
    """A row of `engagements`."""

    time: float
    bushing: int
    sprocket: int
    tooth: int
    region: int
    force: float
    impulse: float
    largest_force: float
    pitches: float


def impacts(
    result: Result, sprocket: Count | str | None, within: Number, start: Time, end: Time
) -> list[Impact]:
    """Return the rows of `engagements`, bushing by bushing."""
    if not within > 0.0:
        msg = f"within = {shown(within)}: must be a positive number of pitches"
        raise InvalidInput(msg)
    count = len(result.drive.sprockets)
    numbers: Sequence[int] = range(1, count + 1)
    if isinstance(sprocket, str) and sprocket.startswith("guide"):
        numbers = [count + guide_number(result, sprocket)]
    elif sprocket is not None:
        checked_sprocket(result, sprocket)
        numbers = [int(sprocket)]
    rows = rows_between(result, start, end)
    # Rows before `start` show which contacts are in the middle of their episode.
    nearest = nearest_contact(result)
    wheel, gap, region = (
        np.take_along_axis(result.array(f"tooth_{name}"), nearest, 0)
        for name in ("sprocket", "index", "region")
    )
    peak, impulse = (result.array(f"peak_tooth_{name}") for name in ("force", "impulse"))
    seen = result.array("tooth_sprocket") > 0
    time = result.time
    circuit = Circuit.of(result.drive)
    passed = np.append(0.0, np.cumsum(circuit.steps(result, slice(None))))
    engaged = _engaged_before(result)
    found, last_number = [], max(count, numbers[-1])
    for k in range(wheel.shape[1]):
        met = seen[:, k] | (peak[:, k] > 0.0)
        touching = np.flatnonzero(met & (wheel[:, k] > 0) & (wheel[:, k] <= last_number))
        if touching.size == 0:
            continue
        where = np.stack([wheel[touching, k], gap[touching, k]])
        changes = np.flatnonzero((np.diff(where) != 0).any(axis=0)) + 1
        for episode in np.split(touching, changes):
            first, last = _ends(episode, seen[episode, k], passed)
            begun = first == 0 or (episode[0] == touching[0] and engaged[k] == wheel[first, k])
            if begun or not rows.start <= first < rows.stop or wheel[first, k] not in numbers:
                continue  # the onset lies before the first row, or outside the evaluated part
            # The first row ends the interval in which the contact began.
            early = slice(first, _row_at(passed, first, within))
            whole = slice(first, last + 2)
            found.append(
                Impact(
                    time[first],
                    k + 1,
                    int(wheel[first, k]),
                    int(gap[first, k]),
                    int(region[first, k]),
                    peak[early, k].max(),
                    impulse[early, k].sum(),
                    peak[whole, k].max(),
                    passed[last] - passed[first],
                )
            )
    return found


def _ends(
    episode: npt.NDArray[np.intp], seen: npt.NDArray[np.bool_], passed: Array
) -> tuple[int, int]:
    """Return the first and the last row of a contact episode.

    `episode` are the rows with a force since the row before, or in contact (`seen`). An impact may
    be over before the next row, which then shows the bushing in flight. Before the first row in
    contact and behind the last one, impacts belong to the episode if no flight between them is
    longer than `_FLIGHT`.
    """
    flights = passed[episode[1:] - 1] - passed[episode[:-1]]
    long = np.flatnonzero(flights > _FLIGHT) + 1
    contact = np.flatnonzero(seen)
    begin = max(long[long <= contact[0]], default=0)
    end = min(long[long > contact[-1]], default=len(episode)) - 1
    first = int(episode[begin])
    # The row after the last contact ends the interval in which it ended.
    return first, max(int(episode[contact[-1]]), int(episode[end]) - 1, first)


def _engaged_before(result: Result) -> list[int]:
    """Return the sprocket, from 1, in whose wrap each bushing is at the first row; 0 for none.

    Such a bushing is in the middle of an episode, also if it is in flight. At the start of a run
    from other than given positions there is none.
    """
    circuit = Circuit.during(result, slice(0, 1))
    engaged = np.zeros(circuit.links, int)
    if result.time[0] > 0.0 or result.scene.positions is not None:
        here = circuit.positions(result)[0]
        for section in circuit.sections:
            if section.sprocket is not None:
                inside = (here - section.begin) % circuit.links <= section.end - section.begin
                engaged[inside] = section.sprocket
    return engaged.tolist()


def _row_at(passed: Array, first: int, within: Number) -> int:
    """Return the row, after `first`, at which the chain has gone on by `within` pitches since."""
    return first + int(np.searchsorted(passed[first:] - passed[first], within, "left"))
