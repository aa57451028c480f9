"""How errors of the gyrocompass grow and what aiding sees of them: equations (8) to (12).

An error is what is computed less what is true, of the quantities of `fogkit.gyrocompass.mechanisation`; a gyro reads
``(1 + scale factor error) * rate + bias + noise``. The thesis prints the row of heading, (8); the others follow from
the same variation. `fogkit.reproduction.lechang.derivation` sets the print beside it.

References
----------
.. [1] Le Van Chang, Gyrocompass with a quasi-harmonic autocompensating mount (in Russian), thesis abstract, LETI,
   St Petersburg, 2015, chapter 2.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.constants import STANDARD_GRAVITY
from fogkit.gyrocompass import _kernels
from fogkit.gyrocompass.frames import hull_attitude, mount_attitude, pyramid_axes
from fogkit.gyrocompass.mechanisation import EARTH_RADIUS, CompassState, Reading, checked_trim

Array = NDArray[np.float64]

STATES = (
    *("heading", "trim", "roll"),
    *("velocity_north", "velocity_up", "velocity_east"),
    *("lat", "lon", "alt"),
    *("bias_x", "bias_y", "bias_z"),
    *("scale_factor_x", "scale_factor_y", "scale_factor_z"),
)
"""The state vector (10) of [1]_: rad, m/s, rad and m, rad/s, 1."""

MEASUREMENTS = STATES[3:9]
"""What aiding measures, (11) of [1]_: the computed less the aid's velocity and position."""


def system_matrix(state: CompassState, reading: Reading, gravity: float = STANDARD_GRAVITY) -> Array:
    """Matrix F of the linear error model, ``dx/dt = F x + G w``: (8) and (9) of [1]_.

    Parameters
    ----------
    state : CompassState
        Angles, velocity, position about which errors are taken.
    reading : Reading
        What the sensors read there.
    gravity : float, optional
        Gravity on the sphere, m/s^2.

    Returns
    -------
    ndarray, shape (15, 15)
        In the order of `STATES`. Accelerometers are without error, as in [1]_; see `accelerometer_input`.
    """
    radius = EARTH_RADIUS + state.alt
    there = checks.positive("gravity", gravity, "m/s^2") * (EARTH_RADIUS / radius) ** 2
    F = np.empty((15, 15))
    force, angle, rate = reading.specific_force, reading.mount_angle, reading.mount_rate
    _kernels.system_matrix(state.to_vector(), reading.rates, force, angle, rate, pyramid_axes(), radius, there, F)
    return F


def noise_input(trim: float, roll: float, mount_angle: float) -> Array:
    """Matrix G that takes white noise of the gyros into the states: (9) of [1]_.

    Parameters
    ----------
    trim, roll, mount_angle : float
        Angles of the hull and of the mount, rad.

    Returns
    -------
    ndarray, shape (15, 3)
        In the order of `STATES`; only the rows of the angles are not zero.
    """
    trim = float(checked_trim(checks.finite("trim", trim, "rad")))
    roll = checks.finite("roll", roll, "rad")
    forward, up, starboard = mount_attitude(mount_angle) @ pyramid_axes()
    down = starboard * np.sin(roll) - up * np.cos(roll)
    G = np.zeros((15, 3))
    G[0], G[1] = down / np.cos(trim), up * np.sin(roll) + starboard * np.cos(roll)
    G[2] = forward + np.tan(trim) * down
    return G


def accelerometer_input(heading: float, trim: float, roll: float) -> Array:
    """Matrix that takes errors of the accelerometers on the hull into the states; [1]_ leaves them out.

    Parameters
    ----------
    heading, trim, roll : float
        Angles of the hull, rad.

    Returns
    -------
    ndarray, shape (15, 3)
        In the order of `STATES`; only the rows of velocity are not zero.
    """
    G = np.zeros((15, 3))
    G[3:6] = hull_attitude(heading, trim, roll)
    return G


def measurement_matrix(measured: ArrayLike | None = None) -> Array:
    """Matrix H of the aiding, ``z = H x + v``: (11) and (12) of [1]_.

    Parameters
    ----------
    measured : sequence of str, optional
        Which of `STATES` the aid measures; velocity and position, as in [1]_, if not given.

    Returns
    -------
    ndarray, shape (m, 15)
        Rows of the unit matrix.

    Raises
    ------
    ValueError
        If a name is none of `STATES`, or comes twice, or there is none at all: without aiding nothing can be observed.
    """
    names = MEASUREMENTS if measured is None else tuple(measured)
    if not names:
        raise ValueError("`measured` must name a state at least, got none: an unaided filter observes nothing")
    for name in names:
        checks.option("measured", name, STATES)
    if len(set(names)) < len(names):
        raise ValueError(f"`measured` must name each state once, got {names}")
    return np.eye(len(STATES))[[STATES.index(name) for name in names]]
