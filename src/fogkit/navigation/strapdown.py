"""Strapdown mechanisation in east-north-up: attitude, velocity and position from increments.

`integrate` takes a table; `integrate_arrays` takes arrays, of one recording or of thousands at once. Both run the same
compiled loop. The state is that of the body b against the Earth e in axes of n, as in `fogkit.rotation` and
`fogkit.earth`; gravity is the plumb-line one, centrifugal part included.

**What is solved**, with the Earth rate ``omega_ie_n``, the transport rate ``omega_en_n`` and their sum ``omega_in_n``::

    C_b_n' = C_b_n skew(omega_ib_b) - skew(omega_in_n) C_b_n
    v_eb_n' = C_b_n f_ib_b + g_b_n - (2 omega_ie_n + omega_en_n) x v_eb_n

and the position follows the velocity: [1]_, section 3.5; [2]_, section 5.4.

**How.** With a and f the increments of a step of length T, and da, df their change from the step before to the step
after::

    p = a + a x da / 24                                             [1]  rotation vector of the body: coning
    u = f + (a x df + f x da) / 24                                  [2]  sculling
    w = u + (1 - cos p)/p^2 p x u + (p - sin p)/p^3 p x (p x u)     [3]  velocity gained, body axes of the start
    m = w/2 - (y + a x y / 2) / 12,   y = a x f + df/2              [4]  mean over the step of the velocity gained

[1] and [2] together are the Magnus expansion to fourth order [5]_ of attitude and velocity as one rigid motion, and [3]
is its exponential; read apart they are the coning and sculling corrections of Savage [3]_ [4]_, who has the increments
of the step before alone. Looking to both sides costs nothing in a recording and cancels the next order.
[4] is the Euler-Maclaurin formula. Then, with capitals for w and m in axes of n and z the turn of n during the step::

    mean height = h + T v_mean / 2 - T dv / 12, latitude likewise   [5]  where gravity and all rates are evaluated
    z = T omega_in_n,   c = g_b_n - (2 omega_ie_n + omega_en_n) x v [6]  with the velocity v at the start: z_0, c_0
    M' = M - z_0 x W / 6                                                 the frame turns while W is gained
    z, c                                                            [7]  with the velocity v + M' + T c_0 / 2
    v_mean = v + M' + T (c_0 + 2 c) / 6
    dv = W - z x (W - M' - z_0 x W / 3) + T c                       [8]
    C_b_n = exp(-skew(z)) C_b_n exp(skew(p))                        [9]  by quaternions

and the position moves with ``v_mean``.

**Order.** The error of attitude, velocity and position at a given time is of fourth order in T with
``corrections="central"``, third with ``"previous"``, second with ``"none"``. Left out, of second order: in velocity
``T^2 |g| |v - v_start| / (12 R)``, 1.3e-9 m/s at 100 Hz after a change by 100 m/s; in position, per second,
``T^2 (|a| / 12 + |g| / 6) |v| / R``, 4e-9 m/s at 100 m/s. At rest there is nothing of second order, and 2e-13 m/s^2 at
a step of 1 s.

References
----------
.. [1] D. H. Titterton, J. L. Weston, Strapdown inertial navigation technology, 2nd edition, IEE (2004).
.. [2] P. D. Groves, Principles of GNSS, inertial, and multisensor integrated navigation systems, 2nd edition (2013).
.. [3] P. G. Savage, Strapdown inertial navigation integration algorithm design part 1: attitude algorithms, Journal of
   Guidance, Control, and Dynamics 21 (1998), 19-28.
.. [4] P. G. Savage, part 2: velocity and position algorithms, the same volume, 208-221.
.. [5] A. Iserles, H. Z. Munthe-Kaas, S. P. Norsett, A. Zanna, Lie-group methods, Acta Numerica 9 (2000), 215-365.
"""

import warnings
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from fogkit import checks, earth
from fogkit.navigation import _kernels
from fogkit.navigation._gravity import Gravity, GravityModel, contiguous, followed, gravity_model
from fogkit.navigation.increments import time_step, values
from fogkit.navigation.states import State, Trajectory

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

_CORRECTIONS = {"none": _kernels.NONE, "previous": _kernels.PREVIOUS, "central": _kernels.CENTRAL}
# A unit at rest whose specific force departs from gravity by a larger factor than this, either way, is in wrong units.
_GRAVITY_FACTOR = 2.0


def integrate(
    increments: "DataFrame", start: State, *, velocity_reset: ArrayLike | None = None, **options
) -> Trajectory:
    """Navigate through a table of increments.

    Parameters
    ----------
    increments : DataFrame
        Index ``time``, s, the beginning of each step, equally spaced; columns ``gyro_x`` to ``accel_z``: increments of
        angle, rad, and of velocity, m/s (`fogkit.navigation.increments`).
    start : State
        State at the first time.
    velocity_reset : float or array_like, shape (r,), optional
        Times, s, at which the velocity is set to zero, within the table; the sample nearest to each.
    **options
        As in `integrate_arrays`: `gravity`, `corrections`, `position_fixed`, `every`, `keep_attitude`.

    Returns
    -------
    Trajectory
        States at the start and after every step, or every `every`-th; `Trajectory.to_frame` makes a table of it. A row
        at the time of a reset holds the velocity after it.

    Raises
    ------
    ValueError
        If a column is missing, a value not finite, times are unequal or out of order, a step turns by more than pi, a
        reset is outside of the table, or the navigation leaves the Earth or passes a pole.

    Warns
    -----
    UserWarning
        If the unit starts from rest and its specific force in the first second is not gravity to a factor of two:
        legal, but seldom meant. Rates in place of increments, or g in place of m/s^2, look like this.

    Examples
    --------
    A unit at rest, level, heading north, at 60 degrees of latitude:

    >>> import pandas as pd
    >>> from fogkit.earth import earth_rate_n, gravity_n
    >>> lat, dt = np.deg2rad(60.0), 0.01
    >>> reading = np.concatenate([earth_rate_n(lat), -gravity_n(lat)]) * dt
    >>> columns = ["gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"]
    >>> increments = pd.DataFrame([reading] * 6000, index=pd.Index(dt * np.arange(6000), name="time"), columns=columns)
    >>> trajectory = integrate(increments, State(lat=lat, C_b_n=np.eye(3)))
    >>> bool(np.abs(trajectory.v_eb_n[-1]).max() < 1e-9)
    True
    """
    first, step = time_step(increments)
    sums = values(increments)
    resets = None if velocity_reset is None else checks.finite_array("velocity_reset", velocity_reset) - first
    return integrate_arrays(sums[:, :3], sums[:, 3:], step, start, velocity_reset=resets, start_time=first, **options)


def integrate_arrays(
    dtheta_ib_b: ArrayLike,
    dv_ib_b: ArrayLike,
    dt: float,
    start: State,
    *,
    gravity: Gravity = None,
    corrections: str = "central",
    velocity_reset: ArrayLike | None = None,
    position_fixed: bool = False,
    every: int = 1,
    keep_attitude: bool = True,
    start_time: float = 0.0,
) -> Trajectory:
    """Navigate through arrays of increments, of one recording or of many.

    Parameters
    ----------
    dtheta_ib_b, dv_ib_b : array_like, shape (..., n, 3)
        Increments of angle, rad, and of velocity, m/s, n steps of as many runs as the leading axes hold.
    dt : float
        Duration of a step, s.
    start : State
        State at the start; its leading axes broadcast to those of the increments.
    gravity : None, float, array_like or callable, optional
        None is normal gravity at the position. A number is its magnitude everywhere, m/s^2; an array of shape (3,) the
        vector, east, north, up; one of shape (..., n, 3) the mean vector of each step. A function of latitude,
        longitude and height, arrays of one shape (...,), that returns vectors, shape (..., 3), is called for whole
        trajectories and followed by iteration: plain Python will do, a map interpolated by SciPy as well.
    corrections : {"central", "previous", "none"}, optional
        Neighbours that coning and sculling are corrected from: both; the step before, as in real time; or none at all.
    velocity_reset : array_like, shape (r,) or (..., r), optional
        Times from the start, s, at which the velocity is set to zero: navigation begins anew from rest, with the
        attitude carried on. Leading axes are runs. The sample nearest to each time is taken.
    position_fixed : bool, optional
        Whether the position is held at the start, as in a laboratory: velocity is then but the error of velocity. It
        still turns the navigation frame, so it oscillates as it would.
    every : int, optional
        Steps from one row of the result to the next: rows are the start and what follows every so many steps.
    keep_attitude : bool, optional
        Whether the result holds the attitude; a campaign that looks at velocities saves half of the memory without.
    start_time : float, optional
        Time of the start in the result, s.

    Returns
    -------
    Trajectory
        States, with the leading axes of the increments.

    Raises
    ------
    ValueError, TypeError
        As `integrate`, and for a shape that does not fit.

    Warns
    -----
    UserWarning
        As `integrate`.

    Notes
    -----
    Runs are navigated one after the other on the calling thread, without the interpreter's lock, so threads may share
    them.
    """
    dtheta, dv = _pair(dtheta_ib_b, dv_ib_b)
    *runs, steps, _ = dtheta.shape
    runs = tuple(runs)
    dt = checks.positive("dt", dt, "s")
    every = checks.integer("every", every, minimum=1)
    scheme = _CORRECTIONS[checks.option("corrections", corrections, _CORRECTIONS)]
    start = _broadcast(checks.instance("start", start, State), runs)
    resets = _reset_steps(velocity_reset, dt, steps, runs)
    model = gravity_model(gravity, start, runs, steps)
    _warn_of_units(dv, dt, start, model)

    count = int(np.prod(runs))
    flat = (dtheta.reshape(count, steps, 3), dv.reshape(count, steps, 3))
    initial = (
        Rotation.from_matrix(start.C_b_n.reshape(count, 3, 3)).as_quat(),
        contiguous(start.v_eb_n, count, 3),
        contiguous(np.stack([start.lat, start.lon, start.alt], axis=-1), count, 3),
    )

    def run(model: "GravityModel", every: int, keep_attitude: bool) -> tuple[Array, Array, Array]:
        rows = 1 + steps // every
        outputs = (
            np.empty((count, rows if keep_attitude else 0, 4)),
            np.empty((count, rows, 3)),
            np.empty((count, 0 if position_fixed else rows, 3)),
        )
        left = np.empty(count, np.int64)
        limits = np.sin(earth.POLE_MARGIN), earth.GRAVITY_HEIGHT_LIMIT
        _kernels.navigate_runs(
            *flat,
            dt,
            scheme,
            model.normal,
            model.vectors,
            position_fixed,
            *limits,
            resets,
            every,
            *initial,
            *outputs,
            left,
        )
        _require_on_earth(left, dt, start_time)
        return outputs

    if callable(gravity):
        model = followed(gravity, run, initial[2], steps, position_fixed)
    quaternion, velocity, position = run(model, every, keep_attitude)
    rows = velocity.shape[1]
    if position_fixed:
        position = np.broadcast_to(initial[2][:, None, :], (count, rows, 3))
    lat, lon, alt = np.moveaxis(position.reshape(*runs, rows, 3), -1, 0)
    return Trajectory(
        time=start_time + dt * every * np.arange(rows),
        lat=lat,
        lon=lon,
        alt=alt,
        v_eb_n=velocity.reshape(*runs, rows, 3),
        quaternion=quaternion.reshape(*runs, rows, 4) if keep_attitude else None,
    )


def _pair(dtheta_ib_b: ArrayLike, dv_ib_b: ArrayLike) -> tuple[Array, Array]:
    """Both kinds of increments, of one shape (..., n, 3); contiguous and writable, as the kernel is compiled for."""
    dtheta = checks.finite_array("dtheta_ib_b", dtheta_ib_b, shape=(..., None, 3))
    dv = checks.finite_array("dv_ib_b", dv_ib_b, shape=(..., None, 3))
    if dtheta.shape != dv.shape:
        raise ValueError(f"`dv_ib_b` must have the shape of `dtheta_ib_b`, {dtheta.shape}, got {dv.shape}")
    largest = np.abs(dtheta).max()
    if largest > np.pi:
        raise ValueError(
            f"`dtheta_ib_b` must be at most pi in a step, got {largest:.6g} rad. Increments are in rad; "
            "`fogkit.navigation.increments.increments_from_rates` makes them from rates."
        )
    return np.require(dtheta, requirements=["C", "W"]), np.require(dv, requirements=["C", "W"])


def _broadcast(start: State, runs: tuple[int, ...]) -> State:
    """State with the leading axes of the increments."""
    try:
        lat = np.broadcast_to(start.lat, runs)
    except ValueError:
        raise ValueError(f"`start` must broadcast to the runs of the increments, {runs}, got {start.shape}") from None
    return State(lat=lat, lon=start.lon, alt=start.alt, v_eb_n=start.v_eb_n, C_b_n=start.C_b_n)


def _reset_steps(times: ArrayLike | None, dt: float, steps: int, runs: tuple[int, ...]) -> NDArray[np.int64]:
    """Steps done at each reset, ascending, shape (runs or 1, r)."""
    if times is None:
        return np.empty((1, 0), np.int64)
    times = np.atleast_1d(checks.finite_array("velocity_reset", times))
    nearest = np.rint(times / dt).astype(np.int64)
    if nearest.min() < 0 or nearest.max() > steps:
        worst = times.min() if nearest.min() < 0 else times.max()
        raise ValueError(
            f"`velocity_reset` must be within the increments, 0 to {steps * dt:.6g} s from their start, "
            f"got {worst:.6g} s"
        )
    if times.ndim > 1:
        try:
            nearest = np.broadcast_to(nearest, (*runs, times.shape[-1]))
        except ValueError:
            raise ValueError(f"`velocity_reset` must have the leading axes {runs} of runs, got {times.shape}") from None
    return np.sort(contiguous(nearest, -1, times.shape[-1]), axis=-1)


def _require_on_earth(left: NDArray[np.int64], dt: float, start_time: float) -> None:
    """``ValueError`` for the first run that the kernel gave up."""
    if (left < 0).all():
        return
    run = int(np.argmax(left >= 0))
    raise ValueError(
        f"the increments must keep the position within {earth.GRAVITY_HEIGHT_LIMIT:g} m of height and "
        f"{earth.POLE_MARGIN:g} rad off the poles; run {run} leaves at {start_time + dt * left[run]:.6g} s. "
        "Look at their units and at the start; a unit at rest may have `position_fixed=True`."
    )


def _warn_of_units(dv: Array, dt: float, start: State, model: GravityModel) -> None:
    """Warn if a unit at rest does not feel gravity in the first second."""
    if model.normal:
        expected = earth.normal_gravity(start.lat, start.alt)
    else:
        expected = np.linalg.norm(model.vectors[:, 0], axis=-1).reshape(-1)
        expected = expected.reshape(start.shape) if expected.size == start.lat.size else expected[0]
    samples = dv[..., : max(1, round(1.0 / dt)), :]
    felt = np.linalg.norm(samples, axis=-1).mean(axis=-1) / dt
    at_rest = (start.v_eb_n == 0).all(axis=-1)
    wrong = at_rest & ((felt > _GRAVITY_FACTOR * expected) | (felt < expected / _GRAVITY_FACTOR))
    if wrong.any():
        warnings.warn(
            f"a unit that starts from rest feels {felt[wrong].flat[0]:.4g} m/s^2 in the first second where gravity is "
            f"{np.broadcast_to(expected, wrong.shape)[wrong].flat[0]:.4g} m/s^2: are these increments, in m/s, and is "
            "`dt` right?",
            UserWarning,
            stacklevel=4,
        )
