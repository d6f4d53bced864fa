"""Methods of a result about motion and power: transmission, strands, spectra, efficiency."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rustchain.analysis.owner import Itself
from rustchain.names import known_keywords

if TYPE_CHECKING:
    import xarray as xr


_STATIONS = (0.25, 0.5, 0.75)


class MotionOutputs(Itself):
    """The evaluations of motion and power."""

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

        Raises
        ------
        InvalidInput
            The chain jumped teeth of one of them: the error then grows by a gap for each tooth.
        """
        from rustchain.analysis.transmission import transmission_error

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
        from rustchain.analysis.transmission import speed_ripple

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
            ``attrs``: ``span`` [s]; ``tooth_jumps``, how many teeth the chain jumped meanwhile.
        """
        from rustchain.analysis.power import power_balance

        return power_balance(self._result, start, end)

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
        from rustchain.analysis.strands import strand_motion

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
            How many natural frequencies to tell, at most the number of hinges.
        segment : float, optional
            Length of Welch's segments [s]; by default one segment, the finest resolution.

        Returns
        -------
        Dataset
            ``density`` [m^2/Hz], (station, frequency [Hz]): `scipy.signal.welch`, Hann's window.
            ``natural_frequency`` [Hz], (mode): of a string of rigid links between fixed ends, at
            the strand's mean tension and speed (`rustchain.analysis.strands.natural_frequencies`).
            ``attrs``: ``tension`` [N], ``speed`` [m/s], ``pitches``, ``tooth_frequency`` [Hz]: that
            of the engagements, pitches a second.
        """
        from rustchain.analysis.strands import strand_spectrum

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
        from rustchain.analysis.spectrum import spectrum

        return spectrum(self._result, name, segment, start, end)
