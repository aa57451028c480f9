"""Random errors of a gyro or an accelerometer: five processes of IEEE 952 [1]_, and records of them.

Spectra are two-sided. A record holds the mean rate over each sample, which is what an integrating sensor delivers, and
each process has its exact statistics at every averaging time: nothing is approximated by a filter of finite memory.

References
----------
.. [1] IEEE Std 952-2020, annex C (Allan variance).
.. [2] R. B. Davies, D. S. Harte, "Tests for Hurst effect", Biometrika 74 (1987): circulant embedding. Non-negative
   for negatively correlated increments: P. F. Craigmile, Journal of Time Series Analysis 24 (2003).
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from math import log, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.noise.increments import flicker_covariance, second_difference_of_log
from fogkit.results import Record
from fogkit.units import (
    ARCSEC,
    DEG_PER_HOUR,
    DEG_PER_HOUR_PER_HOUR,
    DEG_PER_HOUR_PER_SQRT_HOUR,
    DEG_PER_SQRT_HOUR,
    HOUR,
    M_PER_S_PER_SQRT_HOUR,
    MICRO_G,
)

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

PROCESSES = ("angle_random_walk", "bias_instability", "rate_random_walk", "rate_ramp", "quantization")
"""Names of the processes, in the order of all arrays over processes."""

UNITS = {
    "si": {
        "angle_random_walk": (1.0, "rad/sqrt(s)"),
        "bias_instability": (1.0, "rad/s"),
        "rate_random_walk": (1.0, "rad/s/sqrt(s)"),
        "rate_ramp": (1.0, "rad/s^2"),
        "quantization": (1.0, "rad"),
    },
    "gyro": {
        "angle_random_walk": (DEG_PER_SQRT_HOUR, "deg/sqrt(h)"),
        "bias_instability": (DEG_PER_HOUR, "deg/h"),
        "rate_random_walk": (DEG_PER_HOUR_PER_SQRT_HOUR, "deg/h/sqrt(h)"),
        "rate_ramp": (DEG_PER_HOUR_PER_HOUR, "deg/h/h"),
        "quantization": (ARCSEC, "arcsec"),
    },
    "accelerometer": {
        "angle_random_walk": (M_PER_S_PER_SQRT_HOUR, "m/s/sqrt(h)"),
        "bias_instability": (MICRO_G, "ug"),
        "rate_random_walk": (MICRO_G / sqrt(HOUR), "ug/sqrt(h)"),
        "rate_ramp": (MICRO_G / HOUR, "ug/h"),
        "quantization": (1.0, "m/s"),
    },
}
"""Factor and label of each coefficient: SI, and as data sheets of gyros and of accelerometers have it."""

SLOPES = np.array([-1.0, 0.0, 1.0, 2.0, -2.0])
"""Power of the averaging time in the Allan variance, in the order of `PROCESSES`."""

FACTORS = np.array([1.0, 2 * log(2) / pi, 1 / 3, 1 / 2, 3.0])
"""Allan variance at 1 s for a coefficient of 1, in the order of `PROCESSES`."""


@dataclass(frozen=True, kw_only=True)
class RandomErrors(Record):
    """Coefficients of the random errors of one channel.

    For an accelerometer read velocity for angle: m/s/sqrt(s), m/s^2, m/s^2/sqrt(s), m/s^3, m/s.

    Attributes
    ----------
    angle_random_walk : float
        N: white noise of the rate, rad/sqrt(s).
    bias_instability : float
        B: flicker noise of the rate, rad/s; its Allan deviation is ``sqrt(2 ln 2 / pi) B = 0.664 B`` at every time.
    rate_random_walk : float
        K, rad/s/sqrt(s).
    rate_ramp : float
        R: constant slope of the rate, rad/s^2; of either sign, but only its size shows in an Allan deviation.
    quantization : float
        Q: root mean square of the white error of the angle, rad; that of a step is the step over ``sqrt(12)``.

    Examples
    --------
    >>> from fogkit.units import DEG_PER_HOUR, DEG_PER_SQRT_HOUR, HOUR
    >>> errors = RandomErrors(
    ...     angle_random_walk=0.001 * DEG_PER_SQRT_HOUR, bias_instability=0.003 * DEG_PER_HOUR
    ... )
    >>> print(f"{errors.allan_variance(HOUR) ** 0.5 / DEG_PER_HOUR:.5f} deg/h")
    0.00223 deg/h
    """

    angle_random_walk: float = 0.0
    bias_instability: float = 0.0
    rate_random_walk: float = 0.0
    rate_ramp: float = 0.0
    quantization: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            check = checks.finite if field.name == "rate_ramp" else checks.non_negative
            unit = UNITS["si"][field.name][1]
            object.__setattr__(self, field.name, check(field.name, getattr(self, field.name), unit))

    @property
    def squares(self) -> Array:
        """Squared coefficients in the order of `PROCESSES`, shape (5,): the Allan variance is linear in them."""
        return np.array([getattr(self, name) ** 2 for name in PROCESSES])

    @classmethod
    def from_squares(cls, squares: ArrayLike) -> RandomErrors:
        """Coefficients from their squares, shape (5,), none below zero."""
        squares = checks.array_in_closed_interval("squares", squares, 0.0, np.inf)
        return cls(**dict(zip(PROCESSES, np.sqrt(squares).tolist(), strict=True)))

    def allan_variance(self, tau: ArrayLike) -> Array:
        """Allan variance at averaging times of any shape, s: (rad/s)^2.

        ``N**2/tau + (2 ln 2/pi) B**2 + K**2 tau/3 + R**2 tau**2/2 + 3 Q**2/tau**2``, [1]_ annex C.
        """
        tau = _positive_array("tau", tau, "s")
        return np.sum(self.squares * FACTORS * tau[..., None] ** SLOPES, axis=-1)

    def power_spectral_density(self, frequency: ArrayLike, dt: float | None = None) -> Array:
        """Two-sided power spectral density of the rate; `scipy.signal.welch` returns twice this.

        Parameters
        ----------
        frequency : array_like, shape (...,)
            Frequencies, Hz, positive.
        dt : float, optional
            Sampling time, s. Only quantization needs it: it is made by the sampling.

        Returns
        -------
        ndarray, shape (...,)
            ``N**2 + B**2/(2 pi f) + K**2/(2 pi f)**2 + 4 Q**2 sin(pi f dt)**2/dt``, (rad/s)^2/Hz: [1]_ annex C. The
            ramp is no noise and has no part in it. A record of means over `dt` has the first three times
            ``sinc(f dt)**2``, and what folds back from above half the sampling frequency.

        Raises
        ------
        ValueError
            If a frequency is not positive, or there is quantization and no `dt`.
        """
        f = _positive_array("frequency", frequency, "Hz")
        N, B, K = self.angle_random_walk, self.bias_instability, self.rate_random_walk
        density = N**2 + B**2 / (2 * pi * f) + K**2 / (2 * pi * f) ** 2
        if not self.quantization:
            return density
        if dt is None:
            raise ValueError("`dt` must be given for errors with quantization, got None")
        dt = checks.positive("dt", dt, "s")
        return density + 4 * self.quantization**2 * np.sin(pi * f * dt) ** 2 / dt

    def to_frame(self, units: str = "si") -> pd.DataFrame:
        """Table with the index ``quantity`` and the columns ``value`` and ``unit``.

        Parameters
        ----------
        units : {"si", "gyro", "accelerometer"}, optional
            SI, or the units of data sheets.
        """
        import pandas as pd  # loaded where used

        table = UNITS[checks.option("units", units, UNITS)]
        rows = {name: (value / table[name][0], table[name][1]) for name, value in asdict(self).items()}
        return pd.DataFrame.from_dict(rows, orient="index", columns=["value", "unit"]).rename_axis("quantity")


def simulate(
    errors: RandomErrors, count: int, dt: float, rng: np.random.Generator, *, channels: int | None = None
) -> Array:
    """Record of random errors: mean rate over each sample.

    Bias instability and rate random walk have no level of their own: the first starts with a sample of 0, the second
    at 0. Work grows as ``count * ln(count)``; the peak of memory is 60 bytes per sample of one channel.

    Parameters
    ----------
    errors : RandomErrors
        Coefficients, the same for all channels.
    count : int
        Samples.
    dt : float
        Sampling time, s.
    rng : numpy.random.Generator
        Source of randomness.
    channels : int, optional
        Number of independent channels; None for one without an axis of its own.

    Returns
    -------
    ndarray, shape (count,) or (count, channels)
        Mean rate over each sample, rad/s.

    Notes
    -----
    Bias instability: the differences of successive means are stationary, with the covariance
    ``B**2 / (2 pi) * flicker_covariance(1, 1, lag)`` at every lag. They are drawn by circulant embedding [2]_ and
    summed. The embedding is exact, as no covariance but the one at lag 0 is positive and all sum to zero.

    Examples
    --------
    >>> rate = simulate(RandomErrors(angle_random_walk=1e-6), 1000, 0.01, np.random.default_rng(1), channels=3)
    >>> rate.shape
    (1000, 3)
    """
    checks.instance("errors", errors, RandomErrors)
    count = checks.integer("count", count, minimum=1)
    dt = checks.positive("dt", dt, "s")
    rng = checks.generator("rng", rng)
    amplitudes = _flicker_amplitudes(count) if errors.bias_instability and count > 1 else None
    if channels is None:
        return _channel(errors, count, dt, rng, amplitudes)
    rate = np.empty((count, checks.integer("channels", channels, minimum=1)))
    for column in rate.T:
        column[:] = _channel(errors, count, dt, rng, amplitudes)
    return rate


def quantize(rate: ArrayLike, dt: float, step: float) -> Array:
    """Rate as a sensor gives it that delivers whole steps of the angle and keeps the remainder for later.

    Parameters
    ----------
    rate : array_like, shape (n,) or (n, channels)
        Mean rate over each sample, rad/s.
    dt : float
        Sampling time, s.
    step : float
        Angle of one step, rad: ``sqrt(12)`` times the quantization coefficient Q, if the angle passes several steps
        per sample or is noisy by a step. The error of an angle that moves slower is no white noise.

    Returns
    -------
    ndarray, shape of `rate`
        Mean rate over each sample, rad/s, a multiple of ``step / dt`` each.

    Examples
    --------
    >>> quantize([0.4, 0.4, 0.4, 0.4, 0.4], 1.0, 1.0)
    array([0., 1., 0., 1., 0.])
    """
    rate = checks.finite_array("rate", rate)
    if rate.ndim not in (1, 2):
        raise ValueError(f"`rate` must be of shape (n,) or (n, channels), got {rate.shape}")
    dt, step = checks.positive("dt", dt, "s"), checks.positive("step", step, "rad")
    steps = np.rint(np.cumsum(rate * (dt / step), axis=0))
    return np.diff(steps, axis=0, prepend=0.0) * (step / dt)


def _channel(errors: RandomErrors, count: int, dt: float, rng: np.random.Generator, amplitudes: Array | None) -> Array:
    """Record of one channel."""
    rate = np.zeros(count)
    if errors.angle_random_walk:
        rate += errors.angle_random_walk / sqrt(dt) * rng.standard_normal(count)
    if amplitudes is not None:
        rate += errors.bias_instability * _flicker(count, rng, amplitudes)
    if errors.rate_random_walk:
        rate += errors.rate_random_walk * sqrt(dt) * _walk_means(count, rng)
    if errors.rate_ramp:
        rate += errors.rate_ramp * dt * (np.arange(count) + 0.5)
    if errors.quantization:
        half_step = sqrt(3) * errors.quantization  # a uniform error of the angle has the variance half_step**2 / 3
        rate += np.diff(rng.uniform(-half_step, half_step, count + 1)) / dt
    return rate


def _walk_means(count: int, rng: np.random.Generator) -> Array:
    """Means of a Wiener process over successive unit intervals."""
    step = rng.standard_normal(count)
    # within an interval: the chord has the mean step / 2, the bridge about it a mean of variance 1/12, independent
    means = step / 2 + sqrt(1 / 12) * rng.standard_normal(count)
    means[1:] += np.cumsum(step[:-1])
    return means


def _flicker_amplitudes(count: int) -> Array:
    """Amplitudes of the spectral lines of periodic flicker increments, enough for a record, shape (half + 1,)."""
    from scipy.fft import next_fast_len  # loaded where used

    half = next_fast_len(count, real=True)
    amplitudes = np.sqrt(half * embedding(half))
    amplitudes[[0, half]] *= sqrt(2)  # lines without an imaginary part, which has half of the power of the others
    return amplitudes


def _flicker(count: int, rng: np.random.Generator, amplitudes: Array) -> Array:
    """Means of flicker noise with B = 1 over successive intervals of any length, the first one 0."""
    from scipy.fft import irfft  # loaded where used

    lines = rng.standard_normal((amplitudes.size, 2))
    lines *= amplitudes[:, None]
    lines[[0, -1], 1] = 0.0
    increments = irfft(lines.view(np.complex128)[:, 0], 2 * (amplitudes.size - 1))
    means = np.zeros(count)
    np.cumsum(increments[: count - 1], out=means[1:])
    return means


def embedding(half: int) -> Array:
    """Spectrum of the periodic sequence, of twice the length, that carries the covariance of flicker increments.

    Parameters
    ----------
    half : int
        Largest lag whose covariance the sequence reproduces.

    Returns
    -------
    ndarray, shape (half + 1,)
        Discrete Fourier transform of the covariance ``flicker_covariance(1, 1, lag) / (2 pi)`` continued
        symmetrically; its smallest value, at frequency 0, is positive.
    """
    from scipy.fft import rfft  # loaded where used

    half = checks.integer("half", half, minimum=1)
    covariance = flicker_covariance(1, 1, np.arange(half + 1.0)) / (2 * pi)
    spectrum = rfft(np.concatenate([covariance, covariance[-2:0:-1]])).real
    # positive by theory, but at frequency 0 only 2 / (pi half): summed, it would drown in the rounding of large records
    spectrum[0] = _sum_of_covariances(half)
    if spectrum.min() < 0:
        raise ArithmeticError(f"the embedding of {half} flicker increments has the eigenvalue {spectrum.min():.3g}")
    return spectrum


def _sum_of_covariances(half: int) -> float:
    """Eigenvalue of the embedding at frequency 0, without the cancellation of summing its entries."""
    # A covariance is a second difference of D, itself one of t**2 ln|t|: those from -(half - 1) to half - 1 telescope
    before, last = second_difference_of_log(1, np.array([half - 1.0, half]))
    beyond = flicker_covariance(1, 1, np.array([half]))[0]
    return float(2 * (last - before) + beyond) / (2 * pi)


def _positive_array(name: str, value: ArrayLike, unit: str) -> Array:
    """Array of finite numbers above zero."""
    array = checks.finite_array(name, value)
    if not (array > 0).all():
        raise ValueError(f"`{name}` must be > 0 {unit}, got {array.min()}")
    return array
