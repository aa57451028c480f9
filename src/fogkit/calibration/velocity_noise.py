"""From random errors of sensors to the noise of what is fitted to a computed velocity.

A number that is linear in the computed velocity, such as the slope of a line through it, is linear in the increments
of the sensors, and so in their noise. With weights w_k of the velocity after k steps, an error of the velocity gained
in step p counts with ``a_p``, the sum of w_k over the k > p up to the next reset; one of the angle of step p tilts the
computed specific force from then on, resets or not, and counts with ``g dt (a_p / 2 + sum_{r > p} a_r)``: half of its
own step, as the angle grows during it. The signs are those of `fogkit.calibration.navigation_based.turn_model`: a tilt
theta changes the velocity by ``+g theta_2`` east and ``-g theta_1`` north per second.

The errors belong to the axes of the unit and are taken to east, north and up by its attitude in each step. Left out,
at 1e-2 of a deviation in a minute: the Schuler oscillation, the Earth's turn of a tilt, accelerations of the turn.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.imu.unit import MeasurementUnit
from fogkit.noise.increments import flicker_covariance
from fogkit.noise.processes import RandomErrors
from fogkit.rotation import dcm_from_rotvec
from fogkit.stand.turn_tests import TurnTest

Array = NDArray[np.float64]

_STEP_TOLERANCE = 1e-6  # of a step: durations that come from sums of decimal fractions


@dataclass(frozen=True, kw_only=True)
class SensorNoise:
    """Random errors of the six sensors of a unit.

    Parameters
    ----------
    gyros, accelerometers : RandomErrors or sequence of three of them, optional
        Of each gyro, and of each accelerometer with velocity for angle: `angle_random_walk` is then the velocity
        random walk, m/s/sqrt(s), and `quantization` a white error of the velocity, m/s. One stands for all three.

    Raises
    ------
    ValueError
        If there are not three, or one has a rate ramp, which is no noise: it is the same in every test.
    """

    gyros: RandomErrors | Sequence[RandomErrors] = field(default_factory=RandomErrors)
    accelerometers: RandomErrors | Sequence[RandomErrors] = field(default_factory=RandomErrors)

    def __post_init__(self) -> None:
        for name in ("gyros", "accelerometers"):
            given = getattr(self, name)
            three = (given,) * 3 if isinstance(given, RandomErrors) else tuple(given)
            if len(three) != 3:
                raise ValueError(f"`{name}` must be one `RandomErrors` or three, got {len(three)}")
            for one in three:
                if checks.instance(name, one, RandomErrors).rate_ramp:
                    raise ValueError(f"`{name}` must have no `rate_ramp`, which is no noise, got {one.rate_ramp}")
            object.__setattr__(self, name, three)

    @classmethod
    def of_unit(cls, unit: MeasurementUnit) -> "SensorNoise":
        """Noise of a simulated unit; its pulses count as quantization of a step over ``sqrt(12)``."""
        return cls(
            **{
                name: _with_pulses(getattr(checks.instance("unit", unit, MeasurementUnit), name))
                for name in ("gyros", "accelerometers")
            }
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Steps:
    """Steps of a test: where the dwells begin and end, and the attitude in each.

    Attributes
    ----------
    dt : float
        Duration of a step, s.
    turn_begin, turn_end, count : int
        Steps before the turn, before its end, and in all.
    C_b_n : ndarray, shape (count, 3, 3)
        Attitude in the middle of each step.
    """

    dt: float
    turn_begin: int
    turn_end: int
    count: int
    C_b_n: Array

    @classmethod
    def of(cls, test: TurnTest, dt: float, C_b_n: ArrayLike | None = None) -> "Steps":
        """Steps of a commanded test, its turn steady; or with attitudes, shape (count, 3, 3), that were navigated.

        Raises
        ------
        ValueError
            If a dwell or the turn is no whole number of steps, a dwell has less than 4, or attitudes are not one for
            each step.
        """
        dt = checks.positive("dt", dt, "s")
        (_, first), (second, end) = test.dwells
        edges = np.array([first, second, end]) / dt
        whole = np.rint(edges).astype(int)
        if (np.abs(edges - whole) > _STEP_TOLERANCE * edges).any() or whole[0] < 4 or whole[2] - whole[1] < 4:
            raise ValueError(
                f"`dt` must divide dwells and turn of test {test.label!r} into whole steps, at least 4 in a dwell, "
                f"got {edges.tolist()} steps up to their ends"
            )
        turn_begin, turn_end, count = (int(edge) for edge in whole)
        if C_b_n is None:
            share = np.clip((np.arange(count) + 0.5 - turn_begin) / (turn_end - turn_begin), 0, 1)
            C_b_n = test.C_b_n @ dcm_from_rotvec(share[:, None] * test.angle * test.axis)
        C_b_n = checks.finite_array("C_b_n", C_b_n, shape=(count, 3, 3))
        return cls(dt=dt, turn_begin=turn_begin, turn_end=turn_end, count=count, C_b_n=C_b_n)


def covariance(weights: ArrayLike, steps: Steps, noise: SensorNoise, gravity: float) -> Array:
    """Covariance of linear combinations of the computed velocity, each taken east, north and up.

    Parameters
    ----------
    weights : array_like, shape (m, count + 2) or (m, count + 1)
        Weights of the velocity after 0, 1, ... steps: first those up to the end of the turn, ``turn_end + 1`` of
        them; then those from there on, where the velocity begins anew from 0, ``count - turn_end + 1``. Or, one less,
        those of a velocity that is carried on through the turn.
    steps : Steps
        Steps and attitudes.
    noise : SensorNoise
        Random errors. Rate random walk and bias instability begin with 0 at the beginning of the test.
    gravity : float
        m/s^2.

    Returns
    -------
    ndarray, shape (3 m, 3 m)
        In the order of the combinations, each east, north, up; (m/s times the unit of the weights) squared.
    """
    velocity, angle = _influence(np.asarray(weights, dtype=float), steps, gravity)
    C = steps.C_b_n
    tilted = np.stack([C[:, 1], -C[:, 0], np.zeros_like(C[:, 0])], axis=1)  # what an angle does east, north, up
    total = np.zeros((3 * len(velocity),) * 2)
    for influence, axes, sensors in ((angle, tilted, noise.gyros), (velocity, C, noise.accelerometers)):
        for sensor, errors in enumerate(sensors):
            if errors != RandomErrors():
                counts = influence[:, None, :] * axes[:, :, sensor].T
                total += _of_increments(counts.reshape(-1, steps.count), errors, steps.dt)
    return total


def _with_pulses(sensors) -> tuple[RandomErrors, ...]:
    """Random errors of three sensors with the error of their counting in steps."""
    step = np.abs(sensors.pulse / sensors.triad.equivalents) / np.sqrt(12) if sensors.pulse else np.zeros(3)
    *others, quantization = sensors.random.squares
    return tuple(RandomErrors.from_squares([*others, quantization + q**2]) for q in step)


def _influence(weights: Array, steps: Steps, gravity: float) -> tuple[Array, Array]:
    """With what an error of the velocity and of the angle of each step counts, shape (m, count) each."""
    reset = [steps.turn_end + 1] if weights.shape[-1] == steps.count + 2 else []
    parts = np.split(weights, reset, axis=-1)
    velocity = np.concatenate([_sum_after(part)[:, :-1] for part in parts], axis=-1)
    return velocity, gravity * steps.dt * (_sum_after(velocity) + velocity / 2)


def _sum_after(values: Array) -> Array:
    """Sum of the entries that follow each entry, along the last axis."""
    return np.cumsum(values[:, ::-1], axis=-1)[:, ::-1] - values


def _of_increments(counts: Array, errors: RandomErrors, dt: float) -> Array:
    """Covariance of combinations of one sensor's increments, counts of shape (m, n)."""
    white, flicker, walk, _, quantization = errors.squares
    total = white * dt * (counts @ counts.T)
    if quantization:  # an angle's error enters one increment and, reversed, the next
        changes = np.diff(counts, axis=-1, prepend=0.0, append=0.0)
        total += quantization * (changes @ changes.T)
    if walk:  # a change of the rate counts with all that follows, which is linear in the time within a step
        rest = dt * np.pad(np.cumsum(counts[:, ::-1], axis=-1)[:, ::-1], ((0, 0), (0, 1)))
        left, right = rest[:, :-1], rest[:, 1:]
        mixed = left @ right.T
        total += walk * dt / 3 * (left @ left.T + right @ right.T + (mixed + mixed.T) / 2)
    if flicker:  # differences of successive means are stationary, with the covariance of `fogkit.noise.increments`
        rest = dt * _sum_after(counts)[:, :-1]
        total += flicker / (2 * np.pi) * rest @ _toeplitz_times(rest).T
    return total


def _toeplitz_times(rows: Array) -> Array:
    """Rows times the covariance matrix of flicker increments, by convolution."""
    from scipy.fft import irfft, next_fast_len, rfft  # loaded where used

    n = rows.shape[-1]
    lags = flicker_covariance(1, 1, np.arange(-(n - 1.0), n))
    size = next_fast_len(3 * n, real=True)
    return irfft(rfft(rows, size) * rfft(lags, size), size)[:, n - 1 : 2 * n - 1]
