"""The filter to use: the Earth's axis for a state, in a level frame of known azimuth against the hull.

The frame w is level and its azimuth is free: at the start it is where the compass takes north to be. What heading is
then follows from the level part of the Earth's axis in w, a vector of two numbers with the length ``cos(lat)``. These
two, and not an angle, are estimated. All equations are linear in them:

- the Earth's rate in w, by which tilts grow: however wrong heading is, the filter makes no error of second order in it;
- their own change under way, ``-v_w sin(lat)/R``: transport has no part about up in w, and nothing grows without bound
  as a pole is approached;
- the aid's velocity in w.

The attitude of the hull against w is a matrix, which no trim makes singular. What multiplies errors in the
model is taken without the noise of the aid, which a filter takes for knowledge of azimuth: a velocity and a level
specific force that are not well above it count as none. An uncertain heading with standard
deviation ``s`` begins as the mean ``exp(-s**2/2)`` and the variances ``(1 - exp(-s**2))**2/2``,
``(1 - exp(-2 s**2))/2`` of cosine and sine. That the two numbers have the length ``cos(lat)`` is used in this beginning
only. Products of errors that are left are those of the axis with the drift in azimuth since the start, with
tilts and with errors of velocity. At rest, as far as 89 degrees north, they do not matter (tests, and
`fogkit.reproduction.lechang.filtering`). Under way they do with an aid of 0.1 m/s: the filter is then too sure of
heading, and warns.

References
----------
.. [1] Le Van Chang, Gyrocompass with a quasi-harmonic autocompensating mount (in Russian), thesis abstract, LETI,
   St Petersburg, 2015, chapter 2.
"""

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass.covariance import Noise, Prior, multiple
from fogkit.gyrocompass.filters import _kernels
from fogkit.gyrocompass.filters.records import Fixes, Recording
from fogkit.gyrocompass.filters.runs import (
    MARGINS,
    FilterRun,
    arguments,
    fix_steps,
    raise_failure,
    warn_of_innovations,
    wrapped,
)
from fogkit.gyrocompass.frames import hull_attitude, pyramid_axes
from fogkit.gyrocompass.mechanisation import EARTH_RADIUS, TRIM_MARGIN, CompassState
from fogkit.gyrocompass.motions import Motion
from fogkit.rotation import small_angle_between

Array = NDArray[np.float64]

POOR_AID = 0.01
"""Standard deviation of the aid's velocity, m/s, above which the filter is not consistent under way."""

WANDER_STATES = (
    *("tilt_1", "azimuth", "tilt_2"),
    *("velocity_1", "velocity_up", "velocity_2"),
    *("lat", "lon", "alt"),
    *("axis_1", "axis_2"),
    *("bias_x", "bias_y", "bias_z"),
    *("scale_factor_x", "scale_factor_y", "scale_factor_z"),
)
"""Errors that the filter follows: turn of the hull's attitude in w, rad (from true to computed); velocity in w, m/s;
position, rad and m; level part of the Earth's axis in w, 1; and what the gyros have left of bias and scale factor."""


@dataclass(frozen=True, kw_only=True)
class WanderRun(FilterRun):
    """Estimates over time in the quantities of the thesis, and in those of the filter.

    Standard deviations of the former are to first order: heading's are right while they are some degrees.

    Attributes
    ----------
    C_h_w : ndarray, shape (k, 3, 3)
        Attitude of the hull against w.
    state : ndarray, shape (k, 14)
        Velocity 1, up, 2; latitude, longitude, height; the Earth's axis 1, 2; biases; scale factors.
    wander_covariance : ndarray, shape (k, 17, 17)
        Of the errors `WANDER_STATES`.
    """

    C_h_w: Array
    state: Array
    wander_covariance: Array

    def wander_errors(self, motion: Motion, bias: ArrayLike = 0.0, scale_factor: ArrayLike = 0.0) -> Array:
        """Errors of the filter's own states, shape (k, 17), in the order of `WANDER_STATES`.

        Parameters
        ----------
        motion : Motion
            True motion.
        bias, scale_factor : array_like, shape (3,) or (k, 3), optional
            True biases, rad/s, and scale factors.
        """
        rows = np.rint(self.time / motion.dt).astype(int)
        C_h_g, truth = hull_attitude(*motion.states[rows, :3].T), motion.states[rows, 3:9]
        # true azimuth of w against north: what heading was wrong by at the start, and what meridians converged since
        turning = motion.states[:, 5] * np.tan(motion.states[:, 6]) / (EARTH_RADIUS + motion.states[:, 8])
        steps = np.concatenate([[0.0], np.cumsum(0.5 * (turning[1:] + turning[:-1])) * motion.dt])
        azimuth = self._true_azimuth(hull_attitude(*motion.states[0, :3])) + steps[rows]
        C_w_g = hull_attitude(azimuth, 0.0, 0.0)
        C_h_w = C_w_g.swapaxes(1, 2) @ C_h_g
        in_w = (C_w_g.swapaxes(1, 2) @ truth[:, :3, np.newaxis])[..., 0]
        axis = np.cos(truth[:, 3]) * np.array([np.cos(azimuth), -np.sin(azimuth)])
        errors = np.zeros((len(rows), 17))
        errors[:, :3] = -small_angle_between(self.C_h_w, C_h_w)
        errors[:, 3:6] = self.state[:, :3] - in_w
        errors[:, 6:9] = self.state[:, 3:6] - truth[:, 3:]
        errors[:, 7] = wrapped(errors[:, 7])
        errors[:, 9:11] = self.state[:, 6:8] - axis.T
        errors[:, 11:14], errors[:, 14:] = bias - self.state[:, 8:11], scale_factor - self.state[:, 11:]
        return errors

    def _true_azimuth(self, C_h_g: Array) -> float:
        """Azimuth of w at the start, rad: that from which the computed attitude there differs by tilts only."""
        azimuth = 0.0
        for _ in range(30):  # a turn about up changes the third part of a turn vector by nearly itself
            wrong = small_angle_between(self.C_h_w[0], hull_attitude(azimuth, 0.0, 0.0).T @ C_h_g)[1]
            azimuth -= wrong
            if abs(wrong) < 1e-15:
                break
        return azimuth


def run_wander(
    recording: Recording,
    fixes: Fixes,
    noise: Noise,
    start: CompassState,
    prior: Prior | None = None,
    *,
    heading_known: bool = True,
    output_interval: float = 1.0,
) -> WanderRun:
    """Heading and the rest from a record and an aid, from any heading.

    Parameters
    ----------
    recording, fixes, noise, start, output_interval
        As for `fogkit.gyrocompass.filters.extended.run_extended`.
    prior : Prior, optional
        Standard deviations of the errors at the start.
    heading_known : bool, optional
        False: nothing is known of heading, whatever `start` and `prior` say.

    Returns
    -------
    WanderRun
        Estimates and covariances.

    Raises
    ------
    ValueError
        If a time is no multiple of the step, there is no aid, velocities north and east are not measured together with
        one standard deviation, latitude comes near a pole, or the covariance ceases to be one.

    Warns
    -----
    UserWarning
        If the aid is poor under way (`POOR_AID`) or lost for a time, innovations are larger than they may be, or trim
        comes near the vertical, where
        heading and roll are not defined apart (`WanderRun.C_h_w` is).

    Notes
    -----
    Covariance and mechanisation are predicted in every step, the transition to second order; measurements are taken one
    component after the other in Joseph's form, and fed back at once.
    """
    return _run(recording, fixes, noise, start, prior, heading_known, output_interval)[0]


def _run(recording, fixes, noise, start, prior, heading_known, output_interval, smooth=False) -> tuple:
    """The run, and what a smoother needs of it."""
    steps = fix_steps(recording, fixes)
    keep = multiple("output_interval", checks.positive("output_interval", output_interval, "s"), recording.dt)
    if smooth and (steps % keep).any():
        raise ValueError("`output_interval` must divide the times of all `fixes` for the smoother")
    _check_level_aid(fixes)
    prior = checks.instance("prior", Prior() if prior is None else prior, Prior)
    P, s, way = wander_start(checks.instance("start", start, CompassState), prior, heading_known)
    aided = np.sqrt(np.nan_to_num(fixes.variances[0]))
    if way.any() and aided > POOR_AID:
        warnings.warn(
            f"under way, at {np.hypot(*way):.3g} m/s, with an aid of {aided:.2g} m/s the filter is too sure of heading "
            f"where that was wrong by 5 degrees and more; it is not so at rest, nor with {POOR_AID:g} m/s or better",
            UserWarning,
            stacklevel=4,
        )
    C = hull_attitude(start.heading, start.trim, start.roll)
    rows, count = len(recording.dtheta) // keep + 1, len(WANDER_STATES)
    attitudes, states, covariances = np.empty((rows, 3, 3)), np.empty((rows, 14)), np.empty((rows, count, count))
    nis = np.zeros(len(steps))
    kept = [np.zeros(((rows - 1) * smooth, count, count)) for _ in range(2)] + [np.zeros((rows * smooth, count))]
    dt, *densities = arguments(recording, noise, count, 11)
    failure, step = _kernels.wander_run(
        *(P, C, s, way, recording.dtheta, recording.dv, recording.mount_angle, recording.axes),
        *(EARTH_RADIUS, recording.gravity, dt, *densities),
        *(steps, fixes.values, fixes.variances, MARGINS, keep, attitudes, states, covariances, nis, smooth, *kept),
    )
    raise_failure(failure, step, dt)
    counts = np.isfinite(fixes.values).sum(axis=1)
    warn_of_innovations(nis, counts)
    time = dt * keep * np.arange(rows)
    return wander_result(time, attitudes, states, covariances, (fixes.time, nis, counts)), kept


def wander_start(start: CompassState, prior: Prior, heading_known: bool) -> tuple[Array, Array, Array]:
    """Covariance, shape (17, 17), state, (14,), and velocity that an error of the axis turns, (2,), at the start.

    w has north where the compass takes it to be. A velocity within five standard deviations of none is not turned: its
    error would be taken for one of the axis.
    """
    square = prior.heading**2 if heading_known else np.inf
    c = np.cos(start.lat)
    mean, along, across = np.exp(-square / 2), (1 - np.exp(-square)) ** 2 / 2, (1 - np.exp(-2 * square)) / 2
    P = np.zeros((17, 17))
    axis = c**2 * np.diag([along, across])
    P[9:11, 9:11] = axis
    std = np.array([prior.level, 0.0, prior.level, *[prior.velocity] * 3])
    north = prior.position / EARTH_RADIUS
    P[np.arange(9), np.arange(9)] = np.square([*std, north, north / c, prior.height])
    P[np.arange(11, 17), np.arange(11, 17)] = np.square([*[prior.bias] * 3, *[prior.scale_factor] * 3])
    v_n, v_u, v_e = start.velocity
    way = np.array([v_n, v_e]) * (np.hypot(v_n, v_e) > 5 * prior.velocity)
    turn = np.array([[way[0], -way[1]], [way[1], way[0]]]) / c
    level = np.ix_([3, 5], [9, 10])
    P[level] = turn @ axis
    P[level[1].T, level[0].T] = P[level].T
    P[np.ix_([3, 5], [3, 5])] += turn @ axis @ turn.T
    v_1, v_2 = mean * np.array([v_n, v_e])
    s = np.array([v_1, v_u, v_2, start.lat, start.lon, start.alt, c * mean, 0.0, *np.zeros(6)])
    return P, s, way


def wander_result(time: Array, C: Array, s: Array, P: Array, innovations: tuple) -> WanderRun:
    """Run in the quantities of the thesis, from that in the filter's."""
    north = _north(s, P)
    angles, T = _angles(C, s, *north)
    estimate = np.hstack([angles, _level_velocity(s, *north), s[:, 3:6], s[:, 8:]])
    steepest = np.abs(angles[:, 1]).max()
    if steepest > np.pi / 2 - TRIM_MARGIN:
        warnings.warn(
            f"trim comes within {np.pi / 2 - steepest:.2g} rad of the vertical, where heading and roll are not defined "
            "apart: use `C_h_w`",
            UserWarning,
            stacklevel=4,
        )
    fix_time, nis, counts = innovations
    return WanderRun(
        time=time,
        estimate=estimate,
        covariance=T @ P @ T.swapaxes(1, 2),
        fix_time=fix_time,
        nis=nis,
        fix_count=counts,
        C_h_w=C,
        state=s,
        wander_covariance=P,
    )


def _north(s: Array, P: Array) -> tuple[Array, Array]:
    """Direction of north in w, shape (k, 2), and the length by which an error of the axis turns it, (k,).

    The length is that of the axis, or its uncertainty where that is larger: then nothing is known of north, and its
    standard deviation comes out as 0.7 rad at most instead of without bound.
    """
    axis = s[:, 6:8]
    found = np.linalg.norm(axis, axis=1)
    north = np.where(found[:, np.newaxis] > 0, axis / np.where(found > 0, found, 1.0)[:, np.newaxis], [1.0, 0.0])
    return north, np.maximum(found, np.sqrt(P[:, 9, 9] + P[:, 10, 10]))


def _angles(C: Array, s: Array, north: Array, length: Array) -> tuple[Array, Array]:
    """Heading, trim and roll, shape (k, 3); derivatives of the errors of all 15 by the filter's, (k, 15, 17)."""
    n_1, n_2 = north.T
    ahead, trim_sine, abeam = C[:, 0, 0], C[:, 1, 0], C[:, 2, 0]
    square = np.maximum(ahead**2 + abeam**2, 1e-24)
    heading = wrapped(np.arctan2(abeam, ahead) + np.arctan2(-n_2, n_1))
    trim = np.arctan2(trim_sine, np.sqrt(square))
    roll = np.arctan2(-C[:, 1, 2], C[:, 1, 1])
    T = np.zeros((len(s), 15, 17))
    T[:, 0, 0], T[:, 0, 1], T[:, 0, 2] = trim_sine * ahead / square, -1.0, trim_sine * abeam / square
    T[:, 0, 9], T[:, 0, 10] = n_2 / length, -n_1 / length
    T[:, 1, 0], T[:, 1, 2] = -abeam / np.sqrt(square), ahead / np.sqrt(square)
    T[:, 2, 0], T[:, 2, 2] = ahead / square, abeam / square
    c = np.cos(s[:, 3])
    per = c / length
    T[:, 3, 3], T[:, 3, 5], T[:, 5, 3], T[:, 5, 5] = n_1 * per, n_2 * per, -n_2 * per, n_1 * per
    v_n, _, v_e = _level_velocity(s, north, length).T
    for column, along, across in ((9, n_1, -n_2), (10, n_2, n_1)):  # length and direction of the axis
        T[:, 3, column] = (across * v_e - along * v_n) / length
        T[:, 5, column] = (-across * v_n - along * v_e) / length
    T[:, 4, 4] = 1.0
    for row in (6, 7, 8):
        T[:, row, row] = 1.0
    for row in range(9, 15):  # estimate less truth: the negative of what the gyros have left
        T[:, row, row + 2] = -1.0
    return np.stack([heading, trim, roll], axis=-1), T


def _level_velocity(s: Array, north: Array, length: Array) -> Array:
    """Velocity north, up, east from that in w, shape (k, 3)."""
    (n_1, n_2), per = north.T, np.cos(s[:, 3]) / length
    return np.stack([(n_1 * s[:, 0] + n_2 * s[:, 2]) * per, s[:, 1], (n_1 * s[:, 2] - n_2 * s[:, 0]) * per], axis=-1)


def _check_level_aid(fixes: Fixes) -> None:
    """Refuse level velocities that the frame w cannot take: one alone, or of two accuracies."""
    there = np.isfinite(fixes.values)
    variances = fixes.variances
    if (there[:, 0] != there[:, 2]).any() or (there[:, 0].any() and not np.isclose(variances[0], variances[2])):
        raise ValueError(
            "`fixes` must measure the velocities north and east together and with one standard deviation, got one "
            "alone or two of different accuracy: the filter knows neither direction at the start"
        )


def wander_matrix(
    C_h_w: ArrayLike,
    state: ArrayLike,
    way: ArrayLike,
    rates: ArrayLike,
    specific_force: ArrayLike,
    mount_angle: float,
    gravity: float,
) -> Array:
    """Matrix F of the linear model of the errors `WANDER_STATES`.

    Parameters
    ----------
    C_h_w : array_like, shape (3, 3)
        Attitude of the hull against w.
    state : array_like, shape (8,) at least
        Velocity 1, up, 2, m/s; latitude, longitude, rad, height, m; the Earth's axis 1, 2.
    way : array_like, shape (2,)
        Velocity north and east as the aid has it, m/s.
    rates : array_like, shape (3,)
        Of the gyros, rad/s.
    specific_force : array_like, shape (3,)
        In the hull, m/s^2.
    mount_angle, gravity : float
        rad; on the sphere, m/s^2.

    Returns
    -------
    ndarray, shape (17, 17)
        Rows of biases and scale factors are zero.
    """
    C, s = checks.rotation_matrix("C_h_w", C_h_w), checks.finite_array("state", state)
    F, radius = np.empty((17, 17)), EARTH_RADIUS + s[5]
    weight = checks.positive("gravity", gravity, "m/s^2") * (EARTH_RADIUS / radius) ** 2
    rates = checks.finite_array("rates", rates, shape=(3,))
    way = checks.finite_array("way", way, shape=(2,))
    force = C @ checks.finite_array("specific_force", specific_force, shape=(3,))
    _kernels.wander_matrix(C, s, way, force, rates, mount_angle, pyramid_axes(), radius, weight, F)
    return F


def wander_rate(
    C_h_w: ArrayLike, state: ArrayLike, way: ArrayLike, omega_ih_h: ArrayLike, specific_force: ArrayLike, gravity: float
) -> tuple[Array, Array]:
    """Rate of turn of the hull against w, in w, shape (3,), and rates of velocity, position and axis, shape (8,).

    What `wander_matrix` is the derivative of; arguments as there, the rate of the hull, rad/s, and the specific force,
    m/s^2. Velocity north and east is `way` and what that in w departs from it by: an axis that is not of the length
    ``cos(lat)`` does not change it.
    """
    C, s = checks.rotation_matrix("C_h_w", C_h_w), checks.finite_array("state", state)
    v, lat, radius, axis = s[:3], s[3], EARTH_RADIUS + s[5], np.array([s[6], np.sin(s[3]), s[7]])
    transport = np.array([v[2], 0.0, -v[0]]) / radius
    frame = EARTH_RATE * axis + transport
    force = C @ specific_force - [0.0, gravity * (EARTH_RADIUS / radius) ** 2, 0.0]
    dv = force - np.cross(frame + EARTH_RATE * axis, v)
    c, turn = np.cos(lat), np.array([[s[6], -s[7]], [s[7], s[6]]]) / np.cos(lat)
    north, east = way + turn.T @ (v[[0, 2]] - turn @ way)
    position = [north / radius, east / (radius * c), v[1]]
    return C @ np.asarray(omega_ih_h) - frame, np.array([*dv, *position, *-np.cross(transport, axis)[[0, 2]]])
