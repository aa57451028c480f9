"""What the case does: rotation rates as the gyro samples them, one at the middle of each half-period of modulation."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.optics import _kernels


class Motion(Protocol):
    """Anything that gives the rates of a stretch of half-periods."""

    def sample(self, first: int, count: int, step: float) -> NDArray[np.float64]:
        """Rates, rad/s, shape (count,), at times ``(first + 0.5 + n) * step`` for n from 0, s."""
        ...


@dataclass(frozen=True, kw_only=True)
class AngularOscillation:
    """Harmonic angular oscillation: rate ``acceleration / (2 pi frequency) sin(2 pi frequency t + phase)``.

    Parameters
    ----------
    acceleration : float
        Amplitude of the angular acceleration, rad/s^2.
    frequency : float
        Frequency of the oscillation, Hz.
    phase : float, optional
        Phase of the rate at time zero, rad. At 0 the rate starts at zero and the acceleration at its maximum.

    Raises
    ------
    ValueError
        If `acceleration` or `phase` is not finite, or `frequency` not positive.
    """

    acceleration: float
    frequency: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        checks.finite("acceleration", self.acceleration, "rad/s^2")
        checks.positive("frequency", self.frequency, "Hz")
        checks.finite("phase", self.phase, "rad")

    @property
    def rate_amplitude(self) -> float:
        """Amplitude of the rate, rad/s."""
        return self.acceleration / (2 * np.pi * self.frequency)

    def sample(self, first: int, count: int, step: float) -> NDArray[np.float64]:
        """See `Motion.sample`."""
        rates = np.empty(count)
        cycles_per_sample = self.frequency * step
        if cycles_per_sample > 0.5:
            raise ValueError(
                f"`frequency` must be at most {0.5 / step:.6g} Hz, half the sampling rate, got {self.frequency:.6g}: "
                "the gyro samples its input once per half-period"
            )
        first_cycle = ((first + 0.5) * cycles_per_sample + self.phase / (2 * np.pi)) % 1.0
        _kernels.sinusoid(self.rate_amplitude, cycles_per_sample, first_cycle, rates)
        return rates


@dataclass(frozen=True, kw_only=True)
class Ramp:
    """Constant angular acceleration from a given rate; with no acceleration, a constant rate.

    Parameters
    ----------
    acceleration : float
        Angular acceleration, rad/s^2.
    rate : float, optional
        Rate at time zero, rad/s.

    Raises
    ------
    ValueError
        If either is not finite.
    """

    acceleration: float
    rate: float = 0.0

    def __post_init__(self) -> None:
        checks.finite("acceleration", self.acceleration, "rad/s^2")
        checks.finite("rate", self.rate, "rad/s")

    def sample(self, first: int, count: int, step: float) -> NDArray[np.float64]:
        """See `Motion.sample`."""
        return self.rate + self.acceleration * step * (first + 0.5 + np.arange(count))


@dataclass(frozen=True)
class SampledMotion:
    """Rates given one by one.

    Parameters
    ----------
    rates : array_like, shape (n,)
        Rate in the middle of each half-period, rad/s, finite.
    """

    rates: ArrayLike

    def __post_init__(self) -> None:
        object.__setattr__(self, "rates", checks.finite_array("motion", self.rates, ndim=1))

    def sample(self, first: int, count: int, step: float) -> NDArray[np.float64]:
        """See `Motion.sample`; `step` is not looked at."""
        return self.rates[first : first + count]


@dataclass(frozen=True)
class FunctionMotion:
    """Rates from a function of time.

    Parameters
    ----------
    function : callable
        Takes times, s, shape (n,), and returns rates, rad/s, of the same shape.
    """

    function: Callable[[NDArray[np.float64]], ArrayLike]

    def sample(self, first: int, count: int, step: float) -> NDArray[np.float64]:
        """See `Motion.sample`; ``ValueError`` if the function returns another shape or something not finite."""
        return checks.finite_array("motion(t)", self.function((first + 0.5 + np.arange(count)) * step), shape=(count,))


def as_motion(motion: Motion | Callable | ArrayLike) -> Motion:
    """Motion from what a user has: a motion as it is, a function of time, or an array of rates.

    Raises
    ------
    TypeError
        If `motion` is a class, a string or nothing that holds numbers.
    ValueError
        If an array is empty, of other than one axis, or not finite.
    """
    if isinstance(motion, type):
        raise TypeError(
            f"`motion` must be a motion, got the class {motion.__name__}. Make one of it with its parameters"
        )
    if hasattr(motion, "__array__"):  # pandas objects have a `sample` of their own, which draws at random
        return SampledMotion(np.asarray(motion))
    if hasattr(motion, "sample"):
        return motion
    return FunctionMotion(motion) if callable(motion) else SampledMotion(motion)
