"""Material of the parts of a drive."""

from __future__ import annotations

from rustchain.description.base import Description, description


@description(frozen=True)
class Material(Description):
    """An elastic material; the default is the steel of the published drive.

    Attributes
    ----------
    elastic_modulus : float
        Young's modulus [Pa].
    poisson_ratio : float
        Poisson's ratio.
    restitution : float
        Restitution coefficient of the damping factor, 0 to 1. The restitution of an impact differs:
        see `effective_restitution`.

    Examples
    --------
    >>> steel = rc.Material(elastic_modulus=206e9, restitution=0.8)
    >>> steel.restitution
    0.8
    """

    elastic_modulus: float = 2.07e11
    poisson_ratio: float = 0.3
    restitution: float = 0.71
