"""Gyro biases by (29)-(31): two long dwells half a turn apart, navigated again and again with what was found.

What the start of the test gets wrong is the point: a constant error of the attitude, times the Earth rate, bends the
velocity alike in both dwells and drops out of (29) and (30). The yaw rate of (31) keeps it.
"""

from dataclasses import dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.calibration.navigation_based import (
    Compensation,
    GyroBiases,
    estimate_gyro_biases,
    gyrocompass_azimuth,
)
from fogkit.earth import earth_rate_n, gravity_n
from fogkit.imu.tables import IMU_COLUMNS
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors
from fogkit.noise.processes import RandomErrors
from fogkit.reproduction.klimkovich import paper
from fogkit.reproduction.klimkovich.estimates import LATITUDE
from fogkit.reproduction.klimkovich.trials import ANGLE_RANDOM_WALK, VELOCITY_RANDOM_WALK
from fogkit.rotation import dcm_from_heading_pitch_roll
from fogkit.stand.rough_table import RoughTable
from fogkit.stand.turn_recordings import record
from fogkit.stand.turn_tests import bias_test
from fogkit.units import DEG, DEG_PER_HOUR

if TYPE_CHECKING:
    from pandas import DataFrame, Series

Array = NDArray[np.float64]

BIAS = (0.03 * DEG_PER_HOUR, -0.05 * DEG_PER_HOUR, 0.02 * DEG_PER_HOUR)
"""Biases of the example, rad/s; the paper's are in its lost figure 6."""

RATE = 10.0
"""Samples per second: the test has one slow turn."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BiasTrial:
    """A recording of the bias test by a unit without other errors.

    Parameters
    ----------
    bias : array_like, shape (3,), optional
        Of the gyros, rad/s.
    tilt : array_like, shape (3,), optional
        Rotation vector in n, rad, from the attitude that the navigation starts from to the true one, about east, north
        and up.
    dwell : float, optional
        T, s.
    noisy : bool, optional
        Whether the sensors have random walks.
    seed : int, optional
        Of the noise.
    """

    bias: ArrayLike = BIAS
    tilt: ArrayLike = (0.0, 0.0, 0.0)
    dwell: float = paper.BIAS_TEST_DWELL
    noisy: bool = False
    seed: int = 1

    @cached_property
    def recording(self) -> "DataFrame":
        """Raw increments."""
        walks = (ANGLE_RANDOM_WALK, VELOCITY_RANDOM_WALK) if self.noisy else (0.0, 0.0)
        unit = MeasurementUnit(
            gyros=Sensors(
                triad=LinearTriad(bias=checks.finite_array("bias", self.bias, shape=(3,))),
                random=RandomErrors(angle_random_walk=walks[0]),
            ),
            accelerometers=Sensors(random=RandomErrors(angle_random_walk=walks[1])),
        )
        east, north, up = checks.finite_array("tilt", self.tilt, shape=(3,))
        table = RoughTable(latitude=LATITUDE, level_east=east, level_north=north, azimuth_error=up)
        motions = table.motions([bias_test(self.dwell)])
        return record(unit, motions, RATE, rng=np.random.default_rng(self.seed))[0]


def estimate(trial: BiasTrial, iterations: int = 1, **options) -> GyroBiases:
    """Biases by (29)-(31) from the attitude of the plan.

    Parameters
    ----------
    trial : BiasTrial
        Recording.
    iterations : int, optional
        Number of iterations.
    **options
        Of `fogkit.calibration.navigation_based.estimate_gyro_biases`.
    """
    options = {"method": "slopes", "initial_attitude": "model"} | options
    return estimate_gyro_biases(
        trial.recording, bias_test(trial.dwell), Compensation(), LATITUDE, iterations=iterations, **options
    )


def figure_6(trial: BiasTrial | None = None, iterations: int = 6, **options) -> "DataFrame":
    """Estimates of the gyro biases by iteration, deg/h.

    Returns
    -------
    DataFrame
        Index: iteration. Columns "x", "y", "z": the bias found so far; "left_x" to "left_z": its error.
    """
    import pandas as pd

    trial = trial or BiasTrial()
    found = estimate(trial, iterations, **options).log[["b_g_1", "b_g_2", "b_g_3"]].to_numpy()
    columns = ["x", "y", "z", "left_x", "left_y", "left_z"]
    index = pd.RangeIndex(1, iterations + 1, name="iteration")
    return pd.DataFrame(np.hstack([found, found - np.array(trial.bias)]) / DEG_PER_HOUR, index=index, columns=columns)


@cache
def effect_of_start(axis: int, angle: float = 1e-3) -> Array:
    """What a start that is wrong by `angle` about east (0), north (1) or up (2) does to one estimate, rad/s."""
    changes = [estimate(BiasTrial(tilt=tilt)).bias for tilt in (angle * np.eye(3)[axis], np.zeros(3))]
    return changes[0] - changes[1]


def azimuths(
    bias_left: ArrayLike = (0.0, 0.0, 0.0), seed: int = 1, duration: float = paper.GYROCOMPASSING_TIME
) -> "Series":
    """Table 2 by simulation: set azimuth less found, the mean taken off, by gyros calibrated but for a bias.

    Parameters
    ----------
    bias_left : array_like, shape (3,), optional
        rad/s.
    seed : int, optional
        Of the noise, `ANGLE_RANDOM_WALK` and `VELOCITY_RANDOM_WALK`.
    duration : float, optional
        s.

    Returns
    -------
    pandas.Series
        Azimuth, deg, to difference, deg.
    """
    import pandas as pd

    rng, found = np.random.default_rng(seed), {}
    gyros = Sensors(triad=LinearTriad(bias=bias_left), random=RandomErrors(angle_random_walk=ANGLE_RANDOM_WALK))
    accelerometers = Sensors(random=RandomErrors(angle_random_walk=VELOCITY_RANDOM_WALK))
    index = pd.Index(np.arange(round(duration * RATE)) / RATE, name="time")
    for angle in paper.TABLE_2:
        C_n_b = dcm_from_heading_pitch_roll(angle * DEG, 0.0, 0.0).T
        still = np.ones((len(index), 1))
        rates = gyros.readings(still * (C_n_b @ earth_rate_n(LATITUDE)), 1 / RATE, rng)
        forces = accelerometers.readings(still * (C_n_b @ -gravity_n(LATITUDE)), 1 / RATE, rng)
        table = pd.DataFrame(np.hstack([rates, forces]) / RATE, index=index, columns=list(IMU_COLUMNS))
        heading = gyrocompass_azimuth(table, Compensation(), LATITUDE).heading / DEG
        found[angle] = (angle - heading + 180) % 360 - 180
    series = pd.Series(found, name="difference_deg").rename_axis("azimuth_deg")
    return series - series.mean()


def bias_of_table_2(lat: float = LATITUDE) -> float:
    """East gyro error, rad/s, whose azimuth error is the printed deviation of table 2; the latitude is not given."""
    return paper.TABLE_2_DEVIATION * DEG * float(earth_rate_n(lat)[1])
