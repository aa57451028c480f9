"""Which plan is best? What a plan will give, from the derivative of the bench's model, before anything is measured.

`predict` gives the standard deviations that a fit to a plan's data will have, and which parameters the plan leaves
open; `drift_at_sea` turns a covariance into the drift that remains in a motion of the ship, which makes plans
comparable: a scale factor and an angle have no common unit, the drifts that they cause have one.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.calibration.bench_fit import data_covariance, fit
from fogkit.calibration.triad import PARAMETERS, parameters_of, triad_from_parameters
from fogkit.estimation.leastsquares import NUMERIC_RANK_TOLERANCE, linear
from fogkit.estimation.solution import Solution
from fogkit.imu.constructions import Construction
from fogkit.imu.errors import GyroTriad, misalignment_matrix
from fogkit.stand import bench, plans
from fogkit.stand.plans import Plan
from fogkit.stand.table import GEOMETRY, RateTable

STEP = 1e-4
"""Step of the central differences, rad or relative; third derivatives leave 2e-9 of the result, rounding 1e-12."""


def predict(plan: Plan, noise: tuple[GyroTriad, RateTable], *, geometry: Mapping[str, float] | None = None) -> Solution:
    """Result that a fit of all data will have, apart from the estimates themselves: no data are needed.

    Parameters
    ----------
    plan : Plan
        The plan; turns need not be whole.
    noise : tuple of GyroTriad and RateTable
        Gyros and table with their noise levels, about which the model is linearised.
    geometry : mapping of str to float, optional
        Errors of the table to estimate along, as in `fogkit.calibration.bench_fit.fit`; ``inf`` for no prior.

    Returns
    -------
    Solution
        Parameters in the order of `PARAMETERS`, then those of `geometry`; `estimate` holds errors, which are expected
        to be zero. `covariance`, `correlation`, `condition` and `unobservable` are those of the plan. A parameter that
        neither plan nor prior determines has an infinite deviation; nothing is raised.

    Raises
    ------
    ValueError
        If `geometry` has an unknown name, or there is no noise at all, without which nothing has a weight.
    """
    triad, table = noise
    geometry = dict(geometry or {})
    for name in geometry:
        checks.option("geometry", name, GEOMETRY)
    ideal = bench.run(plan, triad, table)
    chosen = [len(PARAMETERS) + GEOMETRY.index(name) for name in geometry]
    believed = np.concatenate([parameters_of(triad), table.geometry])

    def readings(parameters: NDArray) -> NDArray:
        gyros, errors = np.split(parameters, [len(PARAMETERS)])
        moved = triad_from_parameters(gyros)
        return bench.expected_readings(plan, moved, table.with_geometry(errors), ideal.turned).ravel()

    columns = []
    for i in [*range(len(PARAMETERS)), *chosen]:
        step = np.zeros(believed.size)
        step[i] = STEP * believed[i] if 3 <= i < 9 else STEP
        columns.append((readings(believed + step) - readings(believed - step)) / (2 * step[i]))
    return linear(
        np.stack(columns, axis=-1),
        np.zeros(3 * len(plan.segments)),
        covariance=data_covariance(ideal, noise),
        prior_standard_deviation=geometry or None,
        names=(*PARAMETERS, *geometry),
        rank_tolerance=NUMERIC_RANK_TOLERANCE,
    )


def corrected_rate(triad: GyroTriad, readings: ArrayLike) -> NDArray[np.float64]:
    """Rate along the nominal axes from readings, with the parameters of a triad: what a navigation system does.

    Parameters
    ----------
    triad : GyroTriad
        Parameters that are believed.
    readings : array_like, shape (..., 3)
        Readings.

    Returns
    -------
    ndarray, shape (..., 3)
        Rates, rad/s. The sign of a reading less its bias chooses the scale factor.
    """
    free = checks.finite_array("readings", readings, shape=(..., 3)) - np.array(triad.bias)
    along = np.where(free > 0, triad.scale_positive, triad.scale_negative) * free
    return along @ np.linalg.inv(misalignment_matrix(triad.misalignments)).T


def drift_at_sea(
    covariance: ArrayLike,
    triad: GyroTriad,
    construction: Construction,
    motion: ArrayLike,
    *,
    fresh_bias: bool = False,
) -> NDArray[np.float64]:
    """Standard deviation of the drift that errors of a calibration leave in a motion.

    Parameters
    ----------
    covariance : array_like, shape (15, 15)
        Of the calibrated parameters, in the order of `PARAMETERS`. Their correlations count: the error of a bias enters
        the two scale factors with opposite signs, and partly cancels in rocking.
    triad : GyroTriad
        The parameters themselves.
    construction : Construction
        The unit; its block stands at zero.
    motion : array_like, shape (n, 3)
        Rates of the case in its own axes, rad/s, at equal steps of time over whole periods of the motion.
    fresh_bias : bool, optional
        Whether the biases are found anew, without error, when the system starts at sea.

    Returns
    -------
    ndarray, shape (3,)
        Of the mean rate along the axes of the case, rad/s.
    """
    covariance = checks.finite_array("covariance", covariance, shape=(len(PARAMETERS), len(PARAMETERS)))
    motion = checks.finite_array("motion", motion, shape=(..., 3)).reshape(-1, 3)
    C_0_g1 = construction.C_0_g1()
    along = motion @ C_0_g1.T @ triad.A_g.T
    readings = np.array(triad.bias) + along / np.where(along > 0, triad.scale_positive, triad.scale_negative)
    believed = parameters_of(triad)
    jacobian = np.zeros((3, believed.size))
    for i in range(3 if fresh_bias else 0, believed.size):
        # a small step: no sample of the motion may change the sign of its reading; the relation is all but linear
        step = np.zeros(believed.size)
        step[i] = 1e-9 if i < 3 else 1e-6
        means = [
            corrected_rate(triad_from_parameters(believed + sign * step), readings).mean(axis=0) for sign in (1, -1)
        ]
        jacobian[:, i] = C_0_g1.T @ (means[0] - means[1]) / (2 * step[i])
    return np.sqrt(np.einsum("ij,jk,ik->i", jacobian, covariance, jacobian))


def split_plan(
    construction: Construction, duration: float, *, bias_share: float, rate: float, repeats: int = 1
) -> Plan:
    """Plan of a given duration: a share for four bias positions, the rest for whole turns both ways about each gyro.

    Parameters
    ----------
    construction : Construction
        The unit.
    duration : float
        Time of all readings, s.
    bias_share : float
        Share for the positions, from 0, which leaves them out, to below 1. They also get what remains after the last
        whole turn.
    rate : float
        Rate of the turns, rad/s, positive.
    repeats : int, optional
        How often each turn is made, in as many parts with readings of their own.

    Returns
    -------
    Plan
        Four positions and ``6 * repeats`` turns, or the turns alone.

    Raises
    ------
    ValueError
        If the time for each turn is too short for a whole one.
    """
    checks.in_closed_interval("bias_share", bias_share, 0.0, 1.0)
    rate = checks.positive("rate", rate, "rad/s")
    duration = checks.positive("duration", duration, "s")
    shortest = 6 * checks.integer("repeats", repeats, minimum=1) * 2 * np.pi / rate
    count = int(np.floor((1 - bias_share) * duration / shortest * (1 + plans.WHOLE_TURN_TOLERANCE)))
    if count < 1:
        raise ValueError(f"`bias_share` must leave {shortest:.6g} s for whole turns, got {bias_share} of {duration} s")
    turning = plans.turns(construction, (rate, -rate) * repeats, count=count)
    held = duration - count * shortest
    return Plan(construction, (plans.four_positions(construction, held / 4) if bias_share else []) + turning)


def simulated_fit(
    plan: Plan, noise: tuple[GyroTriad, RateTable], seed: int, geometry: Mapping[str, float] | None = None
) -> dict[str, float]:
    """One complete calibration by fit: errors over their predicted deviations, and chi-square.

    Parameters
    ----------
    plan : Plan
        The plan.
    noise : tuple of GyroTriad and RateTable
        True gyros and the table that is believed, with their noise levels.
    seed : int
        Of the run's own random generator.
    geometry : mapping of str to float, optional
        Errors of the table that are drawn from their priors, rad, and estimated along.

    Returns
    -------
    dict
        By parameter, ``(estimate - truth) / standard deviation``; then ``chi_square``, ``degrees_of_freedom`` and
        ``seed``.
    """
    triad, table = noise
    rng = np.random.default_rng(seed)
    errors = table.geometry
    geometry = dict(geometry or {})
    chosen = [GEOMETRY.index(name) for name in geometry]
    errors[chosen] += rng.standard_normal(len(chosen)) * np.array(list(geometry.values()), dtype=float)
    record = bench.run(plan, triad, table.with_geometry(errors), rng=rng)
    solution = fit(record, noise, geometry=geometry)
    truth = np.concatenate([parameters_of(triad), (errors - table.geometry)[chosen]])
    ratios = (solution.estimate - truth) / solution.standard_deviation
    return dict(zip(solution.names, ratios.tolist(), strict=True)) | {
        "chi_square": solution.chi_square,
        "degrees_of_freedom": solution.degrees_of_freedom,
        "seed": seed,
    }
