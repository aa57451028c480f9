"""Gyro biases by (29)-(31): two long dwells half a turn apart, navigated again and again with what was found.

What the start of the test gets wrong is the point: a constant error of the attitude, times the Earth rate, bends the
velocity alike in both dwells and drops out of (29) and (30). The yaw rate of (31) keeps it.
"""

from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.calibration.navigation_based import Compensation
from fogkit.earth import earth_rate_n
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors
from fogkit.navigation import State, integrate
from fogkit.noise.processes import RandomErrors
from fogkit.reproduction.klimkovich import paper
from fogkit.reproduction.klimkovich.estimates import LATITUDE
from fogkit.reproduction.klimkovich.trials import ANGLE_RANDOM_WALK, GRAVITY, VELOCITY_RANDOM_WALK
from fogkit.stand.rough_table import RoughTable
from fogkit.stand.turn_recordings import record
from fogkit.stand.turn_tests import bias_test
from fogkit.units import DEG, DEG_PER_HOUR

if TYPE_CHECKING:
    from pandas import DataFrame

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


def estimate(recording: "DataFrame", compensation: Compensation, dwell: float = paper.BIAS_TEST_DWELL) -> Array:
    """Errors of the gyro biases by (29)-(31).

    Parameters
    ----------
    recording : DataFrame
        Raw increments of `fogkit.stand.turn_tests.bias_test`.
    compensation : Compensation
        Parameters so far.
    dwell : float, optional
        T, s.

    Returns
    -------
    ndarray, shape (3,)
        rad/s, to be subtracted.
    """
    test = bias_test(dwell)
    run = integrate(
        compensation.apply(recording),
        State(lat=LATITUDE, C_b_n=test.C_b_n),
        position_fixed=True,
        velocity_reset=[test.dwells[1][0]],
    )
    heading = np.unwrap(run.heading_pitch_roll[0])
    second, yaw = [], []
    for begin, end in test.dwells:
        inside = (run.time > begin + 1e-9) & (run.time < end + 1e-9)
        t = run.time[inside] - begin
        second.append(2 * np.polyfit(t, run.v_eb_n[inside, :2], 2)[0])
        yaw.append(np.polyfit(t, heading[inside], 1)[0])
    (east, north), (east_after, north_after) = second
    return np.array(
        [(north_after - north) / (2 * GRAVITY), -(east_after - east) / (2 * GRAVITY), -(yaw[1] + yaw[0]) / 2]
    )


def figure_6(trial: BiasTrial | None = None, iterations: int = 6) -> "DataFrame":
    """Estimates of the gyro biases by iteration, deg/h.

    Returns
    -------
    DataFrame
        Index: iteration. Columns "x", "y", "z": the bias found so far; "left_x" to "left_z": its error.
    """
    import pandas as pd

    trial = trial or BiasTrial()
    recording, compensation, rows = trial.recording(), Compensation(), []
    for _ in range(iterations):
        step = estimate(recording, compensation, trial.dwell)
        compensation = replace(compensation, gyro_bias=compensation.gyro_bias - step)
        found = -compensation.gyro_bias
        rows.append(np.concatenate([found, found - np.array(trial.bias)]) / DEG_PER_HOUR)
    columns = ["x", "y", "z", "left_x", "left_y", "left_z"]
    return pd.DataFrame(rows, index=pd.RangeIndex(1, iterations + 1, name="iteration"), columns=columns)


@cache
def effect_of_start(axis: int, angle: float = 1e-3) -> Array:
    """What a start that is wrong by `angle` about east (0), north (1) or up (2) does to one estimate, rad/s."""
    changes = [
        estimate(BiasTrial(tilt=tilt).recording(), Compensation()) for tilt in (angle * np.eye(3)[axis], np.zeros(3))
    ]
    return changes[0] - changes[1]


def bias_of_table_2(lat: float = LATITUDE) -> float:
    """East gyro error, rad/s, whose azimuth error is the printed deviation of table 2; the latitude is not given."""
    return paper.TABLE_2_DEVIATION * DEG * float(earth_rate_n(lat)[1])

