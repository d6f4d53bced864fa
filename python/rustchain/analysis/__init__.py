"""Post-processing of runs: loads, transmission, power, pressure, strands, impacts.

Each function is a method of a `Result`; docs/reference/outputs.md explains the numbers.
"""

from __future__ import annotations

from rustchain.analysis import (
    engagement,
    guides,
    loads,
    power,
    pressure,
    spectrum,
    strands,
    summary,
    transmission,
    window,
)


class Outputs:
    """The evaluations of a result.

    `start` and `end` [s] choose a part of the time, by default all of it. What comes back are
    xarray datasets with units in their attributes.
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
    strand_motion = strands.strand_motion
    strand_spectrum = strands.strand_spectrum
    spectrum = spectrum.spectrum
