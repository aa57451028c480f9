"""What a gyrocompass records, and what its aid says: simulated from a motion, or filled in from one's own data.

References
----------
.. [1] Le Van Chang, Gyrocompass with a quasi-harmonic autocompensating mount (in Russian), thesis abstract, LETI,
   St Petersburg, 2015, chapter 2.
"""

import warnings
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.constants import STANDARD_GRAVITY
from fogkit.gyrocompass.covariance import Aid, Noise, Prior
from fogkit.gyrocompass.error_model import MEASUREMENTS
from fogkit.gyrocompass.frames import mount_attitude, pyramid_axes
from fogkit.gyrocompass.laws import COARSEST_STEP
from fogkit.gyrocompass.mechanisation import CompassState
from fogkit.gyrocompass.motions import Motion
from fogkit.units import DEG_PER_SECOND

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Recording:
    """Increments over equally spaced steps, and angles of the mount between them.

    Parameters
    ----------
    dt : float
        Step, s.
    dtheta : array_like, shape (n, 3)
        Integrals of what the gyros x, y, z of the mount read over each step, rad.
    dv : array_like, shape (n, 3)
        Integrals of the specific force over each step, forward, up, starboard of the hull, m/s.
    mount_angle : array_like, shape (n + 1,)
        Angle of the mount at the ends of the steps, rad, counter-clockwise from above.
    gravity : float, optional
        Gravity on the sphere at the place, m/s^2.
    axes : array_like, shape (3, 3), optional
        ``C_p_m``, the gyros' input axes in the mount; those of the pyramid if not given.

    Raises
    ------
    ValueError
        If an entry is not finite, a shape does not fit, or the mount turns by more than half a turn in a step.

    Warns
    -----
    UserWarning
        If the mount turns by more than `fogkit.gyrocompass.laws.COARSEST_STEP` in a step.
    """

    dt: float
    dtheta: ArrayLike
    dv: ArrayLike
    mount_angle: ArrayLike
    gravity: float = STANDARD_GRAVITY
    axes: ArrayLike = field(default_factory=pyramid_axes)

    def __post_init__(self) -> None:
        object.__setattr__(self, "dt", checks.positive("dt", self.dt, "s"))
        object.__setattr__(self, "gravity", checks.positive("gravity", self.gravity, "m/s^2"))
        dtheta = checks.finite_array("dtheta", self.dtheta, shape=(None, 3))
        dv = checks.finite_array("dv", self.dv, shape=dtheta.shape)
        mount = checks.finite_array("mount_angle", self.mount_angle, shape=(len(dtheta) + 1,), fix="One at each end.")
        largest = np.abs(np.diff(mount)).max()
        if largest > np.pi:
            raise ValueError(
                f"`mount_angle` must not change by more than pi in a step, got {largest:.3g} rad: unwrap it "
                "(`numpy.unwrap`), or sample faster"
            )
        if largest > COARSEST_STEP:
            warnings.warn(
                f"`mount_angle` changes by up to {largest:.3g} rad in a step of {self.dt:g} s; beyond "
                f"{COARSEST_STEP:g} rad what the hull does in a step is smeared over its turn. Sample faster",
                UserWarning,
                stacklevel=3,
            )
        axes = checks.rotation_matrix("axes", self.axes)
        for name, value in (("dtheta", dtheta), ("dv", dv), ("mount_angle", mount), ("axes", axes)):
            object.__setattr__(self, name, np.ascontiguousarray(value))

    @property
    def duration(self) -> float:
        """Length, s."""
        return self.dt * len(self.dtheta)


@dataclass(frozen=True, kw_only=True)
class Fixes:
    """What an aid measured.

    Parameters
    ----------
    time : array_like, shape (m,)
        Times for which the measurements hold, s from the start of the recording, ascending.
    values : array_like, shape (m, 6)
        Velocity north, up, east, m/s, latitude, longitude, rad, and height, m; NaN where one was not measured or lost.
    aid : Aid
        Standard deviations, and the interval at which measurements are expected.

    Raises
    ------
    ValueError
        If times do not ascend, nothing at all was measured, or something was for which `aid` has no standard deviation.
    """

    time: ArrayLike
    values: ArrayLike
    aid: Aid

    def __post_init__(self) -> None:
        checks.instance("aid", self.aid, Aid)
        foreign = [name for name in self.aid.std if name not in MEASUREMENTS]
        if foreign:
            raise ValueError(f"`aid` must measure velocity and position only, {MEASUREMENTS}, got {foreign[0]!r}")
        time = checks.finite_array("time", self.time, ndim=1)
        if (np.diff(time) < 0).any():
            at = int(np.argmax(np.diff(time) < 0))
            raise ValueError(
                f"`time` must ascend, got {time[at + 1]:g} s after {time[at]:g} s: sort late measurements in"
            )
        try:
            values = np.array(self.values, dtype=float)
        except (TypeError, ValueError):
            raise TypeError("`values` must hold real numbers, and NaN where there is none") from None
        if values.shape != (len(time), 6):
            raise ValueError(f"`values` must be of shape ({len(time)}, 6), got {values.shape}")
        measured = np.isfinite(values)
        if np.isinf(values).any() or not measured.any():
            raise ValueError(
                "`values` must hold numbers, and NaN where there is none; an unaided filter observes nothing"
            )
        for name, there in zip(MEASUREMENTS, measured.any(axis=0), strict=True):
            if there and name not in self.aid.std:
                raise ValueError(
                    f"`aid` must have a standard deviation of {name!r}, of which `values` has measurements"
                )
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "values", np.ascontiguousarray(values))

    @property
    def variances(self) -> Array:
        """Variances of the six measurements, NaN for those that the aid does not make: shape (6,)."""
        return np.array([self.aid.std.get(name, np.nan) ** 2 for name in MEASUREMENTS])


def record(
    motion: Motion,
    noise: Noise,
    rng: np.random.Generator,
    *,
    bias: ArrayLike = (0.0, 0.0, 0.0),
    scale_factor: ArrayLike = (0.0, 0.0, 0.0),
    mount_reading: ArrayLike | None = None,
    gyro_range: float = np.inf,
) -> Recording:
    """Record of a motion by sensors with errors.

    Parameters
    ----------
    motion : Motion
        True motion; its step is that of the record.
    noise : Noise
        White noise of gyros and accelerometers, random walk of the gyros' biases.
    rng : numpy.random.Generator
        Source of the noise.
    bias, scale_factor : array_like, shape (3,), optional
        Of the gyros x, y, z, rad/s and 1.
    mount_reading : array_like, shape (n,), optional
        What the angle sensor of the mount reads at the times of the motion, rad (`fogkit.gyrocompass.encoder`); the
        true angle if not given.
    gyro_range : float, optional
        Largest rate that a gyro can read, rad/s.

    Raises
    ------
    ValueError
        If the motion asks a gyro to read more than its range.

    Returns
    -------
    Recording
        One step less than `motion` has times.

    Notes
    -----
    Increments of the hull are integrals of the cubic through four readings. What the gyros then see of it on the mount
    follows from the angles at the ends of a step, so that a mount may be switched on with any rate
    (`fogkit.gyrocompass.mechanisation.hull_increments` is the way back).
    """
    rng = checks.generator("rng", rng)
    dt = checks.instance("motion", motion, Motion).dt
    _check_range(motion, gyro_range)
    angle = motion.mount_angle
    rates = motion.rates @ motion.axes.T
    rates[:, 1] -= motion.mount_rate
    hull = _integrals((mount_attitude(angle) @ rates[..., np.newaxis])[..., 0], dt)
    way, middle = np.diff(angle), mount_attitude((angle[1:] + angle[:-1]) / 2)
    in_mount = (middle.swapaxes(-1, -2) @ hull[..., np.newaxis])[..., 0]
    in_mount[:, [0, 2]] *= np.sinc(way / (2 * np.pi))[:, np.newaxis]
    in_mount[:, 1] += way
    gyros = in_mount @ motion.axes * (1 + checks.finite_array("scale_factor", scale_factor, shape=(3,)))
    shape = gyros.shape
    drift = checks.instance("noise", noise, Noise).rate_random_walk * np.sqrt(dt) * rng.standard_normal(shape)
    gyros += (checks.finite_array("bias", bias, shape=(3,)) + np.cumsum(drift, axis=0)) * dt
    gyros += np.asarray(noise.angle_random_walk) * np.sqrt(dt) * rng.standard_normal(shape)
    dv = _integrals(motion.specific_force, dt)
    dv = dv + noise.velocity_random_walk * np.sqrt(dt) * rng.standard_normal(shape)
    reading = angle if mount_reading is None else mount_reading
    return Recording(dt=dt, dtheta=gyros, dv=dv, mount_angle=reading, gravity=motion.gravity, axes=motion.axes)


def take_fixes(
    motion: Motion,
    aid: Aid,
    rng: np.random.Generator,
    *,
    delay: float = 0.0,
    lost: tuple[tuple[float, float], ...] = (),
) -> Fixes:
    """What an aid measures of a motion, from time 0 at its interval.

    Parameters
    ----------
    motion : Motion
        True motion.
    aid : Aid
        Standard deviations and interval.
    rng : numpy.random.Generator
        Source of the errors.
    delay : float, optional
        Age of a measurement that the aid does not tell, s: it says where the vessel was that long ago.
    lost : tuple of (float, float), optional
        Times from and until which nothing comes, s.

    Returns
    -------
    Fixes
        Without those that were lost.
    """
    duration = checks.instance("motion", motion, Motion).time[-1]
    delay = checks.non_negative("delay", delay, "s")
    interval = checks.instance("aid", aid, Aid).interval
    time = interval * np.arange(int(duration / interval + 1e-9) + 1)
    truth = np.stack([np.interp(time - delay, motion.time, motion.states[:, k]) for k in range(3, 9)], axis=-1)
    std = np.array([aid.std.get(name, np.nan) for name in MEASUREMENTS])
    values = truth + std * checks.generator("rng", rng).standard_normal(truth.shape)
    kept = np.ones(len(time), dtype=bool)
    for pair in lost:
        if np.shape(pair) != (2,):
            raise ValueError(f"`lost` must have pairs of a time and a later one, got {pair!r}. One gap is ((10, 20),)")
        start, end = pair
        if not start < end:
            raise ValueError(f"`lost` must have pairs of a time and a later one, got ({start:g}, {end:g}) s")
        kept &= (time < start) | (time > end)
    if not kept.any():
        raise ValueError(f"`lost` must leave a measurement, got {lost!r}: an unaided filter observes nothing")
    return Fixes(time=time[kept], values=values[kept], aid=aid)


def draw_start(motion: Motion, prior: Prior, rng: np.random.Generator) -> CompassState:
    """State that a compass takes at the start: the true one with errors of the standard deviations of `prior`."""
    state = checks.instance("motion", motion, Motion).states[0].copy()
    checks.instance("prior", prior, Prior)
    std = np.sqrt(np.diag(prior.covariance(state[6], linear=False)))[:9]
    state += std * checks.generator("rng", rng).standard_normal(9)
    names = ("heading", "trim", "roll")
    return CompassState(
        **dict(zip(names, state[:3].tolist(), strict=True)),
        velocity=state[3:6],
        lat=state[6],
        lon=state[7],
        alt=state[8],
    )


def _check_range(motion: Motion, gyro_range: float) -> None:
    """Refuse a motion that asks a gyro to read more than it can."""
    if not (isinstance(gyro_range, float) and gyro_range == np.inf):
        gyro_range = checks.positive("gyro_range", gyro_range, "rad/s")
    rates = np.abs(motion.rates)
    step, gyro = np.unravel_index(np.argmax(rates), rates.shape)
    if rates[step, gyro] > gyro_range:
        raise ValueError(
            f"`motion` must keep gyro {'xyz'[gyro]} within `gyro_range`, {gyro_range / DEG_PER_SECOND:.4g} deg/s, got "
            f"{rates[step, gyro] / DEG_PER_SECOND:.4g} deg/s at {motion.time[step]:g} s. Let the law of the mount take "
            "a longer period or a smaller amplitude (`fogkit.gyrocompass.gyro_range`)."
        )


def _integrals(values: Array, dt: float) -> Array:
    """Integrals over steps of the cubics through four values; of the parabola at both ends."""
    n = len(values) - 1
    if n < 3:
        return dt * 0.5 * (values[1:] + values[:-1])
    inner = dt / 24 * (13 * (values[1:-2] + values[2:-1]) - values[:-3] - values[3:])
    first = dt / 12 * (5 * values[0] + 8 * values[1] - values[2])
    last = dt / 12 * (5 * values[-1] + 8 * values[-2] - values[-3])
    return np.concatenate([first[np.newaxis], inner, last[np.newaxis]])
