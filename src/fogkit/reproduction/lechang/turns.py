"""Equations (3)-(7) and (9)-(12) of the thesis against turns of attitudes: no formula of the print is used here.

A hull that turns in all angles on a vessel that moves over the sphere, with a mount that turns on the hull, has an
attitude in inertial space at any time. Rates are the turn over a short time, by rotation vectors; the equations have to
give them.
"""

from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass import error_model, frames, mechanisation
from fogkit.gyrocompass.mechanisation import EARTH_RADIUS, CompassState, Reading

STEP = 1e-3
"""Half of the time over which rates are taken, s: they are then right to about 1e-8 of the largest."""

_ANGLES = np.array([[0.9, 0.02, 3e-3], [0.2, -0.03, 2e-3], [-0.3, 0.05, -1e-3], [0.4, 0.2, 5e-3]])  # K, theta, gamma, b
_PLACE = np.array([[0.7, 3e-6], [0.3, -5e-6]])  # latitude and longitude, rad; some 20 m/s north and west
TOLERANCE = 1e-6
"""Of the largest rate of a kind: differences over `STEP` and rounding of attitudes to 1e-16 leave 1e-8 to 1e-7."""


def _polynomials(coefficients: np.ndarray, t: float) -> np.ndarray:
    return coefficients @ t ** np.arange(coefficients.shape[1])


def geographic_attitude(lat: float, lon: float) -> np.ndarray:
    """North, up, east as columns, in axes of which the third is the Earth's, from latitude and inertial longitude."""
    up = np.array([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)])
    east = np.array([-np.sin(lon), np.cos(lon), 0.0])
    return np.column_stack([np.cross(up, east), up, east])


def _attitudes(t: float) -> dict[str, np.ndarray]:
    """Attitudes at a time: geographic, hull and gyros against inertial axes, hull against geographic."""
    lat, lon = _polynomials(_PLACE, t)
    heading, trim, roll, mount = _polynomials(_ANGLES, t)
    C_g_i = geographic_attitude(lat, lon + EARTH_RATE * t)
    C_h_g = frames.hull_attitude(heading, trim, roll)
    C_h_i = C_g_i @ C_h_g
    gyros = C_h_i @ frames.mount_attitude(mount) @ frames.pyramid_axes()
    return {"geographic": C_g_i, "hull": C_h_i, "gyros": gyros, "relative": C_h_g}


@cache
def rates_by_turns(t: float = 1.0) -> dict[str, np.ndarray]:
    """Rates of the attitudes of `_attitudes`, each in its own axes, rad/s, as turns over twice `STEP`."""
    before, after = _attitudes(t - STEP), _attitudes(t + STEP)
    return {name: Rotation.from_matrix(before[name].T @ after[name]).as_rotvec() / (2 * STEP) for name in before}


def departures() -> dict[str, float]:
    """Departures of (3)-(6) from `rates_by_turns`, over the largest rate of the kind.

    Returns
    -------
    dict of float
        ``eq03`` hull from gyros and mount, ``eq04`` relative rate, ``eq05`` geographic rate, ``eq06`` rates of angles.
    """
    t, turned = 1.0, rates_by_turns()
    place, place_rate = _polynomials(_PLACE, t), _PLACE[:, 1]
    slopes = _ANGLES[:, 1] + 2 * _ANGLES[:, 2] * t
    heading, trim, roll, mount = _polynomials(_ANGLES, t)
    velocity = EARTH_RADIUS * np.array([place_rate[0], 0.0, np.cos(place[0]) * place_rate[1]])
    geographic = mechanisation.geographic_rate(place[0], velocity)
    hull = mechanisation.hull_rate(turned["gyros"], mount, slopes[3])
    relative = turned["hull"] - frames.hull_attitude(heading, trim, roll).T @ geographic
    angles = mechanisation.angle_rates(turned["relative"], trim, roll)
    pairs = {
        "eq03": (hull, turned["hull"]),
        "eq04": (relative, turned["relative"]),
        "eq05": (geographic, turned["geographic"]),
        "eq06": (angles, slopes[:3]),
    }
    return {name: float(np.abs(a - b).max() / np.abs(b).max()) for name, (a, b) in pairs.items()}


def follows(name: str) -> bool:
    """Whether one of (3)-(6) gives the rates of turns to `TOLERANCE`."""
    return departures()[name] < TOLERANCE


def angles_by_integration(duration: float = 10.0, steps: int = 10) -> float:
    """Largest departure, rad, of the angles from (7), Simpson's rule of the rates (6), after a time."""
    angles = _polynomials(_ANGLES, 0.0)[:3]
    start, end = angles.copy(), _polynomials(_ANGLES, duration)[:3]
    weights = np.ones(2 * steps + 1)
    weights[1:-1:2], weights[2:-1:2] = 4, 2
    total = np.zeros(3)
    for weight, t in zip(weights, np.linspace(0, duration, 2 * steps + 1), strict=True):
        _, trim, roll, _ = _polynomials(_ANGLES, t)
        total += weight * mechanisation.angle_rates(rates_by_turns(float(t))["relative"], trim, roll)
    return float(np.abs(start + total * duration / (6 * steps) - end).max())


def _point() -> tuple[CompassState, Reading]:
    """A state and readings where every term of the error model is at work."""
    state = CompassState(heading=0.9, trim=0.2, roll=-0.3, velocity=(12.0, 1.0, -20.0), lat=0.8, lon=0.1, alt=100.0)
    return state, Reading(rates=(0.11, -0.2, 0.15), specific_force=(0.4, 9.7, -0.8), mount_angle=0.7, mount_rate=0.2)


@cache
def error_model_departure() -> float:
    """Largest departure of the matrix of (9) from differences of the nonlinear rates, over each column's largest entry.

    Columns of the gyro errors are by changes of the readings: ``(1 + scale factor error) * rate + bias``.
    """
    state, reading = _point()
    x, F, worst = state.to_vector(), error_model.system_matrix(state, reading), 0.0

    def rate(errors: np.ndarray) -> np.ndarray:
        names = ("heading", "trim", "roll")
        at = x + errors[:9]
        moved = CompassState(**dict(zip(names, at[:3], strict=True)), velocity=at[3:6], lat=at[6], lon=at[7], alt=at[8])
        read = np.asarray(reading.rates) * (1 + errors[12:]) + errors[9:12]
        return mechanisation.state_rate(
            moved,
            Reading(
                rates=read,
                specific_force=reading.specific_force,
                mount_angle=reading.mount_angle,
                mount_rate=reading.mount_rate,
            ),
        )

    steps = [1e-4] * 3 + [1.0] * 3 + [1e-4, 1e-4, 100.0] + [1e-4] * 6
    for column, step in enumerate(steps):
        e = np.zeros(15)
        e[column] = step
        # fourth order: the step may be long enough for rounding to be small
        near, far = rate(e) - rate(-e), rate(2 * e) - rate(-2 * e)
        difference = (8 * near - far) / (12 * step)
        largest = np.abs(F[:9, column]).max()
        if largest == 0:  # longitude: nothing depends on it
            worst = max(worst, float(np.abs(difference).max()))
        else:
            worst = max(worst, float(np.abs(difference - F[:9, column]).max() / largest))
    return worst


def errors_of_a_gyro_act_alike() -> bool:
    """Whether noise acts like a bias, and a scale factor error like a bias of that times the rate: (8) and (9)."""
    state, reading = _point()
    F = error_model.system_matrix(state, reading)
    G = error_model.noise_input(state.trim, state.roll, reading.mount_angle)
    scaled = np.allclose(F[:, 12:], F[:, 9:12] * np.asarray(reading.rates), rtol=1e-12, atol=1e-15)
    return bool(scaled and np.allclose(G, F[:, 9:12], rtol=1e-12, atol=1e-12))


def measurement_takes_its_states() -> bool:
    """Whether H of (12) takes the velocities and the position of (11) out of the state vector (10), in that order."""
    x = np.arange(1.0, 16.0)
    taken = error_model.measurement_matrix() @ x
    places = [error_model.STATES.index(name) for name in error_model.MEASUREMENTS]
    return bool(np.array_equal(taken, x[places]) and places == list(range(3, 9)))


def rates_near_a_vertical_bow(trim: float) -> float:
    """Ratio of the largest rate of an angle by (6) at a trim, rad, to that of a level hull of the same rate."""
    rate = np.array([0.0, 0.1, 0.1])
    steep, level = (np.abs(mechanisation.angle_rates(rate, at, 0.0)).max() for at in (trim, 0.0))
    return float(steep / level)
