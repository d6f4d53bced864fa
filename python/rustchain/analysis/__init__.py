"""What engineers read from a run: loads, transmission, power, pressure, strands, impacts.

Each is a method of a `Result`; docs/outputs.md explains the numbers.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rustchain.analysis.of_loads import LoadOutputs
from rustchain.analysis.of_motion import MotionOutputs
from rustchain.names import known_keywords

if TYPE_CHECKING:
    from rustchain.analysis.summary import Summary
    from rustchain.results.result import Result


class Outputs(LoadOutputs, MotionOutputs):
    """The evaluations of a result.

    `start` and `end` [s] choose a part of the time, by default all of it. What comes back are
    xarray datasets with units in their attributes.
    """

    @known_keywords
    def between(self, start: float | None = None, end: float | None = None) -> Result:
        """Return the part of the result from `start` to `end` [s], as a result.

        States at ends that were not recorded are NaN. ``stats`` are those of the whole run.
        """
        from rustchain.analysis.window import between

        return between(self._result, start, end)

    @known_keywords
    def summary(self, *, start: float | None = None, end: float | None = None) -> Summary:
        """Return key figures of what was recorded, by name: the default measures of a study.

        A dict that prints as a table with units; ``.units`` has these.

        Efficiency and transmission errors are left out where the chain jumped teeth.
        """
        from rustchain.analysis.summary import summary

        return summary(self._result, start, end)
