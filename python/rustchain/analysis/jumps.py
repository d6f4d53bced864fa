"""Tooth jumps of a run, and the outputs that hold only while the chain remains in its gaps."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np

from rustchain.analysis.window import rows_between
from rustchain.errors import InvalidInput, NotRecorded
from rustchain.typing import Array, Time

if TYPE_CHECKING:
    import pandas as pd

    from rustchain.results.result import Result
    from rustchain.results.views import Jumps


def tooth_jumps(result: Result) -> pd.DataFrame:
    """Return the table that `Result.tooth_jumps` describes."""
    from rustchain.extras import pandas as pd

    jumps = jumps_within(result)
    if jumps is None:
        msg = "tooth_jumps: not counted in this run; expected a drive, run or saved by this version"
        raise NotRecorded(msg)
    return pd.DataFrame(dict(zip(("time", "sprocket", "direction"), jumps, strict=True)))


def jumps_within(result: Result, start: Time = None, end: Time = None) -> Jumps | None:
    """Return times, sprockets and directions of the jumps in a part of a run; None: not counted."""
    if result.jumps is None:
        return None
    recorded = result.time[rows_between(result, start, end)]
    time, sprocket, direction = result.jumps
    within = (time > recorded[0]) & (time <= recorded[-1])
    return time[within], sprocket[within], direction[within]


def check_seated(
    result: Result,
    output: str,
    start: Time,
    end: Time,
    sprockets: Collection[int] | None = None,
) -> None:
    """Raise where the chain jumped teeth of these sprockets, by default of any."""
    if (jumps := jumps_within(result, start, end)) is None:
        return
    time, sprocket, _ = jumps
    counts = slice(None) if sprockets is None else np.isin(sprocket, list(sprockets))
    time, sprocket = time[counts], sprocket[counts]
    if len(time):
        teeth = "tooth" if len(time) == 1 else "teeth"
        msg = (
            f"{output}: the chain jumped {len(time)} {teeth} in this part of the run, first on "
            f"sprocket {sprocket[0]} at t = {time[0]:.6g} s; expected a chain that "
            "remains in its gaps; take a part between two jumps, see Result.tooth_jumps"
        )
        raise InvalidInput(msg)


def teeth_jumped(result: Result, sprocket: int) -> Array:
    """Return how many teeth a sprocket has turned counterclockwise against the chain, (times,)."""
    if result.jumps is None:
        return np.zeros(len(result.time))
    time, _, direction = (column[result.jumps[1] == sprocket] for column in result.jumps)
    total = np.concatenate([[0.0], np.cumsum(direction)])
    jumped: Array = total[np.searchsorted(time, result.time, "right")]
    return jumped
