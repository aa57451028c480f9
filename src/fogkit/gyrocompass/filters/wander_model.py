"""Error model of the filter with the Earth's axis for a state, and the rates that it is the derivative of.

For tests: `fogkit.gyrocompass.filters.wander` has the same, compiled. What the model is, is written there.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass.filters import _wander_kernels
from fogkit.gyrocompass.frames import pyramid_axes
from fogkit.gyrocompass.mechanisation import EARTH_RADIUS

Array = NDArray[np.float64]

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
    _wander_kernels.wander_matrix(C, s, force, pushed, yaw, rates, mount_angle, pyramid_axes(), radius, weight, F)
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
