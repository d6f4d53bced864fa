"""Normal force laws as values: an elastic part, a damping part, and how a tooth's regions join."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from rustchain._description import Description
from rustchain._names import known_keywords

Damping = Literal["lankarani-nikravesh"]
Regions = Literal["kept", "sharp"]


@dataclass(frozen=True)
class ForceLaw(Description):
    """What every force law has; choose one of its subclasses.

    Attributes
    ----------
    elastic : str
        Name of the elastic part.
    damping : {"lankarani-nikravesh", None}
        Restitution-based damping, or none.
    regions : {"kept", "sharp"}
        "kept": a contact keeps the stiffness of the tooth region where it began, which closes the
        energy balance. "sharp": the stiffness changes where the bushing crosses into another
        region.
    """

    elastic: ClassVar[Literal["hertz", "johnson", "enhanced-cylinder"]]

    damping: Damping | None = None
    regions: Regions = "kept"


@known_keywords
@dataclass(frozen=True)
class Hertz(ForceLaw):
    """Hertz's contact of spheres, undamped unless asked: (4/3) E* sqrt(Ri Rj / dR) delta^1.5."""

    elastic = "hertz"


@known_keywords
@dataclass(frozen=True)
class LankaraniNikravesh(ForceLaw):
    """Hertz's contact of spheres with the damping of Lankarani and Nikravesh (1990)."""

    elastic = "hertz"

    damping: Damping | None = "lankarani-nikravesh"


@known_keywords
@dataclass(frozen=True)
class Johnson(ForceLaw):
    """Johnson's contact of cylinders, implicit in the force; undamped unless asked."""

    elastic = "johnson"


@known_keywords
@dataclass(frozen=True)
class EnhancedCylinder(ForceLaw):
    """The enhanced cylindrical law of Pereira, Ramalho and Ambrosio, as published in 2010."""

    elastic = "enhanced-cylinder"

    damping: Damping | None = "lankarani-nikravesh"
