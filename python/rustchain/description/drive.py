"""The description of a chain drive: frozen dataclasses in SI units."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

from rustchain.arguments import checked
from rustchain.description.base import Description, description
from rustchain.description.chain import Chain
from rustchain.description.ends import AnchoredEnd, FreeEnd, LoadedEnd
from rustchain.description.guides import GuideRail, SmoothIdler
from rustchain.description.report import DriveReport
from rustchain.description.sprocket import Sprocket
from rustchain.description.tensioner import Tensioner
from rustchain.html import HtmlView
from rustchain.typing import Point

if TYPE_CHECKING:
    from rustchain.description.laws.force import ForceLaw
    from rustchain.description.mechanism.builder import Mechanism

Hinges = Literal["clearance", "ideal"]


@description(frozen=True)
class ChainDrive(Description, HtmlView):
    """A closed chain on sprockets, or an open chain between two ends.

    Attributes
    ----------
    chain : Chain
        The chain.
    sprockets : sequence of Sprocket
        Sprockets in their order along the chain, in either direction. The first one is usually the
        driver.
    tensioner : Tensioner, optional
        Tensioner of one sprocket. Without it, the centres are fixed.
    gravity : (float, float)
        Acceleration of gravity [m/s^2].
    name : str
        Name for reports and figures.
    hinges : {"clearance", "ideal"}
        Pins with clearance in their bushings, or joints without clearance. Joints need rigid links,
        and have neither friction nor film.
    guides : sequence of GuideRail and SmoothIdler
        Rails, blades and smooth idlers. The initial configuration is generated without them: they
        begin beside the chain, and blades are swung back on their arms.
    ends : (end, end), optional
        Ends of an open chain, before its first link and behind its last one: each an `AnchoredEnd`,
        a `LoadedEnd` or a `FreeEnd`. By default the chain is closed. The first link of an open
        chain is an inner one. An open chain needs no sprocket; sprockets with the same `side` are
        on the same side of it.

    Examples
    --------
    >>> drive = rc.paper_drive(25.0)
    >>> print(str(drive.check()).splitlines()[0])
    chain                     38 links of 12.7000 mm
    """

    chain: Chain
    sprockets: Sequence[Sprocket]
    tensioner: Tensioner | None = None
    gravity: Point = (0.0, -9.81)
    name: str = ""
    hinges: Hinges = "clearance"
    guides: Sequence[GuideRail | SmoothIdler] = ()
    ends: Sequence[AnchoredEnd | LoadedEnd | FreeEnd] | None = None

    @property
    def hinge_count(self) -> int:
        """Number of hinges in arrays, which is that of the bodies before the sprockets.

        A closed chain has one a link. An open one has two more. Hinge `links` joins the last link
        and end 2, and the last one joins end 1 and the first link. The array entry between them is
        unused.
        """
        return self.chain.links + (0 if self.ends is None else 2)

    def check(self) -> DriveReport:
        """Generate the initial configuration and return its report, which prints as a table."""
        return DriveReport.of(self)

    @checked
    def to_mechanism(
        self,
        hinges: Hinges | None = None,
        force_law: ForceLaw | None = None,
        min_impact_velocity: float = 1e-3,
    ) -> Mechanism:
        """Return the drive in its initial configuration as a mechanism, which can be extended.

        Parameters
        ----------
        hinges : {"clearance", "ideal"}, optional
            Pins with clearance in their bushings, or ideal joints, whose reactions are the hinge
            forces; by default those of the drive.
        force_law : ForceLaw, optional
            Law of the contacts, by default that of Lankarani and Nikravesh.
        min_impact_velocity : float
            Lower bound on the initial impact velocity used by the damping factor [m/s].
        """
        from rustchain.description.mechanism.from_drive import drive_mechanism

        wanted = self.hinges if hinges is None else hinges
        return drive_mechanism(self, wanted, force_law, min_impact_velocity)
