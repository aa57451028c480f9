"""Rates of temperature from sampled, noisy temperatures: slopes over a window, never differences of samples.

A difference of two samples has the noise ``sqrt(2) sigma / dt``; the slope of a line through ``m`` samples has
``sqrt(12 / (m (m**2 - 1))) sigma / dt``, for 30 samples 67 times less. The slope is the mean of the true rate over the
window with the weight of a parabola, so it lags or smooths, and this is stated with it.

For a fit use `reduce`: it takes every other column through the same parabola, so that a relation which is linear in
temperatures and rates stays exact whatever the window, and its windows do not overlap, so that white noise stays white.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks

if TYPE_CHECKING:
    from pandas import DataFrame

TEMPERATURE, RATE = "temperature_", "rate_"
"""Prefixes of the columns of temperatures, degC, and of their rates, K/s; what follows is the measuring point."""

_TIMING = 1e-6  # relative spread of sampling intervals that counts as equal: rounding of times written with 7 digits


def sampling_interval(table: DataFrame, name: str = "table") -> float:
    """Interval between the rows of a table, s, from its index; ``ValueError`` if there is more than one."""
    time = checks.finite_array(f"{name}.index", table.index.to_numpy(), ndim=1, min_size=2)
    gaps = np.diff(time)
    interval = float((time[-1] - time[0]) / gaps.size)
    if not np.abs(gaps - interval).max() <= _TIMING * abs(time).max() or interval <= 0:
        at = int(np.argmax(np.abs(gaps - interval)))
        raise ValueError(
            f"`{name}` must be equally sampled with time increasing, got {gaps[at]:g} s after row {at} where the mean "
            f"interval is {interval:g} s. Interpolate to equal times first."
        )
    return interval


@dataclass(frozen=True, kw_only=True)
class RateFilter:
    """Running estimator of a rate: derivative of a polynomial fitted to the samples of a window.

    Parameters
    ----------
    window : float
        Duration that the polynomial is fitted to, s.
    degree : int, optional
        Degree of the polynomial.
    causal : bool, optional
        Whether the rate is taken at the end of the window, for use in real time, instead of at its middle.

    Notes
    -----
    Centred, degrees 1 and 2 give the same estimator (Savitzky-Golay) without delay; causal, degree 1 has the same
    noise and a delay of half the window, degree 2 no delay for parabolas and nearly four times the noise.
    """

    window: float
    degree: int = 1
    causal: bool = False

    def __post_init__(self) -> None:
        checks.positive("window", self.window, "s")
        checks.integer("degree", self.degree, minimum=1)

    def samples(self, interval: float) -> int:
        """Samples in the window, odd if it is centred."""
        count = round(self.window / checks.positive("interval", interval, "s"))
        count += not self.causal and count % 2 == 0
        if count <= self.degree:
            needed = self.degree * interval
            raise ValueError(f"`window` must be longer than {needed:g} s for degree {self.degree}, got {self.window} s")
        return count

    def weights(self, interval: float) -> NDArray[np.float64]:
        """Weights of the samples of a window, the oldest first, 1/s; the rate is their sum with the temperatures."""
        m = self.samples(interval)
        at = (np.arange(m) - (m - 1 if self.causal else (m - 1) / 2)) / m  # scaled for the condition of the fit
        return np.linalg.pinv(np.vander(at, self.degree + 1, increasing=True))[1] / (m * interval)

    def noise_gain(self, interval: float) -> float:
        """Standard deviation of the rate per standard deviation of independent noise of the samples, 1/s."""
        return float(np.sqrt((self.weights(interval) ** 2).sum()))

    def delay(self, interval: float) -> float:
        """Delay for a temperature that is a parabola in time, s."""
        m = self.samples(interval)
        age = interval * (m - 1 - np.arange(m) if self.causal else (m - 1) / 2 - np.arange(m))
        return float(-(self.weights(interval) * age**2).sum() / 2)

    def apply(self, values: ArrayLike, interval: float) -> NDArray[np.float64]:
        """Rates of a series, shape (n,), 1/s of its unit; NaN where the window is not full."""
        values = checks.finite_array("values", values, ndim=1)
        weights = self.weights(interval)
        rates = np.full(values.size, np.nan)
        if values.size < weights.size:
            raise ValueError(f"`values` must fill the window of {weights.size} samples, got {values.size}")
        first = weights.size - 1 if self.causal else weights.size // 2
        full = np.convolve(values - values[0], weights[::-1], mode="valid")  # the mean has no rate: keep digits
        rates[first : first + full.size] = full
        return rates


def add_rates(table: DataFrame, rate_filter: RateFilter) -> DataFrame:
    """Table with a column ``rate_*`` for every ``temperature_*``, without the rows in which the window is not full."""
    interval = sampling_interval(table)
    rates = {}
    for column in _temperatures(table):
        values = checks.finite_array(column, table[column].to_numpy())
        rates[RATE + column.removeprefix(TEMPERATURE)] = rate_filter.apply(values, interval)
    table = table.assign(**rates)
    return table[table[next(iter(rates))].notna()]


def reduce(table: DataFrame, window: float) -> DataFrame:
    """Table with one row for each of the windows that follow one another: rates as slopes, the rest as weighted means.

    Parameters
    ----------
    table : pandas.DataFrame
        Equally sampled, index time in s; columns ``temperature_*`` get a ``rate_*``, K/s. All columns are numbers.
    window : float
        Duration of a window, s, of at least three samples. What is left at the end is not used.

    Returns
    -------
    pandas.DataFrame
        Index: time of the middle of each window, s.

    Notes
    -----
    The least-squares slope of m samples is a mean of the m - 1 rates between samples with weights ``k (m - k)``. With
    the same weights a sample k counts ``k (m - k) + (k + 1)(m - k - 1)``: these are the weights of the means here.
    White noise keeps the share `mean_noise_gain` of its standard deviation, 1.095 / sqrt(m) for large m.
    """
    interval = sampling_interval(table)
    m = round(checks.positive("window", window, "s") / interval)
    if m < 3 or m > len(table):
        raise ValueError(
            f"`window` must hold 3 to {len(table)} samples of {interval:g} s, got {window:g} s, which holds {m}"
        )
    values = {c: checks.finite_array(c, table[c].to_numpy()) for c in table.columns}
    count = len(table) // m
    cut = {c: v[: count * m].reshape(count, m) for c, v in values.items()}
    slope = RateFilter(window=m * interval, causal=True).weights(interval)
    mean = mean_weights(m)
    reduced = {c: v @ mean for c, v in cut.items()}
    for column in _temperatures(table):
        rows = cut[column]
        reduced[RATE + column.removeprefix(TEMPERATURE)] = (rows - rows[:, :1]) @ slope
    time = table.index.to_numpy(float)[: count * m].reshape(count, m).mean(axis=1)
    return type(table)(reduced, index=time).rename_axis(table.index.name)


def mean_weights(samples: int) -> NDArray[np.float64]:
    """Weights of the samples in the means of `reduce`, of sum 1, shape (samples,)."""
    k = np.arange(samples + 1.0)
    between = k * (samples - k)
    weights = between[:-1] + between[1:]
    return weights / weights.sum()


def mean_noise_gain(samples: int) -> float:
    """Standard deviation of a mean of `reduce` per standard deviation of independent noise of its samples."""
    return float(np.sqrt((mean_weights(samples) ** 2).sum()))


def row_noise(deviation: float, interval: float, window: float) -> tuple[float, float]:
    """Standard deviations of temperatures, K, and rates, K/s, in the rows of `reduce`, from that of a sample, K."""
    deviation = checks.non_negative("deviation", deviation, "K")
    rate_filter = RateFilter(window=window, causal=True)
    samples = rate_filter.samples(interval)
    return deviation * mean_noise_gain(samples), deviation * rate_filter.noise_gain(interval)


def _temperatures(table: DataFrame) -> list[str]:
    """Columns of temperatures; an error if there is none."""
    found = [column for column in table.columns if str(column).startswith(TEMPERATURE)]
    if not found:
        raise ValueError(f"`table` must have a column {TEMPERATURE}*, got {list(table.columns)}")
    return found
