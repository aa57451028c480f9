"""From the raw record of a scan to its readings: which samples belong to a position, and what their means are.

A gyro is turned to an angle, held there, turned on. What it says while it turns is no reading of the Earth rate: a
tolerance of 0.01 degrees in the angle of a minute's dwell is 0.6 deg/h. So the beginning and the end of each dwell are
cut.
"""

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.gyrocompass.laws import LARGEST_AMPLITUDE
from fogkit.gyrocompass.scan import ScanFit, fit_scan
from fogkit.gyrocompass.tables import check_index
from fogkit.imu.tables import GYRO_COLUMNS
from fogkit.units import ARCMIN

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

ANGLE_COLUMN = "angle"


@dataclass(frozen=True, kw_only=True)
class Dwells:
    """Mean readings of three gyros at the positions of a scan.

    Attributes
    ----------
    angle : ndarray, shape (m,)
        Mean angle of each dwell, rad.
    reading : ndarray, shape (m, 3)
        Mean readings, in the unit of the record.
    time : ndarray, shape (m,)
        Middle of the samples that were used, s.
    duration : ndarray, shape (m,)
        Length of these, s.
    scatter : ndarray, shape (m, 3)
        Standard deviations of the means if samples are independent: those of the samples over ``sqrt(samples)``.
    unused : float
        Share of the record's samples that are in no mean: turns, cut ends, dwells too short.
    """

    angle: Array
    reading: Array
    time: Array
    duration: Array
    scatter: Array
    unused: float

    def fit(
        self, lat: float, *, noise: ArrayLike | None = None, drift: int = 0, axes: ArrayLike | None = None
    ) -> ScanFit:
        """Heading, scale factors and biases from the means (`fogkit.gyrocompass.scan.fit_scan`).

        Parameters
        ----------
        lat : float
            Latitude, rad.
        noise : array_like, shape () or (3,), optional
            White noise of the gyros in units of the reading times ``sqrt(s)``, from a two-sided spectrum: a mean over T
            then has the standard deviation ``noise/sqrt(T)``, and chi-square tests the model. Without it means have
            weights in proportion to their time, and the residuals give the level.
        drift : int, optional
            Degree of the polynomial of time by which each gyro's mean drifts; 0 for none.
        axes : array_like, shape (3, 3), optional
            Input axes in columns: forward, along the axis of the turns; up; starboard. The pyramid's if not given.

        Returns
        -------
        ScanFit
            Both headings that the readings allow, and what goes with them.
        """
        density = 1.0 if noise is None else checks.finite_array("noise", noise)
        if np.shape(density) not in ((), (3,)) or not np.all(np.greater(density, 0)):
            raise ValueError(f"`noise` must be one number or three, above 0, got {noise!r}")
        deviation = density / np.sqrt(self.duration)[:, np.newaxis] * np.ones(3)
        return fit_scan(
            self.angle,
            self.reading,
            lat,
            axes=axes,
            time=self.time if drift else None,
            drift=drift,
            standard_deviation=deviation,
            scale="estimated" if noise is None else "given",
        )

    def to_frame(self) -> "DataFrame":
        """Table of the dwells, index ``time`` in s."""
        import pandas as pd

        columns = {"angle": self.angle, "duration": self.duration}
        columns |= dict(zip(GYRO_COLUMNS, self.reading.T, strict=True))
        columns |= {f"{name}_std": values for name, values in zip(GYRO_COLUMNS, self.scatter.T, strict=True)}
        return pd.DataFrame(columns, index=pd.Index(self.time, name="time"))


def find_dwells(
    table: "DataFrame",
    *,
    settling: float = 2.0,
    guard: float = 1.0,
    shortest: float = 5.0,
    tolerance: float = 1 * ARCMIN,
    columns: tuple[str, str, str] = GYRO_COLUMNS,
    angle: str = ANGLE_COLUMN,
) -> Dwells:
    """Mean readings at the positions of a scan, from its samples.

    Parameters
    ----------
    table : DataFrame
        Index time, s, ascending; columns of the angle about the axis, rad, and of the readings of three gyros, in volts
        or rad/s: scale factors then come out in V/(rad/s) or without unit.
    settling, guard : float, optional
        Time cut from the beginning and from the end of each dwell, s: what the gyro needs to settle, and what the turn
        takes to leave `tolerance`.
    shortest : float, optional
        Least time that must be left of a dwell, s; shorter ones are left out.
    tolerance : float, optional
        Largest departure of the angle from that of the dwell's first sample, rad: more than the angle sensor's noise.
    columns : tuple of str, optional
        Names of the readings of gyros x, y, z: ``("voltage_x", "voltage_y", "voltage_z")``, say.
    angle : str, optional
        Name of the angle.

    Returns
    -------
    Dwells
        In the order of time.

    Raises
    ------
    ValueError
        If a column is missing, an entry is not finite, an angle beyond 10 turns (degrees?), time does not ascend or is
        no index, or nothing stands still for long enough.

    Warns
    -----
    UserWarning
        If samples are missing within a dwell: it is then taken as two.
    """
    columns = tuple(columns)
    if len(columns) != 3:
        raise ValueError(f"`columns` must name the readings of three gyros, got {columns!r}")
    check_index(checks.columns(table, (angle, *columns)))
    settling, guard = (checks.non_negative(n, v, "s") for n, v in (("settling", settling), ("guard", guard)))
    shortest, tolerance = checks.positive("shortest", shortest, "s"), checks.positive("tolerance", tolerance, "rad")
    time = checks.finite_array("table.index", table.index.to_numpy(), shape=(None,), min_size=2)
    if not (np.diff(time) > 0).all():
        at = int(np.argmin(np.diff(time)))
        raise ValueError(f"`table.index` must ascend, got {time[at + 1]:g} s after {time[at]:g} s")
    turned = checks.finite_array(f"table[{angle!r}]", table[angle].to_numpy())
    fix = "Multiply degrees by `fogkit.units.DEG`."
    checks.in_closed_interval(f"table[{angle!r}]", np.abs(turned).max(), 0.0, LARGEST_AMPLITUDE, "rad", fix=fix)
    readings = checks.finite_array("readings", table[list(columns)].to_numpy())

    step = float(np.median(np.diff(time)))
    runs = []
    for begin, end in _still(turned, tolerance):
        gaps = np.flatnonzero(np.diff(time[begin:end]) > 1.5 * step) + begin + 1
        runs += zip([begin, *gaps], [*gaps, end], strict=True)
        if len(gaps) and time[end - 1] - time[begin] >= shortest:
            warnings.warn(
                f"samples are missing in a dwell, {len(gaps)} times, first after {time[gaps[0] - 1]:g} s: each part is "
                "taken as a dwell of its own",
                UserWarning,
                stacklevel=2,
            )
    kept = []
    for begin, end in runs:
        low = np.searchsorted(time, time[begin] + settling - 1e-6 * step)
        high = np.searchsorted(time, time[end - 1] - guard + 1e-6 * step, side="right")
        if high - low >= 2 and (high - low) * step >= shortest:
            kept.append(slice(int(low), int(high)))
    if not kept:
        raise ValueError(
            f"`table` must hold dwells of {settling + guard + shortest:g} s at least (settling, guard and shortest), "
            f"got none whose angle stays within {tolerance:.3g} rad. Is `tolerance` above the noise of the angle?"
        )
    counts = np.array([part.stop - part.start for part in kept])
    return Dwells(
        angle=np.array([turned[part].mean() for part in kept]),
        reading=np.array([readings[part].mean(axis=0) for part in kept]),
        time=np.array([time[part].mean() for part in kept]),
        duration=counts * step,
        scatter=np.array([readings[part].std(axis=0, ddof=1) for part in kept]) / np.sqrt(counts)[:, np.newaxis],
        unused=float(1 - counts.sum() / len(time)),
    )


def _still(angle: Array, tolerance: float, block: int = 1024) -> list[tuple[int, int]]:
    """Runs of samples whose angle stays within the tolerance of the run's first."""
    runs, begin = [], 0
    while begin < len(angle):
        end = begin + 1
        while end < len(angle):
            away = np.abs(angle[end : end + block] - angle[begin]) > tolerance
            if away.any():
                end += int(np.argmax(away))
                break
            end += len(away)
        runs.append((begin, end))
        begin = end
    return runs
