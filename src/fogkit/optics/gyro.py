"""One closed-loop gyro: coil, loop and detector noise in one record."""

import warnings
from dataclasses import dataclass, replace

import numpy as np

from fogkit import checks
from fogkit.optics.coil import Coil
from fogkit.optics.interferometer import power
from fogkit.optics.loop import Loop


@dataclass(frozen=True, kw_only=True)
class ClosedLoopGyro:
    """Closed-loop fibre-optic gyro.

    Parameters
    ----------
    coil : Coil
        Sensing coil.
    loop : Loop
        Modulation and controller.
    detector_noise, shot_noise, intensity_noise : float, optional
        Noise of one half-period's power, relative to full power: its variance at relative power p is
        ``detector_noise**2 + shot_noise**2 * p + (intensity_noise * p)**2``. White from one half-period to the next.

    Raises
    ------
    TypeError
        If `coil` or `loop` is something else.
    ValueError
        If a noise level is negative or not finite.

    Warns
    -----
    UserWarning
        If the half-period of the modulation is more than a tenth away from the coil's transit time: then the light that
        meets was not modulated half a period apart, which this model takes it to be.
    """

    coil: Coil
    loop: Loop
    detector_noise: float = 0.0
    shot_noise: float = 0.0
    intensity_noise: float = 0.0

    def __post_init__(self) -> None:
        for name, kind in (("coil", Coil), ("loop", Loop)):
            checks.instance(name, getattr(self, name), kind)
        for name in ("detector_noise", "shot_noise", "intensity_noise"):
            checks.non_negative(name, getattr(self, name))
        ratio = self.loop.half_period / self.coil.transit_time
        if not 0.9 < ratio < 1.1:
            warnings.warn(
                f"`loop.half_period` {self.loop.half_period:.4g} s is {ratio:.3g} times the coil's transit time, "
                f"{self.coil.transit_time:.4g} s: modulation away from the proper frequency is not modelled",
                UserWarning,
                stacklevel=3,
            )

    @property
    def is_noisy(self) -> bool:
        """Whether any noise level is above zero."""
        return max(self.detector_noise, self.shot_noise, self.intensity_noise) > 0

    def with_angle_random_walk(self, angle_random_walk: float) -> "ClosedLoopGyro":
        """Same gyro with detector noise alone, as strong as makes an `angle_random_walk`, rad/sqrt(s)."""
        target = checks.non_negative("angle_random_walk", angle_random_walk, "rad/sqrt(s)")
        unit = replace(self, detector_noise=1.0, shot_noise=0.0, intensity_noise=0.0)
        return replace(unit, detector_noise=target / unit.angle_random_walk)

    @property
    def residual_noise(self) -> float:
        """Standard deviation of the demodulated phase of one regulation period at rest, rad."""
        bias_power = power(self.loop.actual_depth)
        variance = self.detector_noise**2 + self.shot_noise**2 * bias_power + (self.intensity_noise * bias_power) ** 2
        return float(np.sqrt(variance / self.loop.half_periods) / (0.5 * np.sin(self.loop.depth)))

    @property
    def angle_random_walk(self) -> float:
        """Angle random walk from the detector noise, rad/sqrt(s); the two-sided rate noise density is its square."""
        slope = np.sin(self.loop.actual_depth) / np.sin(self.loop.depth)  # the loop nulls with the actual slope
        return self.residual_noise / slope * np.sqrt(self.loop.regulation_period) / self.coil.sagnac_scale_factor
