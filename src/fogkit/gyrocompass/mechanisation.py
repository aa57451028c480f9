"""What the readings of the gyrocompass say of heading, trim, roll, velocity and position: equations (3) to (7).

The Earth is a sphere that turns, with gravity towards its centre that falls with the square of the distance, as in the
thesis; where the ellipsoid matters `fogkit.navigation` has it. Vectors are in the axes of `fogkit.gyrocompass.frames`.

References
----------
.. [1] Le Van Chang, Gyrocompass with a quasi-harmonic autocompensating mount (in Russian), thesis abstract, LETI,
   St Petersburg, 2015, chapter 2.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.constants import EARTH_RATE, SEMI_MAJOR_AXIS, SEMI_MINOR_AXIS, STANDARD_GRAVITY
from fogkit.earth import POLE_MARGIN, checked_latitude
from fogkit.gyrocompass.frames import hull_attitude, mount_attitude, pyramid_axes

Array = NDArray[np.float64]

EARTH_RADIUS = (2 * SEMI_MAJOR_AXIS + SEMI_MINOR_AXIS) / 3
"""Radius of the sphere, m: the mean one of WGS 84, 6371009 m; [1]_ does not state its own."""

TRIM_MARGIN = 1e-3
"""Distance from a vertical bow, rad, within which rates of heading and roll are refused."""


@dataclass(frozen=True, kw_only=True)
class CompassState:
    """What the gyrocompass computes: angles, velocity, position.

    Parameters
    ----------
    heading, trim, roll : float
        Angles of the hull, rad.
    velocity : array_like, shape (3,), optional
        Velocity over the Earth, north, up, east, m/s.
    lat : float
        Latitude, rad, at least `fogkit.earth.POLE_MARGIN` from a pole.
    lon, alt : float, optional
        Longitude, rad, and height above the sphere, m.

    Raises
    ------
    ValueError
        If an entry is not finite, `lat` too near to a pole, or `trim` too near to the vertical.
    """

    heading: float
    lat: float
    trim: float = 0.0
    roll: float = 0.0
    velocity: ArrayLike = (0.0, 0.0, 0.0)
    lon: float = 0.0
    alt: float = 0.0

    def __post_init__(self) -> None:
        for name, unit in (("heading", "rad"), ("roll", "rad"), ("lon", "rad"), ("alt", "m")):
            object.__setattr__(self, name, checks.finite(name, getattr(self, name), unit))
        object.__setattr__(self, "trim", float(checked_trim(checks.finite("trim", self.trim, "rad"))))
        lat = checked_latitude(checks.finite("lat", self.lat, "rad"), pole_margin=POLE_MARGIN)
        object.__setattr__(self, "lat", float(lat))
        velocity = np.array(checks.finite_array("velocity", self.velocity, shape=(3,)))
        velocity.setflags(write=False)
        object.__setattr__(self, "velocity", velocity)

    def to_vector(self) -> Array:
        """Heading, trim, roll, velocity north, up, east, latitude, longitude, height: shape (9,), the order of (10)."""
        return np.array([self.heading, self.trim, self.roll, *self.velocity, self.lat, self.lon, self.alt])


@dataclass(frozen=True, kw_only=True)
class Reading:
    """What the sensors read at one time.

    Parameters
    ----------
    rates : array_like, shape (3,)
        Rates of the gyros x, y, z of the pyramid against inertial space, rad/s.
    specific_force : array_like, shape (3,), optional
        Of the accelerometers, which stand on the hull: forward, up, starboard, m/s^2. At rest and level if not given.
    mount_angle, mount_rate : float, optional
        Angle of the mount, rad, and its rate, rad/s.
    """

    rates: ArrayLike
    specific_force: ArrayLike = (0.0, STANDARD_GRAVITY, 0.0)
    mount_angle: float = 0.0
    mount_rate: float = 0.0

    def __post_init__(self) -> None:
        for name in ("rates", "specific_force"):
            values = np.array(checks.finite_array(name, getattr(self, name), shape=(3,)))
            values.setflags(write=False)
            object.__setattr__(self, name, values)
        for name, unit in (("mount_angle", "rad"), ("mount_rate", "rad/s")):
            object.__setattr__(self, name, checks.finite(name, getattr(self, name), unit))


def checked_trim(trim: ArrayLike) -> Array:
    """Trim as float64, after the check that it is at least `TRIM_MARGIN` from the vertical."""
    limit = np.pi / 2 - TRIM_MARGIN
    fix = "Heading and roll are not defined apart when the bow is vertical: use `C_h_g`. Degrees need `units.DEG`."
    return checks.array_in_closed_interval("trim", trim, -limit, limit, "rad", fix=fix)


def hull_rate(rates: ArrayLike, mount_angle: ArrayLike, mount_rate: ArrayLike) -> Array:
    """Rate of the hull against inertial space, from the gyros and the mount: (3) of [1]_.

    Parameters
    ----------
    rates : array_like, shape (..., 3)
        Rates of the gyros of the pyramid, rad/s.
    mount_angle, mount_rate : array_like, shape (...,)
        Angle and rate of the mount against the hull, rad and rad/s.

    Returns
    -------
    ndarray, shape (..., 3)
        ``omega_ih_h``, forward, up, starboard, rad/s.
    """
    in_mount = checks.finite_array("rates", rates, shape=(..., 3)) @ pyramid_axes().T
    about_axis = np.asarray(mount_rate, dtype=float)[..., np.newaxis] * np.array([0.0, 1.0, 0.0])
    return (mount_attitude(mount_angle) @ (in_mount - about_axis)[..., np.newaxis])[..., 0]


def gyro_rates(omega_ih_h: ArrayLike, mount_angle: ArrayLike, mount_rate: ArrayLike) -> Array:
    """Rates that the gyros of the pyramid sense, rad/s, shape (..., 3): the inverse of `hull_rate`."""
    hull = checks.finite_array("omega_ih_h", omega_ih_h, shape=(..., 3))
    about_axis = np.asarray(mount_rate, dtype=float)[..., np.newaxis] * np.array([0.0, 1.0, 0.0])
    in_mount = (mount_attitude(mount_angle).swapaxes(-1, -2) @ hull[..., np.newaxis])[..., 0] + about_axis
    return in_mount @ pyramid_axes()


def hull_increments(dtheta: ArrayLike, mount_angle: ArrayLike) -> Array:
    """Integrals of the hull's rate over steps, from those of the gyros and the mount's angles between them.

    Parameters
    ----------
    dtheta : array_like, shape (n, 3)
        Integrals of the rates of the gyros of the pyramid over each step, rad.
    mount_angle : array_like, shape (n + 1,)
        Angles of the mount at the ends of the steps, rad.

    Returns
    -------
    ndarray, shape (n, 3)
        Integrals of ``omega_ih_h``, forward, up, starboard, rad: exact for a hull whose rate is constant and a mount
        whose rate is constant over the step, else to the third order of the step. ``TO_PACKAGE`` of
        `fogkit.gyrocompass.frames` makes them those of the body that `fogkit.navigation.integrate_arrays` takes.

    Raises
    ------
    ValueError
        If there is not one angle more than steps, or the mount turns by more than half a turn in a step.
    """
    dtheta = checks.finite_array("dtheta", dtheta, shape=(None, 3))
    needed = "One angle at each end of a step."
    angle = checks.finite_array("mount_angle", mount_angle, shape=(len(dtheta) + 1,), fix=needed)
    turned = np.diff(angle)
    if np.abs(turned).max() > np.pi:
        raise ValueError(
            f"`mount_angle` must not change by more than pi in a step, got {np.abs(turned).max():.3g} rad: unwrap it "
            "(`numpy.unwrap`), or sample faster"
        )
    in_mount = dtheta @ pyramid_axes().T
    in_mount[:, 1] -= turned
    # a level vector of the hull seen from the turning mount is shortened by the mean of its turn about the middle
    in_mount[:, [0, 2]] /= np.sinc(turned / (2 * np.pi))[:, np.newaxis]
    middle = mount_attitude((angle[1:] + angle[:-1]) / 2)
    return (middle @ in_mount[..., np.newaxis])[..., 0]


def geographic_rate(lat: ArrayLike, velocity: ArrayLike, alt: ArrayLike = 0.0) -> Array:
    """Rate of north-up-east against inertial space: (5) of [1]_.

    Parameters
    ----------
    lat : array_like, shape (...,)
        Latitude, rad.
    velocity : array_like, shape (..., 3)
        Velocity over the Earth, north, up, east, m/s.
    alt : array_like, shape (...,), optional
        Height above the sphere, m.

    Returns
    -------
    ndarray, shape (..., 3)
        ``omega_ig_g``, north, up, east, rad/s.

    Raises
    ------
    ValueError
        If `lat` is within `fogkit.earth.POLE_MARGIN` of a pole, where the up component has no limit.
    """
    lat = checked_latitude(lat, pole_margin=POLE_MARGIN)
    north, _, east = np.moveaxis(checks.finite_array("velocity", velocity, shape=(..., 3)), -1, 0)
    radius = EARTH_RADIUS + checks.finite_array("alt", alt)
    level, up = EARTH_RATE * np.cos(lat) + east / radius, EARTH_RATE * np.sin(lat) + east * np.tan(lat) / radius
    return np.stack(np.broadcast_arrays(level, up, -north / radius), axis=-1)


def angle_rates(omega_gh_h: ArrayLike, trim: ArrayLike, roll: ArrayLike) -> Array:
    """Rates of heading, trim and roll, from the rate of the hull against north-up-east: (6) of [1]_.

    Parameters
    ----------
    omega_gh_h : array_like, shape (..., 3)
        Relative rate (4), forward, up, starboard, rad/s.
    trim, roll : array_like, shape (...,)
        Angles, rad.

    Returns
    -------
    ndarray, shape (..., 3)
        Rates of heading, trim, roll, rad/s. The fraction before the bracket for heading needs a minus sign, which the
        scan of [1]_ does not show: heading is clockwise and the second axis points up.

    Raises
    ------
    ValueError
        If `trim` is within `TRIM_MARGIN` of the vertical.
    """
    forward, up, starboard = np.moveaxis(checks.finite_array("omega_gh_h", omega_gh_h, shape=(..., 3)), -1, 0)
    trim, roll = checked_trim(trim), checks.finite_array("roll", roll)
    level = up * np.cos(roll) - starboard * np.sin(roll)
    rates = -level / np.cos(trim), up * np.sin(roll) + starboard * np.cos(roll), forward - np.tan(trim) * level
    return np.stack(np.broadcast_arrays(*rates), axis=-1)


def state_rate(state: CompassState, reading: Reading, gravity: float = STANDARD_GRAVITY) -> Array:
    """Rate of all that the gyrocompass computes: (3)-(6) of [1]_ with the equations of velocity and position.

    Parameters
    ----------
    state : CompassState
        Angles, velocity, position.
    reading : Reading
        What the sensors read.
    gravity : float, optional
        Gravity on the sphere, the centrifugal part included, m/s^2; it falls with the square of the radius.

    Returns
    -------
    ndarray, shape (9,)
        Rates in the order of `CompassState.to_vector`.
    """
    C_h_g = hull_attitude(state.heading, state.trim, state.roll)
    omega_ig_g = geographic_rate(state.lat, state.velocity, state.alt)
    omega_ih_h = hull_rate(reading.rates, reading.mount_angle, reading.mount_rate)
    angles = angle_rates(omega_ih_h - C_h_g.T @ omega_ig_g, state.trim, state.roll)
    earth = EARTH_RATE * np.array([np.cos(state.lat), np.sin(state.lat), 0.0])
    radius = EARTH_RADIUS + state.alt
    weight = np.array([0.0, -checks.positive("gravity", gravity, "m/s^2") * (EARTH_RADIUS / radius) ** 2, 0.0])
    velocity = C_h_g @ reading.specific_force + weight - np.cross(omega_ig_g + earth, state.velocity)
    north, up, east = state.velocity
    return np.array([*angles, *velocity, north / radius, east / (radius * np.cos(state.lat)), up])
