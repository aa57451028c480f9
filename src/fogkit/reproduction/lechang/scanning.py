"""The thesis's first experiment: what a static scan about a level axis can say, and whether drift explains table 6.

Not stated are the latitude (taken as that of St Petersburg), the positions and the time in each: 12 positions one after
the other, 30 degrees apart, and a minute in each are assumed. Figures 14 to 16 are lost; `figure_readings` makes them
from table 6.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass.dwells import ANGLE_COLUMN
from fogkit.gyrocompass.frames import pyramid_axes
from fogkit.gyrocompass.scan import ScanFit, fit_scan, scan_readings
from fogkit.imu.tables import GYRO_COLUMNS
from fogkit.noise import RandomErrors, simulate
from fogkit.noise.covariance import mean_covariance
from fogkit.reproduction.lechang import paper
from fogkit.units import DEG

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

POSITIONS = 12
DWELL = 60.0
TURN = 4.0
"""Time from one position to the next, s."""

DATA_SHEET_SCALES = paper.DATA_SHEET_SCALE * np.sign(paper.STAND_SCALES)
PARAMETERS = ("mean_x", "mean_y", "mean_z", "scale_x", "scale_y", "scale_z", "sine")


def angles(positions: int = POSITIONS) -> Array:
    """Angles of a turn in equal parts, rad, shape (positions,)."""
    return 2 * np.pi * np.arange(positions) / positions


def figure_readings(at: ArrayLike) -> Array:
    """Figures 14 to 16: readings of the gyros x, y, z at angles about the outer axis, V, by table 6: shape (n, 3)."""
    return scan_readings(at, paper.STAND_HEADING, paper.ASSUMED_LATITUDE, paper.STAND_SCALES, paper.STAND_BIASES)


def amplitudes() -> Array:
    """Half of peak to peak of figures 14 to 16, V, shape (3,)."""
    return np.ptp(figure_readings(angles(3600)), axis=0) / 2


def other_heading() -> ScanFit:
    """Fit to readings made of table 6: its numbers come back, with a second heading and other biases."""
    return fit_scan(angles(), figure_readings(angles()), paper.ASSUMED_LATITUDE, standard_deviation=1e-6)


def design(scales: ArrayLike, sine: float, positions: int = POSITIONS) -> Array:
    """Derivatives of all readings, position after position, by `PARAMETERS` (V, V/(rad/s), 1): (3 positions, 7)."""
    scales, at, lat = np.asarray(scales, dtype=float), angles(positions), paper.ASSUMED_LATITUDE
    still = scan_readings(at, 0.0, lat) - EARTH_RATE * np.cos(lat) * pyramid_axes()[0]
    east = (
        scan_readings(at, -np.pi / 2, lat) - scan_readings(at, 0.0, lat) + EARTH_RATE * np.cos(lat) * pyramid_axes()[0]
    )
    D = np.zeros((positions, 3, 7))
    for g in range(3):
        D[:, g, g], D[:, g, 3 + g] = 1.0, still[:, g] - sine * east[:, g]
        D[:, g, 6] = -scales[g] * east[:, g]
    return D.reshape(-1, 7)


def scatter(errors: RandomErrors, dwell: float = DWELL, positions: int = POSITIONS) -> dict[str, Array]:
    """Standard deviations of a scan's results with gyros of random errors, by propagation through least squares.

    Parameters
    ----------
    errors : RandomErrors
        Of each gyro, the gyros independent; a level of its own (a constant bias) is no error of the scan.
    dwell : float, optional
        Time in each position, s.
    positions : int, optional
        How many.

    Returns
    -------
    dict
        ``heading``, rad, shape (); ``scale``, relative, and ``bias``, rad/s, with the right heading: shape (3,).
    """
    scales, heading = DATA_SHEET_SCALES, paper.STAND_HEADING
    sine = np.sin(heading)
    gain = np.linalg.pinv(design(scales, sine, positions))
    start = (dwell + TURN) * np.arange(positions)
    one = mean_covariance(errors, start, start + dwell, 0.01)
    full = np.kron(one, np.diag(scales**2))
    P = gain @ full @ gain.T
    # bias = mean/scale - level cos(heading) axis, with d cos = -tan d sine
    level = EARTH_RATE * np.cos(paper.ASSUMED_LATITUDE)
    to_bias = np.hstack(
        [np.diag(1 / scales), np.zeros((3, 3)), level * np.tan(heading) * pyramid_axes()[0][:, np.newaxis]]
    )
    return {
        "heading": np.sqrt(P[6, 6]) / abs(np.cos(heading)),
        "scale": np.sqrt(np.diag(P)[3:6]) / np.abs(scales),
        "bias": np.sqrt(np.diag(to_bias @ P @ to_bias.T)),
    }


def ramps_needed(positions: int = POSITIONS) -> tuple[float, Array, float]:
    """Linear drifts without which no scan of gyros with the data sheet's scale factors returns table 6.

    Parameters
    ----------
    positions : int, optional
        Positions of the scan, one after the other.

    Returns
    -------
    heading_sine : float
        Sine of the true heading that goes with them; no heading has one beyond 1.
    drift : ndarray, shape (3,)
        Change of the gyros' biases from the first position to the last, rad/s.
    residual : float
        Root mean square of the fit's residuals over the largest amplitude of a figure.

    Notes
    -----
    Where least squares ends residuals are orthogonal to all derivatives there. Readings are linear in the drifts and in
    the sine: four linear equations, for three scale factors and the printed heading. They are necessary: where
    residuals are large the sum of squares may be less elsewhere.
    """
    printed_sine = np.sin(paper.STAND_HEADING)
    D = design(paper.STAND_SCALES, printed_sine, positions)
    ones = np.kron(np.ones((positions, 1)), np.eye(3))
    ramp = np.kron((np.arange(positions) / (positions - 1) - 0.5)[:, np.newaxis], np.diag(DATA_SHEET_SCALES))
    true = design(DATA_SHEET_SCALES, 0.0, positions)
    fixed = true[:, 3:6] @ DATA_SHEET_SCALES - D[:, 3:6] @ paper.STAND_SCALES
    columns = np.column_stack([true[:, 6], ramp])

    def free(values: Array) -> Array:  # of the means
        return values - ones @ np.linalg.lstsq(ones, values)[0]

    tested = free(D[:, 3:])
    found = np.linalg.solve(tested.T @ columns, -tested.T @ fixed)
    left = free(fixed + columns @ found)
    return float(found[0]), found[1:], float(np.sqrt(np.mean(left**2)) / amplitudes().max())


def recording(
    rng: np.random.Generator,
    errors: RandomErrors,
    *,
    dwell: float = DWELL,
    positions: int = POSITIONS,
    dt: float = 0.1,
    scales: ArrayLike = paper.STAND_SCALES,
    biases: ArrayLike = paper.STAND_BIASES,
) -> "DataFrame":
    """Raw record of the scan, as `fogkit.gyrocompass.dwells.find_dwells` takes it.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of the noise.
    errors : RandomErrors
        Of each gyro, with ramps alike.
    dwell, dt : float, optional
        Time in each position and between samples, s.
    positions : int, optional
        How many.
    scales, biases : array_like, shape (3,), optional
        V/(rad/s), rad/s.

    Returns
    -------
    DataFrame
        Index ``time``, s; angle, rad; readings, V.
    """
    import pandas as pd

    stay, way = round(dwell / dt), round(TURN / dt)
    time = dt * np.arange(positions * (stay + way) - way)
    part = (time / dt + 0.5).astype(int)
    place, inside = np.divmod(part, stay + way)
    step, turning = 2 * np.pi / positions, inside >= stay
    at = step * (place + np.where(turning, (inside - stay + 1) / (way + 1), 0.0))
    rate = scan_readings(at, paper.STAND_HEADING, paper.ASSUMED_LATITUDE, biases=biases)
    rate += simulate(errors, len(time), dt, rng, channels=3)
    rate += np.where(turning, step / ((way + 1) * dt), 0.0)[:, np.newaxis] * pyramid_axes()[0]
    table = pd.DataFrame(rate * np.asarray(scales), index=pd.Index(time, name="time"), columns=list(GYRO_COLUMNS))
    table.insert(0, ANGLE_COLUMN, at)
    return table


def scans(seeds: ArrayLike, errors: RandomErrors, drift: int = 0, dwell: float = DWELL) -> "DataFrame":
    """Results of simulated scans, one to a row: heading of the right branch, deg, scales over those of table 6.

    Dwell means are drawn from simulated errors a second apart; `drift` is the degree of what the fit allows.
    """
    import pandas as pd

    clean, rows = figure_readings(angles()), []
    stay, way = round(dwell), round(TURN)
    time = (stay + way) * np.arange(POSITIONS) + 0.5 * dwell
    for seed in np.asarray(seeds):
        noise = simulate(errors, POSITIONS * (stay + way), 1.0, np.random.default_rng(int(seed)), channels=3)
        means = noise.reshape(POSITIONS, stay + way, 3)[:, :stay].mean(axis=1)
        fit = fit_scan(
            angles(),
            clean + means * paper.STAND_SCALES,
            paper.ASSUMED_LATITUDE,
            time=time if drift else None,
            drift=drift,
        )
        right = int(np.argmin(np.abs(fit.headings - paper.STAND_HEADING)))
        ratio = fit.scales / paper.STAND_SCALES
        rows.append([fit.headings[right] / DEG, *ratio, *fit.biases[right]])
    names = ["heading", *(f"scale_{g}" for g in "xyz"), *(f"bias_{g}" for g in "xyz")]
    return pd.DataFrame(rows, columns=names)


def digitiser_error(bits: int, bandwidth: float = 100.0) -> float:
    """Largest error of a long mean that a digitiser makes, V, its input a steady voltage with noise of the data sheet.

    Parameters
    ----------
    bits : int
        Of a digitiser whose span is the gyro's: data sheet's range times scale factor, either way.
    bandwidth : float, optional
        Of the noise, Hz; its density is taken as one-sided, the deviation of a sample as density times square root.

    Returns
    -------
    float
        ``step/pi exp(-2 (pi deviation/step)**2)``, the first harmonic of the sawtooth that noise has smoothed; if noise
        is much less than a step the sawtooth itself has half a step.
    """
    step = 2 * paper.GYRO_RANGE * paper.DATA_SHEET_SCALE / 2**bits
    deviation = paper.DATA_SHEET_NOISE * np.sqrt(bandwidth)
    return float(step / np.pi * np.exp(-2 * (np.pi * deviation / step) ** 2))


def drift_of_scale(gyro: int) -> float:
    """Drift of once per scan, its amplitude in rad/s, that would turn the data sheet's scale factor into table 6's."""
    printed, ours = np.abs(paper.STAND_SCALES[gyro]), paper.DATA_SHEET_SCALE
    rate = amplitudes()[gyro] / printed  # of the Earth, rad/s
    return float(abs(printed - ours) / ours * rate)
