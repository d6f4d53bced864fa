"""Contacts of a mechanism: the methods of `Mechanism` that add them."""

from __future__ import annotations

from collections.abc import Sequence

from rustchain.arguments import shown
from rustchain.description.drive import Chain, Sprocket
from rustchain.description.mechanism.checks import arcs, point, rows
from rustchain.description.mechanism.parts import Contact, ContactLaw, Point, Rows
from rustchain.errors import InvalidInput
from rustchain.names import known_keywords


class WithContacts:
    """What a mechanism knows of its contacts."""

    contacts: list[Contact]

    @known_keywords
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
        """Let a pin of one body play in a bore of another [m]."""
        self.contacts.append(
            Contact(
                "bore",
                name,
                bore,
                pin,
                point("bore_point", "contact", name, bore_point),
                point("pin_point", "contact", name, pin_point),
                pin_radius,
                law,
                profile_radius=bore_radius,
            )
        )

    @known_keywords
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
        """Let two discs touch from outside [m]."""
        self.contacts.append(
            Contact(
                "disc",
                name,
                body_a,
                body_b,
                point("point_a", "contact", name, point_a),
                point("point_b", "contact", name, point_b),
                radius_b,
                law,
                profile_radius=radius_a,
            )
        )

    @known_keywords
    def add_outline_contact(
        self,
        name: str,
        outline: str,
        circle: str,
        points: Rows,
        radius: float,
        law: ContactLaw,
        circle_point: Point = (0.0, 0.0),
        bulges: Sequence[float] | None = None,
        closed: bool = True,
    ) -> None:
        """Let a circle of one body touch an outline on another.

        Parameters
        ----------
        points : sequence of (float, float)
            Corners in the frame of the body [m]; the material lies on the left of the way through
            them. Two points and ``closed=False`` make a segment.
        radius : float
            Of the circle [m].
        bulges : sequence of float, optional
            For each piece the tangent of a quarter of the angle of its arc: positive where the
            outline is convex, negative where it is concave, 0 for a straight line.
        closed : bool
            Whether the last point is joined to the first.
        """
        kind, pieces = "polyline", points
        rows(f"points of contact {shown(name)}", points, 2)
        if bulges is not None:
            kind, pieces = "arcs", arcs(name, points, bulges, closed)
        self.contacts.append(
            Contact(
                kind,
                name,
                outline,
                circle,
                (0.0, 0.0),
                point("circle_point", "contact", name, circle_point),
                radius,
                law,
                points=pieces,
                closed=closed,
            )
        )

    @known_keywords
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
        """Let a bushing of `chain` around a point of one body touch the teeth of another."""
        for field, given, kind in (("sprocket", sprocket, Sprocket), ("chain", chain, Chain)):
            if not isinstance(given, kind):
                msg = (
                    f"{field} of contact {shown(name)} = {shown(given)}: must be a {kind.__name__}"
                )
                raise InvalidInput(msg)
        self.contacts.append(
            Contact(
                "sprocket",
                name,
                wheel,
                circle,
                (0.0, 0.0),
                point("circle_point", "contact", name, circle_point),
                chain.contact_radius,
                law,
                sprocket=sprocket,
                chain=chain,
            )
        )
