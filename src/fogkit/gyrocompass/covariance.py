"""How well an aided gyrocompass knows each of its states over a motion: covariance without data.

The errors of `fogkit.gyrocompass.error_model` are followed with white noise of gyros and accelerometers and corrected
by an aid that measures some of the states with white errors. It is what a Kalman filter believes when it is right about
its noise and close enough to the truth for a linear model.

References
----------
.. [1] Le Van Chang, Gyrocompass with a quasi-harmonic autocompensating mount (in Russian), thesis abstract, LETI,
   St Petersburg, 2015, chapter 2.
"""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.earth import POLE_MARGIN, checked_latitude
from fogkit.gyrocompass import _kernels
from fogkit.gyrocompass.error_model import STATES
from fogkit.gyrocompass.mechanisation import EARTH_RADIUS, checked_trim
from fogkit.gyrocompass.motions import Motion
from fogkit.units import DEG, DEG_PER_HOUR, PERCENT

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

LARGEST_HEADING_STD = 30 * DEG
"""Prior standard deviation of heading, rad, beyond which a linear model is a poor one and a warning comes."""


@dataclass(frozen=True, kw_only=True)
class Prior:
    """Standard deviations of the states at the start; all errors independent.

    Parameters
    ----------
    heading, level : float, optional
        Of heading, and of trim and roll, rad.
    velocity, position, height : float, optional
        m/s; m over the ground, each way; m.
    bias, scale_factor : float, optional
        Of each gyro, rad/s and 1.

    Raises
    ------
    ValueError
        If one is negative or not finite.
    """

    heading: float = 10 * DEG
    level: float = 1 * DEG
    velocity: float = 1.0
    position: float = 10.0
    height: float = 10.0
    bias: float = 10 * DEG_PER_HOUR
    scale_factor: float = 1 * PERCENT

    def __post_init__(self) -> None:
        units = {"heading": "rad", "level": "rad", "velocity": "m/s", "position": "m", "height": "m", "bias": "rad/s"}
        for name in (*units, "scale_factor"):
            object.__setattr__(self, name, checks.non_negative(name, getattr(self, name), units.get(name, "")))

    def covariance(self, lat: float, *, linear: bool = True) -> Array:
        """Covariance of the states at a latitude, rad: shape (15, 15).

        Warn, unless `linear` is False, if heading is known so badly that an error model linear in it is a poor one.
        """
        if linear and self.heading > LARGEST_HEADING_STD:
            warnings.warn(
                f"`heading` of {self.heading / DEG:.3g} deg is beyond {LARGEST_HEADING_STD / DEG:.0f} deg, where a "
                "linear error model is a poor one: `filters.wander` has another",
                UserWarning,
                stacklevel=3,
            )
        lat = float(checked_latitude(checks.finite("lat", lat, "rad"), pole_margin=POLE_MARGIN))
        north = self.position / EARTH_RADIUS
        std = [self.heading, *[self.level] * 2, *[self.velocity] * 3, north, north / np.cos(lat), self.height]
        return np.diag(np.square([*std, *[self.bias] * 3, *[self.scale_factor] * 3]))


@dataclass(frozen=True, kw_only=True)
class Noise:
    """White noise of the sensors.

    Parameters
    ----------
    angle_random_walk : array_like, shape () or (3,)
        Of the gyros x, y, z, rad/sqrt(s).
    velocity_random_walk : float, optional
        Of each accelerometer, m/s/sqrt(s).
    rate_random_walk : float, optional
        Of each gyro's bias, rad/s/sqrt(s).
    """

    angle_random_walk: ArrayLike
    velocity_random_walk: float = 0.0
    rate_random_walk: float = 0.0

    def __post_init__(self) -> None:
        walk = checks.finite_array("angle_random_walk", self.angle_random_walk)
        if walk.shape not in ((), (3,)) or (walk < 0).any():
            raise ValueError(f"`angle_random_walk` must be one number or three, >= 0, got {self.angle_random_walk!r}")
        object.__setattr__(self, "angle_random_walk", tuple(np.broadcast_to(walk, 3).tolist()))
        for name in ("velocity_random_walk", "rate_random_walk"):
            object.__setattr__(self, name, checks.non_negative(name, getattr(self, name)))


@dataclass(frozen=True, kw_only=True)
class Aid:
    """What an aid measures, how well, how often.

    Parameters
    ----------
    std : mapping of str to float
        Standard deviations of the white errors of a measurement, by name of the state (`error_model.STATES`), in the
        units of the states: rad for latitude and longitude (`satellite` takes metres).
    interval : float, optional
        Time between measurements, s.

    Raises
    ------
    ValueError
        If nothing is measured, a name is none of the states, or a number is not above zero.
    """

    std: Mapping[str, float] = field(default_factory=dict)
    interval: float = 1.0

    def __post_init__(self) -> None:
        checks.instance("std", self.std, Mapping, fix="Names with their standard deviations; or use `Aid.satellite`.")
        if not self.std:
            raise ValueError("`std` must name a state at least, got none: an unaided filter observes nothing")
        kept = {}
        for name, value in self.std.items():
            checks.option("std", name, STATES)
            kept[name] = checks.positive(f"std[{name!r}]", value)
        object.__setattr__(self, "std", kept)
        object.__setattr__(self, "interval", checks.positive("interval", self.interval, "s"))

    @classmethod
    def satellite(cls, lat: float, velocity: float = 0.1, position: float = 3.0, interval: float = 1.0) -> "Aid":
        """The aid of (11) of [1]_: velocity, m/s, and position, m, each with a standard deviation per component.

        [1]_ does not state the accuracy of its aid; the defaults are assumed.
        """
        lat = float(checked_latitude(checks.finite("lat", lat, "rad"), pole_margin=POLE_MARGIN))
        velocity = checks.positive("velocity", velocity, "m/s")
        north = checks.positive("position", position, "m") / EARTH_RADIUS
        std = dict.fromkeys(("velocity_north", "velocity_up", "velocity_east"), velocity)
        return cls(std={**std, "lat": north, "lon": north / np.cos(lat), "alt": position}, interval=interval)


@dataclass(frozen=True, kw_only=True)
class CovarianceRun:
    """Standard deviations over a motion.

    Attributes
    ----------
    time : ndarray, shape (n,)
        s.
    std : ndarray, shape (n, 15)
        Standard deviations in the order of `error_model.STATES`, after the measurement of that time if there is one.
    covariance : ndarray, shape (15, 15)
        At the end.
    """

    time: Array
    std: Array
    covariance: Array

    def of(self, name: str) -> Array:
        """Standard deviation of a state over time, shape (n,)."""
        return self.std[:, STATES.index(checks.option("name", name, STATES))]

    def to_frame(self) -> "DataFrame":
        """Table of the standard deviations, index ``time`` in s."""
        import pandas as pd

        return pd.DataFrame(self.std, index=pd.Index(self.time, name="time"), columns=list(STATES))


def run_covariance(
    motion: Motion,
    noise: Noise,
    aid: Aid,
    prior: Prior | ArrayLike | None = None,
    *,
    output_interval: float = 1.0,
) -> CovarianceRun:
    """Covariance of an aided gyrocompass along a motion.

    Parameters
    ----------
    motion : Motion
        True motion and readings.
    noise : Noise
        Of the sensors.
    aid : Aid
        What is measured; the first measurement is at time 0.
    prior : Prior or array_like, shape (15, 15), optional
        Standard deviations, or covariance, at the start.
    output_interval : float, optional
        Time between rows of the result, s.

    Returns
    -------
    CovarianceRun
        Standard deviations over time, covariance at the end.

    Raises
    ------
    ValueError
        If a time is no multiple of the motion's step, trim is vertical or latitude at a pole on the way, or the
        covariance is not symmetric and positive semi-definite.

    Warns
    -----
    UserWarning
        If the aid measures at the start only.
    """
    dt = checks.instance("motion", motion, Motion).dt
    every = multiple("aid.interval", checks.instance("aid", aid, Aid).interval, dt)
    keep = multiple("output_interval", checks.positive("output_interval", output_interval, "s"), dt)
    if every >= len(motion.time):
        warnings.warn(
            f"`aid` measures every {aid.interval:g} s, once in a motion of {motion.time[-1]:g} s: errors grow freely",
            UserWarning,
            stacklevel=2,
        )
    checked_trim(motion.states[:, 1])
    checked_latitude(motion.states[:, 6], pole_margin=POLE_MARGIN)
    prior = Prior() if prior is None else prior
    P = prior.covariance(motion.states[0, 6]) if isinstance(prior, Prior) else checked_covariance("prior", prior)
    aided = np.array([STATES.index(name) for name in aid.std])
    variances = np.array([std**2 for std in aid.std.values()])
    walks = np.zeros(15)
    walks[9:12] = checks.instance("noise", noise, Noise).rate_random_walk ** 2
    rows = (len(motion.time) - 1) // keep + 1
    out = np.empty((rows, 15))
    failed = _kernels.covariance_run(
        *(P, motion.states, motion.rates, motion.specific_force, motion.mount_angle, motion.mount_rate),
        *(motion.axes, EARTH_RADIUS, motion.gravity, dt),
        *(np.square(noise.angle_random_walk), noise.velocity_random_walk**2, walks, aided, variances, every, keep, out),
    )
    if failed >= 0:
        raise ValueError(
            f"`prior` must lead to a covariance throughout, got a negative variance at {failed * dt:g} s: rounding, by "
            "an `aid` too good for a start so poor. Raise its standard deviations or lower those of the prior."
        )
    return CovarianceRun(time=motion.time[::keep], std=out, covariance=P)


def checked_covariance(name: str, P: ArrayLike) -> Array:
    """Copy of a covariance of the 15 states, after the check that it is one."""
    P = np.array(checks.finite_array(name, P, shape=(15, 15)))
    scale = np.sqrt(np.abs(np.diag(P)))
    scale[scale == 0] = 1.0
    normed = P / np.outer(scale, scale)
    if np.abs(normed - normed.T).max() > 1e-9:
        raise ValueError(f"`{name}` must be symmetric, got {np.abs(normed - normed.T).max():.3g} between correlations")
    lowest = np.linalg.eigvalsh(normed)[0]
    if lowest < -1e-9:
        raise ValueError(f"`{name}` must be positive semi-definite, got an eigenvalue of {lowest:.3g} of correlations")
    return P


def multiple(name: str, interval: float, dt: float) -> int:
    """Steps in an interval, after the check that it is whole steps."""
    steps = round(interval / dt)
    if steps < 1 or abs(steps * dt - interval) > 1e-6 * dt * max(steps, 1):
        raise ValueError(f"`{name}` must be a multiple of the motion's step, {dt:g} s, got {interval:g} s")
    return steps
