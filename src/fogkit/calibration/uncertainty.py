"""How sure is a calibration by changes of the computed velocity? Covariances that are true for the noise of sensors.

The paper takes the noise of a slope from the residuals of the line through the velocity, (21)-(24), as if they were
white. Random walks leave little trace in them: a line bends to follow, and a tilt that came during the turn shows in
no residual at all. Here the covariance of the slopes follows from the random errors of the sensors
(`fogkit.calibration.velocity_noise`); `predict` gives what least squares with it will reach, `stated_and_true` what
the paper's weights give and what formula (27) would say of it.

References
----------
.. [1] B. V. Klimkovich, Precise calibration of strapdown INS using low-accuracy turntables, Gyroscopy and Navigation
   (in Russian), vol. 30, no. 4 (119), 2022, pp. 54-70.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.calibration import velocity_noise
from fogkit.calibration.navigation_based import turn_model
from fogkit.calibration.velocity_noise import SensorNoise, Steps
from fogkit.constants import STANDARD_GRAVITY
from fogkit.estimation.leastsquares import linear
from fogkit.estimation.solution import Solution
from fogkit.results import FrozenArrays
from fogkit.stand.turn_tests import TurnTest

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

SCALE_FACTORS = ("m_a_11", "m_a_22", "m_a_33")
"""Errors of the accelerometers' scale factors, which (26) of [1]_ finds apart from the other fifteen."""

_SAMPLES = 60  # of a dwell, at which the variance of a residual is averaged: its mean is then right to 1e-3


def slope_weights(count: int, dt: float, degree: int = 1, at: float = 0.0) -> Array:
    """Weights of equally spaced values in the slope of the polynomial of least squares through them.

    Parameters
    ----------
    count : int
        Values.
    dt : float
        Time between them, s.
    degree : int, optional
        Degree of the polynomial, 1 or 2.
    at : float, optional
        Where the slope is taken, s from the first value; with degree 1 it is the same everywhere.

    Returns
    -------
    ndarray, shape (count,)
        1/s.
    """
    degree = checks.integer("degree", degree, minimum=1)
    count = checks.integer("count", count, minimum=degree + 1)
    if degree > 2:
        raise ValueError(f"`degree` must be 1 or 2, got {degree}")
    middle = (count - 1) / 2
    x = np.arange(count) - middle
    weights = x / (x @ x)
    if degree == 2:
        square = x**2 - np.mean(x**2)
        weights = weights + 2 * (at / dt - middle) * square / (square @ square)
    return weights / dt


def slope_covariance(
    test: TurnTest,
    dt: float,
    noise: SensorNoise,
    *,
    degree: int = 1,
    gravity: float = STANDARD_GRAVITY,
    C_b_n: ArrayLike | None = None,
) -> Array:
    """Covariance of the slopes of the computed velocity in both dwells of a test.

    Parameters
    ----------
    test : TurnTest
        The test; navigation begins from rest with it, and again from rest at the end of the turn.
    dt : float
        Duration of a step, s, of which dwells and turn are whole numbers.
    noise : SensorNoise
        Random errors of the sensors.
    degree : int, optional
        Degree of the polynomials, 1 or 2. The slopes of the second degree are both taken in the middle of the turn, as
        in `fogkit.calibration.navigation_based.slopes`.
    gravity : float, optional
        m/s^2.
    C_b_n : array_like, shape (n, 3, 3), optional
        Attitude in each step, where it was navigated. By default the commanded one with a steady turn; for white noise
        of three equal sensors it makes no difference.

    Returns
    -------
    ndarray, shape (6, 6)
        East, north, up in the first dwell, then in the last, (m/s^2)^2.

    Raises
    ------
    ValueError
        If `dt` does not divide the test, or an argument is out of range.

    Notes
    -----
    For dwells T, a turn of length U and steps that are short beside them, angle random walk N, velocity random walk M
    and white velocity noise s: the variance of a level slope in the first dwell is
    ``13/35 g^2 N^2 T + 6/5 M^2 / T + 12 s^2 dt / T^3``, in the last ``g^2 N^2 (T + U)`` more, and of their difference
    ``g^2 N^2 (26/35 T + U) + 12/5 M^2 / T + 24 s^2 dt / T^3``.

    Examples
    --------
    >>> from fogkit.noise import RandomErrors
    >>> test = TurnTest.from_letters("ENU", "x", np.pi / 2, dwell=10.0, turn_duration=15.0)
    >>> noise = SensorNoise(gyros=RandomErrors(angle_random_walk=1e-6))
    >>> covariance = slope_covariance(test, 0.01, noise)
    >>> difference = covariance[0, 0] + covariance[3, 3] - 2 * covariance[0, 3]
    >>> print(f"{difference**0.5:.3e} {9.80665e-6 * (26 / 35 * 10 + 15) ** 0.5:.3e}")
    4.644e-05 4.644e-05
    """
    steps = Steps.of(test, dt, C_b_n)
    gravity = checks.positive("gravity", gravity, "m/s^2")
    return velocity_noise.covariance(_both_slopes(steps, degree), steps, noise, gravity)


def plan_covariance(
    plan: Sequence[TurnTest],
    dt: float,
    noise: SensorNoise,
    *,
    degree: int = 1,
    gravity: float = STANDARD_GRAVITY,
    scale_factors: bool = False,
) -> Array:
    """Covariance of the measurements (6), (7) of [1]_: differences of the level slopes of each test.

    Parameters
    ----------
    plan : sequence of TurnTest
        Tests, in the order of the rows.
    dt, noise, degree, gravity
        As in `slope_covariance`.
    scale_factors : bool, optional
        Whether the vertical slopes follow, which say the scale factors of accelerometers.

    Returns
    -------
    ndarray, shape (2 n, 2 n) or (4 n, 4 n)
        East and north of each test, (m/s^2)^2; then up in both dwells of each. Nothing is common to two tests. It is
        what `fogkit.calibration.navigation_based.calibrate` takes for `noise`.
    """
    return _measurements(plan, dt, noise, degree, gravity, scale_factors)[1]


def design(test: TurnTest, *, gravity: float = STANDARD_GRAVITY, scale_factors: bool = False) -> Array:
    """What the errors of calibration change in the slopes of one commanded test, to first order.

    Parameters
    ----------
    test : TurnTest
        The test.
    gravity : float, optional
        m/s^2.
    scale_factors : bool, optional
        Whether the vertical slopes take part, which say the scale factors of accelerometers.

    Returns
    -------
    ndarray, shape (2, 15) or (4, 18)
        Rows: difference of the slopes east and north; then the slopes up in the first and in the last dwell. Columns:
        `turn_model.PARAMETERS`, then `SCALE_FACTORS`.
    """
    level = turn_model.measurement_rows(test.C_b_n, test.axis, test.angle, gravity)
    if not scale_factors:
        return level
    attitudes = np.stack([test.C_b_n, test.C_b_n_end])
    own = gravity * attitudes * attitudes[:, 2:, :]  # C_ip C_3p g: what a scale factor does along n axis i
    up = attitudes[:, 2]
    crossed = gravity * up * up[:, turn_model.MISALIGNED_WITH]
    vertical = np.concatenate([crossed, np.zeros((2, 9)), up, own[:, 2]], axis=-1)
    return np.concatenate([np.concatenate([level, (own[1] - own[0])[:2]], axis=-1), vertical])


def predict(
    plan: Sequence[TurnTest],
    noise: SensorNoise,
    *,
    dt: float = 0.01,
    degree: int = 1,
    gravity: float = STANDARD_GRAVITY,
    scale_factors: bool = False,
) -> Solution:
    """Result that generalised least squares will have with a plan, apart from the estimates: no data are needed.

    Parameters
    ----------
    plan : sequence of TurnTest
        Tests as commanded.
    noise : SensorNoise
        Random errors of the sensors; every measurement needs some.
    dt, degree, gravity
        As in `slope_covariance`.
    scale_factors : bool, optional
        Whether all vertical slopes are fitted along, with the scale factors of accelerometers as parameters. The
        vertical slopes also help the biases and misalignments, which (26) of [1]_ leaves unused.

    Returns
    -------
    Solution
        Parameters `turn_model.PARAMETERS`, then `SCALE_FACTORS`; `estimate` holds errors, which are expected to be
        zero. `covariance`, `condition` and `unobservable` are those of the plan.

    Raises
    ------
    ValueError
        If there are no tests, or a measurement has no noise, without which nothing has a weight.
    """
    rows, covariance = _measurements(plan, dt, noise, degree, gravity, scale_factors)
    if not (np.diagonal(covariance) > 0).all():
        raise ValueError("`noise` must reach every measurement, got some without: give gyros or accelerometers noise")
    names = turn_model.PARAMETERS + (SCALE_FACTORS if scale_factors else ())
    return linear(rows, np.zeros(len(rows)), covariance=covariance, names=names)


@dataclass(frozen=True, kw_only=True, eq=False)
class StatedAndTrue(FrozenArrays):
    """Standard deviations of the fifteen errors (13) of [1]_, rad and m/s^2.

    Attributes
    ----------
    stated : ndarray, shape (15,)
        By (27), with the weights that (21)-(24) are expected to give.
    true : ndarray, shape (15,)
        Of the same estimates, with the noise as it is.
    best : ndarray, shape (15,)
        Of generalised least squares with the true covariance.
    residual_deviation : ndarray, shape (n, 2, 2)
        Expected root mean square S of the residuals of (24), m/s: by test, dwell, and east or north.
    """

    stated: Array
    true: Array
    best: Array
    residual_deviation: Array

    def to_frame(self) -> "DataFrame":
        """Table with one row for each error, SI; ``ratio`` is true over stated."""
        import pandas as pd

        columns = {"stated": self.stated, "true": self.true, "best": self.best, "ratio": self.true / self.stated}
        return pd.DataFrame(columns, index=pd.Index(turn_model.PARAMETERS, name="parameter"))


def stated_and_true(
    plan: Sequence[TurnTest], noise: SensorNoise, *, dt: float = 0.01, gravity: float = STANDARD_GRAVITY
) -> StatedAndTrue:
    """How far the standard deviations (27) of [1]_ are from the truth, lines being fitted as in the paper.

    Parameters
    ----------
    plan : sequence of TurnTest
        Tests that determine all fifteen errors.
    noise : SensorNoise
        Random errors of the sensors.
    dt, gravity
        As in `slope_covariance`.

    Returns
    -------
    StatedAndTrue
        Deviations that (27) states, that the estimates (25) have, and that the best weights would give.

    Raises
    ------
    ValueError
        If the plan leaves an error open, or a measurement has no noise.
    """
    best = predict(plan, noise, dt=dt, gravity=gravity)
    best.raise_if_unobservable("the plan")
    rows, covariance = _measurements(plan, dt, noise, 1, gravity, False)
    residual = np.stack([_residual_deviation(Steps.of(test, dt), noise, gravity) for test in plan])
    spread = np.stack([_spread(Steps.of(test, dt)) for test in plan])
    deviation = np.sqrt((residual**2 / spread[..., None]).sum(axis=1)).ravel()  # (23), (24)
    weighted = linear(rows, np.zeros(len(rows)), standard_deviation=deviation)
    gain = weighted.covariance @ rows.T / deviation**2
    return StatedAndTrue(
        stated=weighted.standard_deviation,
        true=np.sqrt(np.diagonal(gain @ covariance @ gain.T)),
        best=best.standard_deviation,
        residual_deviation=residual,
    )


def _both_slopes(steps: Steps, degree: int) -> Array:
    """Weights of the slopes in both dwells, as `velocity_noise.covariance` takes them, shape (2, count + 2)."""
    weights = np.zeros((2, steps.count + 2))
    middle = (steps.turn_begin + steps.turn_end) / 2
    for row, (begin, count, node) in zip(weights, _samples(steps), strict=True):
        row[begin : begin + count] = slope_weights(count, steps.dt, degree, at=(middle - node) * steps.dt)
    return weights


def _samples(steps: Steps) -> tuple[tuple[int, int, int], tuple[int, int, int]]:
    """Of both dwells: place of the first weight, samples, steps before the first; nodes set to zero are left out."""
    last = steps.count - steps.turn_end
    return (1, steps.turn_begin, 1), (steps.count + 2 - last, last, steps.turn_end + 1)


def _measurements(
    plan: Sequence[TurnTest], dt: float, noise: SensorNoise, degree: int, gravity: float, scale_factors: bool
) -> tuple[Array, Array]:
    """Design and covariance of the measurements of all tests: level differences of all, then vertical slopes of all."""
    from scipy.linalg import block_diag  # loaded where used

    checks.instance("noise", noise, SensorNoise)
    plan = tuple(checks.instance("plan", test, TurnTest) for test in plan)
    if not plan:
        raise ValueError("`plan` must hold at least one test, got none")
    take = np.zeros((4, 6))
    take[[0, 0, 1, 1, 2, 3], [0, 3, 1, 4, 2, 5]] = (-1, 1, -1, 1, 1, 1)
    take = take[: 4 if scale_factors else 2]
    blocks = [take @ slope_covariance(test, dt, noise, degree=degree, gravity=gravity) @ take.T for test in plan]
    rows = np.concatenate([design(test, gravity=gravity, scale_factors=scale_factors) for test in plan])
    order = np.arange(len(rows)).reshape(len(plan), -1, 2).swapaxes(0, 1).ravel()
    return rows[order], block_diag(*blocks)[np.ix_(order, order)]


def _spread(steps: Steps) -> Array:
    """Sum of the squared distances from their mean of the times in either dwell, s^2: ``k (<tau^2> - <tau>^2)``."""
    counts = np.array([count for _, count, _ in _samples(steps)])
    return steps.dt**2 * counts * (counts**2 - 1) / 12


def _residual_deviation(steps: Steps, noise: SensorNoise, gravity: float) -> Array:
    """Expected S of (24), m/s, in both dwells, east and north: shape (2, 2)."""
    result = np.zeros((2, 2))
    for dwell, (begin, count, _) in enumerate(_samples(steps)):
        x = np.arange(count) - (count - 1) / 2
        chosen = np.unique(np.linspace(0, count - 1, min(count, _SAMPLES)).round().astype(int))
        weights = np.zeros((chosen.size, steps.count + 2))
        weights[np.arange(chosen.size), begin + chosen] = 1
        weights[:, begin : begin + count] -= 1 / count + np.outer(x[chosen], x) / (x @ x)
        variance = np.diagonal(velocity_noise.covariance(weights, steps, noise, gravity)).reshape(-1, 3)[:, :2]
        total = np.trapezoid(variance, chosen, axis=0) + (variance[0] + variance[-1]) / 2  # over all samples
        result[dwell] = np.sqrt(total / (count - 2))
    return result
