"""Tooth jumps of a run, and the outputs that hold only while the chain stays in its gaps."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np

from rustchain.errors import InvalidInput, NotRecorded

if TYPE_CHECKING:
    import pandas as pd

    from rustchain.results.result import Result
    from rustchain.typing import Array


def tooth_jumps(result: Result) -> pd.DataFrame:
    """Return the table that `Result.tooth_jumps` describes."""
    from rustchain.extras import pandas as pd

    if result.jumps is None:
        msg = (
            "tooth_jumps: not counted in this run; expected a drive with hinges='clearance', run "
            "or saved by this version"
        )
        raise NotRecorded(msg)
    time, sprocket, direction = result.jumps
    within = (time > result.time[0]) & (time <= result.time[-1])
    columns = {"time": time, "sprocket": sprocket, "direction": direction}
    return pd.DataFrame({name: values[within] for name, values in columns.items()})


def check_seated(result: Result, output: str, sprockets: Collection[int] | None = None) -> None:
    """Raise where the chain jumped teeth of these sprockets, by default of any."""
    if result.jumps is None:
        return
    jumps = tooth_jumps(result)
    if sprockets is not None:
        jumps = jumps[jumps["sprocket"].isin(list(sprockets))]
    if len(jumps):
        first = jumps.iloc[0]
        teeth = "tooth" if len(jumps) == 1 else "teeth"
        msg = (
            f"{output}: the chain jumped {len(jumps)} {teeth} in this part of the run, first on "
            f"sprocket {first['sprocket']:.0f} at t = {first['time']:.6g} s; expected a chain that "
            "stays in its gaps; take a part between two jumps, see Result.tooth_jumps"
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
