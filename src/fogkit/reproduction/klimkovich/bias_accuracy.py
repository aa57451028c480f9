"""How well (29)-(31) know a gyro bias, and what table 2 says of the gyros: closed forms and simulations.

(29) and (30) take the bend of a parabola through the velocity, which is the angle's integral times gravity; (31) the
slope of a line through the heading. Both weigh a dwell of length T unevenly: of angle random walk N their variances in
one dwell are ``10/7`` and ``6/5`` of the ``N^2 / T`` of a mean rate, and velocity random walk K adds
``120/7 K^2 / (g^2 T^3)`` to the first. The half difference, or half sum, of two dwells has half of that.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.calibration.navigation_based import Compensation, gyrocompass_azimuth
from fogkit.earth import earth_rate_n, gravity_n, normal_gravity, radius_transverse
from fogkit.imu.tables import IMU_COLUMNS
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import Sensors
from fogkit.noise.processes import RandomErrors
from fogkit.reproduction.klimkovich import paper
from fogkit.reproduction.klimkovich.estimates import LATITUDE
from fogkit.reproduction.klimkovich.gyro_bias_test import RATE, BiasTrial, estimate
from fogkit.reproduction.klimkovich.trials import ANGLE_RANDOM_WALK, VELOCITY_RANDOM_WALK
from fogkit.rotation import dcm_from_heading_pitch_roll
from fogkit.units import DEG

if TYPE_CHECKING:
    from pandas import DataFrame, Series
    from sympy import Expr

Array = NDArray[np.float64]


@cache
def factors() -> dict[str, Expr]:
    """Factors of ``N^2/T``, ``K^2/(g^2 T^3)`` and ``N^2/T`` in one dwell, from the least squares in continuous time.

    Returns
    -------
    dict
        "bend, angle random walk", "bend, velocity random walk", "slope, angle random walk".

    Notes
    -----
    A bend or slope is the integral of a weight w times the velocity or heading. Integrated by parts, it is that of the
    repeated integral of w times the white noise; the ends drop out since w is orthogonal to what is fitted besides.
    """
    import sympy as sp

    t, s = sp.symbols("t s", positive=True)

    def weight(degree: int, derivative: int) -> Expr:  # in a dwell of length 1
        gram = sp.Matrix(degree + 1, degree + 1, lambda i, j: sp.Rational(1, i + j + 1))
        row = gram.inv()[derivative, :] * sp.factorial(derivative)
        return sum(row[i] * t**i for i in range(degree + 1))

    def integral(w: Expr) -> Expr:
        return sp.expand(sp.integrate(w.subs(t, s), (s, 0, t)))

    once = integral(weight(2, 2))
    square = {
        "bend, angle random walk": integral(once),
        "bend, velocity random walk": once,
        "slope, angle random walk": integral(weight(1, 1)),
    }
    return {name: sp.integrate(sp.expand(w**2), (t, 0, 1)) for name, w in square.items()}


def deviations(
    dwell: ArrayLike,
    angle_random_walk: float = ANGLE_RANDOM_WALK,
    velocity_random_walk: float = VELOCITY_RANDOM_WALK,
) -> dict[str, Array]:
    """Standard deviations of gyro biases by two dwells, rad/s.

    Parameters
    ----------
    dwell : array_like, shape (...,)
        T, s.
    angle_random_walk, velocity_random_walk : float, optional
        rad/sqrt(s) and m/s/sqrt(s).

    Returns
    -------
    dict
        "level" by (29), (30); "vertical" by (31); "mean rate", the least that any method can have.
    """
    T = np.asarray(dwell, dtype=float)
    angle = angle_random_walk**2 / T
    f = {name: float(value) for name, value in factors().items()}
    felt = velocity_random_walk / float(normal_gravity(LATITUDE))
    bend = f["bend, angle random walk"] * angle + f["bend, velocity random walk"] * felt**2 / T**3
    slope = f["slope, angle random walk"] * angle
    return {name: np.sqrt(v / 2) for name, v in (("level", bend), ("vertical", slope), ("mean rate", angle))}


def scatter(dwell: float, runs: int = 50, *, method: str = "slopes") -> Array:
    """Errors of the estimates over runs with noise, from the true attitude: shape (runs, 3), rad/s.

    Parameters
    ----------
    dwell : float
        T, s.
    runs : int, optional
        Number of them; the seeds.
    method : {"slopes", "rates"}, optional
        As of `fogkit.calibration.navigation_based.estimate_gyro_biases`.
    """
    trials = (BiasTrial(dwell=dwell, noisy=True, seed=seed) for seed in range(runs))
    return np.array([estimate(trial, 2, method=method).bias - trial.bias for trial in trials])


def yaw_rate_of_tilt(tilt: ArrayLike, dwell: float = paper.BIAS_TEST_DWELL, lat: float = LATITUDE) -> float:
    """What a start that is tilted adds to the vertical bias by (31), rad/s, to first order.

    Parameters
    ----------
    tilt : array_like, shape (2,)
        Rotation from the attitude that the navigation starts from to the true one, about east and north, rad.
    dwell : float, optional
        T, s.
    lat : float, optional
        Latitude, rad.

    Notes
    -----
    ``-Omega cos(lat) tilt_east``: part of the Earth's level rate appears as vertical. ``g tilt_north tan(lat) T / (2
    R)``: the east velocity that the tilt makes turns the navigation's north.
    """
    east, north = checks.finite_array("tilt", tilt, shape=(2,))
    transport = float(normal_gravity(lat)) * dwell / 2 * np.tan(lat) / float(radius_transverse(lat))
    return float(-earth_rate_n(lat)[1] * east + transport * north)


# Table 2


@dataclass(frozen=True)
class Harmonics:
    """Azimuth errors as a mean, a part that goes round once with the azimuth, and the rest.

    Attributes
    ----------
    mean, cosine, sine : float
        Deg.
    rest : float
        Standard deviation of the rest, deg, with the degrees of freedom that are left.
    p_value : float
        Probability that noise alone makes so large a once-round part.
    """

    mean: float
    cosine: float
    sine: float
    rest: float
    p_value: float

    @property
    def amplitude(self) -> float:
        """Of the part that goes round, deg."""
        return float(np.hypot(self.cosine, self.sine))


def harmonics(errors: Series | dict[int, float] = paper.TABLE_2) -> Harmonics:
    """What a bias of the level gyros, fixed in the unit, would do to table 2: fit it.

    Parameters
    ----------
    errors : mapping of azimuth, deg, to error, deg
        Equally spaced azimuths.
    """
    from scipy import stats

    azimuth = np.array(list(errors.keys())) * DEG
    values = np.array([errors[key] for key in errors.keys()], dtype=float)
    A = np.stack([np.ones_like(azimuth), np.cos(azimuth), np.sin(azimuth)], axis=-1)
    x = np.linalg.lstsq(A, values, rcond=None)[0]
    freedom = len(values) - 3
    rest = float(np.sum((values - A @ x) ** 2) / freedom)
    ratio = len(values) * (x[1] ** 2 + x[2] ** 2) / 4 / rest
    return Harmonics(*map(float, x), np.sqrt(rest), float(stats.f.sf(ratio, 2, freedom)))


def walk_of_table_2(confidence: float = 0.95, lat: float = LATITUDE) -> tuple[float, float, float]:
    """Angle random walk, rad/sqrt(s), that would make table 2 all by itself, and its confidence interval.

    Parameters
    ----------
    confidence : float, optional
        Probability.
    lat : float, optional
        Latitude, rad, which the paper does not give.
    """
    from scipy import stats

    errors = np.array(list(paper.TABLE_2.values())) * DEG
    freedom = len(errors) - 1  # the mean was taken off
    squares = float(np.sum((errors - errors.mean()) ** 2))
    tails = stats.chi2.ppf([(1 + confidence) / 2, (1 - confidence) / 2], freedom)
    variances = squares / np.array([freedom, *tails])
    found = np.sqrt(variances * paper.GYROCOMPASSING_TIME) * earth_rate_n(lat)[1]
    return tuple(float(walk) for walk in found)


def table_2(
    angle_random_walk: float,
    *,
    bias_b: ArrayLike = (0.0, 0.0, 0.0),
    bias_n: ArrayLike = (0.0, 0.0, 0.0),
    table_error: float = 0.0,
    seed: int = 1,
) -> DataFrame:
    """Table 2 by simulation: a level unit at rest in eight headings, gyrocompassing in each.

    Parameters
    ----------
    angle_random_walk : float
        Of the gyros, rad/sqrt(s).
    bias_b : array_like, shape (3,), optional
        Biases left in the unit, rad/s.
    bias_n : array_like, shape (3,), optional
        Rate errors that stay in space while the unit turns, east, north, up, rad/s: of magnetic sensitivity, or of a
        wrong latitude.
    table_error : float, optional
        Standard deviation of the set angles, rad.
    seed : int, optional
        Of the noise and of the table.

    Returns
    -------
    DataFrame
        Index: set azimuth, deg. Columns, deg: "error", set less found; "difference", the same less its mean, as in the
        print; "deviation" that the noise of the recording predicts.
    """
    import pandas as pd

    rng = np.random.default_rng(seed)
    gyros = Sensors(
        triad=LinearTriad(bias=checks.finite_array("bias_b", bias_b, shape=(3,))),
        random=RandomErrors(angle_random_walk=angle_random_walk),
    )
    accelerometers = Sensors(random=RandomErrors(angle_random_walk=VELOCITY_RANDOM_WALK))
    time = pd.Index(np.arange(round(paper.GYROCOMPASSING_TIME * RATE)) / RATE, name="time")
    felt_n = earth_rate_n(LATITUDE) + checks.finite_array("bias_n", bias_n, shape=(3,))
    rows = {}
    for azimuth in paper.TABLE_2:
        C_n_b = dcm_from_heading_pitch_roll(azimuth * DEG + table_error * rng.standard_normal(), 0.0, 0.0).T
        still = np.ones((len(time), 1))
        rates = gyros.readings(still * (C_n_b @ felt_n), 1 / RATE, rng)
        forces = accelerometers.readings(still * (C_n_b @ -gravity_n(LATITUDE)), 1 / RATE, rng)
        recording = pd.DataFrame(np.hstack([rates, forces]) / RATE, index=time, columns=list(IMU_COLUMNS))
        found = gyrocompass_azimuth(recording, Compensation(), LATITUDE, angle_random_walk=angle_random_walk)
        error = (azimuth - found.heading / DEG + 180) % 360 - 180
        rows[azimuth] = {"error": error, "deviation": found.standard_deviation / DEG}
    table = pd.DataFrame.from_dict(rows, orient="index").rename_axis("azimuth")
    table.insert(1, "difference", table["error"] - table["error"].mean())
    return table
