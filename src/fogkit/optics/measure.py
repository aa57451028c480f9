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
from fogkit.optics.compensation import AfterLoop, InsideLoop, after_loop
from fogkit.optics.gyro import ClosedLoopGyro
from fogkit.optics.motion import AngularOscillation, Motion, Ramp
from fogkit.optics.simulate import LoopRecord, run, stream
from fogkit.results import Record

WINDOW_POWER = 6
"""Power of the sine that weights a record: its spectrum falls with the seventh power of the number of cycles."""


@dataclass(frozen=True, kw_only=True)
class DriftMeasurement(Record):
    """Mean reading of a shaken gyro.

    Attributes
    ----------
    drift : float
        Weighted mean of the reading, rad/s.
    standard_deviation : float
        Its standard deviation from detector noise, rad/s; 0 without noise.
    leakage : float
        What the window may have left of the oscillation, at most, rad/s.
    duration : float
        Length of the record, s.
    samples : int
        Simulated half-periods.
    """

    drift: float
    standard_deviation: float
    leakage: float
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
        Weighted mean; what it keeps of an oscillation is at most `leakage`.
    """
    values = checks.finite_array("values", values, ndim=1)
    weights = _weights(0, values.size, values.size)
    return float(weights @ values / weights.sum())


def leakage(cycles: float) -> float:
    """Largest share of an oscillation of so many cycles that `windowed_mean` leaves, half-way between its nulls.

    Parameters
    ----------
    cycles : float
        Cycles in the record, more than 3.

    Examples
    --------
    >>> f"{leakage(20):.0e}"
    '9e-09'
    """
    checks.in_open_interval("cycles", cycles, 3.0, np.inf)
    return float(36 / (np.pi * cycles**7) / np.prod(1 - np.arange(1, 4) ** 2 / cycles**2))


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
        If the shapes differ, the record has too few readings for the fit, or the times do not tell the harmonics apart.
    """
    harmonics = checks.integer("harmonics", harmonics, minimum=1)
    time = checks.finite_array("time", time, ndim=1, min_size=2 * harmonics + 2)
    values = checks.finite_array("values", values, shape=time.shape)
    angle = 2 * np.pi * checks.positive("frequency", frequency, "Hz") * time
    orders = np.arange(1, harmonics + 1)
    columns = np.concatenate(
        [np.ones((time.size, 1)), np.cos(angle[:, None] * orders), np.sin(angle[:, None] * orders)], axis=1
    )
    solution, _, rank, _ = np.linalg.lstsq(columns, values, rcond=1e-10)
    if rank < columns.shape[1]:
        raise ValueError(
            f"`time` must tell {harmonics} harmonics of {frequency:.6g} Hz and the mean apart, got times that do not: "
            "a harmonic is a multiple of the sampling rate, or the record is far shorter than a cycle"
        )
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
        Record whose `rate` and `residual` are the differences, and `true_rate` zero: neither oscillation nor lag
        is left in them.
    """
    silent = _silent(gyro)
    full = run(silent, motion, duration, degree=degree, **options)
    options.pop("compensation", None)
    linear = run(silent, motion, duration, degree=1, **options)
    return replace(
        full,
        rate=full.rate - linear.rate,
        residual=full.residual - linear.residual,
        true_rate=np.zeros_like(full.true_rate),
    )


def simulated_drift(
    gyro: ClosedLoopGyro,
    oscillation: AngularOscillation,
    duration: float | None = None,
    *,
    compensation: InsideLoop | AfterLoop | None = None,
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
        Length of the record, s, at least 20 cycles; by default 60 cycles or 4000 regulation periods, whichever is
        longer.
    compensation : InsideLoop or AfterLoop, optional
        Remedy against the drift. `AfterLoop` needs the record as a whole, in memory.
    **options
        As in `simulate.stream`: degree, rng, on_lock_loss, ...

    Returns
    -------
    DriftMeasurement
        Mean under a sixth-power sine window, which also takes the start of the loop out.

    Raises
    ------
    ValueError
        If `duration` is shorter than 20 cycles of the oscillation.
    TypeError
        If `oscillation` is another motion: its mean would need another window.
    """
    checks.instance("gyro", gyro, ClosedLoopGyro)
    checks.instance(
        "oscillation", oscillation, AngularOscillation, fix="Use `simulate.run` and `windowed_mean` for others"
    )
    period = gyro.loop.regulation_period
    if duration is None:
        duration = max(60 / oscillation.frequency, 4000 * period)
    cycles = checks.positive("duration", duration, "s") * oscillation.frequency
    if cycles < 20:
        raise ValueError(
            f"`duration` must be at least 20 cycles of the oscillation, {20 / oscillation.frequency:.6g} s, "
            f"got {duration:.6g} s: "
            "a shorter record mixes the oscillation into its mean"
        )
    periods = int(np.floor(duration / period * (1 + 1e-12)))
    total = weight = squares = 0.0
    done = 0
    if isinstance(compensation, AfterLoop):
        record = after_loop(run(gyro, oscillation, periods * period, **options), compensation)
        blocks, periods = [record], record.rate.size
    else:
        blocks = stream(gyro, oscillation, periods * period, compensation=compensation, **options)
    for block in blocks:
        weights = _weights(done, block.rate.size, periods)
        total += weights @ block.rate
        weight += weights.sum()
        squares += weights @ weights
        done += block.rate.size
    noise = gyro.angle_random_walk / np.sqrt(period) * np.sqrt(squares) / weight
    return DriftMeasurement(
        drift=float(total / weight),
        standard_deviation=float(noise),
        leakage=oscillation.rate_amplitude * leakage(cycles),
        duration=periods * period,
        samples=periods * gyro.loop.half_periods,
    )


def largest_acceleration_in_lock(gyro: ClosedLoopGyro, frequency: float, *, cycles: int = 5) -> float:
    """Amplitude of angular acceleration up to which a gyro keeps its fringe under angular oscillation.

    Parameters
    ----------
    gyro : ClosedLoopGyro
        The gyro; its noise is left out.
    frequency : float
        Frequency of the oscillation, Hz.
    cycles : int, optional
        Cycles that have to be survived.

    Returns
    -------
    float
        Amplitude, rad/s^2, found by bisection of its logarithm to 1 %.
    """
    silent = _silent(gyro)
    # between a residual of 1e-3 rad in the linear loop and one that no loop holds
    unit = 1 / (gyro.coil.sagnac_scale_factor * gyro.loop.regulation_period)
    low, high = 1e-3 * gyro.loop.gain * unit, 1e4 * unit
    while high / low > 1.01:
        middle = np.sqrt(low * high)
        oscillation = AngularOscillation(acceleration=middle, frequency=frequency)
        lost = run(silent, oscillation, cycles / frequency, on_lock_loss="nan").lock_lost_at
        low, high = (middle, high) if np.isnan(lost) else (low, middle)
    return float(low)


def simulated_noise_bias(
    gyro: ClosedLoopGyro,
    remedy: InsideLoop | AfterLoop,
    rng: np.random.Generator,
    *,
    runs: int = 16,
    duration: float = 1.0,
) -> tuple[float, float]:
    """What a remedy adds to the mean reading of a noisy gyro at rest, from pairs of runs with the same noise.

    Parameters
    ----------
    gyro : ClosedLoopGyro
        The gyro with its noise levels.
    remedy : InsideLoop or AfterLoop
        The correction.
    rng : numpy.random.Generator
        Source of the noise; each pair of runs has a generator spawned from it.
    runs : int, optional
        Pairs of runs, at least 2.
    duration : float, optional
        Length of a run, s.

    Returns
    -------
    bias, standard_deviation : float
        Mean over the runs and its standard deviation from their scatter, rad/s.

    Raises
    ------
    ValueError
        If `runs` is below 2.
    TypeError
        If `rng` is not a generator.
    """
    rest = Ramp(acceleration=0.0)
    shifts = []
    for source in checks.generator("rng", rng).spawn(checks.integer("runs", runs, minimum=2)):
        state = source.bit_generator.state
        plain = run(gyro, rest, duration, rng=source)
        if isinstance(remedy, InsideLoop):
            source.bit_generator.state = state
            shifts.append(np.mean(run(gyro, rest, duration, rng=source, compensation=remedy).rate - plain.rate))
        else:  # against feedback plus residual, which is the reading that the remedy corrects
            corrected = after_loop(plain, remedy)
            kept = np.isin(plain.time, corrected.time)
            shifts.append(np.mean(corrected.rate - (plain.rate + plain.residual)[kept]))
    return float(np.mean(shifts)), float(np.std(shifts, ddof=1) / np.sqrt(len(shifts)))


def _silent(gyro: ClosedLoopGyro) -> ClosedLoopGyro:
    return replace(gyro, detector_noise=0.0, shot_noise=0.0, intensity_noise=0.0)


def _weights(first: int, count: int, total: int) -> NDArray[np.float64]:
    """Part of a sine-power window of `total` points."""
    return np.sin(np.pi * (first + 0.5 + np.arange(count)) / total) ** WINDOW_POWER
