"""The gyro in the time domain, half-period by half-period of its modulation.

In half-period n the wave pair carries the Sagnac phase of the rate at its middle, less the feedback step, plus the bias
of the state that is due, and the detector sees `interferometer.power` of that. After k half-periods the controller of
`loop` corrects the feedback. The feedback is a phase ramp with 2-pi resets; a wrong drive voltage (`Loop.v_pi_error`)
makes its steps, its resets and the bias too large by the same factor. The rate is taken as constant during a
half-period: its mean over the transit time differs from its middle by ``(pi f tau)**2 / 6``, 4e-5 at 1 kHz.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.optics import _kernels
from fogkit.optics.compensation import InsideLoop, warn_if_idle
from fogkit.optics.gyro import ClosedLoopGyro
from fogkit.optics.interferometer import taylor_coefficients
from fogkit.optics.motion import Motion, SampledMotion, as_motion

if TYPE_CHECKING:
    from pandas import DataFrame

SAMPLES_PER_BLOCK = 65536
LOCK_LIMIT = np.pi
"""Residual phase at which the pull of the loop changes sign, rad: beyond it the loop is drawn to another fringe."""


class FringeLockError(RuntimeError):
    """The residual phase left the fringe that the loop holds, at `time`, s, and a true rate of `rate`, rad/s."""

    def __init__(self, time: float, rate: float) -> None:
        super().__init__(
            f"fringe lock lost at {time:.9g} s, at a rate of {rate:.6g} rad/s: the residual phase passed pi. "
            "Lower the angular acceleration, raise the gain or shorten the regulation period; "
            "with `on_lock_loss='nan'` the record goes on with NaN"
        )
        self.time = time
        self.rate = rate

    def __reduce__(
        self,
    ) -> tuple:  # an exception is rebuilt from its message otherwise, and dies on its way out of a pool
        return type(self), (self.time, self.rate)


@dataclass(frozen=True, kw_only=True, eq=False)
class LoopRecord:
    """What a gyro and its simulation have to say of n successive regulation periods.

    Attributes
    ----------
    gyro : ClosedLoopGyro
        The gyro.
    time : ndarray, shape (n,)
        Middle of each regulation period, s.
    rate : ndarray, shape (n,)
        The reading: rate fed back during the period, rad/s.
    residual : ndarray, shape (n,)
        Demodulated residual of the period, as a rate, rad/s.
    true_rate : ndarray, shape (n,)
        Mean of the true rate over the period, rad/s.
    resets : float
        2-pi resets of the ramp from the start of the simulation to the end of the record.
    lock_lost_at : float
        Time at which fringe lock was lost, s, or NaN; all later readings are NaN.

    Notes
    -----
    A record of a real gyro has no `true_rate`, `resets` and `lock_lost_at`: left out, they are NaN.
    """

    gyro: ClosedLoopGyro
    time: NDArray[np.float64]
    rate: NDArray[np.float64]
    residual: NDArray[np.float64]
    true_rate: NDArray[np.float64] | None = None
    resets: float = np.nan
    lock_lost_at: float = np.nan

    def __post_init__(self) -> None:
        checks.instance("gyro", self.gyro, ClosedLoopGyro)
        if self.true_rate is None:
            object.__setattr__(self, "true_rate", np.full(np.shape(self.rate), np.nan))

    @property
    def error(self) -> NDArray[np.float64]:
        """Reading less truth, rad/s, shape (n,): the lag of the loop included."""
        return self.rate - self.true_rate

    def to_frame(self) -> "DataFrame":
        """Table of readings, index time in s, columns ``rate``, ``residual``, ``true_rate`` in rad/s."""
        import pandas as pd

        columns = {name: getattr(self, name) for name in ("rate", "residual", "true_rate")}
        return pd.DataFrame(columns, index=pd.Index(self.time, name="time"))


def run(
    gyro: ClosedLoopGyro,
    motion: Motion | Callable | ArrayLike,
    duration: float | None = None,
    **options,
) -> LoopRecord:
    """Simulate a gyro and keep every regulation period.

    Parameters
    ----------
    gyro, motion, duration, **options
        As in `stream`.

    Returns
    -------
    LoopRecord
        All regulation periods in one record.

    Examples
    --------
    >>> from fogkit.optics import Coil, ClosedLoopGyro, Loop
    >>> from fogkit.optics.motion import Ramp
    >>> coil = Coil(length=1000, diameter=0.1)
    >>> gyro = ClosedLoopGyro(coil=coil, loop=Loop(depth=np.pi / 2, half_period=coil.transit_time, half_periods=16))
    >>> record = run(gyro, Ramp(acceleration=0.0, rate=0.1), duration=0.01)
    >>> round(float(record.rate[-1]), 9)
    0.1
    """
    blocks = list(stream(gyro, motion, duration, **options))
    arrays = {
        name: np.concatenate([getattr(b, name) for b in blocks]) for name in ("time", "rate", "residual", "true_rate")
    }
    return LoopRecord(gyro=gyro, **arrays, resets=blocks[-1].resets, lock_lost_at=blocks[-1].lock_lost_at)


def stream(
    gyro: ClosedLoopGyro,
    motion: Motion | Callable | ArrayLike,
    duration: float | None = None,
    *,
    degree: int | None = None,
    rng: np.random.Generator | None = None,
    initial_rate: float | None = None,
    compensation: InsideLoop | None = None,
    on_lock_loss: str = "raise",
) -> Iterator[LoopRecord]:
    """Simulate a gyro, a block of regulation periods at a time, in memory that does not grow with the duration.

    Parameters
    ----------
    gyro : ClosedLoopGyro
        The gyro.
    motion : Motion, callable or array_like, shape (n,)
        Rotation of the case: a motion of `fogkit.optics.motion`, a function of times in s that returns rates in rad/s,
        or the rates themselves, one per half-period, a whole number of regulation periods.
    duration : float, optional
        Length of the simulation, s; rounded down to whole regulation periods. Only an array of rates brings its own.
    degree : int, optional
        Degree of the Taylor polynomial that stands for the interferometer in each bias state; None is the exact
        response.
    rng : numpy.random.Generator, optional
        Source of the detector noise; needed if the gyro has any.
    initial_rate : float, optional
        Rate in the register at the start, rad/s; None is the true rate of the first half-period.
    compensation : InsideLoop, optional
        Correction of the demodulated phase inside the loop.
    on_lock_loss : {"raise", "nan"}, optional
        Whether loss of fringe lock raises or fills the rest with NaN. The watch is off for ``degree=1``, which has no
        fringes.

    Yields
    ------
    LoopRecord
        The next block, in time order.

    Raises
    ------
    ValueError
        If `motion` is not finite or not a whole number of regulation periods, or `duration` is shorter than one.
    TypeError
        If the gyro is noisy and `rng` is not a generator, or `compensation` is not an InsideLoop.
    FringeLockError
        If fringe lock is lost and `on_lock_loss` is ``"raise"``.
    """
    checks.instance("gyro", gyro, ClosedLoopGyro)
    motion = as_motion(motion)
    periods = _whole_periods(gyro, motion, duration)
    checks.option("on_lock_loss", on_lock_loss, ("raise", "nan"))
    parameters = _kernel_parameters(gyro, degree, compensation)
    if gyro.is_noisy:
        checks.generator("rng", rng)
    return _blocks(gyro, motion, periods, parameters, rng if gyro.is_noisy else None, initial_rate, on_lock_loss)


def _blocks(gyro, motion, periods, parameters, rng, initial_rate, on_lock_loss) -> Iterator[LoopRecord]:
    loop, to_phase = gyro.loop, gyro.coil.sagnac_scale_factor
    k = loop.half_periods
    state = np.zeros(4 + loop.delay + parameters["lag"])
    lock_lost_at = np.nan
    for first in range(0, periods, max(1, SAMPLES_PER_BLOCK // k)):
        count = min(max(1, SAMPLES_PER_BLOCK // k), periods - first)
        rates = motion.sample(first * k, count * k, loop.half_period)
        rates = checks.finite_array("motion", rates, shape=(count * k,))
        if first == 0:
            start = rates[0] if initial_rate is None else checks.finite("initial_rate", initial_rate, "rad/s")
            state[0] = to_phase * start
        true_rate = np.empty(count)
        _kernels.period_means(rates, k, true_rate)
        feedback, residual = np.full(count, np.nan), np.full(count, np.nan)
        if np.isnan(lock_lost_at):
            noise = np.empty(0) if rng is None else rng.standard_normal(count * k)
            lost = _kernels.advance(
                phase_in=to_phase * rates, noise=noise, first_period=first, state=state,
                out_feedback=feedback, out_residual=residual, **parameters,
            )  # fmt: skip
            if lost >= 0:
                lock_lost_at = (first * k + lost) * loop.half_period
                if on_lock_loss == "raise":
                    raise FringeLockError(lock_lost_at, rates[lost])
                feedback[lost // k :], residual[lost // k :] = np.nan, np.nan
        yield LoopRecord(
            gyro=gyro,
            time=(first + 0.5 + np.arange(count)) * loop.regulation_period,
            rate=feedback / to_phase,
            residual=residual / to_phase,
            true_rate=true_rate,
            resets=float(state[3]),
            lock_lost_at=lock_lost_at,
        )


def _whole_periods(gyro: ClosedLoopGyro, motion: Motion, duration: float | None) -> int:
    """Regulation periods to simulate."""
    k = gyro.loop.half_periods
    if isinstance(motion, SampledMotion):
        if duration is not None:
            raise ValueError(
                "`duration` must be left out where `motion` is an array of rates, which has its own length"
            )
        periods, left = divmod(len(motion.rates), k)
        if left:
            raise ValueError(
                f"`motion` must hold a whole number of regulation periods of {k} half-periods, "
                f"got {len(motion.rates)} rates. "
                + (f"Drop the last {left} or add {k - left}" if periods else f"Add {k - left}")
            )
        return periods
    if duration is None:
        raise ValueError("`duration` must be given, in s, where `motion` is a function of time")
    # a duration that is whole periods but for rounding counts as whole
    periods = int(np.floor(checks.positive("duration", duration, "s") / gyro.loop.regulation_period * (1 + 1e-12)))
    if periods < 1:
        raise ValueError(
            f"`duration` must be at least one regulation period, {gyro.loop.regulation_period:.6g} s, got {duration}"
        )
    return periods


def _kernel_parameters(gyro: ClosedLoopGyro, degree: int | None, compensation: InsideLoop | None) -> dict:
    """Arguments of the kernel that stay the same from block to block."""
    loop = gyro.loop
    if degree is None:
        taylor = (np.empty(0), np.empty(0))
    else:
        degree = checks.integer("degree", degree, minimum=1)
        taylor = tuple(taylor_coefficients(sign * loop.actual_depth, degree) for sign in (-1, 1))
    inside = InsideLoop() if compensation is None else compensation
    if compensation is not None:
        warn_if_idle(gyro)
    if not isinstance(inside, InsideLoop):
        raise TypeError(
            f"`compensation` must be an InsideLoop, got {type(inside).__name__}. "
            "Correct a finished record with `compensation.after_loop`"
        )
    return {
        "noise_levels": np.array([gyro.detector_noise, gyro.shot_noise, gyro.intensity_noise]),
        "pattern": loop.bias_pattern,
        "order_signs": loop.order_signs,
        "depth": loop.actual_depth,
        "nominal_depth": loop.depth,
        "gain": float(loop.gain),
        "second_gain": float(loop.second_gain),
        "delay": loop.delay,
        "step_scale": 1.0 + loop.v_pi_error,
        "taylor_minus": taylor[0],
        "taylor_plus": taylor[1],
        "law": _kernels.UNCOMPENSATED if compensation is None else _kernels.LAWS[inside.law],
        "lag": inside.lag,
        "compensation_depth": loop.depth if inside.depth is None else inside.depth,
        "lock_limit": np.inf if degree == 1 else LOCK_LIMIT,
    }
