"""The iteration of the paper, laid open: every step with its true error, for three measurement matrices on equal terms.

`fogkit.calibration.navigation_based.calibrate` stops when it diverges, shortens steps, and refuses a table that is too
rough. `iterate` does nothing of the kind, so that one can watch what happens: same recordings, attitudes and weights
for each matrix. `sweep` does so for many tables; its rows are kept in ``data/derived/klimkovich_matrices.csv``.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import DTypeLike, NDArray

from fogkit import checks
from fogkit.calibration.navigation_based import matrix as matrices
from fogkit.calibration.navigation_based.compensation import Compensation, differences
from fogkit.calibration.navigation_based.processing import Processed, Processing, gravity_vector
from fogkit.calibration.navigation_based.recordings import recordings_of
from fogkit.calibration.navigation_based.turn_model import PARAMETERS
from fogkit.claims import claims_folder
from fogkit.imu.unit import MeasurementUnit, Shape
from fogkit.reproduction.klimkovich import paper
from fogkit.reproduction.klimkovich.estimates import LATITUDE
from fogkit.reproduction.klimkovich.trials import GRAVITY, MATRICES, Trial
from fogkit.units import ARCSEC

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

ROUGHNESS = (0.0, 0.1, 0.3, 1.0, 2.0, 3.0, 5.0, 10.0)
"""Roughness of the table in `sweep`, in units of `RoughTable.typical`."""

SETTLED = 0.1 * ARCSEC
"""Distance of every misalignment from where an iteration ends that is settled: a tenth of what the noise makes."""

SEEDS = 24
"""Tables, units and noises of each roughness in `sweep`."""

LOST = 0.5
"""Element of the matrices, less the unit one, beyond which an iteration has gone astray."""

ANGLES = tuple(f"m_{kind}_{place}" for kind in "ag" for place in ("12", "13", "21", "23", "31", "32"))
"""Misalignments; with those of the gauge, whose errors are zero."""

_FREE = tuple(name for name in ANGLES if name not in ("m_a_12", "m_a_23", "m_a_31"))
_DOWN = gravity_vector(None, LATITUDE, 0.0)
_SCALE_FACTORS = matrices.ACCELEROMETER_SCALE_FACTORS


def processing(trial: Trial, starts: str | Array = "true") -> Processing:
    """The recordings of a trial, ready to be navigated from the true attitudes or as `calibrate` knows them."""
    if isinstance(starts, str) and starts == "true":
        starts = trial.starts
    return Processing(recordings_of(trial.recordings, trial.plan), LATITUDE, 0.0, _DOWN, starts, 0.0, 1, "central")


@dataclass(frozen=True, kw_only=True, eq=False)
class VariedTrial(Trial):
    """Trial of a unit with scale factors that are far off, or not constant.

    Parameters
    ----------
    asymmetry : float, optional
        Of the gyros: difference of the scale factors for both senses over their mean.
    quadratic : float, optional
        Of the accelerometers, 1/(m/s^2).
    gyro_scale : float, optional
        What all gyros read too much, relative.
    """

    gyro_scale: float = 0.0
    asymmetry: float = 0.0
    quadratic: float = 0.0

    @cached_property
    def unit(self) -> MeasurementUnit:
        """The unit with its errors."""
        unit = super().unit
        triad = replace(unit.gyros.triad, matrix=(1 + self.gyro_scale) * np.array(unit.gyros.triad.matrix))
        gyros = replace(unit.gyros, triad=triad, shape=Shape(asymmetry=np.full(3, self.asymmetry)))
        accelerometers = replace(unit.accelerometers, shape=Shape(quadratic=np.full(3, self.quadratic)))
        return replace(unit, gyros=gyros, accelerometers=accelerometers)


def measurement_matrix(matrix: str, trial: Trial, processed: Processed) -> Array:
    """One of `MATRICES` for a trial, shape (18, 15), m/s^2."""
    if checks.option("matrix", matrix, MATRICES) == "actual":
        return matrices.actual_matrix(processed, GRAVITY)
    return matrices.model_matrix(trial.plan, GRAVITY) if matrix == "model" else paper.printed_matrix(GRAVITY)


def solve(H: Array, processed: Processed) -> dict[str, float]:
    """Errors from one pass: the rows of the level with all weights equal, and the lengths of the specific force.

    The lengths, of single slopes, have half the variance of the changes. They and the columns of the accelerometer
    scale factors are the recorded ones for every matrix: (26), which a rough table upsets, would blur the comparison.
    """
    lengths, values = matrices.magnitude_rows(processed, _DOWN)
    level = np.hstack([H, matrices.scale_factor_columns(processed)])
    A = np.vstack([level, np.sqrt(2) * lengths])
    b = np.concatenate([processed.change, np.sqrt(2) * values])
    found = np.linalg.lstsq(A, b, rcond=None)[0]
    return dict(zip(PARAMETERS + _SCALE_FACTORS, found.tolist(), strict=True))


def iterate(
    trial: Trial,
    matrix: str = "actual",
    iterations: int = 8,
    *,
    starts: str | Array = "true",
    stored: DTypeLike = np.float64,
) -> tuple["DataFrame", Compensation]:
    """Plain iteration: whole steps, nothing refused, each step with its true error.

    Parameters
    ----------
    trial : Trial
        Recordings and truth.
    matrix : str, optional
        One of `MATRICES`.
    iterations : int, optional
        Number of passes; fewer if an element of the compensation leaves the unit matrix by more than `LOST`.
    starts : str or ndarray, optional
        Attitudes at the start: ``"true"``, or as in `calibrate`.
    stored : dtype, optional
        Precision in which the compensation is kept from one pass to the next.

    Returns
    -------
    log : DataFrame
        By iteration: ``rms_z`` before the correction, m/s^2; ``rms_m_a, rms_m_g, rms_b_a`` of the correction (fig. 5);
        ``angle``, rad, and ``scale_factor``, the largest true errors after it; and all true errors by name.
    Compensation
        The last one.
    """
    import pandas as pd

    prepared, compensation, rows = processing(trial, starts), Compensation(), []
    for _ in range(checks.integer("iterations", iterations, minimum=1)):
        processed = prepared.run(compensation)
        errors = solve(measurement_matrix(matrix, trial, processed), processed)
        compensation = _kept(compensation.corrected(errors), stored)
        moved = [getattr(compensation, f"{kind}_matrix") - np.eye(3) for kind in ("gyro", "accelerometer")]
        if not np.abs(moved).max() < LOST:
            break
        rows.append(_row(processed, errors, differences(compensation, trial.truth)))
    log = pd.DataFrame(rows, index=pd.RangeIndex(1, len(rows) + 1, name="iteration"))
    return log, compensation


def _kept(compensation: Compensation, stored: DTypeLike) -> Compensation:
    """Compensation rounded to a precision."""
    names = ("gyro_matrix", "gyro_bias", "accelerometer_matrix", "accelerometer_bias")
    return Compensation(**{name: getattr(compensation, name).astype(stored).astype(float) for name in names})


def _row(processed: Processed, errors: dict[str, float], true: dict[str, float]) -> dict[str, float]:
    def rms(*names: str) -> float:
        return float(np.sqrt(np.mean([errors[name] ** 2 for name in names])))

    return {
        "rms_z": float(np.sqrt(np.mean(processed.change**2))),
        "rms_m_a": rms(*PARAMETERS[:3]),
        "rms_m_g": rms(*PARAMETERS[3:12]),
        "rms_b_a": rms(*PARAMETERS[12:]),
        "angle": max(abs(true[name]) for name in ANGLES),
        "scale_factor": max(abs(true[f"m_{kind}_{i}{i}"]) for kind in "ag" for i in (1, 2, 3)),
    } | true


def step_matrix(trial: Trial, matrix: str) -> Array:
    """What one step leaves of small errors of all 18 parameters, near the truth: ``I - K H_true``, shape (18, 18).

    By central differences of a whole step: nothing of (12)-(19) is used but in the step itself.
    """
    prepared, truth = processing(trial), trial.truth.gauged()
    names, columns = PARAMETERS + _SCALE_FACTORS, []
    for name in names:
        step = 1e-5 if name[0] == "b" else 1e-6
        found = []
        for sign in (1, -1):
            processed = prepared.run(truth.corrected({name: -sign * step}))
            H = measurement_matrix(matrix, trial, processed)
            solved = solve(H, processed)
            found.append(np.array([solved[other] for other in names]))
        columns.append((found[0] - found[1]) / (2 * step))
    return np.eye(len(names)) - np.stack(columns, axis=-1)


def contraction(trial: Trial, matrix: str) -> float:
    """Factor by which the errors shrink in each iteration, in the end: spectral radius of `step_matrix`."""
    return float(np.abs(np.linalg.eigvals(step_matrix(trial, matrix))).max())


def settled(log: "DataFrame", iterations: int, end: "DataFrame | None" = None) -> float:
    """First iteration from which on no misalignment is further than `SETTLED` from the last; NaN if there is none.

    Parameters
    ----------
    log : DataFrame
        Of `iterate`.
    iterations : int
        Number that was asked for; a log that is shorter went astray.
    end : DataFrame, optional
        Log of another matrix at whose end this one has to be, too.
    """
    if len(log) < iterations:
        return np.nan
    angles = log[list(ANGLES)].to_numpy()
    last = angles[-1] if end is None else end[list(ANGLES)].to_numpy()[-1]
    far = np.flatnonzero(np.abs(angles - last).max(axis=1) > SETTLED)
    if far.size and far[-1] >= len(log) - 2:  # the last two must agree
        return np.nan
    return float(far[-1] + 2) if far.size else 1.0


def matrix_run(roughness: float, seed: int, iterations: int = 30) -> list[dict[str, float | str]]:
    """One table, one noisy unit, and its recordings calibrated with each of `MATRICES`: rows of `sweep`."""
    trial = Trial(seed=seed, roughness=roughness, noisy=True)
    rows, ends = [], {}
    for matrix in MATRICES:
        log, _ = iterate(trial, matrix, iterations)
        row = {"roughness": roughness, "seed": seed, "matrix": matrix, "contraction": contraction(trial, matrix)}
        row["settled"] = settled(log, iterations)
        done = not np.isnan(row["settled"])
        row["rms_z"] = log.rms_z.iloc[-1] if done else np.nan
        for number in (1, 2, 3, 4, 8, iterations):
            known = number <= len(log) and (done or number <= 8)
            row[f"angle_{number}"] = _rms_angle(log, number) if known else np.nan
        row["scale_factor"] = log.scale_factor.iloc[-1] if done else np.nan
        ends[matrix] = log[list(_FREE)].to_numpy()[-1] if done else np.full(len(_FREE), np.nan)
        row["apart"] = float(np.sqrt(np.mean((ends[matrix] - ends["actual"]) ** 2)))
        rows.append(row)
    return rows


def _rms_angle(log: "DataFrame", number: int) -> float:
    """Root of the mean square of the nine misalignments after an iteration, rad; three of the twelve are zero."""
    return float(np.sqrt((log.loc[number, list(_FREE)] ** 2).mean()))


def sweep(roughness: Sequence[float] = ROUGHNESS, seeds: Sequence[int] = range(SEEDS)) -> "DataFrame":
    """Runs of `matrix_run`, the content of ``klimkovich_matrices.csv``; about ten minutes.

    Returns
    -------
    DataFrame
        ``contraction`` near the truth; ``settled``, iterations; ``rms_z``, m/s^2, ``scale_factor`` and ``angle_30`` in
        the end, NaN if not settled; ``apart``, rad, root mean square distance of the misalignments from those that the
        matrix of the actual rotations ends at; ``angle_1`` to ``angle_8``, root mean square of the misalignments,
        rad, on the way.
    """
    import pandas as pd

    return pd.DataFrame([row for value in roughness for seed in seeds for row in matrix_run(value, seed)])


def scale_factors_of_a_tilted_base(tilt: float) -> dict[str, Array]:
    """Accelerometer scale factor errors, shape (3,), that are found in a perfect unit on a table whose base leans.

    Parameters
    ----------
    tilt : float
        Rotation of the base about east, rad.

    Returns
    -------
    dict of str to ndarray
        By (26), navigated from the model attitudes and from levelled ones, and by the lengths of the specific force.
    """
    trial = Trial(roughness=0, error=0, accelerometer_bias=0, table={"level_east": tilt})
    found = {}
    for name in ("model", "levelled"):
        processed = processing(trial, name).run(Compensation())
        pairs = [tests[0] for tests in matrices.upended(trial.plan).values()]
        found[name] = processed.slopes[pairs, :, 2].sum(axis=1) / (2 * GRAVITY)
    processed = processing(trial, "model").run(Compensation())
    solved = solve(measurement_matrix("actual", trial, processed), processed)
    return found | {"lengths": np.array([solved[name] for name in _SCALE_FACTORS])}


def stored() -> "DataFrame":
    """Rows of `sweep` that are kept."""
    import pandas as pd

    return pd.read_csv(claims_folder().parent / "derived" / "klimkovich_matrices.csv")


def floors(asymmetry: float = 1e-6, quadratic: float = 1e-5 / GRAVITY) -> dict[str, tuple[Trial, str | Array]]:
    """Trials and attitudes at the start that each leave one thing to set the floor of the iteration.

    Parameters
    ----------
    asymmetry : float, optional
        Of the gyros' scale factors.
    quadratic : float, optional
        Of the accelerometers, 1/(m/s^2): by default 10 ug/g^2.
    """
    still = Trial()
    case = np.stack([motion.C_b_n(0.0) for motion in still.motions])
    return {
        "nothing": (still, "true"),
        "attitude of the case": (still, case),
        "levelled start": (still, "levelled"),
        "model start": (still, "model"),
        "gyro bias": (Trial(gyro_bias=(paper.GYRO_BIAS_LEFT,) * 3), "true"),
        "gyro asymmetry": (VariedTrial(asymmetry=asymmetry), "true"),
        "quadratic accelerometers": (VariedTrial(quadratic=quadratic), "true"),
        "noise": (Trial(noisy=True), "true"),
    }
