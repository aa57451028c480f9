"""What the paper says of the idea of the method, before any recording: tested with the model of a turn.

Everything here follows from `fogkit.calibration.navigation_based.turn_model`, in which the Earth stands still, at the
attitudes of the recovered plan or at random ones. What needs recordings is in the other modules.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fogkit.calibration.navigation_based import turn_model
from fogkit.constants import EARTH_RATE
from fogkit.earth import earth_rate_n, gravity_n
from fogkit.imu.size_effect import SizeEffect
from fogkit.navigation import State, integrate_arrays
from fogkit.reproduction.klimkovich import plan_search
from fogkit.reproduction.klimkovich.estimates import LATITUDE
from fogkit.stand.turn_tests import DWELL
from fogkit.units import HOUR

Array = NDArray[np.float64]

STATE = tuple(turn_model.FULL_PARAMETERS.index(name) for name in turn_model.PARAMETERS)
"""Where the state (13) is among all errors of the readings."""

_ROUNDING = 1e-12  # slopes in units of gravity: products of a few matrices of ones, angles up to 35 rad
_DIFFERENCES = 1e-4  # of `turn_model.differentiated_rows`: relative to the elements, 3e-5 for angles up to 35 rad


def random_tests(count: int, seed: int) -> list[tuple[Array, Array, float]]:
    """Attitudes, unit axes in the body and angles, up to six turns of either sign, of tests of no plan."""
    rng = np.random.default_rng(seed)
    axes = rng.normal(size=(count, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    return list(zip(Rotation.random(count, rng=rng).as_matrix(), axes, rng.uniform(-38, 38, count), strict=True))


def stays_where_it_is(duration: float = HOUR) -> float:
    """Largest level velocity, m/s, that a perfect unit at rest in the attitude of test 1 computes for itself.

    The vertical channel, which no inertial system keeps, is not in it, but turns rounding into a little velocity.
    """
    dt = 1.0
    steps = round(duration / dt)
    rate, force = earth_rate_n(LATITUDE), -gravity_n(LATITUDE)
    start = State(lat=LATITUDE, C_b_n=np.eye(3))
    run = integrate_arrays(np.tile(rate * dt, (steps, 1)), np.tile(force * dt, (steps, 1)), dt, start)
    return float(np.abs(run.v_eb_n[:, :2]).max())


def largest_change(errors: Array | None = None, start: Array | tuple = (0, 0, 0)) -> float:
    """Largest change of slope, in units of gravity, over random tests; without errors if none are given."""
    errors = np.zeros(len(turn_model.FULL_PARAMETERS)) if errors is None else errors
    return max(np.abs(turn_model.slope_change(*test, errors, start=start)).max() for test in random_tests(10, 1))


def perfect_unit_stays_level() -> bool:
    """Whether no turn changes the slopes of a perfect unit."""
    return bool(largest_change() < _ROUNDING)


def start_does_not_matter() -> bool:
    """Whether this holds with a wrong attitude at the start, too; the Earth stands still here."""
    return bool(largest_change(start=(0.01, -0.02, 0.03)) < 100 * _ROUNDING)


def every_error_shows() -> bool:
    """Whether each of the 15 errors of (13) alone changes the slopes of the plan."""
    changes = []
    for column in STATE:
        errors = 1e-4 * np.eye(len(turn_model.FULL_PARAMETERS))[column]
        changes.append(
            max(
                np.abs(turn_model.slope_change(turn.C_b_n, turn.direction, turn.angle, errors)).max()
                for turn in plan_search.recovered_plan()
            )
        )
    return bool(min(changes) > 0.5e-4)


def full_rows() -> Array:
    """Derivatives of the slopes of the plan by all 21 errors of the readings, by differences, shape (18, 21)."""
    plan = plan_search.recovered_plan()
    return np.concatenate([turn_model.differentiated_rows(t.C_b_n, t.direction, t.angle) for t in plan])


def gauge_removes_the_frame() -> bool:
    """Whether without the three zeros a common rotation of both triads is unseen, and with them nothing of (13) is."""
    rows = full_rows()
    rotations = np.zeros((3, rows.shape[1]))
    for i, turned in enumerate(np.cross(np.eye(3), np.eye(3)[:, np.newaxis, :])):
        rotations[i, :18] = np.tile(turned.ravel(), 2)
    unseen = np.abs(rows @ rotations.T).max() < _DIFFERENCES
    return bool(unseen and np.linalg.matrix_rank(rows[:, STATE], tol=_DIFFERENCES) == len(STATE))


def rank_of_dwells(turned: bool = True) -> int:
    """Rank of what the dwells tell of the 15 errors, with the turns of the plan between them or with none.

    Nothing that is read during a turn is in the measurements: the slopes are those of the dwells.
    """
    plan = plan_search.recovered_plan()
    rows = [turn_model.measurement_rows(t.C_b_n, t.direction, t.angle if turned else 0.0) for t in plan]
    return int(np.linalg.matrix_rank(np.concatenate(rows), tol=_DIFFERENCES))


@cache
def rows_are_derivatives() -> bool:
    """Whether (14)-(19) are the derivatives of the exact slopes, at random attitudes, axes and angles."""
    for test in random_tests(10, 2):
        difference = turn_model.measurement_rows(*test) - turn_model.differentiated_rows(*test)[:, STATE]
        if not np.abs(difference).max() < _DIFFERENCES:
            return False
    return True


def sums_of_eq12(steps: int, instant: float = 0.5) -> float:
    """Departure of (12) from the integral in (10) for the turn of test 1, relative, with so many steps.

    Parameters
    ----------
    steps : int
        Number of steps of the turn.
    instant : float, optional
        Where in the step the attitude is taken: 0 its beginning, 0.5 its middle.
    """
    turn = plan_search.recovered_plan()[0]
    exact = turn_model.angle_projections(turn.C_b_n, turn.direction, turn.angle)
    angles = turn.angle * (np.arange(steps) + instant) / steps
    attitudes = turn.C_b_n @ Rotation.from_rotvec(np.outer(angles, turn.direction)).as_matrix()
    increments = np.tile(turn.direction * turn.angle / steps, (steps, 1))
    return float(np.abs(np.einsum("pik,pj->ikj", attitudes, increments) - exact).max())


def order_of_eq12(instant: float = 0.5) -> float:
    """Order of convergence of (12) in the step."""
    return float(np.log2(sums_of_eq12(1000, instant) / sums_of_eq12(2000, instant)))


def error_after_one_step(sign: int = 1, gyro_sign: int = 1) -> float:
    """Largest error left, over the largest before, after one iteration on the ideal plan without noise.

    Parameters
    ----------
    sign : {1, -1}, optional
        1 subtracts the estimate, as the paper does; -1 adds it.
    gyro_sign : {1, -1}, optional
        -1 takes the attitude error into the measurement with the signs of (3) and (4).
    """
    errors = np.zeros(len(turn_model.FULL_PARAMETERS))
    errors[list(STATE)] = 1e-5 * np.random.default_rng(3).normal(size=len(STATE))
    plan = plan_search.recovered_plan()
    Z = np.concatenate([turn_model.slope_change(t.C_b_n, t.direction, t.angle, errors) for t in plan])
    H = plan_search.measurement_matrix() * np.repeat([1, gyro_sign, 1], [3, 9, 3])
    left = errors[list(STATE)] - sign * np.linalg.lstsq(H, Z, rcond=None)[0]
    return float(np.abs(left).max() / np.abs(errors).max())


def east_and_north_are_independent() -> bool:
    """Whether noise of any three sensors is uncorrelated east and north in every attitude of the plan."""
    variances = np.diag([1.0, 2.0, 5.0])
    attitudes = [plan_search.attitude(s) for turn in plan_search.recovered_plan() for s in (turn.start, turn.end)]
    return all(abs((C @ variances @ C.T)[0, 1]) < _ROUNDING for C in attitudes)


def more_states_are_worse() -> bool:
    """Whether states that are estimated besides never improve the condition, or lessen the variance of the others.

    For any measurement, since columns that are added can only lessen the smallest singular value and raise the largest:
    tried on the rows of the plan with random columns besides.
    """
    rng = np.random.default_rng(9)
    H = plan_search.measurement_matrix()
    for count in (1, 2, 3):
        wider = np.hstack([H, rng.normal(size=(len(H), count))])
        variances = [np.diag(np.linalg.inv(M.T @ M))[: H.shape[1]] for M in (H, wider)]
        if np.linalg.cond(wider) < np.linalg.cond(H) or (variances[1] < variances[0] * (1 - 1e-9)).any():
            return False
    return True


def turn_of_a_dwell() -> float:
    """Angle, rad, by which Schuler's oscillation and the Earth turn anything in a dwell, the larger."""
    from fogkit.reproduction.klimkovich.estimates import schuler_frequencies

    return float(max(schuler_frequencies(LATITUDE).max(), EARTH_RATE) * DWELL)


def unknowns_of_size_effect(centres: int) -> int:
    """Number of coordinates of three accelerometers with so many centres of sensitivity each."""
    accelerometers, coordinates = 3, 3
    return accelerometers * centres * coordinates


def visible_of_size_effect(centres: int) -> int:
    """How many of them change the readings of an arbitrary motion, by `fogkit.imu.size_effect.SizeEffect`.

    The tangential acceleration along the axis of an accelerometer does not depend on how far along it the centre lies.
    """
    rng = np.random.default_rng(4)
    steps = np.eye(9 * centres).reshape(-1, centres, 3, 3)
    columns = []
    rates, accelerations = rng.normal(size=(2, 12, 3))
    for step in steps:
        effect = (
            SizeEffect(acceleration_centres=step[0], velocity_centres=step[1])
            if centres == 2
            else SizeEffect.one_point(step[0])
        )
        added = effect.added_force(accelerations, rates[:, :, None] * rates[:, None, :])
        columns.append(np.diagonal(added, axis1=-2, axis2=-1).ravel())  # along each accelerometer's own axis
    return int(np.linalg.matrix_rank(np.array(columns).T, tol=1e-9))
