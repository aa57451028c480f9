"""Measurement matrix: how the changes of slope follow from the errors, by rotations, by the plan, or by trial."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fogkit.calibration.navigation_based.compensation import Compensation
from fogkit.calibration.navigation_based.processing import Processed, Processing
from fogkit.calibration.navigation_based.turn_model import MISALIGNED_WITH, PARAMETERS, measurement_rows
from fogkit.stand.turn_tests import TurnTest

Array = NDArray[np.float64]

ACCELEROMETER_SCALE_FACTORS = ("m_a_11", "m_a_22", "m_a_33")
_STEPS = {"m": 1e-6, "b": 1e-5}  # of the differences, pure and m/s^2: the cube of 33 rad times 1e-6 is 4e-14


def actual_matrix(processed: Processed, gravity: float) -> Array:
    """Measurement matrix (14)-(19) from the rotations and readings that were recorded, shape (2 * tests, 15)."""
    C, A = processed.attitudes, processed.forces
    felt = C[..., :2, :] * A[..., np.newaxis, MISALIGNED_WITH]  # tests, dwells, east and north, accelerometers
    misalignments = felt[:, 1] - felt[:, 0]
    Theta = processed.projections
    gyros = gravity * np.stack([Theta[:, 1], -Theta[:, 0]], axis=1).reshape(len(C), 2, 9)
    biases = C[:, 1, :2] - C[:, 0, :2]
    return np.concatenate([misalignments, gyros, biases], axis=-1).reshape(-1, len(PARAMETERS))


def model_matrix(plan: Sequence[TurnTest], gravity: float) -> Array:
    """Measurement matrix of the plan itself: the paper's appendix without its misprints, shape (2 * tests, 15)."""
    C, axis, angle = (np.stack([getattr(test, name) for test in plan]) for name in ("C_b_n", "axis", "angle"))
    return measurement_rows(C, axis, angle, gravity).reshape(-1, len(PARAMETERS))


def finite_difference_matrix(processing: Processing, compensation: Compensation) -> Array:
    """Derivatives of the measured changes of slope by central differences of the whole processing.

    Parameters
    ----------
    processing : Processing
        The recordings, as `fogkit.calibration.navigation_based.prepare` gives them.
    compensation : Compensation
        Where the derivatives are taken.

    Returns
    -------
    ndarray, shape (2 * tests, 15)
        Per unit of the errors `PARAMETERS`. The attitudes at the start are held: what of the start is levelled with
        other parameters would otherwise be in the derivative too.

    Notes
    -----
    Everything is navigated twice for each parameter; nothing of (12) or (14)-(19) is used.
    """
    starts = processing.run(compensation).starts
    columns = []
    for name in PARAMETERS:
        step = _STEPS[name[0]]
        more, less = (processing.run(compensation.with_errors({name: s}), starts).change for s in (step, -step))
        columns.append((more - less) / (2 * step))
    return np.stack(columns, axis=-1)


def magnitude_rows(processed: Processed, gravity: Array) -> tuple[Array, Array]:
    """Rows and values by which the length of the mean specific force in each dwell tells of the accelerometers.

    Parameters
    ----------
    processed : Processed
        Navigated tests.
    gravity : ndarray, shape (3,)
        Gravity in n, m/s^2.

    Returns
    -------
    rows : ndarray, shape (2 * tests, 18)
        Per unit of `PARAMETERS` and `ACCELEROMETER_SCALE_FACTORS`; tests, then dwells.
    values : ndarray, shape (2 * tests,)
        Length of the specific force less gravity, m/s^2. Unlike the slope upwards of (26) it does not depend on the
        attitude, so a wrong start leaves no error of second order.
    """
    length = np.linalg.norm(processed.slopes - gravity, axis=-1).ravel()
    A = processed.forces.reshape(-1, 3)
    along = A / np.linalg.norm(A, axis=-1, keepdims=True)
    rows = np.zeros((len(A), len(PARAMETERS) + 3))
    rows[:, :3] = along * A[:, MISALIGNED_WITH]
    rows[:, 12:15] = along
    rows[:, 15:] = along * A
    return rows, length - np.linalg.norm(gravity)


def scale_factor_columns(processed: Processed) -> Array:
    """Columns of `ACCELEROMETER_SCALE_FACTORS` beside (14): zero where every axis is level or upright."""
    felt = processed.attitudes[..., :2, :] * processed.forces[..., np.newaxis, :]
    return (felt[:, 1] - felt[:, 0]).reshape(-1, 3)


def upended(plan: Sequence[TurnTest]) -> dict[str, list[int]]:
    """Tests, from 0, by whose two dwells (26) gives each accelerometer scale factor: one turns its axis upside down."""
    up = np.stack([np.stack([test.C_b_n[2], test.C_b_n_end[2]]) for test in plan])
    level = 0.99  # cosine: 8 deg off the vertical still upright
    turned = (up[:, 0] * up[:, 1] < 0) & (np.abs(up).min(axis=1) > level)
    return {name: np.flatnonzero(turned[:, p]).tolist() for p, name in enumerate(ACCELEROMETER_SCALE_FACTORS)}
