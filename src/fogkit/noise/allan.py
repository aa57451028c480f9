"""Allan deviation of a record, with its error bars.

The estimator is the overlapping one [1]_: with the angle ``theta`` at the ends of n samples, for an averaging factor m

``AVAR(m dt) = sum_k (theta[k + 2m] - 2 theta[k + m] + theta[k])**2 / (2 (m dt)**2 (n - 2m + 1))``.

Its scatter is that of a chi-square number whose degrees of freedom, for given processes, are exact
(`fogkit.noise.covariance`); only the chi-square shape is an approximation.

References
----------
.. [1] W. J. Riley, Handbook of Frequency Stability Analysis, NIST Special Publication 1065 (2008), section 5.2.4; IEEE
   Std 952-2020, annex C.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.noise._records import ArrayRecord
from fogkit.noise.covariance import checked_factors, equivalent_degrees_of_freedom
from fogkit.noise.processes import RandomErrors

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

TIME_TOLERANCE = 1e-3
"""Largest departure of a sample's time from an even spacing, in sampling times: a rounded time stamp passes."""

TIME_INDEX = "The index is the time, s; of time stamps take `(index - index[0]).total_seconds()`."

BY_SLOPE = {-2: "quantization", -1: "angle_random_walk", 0: "bias_instability", 1: "rate_random_walk"}
"""Process that has a power of the averaging time in its Allan variance; a steeper rise counts as a random walk."""


@dataclass(frozen=True, kw_only=True, eq=False)
class AllanDeviation(ArrayRecord):
    """Overlapping Allan deviation of one record, of one or several channels.

    Attributes
    ----------
    tau : ndarray, shape (j,)
        Averaging times, s.
    deviation : ndarray, shape (j,) or (j, channels)
        Allan deviation, rad/s.
    factors : ndarray of int, shape (j,)
        Averaging factors m.
    differences : ndarray of int, shape (j,)
        Second differences in each average, ``count - 2 m + 1``; as they overlap, far from independent.
    count : int
        Samples of the record.
    dt : float
        Sampling time, s.
    """

    tau: Array
    deviation: Array
    factors: NDArray[np.int64]
    differences: NDArray[np.int64]
    count: int
    dt: float

    @property
    def variance(self) -> Array:
        """Allan variance, (rad/s)^2, of the shape of `deviation`."""
        return self.deviation**2

    @property
    def duration(self) -> float:
        """Length of the record, s."""
        return self.count * self.dt

    def channel(self, index: int) -> AllanDeviation:
        """Allan deviation of one of several channels."""
        if self.deviation.ndim == 1:
            raise ValueError(f"`index` must not be given for an Allan deviation of one channel, got {index}")
        values = {name: getattr(self, name) for name in ("tau", "factors", "differences", "count", "dt")}
        return AllanDeviation(deviation=self.deviation[:, checks.integer("index", index, minimum=0)], **values)

    def degrees_of_freedom(self, errors: RandomErrors | None = None) -> Array:
        """Equivalent degrees of freedom of each Allan variance, of the shape of `deviation`.

        Parameters
        ----------
        errors : RandomErrors, optional
            What the record holds, from `fogkit.noise.identify` say: the result is exact for it. Without, each value is
            that of the one process whose power of the averaging time is nearest to the local slope.
        """
        if errors is not None:
            exact = equivalent_degrees_of_freedom(errors, self.factors, self.count, self.dt)
            return np.broadcast_to(exact.reshape(-1, *[1] * (self.deviation.ndim - 1)), self.deviation.shape)
        pure = {
            power: equivalent_degrees_of_freedom(RandomErrors(**{name: 1.0}), self.factors, self.count, self.dt)
            for power, name in BY_SLOPE.items()
        }
        nearest = np.clip(np.rint(self._slopes()), -2, 1)
        # what looks like quantization beyond a flatter part is a chance, and its many degrees of freedom are not there
        nearest = np.where(np.logical_or.accumulate(nearest > -2, axis=0), np.maximum(nearest, -1), nearest)
        pure = {p: v.reshape(-1, *[1] * (self.deviation.ndim - 1)) for p, v in pure.items()}
        return np.select([nearest == power for power in pure], list(pure.values()))

    def interval(self, level: float = 0.95, errors: RandomErrors | None = None) -> tuple[Array, Array]:
        """Confidence interval of the Allan deviation at each averaging time by itself.

        Parameters
        ----------
        level : float, optional
            Probability inside; what is outside is split evenly.
        errors : RandomErrors, optional
            As in `degrees_of_freedom`.

        Returns
        -------
        low, high : ndarray
            Bounds, rad/s, of the shape of `deviation`: ``deviation * sqrt(f / chi2)`` with f degrees of freedom.

        Examples
        --------
        >>> from fogkit.noise import simulate
        >>> rate = simulate(RandomErrors(angle_random_walk=1.0), 1000, 1.0, np.random.default_rng(1))
        >>> low, high = allan_deviation(rate, 1.0, averaging=[1, 100]).interval(0.95)
        >>> (high / low).round(2)
        array([1.11, 2.24])
        """
        from scipy.special import gammainccinv, gammaincinv  # loaded where used

        tail = (1 - checks.in_open_interval("level", level, 0, 1)) / 2
        half = self.degrees_of_freedom(errors) / 2
        with np.errstate(invalid="ignore"):
            bounds = [np.sqrt(half / inverse(half, tail)) for inverse in (gammainccinv, gammaincinv)]
        low, high = (self.deviation * np.where(np.isfinite(half), bound, 1.0) for bound in bounds)
        return low, high

    def to_frame(self, level: float = 0.95) -> pd.DataFrame:
        """Table with the index ``tau`` and, for each channel, the columns `deviation`, `low`, `high`."""
        import pandas as pd  # loaded where used

        low, high = self.interval(level)
        columns: dict[str, Any] = {"factor": self.factors, "differences": self.differences}
        if self.deviation.ndim == 1:
            columns |= {"deviation": self.deviation, "low": low, "high": high}
        for i in range(self.deviation.shape[1] if self.deviation.ndim == 2 else 0):
            columns |= {f"deviation_{i}": self.deviation[:, i], f"low_{i}": low[:, i], f"high_{i}": high[:, i]}
        return pd.DataFrame(columns, index=pd.Index(self.tau, name="tau"))

    def _slopes(self) -> Array:
        """Power of the averaging time that the variance follows about each point, of the shape of `deviation`."""
        if len(self.tau) == 1:
            return np.full(self.deviation.shape, -1.0)  # nothing to tell it by: as for white noise
        logarithm = np.log(np.maximum(self.variance, np.finfo(float).tiny))
        step = np.diff(np.log(self.tau)).reshape(-1, *[1] * (self.deviation.ndim - 1))
        between = np.diff(logarithm, axis=0) / step
        return (np.concatenate([between[:1], between]) + np.concatenate([between, between[-1:]])) / 2


def allan_deviation(
    rate: ArrayLike | pd.Series | pd.DataFrame, dt: float | None = None, *, averaging: str | ArrayLike = "octave"
) -> AllanDeviation:
    """Overlapping Allan deviation of a record.

    Parameters
    ----------
    rate : array_like, shape (n,) or (n, channels), or pandas Series or DataFrame
        Mean rate over each sample, rad/s. The index of a table is the time, s.
    dt : float, optional
        Sampling time, s. Needed for an array; for a table it follows from the index.
    averaging : "octave" or array_like of int, optional
        Averaging factors, increasing; "octave" is all powers of two up to half of the record.

    Returns
    -------
    AllanDeviation
        Averaging times, deviations and, on demand, their confidence intervals.

    Raises
    ------
    ValueError
        If the record holds a NaN, is sampled unevenly, too short for an averaging factor, or constant (which a sensor
        is not: frozen).

    Examples
    --------
    >>> allan_deviation([1.0, 2.0, 4.0, 3.0], dt=0.5, averaging=[1, 2]).deviation.round(4)
    array([1.    , 1.4142])
    """
    values, dt = record(rate, dt)
    count = len(values)
    factors = octaves(count) if isinstance(averaging, str) else checked_factors(averaging, count, "averaging")
    if isinstance(averaging, str):
        checks.option("averaging", averaging, ("octave",))
    variance = np.stack([_variances(column, factors) for column in values.reshape(count, -1).T], axis=1)
    m = np.array(factors)
    return AllanDeviation(
        tau=m * dt,
        deviation=np.sqrt(variance).reshape(len(m), *values.shape[1:]),
        factors=m,
        differences=count - 2 * m + 1,
        count=count,
        dt=dt,
    )


def octaves(count: int) -> tuple[int, ...]:
    """Powers of two up to half of a number of samples."""
    return tuple(1 << k for k in range((count // 2).bit_length()))


def record(rate: Any, dt: float | None) -> tuple[Array, float]:
    """Checked readings, shape (n,) or (n, channels), and sampling time, from an array or a table."""
    if hasattr(rate, "index") and hasattr(rate, "to_numpy"):
        spacing = _spacing(rate.index.to_numpy())
        if dt is not None and abs(checks.positive("dt", dt, "s") / spacing - 1) > TIME_TOLERANCE:
            raise ValueError(f"`dt` must be the spacing of the index of `rate`, {spacing:g} s, got {dt:g}")
        dt, rate = spacing, rate.to_numpy()
    if dt is None:
        raise ValueError("`dt` must be given for an array, got None. A table with the time as index needs none.")
    dt = checks.positive("dt", dt, "s")
    values = checks.finite_array("rate", rate)
    if values.ndim not in (1, 2):
        raise ValueError(f"`rate` must be of shape (n,) or (n, channels), got {values.shape}")
    if len(values) < 2:
        raise ValueError(f"`rate` must have at least 2 samples, got {len(values)}")
    frozen = np.atleast_1d(values.max(axis=0) == values.min(axis=0))
    if frozen.any():
        channel = f" in channel {int(np.argmax(frozen))}" if values.ndim == 2 else ""
        value = values[0, np.argmax(frozen)] if values.ndim == 2 else values[0]
        raise ValueError(f"`rate` must vary, got {value:g} in all {len(values)} samples{channel}: a frozen sensor?")
    return values, dt


def _spacing(time: NDArray) -> float:
    """Sampling time of evenly spaced times."""
    time = checks.finite_array("rate.index", time, ndim=1, min_size=2, fix=TIME_INDEX)
    spacing = (time[-1] - time[0]) / (time.size - 1)
    wrong = np.abs(np.diff(time) - spacing) > TIME_TOLERANCE * abs(spacing)
    if wrong.any() or not spacing > 0:
        usual = np.median(np.diff(time))
        at = int(np.argmax(np.abs(np.diff(time) - usual)))
        raise ValueError(
            f"`rate` must be sampled evenly, got {time[at + 1] - time[at]:g} s after t = {time[at]:g} s "
            f"(sample {at}) where {usual:g} s is usual"
        )
    return float(spacing)


def _variances(rate: Array, factors: tuple[int, ...]) -> Array:
    """Allan variances of one channel."""
    from fogkit.noise import _kernels  # compiled: loaded where used

    angle = np.empty(rate.size + 1)
    _kernels.angle(np.ascontiguousarray(rate), rate.mean(), angle)
    return np.array([_kernels.second_difference_power(angle, m) / (2.0 * m**2) for m in factors])
