"""Normal force laws as values: an elastic part, a damping part, and how a tooth's regions join."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, Literal

import numpy as np
import numpy.typing as npt

from rustchain import _rustchain
from rustchain.arguments import checked
from rustchain.description.base import Description, description
from rustchain.description.laws.film import LubricantFilm
from rustchain.description.laws.friction import Coulomb, LuGre
from rustchain.description.material import Material
from rustchain.typing import Pair

Damping = Literal[
    "lankarani-nikravesh",
    "hunt-crossley",
    "herbert-mcwhannell",
    "lee-wang",
    "flores",
    "gonthier",
    "hu-guo",
    "zhiying-qishao",
]
Regions = Literal["kept", "sharp"]
Surfaces = Literal["internal", "external", "flat"]


@dataclass(frozen=True)
class ForceLaw(Description):
    """Common base of the force laws; choose one of its subclasses.

    Attributes
    ----------
    elastic : str
        Name of the elastic part.
    damping : str, optional
        Restitution-based damping, with any elastic part: "lankarani-nikravesh", "hunt-crossley",
        "herbert-mcwhannell", "lee-wang", "flores", "gonthier", "hu-guo" or "zhiying-qishao". None:
        the contact is elastic. `effective_restitution` gives the restitution of an impact for that
        of the material; "flores", "gonthier" and "hu-guo" divide by it and take 0.01 or more.
    regions : {"kept", "sharp"}
        "kept": a contact keeps the stiffness of the tooth region where it began, which closes the
        energy balance. "sharp": the stiffness changes where the bushing crosses into another
        region; under load, energy is not conserved there, at any accuracy. Mechanisms take "kept"
        alone.
    friction : Coulomb or LuGre, optional
        Friction of the contacts that have this law, in chain drives with clearance hinges and in
        mechanisms. None: there is none, and it costs nothing.
    film : LubricantFilm, optional
        Lubricant of the hinges or clearance joints that have this law; no other contact has one.
    """

    elastic: ClassVar[
        Literal[
            "hertz",
            "johnson",
            "enhanced-cylinder",
            "hertz-cylinder",
            "radzimovsky",
            "esdu-78035",
            "liu-conformal",
            "linear",
        ]
    ]

    # What a law takes from the surfaces in contact.
    _elsewhere: ClassVar[dict[str, str]] = dict.fromkeys(
        ("material", "restitution", "elastic_modulus", "poisson_ratio"),
        "it is a field of Material: the chain or a SurfaceContact has one",
    )

    damping: Damping | None = None
    regions: Regions = "kept"
    friction: Coulomb | LuGre | None = field(default=None, kw_only=True)
    film: LubricantFilm | None = field(default=None, kw_only=True)

    @checked
    def elastic_force(
        self,
        penetration: npt.ArrayLike,
        radii: Pair,
        length: float,
        surfaces: Surfaces = "internal",
        material: Material | None = None,
    ) -> npt.NDArray[np.float64]:
        """Return the elastic force [N] of two cylinders at a penetration.

        Past the end of a law's range it is the force with which a run continues: that of the
        secant's stiffness (see the page on force laws). No warning is given.

        Parameters
        ----------
        penetration : array_like
            [m], any shape; no force at zero and below.
        radii : (float, float)
            Radius of the cylinder [m], and that of its bore ("internal"), of the other cylinder
            ("external"), or of the convex curve next to the flat ("flat").
        length : float
            Length of contact [m].
        surfaces : {"internal", "external", "flat"}
            What the second radius is of.
        material : Material, optional
            Of both; by default the published drive's steel.

        Raises
        ------
        InvalidInput
            A radius, the length, or the kind of surfaces is not allowed.

        Examples
        --------
        >>> round(float(rc.Johnson().elastic_force(1e-6, (2.22e-3, 2.245e-3), 0.011)), 1)
        746.3
        """
        depth = np.asarray(penetration, dtype=np.float64)
        radius_i, radius_j = radii
        force = _rustchain.law_force(
            self,
            surfaces,
            radius_i,
            radius_j,
            length,
            Material() if material is None else material,
            np.ascontiguousarray(depth.ravel()),
        )
        return force.reshape(depth.shape)


@description(frozen=True)
class Hertz(ForceLaw):
    """Hertz's contact of spheres, undamped by default: (4/3) E* sqrt(Ri Rj / dR) delta^1.5.

    Examples
    --------
    >>> law = rc.Hertz()
    >>> round(float(law.elastic_force(1e-6, (2.22e-3, 2.245e-3), 0.011)), 1)  # [N], at 1 um
    67.7
    """

    elastic = "hertz"


@description(frozen=True)
class LankaraniNikravesh(ForceLaw):
    """Hertz's contact of spheres with the damping of Lankarani and Nikravesh (1990).

    Examples
    --------
    >>> law = rc.LankaraniNikravesh()
    >>> round(float(law.elastic_force(1e-6, (2.22e-3, 2.245e-3), 0.011)), 1)  # [N], at 1 um
    67.7
    """

    elastic = "hertz"

    damping: Damping | None = "lankarani-nikravesh"


@description(frozen=True)
class Johnson(ForceLaw):
    """Johnson's contact of cylinders (1985), implicit in the force; undamped by default.

    Examples
    --------
    >>> law = rc.Johnson()
    >>> round(float(law.elastic_force(1e-6, (2.22e-3, 2.245e-3), 0.011)), 1)  # [N], at 1 um
    746.3
    """

    elastic = "johnson"


@description(frozen=True)
class EnhancedCylinder(ForceLaw):
    """The enhanced cylindrical law of Pereira, Ramalho and Ambrosio: a power of the penetration.

    Attributes
    ----------
    coefficients : {"2010", "2015"}
        Coefficients of internal contacts: those of ECCM 2010, or those of Multibody System Dynamics
        35 (2015). Both sets have the same coefficients of external contacts.

    Examples
    --------
    >>> law = rc.EnhancedCylinder()
    >>> round(float(law.elastic_force(1e-6, (2.22e-3, 2.245e-3), 0.011)), 1)  # [N], at 1 um
    872.6
    """

    elastic = "enhanced-cylinder"

    damping: Damping | None = "lankarani-nikravesh"
    coefficients: Literal["2010", "2015"] = "2010"


@description(frozen=True)
class HertzCylinder(ForceLaw):
    """Hertz's cylinders as two half-planes, implicit in the force; undamped by default.

    Examples
    --------
    >>> law = rc.HertzCylinder()
    >>> round(float(law.elastic_force(1e-6, (2.22e-3, 2.245e-3), 0.011)), 1)  # [N], at 1 um
    447.5
    """

    elastic = "hertz-cylinder"


@description(frozen=True)
class Radzimovsky(ForceLaw):
    """Radzimovsky's contact of cylinders (1953), implicit in the force; undamped by default.

    Examples
    --------
    >>> law = rc.Radzimovsky()
    >>> round(float(law.elastic_force(1e-6, (2.22e-3, 2.245e-3), 0.011)), 1)  # [N], at 1 um
    610.8
    """

    elastic = "radzimovsky"


@description(frozen=True)
class Esdu78035(ForceLaw):
    """Contact of cylinders after ESDU 78035, implicit in the force; undamped by default.

    Examples
    --------
    >>> law = rc.Esdu78035()
    >>> round(float(law.elastic_force(1e-6, (2.22e-3, 2.245e-3), 0.011)), 1)  # [N], at 1 um
    514.6
    """

    elastic = "esdu-78035"


@description(frozen=True)
class LiuConformal(ForceLaw):
    """Liu, Zhang and Yang's pin in a close bore (2007), undamped by default.

    Between convex surfaces, as on a tooth's flat and tip, it is a formality and warns.

    Examples
    --------
    >>> law = rc.LiuConformal()
    >>> round(float(law.elastic_force(1e-6, (2.22e-3, 2.245e-3), 0.011)), 1)  # [N], at 1 um
    272.5
    """

    elastic = "liu-conformal"


@description(frozen=True)
class Linear(ForceLaw):
    """A constant stiffness, whatever the surfaces; undamped by default.

    Its damping is a restitution's, as that of every law here. A dashpot beside the spring is
    `LinearContact`, in a mechanism.

    Attributes
    ----------
    stiffness : float
        Stiffness [N/m].

    Examples
    --------
    >>> law = rc.Linear(stiffness=1e8)
    >>> round(float(law.elastic_force(1e-6, (2.22e-3, 2.245e-3), 0.011)), 1)  # [N], at 1 um
    100.0
    """

    elastic = "linear"

    stiffness: float = field(kw_only=True)


@checked
def effective_restitution(damping: Damping, restitution: float) -> float:
    """Return the restitution of an impact whose damping law is given `restitution`.

    It solves lam (1 + e) = ln[(1 + lam) / (1 - lam e)], lam that of the damping law, whatever the
    elastic part, the mass and the speed.

    Parameters
    ----------
    damping : str
        As in `ForceLaw`.
    restitution : float
        `Material.restitution`, 0 to 1.

    Raises
    ------
    InvalidInput
        The name is not known, or the restitution is out of the law's range.

    Examples
    --------
    >>> round(rc.effective_restitution("lankarani-nikravesh", 0.71), 4)
    0.8005
    """
    return _rustchain.effective_restitution(damping, restitution)
