"""Figures 2 to 5 by simulation: how the iteration converges, with which matrix, and to what.

At the true parameters the change of slope is what the noise and the error of the start make, whatever the measurement
matrix is. So two matrices that both converge do so to the same result, up to how they share out what no parameter
explains; the matrix decides how fast, and whether.
"""

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit.calibration.navigation_based import Compensation, NavigationCalibration, differences
from fogkit.imu.size_effect import SizeEffect
from fogkit.navigation import State, integrate
from fogkit.reproduction.klimkovich.estimates import LATITUDE
from fogkit.reproduction.klimkovich.trials import MATRICES, Trial, largest
from fogkit.rotation import rotvec_from_dcm

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

LONG = 15
"""Iterations after which what has not converged is not about to."""

SETTLED = 1.1
"""Factor of the last value at which a quantity counts as having reached its floor."""


@cache
def standard_trial(*, noisy: bool = False, seed: int = 1, roughness: float = 1.0) -> Trial:
    """Trial that several rows and chapters share."""
    return Trial(noisy=noisy, seed=seed, roughness=roughness)


@cache
def standard_calibration(
    matrix: str = "actual", attitude: str = "model", *, noisy: bool = False, seed: int = 1, roughness: float = 1.0
) -> NavigationCalibration:
    """Calibration of `standard_trial` after `LONG` iterations."""
    trial = standard_trial(noisy=noisy, seed=seed, roughness=roughness)
    return trial.calibrated(matrix, attitude=attitude, iterations=LONG)


def history(trial: Trial, matrix: str = "actual", *, attitude: str = "model", iterations: int = 12) -> "DataFrame":
    """Figures 4 and 5 with the true errors beside them.

    Parameters
    ----------
    trial : Trial
        Recordings.
    matrix, attitude : str, optional
        As in `Trial.calibrated`.
    iterations : int, optional
        Rows.

    Returns
    -------
    DataFrame
        Index: iteration. Columns of `NavigationCalibration.log`, and the true errors after the iteration, as `largest`
        gives them.

    Raises
    ------
    RuntimeError
        If the iteration diverges within one step. Over more steps it shows in the rows.
    """
    import pandas as pd

    rows, compensation = [], Compensation()
    for _ in range(iterations):
        found = trial.calibrated(matrix, attitude=attitude, iterations=1, start=compensation)
        compensation = found.compensation
        rows.append(found.log.iloc[0].to_dict() | trial.errors(compensation))
    return pd.DataFrame(rows, index=pd.RangeIndex(1, len(rows) + 1, name="iteration"))


def iterations_to_floor(log: "DataFrame", quantity: str = "rms_z") -> int:
    """First iteration at which a quantity is within `SETTLED` of its last value, for good."""
    settled = (log[quantity] <= SETTLED * log[quantity].iloc[-1]).to_numpy()
    return int(log.index[len(settled) - int(np.argmin(settled[::-1])) if not settled.all() else 0])


def compare_matrices(trial: Trial, *, attitude: str = "model", iterations: int = LONG) -> "DataFrame":
    """Each matrix on the same recordings: how fast, to which floor, with which true errors.

    Parameters
    ----------
    trial : Trial
        Recordings.
    attitude : str, optional
        As in `Trial.calibrated`.
    iterations : int, optional
        Number of iterations.

    Returns
    -------
    DataFrame
        Index: matrix, one of `MATRICES`. Columns: "iterations" to the floor, "rms_z" at the end, m/s^2, and the true
        errors. NaN for a matrix with which the iteration diverges.
    """
    import pandas as pd

    rows = {}
    for matrix in MATRICES:
        try:
            found = trial.calibrated(matrix, attitude=attitude, iterations=iterations)
        except RuntimeError:
            rows[matrix] = {"iterations": np.nan}
            continue
        ends = {"iterations": iterations_to_floor(found.log), "rms_z": found.log["rms_z"].iloc[-1]}
        rows[matrix] = ends | trial.errors(found.compensation)
    table = pd.DataFrame.from_dict(rows, orient="index")
    return table.rename_axis("matrix")


def disagreement(one: NavigationCalibration, other: NavigationCalibration) -> dict[str, float]:
    """Largest differences of two calibrations of the same unit, without a common rotation: see `largest`."""
    return largest(differences(one.compensation, other.compensation))


def errors_of_turns(trial: Trial, attitude: str = "model") -> Array:
    """How the computed turns of all tests approach the true ones.

    Returns
    -------
    ndarray, shape (2,)
        Largest angle, rad, between the computed and the true rotation from the end of the first to the beginning of
        the second dwell: in the first iteration, and in the fourth.
    """
    times = [(test.dwells[0][1], test.dwells[1][0]) for test in trial.plan]
    named = trial.C_case_b
    true = [
        named @ m.C_b_n(begin).T @ m.C_b_n(end) @ named.T for m, (begin, end) in zip(trial.motions, times, strict=True)
    ]
    found = []
    for iterations in (1, 4):
        attitudes = trial.calibrated(attitude=attitude, iterations=iterations).attitudes
        turns = np.swapaxes(attitudes[:, 0], -1, -2) @ attitudes[:, 1]
        found.append(np.linalg.norm(rotvec_from_dcm(np.swapaxes(np.stack(true), -1, -2) @ turns), axis=-1).max())
    return np.array(found)


# Figures 2 and 3


def velocities(trial: Trial, compensation: Compensation | None = None, test: int = 0) -> "DataFrame":
    """Level velocity computed in a test from the model start, set to zero at the end of the turn.

    Parameters
    ----------
    trial : Trial
        Recordings.
    compensation : Compensation, optional
        Parameters of the iteration; none, as in the first, if not given.
    test : int, optional
        Number of the test, from 0.

    Returns
    -------
    DataFrame
        Index: time, s. Columns "east" and "north", m/s.
    """
    commanded = trial.plan[test]
    run = integrate(
        (compensation or Compensation()).apply(trial.recordings[test]),
        State(lat=LATITUDE, C_b_n=commanded.C_b_n),
        position_fixed=True,
        velocity_reset=[commanded.dwells[1][0]],
    )
    import pandas as pd

    return pd.DataFrame(run.v_eb_n[:, :2], index=pd.Index(run.time, name="time"), columns=["east", "north"])


def figures_2_and_3(trial: Trial, iteration: int = 8) -> "dict[int, DataFrame]":
    """Velocities in the first test in the first and in a later iteration."""
    found = trial.calibrated(iterations=iteration - 1)
    return {1: velocities(trial), iteration: velocities(trial, found.compensation)}


def slopes(table: "DataFrame", trial: Trial, test: int = 0) -> Array:
    """Slopes of `velocities` in both dwells, m/s^2, shape (2, 2): dwell, then east and north."""
    found = []
    for begin, end in trial.plan[test].dwells:
        inside = table.loc[begin + 1e-9 : end + 1e-9]  # not the sample at which a dwell begins: it ends a step before
        found.append(np.polyfit(inside.index, inside.to_numpy(), 1)[0])
    return np.array(found)


@cache
def oscillations(iteration: int = 8) -> dict[str, float]:
    """What makes the velocity oscillate in the turn of test 1: excursions, m/s, after calibration.

    Returns
    -------
    dict
        Of a unit in the axis of the turn with sensors in one point; with accelerometers 2 cm apart; with sensors late
        by 5 ms; and of the first, but 5 cm off the axis.
    """
    still = {"offset": (0.0, 0.0, 0.0)}
    centres = np.random.default_rng(5).normal(0, 0.02, (3, 3))
    trials = {
        "none": Trial(table=still),
        "size effect": Trial(table=still, size_effect=SizeEffect.one_point(centres)),
        "delays": Trial(table=still, accelerometer_delay=(5e-3,) * 3),
        "off the axis": Trial(),
    }
    return {name: oscillation(figures_2_and_3(trial, iteration)[iteration], trial) for name, trial in trials.items()}


def oscillation(table: "DataFrame", trial: Trial, test: int = 0) -> float:
    """Largest excursion, m/s, of `velocities` in the turn from the line of the first dwell."""
    (_, begin), (end, _) = trial.plan[test].dwells
    before = table.loc[1e-9 : begin + 1e-9]
    turning = table.loc[begin + 1e-9 : end - 1e-9]
    line = np.polynomial.polynomial.polyfit(before.index, before.to_numpy(), 1)
    expected = np.polynomial.polynomial.polyval(turning.index.to_numpy(), line).T
    return float(np.abs(turning.to_numpy() - expected).max())
