"""Which axes are the calibrated ones, and how they are brought to those of the table.

The calibration leaves a rotation common to both triads open; the paper fixes it by zeros in the accelerometer matrix
(`compensation.GAUGE`), so the axes are those of the accelerometers, as far as these are orthogonal. At the end the
paper ties the matrices to the axes of rotation of the table, in words only. Two readings of that are here.

``"turns"``: the axes about which the unit did turn, from the gyros, shall be those of the plan, in the mean of all
tests. Level and north are not needed; what remains is how far the axes of the tests are apart, the table's own errors.

``"attitude"``: the unit shall stand in the first dwell of the first test as the plan says, by level and by the heading
of the start attitude: the table's zero position defines the axes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.calibration.navigation_based.compensation import Compensation
from fogkit.calibration.navigation_based.processing import levelled
from fogkit.calibration.navigation_based.recordings import Recording, checked_plan, recordings_of
from fogkit.results import FrozenArrays
from fogkit.rotation import orthonormalise
from fogkit.stand.turn_tests import TurnTest

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Alignment(FrozenArrays):
    """Calibration in the axes of the table.

    Attributes
    ----------
    compensation : Compensation
        Matrices and biases in the new axes.
    C_b_table : ndarray, shape (3, 3)
        Takes components in the axes of the calibration to the new ones.
    residuals : ndarray, shape (k,)
        Angle that is left between direction and plan, rad: of the axis of each test, or of the one attitude, which
        leaves none.
    """

    compensation: Compensation
    C_b_table: Array
    residuals: Array


def align_to_table(
    compensation: Compensation,
    recordings: Sequence["DataFrame"],
    plan: Sequence[TurnTest],
    *,
    by: str = "turns",
    initial_attitude: ArrayLike | None = None,
    dwells: str = "plan",
) -> Alignment:
    """Calibration turned, both triads alike, to the axes of the table.

    Parameters
    ----------
    compensation : Compensation
        As calibrated.
    recordings, plan, dwells
        As for `calibrate`.
    by : {"turns", "attitude"}, optional
        See above.
    initial_attitude : array_like, shape (3, 3), optional
        For ``by="attitude"``: attitude in the first dwell of the first test, by default the plan's turned level.

    Returns
    -------
    Alignment

    Raises
    ------
    ValueError
        If all tests turn about one axis, or the recordings are not those of the plan.
    """
    compensation = checks.instance("compensation", compensation, Compensation)
    plan = checked_plan(plan)
    prepared = recordings_of(recordings, plan, dwells=dwells)
    if checks.option("by", by, ("turns", "attitude")) == "attitude":
        C_b_table, residuals = _by_attitude(compensation, prepared[0], initial_attitude), np.zeros(1)
    else:
        C_b_table, residuals = _by_turns(compensation, prepared, plan)
    return Alignment(compensation=compensation.turned(C_b_table), C_b_table=C_b_table, residuals=residuals)


def turn_axes(compensation: Compensation, recordings: Sequence[Recording]) -> Array:
    """Mean direction in the unit about which each test turned, shape (tests, 3).

    The Earth rotation is in it: about a level axis by its component along that axis alone; the rest turns
    round and round in the unit: 1e-3 rad in 15 s, against 33 rad of a test.
    """
    sums = np.stack([recording.turned for recording in recordings]) @ compensation.gyro_matrix.T
    times = np.array([(r.dwells[1][0] - r.dwells[0][1]) * r.dt for r in recordings])
    sums = sums + times[:, np.newaxis] * compensation.gyro_bias
    return sums / np.linalg.norm(sums, axis=1, keepdims=True)


def _by_turns(
    compensation: Compensation, recordings: Sequence[Recording], plan: Sequence[TurnTest]
) -> tuple[Array, Array]:
    planned = np.stack([test.axis * np.sign(test.angle) for test in plan])
    if np.linalg.matrix_rank(planned, tol=1e-3) < 2:
        raise ValueError("`plan` must turn about at least two axes to fix three angles, got one")
    turned = turn_axes(compensation, recordings)
    # least squares over rotations: C that makes the sum of planned . C turned largest
    C = orthonormalise(_completed(planned.T @ turned))
    return C, np.linalg.norm(np.cross(planned, turned @ C.T), axis=1)


def _completed(B: Array) -> Array:
    """Matrix of rank two made regular without a change to the rotation nearest to it."""
    left, values, right = np.linalg.svd(B)
    values[2] = max(values[2], 1e-3 * values[0]) * np.sign(np.linalg.det(left) * np.linalg.det(right))
    return left @ np.diag(values) @ right


def _by_attitude(compensation: Compensation, recording: Recording, attitude: ArrayLike | None) -> Array:
    force = compensation.accelerometer_matrix @ recording.forces[0] + compensation.accelerometer_bias
    planned = recording.test.C_b_n
    actual = levelled(planned, force) if attitude is None else checks.rotation_matrix("initial_attitude", attitude)
    return planned.T @ actual
