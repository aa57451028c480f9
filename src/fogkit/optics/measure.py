"""The mean of a shaken gyro, taken properly.

The oscillation that makes a drift of tenths of a degree per hour passes through the reading with an amplitude a hundred
thousand times larger. A plain mean over a record that is no whole number of cycles, or that holds the start of the
loop, keeps some of it. Either the record is weighted by a window whose spectrum falls fast enough (`windowed_mean`), or
the oscillation is fitted along with the mean (`harmonic_fit`), or, in a simulation, a linear loop is run on the same
samples and subtracted (`nonlinear_error`).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.optics.gyro import ClosedLoopGyro
from fogkit.optics.motion import AngularOscillation, Motion
from fogkit.optics.simulate import LoopRecord, run, stream

WINDOW_POWER = 6
"""Power of the sine that weights a record: its spectrum falls with the seventh power of the number of cycles."""


@dataclass(frozen=True, kw_only=True)
class DriftMeasurement:
    """Mean reading of a shaken gyro.

    Attributes
    ----------
    drift : float
        Weighted mean of the reading, rad/s.
    standard_deviation : float
        Its standard deviation from detector noise, rad/s; 0 without noise.
    duration : float
        Length of the record, s.
    samples : int
        Simulated half-periods.
    """

    drift: float
    standard_deviation: float
    duration: float
    samples: int


def windowed_mean(values: ArrayLike) -> float:
    """Mean of a record under a sixth-power sine window.

    Parameters
    ----------
    values : array_like, shape (n,)
        Evenly spaced readings, of 10 or more cycles of whatever oscillation is to be suppressed.

    Returns
    -------
    float
        Weighted mean. An oscillation with N cycles in the record leaks about ``36 / (pi N**7)`` of its amplitude at
        most.
    """
    values = checks.finite_array("values", values, ndim=1)
    weights = _weights(0, values.size, values.size)
    return float(weights @ values / weights.sum())


def harmonic_fit(time: ArrayLike, values: ArrayLike, frequency: float, harmonics: int = 3) -> tuple[float, float]:
    """Mean of a record with an oscillation of known frequency and its harmonics fitted by least squares.

    Parameters
    ----------
    time, values : array_like, shape (n,)
        Times, s, and readings.
    frequency : float
        Fundamental frequency, Hz, positive.
    harmonics : int, optional
        Multiples of the frequency that are fitted, 1 or more.

    Returns
    -------
    mean, standard_deviation : float
        Estimate and its standard deviation from the scatter about the fit, taken as white.

    Raises
    ------
    ValueError
        If the shapes differ or the record has too few readings for the fit.
    """
    harmonics = checks.integer("harmonics", harmonics, minimum=1)
    time = checks.finite_array("time", time, ndim=1, min_size=2 * harmonics + 2)
    values = checks.finite_array("values", values, shape=time.shape)
    angle = 2 * np.pi * checks.positive("frequency", frequency, "Hz") * time
    orders = np.arange(1, harmonics + 1)
    columns = np.concatenate(
        [np.ones((time.size, 1)), np.cos(angle[:, None] * orders), np.sin(angle[:, None] * orders)], axis=1
    )
    solution, *_ = np.linalg.lstsq(columns, values, rcond=None)
    scatter = values - columns @ solution
    variance = scatter @ scatter / (time.size - columns.shape[1])
    return float(solution[0]), float(np.sqrt(variance * np.linalg.inv(columns.T @ columns)[0, 0]))


def nonlinear_error(
    gyro: ClosedLoopGyro,
    motion: Motion | Callable | ArrayLike,
    duration: float | None = None,
    *,
    degree: int | None = None,
    **options,
) -> LoopRecord:
    """Reading of a noiseless gyro less that of the same loop with a linear interferometer.

    Parameters
    ----------
    gyro, motion, duration, degree, **options
        As in `simulate.stream`. Detector noise is left out.

    Returns
    -------
    LoopRecord
        Record whose `rate` and `residual` are the differences: neither the oscillation nor the lag is left in them.
    """
    silent = replace(gyro, detector_noise=0.0, shot_noise=0.0, intensity_noise=0.0)
    full = run(silent, motion, duration, degree=degree, **options)
    options.pop("compensation", None)
    linear = run(silent, motion, duration, degree=1, **options)
    return replace(full, rate=full.rate - linear.rate, residual=full.residual - linear.residual)


def simulated_drift(
    gyro: ClosedLoopGyro,
    oscillation: AngularOscillation,
    duration: float | None = None,
    **options,
) -> DriftMeasurement:
    """Mean reading of a simulated gyro on a vibrator, streamed.

    Parameters
    ----------
    gyro : ClosedLoopGyro
        The gyro.
    oscillation : AngularOscillation
        Motion of the case.
    duration : float, optional
        Length of the record, s, at least 10 cycles; by default 60 cycles or 4000 regulation periods, whichever is
        longer.
    **options
        As in `simulate.stream`: degree, rng, compensation, on_lock_loss, ...

    Returns
    -------
    DriftMeasurement
        Mean under a sixth-power sine window, which also takes the start of the loop out.

    Raises
    ------
    ValueError
        If `duration` is shorter than 10 cycles of the oscillation.
    """
    period = gyro.loop.regulation_period
    if duration is None:
        duration = max(60 / oscillation.frequency, 4000 * period)
    if duration * oscillation.frequency < 10:
        raise ValueError(
            f"`duration` must be at least 10 cycles of the oscillation, {10 / oscillation.frequency:.6g} s, "
            f"got {duration:.6g} s: "
            "a shorter record mixes the oscillation into its mean"
        )
    periods = int(np.floor(duration / period * (1 + 1e-12)))
    total = weight = squares = 0.0
    done = 0
    for block in stream(gyro, oscillation, periods * period, **options):
        weights = _weights(done, block.rate.size, periods)
        total += weights @ block.rate
        weight += weights.sum()
        squares += weights @ weights
        done += block.rate.size
    noise = gyro.angle_random_walk / np.sqrt(period) * np.sqrt(squares) / weight
    return DriftMeasurement(
        drift=float(total / weight),
        standard_deviation=float(noise),
        duration=periods * period,
        samples=periods * gyro.loop.half_periods,
    )


def _weights(first: int, count: int, total: int) -> NDArray[np.float64]:
    """Part of a sine-power window of `total` points."""
    return np.sin(np.pi * (first + 0.5 + np.arange(count)) / total) ** WINDOW_POWER
