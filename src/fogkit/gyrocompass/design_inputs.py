"""What a design starts from: the grade of the gyros, as data sheets have it, and what the mount can do."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fogkit import checks
from fogkit.gyrocompass.frames import pyramid_axes
from fogkit.gyrocompass.laws import LARGEST_AMPLITUDE
from fogkit.noise import RandomErrors
from fogkit.results import Record
from fogkit.units import DEG, DEG_PER_SECOND, DEG_PER_SECOND_SQUARED, PERCENT


@dataclass(frozen=True, kw_only=True)
class GyroGrade(Record):
    """Errors of each of three equal gyros: standard deviations of what is constant, coefficients of what is random.

    Parameters
    ----------
    angle_random_walk : float
        White noise, rad/sqrt(s), two-sided: a density in rad/s/sqrt(Hz) of a one-sided spectrum is to be divided by
        ``sqrt(2)``.
    bias : float, optional
        What is known of the bias when it is switched on, rad/s; infinite, the default: nothing.
    bias_instability : float, optional
        Coefficient B of flicker noise, rad/s; the floor of an Allan deviation, which data sheets call so, is 0.664 B.
    rate_random_walk : float, optional
        rad/s/sqrt(s).
    scale_factor : float, optional
        Error of the scale factor, 1; errors of the gyros' axes, rad, act in the same way.
    scale_asymmetry : float, optional
        Difference of the scale factors for rates of either sign over their mean (`fogkit.imu.errors.asymmetry`), 1.
    largest_rate : float, optional
        Range, rad/s; infinite, the default: not looked at.

    Raises
    ------
    ValueError
        If an entry is negative, `angle_random_walk` or `largest_rate` zero, or one not finite that has to be.
    """

    angle_random_walk: float
    bias: float = np.inf
    bias_instability: float = 0.0
    rate_random_walk: float = 0.0
    scale_factor: float = 1 * PERCENT
    scale_asymmetry: float = 0.0
    largest_rate: float = np.inf

    def __post_init__(self) -> None:
        walk = checks.positive("angle_random_walk", self.angle_random_walk, "rad/sqrt(s)")
        object.__setattr__(self, "angle_random_walk", walk)
        units = {"bias_instability": "rad/s", "rate_random_walk": "rad/s/sqrt(s)"}
        for name in ("bias_instability", "rate_random_walk", "scale_factor", "scale_asymmetry"):
            object.__setattr__(self, name, checks.non_negative(name, getattr(self, name), units.get(name, "")))
        for name, check in (("bias", checks.non_negative), ("largest_rate", checks.positive)):
            value = getattr(self, name)
            if not (isinstance(value, float | int) and value == np.inf):
                object.__setattr__(self, name, check(name, value, "rad/s"))

    @property
    def random(self) -> RandomErrors:
        """The random errors in the form of `fogkit.noise`."""
        return RandomErrors(
            angle_random_walk=self.angle_random_walk,
            bias_instability=self.bias_instability,
            rate_random_walk=self.rate_random_walk,
        )


@dataclass(frozen=True, kw_only=True)
class MountLimits(Record):
    """What a mount can do.

    Parameters
    ----------
    travel : float, optional
        Angle from one end to the other, rad, that cable and stops allow; infinite for slip rings.
    max_rate, max_acceleration : float, optional
        Of the drive, rad/s and rad/s^2.

    Raises
    ------
    ValueError
        If one is not above zero, or the travel finite and more than 20 turns: degrees are suspected.
    """

    travel: float = 360 * DEG
    max_rate: float = 30 * DEG_PER_SECOND
    max_acceleration: float = 60 * DEG_PER_SECOND_SQUARED

    def __post_init__(self) -> None:
        for name, unit in (("max_rate", "rad/s"), ("max_acceleration", "rad/s^2")):
            object.__setattr__(self, name, checks.positive(name, getattr(self, name), unit))
        if not (isinstance(self.travel, float) and self.travel == np.inf):
            travel, fix = checks.positive("travel", self.travel, "rad"), "Multiply degrees by `fogkit.units.DEG`."
            checks.in_closed_interval("travel", travel, 0.0, 2 * LARGEST_AMPLITUDE, "rad", fix=fix)
            object.__setattr__(self, "travel", travel)

    def rate_with(self, gyro: GyroGrade, hull_rates: ArrayLike = (0.0, 0.0, 0.0)) -> float:
        """Largest rate of the mount, rad/s, that drive and range of the gyros both allow.

        Parameters
        ----------
        gyro : GyroGrade
            Its `largest_rate` counts; a gyro of the pyramid sees ``1/sqrt(3)`` of the mount's rate.
        hull_rates : array_like, shape (3,), optional
            Largest rates of the hull, as for `fogkit.gyrocompass.gyro_range.gyro_peaks`, rad/s.

        Returns
        -------
        float
            rad/s.

        Raises
        ------
        ValueError
            If the hull alone takes the gyros out of their range.
        """
        forward, up, starboard = np.abs(checks.finite_array("hull_rates", hull_rates, shape=(3,)))
        axes = pyramid_axes()
        level = np.hypot(axes[0], axes[2]) * np.hypot(forward, starboard)
        left = float(((gyro.largest_rate - level) / np.abs(axes[1])).min() - up)
        if not left > 0:
            raise ValueError(
                f"`gyro.largest_rate` must exceed what the hull alone does, got "
                f"{gyro.largest_rate / DEG_PER_SECOND:.4g} deg/s, which leaves "
                f"{left / DEG_PER_SECOND:.4g} deg/s for the mount"
            )
        return min(self.max_rate, left)
