"""Lubricant in hinges as a value."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from rustchain import _rustchain
from rustchain.arguments import checked
from rustchain.description.base import Description, description
from rustchain.errors import InvalidInput
from rustchain.typing import Pair


@description(frozen=True)
class LubricantFilm(Description):
    """Lubricant that fills hinges: squeeze and wedge film of a long bearing, half film.

    Of the Reynolds equation's pressure what is positive (Guembel), and shear all around (Petroff);
    towards contact it is handed over to the dry law.

    Attributes
    ----------
    viscosity : float
        Dynamic viscosity [Pa s]: some 0.01 for a warm lubricant of low viscosity, 0.1 to 0.5 for
        chain lubricants.
    length : float, optional
        Length of the film along the pin, of one strand [m]; by default the length of contact of the
        hinge.
    handover : float
        Eccentricity over clearance above which dry contact replaces the film, 0.1 to 0.99. At 1,
        where pin and bushing touch, the film force is zero.
    tension : float
        Largest tension of the film before it breaks [Pa]: the pressure may fall by that much below
        the ambient pressure. By default it is the atmospheric pressure; capillarity alone gives
        some 2e3. Zero: the half film of textbooks, which has a kink at zero velocity.

    Examples
    --------
    >>> oil = rc.LubricantFilm(viscosity=0.1)
    >>> law = rc.LankaraniNikravesh(film=oil)
    >>> law.film.handover
    0.9
    """

    viscosity: float
    length: float | None = None
    handover: float = 0.9
    tension: float = 1e5

    @checked
    def force(
        self,
        eccentricity: npt.ArrayLike,
        velocity: npt.ArrayLike,
        radii: Pair,
        length: float,
    ) -> npt.NDArray[np.float64]:
        """Return the force on the pin [N], along its eccentricity and left of that.

        Parameters
        ----------
        eccentricity : array_like
            Distance of the pin's centre from the bore's [m], zero or positive, any shape.
        velocity : array_like, (..., 2)
            Of the pin's centre, along the eccentricity and left of it, in a frame that turns with
            the mean of both angular velocities [m/s]. For a centre at rest, the second component is
            minus the eccentricity times the mean angular velocity.
        radii : (float, float)
            Of the pin and of the bore [m].
        length : float
            Length of contact [m], where the film has none of its own.

        Returns
        -------
        ndarray, (..., 2)

        Raises
        ------
        InvalidInput
            An eccentricity, a radius or the length is not allowed.

        Examples
        --------
        >>> film = rc.LubricantFilm(0.1, tension=0.0)
        >>> squeeze = film.force(10e-6, (1e-3, 0.0), (2.22e-3, 2.245e-3), 0.011)
        >>> round(float(squeeze[0]), 1)
        -28.2
        """
        speeds = np.asarray(velocity, dtype=np.float64)
        try:
            sizes = np.broadcast_to(np.asarray(eccentricity, dtype=np.float64), speeds.shape[:-1])
        except ValueError:
            sizes = None
        if sizes is None or speeds.shape[-1:] != (2,):
            msg = (
                f"force(velocity): got shape {speeds.shape} with eccentricity of shape "
                f"{np.shape(eccentricity)}; expected (..., 2) and (...)"
            )
            raise InvalidInput(msg)
        pin, bore = radii
        force = _rustchain.film_forces(
            self, (pin, bore), length, np.ascontiguousarray(sizes.ravel()), speeds.reshape(-1, 2)
        )
        return force.reshape(speeds.shape)
