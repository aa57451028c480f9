"""Calibration: navigate all tests, estimate the errors from the changes of slope, subtract them, and again.

Each pass is a step of Gauss and Newton's method on the changes of slope. Its fixed point, where they vanish, does not
depend on the measurement matrix; how fast it is reached does. A gyro scale factor that is wrong by 1e-3 turns the
attitude by 0.03 rad in five turns, and (10) is linear: far from the solution the steps are shortened until none of them
turns an attitude at the end of a test by more than `LARGEST_TILT`.

References
----------
.. [1] B. V. Klimkovich, Precise calibration of strapdown INS using low-accuracy turntables, Gyroscopy and Navigation
   (in Russian), vol. 30, no. 4 (119), 2022, pp. 54-70.
"""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.calibration.navigation_based import plausibility
from fogkit.calibration.navigation_based.compensation import Compensation
from fogkit.calibration.navigation_based.matrix import (
    ACCELEROMETER_SCALE_FACTORS,
    actual_matrix,
    magnitude_rows,
    model_matrix,
    scale_factor_columns,
    upended,
)
from fogkit.calibration.navigation_based.processing import Processed, Processing, prepare
from fogkit.calibration.navigation_based.recordings import checked_plan
from fogkit.calibration.navigation_based.results import NavigationCalibration
from fogkit.calibration.navigation_based.turn_model import PARAMETERS
from fogkit.calibration.velocity_noise import SensorNoise
from fogkit.estimation import Solution, linear
from fogkit.stand.turn_tests import TurnTest

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

LARGEST_TILT = 0.3
"""Largest change, rad, that one step may make to the attitude after a turn: sine and angle differ by 1.5 %."""

SMALLEST_DEVIATION = 1e-10
"""Standard deviation of a slope, m/s^2, below which the scatter about the line is rounding: 1e-11 g. Without noise the
weights (24) would be ratios of rounding errors."""

LARGEST_ERROR = 0.2
"""Element of a correction summed over all steps at which the iteration has lost its way."""

_GROWTH = 10.0  # rms of the changes of slope, of the smallest so far, that is no fluctuation
_NO_RESULT = 1e-2  # change of attitude, rad, by the last of several corrections: the end is not in sight
_SETTLED = 1e-2  # correction in standard deviations that changes no conclusion
_STILL = {"m": 1e-9, "b": 1e-8}  # corrections of 0.0002 arcsec and 0.001 ppm of g, where the deviation is rounding

Noise = ArrayLike | Callable[[Sequence[TurnTest]], ArrayLike] | None


@dataclass(frozen=True, kw_only=True, eq=False)
class Problem:
    """What stays the same in all iterations."""

    processing: Processing
    plan: tuple[TurnTest, ...]
    gravity: Array  # vector in n, m/s^2
    matrix: str | Array
    scale_factor: str
    covariance: Array | None

    @cached_property
    def g(self) -> float:
        """Magnitude of gravity, m/s^2."""
        return float(np.linalg.norm(self.gravity))

    @cached_property
    def upended(self) -> dict[str, list[int]]:
        """Tests by which (26) gives each accelerometer scale factor."""
        return upended(self.plan)

    @cached_property
    def model(self) -> Array:
        """Measurement matrix of the plan."""
        return model_matrix(self.plan, self.g)


def calibrate(
    recordings: Sequence["DataFrame"],
    plan: Sequence[TurnTest],
    latitude: float,
    *,
    altitude: float = 0.0,
    gravity: float | ArrayLike | None = None,
    matrix: str | ArrayLike = "actual",
    initial_attitude: str | ArrayLike = "model",
    azimuth: float = 0.0,
    degree: int = 1,
    scale_factor: str = "pairs",
    iterations: int = 8,
    tolerance: float | None = None,
    start: Compensation | None = None,
    noise: Noise = None,
    settle: float = 0.0,
    dwells: str = "plan",
    corrections: str = "central",
    step_control: bool = True,
) -> NavigationCalibration:
    """Accelerometer biases, and both matrices, from recordings of dwell, turn, dwell on a rough turntable.

    Parameters
    ----------
    recordings : sequence of DataFrame
        Raw increments of each test in the order of the plan: index ``time``, s, from 0, the beginning of each step,
        equally spaced; columns ``gyro_x`` to ``accel_z``, rad and m/s.
    plan : sequence of TurnTest
        The tests as commanded, `fogkit.stand.turn_tests.nine_tests` for the paper's.
    latitude : float
        Geodetic latitude, rad.
    altitude : float, optional
        Height above the ellipsoid, m.
    gravity : float or array_like, shape (3,), optional
        Magnitude, m/s^2, or vector, east, north, up; the normal one of the place by default.
    matrix : {"actual", "model"} or array_like, shape (2 * tests, 15), optional
        Measurement matrix: (14)-(19) from the recorded rotations; the plan's; or any, in m/s^2, as the printed one.
    initial_attitude : {"model", "levelled", "carried"} or array_like, shape (tests, 3, 3), optional
        Attitude at the start of each test: the plan's; that turned level by the accelerometers in the first dwell; the
        same with the heading of the test before where the plan goes on from it; or known attitudes.
    azimuth : float, optional
        Angle, rad, clockwise seen from above, by which the table stands turned from what the plan says.
    degree : {1, 2}, optional
        Of the polynomial through the velocity; for 2 see `fogkit.calibration.navigation_based.slopes`.
    scale_factor : {"pairs", "all"}, optional
        Accelerometer scale factors by (26), from the test that turns an axis upside down, and apart from the other
        parameters; or from the length of the specific force in all dwells, in the same least squares.
    iterations : int, optional
        Largest number of iterations.
    tolerance : float, optional
        Correction, in standard deviations, at which to stop before; by default all iterations are made.
    start : Compensation, optional
        Where to begin; with unit matrices and no biases by default. Its gyro biases are not changed.
    noise : array_like or callable, optional
        Covariance of the measurements, m^2/s^4, or a function of the plan that returns it, in place of the variances
        (21)-(24): shape (2 * tests,) * 2, or (4 * tests,) * 2 with ``scale_factor="all"``, whose further rows are the
        lengths in the dwells, two of each test.
    settle : float, optional
        Time, s, left out of the second dwell after the turn.
    dwells : {"plan", "detected"}, optional
        When the unit rests: as planned, or as its gyros say.
    corrections : str, optional
        For coning and sculling, as of `fogkit.navigation.integrate_arrays`.
    step_control : bool, optional
        Whether steps that would turn an attitude by more than `LARGEST_TILT` are shortened; the paper's are not.

    Returns
    -------
    NavigationCalibration
        Compensation, solution of the last iteration, log, slopes, attitudes.

    Raises
    ------
    TypeError, ValueError
        If an argument is of another kind, or recordings are not what the plan says: `plausibility` lists how.
    RuntimeError
        If the iteration diverges; the message names the iteration, the quantity and its size.

    Warns
    -----
    UserWarning
        If a dwell is not quite at rest, turns are too few for scale factors, or the last correction is not small.
    """
    plan = checked_plan(plan)
    start = Compensation() if start is None else checks.instance("start", start, Compensation)
    iterations = checks.integer("iterations", iterations, minimum=1)
    tolerance = 0.0 if tolerance is None else checks.positive("tolerance", tolerance)
    require_observable(plan, scale_factor)
    processing = prepare(
        recordings,
        plan,
        latitude,
        altitude=altitude,
        gravity=gravity,
        initial_attitude=initial_attitude,
        azimuth=azimuth,
        degree=degree,
        settle=settle,
        dwells=dwells,
        corrections=corrections,
    )
    plausibility.check(processing.recordings, start, float(np.linalg.norm(processing.gravity)))
    problem = Problem(
        processing=processing,
        plan=plan,
        gravity=processing.gravity,
        matrix=_checked_matrix(matrix, len(plan)),
        scale_factor=scale_factor,
        covariance=_checked_covariance(noise, plan, scale_factor),
    )
    return _iterate(problem, start, iterations, tolerance, step_control)


def require_observable(plan: Sequence[TurnTest], scale_factor: str = "pairs") -> None:
    """``ValueError`` that names the parameters which a plan does not determine.

    Parameters
    ----------
    plan : sequence of TurnTest
        The tests.
    scale_factor : {"pairs", "all"}, optional
        As in `calibrate`.
    """
    checks.option("scale_factor", scale_factor, ("pairs", "all"))
    plan = checked_plan(plan)
    if scale_factor == "pairs":
        missing = [name for name, tests in upended(plan).items() if not tests]
        if missing:
            raise ValueError(
                f"the plan does not determine {', '.join(missing)} by (26): no test turns that axis upside down. "
                "`scale_factor='all'` takes all dwells."
            )
    H = model_matrix(plan, 1.0)
    names = PARAMETERS
    if scale_factor == "all":
        names = PARAMETERS + ACCELEROMETER_SCALE_FACTORS
        H = _with_magnitudes(H, _ideal(plan), np.array([0.0, 0.0, -1.0]))[0]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a poor condition of the plan is reported with the recordings
        linear(H, np.zeros(len(H)), standard_deviation=1.0, names=names).raise_if_unobservable("the plan")


def _iterate(
    problem: Problem, compensation: Compensation, iterations: int, tolerance: float, step_control: bool
) -> NavigationCalibration:
    """The loop; the compensation that comes back has the last correction in it."""
    start, log, smallest, converged = compensation, [], np.inf, False
    for number in range(1, iterations + 1):
        processed = problem.processing.run(compensation)
        smallest = _require_no_growth(number, processed, smallest, problem.g)
        solution, scale_factors, deviations = _estimate(problem, processed)
        errors = dict(zip(solution.names, solution.estimate.tolist(), strict=True)) | scale_factors
        tilt = _tilt(processed, errors)
        share = min(1.0, LARGEST_TILT / max(tilt, np.finfo(float).tiny)) if step_control else 1.0
        errors = {name: share * value for name, value in errors.items()}
        compensation = compensation.corrected(errors)
        _require_near(number, compensation, start)
        largest = float(np.abs(solution.estimate / solution.standard_deviation).max())
        log.append(
            _log_row(processed, errors, solution) | {"largest_correction": largest, "tilt": tilt, "share": share}
        )
        still = all(abs(value) <= _STILL[name[0]] for name, value in errors.items())
        converged = share == 1.0 and (still or largest <= max(tolerance, _SETTLED))
        if converged and tolerance:
            break
    if not converged:
        _require_progress(log)
        warnings.warn(
            f"the last of {len(log)} corrections is {largest:.2g} standard deviations: more `iterations` would change "
            "the result",
            UserWarning,
            stacklevel=3,
        )
    result = NavigationCalibration(
        compensation=compensation,
        solution=solution,
        scale_factor_deviation=deviations,
        log=_log_frame(log),
        slopes=_slopes_frame(problem.plan, processed),
        attitudes=processed.attitudes,
        converged=converged,
    )
    plausibility.warn_of_few_turns(problem.plan, solution)
    return result


def _estimate(problem: Problem, processed: Processed) -> tuple[Solution, dict[str, float], Array]:
    """Solution (25) with (27), scale factors (26) if they are not in it, and the standard deviations of these."""
    H = problem.matrix
    if isinstance(H, str):
        H = actual_matrix(processed, problem.g) if H == "actual" else problem.model
    if problem.scale_factor == "pairs":
        solution = _solve(problem, H, processed.change, processed.change_variance, PARAMETERS)
        return solution, *_pairs(problem, processed)
    names = PARAMETERS + ACCELEROMETER_SCALE_FACTORS
    rows, lengths = _with_magnitudes(H, processed, problem.gravity)
    variance = np.concatenate([processed.change_variance, processed.variances[:, :, 2].ravel()])
    solution = _solve(problem, rows, np.concatenate([processed.change, lengths]), variance, names)
    return solution, {}, solution.standard_deviation[-3:]


def _solve(problem: Problem, H: Array, Z: Array, variance: Array, names: tuple[str, ...]) -> Solution:
    if problem.covariance is not None:
        return linear(H, Z, covariance=problem.covariance, names=names)
    return linear(H, Z, standard_deviation=np.sqrt(np.maximum(variance, SMALLEST_DEVIATION**2)), names=names)


def _pairs(problem: Problem, processed: Processed) -> tuple[dict[str, float], Array]:
    """Accelerometer scale factors (26), the mean over all tests that turn an axis upside down."""
    found, deviations = {}, []
    for name, tests in problem.upended.items():
        sums = processed.slopes[tests, :, 2].sum(axis=1) / (2 * problem.g)
        found[name] = float(sums.mean())
        deviations.append(np.sqrt(processed.variances[tests, :, 2].sum()) / (2 * problem.g * len(tests)))
    return found, np.array(deviations)


def _with_magnitudes(H: Array, processed: Processed, gravity: Array) -> tuple[Array, Array]:
    """Rows of the level with columns of scale factors, and rows of the lengths below them; values of the latter."""
    columns = scale_factor_columns(processed).reshape(-1, 3)
    rows, lengths = magnitude_rows(processed, gravity)
    return np.vstack([np.hstack([H, columns]), rows]), lengths


def _ideal(plan: tuple[TurnTest, ...]) -> Processed:
    """What the plan would give with gravity 1, as far as `_with_magnitudes` needs it."""
    C = np.stack([np.stack([test.C_b_n, test.C_b_n_end]) for test in plan])
    nothing = np.zeros((len(plan), 2, 3))
    return Processed(
        slopes=nothing,
        variances=nothing,
        forces=C[:, :, 2],
        attitudes=C,
        starts=C[:, 0],
        ends=C[:, 1],
        projections=np.zeros((len(plan), 3, 3, 3)),
    )


def _tilt(processed: Processed, errors: dict[str, float]) -> float:
    """Largest change that a step makes to an attitude at the end of a turn, rad."""
    m = np.array([[errors[f"m_g_{k}{j}"] for j in (1, 2, 3)] for k in (1, 2, 3)])
    return float(np.linalg.norm(np.einsum("tikj,kj->ti", processed.projections, m), axis=-1).max())


def _require_no_growth(number: int, processed: Processed, smallest: float, gravity: float) -> float:
    """Smallest rms of the changes of slope so far; ``RuntimeError`` if it has grown well beyond."""
    rms = float(np.sqrt(np.mean(processed.change**2)))
    floor = 1e-9 * gravity  # growth from rounding to rounding is none
    if number > 1 and rms > _GROWTH * max(smallest, floor):
        raise RuntimeError(
            f"the calibration diverges: in iteration {number} the rms of the changes of slope is {rms:.3g} m/s^2 after "
            f"{smallest:.3g} m/s^2. The errors of `start` may be too large (gyro scale factors above all, times the "
            "angle of the turns), the matrix or the plan another one, or a recording not of its test."
        )
    return min(rms, smallest)


def _require_progress(log: list[dict[str, float]]) -> None:
    """``RuntimeError`` if several iterations have not come near a solution."""
    if len(log) >= 4 and log[-1]["tilt"] > _NO_RESULT:
        raise RuntimeError(
            f"the calibration does not converge: the correction of iteration {len(log)} still turns an attitude by "
            f"{log[-1]['tilt']:.3g} rad, that of the first by {log[0]['tilt']:.3g} rad. Is the matrix that of "
            "the tests?"
        )


def _require_near(number: int, compensation: Compensation, start: Compensation) -> None:
    """``RuntimeError`` if a matrix has moved from the start by more than any calibration does."""
    for kind in ("gyro", "accelerometer"):
        moved = np.abs(getattr(compensation, f"{kind}_matrix") - getattr(start, f"{kind}_matrix"))
        if not moved.max() <= LARGEST_ERROR:
            i, j = np.unravel_index(np.argmax(moved), (3, 3))
            raise RuntimeError(
                f"the calibration diverges: in iteration {number} the corrections of element {i + 1}, {j + 1} of the "
                f"{kind} matrix add up to {moved.max():.3g}, more than {LARGEST_ERROR:g}. Is `start` that of this unit?"
            )


def _log_row(processed: Processed, errors: dict[str, float], solution: Solution) -> dict[str, float]:
    def rms(*names: str) -> float:
        return float(np.sqrt(np.mean([errors[name] ** 2 for name in names])))

    return {
        "rms_z": float(np.sqrt(np.mean(processed.change**2))),
        "rms_m_a": rms(*PARAMETERS[:3]),
        "rms_m_g": rms(*PARAMETERS[3:12]),
        "rms_b_a": rms(*PARAMETERS[12:]),
        "rms_scale_factor_a": rms(*ACCELEROMETER_SCALE_FACTORS),
        "chi_square": solution.chi_square,
        "condition": solution.condition,
    }


def _log_frame(rows: list[dict[str, float]]) -> "DataFrame":
    import pandas as pd

    return pd.DataFrame(rows, index=pd.Index(range(1, len(rows) + 1), name="iteration"))


def _slopes_frame(plan: tuple[TurnTest, ...], processed: Processed) -> "DataFrame":
    import pandas as pd

    index = pd.MultiIndex.from_product([[test.label for test in plan], [1, 2]], names=["test", "dwell"])
    names = ("east", "north", "up")
    table = np.concatenate([processed.slopes, processed.variances], axis=-1).reshape(-1, 6)
    return pd.DataFrame(table, index=index, columns=[*names, *(f"variance_{name}" for name in names)])


def _checked_matrix(matrix: str | ArrayLike, count: int) -> str | Array:
    if isinstance(matrix, str):
        return checks.option("matrix", matrix, ("actual", "model"))
    return checks.finite_array("matrix", matrix, shape=(2 * count, len(PARAMETERS)))


def _checked_covariance(noise: Noise, plan: tuple[TurnTest, ...], scale_factor: str) -> Array | None:
    if noise is None:
        return None
    if isinstance(noise, SensorNoise):
        raise TypeError(
            "`noise` must be a covariance or a function of the plan, got SensorNoise. "
            "`fogkit.calibration.uncertainty.plan_covariance` makes one of it."
        )
    size = (2 if scale_factor == "pairs" else 4) * len(plan)
    return checks.finite_array("noise", noise(plan) if callable(noise) else noise, shape=(size, size))
