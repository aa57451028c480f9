"""All data of a bench at once: one weighted least-squares fit over every position and turn, with the table's errors.

The model is the bench itself (`fogkit.stand.bench.expected_readings`): turns need not be whole, since the Earth's
rotation is in it, and the table's geometry may be estimated along, as far as the readings or a prior determine it.
"""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from fogkit.calibration.three_stage import deviations
from fogkit.calibration.triad import PARAMETERS, TriadCalibration, triad_from_parameters
from fogkit.estimation.leastsquares import NUMERIC_RANK_TOLERANCE, linear, nonlinear
from fogkit.estimation.solution import Solution
from fogkit.imu.errors import GyroTriad
from fogkit.stand.bench import BenchRecord, expected_readings
from fogkit.stand.table import GEOMETRY, RateTable
from fogkit.units import ARCMIN, ARCSEC


def fit(
    record: BenchRecord,
    noise: tuple[GyroTriad, RateTable],
    *,
    geometry: Mapping[str, float] | None = None,
) -> Solution:
    """Fit a triad, and errors of the table if wanted, to one run.

    Parameters
    ----------
    record : BenchRecord
        Readings and angles of one run; any positions and turns that determine the parameters.
    noise : tuple of GyroTriad and RateTable
        Noise levels of gyros and table. The triad's scale factors are the starting point, the table's geometry is the
        one believed.
    geometry : mapping of str to float, optional
        Errors of the table to estimate along, names of `fogkit.stand.table.GEOMETRY`, with the standard deviation, rad,
        to which each is known beforehand; ``inf`` for not at all.

    Returns
    -------
    Solution
        Parameters in the order of `PARAMETERS`, then those of `geometry`.

    Raises
    ------
    ValueError
        If the record holds several runs, `geometry` has an unknown name or a deviation that is not above zero, or the
        plan leaves a parameter open; the message names it.
    """
    triad, table = noise
    if record.readings.ndim != 2:
        raise ValueError(f"`record` must hold a single run, got readings of shape {record.readings.shape}")
    geometry = dict(geometry or {})
    if unknown := sorted(set(geometry) - set(GEOMETRY)):
        raise ValueError(f"`geometry` must have names of {GEOMETRY}, got {unknown}")
    for name, deviation in geometry.items():
        if not deviation > 0:
            raise ValueError(f"`geometry` must hold standard deviations above 0, in rad, got {deviation} for {name!r}")
    chosen = [GEOMETRY.index(name) for name in geometry]
    believed = table.geometry

    def residuals(parameters: NDArray) -> NDArray:
        errors = believed.copy()
        errors[chosen] += parameters[len(PARAMETERS) :]
        gyros = triad_from_parameters(parameters[: len(PARAMETERS)])
        model = expected_readings(record.plan, gyros, table.with_geometry(errors) if chosen else table, record.turned)
        return (record.readings - model).ravel()

    scale = np.concatenate([triad.scale_positive, triad.scale_negative])
    start = np.concatenate([np.zeros(3), scale, np.zeros(6 + len(chosen))])
    size = np.concatenate([1e-6 / scale[:3], scale, np.full(6, ARCMIN), np.full(len(chosen), 10 * ARCSEC)])
    known = {
        "covariance": data_covariance(record, noise),
        "prior_standard_deviation": geometry or None,
        "prior_mean": dict.fromkeys(geometry, 0.0) or None,
        "names": (*PARAMETERS, *geometry),
    }
    # a plan that leaves something open would send the search anywhere, to scale factors below zero too
    steps = 1e-4 * np.concatenate([1 / scale[:3], scale, np.ones(6 + len(chosen))])  # cubes 2e-9, rounding 1e-12
    design = _slope(residuals, start, steps)
    first = linear(-design, residuals(start), rank_tolerance=NUMERIC_RANK_TOLERANCE, **known)
    first.raise_if_unobservable("the plan", priors_help=True)
    solution = nonlinear(residuals, start, parameter_scale=size, **known)
    solution.raise_if_unobservable("the plan", priors_help=True)
    return solution


def _slope(function: Callable[[NDArray], NDArray], at: NDArray, steps: NDArray) -> NDArray[np.float64]:
    """Derivative of a vector by central differences, shape (n, p)."""
    moves = np.diag(steps)
    return np.stack([(function(at + move) - function(at - move)) / (2 * move.sum()) for move in moves], axis=-1)


def data_covariance(record: BenchRecord, noise: tuple[GyroTriad, RateTable]) -> NDArray[np.float64]:
    """Covariance of the readings against the model that uses the angles read off the table.

    Parameters
    ----------
    record : BenchRecord
        The record of one run.
    noise : tuple of GyroTriad and RateTable
        Noise levels.

    Returns
    -------
    ndarray, shape (3 n, 3 n)
        Gyro noise on the diagonal, and the error of each angle, which all three gyros of its segment share.
    """
    triad, table = noise
    readings, angles = deviations(record.plan, triad, table)
    n = angles.size
    step = np.maximum(angles, 1e-9)
    model = [expected_readings(record.plan, triad, table, record.turned + sign * step) for sign in (1, -1)]
    slope = (model[0] - model[1]) / (2 * step)[:, None]
    covariance = np.zeros((n, 3, n, 3))
    index = np.arange(n)
    shared = slope * angles[:, None]
    covariance[index, :, index, :] = shared[:, :, None] * shared[:, None, :] + readings[:, :, None] ** 2 * np.eye(3)
    return covariance.reshape(3 * n, 3 * n)


def calibration_of(solution: Solution) -> TriadCalibration:
    """The triad's part of a fit: its 15 parameters with their covariance."""
    p = len(PARAMETERS)
    return TriadCalibration(estimate=solution.estimate[:p].copy(), covariance=solution.covariance[:p, :p].copy())
