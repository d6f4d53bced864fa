"""The start of the paper's drive, solved with fifty digits.

Hinges on the driver sit at the angles a + i 2 pi / 17, i = 0 to 8, those on the driven sprocket at
b + i 2 pi / 17, i = 0 to 9, with a = pi - 4 * 2 pi / 17 - eps and b = -4.5 * 2 pi / 17 + eps. The
angle eps and the centre distance C solve "upper strand = 10 p, lower strand = 11 p".
"""

from __future__ import annotations

from dataclasses import dataclass

import mpmath
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TEETH = 17
DRIVER_HINGES, UPPER_PITCHES, DRIVEN_HINGES, LOWER_PITCHES = 9, 10, 10, 11
DIGITS = 50


@dataclass(frozen=True)
class PaperStart:
    """Links and sprockets of the paper's drive at t = 0.

    Attributes
    ----------
    links, link_rates : ndarray, shape (38, 3)
        [m, m, rad] and [m/s, m/s, rad/s].
    sprocket_angles : ndarray, shape (2,)
        A gap angle of each sprocket in (-pi/17, pi/17] [rad].
    center_distance, eps : float
        C [m] and eps [rad].
    first_seats : ndarray, shape (2,)
        Angles a and b of the first seated hinge of each sprocket [rad].
    """

    links: Array
    link_rates: Array
    sprocket_angles: Array
    center_distance: float
    eps: float
    first_seats: Array


def paper_start(
    pitch: str = "0.0127", speed: mpmath.mpf | None = None, digits: int = DIGITS
) -> PaperStart:
    """Solve for the start; ``pitch`` in metres as a decimal string, ``speed`` in rad/s (4 pi)."""
    with mpmath.workdps(digits):
        p = mpmath.mpf(pitch)
        step = 2 * mpmath.pi / TEETH
        radius = p / (2 * mpmath.sin(mpmath.pi / TEETH))
        omega = 4 * mpmath.pi if speed is None else speed

        def seats(eps: mpmath.mpf, center: mpmath.mpf) -> tuple[list, list]:  # type: ignore[type-arg]
            a = mpmath.pi - 4 * step - eps
            b = -step * 9 / 2 + eps
            driver = [radius * _direction(a + i * step) for i in range(DRIVER_HINGES)]
            driven = [center + radius * _direction(b + i * step) for i in range(DRIVEN_HINGES)]
            return driver, driven

        def misfit(eps: mpmath.mpf, center: mpmath.mpf) -> list[mpmath.mpf]:
            driver, driven = seats(eps, center)
            return [
                abs(driven[-1] - driver[0]) - UPPER_PITCHES * p,
                abs(driven[0] - driver[-1]) - LOWER_PITCHES * p,
            ]

        eps, center = mpmath.findroot(misfit, (mpmath.mpf("0.09"), mpmath.mpf("0.1333")))
        driver, driven = seats(eps, center)
        hinges, rates = _around(driver, driven, center, omega)

        links, link_rates = [], []
        for k in range(len(hinges)):
            rear, front = hinges[k - 1], hinges[k]
            middle, d = (front + rear) / 2, front - rear
            middle_rate = (rates[k] + rates[k - 1]) / 2
            dv = rates[k] - rates[k - 1]
            turn = (mpmath.conj(d) * dv).imag / p**2  # (d x dv) / p^2
            links.append([middle.real, middle.imag, mpmath.arg(d)])
            link_rates.append([middle_rate.real, middle_rate.imag, turn])
        first = [mpmath.arg(driver[0]), mpmath.arg(driven[0] - center)]
        phases = [angle - step * mpmath.nint(angle / step) for angle in first]
        return PaperStart(
            links=np.array(links, dtype=np.float64),
            link_rates=np.array(link_rates, dtype=np.float64),
            sprocket_angles=np.array(phases, dtype=np.float64),
            center_distance=float(center),
            eps=float(eps),
            first_seats=np.array(first, dtype=np.float64),
        )


def _direction(angle: mpmath.mpf) -> mpmath.mpc:
    """Unit complex number at ``angle`` [rad]."""
    return mpmath.mpc(mpmath.cos(angle), mpmath.sin(angle))


def _around(
    driver: list[mpmath.mpc], driven: list[mpmath.mpc], center: mpmath.mpf, omega: mpmath.mpf
) -> tuple[list[mpmath.mpc], list[mpmath.mpc]]:
    """Hinges 1 to 38 and their velocities, as complex numbers.

    Seated hinges move rigidly with their sprocket; in a strand both positions and velocities are
    linear between the seated ends.
    """
    turn = mpmath.mpc(0, 1) * omega
    driver_rate = [turn * z for z in driver]
    driven_rate = [turn * (z - center) for z in driven]

    def strand(start: mpmath.mpc, end: mpmath.mpc, pitches: int) -> list[mpmath.mpc]:
        return [start + (end - start) * i / pitches for i in range(1, pitches)]

    hinges = [
        *driver,
        *strand(driver[-1], driven[0], LOWER_PITCHES),
        *driven,
        *strand(driven[-1], driver[0], UPPER_PITCHES),
    ]
    rates = [
        *driver_rate,
        *strand(driver_rate[-1], driven_rate[0], LOWER_PITCHES),
        *driven_rate,
        *strand(driven_rate[-1], driver_rate[0], UPPER_PITCHES),
    ]
    return hinges, rates
