"""What engineers read from a run: loads, transmission, power, pressure, strands, impacts.

Each is a method of a `Result`; docs/outputs.md explains the numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, cast

from rustchain._names import known_keywords

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from rustchain.result import Result

_QUANTILES = (0.05, 0.5, 0.95)
_STATIONS = (0.25, 0.5, 0.75)


class Outputs:
    """The evaluations of a result.

    `start` and `end` [s] choose a part of the time, by default all of it. What comes back are
    xarray datasets with units in their attributes.
    """

    @known_keywords
    def between(self, start: float | None = None, end: float | None = None) -> Result:
        """Return the part of the result from `start` to `end` [s], as a result.

        States at ends that were not recorded are NaN. ``stats`` are those of the whole run.
        """
        from rustchain.outputs.window import between

        return between(self._result, start, end)

    @known_keywords
    def link_tension(self, *, start: float | None = None, end: float | None = None) -> xr.DataArray:
        """Return the pull in the chain at every hinge [N], (time, hinge).

        The component along the chain of the force between the two links of the hinge. It holds the
        part mu v^2 of the chain's own motion. Needs hinges and bodies recorded.
        """
        from rustchain.outputs.strands import link_tension

        return link_tension(self._result, start, end)

    @known_keywords
    def hinge_loads(
        self,
        *,
        quantiles: Sequence[float] = _QUANTILES,
        bins_per_pitch: int = 4,
        start: float | None = None,
        end: float | None = None,
    ) -> xr.Dataset:
        """Return the load of the hinges over a revolution of the chain, and that of each hinge.

        Parameters
        ----------
        quantiles : sequence of float
            Shares, 0 to 1, of the reports that lie below the values of ``quantiles``.
        bins_per_pitch : int
            How finely the chain's way is divided.

        Returns
        -------
        Dataset
            Over ``position``, how far a hinge has gone round [pitches] from the first seat of
            sprocket 1 at the start, counterclockwise (``section`` names sprocket or strand):
            ``mean`` [N], from the impulses; ``quantiles`` [N] of the force at the reports;
            ``largest`` [N], peaks between reports included. Over ``hinge``: ``hinge_mean``,
            ``hinge_quantiles``, ``hinge_largest`` [N].
        """
        from rustchain.outputs.loads import hinge_loads

        return hinge_loads(self._result, quantiles, bins_per_pitch, start, end)

    @known_keywords
    def tooth_loads(
        self,
        sprocket: int = 1,
        *,
        quantiles: Sequence[float] = _QUANTILES,
        bins_per_pitch: int = 4,
        start: float | None = None,
        end: float | None = None,
    ) -> xr.Dataset:
        """Return the load of a sprocket's teeth over its revolution, and that of each tooth.

        A gap counts as the tooth: gap k, from 0, and what bears on either of its flanks.

        Parameters
        ----------
        sprocket : int
            Number of the sprocket, from 1.
        quantiles, bins_per_pitch
            As in `hinge_loads`.

        Returns
        -------
        Dataset
            Over ``angle`` [rad], the direction of a gap seen from the centre, from x
            counterclockwise: ``mean``, ``quantiles``, ``largest`` [N] as in `hinge_loads`, of all
            gaps that pass there, loaded or not. Over ``tooth``: ``tooth_mean``, ``tooth_largest``
            [N].
        """
        from rustchain.outputs.loads import tooth_loads

        return tooth_loads(self._result, sprocket, quantiles, bins_per_pitch, start, end)

    @known_keywords
    def wrap_loads(
        self,
        sprocket: int = 1,
        *,
        quantiles: Sequence[float] = _QUANTILES,
        bins_per_pitch: int = 4,
        start: float | None = None,
        end: float | None = None,
    ) -> xr.Dataset:
        """Return how the load is distributed along the wrap of a sprocket.

        Parameters
        ----------
        sprocket : int
            Number of the sprocket, from 1.
        quantiles, bins_per_pitch
            As in `hinge_loads`.

        Returns
        -------
        Dataset
            Over ``position``, the place of a bushing in the wrap [pitches] from where the belt line
            meets the pitch circle, counterclockwise: ``mean``, ``quantiles``, ``largest`` [N] of
            the tooth force, as in `hinge_loads`, and ``hinge_mean`` [N], the mean hinge force
            there. ``attrs["wrap"]`` is the length of the wrap [pitches].
        """
        from rustchain.outputs.loads import wrap_loads

        return wrap_loads(self._result, sprocket, quantiles, bins_per_pitch, start, end)

    @known_keywords
    def transmission_error(
        self,
        driven: int = 2,
        driver: int = 1,
        *,
        start: float | None = None,
        end: float | None = None,
    ) -> xr.Dataset:
        """Return by how much a sprocket leads or lags the ratio of the teeth.

        Parameters
        ----------
        driven, driver : int
            Numbers of the sprockets, from 1.

        Returns
        -------
        Dataset
            Over ``time``: ``error`` [rad] of the driven sprocket, its mean taken off;
            ``error_length`` [m], the same at the pitch radius; ``driver_angle`` [rad] turned. Over
            ``order``, cycles per revolution of the driver: ``amplitude`` [rad] (Hann's window).
            ``attrs``: ``peak_to_peak`` [rad], ``peak_to_peak_length`` [m], ``ratio``,
            ``tooth_order``.
        """
        from rustchain.outputs.transmission import transmission_error

        return transmission_error(self._result, driven, driver, start, end)

    @known_keywords
    def speed_ripple(
        self, sprocket: int = 2, *, start: float | None = None, end: float | None = None
    ) -> xr.Dataset:
        """Return how unevenly a sprocket turns.

        Parameters
        ----------
        sprocket : int
            Number of the sprocket, from 1.

        Returns
        -------
        Dataset
            Over ``time``: ``speed`` [rad/s], ``ripple`` = speed / mean - 1. Over ``order``, cycles
            per revolution of the sprocket: ``amplitude`` of the ripple. ``attrs``: ``mean``
            [rad/s], ``rms``, ``peak_to_peak``, ``tooth_order``.
        """
        from rustchain.outputs.transmission import speed_ripple

        return speed_ripple(self._result, sprocket, start, end)

    @known_keywords
    def power_balance(self, *, start: float | None = None, end: float | None = None) -> xr.Dataset:
        """Return where the power comes from and goes to, on average, and the efficiency.

        Needs sprockets and the energy balance recorded.

        Returns
        -------
        Dataset
            ``shaft_power`` [W], (sprocket): into the drive positive. ``loss`` [W], (channel):
            dissipated power by channel, contacts and whatever other channels the run kept.
            ``stored`` [W], (store): growth of kinetic, gravity and elastic energy. ``residual``
            [W]: what the energy balance misses. ``efficiency``: power delivered by the shafts over
            power delivered and lost, NaN where nothing is delivered; growth of stored energy does
            not enter. The power of the only motor of prescribed speed holds the tensioner's work.
        """
        from rustchain.outputs.power import power_balance

        return power_balance(self._result, start, end)

    @known_keywords
    def contact_pressure(
        self,
        contact: Literal["hinge", "tooth"] = "hinge",
        *,
        start: float | None = None,
        end: float | None = None,
    ) -> xr.Dataset:
        """Return the largest pressure in each contact by Hertz's line contact.

        p = sqrt(F E* k / (pi L)), half width b = sqrt(4 F / (pi L E* k)) (Johnson, Contact
        Mechanics, 4.2c): F the force, L the length of contact, 1/E* = 2 (1 - nu^2)/E, k the sum of
        the curvatures, which for a tooth is that of the surface in contact. It holds while b is
        small beside the radii, whatever law gave the force.

        Parameters
        ----------
        contact : {"hinge", "tooth"}
            Pins in bushings, or bushings on teeth.

        Returns
        -------
        Dataset
            ``pressure`` [Pa] and ``half_width`` [m] at the reports, ``peak_pressure`` [Pa] of the
            largest force since the report before; (time, hinge) or (time, bushing).
        """
        from rustchain.outputs.pressure import contact_pressure

        return contact_pressure(self._result, contact, start, end)

    @known_keywords
    def pressure_cycles(
        self,
        contact: Literal["hinge", "tooth"] = "hinge",
        sprocket: int | None = None,
        *,
        bins: int = 20,
        start: float | None = None,
        end: float | None = None,
    ) -> xr.Dataset:
        """Return how many cycles of contact pressure a part sees per revolution, by range.

        Rainflow counting (ASTM E1049-85) of the pressures at the reports and the peaks between
        them; swings below a hundredth of the largest are left out. A contact that opens and closes
        twice between two reports counts once.

        Parameters
        ----------
        contact : {"hinge", "tooth"}
            Pins in bushings, or bushings on teeth.
        sprocket : int, optional
            With "tooth": count in the gaps of this sprocket, per revolution of it; by default on
            the bushings, per revolution of the chain.
        bins : int
            Number of classes of the range, from 0 to the largest.

        Returns
        -------
        Dataset
            ``cycles`` per revolution, (hinge, bushing or tooth; range [Pa]), and ``largest`` [Pa].
        """
        from rustchain.outputs.pressure import pressure_cycles

        return pressure_cycles(self._result, contact, sprocket, bins, start, end)

    @known_keywords
    def strand_motion(
        self,
        strand: str | int,
        *,
        stations: Sequence[float] = _STATIONS,
        start: float | None = None,
        end: float | None = None,
    ) -> xr.DataArray:
        """Return how far a strand is off its straight line [m], (time, station).

        Positive away from the inside of the loop. Needs sprockets and bodies recorded.

        Parameters
        ----------
        strand : str or int
            Its name in `strand_names`, or its number there, from 1.
        stations : sequence of float
            Where to look, fixed in space: shares of the way between the tangent points of the pitch
            circles, from where a counterclockwise chain leaves its sprocket.
        """
        from rustchain.outputs.strands import strand_motion

        return strand_motion(self._result, strand, stations, start, end)

    @known_keywords
    def strand_spectrum(
        self,
        strand: str | int,
        *,
        stations: Sequence[float] = _STATIONS,
        modes: int = 3,
        segment: float | None = None,
        start: float | None = None,
        end: float | None = None,
    ) -> xr.Dataset:
        """Return the spectrum of a strand's transverse motion, and its natural frequencies.

        Needs hinges, sprockets and bodies recorded.

        Parameters
        ----------
        strand, stations
            As in `strand_motion`.
        modes : int
            How many natural frequencies to tell.
        segment : float, optional
            Length of Welch's segments [s]; by default one segment, the finest resolution.

        Returns
        -------
        Dataset
            ``density`` [m^2/Hz], (station, frequency [Hz]): `scipy.signal.welch`, Hann's window.
            ``natural_frequency`` [Hz], (mode): of a string of rigid links between fixed ends, at
            the strand's mean tension and speed (`rustchain.outputs.strands.natural_frequencies`).
            ``attrs``: ``tension`` [N], ``speed`` [m/s], ``pitches``.
        """
        from rustchain.outputs.strands import strand_spectrum

        return strand_spectrum(self._result, strand, stations, modes, segment, start, end)

    @known_keywords
    def spectrum(
        self,
        name: str,
        *,
        segment: float | None = None,
        start: float | None = None,
        end: float | None = None,
    ) -> xr.DataArray:
        """Return the power spectral density of a recorded array, (..., frequency [Hz]).

        `scipy.signal.welch`: Hann's window, straight lines taken off. Of two rows 1e-4 s apart,
        what vibrates faster than 5 kHz, as contacts do, is folded down.

        Parameters
        ----------
        name : str
            Name in `arrays`, such as "strand_tension" or "sprocket_speed".
        segment : float, optional
            Length of the segments [s] that are averaged; by default one segment, the finest
            resolution.
        """
        from rustchain.outputs.spectrum import spectrum

        return spectrum(self._result, name, segment, start, end)

    @known_keywords
    def engagements(
        self,
        sprocket: int | None = None,
        *,
        within: float = 0.5,
        start: float | None = None,
        end: float | None = None,
    ) -> pd.DataFrame:
        """Return a row for each time that a bushing came into a tooth gap.

        Parameters
        ----------
        sprocket : int, optional
            Number of the sprocket, from 1; by default all.
        within : float
            What counts as the impact: the first so many pitches of the chain's way.

        Returns
        -------
        DataFrame
            ``time`` [s] of the report that first shows the contact, ``bushing``, ``sprocket``,
            ``tooth`` (gap from 0), ``region``; ``force`` [N] and ``impulse`` [N s] of the impact,
            from the peaks between reports; ``largest_force`` [N] and length ``pitches`` of the
            stay.
        """
        from rustchain.outputs.engagement import engagements

        return engagements(self._result, sprocket, within, start, end)

    @known_keywords
    def summary(self, *, start: float | None = None, end: float | None = None) -> dict[str, float]:
        """Return key figures of what was recorded, by name: the default measures of a study."""
        from rustchain.outputs.summary import summary

        return summary(self._result, start, end)

    @property
    def _result(self) -> Result:
        """The result itself, by its own type."""
        return cast("Result", self)
