"""The sensing coil: what one radian per second of rotation does to light in it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.constants import SPEED_OF_LIGHT


@dataclass(frozen=True, kw_only=True)
class Coil:
    """Fibre coil of a Sagnac interferometer.

    Parameters
    ----------
    length : float
        Length of the fibre, m.
    diameter : float
        Mean diameter of the coil, m.
    wavelength : float, optional
        Mean wavelength of the source in vacuum, m.
    index : float, optional
        Refractive index seen by the modulation (the group index of the mode); it sets the transit time, not
        the Sagnac phase.

    Raises
    ------
    ValueError
        If a length is not positive and finite, or `index` is below 1.

    Notes
    -----
    Sagnac phase ``2 pi L D / (lambda c) * rate`` (miklyashev, scale factor before eq. (4)) [1]_.

    References
    ----------
    .. [1] H. C. Lefevre, *The Fiber-Optic Gyroscope*, 2nd ed., Artech House, 2014.

    Examples
    --------
    >>> from fogkit.units import DEG, NANOMETRE
    >>> coil = Coil(length=1000, diameter=0.1, wavelength=1550 * NANOMETRE)
    >>> round(coil.sagnac_scale_factor, 4)                  # rad of Sagnac phase per rad/s
    1.3522
    >>> round(coil.proper_frequency / 1e3, 1)               # kHz
    102.1
    """

    length: float
    diameter: float
    wavelength: float = 1.55e-6
    index: float = 1.468

    def __post_init__(self) -> None:
        for name in ("length", "diameter", "wavelength"):
            object.__setattr__(self, name, checks.positive(name, getattr(self, name), "m"))
        checks.in_closed_interval("index", self.index, 1.0, np.inf)
        if self.diameter > 10 or self.length > 1e6:
            raise ValueError(
                f"`diameter` must be at most 10 m and `length` 1e6 m, got {self.diameter} m and {self.length} m. "
                "Multiply millimetres by `fogkit.units.MILLIMETRE`"
            )
        if self.wavelength > 1e-4:
            raise ValueError(
                f"`wavelength` must be in metres and below 1e-4 m, got {self.wavelength}. "
                "Multiply micrometres by `fogkit.units.MICROMETRE`"
            )

    @property
    def sagnac_scale_factor(self) -> float:
        """Sagnac phase per unit of rotation rate, rad/(rad/s)."""
        return 2 * np.pi * self.length * self.diameter / (self.wavelength * SPEED_OF_LIGHT)

    @property
    def transit_time(self) -> float:
        """Time that light spends in the coil, s."""
        return self.index * self.length / SPEED_OF_LIGHT

    @property
    def proper_frequency(self) -> float:
        """Modulation frequency whose half-period is the transit time, Hz."""
        return 1 / (2 * self.transit_time)

    @property
    def rate_of_one_fringe(self) -> float:
        """Rotation rate whose Sagnac phase is 2 pi, rad/s."""
        return 2 * np.pi / self.sagnac_scale_factor

    def phase(self, rate: ArrayLike) -> NDArray[np.float64]:
        """Sagnac phase, rad, of a rotation `rate`, rad/s, of any shape."""
        return self.sagnac_scale_factor * np.asarray(rate, dtype=float)

    def rate(self, phase: ArrayLike) -> NDArray[np.float64]:
        """Rotation rate, rad/s, whose Sagnac phase is `phase`, rad, of any shape."""
        return np.asarray(phase, dtype=float) / self.sagnac_scale_factor
