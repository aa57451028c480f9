"""The filter to use: the Earth's axis for a state, in a level frame of known azimuth against the hull.

The frame w is level and its azimuth is free: at the start it is where the compass takes north to be. What heading is
then follows from the level part of the Earth's axis in w, a vector of two numbers with the length ``cos(lat)``. These
two, and not an angle, are estimated. The Earth's rate in w, by which tilts grow, is linear in them: however wrong
heading is, the filter makes no error of second order in it.

Velocity is kept north, up, east, as the aid has it, so that a measurement knows nothing of the axis. The level specific
force in w makes velocity through the axis, ``R^T (f - R c)``, with ``R`` the turn from north and east to w by the
axis and ``c`` the Coriolis force. At constant velocity the bracket is zero but for tilts, and any turn will do in the
place of ``R^T``: the best estimate is taken, and the model stays linear. In a turn the velocity may be taken to turn
with the hull, whose rate the gyros know (`course_follows_heading`): ``c`` then has the acceleration of that as well. In
another manoeuvre, when the force is larger than tilts and noise explain, the measured force is turned by the error of
the axis.

Two ways that look simpler fail. With velocity kept in w the aid's velocity must be turned by the axis, and its noise
with it: of what the aid is wrong by, times the error of heading, the filter knows nothing. And a measured force that is
always turned by the error of the axis has tilts in it, times the error of heading again.

The attitude of the hull against w is a matrix, which no trim makes singular. An uncertain heading with standard
deviation ``s`` begins as the mean ``exp(-s**2/2)`` and the variances ``(1 - exp(-s**2))**2/2``,
``(1 - exp(-2 s**2))/2`` of cosine and sine. That the two numbers have the length ``cos(lat)`` is used in this beginning
only. Products of errors that are left are those of the axis with the drift in azimuth since the start, with tilts, and
in a manoeuvre with the level force that tilts make.

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
from fogkit.units import DEG

Array = NDArray[np.float64]

TURN = 10 * DEG
"""Turn of the hull, rad, that is more than yawing in waves."""

WANDER_STATES = (
    *("tilt_1", "azimuth", "tilt_2"),
    *("velocity_north", "velocity_up", "velocity_east"),
    *("lat", "lon", "alt"),
    *("axis_1", "axis_2"),
    *("bias_x", "bias_y", "bias_z"),
    *("scale_factor_x", "scale_factor_y", "scale_factor_z"),
)
"""Errors that the filter follows: turn of the hull's attitude in w, rad (from true to computed); velocity, m/s;
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
        Velocity north, up, east; latitude, longitude, height; the Earth's axis 1, 2; biases; scale factors.
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
        axis = np.cos(truth[:, 3]) * np.array([np.cos(azimuth), -np.sin(azimuth)])
        errors = np.zeros((len(rows), 17))
        errors[:, :3] = -small_angle_between(self.C_h_w, C_h_w)
        errors[:, 3:9] = self.state[:, :6] - truth
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
    course_follows_heading: bool = False,
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
    course_follows_heading : bool, optional
        True: under way the velocity turns as the hull does, by the gyros. Without it, a turn with heading hardly known
        makes the filter too sure of heading; with it, yawing in waves while the course stays does, and so does a rocked
        mount while scale factors are wrong by 0.5 percent. So it is for turns.

    Returns
    -------
    WanderRun
        Estimates and covariances.

    Raises
    ------
    ValueError
        If a time is no multiple of the step, there is no aid, latitude comes near a pole, or the covariance ceases to
        be one.

    Warns
    -----
    UserWarning
        If the hull turns under way with heading hardly known, unless `course_follows_heading`. If the aid is lost for a
        time, innovations are larger than they may be, or trim comes near the vertical, where
        heading and roll are not defined apart (`WanderRun.C_h_w` is).

    Notes
    -----
    Covariance and mechanisation are predicted in every step, the transition to second order; measurements are taken one
    component after the other in Joseph's form, and fed back at once.
    """
    return _run(recording, fixes, noise, start, prior, heading_known, output_interval, course_follows_heading)[0]


def _run(recording, fixes, noise, start, prior, heading_known, output_interval, follows, smooth=False) -> tuple:
    """The run, and what a smoother needs of it."""
    steps = fix_steps(recording, fixes)
    keep = multiple("output_interval", checks.positive("output_interval", output_interval, "s"), recording.dt)
    heading_known = checks.instance("heading_known", heading_known, bool)
    follows = checks.instance("course_follows_heading", follows, bool)
    if smooth and (steps % keep).any():
        raise ValueError("`output_interval` must divide the times of all `fixes` for the smoother")
    prior = checks.instance("prior", Prior() if prior is None else prior, Prior)
    P, s = wander_start(checks.instance("start", start, CompassState), prior, heading_known)
    C = hull_attitude(start.heading, start.trim, start.roll)
    rows, count = len(recording.dtheta) // keep + 1, len(WANDER_STATES)
    attitudes, states, covariances = np.empty((rows, 3, 3)), np.empty((rows, 14)), np.empty((rows, count, count))
    nis = np.zeros(len(steps))
    kept = [np.zeros(((rows - 1) * smooth, count, count)) for _ in range(2)] + [np.zeros((rows * smooth, count))]
    dt, *densities = arguments(recording, noise, count, 11)
    failure, step = _kernels.wander_run(
        *(P, C, s, recording.dtheta, recording.dv, recording.mount_angle, recording.axes),
        *(EARTH_RADIUS, recording.gravity, dt, *densities),
        *(
            steps,
            fixes.values,
            fixes.variances,
            MARGINS,
            keep,
            attitudes,
            states,
            covariances,
            nis,
            follows,
            smooth,
            *kept,
        ),
    )
    raise_failure(failure, step, dt)
    counts = np.isfinite(fixes.values).sum(axis=1)
    warn_of_innovations(nis, counts)
    if not follows:
        _warn_of_turns(attitudes, states, prior.heading if heading_known else np.pi / 2, fixes.variances[:3])
    time = dt * keep * np.arange(rows)
    return wander_result(time, attitudes, states, covariances, (fixes.time, nis, counts)), kept


def _warn_of_turns(C: Array, s: Array, heading_std: float, variances: Array) -> None:
    """Warn if the hull turned under way by so much that the error of heading was seen in the aid's velocity."""
    azimuth = np.unwrap(np.arctan2(C[:, 2, 0], C[:, 0, 0]))
    turn, speed = np.abs(azimuth - azimuth[0]), np.hypot(s[:, 0], s[:, 2])
    aided = np.sqrt(np.nan_to_num(variances)).max()
    seen = speed * np.abs(2 * np.sin(np.minimum(turn, np.pi) / 2)) * min(heading_std, 1.0)
    bad = (turn > TURN) & (speed > 5 * aided) & (seen > 5 * aided)
    if bad.any():
        warnings.warn(
            f"the hull turns by up to {turn[bad].max() / DEG:.3g} deg under way at {speed[bad].max():.3g} m/s with "
            f"heading known to {min(heading_std, np.pi) / DEG:.3g} deg at the start: the filter may be too sure of "
            "heading. Use `course_follows_heading=True` if the vessel moves where it looks, or find heading before",
            UserWarning,
            stacklevel=4,
        )


def wander_start(start: CompassState, prior: Prior, heading_known: bool) -> tuple[Array, Array]:
    """Covariance, shape (17, 17), and state, (14,), at the start: w has north where the compass takes it to be."""
    square = prior.heading**2 if heading_known else np.inf
    c = np.cos(start.lat)
    mean, along, across = np.exp(-square / 2), (1 - np.exp(-square)) ** 2 / 2, (1 - np.exp(-2 * square)) / 2
    north = prior.position / EARTH_RADIUS
    std = [prior.level, 0.0, prior.level, *[prior.velocity] * 3, north, north / c, prior.height]
    axis = c * np.sqrt([along, across])
    P = np.diag(np.square([*std, *axis, *[prior.bias] * 3, *[prior.scale_factor] * 3]))
    return P, np.array([*start.velocity, start.lat, start.lon, start.alt, c * mean, 0.0, *np.zeros(6)])


def wander_result(time: Array, C: Array, s: Array, P: Array, innovations: tuple) -> WanderRun:
    """Run in the quantities of the thesis, from that in the filter's."""
    north = _north(s, P)
    angles, T = _angles(C, s, *north)
    estimate = np.hstack([angles, s[:, :6], s[:, 8:]])
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
    for row in range(3, 9):
        T[:, row, row] = 1.0
    for row in range(9, 15):  # estimate less truth: the negative of what the gyros have left
        T[:, row, row + 2] = -1.0
    return np.stack([heading, trim, roll], axis=-1), T


def wander_matrix(
    C_h_w: ArrayLike,
    state: ArrayLike,
    rates: ArrayLike,
    specific_force: ArrayLike,
    mount_angle: float,
    gravity: float,
    pushed: bool = False,
    yaw: float = 0.0,
) -> Array:
    """Matrix F of the linear model of the errors `WANDER_STATES`.

    Parameters
    ----------
    C_h_w : array_like, shape (3, 3)
        Attitude of the hull against w.
    state : array_like, shape (8,) at least
        Velocity north, up, east, m/s; latitude, longitude, rad, height, m; the Earth's axis 1, 2.
    rates : array_like, shape (3,)
        Of the gyros, rad/s.
    specific_force : array_like, shape (3,)
        In the hull, m/s^2.
    mount_angle, gravity : float
        rad; on the sphere, m/s^2.
    pushed : bool, optional
        Whether the vessel manoeuvres in another way than by turning.
    yaw : float, optional
        Rate of its turning, clockwise, rad/s.

    Returns
    -------
    ndarray, shape (17, 17)
        Rows of biases and scale factors are zero.
    """
    C, s = checks.rotation_matrix("C_h_w", C_h_w), checks.finite_array("state", state)
    F, radius = np.empty((17, 17)), EARTH_RADIUS + s[5]
    weight = checks.positive("gravity", gravity, "m/s^2") * (EARTH_RADIUS / radius) ** 2
    rates = checks.finite_array("rates", rates, shape=(3,))
    force = C @ checks.finite_array("specific_force", specific_force, shape=(3,))
    _kernels.wander_matrix(C, s, force, pushed, yaw, rates, mount_angle, pyramid_axes(), radius, weight, F)
    return F


def wander_rate(
    C_h_w: ArrayLike,
    state: ArrayLike,
    omega_ih_h: ArrayLike,
    specific_force: ArrayLike,
    gravity: float,
    turn: ArrayLike | None = None,
    yaw: float = 0.0,
) -> tuple[Array, Array]:
    """Rate of turn of the hull against w, in w, shape (3,), and rates of velocity, position and axis, shape (8,).

    What `wander_matrix` is the derivative of. Arguments as there, the rate of the hull, rad/s, and the specific force,
    m/s^2. `turn`, shape (2, 2), is what takes north and east to w in the place of the turn by the axis, where the
    vessel does not manoeuvre but by turning with `yaw`, rad/s.
    """
    C, s = checks.rotation_matrix("C_h_w", C_h_w), checks.finite_array("state", state)
    (north, up, east), lat, radius, R = s[:3], s[3], EARTH_RADIUS + s[5], _axis_turn(s)
    v_1, v_2 = R @ [north, east]
    transport, axis = np.array([v_2, 0.0, -v_1]) / radius, np.array([s[6], np.sin(lat), s[7]])
    frame = EARTH_RATE * axis + transport
    force, coriolis = C @ specific_force, _coriolis(s)
    turning = yaw * np.array([-east, north])
    level = force[[0, 2]] - R @ (coriolis[[0, 2]] + turning)
    dv_n, dv_e = (R if turn is None else np.asarray(turn)).T @ level + turning
    dv_u = force[1] - gravity * (EARTH_RADIUS / radius) ** 2 - coriolis[1]
    position = [north / radius, east / (radius * np.cos(lat)), up]
    rest = np.array([dv_n, dv_u, dv_e, *position, *-np.cross(transport, axis)[[0, 2]]])
    return C @ np.asarray(omega_ih_h) - frame, rest


def _axis_turn(s: Array) -> Array:
    """Turn of level vectors from north and east to w by the axis, shape (2, 2)."""
    return np.array([[s[6], -s[7]], [s[7], s[6]]]) / np.cos(s[3])


def _coriolis(s: Array) -> Array:
    """Coriolis force per mass on a vessel that keeps its velocity, north, up, east, with a turn of the meridian."""
    v, radius = s[:3], EARTH_RADIUS + s[5]
    earth = EARTH_RATE * np.array([np.cos(s[3]), np.sin(s[3]), 0.0])
    transport = np.array([v[2], v[2] * np.tan(s[3]), -v[0]]) / radius
    return np.cross(2 * earth + transport, v)
