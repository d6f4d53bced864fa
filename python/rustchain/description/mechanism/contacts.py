"""Contacts of a mechanism: the methods of `Mechanism` that add them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rustchain.arguments import shown
from rustchain.description.chain import Chain
from rustchain.description.mechanism.checks import arcs, point, rows
from rustchain.description.mechanism.parts import Contact, ContactLaw
from rustchain.description.sprocket import Sprocket
from rustchain.errors import InvalidInput
from rustchain.typing import Numbers, Point, Rows


class WithContacts:
    """Base of `Mechanism`: contacts."""

    contacts: Sequence[Contact]

    def add_clearance_joint(
        self,
        name: str,
        bore: str,
        pin: str,
        bore_radius: float,
        pin_radius: float,
        law: ContactLaw,
        bore_point: Point = (0.0, 0.0),
        pin_point: Point = (0.0, 0.0),
    ) -> None:
        """Add a pin of one body in a bore of another, with clearance.

        Parameters
        ----------
        name : str
            Name of the contact.
        bore, pin : str
            Names of the bodies that carry them; "ground" is the frame that does not move.
        bore_radius, pin_radius : float
            Radii of bore and pin [m]; their difference is the clearance.
        law : LinearContact, HuntCrossley or SurfaceContact
            Contact law.
        bore_point, pin_point : (float, float)
            Centres of bore and pin in the frames of their bodies [m]; by default the centres of
            mass. At the start their distance should be at most the clearance.
        """
        points = {"bore_point": bore_point, "pin_point": pin_point}
        round_profile = {"profile_radius": bore_radius}
        self._touch("bore", name, (bore, pin), points, pin_radius, law, **round_profile)

    def add_disc_contact(
        self,
        name: str,
        body_a: str,
        body_b: str,
        radius_a: float,
        radius_b: float,
        law: ContactLaw,
        point_a: Point = (0.0, 0.0),
        point_b: Point = (0.0, 0.0),
    ) -> None:
        """Add a contact of two discs, from outside.

        Parameters
        ----------
        name : str
            Name of the contact.
        body_a, body_b : str
            Names of the bodies that carry them.
        radius_a, radius_b : float
            Radii of the discs [m].
        law : LinearContact, HuntCrossley or SurfaceContact
            Contact law.
        point_a, point_b : (float, float)
            Centres of the discs in the frames of their bodies [m].
        """
        points = {"point_a": point_a, "point_b": point_b}
        round_profile = {"profile_radius": radius_a}
        self._touch("disc", name, (body_a, body_b), points, radius_b, law, **round_profile)

    def add_outline_contact(
        self,
        name: str,
        outline: str,
        circle: str,
        points: Rows,
        radius: float,
        law: ContactLaw,
        *,
        circle_point: Point = (0.0, 0.0),
        bulges: Numbers | None = None,
        closed: bool = True,
    ) -> None:
        """Add a contact of a circle on one body with an outline on another.

        Parameters
        ----------
        name : str
            Name of the contact.
        outline, circle : str
            Names of the bodies that carry them; "ground" is the frame that does not move.
        points : sequence of (float, float)
            Corners in the frame of the body [m]; the material lies on the left of the path
            through them. Two points and ``closed=False`` make a segment.
        radius : float
            Radius of the circle [m].
        law : LinearContact, HuntCrossley or SurfaceContact
            Contact law.
        circle_point : (float, float)
            Centre of the circle in the frame of its body [m].
        bulges : sequence of float, optional
            Shape of each piece: the tangent of a quarter of the angle of its arc. It is positive
            where the outline is convex, negative where it is concave, 0 for a straight line.
        closed : bool
            Whether the last point is joined to the first.
        """
        kind, pieces = "polyline", points
        rows(f"points of contact {shown(name)}", points, 2)
        if bulges is not None:
            kind, pieces = "arcs", arcs(name, points, bulges, closed)
        places, profile = {"circle_point": circle_point}, {"points": pieces, "closed": closed}
        self._touch(kind, name, (outline, circle), places, radius, law, **profile)

    def add_sprocket_contact(
        self,
        name: str,
        wheel: str,
        circle: str,
        sprocket: Sprocket,
        chain: Chain,
        law: ContactLaw,
        circle_point: Point = (0.0, 0.0),
    ) -> None:
        """Add a contact of a bushing of `chain` on one body with the teeth of another.

        Parameters
        ----------
        name : str
            Name of the contact.
        wheel, circle : str
            Names of the bodies that carry the teeth and the bushing.
        sprocket : Sprocket
            Sprocket with the number of teeth and the profile.
        chain : Chain
            Chain with the pitch and the radius of its bushings or rollers. Length and material of
            the contact are those of the law.
        law : LinearContact, HuntCrossley or SurfaceContact
            Contact law.
        circle_point : (float, float)
            Centre of the bushing in the frame of its body [m].
        """
        for field, given, kind in (("sprocket", sprocket, Sprocket), ("chain", chain, Chain)):
            if not isinstance(given, kind):
                msg = (
                    f"{field} of contact {shown(name)} = {shown(given)}: must be a {kind.__name__}"
                )
                raise InvalidInput(msg)
        places, radius = {"circle_point": circle_point}, chain.contact_radius
        profile: dict[str, Any] = {"sprocket": sprocket, "chain": chain}
        self._touch("sprocket", name, (wheel, circle), places, radius, law, **profile)

    def _touch(
        self,
        kind: str,
        name: str,
        bodies: tuple[str, str],
        places: Mapping[str, Point],
        radius: float,
        law: ContactLaw,
        **profile: Any,  # noqa: ANN401
    ) -> None:
        """Add a contact; of the places on both bodies, by name, the first may be left out."""
        at = [point(field, "contact", name, place) for field, place in places.items()]
        first, last = (at[0] if len(at) == 2 else (0.0, 0.0)), at[-1]
        made = Contact(kind, name, *bodies, radius, law, first, last, **profile)
        self.contacts = (*self.contacts, made)
