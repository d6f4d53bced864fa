"""Post-processing of runs: loads, transmission, power, pressure, strands, impacts.

Each function is a method of a `Result`; docs/reference/outputs.md explains the numbers.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from rustchain.analysis import (
    engagement,
    guides,
    jumps,
    loads,
    power,
    pressure,
    spectrum,
    strands,
    summary,
    transmission,
    window,
)

if TYPE_CHECKING:
    import pandas as pd

    from rustchain.results.result import Result


class Outputs:
    """The evaluations of a result.

    `start` and `end` [s] choose a part of the time, by default all of it. Most return xarray
    datasets or arrays with units in their attributes, some a pandas table or a number.
    """

    between = window.between
    summary = summary.summary
    link_tension = strands.link_tension
    hinge_loads = loads.hinge_loads
    tooth_loads = loads.tooth_loads
    wrap_loads = loads.wrap_loads
    guide_loads = guides.guide_loads
    contact_pressure = pressure.contact_pressure
    pressure_cycles = pressure.pressure_cycles
    engagements = engagement.engagements
    transmission_error = transmission.transmission_error
    speed_ripple = transmission.speed_ripple
    power_balance = power.power_balance
    efficiency = power.efficiency
    strand_motion = strands.strand_motion
    strand_spectrum = strands.strand_spectrum
    spectrum = spectrum.spectrum

    @property
    def tooth_jumps(self) -> pd.DataFrame:
        """The jumps of the chain over teeth in this run, a row for each tooth.

        Columns are ``time`` [s], ``sprocket``, from 1, and ``direction``, 1 where the sprocket has
        turned counterclockwise by a tooth against the chain, -1 clockwise. The time is the end of
        the first step after which all seated bushings of the sprocket are in other gaps than
        before. A bushing is seated where its centre is less than halfway from the pitch circle to
        where it passes over the tips.

        Raises
        ------
        NotRecorded
            The scene is a mechanism: jumps are not counted.
        """
        return jumps.tooth_jumps(cast("Result", self))
