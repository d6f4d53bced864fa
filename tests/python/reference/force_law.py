"""The normal force of one contact: an elastic part and a damping part (Eqs. 4 to 6 of the paper).

Elastic parts, ``f`` the force [N], ``d`` the penetration [m], ``E*`` the effective modulus [Pa],
``dR = R_i + R_j`` outside and ``R_j - R_i`` inside [m], ``L`` the length of contact [m]:

hertz              f = (4 E* / 3) sqrt(R_i R_j / dR) d^1.5
johnson            d = f / (pi L E*) [ln(4 pi L E* dR / f) - 1]
hertz-cylinder     d = 2 f / (pi L E*) [ln(pi L E* dR / f) - 1]
radzimovsky        d = f / (pi L E*) [ln(6.25 L E* dR / f) + 2/3]
esdu-78035         d = f / (pi L E*) [ln(4 pi L E* dR / f) + 1]
enhanced-cylinder  f = (a dR + b) (L E* / dR) d^n, in mm and N/mm^2
liu-conformal      f = (pi / 2) E* L d sqrt(d / (2 (dR + d)))
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import lambertw

if TYPE_CHECKING:
    from rustchain import Material

Array = NDArray[np.float64]

MILLIMETRES = 1000.0  # per metre
MEGAPASCAL = 1.0e6  # [Pa]


class Elastic(NamedTuple):
    """The elastic part of a contact, arrays of one shape.

    Force [N], its derivative with respect to the penetration [N/m], and the energy stored [J].
    """

    force: Array
    stiffness: Array
    energy: Array


class Normal(NamedTuple):
    """The whole normal force, arrays of one shape.

    Force [N], its derivatives with respect to penetration [N/m] and penetration rate [N s/m].
    """

    force: Array
    by_penetration: Array
    by_rate: Array


@dataclass(frozen=True)
class Pair:
    """Two cylinders of one material.

    Attributes
    ----------
    inside : bool
        Whether the first lies inside the second.
    radius_i, radius_j : float
        Radii [m]. On a tooth's flat ``radius_j`` is the radius of the topping curve.
    length : float
        Length of contact [m].
    modulus : float
        E* [Pa].
    flat : bool
        A flat: Hertz takes the limit of an infinite radius, sqrt(R_i); the other laws have no such
        limit and take the pair as it is.
    """

    inside: bool
    radius_i: float
    radius_j: float
    length: float
    modulus: float
    flat: bool = False

    @property
    def radius_difference(self) -> float:
        """DR, the sum of the radii outside and their difference inside [m]."""
        return self.radius_j - self.radius_i if self.inside else self.radius_i + self.radius_j


def effective_modulus(material: Material) -> float:
    """Return E* = E / (2 (1 - nu^2)) of two bodies of one material [Pa]."""
    return float(material.elastic_modulus / (2.0 * (1.0 - material.poisson_ratio**2)))


def elastic(law: str, pair: Pair, penetration: Array) -> Elastic:
    """Elastic part of the named law at ``penetration`` [m], any shape; zero where apart."""
    depth = np.maximum(np.asarray(penetration, dtype=np.float64), 0.0)
    if law == "hertz":
        return _power_law(hertz_stiffness(pair), 1.5, depth)
    if law == "enhanced-cylinder":
        stiffness, exponent = enhanced_cylinder_constants(pair)
        # f = K (1000 d)^n with d in metres
        return _power_law(stiffness * MILLIMETRES**exponent, exponent, depth)
    if law in LOGARITHMS:
        return _logarithmic(law, pair, depth)
    if law == "liu-conformal":
        return _conformal(pair, depth)
    raise ValueError(law)


def in_series(law: str, pair: Pair, penetration: Array, compliance: Array) -> Elastic:
    """Elastic part in series with a spring of ``compliance`` [m/N], whose energy it has in it."""
    depth = np.maximum(np.asarray(penetration, dtype=np.float64), 0.0)
    low, high = np.zeros_like(depth), depth
    for _ in range(200):  # halving
        middle = 0.5 * (low + high)
        short = middle + compliance * elastic(law, pair, middle).force < depth
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    contact = elastic(law, pair, 0.5 * (low + high))
    stiffness = contact.stiffness / (1.0 + compliance * contact.stiffness)
    energy = contact.energy + 0.5 * compliance * contact.force**2
    return contact._replace(stiffness=stiffness, energy=energy)


# A over pi L E*, k and C of d = f/A [ln(k A dR / f) + C].
LOGARITHMS = {
    "johnson": (1.0, 4.0, -1.0),
    "hertz-cylinder": (0.5, 2.0, -1.0),
    "radzimovsky": (1.0, 6.25 / np.pi, 2.0 / 3.0),
    "esdu-78035": (1.0, 4.0, 1.0),
}


def _power_law(stiffness: float, exponent: float, depth: Array) -> Elastic:
    """F = K d^n, with ``stiffness`` [N/m^n]."""
    force = stiffness * depth**exponent
    slope = exponent * stiffness * depth ** (exponent - 1.0)
    return Elastic(force, slope, force * depth / (exponent + 1.0))


def hertz_stiffness(pair: Pair) -> float:
    """K = (4 E* / 3) sqrt(R_i R_j / dR) [N/m^1.5]; on a flat R_i R_j / dR becomes R_i."""
    reduced = pair.radius_i
    if not pair.flat:
        reduced = pair.radius_i * pair.radius_j / pair.radius_difference
    return float(4.0 / 3.0 * pair.modulus * np.sqrt(reduced))


def enhanced_cylinder_constants(pair: Pair) -> tuple[float, float]:
    """K [N/mm^n] and n of Eq. 6, which is fitted in millimetres and N/mm^2."""
    dr = pair.radius_difference * MILLIMETRES
    modulus = pair.modulus / MEGAPASCAL
    length = pair.length * MILLIMETRES
    if not pair.inside:
        a, b, exponent = 0.39, 0.85, 1.094
    else:
        a, b = 0.49, 0.10
        if dr < 0.005:
            raise ValueError(f"the fit begins at dR = 0.005 mm, not {dr}")
        below = 1.56 * np.log(1000.0 * dr) ** -0.192
        above = 0.0028 * min(dr, 10.0) + 1.083  # the fit ends at 10 mm: held there
        exponent = float((below if dr < 0.750 else above) * dr**-0.005)
    return (a * dr + b) * length * modulus / dr, exponent


def johnson_penetration(pair: Pair, force: Array) -> Array:
    """Penetration [m] under ``force`` [N], Johnson's law as he wrote it (Eq. 5)."""
    line = np.pi * pair.length * pair.modulus
    scale = 4.0 * line * pair.radius_difference
    return np.asarray(force / line * (np.log(scale / force) - 1.0))


def johnson_end(pair: Pair) -> tuple[float, float]:
    """Penetration [m] and force [N] at the end of Johnson's branch, where d(f) is largest."""
    dr = pair.radius_difference
    return 4.0 * dr / np.e**2, 4.0 * np.pi * pair.length * pair.modulus * dr / np.e**2


def logarithmic_end(law: str, pair: Pair) -> float:
    """Penetration [m] at the end of a logarithmic law's branch."""
    _, k, c = LOGARITHMS[law]
    return float(k * pair.radius_difference * np.exp(c - 1.0))


def _logarithmic(law: str, pair: Pair, depth: Array) -> Elastic:
    """Inverse of d = f/A [ln(B / f) - 1] by the lower Lambert branch; past the end a straight line.

    With w = f e / B: -w ln w = d e A / B, w = exp(W_-1(-d e A / B)). Past the end the force goes on
    from its end value with the secant stiffness f_end / d_end.
    """
    share, k, c = LOGARITHMS[law]
    line = share * np.pi * pair.length * pair.modulus  # A
    scale = k * line * pair.radius_difference * np.exp(c + 1.0)  # B
    end_force = scale / np.e**2
    end_depth = end_force / line
    secant = line

    force = np.zeros_like(depth)
    slope = np.zeros_like(depth)
    energy = np.zeros_like(depth)

    inside = (depth > 0.0) & (depth < end_depth)
    argument = -depth[inside] * np.e * line / scale
    branch = np.real(lambertw(argument, k=-1))
    f = scale / np.e * np.exp(branch)
    # One Newton step on d(f) - d = 0 takes away the rounding of the exponent, W eps.
    log_ratio = np.log(scale / f)
    error = f / line * (log_ratio - 1.0) - depth[inside]
    f = f - error * line / (log_ratio - 2.0)
    force[inside] = f
    slope[inside] = line / (log_ratio - 2.0)
    # integral of f dd = f d - integral of d df
    energy[inside] = f**2 / line * (0.5 * log_ratio - 0.75)

    past = depth >= end_depth
    end_energy = 0.25 * end_force**2 / line
    force[past] = end_force + secant * (depth[past] - end_depth)
    slope[past] = secant
    energy[past] = end_energy + 0.5 * (end_force + force[past]) * (depth[past] - end_depth)
    return Elastic(force, slope, energy)


def _conformal(pair: Pair, depth: Array) -> Elastic:
    """Liu's law; its energy by Gauss and Legendre's rule in the root of the depth."""
    stiffness, dr = np.pi * pair.modulus * pair.length / np.sqrt(8.0), pair.radius_difference
    share = depth / (dr + depth)
    force = stiffness * depth * np.sqrt(share)
    slope = stiffness * np.sqrt(share) * (1.5 - 0.5 * share)
    nodes, weights = np.polynomial.legendre.leggauss(24)
    root = np.sqrt(depth)[..., None] * 0.5 * (1.0 + nodes)
    integrand = stiffness * 2.0 * root**4 / np.sqrt(dr + root**2)
    return Elastic(force, slope, np.sqrt(depth) * 0.5 * (integrand @ weights))


def lankarani_nikravesh_factor(restitution: float) -> float:
    """Damping factor of Lankarani and Nikravesh, 3 (1 - ce^2) / 4 (Eq. 4)."""
    return 0.75 * (1.0 - restitution**2)


def damping_lambda(law: str | None, restitution: float) -> float:
    """Lambda of the factor 1 + lambda rate / onset speed of a damping law."""
    e = restitution
    return {
        None: 0.0,
        "hunt-crossley": 3.0 * (1.0 - e) / 2.0,
        "lankarani-nikravesh": lankarani_nikravesh_factor(e),
        "herbert-mcwhannell": 6.0 * (1.0 - e) / ((2.0 * e - 1.0) ** 2 + 3.0),
        "lee-wang": 3.0 * (1.0 - e) / 4.0,
        "flores": 8.0 * (1.0 - e) / (5.0 * e),
        "gonthier": (1.0 - e**2) / e,
        "hu-guo": 3.0 * (1.0 - e) / (2.0 * e),
        "zhiying-qishao": 3.0 * (1.0 - e**2) * float(np.exp(2.0 * (1.0 - e))) / 4.0,
    }[law]


def damped(part: Elastic, factor: float, rate: Array, onset_speed: Array) -> Normal:
    """Multiply an elastic force by 1 + factor rate / onset speed, never below zero.

    ``rate`` and ``onset_speed`` [m/s] have the shape of the force; ``onset_speed`` is held fixed in
    the derivative by the rate.
    """
    bracket = 1.0 + factor * rate / onset_speed
    pushes = bracket > 0.0
    return Normal(
        np.where(pushes, part.force * bracket, 0.0),
        np.where(pushes, part.stiffness * bracket, 0.0),
        np.where(pushes, part.force * factor / onset_speed, 0.0),
    )
