"""Dwell, turn, dwell: how calibration errors change the slope of the computed velocity, to first order and exactly.

A unit at rest in attitude ``C_b_n`` turns about one of its own axes and rests again. With errors in the calibration the
computed level velocity has a slope in either dwell; the test measures the change. Over so short a time the Earth's
rotation and the gravity of the place do not enter; the frame n is east, north, up.

**Signs.** An error is what the calibration adds: readings are compensated to ``(I + m) x + b`` of the true quantity
``x``, so that the estimate is to be subtracted. A gyro error ``m_g`` turns the computed attitude to
``(I + skew(theta)) C_b_n``, with ``theta`` the integral of ``C_b_n m_g omega`` of eq. (10). The computed specific
force is then tilted by ``theta x (0, 0, g)``: the slopes change by ``+g theta_2`` east and ``-g theta_1`` north, as in
(15) and (18) of the paper. Its (3) and (4) have the opposite signs.

References
----------
.. [1] B. V. Klimkovich, Precise calibration of strapdown INS using low-accuracy turntables, Gyroscopy and Navigation
   (in Russian), vol. 30, no. 4 (119), 2022, pp. 54-70.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.rotation import dcm_from_rotvec, skew

Array = NDArray[np.float64]

MISALIGNED_WITH = (2, 0, 1)
"""The function q of (14), from 0: accelerometer i has an estimated misalignment with axis q(i)."""

PARAMETERS = (
    *("m_a_13", "m_a_21", "m_a_32"),
    *(f"m_g_{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)),
    *("b_a_1", "b_a_2", "b_a_3"),
)
"""The state vector (13) of [1]_: errors of three elements of the accelerometer matrix, of the gyro matrix, row by row,
and of the accelerometer biases. The first index is the sensor."""

FULL_PARAMETERS = (
    *(f"m_a_{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)),
    *(f"m_g_{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)),
    *("b_a_1", "b_a_2", "b_a_3"),
)
"""All errors of the readings that `slope_change` takes: both matrices row by row, accelerometer biases."""

_STEP = 1e-6  # truncation: its square times the cube of the angle, 1e-7 of the largest element; rounding is smaller


def turn_integral(axis: ArrayLike, angle: ArrayLike) -> Array:
    """Integral over the angle of the matrix that turns about an axis, in closed form.

    Parameters
    ----------
    axis : array_like, shape (..., 3)
        Unit vector in body axes.
    angle : array_like, shape (...,)
        Angle of the turn, rad, right-handed.

    Returns
    -------
    ndarray, shape (..., 3, 3)
        Rad.
    """
    e = checks.finite_array("axis", axis, shape=(..., 3))
    angle = np.asarray(angle, dtype=float)[..., np.newaxis, np.newaxis]
    along = e[..., :, np.newaxis] * e[..., np.newaxis, :]
    return angle * along + np.sin(angle) * (np.eye(3) - along) + 2 * np.sin(angle / 2) ** 2 * skew(e)


def angle_projections(C_b_n: ArrayLike, axis: ArrayLike, angle: ArrayLike) -> Array:
    """The sums (12) of [1]_ for a steady turn about a body axis, in the limit of small steps.

    Parameters
    ----------
    C_b_n : array_like, shape (..., 3, 3)
        Attitude before the turn.
    axis : array_like, shape (..., 3)
        Unit vector of the turn in body axes.
    angle : array_like, shape (...,)
        Angle of the turn, rad.

    Returns
    -------
    ndarray, shape (..., 3, 3, 3)
        Element i, k, j, rad: what an error of gyro k in proportion to the angle about axis j turns about n axis i.
    """
    e = checks.finite_array("axis", axis, shape=(..., 3))
    return (np.asarray(C_b_n) @ turn_integral(e, angle))[..., np.newaxis] * e[..., np.newaxis, np.newaxis, :]


def measurement_rows(C_b_n: ArrayLike, axis: ArrayLike, angle: ArrayLike, gravity: float = 1.0) -> Array:
    """The two rows (14)-(19) of [1]_ that one test adds to the measurement matrix.

    Parameters
    ----------
    C_b_n : array_like, shape (..., 3, 3)
        Attitude in the first dwell.
    axis : array_like, shape (..., 3)
        Unit vector of the turn in body axes.
    angle : array_like, shape (...,)
        Angle of the turn, rad.
    gravity : float, optional
        m/s^2. With 1 the rows are those of the appendix as multiples of gravity.

    Returns
    -------
    ndarray, shape (..., 2, 15)
        Change of the slope east, then north, per unit of the errors (13).
    """
    before = np.asarray(C_b_n, dtype=float)
    e = checks.finite_array("axis", axis, shape=(..., 3))
    after = before @ dcm_from_rotvec(e * np.asarray(angle, dtype=float)[..., np.newaxis])

    def misalignments(C):  # what an accelerometer feels along its other axis, C_3q g, taken to the level
        return C[..., :2, :] * (gravity * C[..., 2:, MISALIGNED_WITH])

    Theta = angle_projections(before, e, angle)
    gyros = gravity * np.stack([Theta[..., 1, :, :], -Theta[..., 0, :, :]], axis=-3)
    gyros = gyros.reshape(*gyros.shape[:-2], 9)
    return np.concatenate([misalignments(after) - misalignments(before), gyros, (after - before)[..., :2, :]], axis=-1)


def slope_change(
    C_b_n: ArrayLike,
    axis: ArrayLike,
    angle: float,
    errors: ArrayLike,
    gravity: float = 1.0,
    start: ArrayLike = (0, 0, 0),
) -> Array:
    """Change of the slope of the computed velocity over a test, without any linearisation.

    Parameters
    ----------
    C_b_n : array_like, shape (3, 3)
        True attitude in the first dwell.
    axis : array_like, shape (3,)
        Unit vector of the turn in body axes.
    angle : float
        Angle of the turn, rad.
    errors : array_like, shape (21,)
        Errors in the order of `FULL_PARAMETERS`: pure numbers, biases in m/s^2.
    gravity : float, optional
        m/s^2.
    start : array_like, shape (3,), optional
        Rotation vector in n, rad, by which the attitude given to the navigation is turned from the true one.

    Returns
    -------
    ndarray, shape (2,)
        East and north, m/s^2.

    Notes
    -----
    A turn about a fixed body axis is read as one about another fixed axis, so the computed attitude is exact.
    """
    errors = checks.finite_array("errors", errors, shape=(21,))
    accelerometers, gyros, bias = errors[:9].reshape(3, 3), errors[9:18].reshape(3, 3), errors[18:]
    turn = np.asarray(axis, dtype=float) * angle
    true = [np.asarray(C_b_n, dtype=float), C_b_n @ dcm_from_rotvec(turn)]
    computed = [dcm_from_rotvec(start) @ C_b_n]
    computed.append(computed[0] @ dcm_from_rotvec(turn + gyros @ turn))
    slopes = [
        C @ ((np.eye(3) + accelerometers) @ (C_true[2] * gravity) + bias)
        for C, C_true in zip(computed, true, strict=True)
    ]
    return (slopes[1] - slopes[0])[:2]


def differentiated_rows(C_b_n: ArrayLike, axis: ArrayLike, angle: float, gravity: float = 1.0) -> Array:
    """Derivatives of `slope_change` by central differences: the check of `measurement_rows` by other means.

    Parameters
    ----------
    C_b_n, axis, angle, gravity
        As in `slope_change`.

    Returns
    -------
    ndarray, shape (2, 21)
        Per unit of the errors in the order of `FULL_PARAMETERS`.
    """
    columns = [
        slope_change(C_b_n, axis, angle, step, gravity) - slope_change(C_b_n, axis, angle, -step, gravity)
        for step in _STEP * np.eye(len(FULL_PARAMETERS))
    ]
    return np.stack(columns, axis=-1) / (2 * _STEP)
