"""Methods of a result about loads: tension, hinges, teeth, pressure, impacts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

from rustchain.analysis.owner import Itself
from rustchain.names import known_keywords

if TYPE_CHECKING:
    from typing import TypeAlias

    import pandas as pd
    import xarray as xr

    SprocketNumber: TypeAlias = int
else:  # left to `check_sprocket`, which tells what answers the name of a guide
    SprocketNumber = object


_QUANTILES = (0.05, 0.5, 0.95)


class LoadOutputs(Itself):
    """The evaluations of loads."""

    @known_keywords
    def link_tension(self, *, start: float | None = None, end: float | None = None) -> xr.DataArray:
        """Return the pull in the chain at every hinge [N], (time, hinge).

        The component along the chain of the force between the two links of the hinge. It holds the
        part mu v^2 of the chain's own motion. Needs hinges and bodies recorded.
        """
        from rustchain.analysis.strands import link_tension

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
            How finely the chain's way is divided, 1 to 1000.

        Returns
        -------
        Dataset
            Over ``position``, how far a hinge has gone round [pitches] from the first seat of
            sprocket 1 at the start, counterclockwise (``section`` names sprocket or strand):
            ``mean`` [N], from the impulses; ``quantiles`` [N] of the force at the reports;
            ``largest`` [N], peaks between reports included; NaN where no hinge has been. Over
            ``hinge``: ``hinge_mean``, ``hinge_quantiles``, ``hinge_largest`` [N].
        """
        from rustchain.analysis.loads import hinge_loads

        return hinge_loads(self._result, quantiles, bins_per_pitch, start, end)

    @known_keywords
    def tooth_loads(
        self,
        sprocket: SprocketNumber = 1,
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
        from rustchain.analysis.loads import tooth_loads

        return tooth_loads(self._result, sprocket, quantiles, bins_per_pitch, start, end)

    @known_keywords
    def wrap_loads(
        self,
        sprocket: SprocketNumber = 1,
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
        from rustchain.analysis.loads import wrap_loads

        return wrap_loads(self._result, sprocket, quantiles, bins_per_pitch, start, end)

    @known_keywords
    def guide_loads(
        self,
        guide: int | str = 1,
        *,
        quantiles: Sequence[float] = _QUANTILES,
        bins_per_pitch: int = 4,
        start: float | None = None,
        end: float | None = None,
    ) -> xr.Dataset:
        """Return the load of a rail, a blade, a shoe or a smooth idler.

        Parameters
        ----------
        guide : int or str
            Number of the guide, from 1, or its name: "guide_1".
        quantiles, bins_per_pitch
            As in `hinge_loads`.

        Returns
        -------
        Dataset
            Over ``position``, the place of a bushing [pitches] from where the chain passed the
            guide's middle at the start of the run, counterclockwise: ``mean``, ``quantiles``,
            ``largest`` [N] of the force of each bushing that passes, as in `hinge_loads`. Over
            ``bushing``: ``bushing_mean``, ``bushing_largest`` [N]. Over ``time``: ``force`` [N],
            the sum of the forces' sizes at the reports, and ``bushings``, how many bear.
            ``attrs["mean_force"]`` is the mean of that sum [N], from the impulses. The angle of a
            blade's arm is that of `Result.guide`.
        """
        from rustchain.analysis.guides import guide_loads

        return guide_loads(self._result, guide, quantiles, bins_per_pitch, start, end)

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
        from rustchain.analysis.pressure import contact_pressure

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
            Number of classes of the range, from 0 to the largest; 1 to 1000.

        Returns
        -------
        Dataset
            ``cycles`` per revolution, (hinge, bushing or tooth; range [Pa]), and ``largest`` [Pa].
        """
        from rustchain.analysis.pressure import pressure_cycles

        return pressure_cycles(self._result, contact, sprocket, bins, start, end)

    @known_keywords
    def engagements(
        self,
        sprocket: int | str | None = None,
        *,
        within: float = 0.5,
        start: float | None = None,
        end: float | None = None,
    ) -> pd.DataFrame:
        """Return a row for each time that a bushing came into a tooth gap, or onto a guide.

        Parameters
        ----------
        sprocket : int or str, optional
            Number of the sprocket, from 1, or the name of a guide: "guide_1". By default all
            sprockets, without guides, on which bushings dance; a guide has the number behind the
            sprockets', and for ``tooth`` 0: its face, 1: its back.
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
        from rustchain.analysis.engagement import engagements

        return engagements(self._result, sprocket, within, start, end)
