"""What velocities alone say of heading: one least-squares fit of all of them, without a filter and without navigation.

Seen from the hull a heading error is a steady tilt rate, ``omega_ie cos(lat)`` times it about east, and a level gyro
bias is a tilt rate that turns with the mount. Gravity times tilt is integrated to velocity, so white noise of velocity
is noise of the tilt rate that grows with the fourth power of frequency: an aid that is poor sees the steady part and
not the turning one. What is then left of a bias passes into heading with the mean direction ``m`` of the mount ::

    std(heading)**2 = std(heading without biases)**2 + (|m| * bias_left / (omega_ie cos(lat)))**2

which is the bound of `fogkit.gyrocompass.accuracy` again when velocity is perfect.
"""

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.constants import EARTH_RATE, STANDARD_GRAVITY
from fogkit.earth import POLE_MARGIN, checked_latitude
from fogkit.gyrocompass.covariance import Prior, multiple
from fogkit.gyrocompass.frames import pyramid_axes
from fogkit.gyrocompass.laws import COARSEST_STEP, MountLaw

Array = NDArray[np.float64]

LONGEST = 1000.0
"""Duration, s, beyond which the Earth's turn of tilts and Schuler's feedback, left out here, count for too much."""

_STEPS = 10  # fewest steps of the sums between two velocities


def heading_from_velocities(
    law: MountLaw,
    duration: float,
    lat: float,
    angle_random_walk: float,
    velocity_std: float,
    prior: Prior,
    *,
    heading: float = 0.0,
    drift_std: float | None = None,
    interval: float = 1.0,
) -> float:
    """Standard deviation of heading at the end of a stay, from all level velocities at once.

    Parameters
    ----------
    law : MountLaw
        Law of the mount.
    duration : float
        Time of the measurement, s, at most `LONGEST`.
    lat : float
        Latitude, rad.
    angle_random_walk : float
        Of each gyro of the pyramid, rad/sqrt(s).
    velocity_std : float
        White error of each level component of velocity, m/s.
    prior : Prior
        What is known at the start of heading, level, velocity, biases and scale factors; an entry of 0 is known. Its
        position and height are not used.
    heading : float, optional
        True heading, rad; it matters to scale factors only.
    drift_std : float, optional
        Of the bias about the mount's axis, rad/s; that of the prior if not given.
    interval : float, optional
        Time between velocities, s; the first is at time 0.

    Returns
    -------
    float
        Rad.

    Raises
    ------
    ValueError
        If the duration is no multiple of the interval or longer than `LONGEST`, the latitude that of a pole, or a
        standard deviation negative.

    Notes
    -----
    Left out are the Earth's turn of the tilts and Schuler's feedback: over five minutes 3 per cent of the standard
    deviation that `fogkit.gyrocompass.covariance.run_covariance` gives.
    """
    checks.instance("law", law, MountLaw)
    duration = checks.in_closed_interval("duration", duration, 0.0, LONGEST, "s")
    noise = checks.positive("angle_random_walk", angle_random_walk, "rad/sqrt(s)")
    velocity_std = checks.positive("velocity_std", velocity_std, "m/s")
    checks.instance("prior", prior, Prior)
    heading = checks.finite("heading", heading, "rad")
    drift = prior.bias if drift_std is None else checks.non_negative("drift_std", drift_std, "rad/s")
    interval = checks.positive("interval", interval, "s")
    steps = multiple("duration", duration, interval)

    dt = interval / max(_STEPS, int(np.ceil(law.max_rate * interval / COARSEST_STEP)))
    t = dt * (np.arange(round(duration / dt)) + 0.5)
    k = interval * np.arange(steps + 1)
    kernel = STANDARD_GRAVITY * np.maximum(k[:, np.newaxis] - t, 0) * dt  # velocity from the tilt rate in each step
    tilts = _tilt_rates(law, t, dt, lat, heading)
    start = [STANDARD_GRAVITY * k, 1j * STANDARD_GRAVITY * k, np.ones_like(k), 1j * np.ones_like(k)]
    columns = np.array([*(kernel @ tilt for tilt in tilts), *start]).T
    stds = [prior.heading, drift, *[prior.bias] * 2, *[prior.scale_factor] * 3, *[prior.level] * 2]
    stds = np.array([*stds, *[prior.velocity] * 2])
    if stds[0] == 0:
        return 0.0
    free = stds > 0
    first, last = np.minimum.outer(k, k), np.maximum.outer(k, k)
    walk = first**2 * (last / 2 - first / 6)  # integral of (first - t) (last - t), 0 to first
    covariance = (STANDARD_GRAVITY * noise) ** 2 * walk + velocity_std**2 * np.eye(len(k))
    whitened = np.linalg.solve(np.linalg.cholesky(covariance), columns[:, free] * stds[free])
    information = (whitened.conj().T @ whitened).real + np.eye(int(free.sum()))
    return float(np.sqrt(np.linalg.inv(information)[0, 0]) * stds[0])


def _tilt_rates(law: MountLaw, t: Array, dt: float, lat: float, heading: float) -> list[Array]:
    """Level tilt rates, forward + i starboard, per heading at the end, up bias, level biases, three scale factors."""
    level, up = EARTH_RATE * _cosine(lat), EARTH_RATE * np.sin(lat)
    angle, rate, _ = law.motion(t)
    turning = np.exp(-1j * angle)  # from the mount into the hull
    of_heading = 1j * level * np.exp(-1j * heading)  # computed less true Earth rate, with the sign of a gyro's error
    tilts = [np.full_like(turning, of_heading), of_heading * (t - t[-1] - dt / 2), turning, 1j * turning]
    axes = pyramid_axes()
    for ahead, upward, abeam in axes.T:
        seen = upward * (rate + up) + ((ahead - 1j * abeam) * level * np.exp(1j * (angle - heading))).real
        turned = -upward * (np.cumsum(seen) - seen.sum()) * dt  # heading, clockwise, until the end of each step
        tilts.append((ahead + 1j * abeam) * seen * turning + of_heading * (turned + upward * seen * dt / 2))
    return tilts


def bias_left(
    law: MountLaw,
    duration: float,
    angle_random_walk: float,
    velocity_std: float,
    bias_std: float,
    *,
    interval: float = 1.0,
    harmonics: int = 1000,
) -> float:
    """Standard deviation of a level gyro bias, from its turning part only, over many periods of a law.

    Parameters
    ----------
    law : MountLaw
        Law of the mount.
    duration : float
        Time of the measurement, s.
    angle_random_walk : float
        Of each gyro, rad/sqrt(s).
    velocity_std : float
        White error of each level component of velocity, m/s; 0: perfect.
    bias_std : float
        Prior standard deviation, rad/s.
    interval : float, optional
        Time between velocities, s.
    harmonics : int, optional
        Highest multiple of the law's frequency that is taken.

    Returns
    -------
    float
        Rad/s: ``(1/bias_std**2 + duration * sum over k != 0 of |c_k|**2 / S(k/period))**-0.5`` with the lines c_k of
        ``exp(i beta)`` and the noise of the tilt rate
        ``S(f) = angle_random_walk**2 + velocity_std**2 * interval * (2 pi f)**4 / g**2``. It holds when the time has
        many periods; with four to fifteen of them heading comes out right to a tenth.

    Raises
    ------
    ValueError
        If a number is negative, or time, period or random walk zero.
    """
    checks.instance("law", law, MountLaw)
    duration = checks.positive("duration", duration, "s")
    noise = checks.positive("angle_random_walk", angle_random_walk, "rad/sqrt(s)")
    velocity_std = checks.non_negative("velocity_std", velocity_std, "m/s")
    bias_std = checks.positive("bias_std", bias_std, "rad/s")
    interval = checks.positive("interval", interval, "s")
    harmonics = checks.integer("harmonics", harmonics, minimum=1)
    points = 4 * max(harmonics, int(np.ceil(law.max_rate * law.period / (2 * np.pi))))
    lines = np.abs(np.fft.fft(np.exp(1j * law.angle(law.period * np.arange(points) / points))) / points) ** 2
    power = lines[1 : harmonics + 1] + lines[: -harmonics - 1 : -1]
    frequency = 2 * np.pi * np.arange(1, harmonics + 1) / law.period
    density = noise**2 + velocity_std**2 * interval * frequency**4 / STANDARD_GRAVITY**2
    return float((bias_std**-2 + duration * (power / density).sum()) ** -0.5)


def _cosine(lat: float) -> float:
    return float(np.cos(checked_latitude(checks.finite("lat", lat, "rad"), pole_margin=POLE_MARGIN)))
