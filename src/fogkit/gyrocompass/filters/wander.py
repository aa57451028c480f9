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

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.gyrocompass.covariance import Noise, Prior, multiple
from fogkit.gyrocompass.filters import _wander_kernels
from fogkit.gyrocompass.filters.records import Fixes, Recording
from fogkit.gyrocompass.filters.runs import MARGINS, arguments, fix_steps, raise_failure, warn_of_innovations
from fogkit.gyrocompass.filters.wander_estimates import WanderRun, wander_result
from fogkit.gyrocompass.filters.wander_model import WANDER_STATES
from fogkit.gyrocompass.frames import hull_attitude
from fogkit.gyrocompass.mechanisation import EARTH_RADIUS, CompassState
from fogkit.units import DEG

Array = NDArray[np.float64]

TURN = 10 * DEG
"""Turn of the hull, rad, that is more than yawing in waves."""


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
    failure, step = _wander_kernels.wander_run(
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
