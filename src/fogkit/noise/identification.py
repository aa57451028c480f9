"""Which random errors does a record show, how large are they, and how sure is that?

The Allan variance is linear in the squared coefficients of the processes, so they are fitted to it by least squares.
Allan variances at different averaging times come from the same samples and are correlated; their covariance
(`fogkit.noise.covariance`) is the weight of the fit. It depends on the coefficients, so fit and weight are repeated
until they agree. What is solved then is ``D^T V(theta)^-1 (A - D theta) = 0`` with the Allan variances A, whose mean is
zero at the true theta whatever else the record holds: no process is read off where another one is assumed to be small.

Squares do not go below zero: a process whose square would, is left out of the fit, and only an upper limit is given.

References
----------
.. [1] C. C. Heyde, Quasi-Likelihood and Its Application, Springer (1997): estimating functions of this form.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks, estimation
from fogkit.noise._records import ArrayRecord
from fogkit.noise.allan import AllanDeviation, allan_deviation, octaves, record
from fogkit.noise.covariance import checked_factors, covariance_of_squares, mean_of_squares, quadratic_form
from fogkit.noise.processes import PROCESSES, UNITS, RandomErrors

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

USUAL = ("angle_random_walk", "bias_instability", "rate_random_walk")

LONGEST = 8
"""Averaging times of the fit reach the record over this. Longer ones have a few degrees of freedom: they add little to
the estimates, and their skewness would make the residual chi-square exceed its 1 % limit in 3 % of records."""

ITERATIONS = 100
TOLERANCE = 1e-6
"""Change of an estimate, in its standard deviations, at which the repetition of fit and weight ends."""

LARGEST_CONDITION = 20.0
"""Condition number of the weighted fit above which processes count as hardly told apart: the three usual ones have 2 to
5 on a record in which each shows, all five some 25."""

LARGEST_BOUND = 1e12
"""Upper bound of a square, in its standard deviations, that counts as none."""

LARGEST_UNCERTAINTY = 0.5
"""Relative standard deviation of a coefficient above which the record counts as too short to determine it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Identification(ArrayRecord):
    """Coefficients of the random errors of a record, with what is known of their errors.

    Attributes
    ----------
    allan : AllanDeviation
        What was fitted.
    processes : tuple of str
        The p processes of the fit, in the order of its arrays.
    estimate : RandomErrors
        Coefficients, 0 for processes that were not fitted or whose square would be negative.
    squares : ndarray, shape (p,)
        Squared coefficients as the fit gives them if they may be negative, the weight being that of `estimate`.
    squares_covariance : ndarray, shape (p, p)
        Covariance of `squares`.
    weights : ndarray, shape (p, j)
        Part of each Allan variance in each of `squares`.
    chi_square : float
        Sum of the squared residuals, decorrelated and in standard deviations.
    degrees_of_freedom : int
        Averaging times less processes that are not at zero.
    condition : float
        Condition number of the weighted fit with columns of unit length: how hard the processes are to tell apart.
    """

    allan: AllanDeviation
    processes: tuple[str, ...]
    estimate: RandomErrors
    squares: Array
    squares_covariance: Array
    weights: Array
    chi_square: float
    degrees_of_freedom: int
    condition: float

    @property
    def coefficients(self) -> Array:
        """Estimated coefficients in the order of `processes`, shape (p,)."""
        return np.array([getattr(self.estimate, name) for name in self.processes])

    @property
    def covariance(self) -> Array:
        """Covariance of the coefficients, shape (p, p), to first order; infinite variance for one at zero."""
        value = self.coefficients
        with np.errstate(divide="ignore", invalid="ignore"):
            covariance = self.squares_covariance / (4 * value[:, None] * value)
        at_zero = value == 0
        covariance[at_zero, :] = covariance[:, at_zero] = np.nan
        covariance[at_zero, at_zero] = np.inf
        return covariance

    @property
    def standard_deviation(self) -> Array:
        """Standard deviations of the coefficients, shape (p,); infinite at zero, where `interval` has a limit."""
        return np.sqrt(np.diagonal(self.covariance))

    @property
    def fitted(self) -> Array:
        """Allan deviation of `estimate` at the averaging times of the fit, shape (j,)."""
        return np.sqrt(self.estimate.allan_variance(self.allan.tau))

    @property
    def residuals(self) -> Array:
        """Allan variance less fit, each in its own standard deviation, shape (j,); neighbours are correlated."""
        spread = np.sqrt(np.diagonal(_covariance(self.allan, self.estimate.squares)))
        return (self.allan.variance - self.fitted**2) / spread

    @property
    def p_value(self) -> float:
        """Probability of a larger chi-square by chance; near 0 the record holds something that was not fitted."""
        from scipy.special import chdtrc  # loaded where used

        return float(chdtrc(self.degrees_of_freedom, self.chi_square)) if self.degrees_of_freedom else np.nan

    def interval(self, level: float = 0.95) -> Array:
        """Confidence intervals of the coefficients.

        Parameters
        ----------
        level : float, optional
            Probability inside; what is outside is split evenly.

        Returns
        -------
        ndarray, shape (p, 2)
            Bounds. Lower bound 0: the record is compatible with the absence of the process. Upper bound infinite: it
            has too few degrees of freedom for any upper limit.

        Notes
        -----
        The interval holds the true values for which the estimate would not be in either tail. For a true square x, and
        the other squares where they fit best with it, the estimate has the mean x and a variance v(x) that follows from
        the covariance of the Allan variances, exactly. Its distribution is taken to be a shifted gamma distribution
        with the third cumulant of the process's own part, ``2 c**2 x**3`` if that part of v is ``c x**2``. Alone, the
        process has a chi-square interval; near zero it is Gaussian.
        """
        tail = (1 - checks.in_open_interval("level", level, 0, 1)) / 2
        return np.sqrt([self._bounds(i, tail) for i in range(len(self.processes))])

    def significant(self, level: float = 0.95) -> tuple[str, ...]:
        """Processes whose interval at a level does not reach zero."""
        bounds = self.interval(level)
        return tuple(name for name, (low, _) in zip(self.processes, bounds, strict=True) if low > 0)

    def to_frame(self, units: str = "si", level: float = 0.95) -> pd.DataFrame:
        """Table of the coefficients.

        Parameters
        ----------
        units : {"si", "gyro", "accelerometer"}, optional
            SI, or the units of data sheets.
        level : float, optional
            Probability of the interval.

        Returns
        -------
        DataFrame
            Index `quantity`; columns `estimate`, `standard_deviation`, `low`, `high`, `unit`.
        """
        import pandas as pd  # loaded where used

        table = UNITS[checks.option("units", units, UNITS)]
        factor = np.array([table[name][0] for name in self.processes])
        low, high = self.interval(level).T
        columns = {
            "estimate": self.coefficients / factor,
            "standard_deviation": self.standard_deviation / factor,
            "low": low / factor,
            "high": high / factor,
            "unit": [table[name][1] for name in self.processes],
        }
        return pd.DataFrame(columns, index=pd.Index(self.processes, name="quantity"))

    def _bounds(self, i: int, tail: float) -> tuple[float, float]:
        """Bounds of one square."""
        unit = float(np.sqrt(self.squares_covariance[i, i]))
        place, places = PROCESSES.index(self.processes[i]), [PROCESSES.index(name) for name in self.processes]
        form = quadratic_form(self.weights[i], tuple(self.allan.factors.tolist()), self.allan.count, self.allan.dt)
        # along this line the other squares follow x so that chi-square stays least
        slope = _all(self.squares_covariance[:, i] / unit**2, places)
        origin = self.estimate.squares - self.estimate.squares[place] * slope

        def variance(x: float) -> float:
            squares = np.maximum(origin + x * unit * slope, 0.0)
            return float(squares @ form @ squares) / unit**2

        low, high = _test_inversion(max(self.squares[i], 0.0) / unit, variance, float(form[place, place]), tail)
        return low * unit, high * unit


def identify(
    rate: ArrayLike | pd.Series | AllanDeviation,
    dt: float | None = None,
    *,
    processes: Iterable[str] = USUAL,
    averaging: str | ArrayLike = "octave",
) -> Identification:
    """Coefficients of the random errors of a record from its Allan variances.

    Parameters
    ----------
    rate : array_like, shape (n,), pandas Series, or AllanDeviation
        Mean rate over each sample, rad/s, or its Allan deviation, of one channel.
    dt : float, optional
        Sampling time, s; as in `allan_deviation`.
    processes : iterable of str, optional
        Which of `fogkit.noise.PROCESSES` to fit; by default angle random walk, bias instability, rate random walk.
    averaging : "octave" or array_like of int, optional
        Averaging factors; "octave" is all powers of two up to an eighth of the record. Not for an `AllanDeviation`,
        whose own are used.

    Returns
    -------
    Identification
        Estimates, standard deviations, intervals, and the chi-square of what is left.

    Raises
    ------
    ValueError
        As `allan_deviation`; if there are fewer averaging times than processes; or if no mixture of the processes has
        any likeness with the record.

    Warns
    -----
    UserWarning
        If processes are hardly told apart, with the condition number; if the record is too short to determine one of
        them, with the upper limit; if the record is so unlike any mixture of the processes that fit and weight do not
        come to agree, with chi-square.

    Examples
    --------
    >>> from fogkit.noise import simulate
    >>> planted = RandomErrors(angle_random_walk=1.0, bias_instability=0.2)
    >>> rate = simulate(planted, 100_000, 1.0, np.random.default_rng(1))
    >>> found = identify(rate, 1.0, processes=["angle_random_walk", "bias_instability"])
    >>> for name, value, sigma in zip(found.processes, found.coefficients, found.standard_deviation):
    ...     print(f"{name}: {value:.3f} +- {sigma:.3f}")
    angle_random_walk: 0.998 +- 0.003
    bias_instability: 0.199 +- 0.004
    """
    allan = _allan(rate, dt, averaging)
    names = _names(processes, len(allan.tau))
    places = [PROCESSES.index(name) for name in names]
    unit = float(allan.variance.max())  # rates of 1e-9 rad/s have variances of variances near the smallest numbers
    design = mean_of_squares(tuple(allan.factors.tolist()), allan.dt)[:, places]
    observed = allan.variance / unit

    def fit(squares: Array, free: NDArray[np.bool_]) -> estimation.Solution:
        covariance = _covariance(allan, _all(squares, places))
        return estimation.linear(design[:, free], observed, covariance=covariance, names=np.array(names)[free].tolist())

    squares, agreed = _iterated(fit, _start(design, observed, allan))
    free, kept = np.ones(len(names), dtype=bool), squares > 0
    full, chosen = fit(squares, free), fit(squares, kept)
    inverse = np.linalg.solve(_covariance(allan, _all(squares, places)), design)
    result = Identification(
        allan=allan,
        processes=names,
        estimate=RandomErrors.from_squares(_all(squares * unit, places)),
        squares=full.estimate * unit,
        squares_covariance=full.covariance * unit**2,
        weights=full.covariance @ inverse.T,
        chi_square=chosen.chi_square,
        degrees_of_freedom=chosen.degrees_of_freedom,
        condition=full.condition,
    )
    if not agreed:
        warnings.warn(
            f"fit and weight do not agree after {ITERATIONS} steps: the record is unlike any mixture of `processes`, "
            f"chi-square {result.chi_square:.3g} for {result.degrees_of_freedom} degrees of freedom",
            stacklevel=2,
        )
    _warn(result)
    return result


def predict(
    errors: RandomErrors,
    count: int,
    dt: float,
    *,
    processes: Iterable[str] = USUAL,
    averaging: str | ArrayLike = "octave",
) -> pd.DataFrame:
    """How well will `identify` find the coefficients in a record that is yet to be taken?

    Parameters
    ----------
    errors : RandomErrors
        What the record will hold.
    count, dt
        Samples, and sampling time in s.
    processes, averaging
        As in `identify`.

    Returns
    -------
    DataFrame
        Index `quantity`, columns `value`, `standard_deviation` and their ratio `relative`, in SI units. To first order,
        so a `relative` above some 0.3 says only that the record will be too short.

    Examples
    --------
    >>> gyro = RandomErrors(angle_random_walk=1.0, bias_instability=0.1)
    >>> predict(gyro, 100_000, 1.0, processes=["angle_random_walk", "bias_instability"]).relative.round(3).to_dict()
    {'angle_random_walk': 0.002, 'bias_instability': 0.041}
    """
    import pandas as pd  # loaded where used

    checks.instance("errors", errors, RandomErrors)
    count, dt = checks.integer("count", count, minimum=2), checks.positive("dt", dt, "s")
    factors = _factors(averaging, count)
    m = np.array(factors)
    variance = errors.allan_variance(m * dt)
    allan = AllanDeviation(
        tau=m * dt, deviation=np.sqrt(variance), factors=m, differences=count - 2 * m + 1, count=count, dt=dt
    )
    names = _names(processes, len(factors))
    places = [PROCESSES.index(name) for name in names]
    covariance = _covariance(allan, errors.squares) / float(variance.max()) ** 2
    solution = estimation.linear(mean_of_squares(factors, dt)[:, places], variance, covariance=covariance)
    value = np.abs([getattr(errors, name) for name in names])
    with np.errstate(divide="ignore"):
        deviation = solution.standard_deviation * float(variance.max()) / (2 * value)
        columns = {"value": value, "standard_deviation": deviation, "relative": deviation / value}
    return pd.DataFrame(columns, index=pd.Index(names, name="quantity"))


def _allan(rate: Any, dt: float | None, averaging: str | ArrayLike) -> AllanDeviation:
    """Allan deviation of one channel, as it came or of a record."""
    if isinstance(rate, AllanDeviation):
        if dt is not None or not isinstance(averaging, str):
            raise ValueError("`dt` and `averaging` must not be given with an AllanDeviation, which has them")
        allan = rate
    else:
        values, dt = record(rate, dt)
        allan = allan_deviation(values, dt, averaging=_factors(averaging, len(values)))
    if allan.deviation.ndim == 1:
        return allan
    if allan.deviation.shape[1] > 1:
        raise ValueError(
            f"`rate` must be of one channel, got {allan.deviation.shape[1]}. Take them one by one: "
            "`identify(rate[:, 0], dt)`, `identify(table['gyro_x'])`, `identify(allan.channel(0))`."
        )
    return allan.channel(0)


def _factors(averaging: str | ArrayLike, count: int) -> tuple[int, ...]:
    """Averaging factors of a fit."""
    if not isinstance(averaging, str):
        return checked_factors(averaging, count, "averaging")
    checks.option("averaging", averaging, ("octave",))
    return tuple(m for m in octaves(count) if LONGEST * m <= count)


def _names(processes: Iterable[str], times: int) -> tuple[str, ...]:
    """Checked names of processes, in the order given."""
    if isinstance(processes, str):
        raise TypeError(f"`processes` must be a sequence of strings, got {processes!r}")
    names = tuple(checks.option("processes", name, PROCESSES) for name in processes)
    if not names or len(set(names)) < len(names):
        raise ValueError(f"`processes` must be one or several different ones, got {names}")
    if times < len(names):
        raise ValueError(
            f"`rate` must be long enough for at least {len(names)} averaging times to fit {len(names)} processes, "
            f"got {times}: an octave each up to an eighth of the record"
        )
    return names


def _all(squares: Array, places: list[int]) -> Array:
    """Squares of the fitted processes among those of all, shape (5,)."""
    result = np.zeros(len(PROCESSES))
    result[places] = squares
    return result


def _covariance(allan: AllanDeviation, squares: Array) -> Array:
    """Covariance of the Allan variances for squared coefficients, shape (5,)."""
    return covariance_of_squares(squares, tuple(allan.factors.tolist()), allan.count, allan.dt)


def _start(design: Array, observed: Array, allan: AllanDeviation) -> Array:
    """First squares: weights as if each variance had the degrees of freedom of white noise, no correlation."""
    from scipy.optimize import nnls  # loaded where used

    weight = np.sqrt(allan.count / allan.factors) / observed
    scale = np.linalg.norm(design * weight[:, None], axis=0)
    return nnls(design * weight[:, None] / scale, observed * weight)[0] / scale


def _iterated(fit: Callable[[Array, NDArray[np.bool_]], estimation.Solution], squares: Array) -> tuple[Array, bool]:
    """Squares at which weight and fit agree, none below zero, and whether they do."""
    for iteration in range(ITERATIONS):
        proposed, deviation = _non_negative(lambda free, at=squares: fit(at, free), squares.size)
        if not proposed.any():
            raise ValueError(
                "`processes` must hold one that the record shows, got only such as would have negative squares"
            )
        change = proposed - squares
        if np.all(np.abs(change) <= TOLERANCE * deviation):
            return proposed, True
        # a record that is unlike the model can make the two go round in a circle, which smaller steps may end
        squares = squares + 0.5 ** (iteration // 15) * change
    return squares, False


def _non_negative(fit: Callable[[NDArray[np.bool_]], estimation.Solution], count: int) -> tuple[Array, Array]:
    """Best squares that are not negative, and standard deviations with all processes free."""
    full = fit(np.ones(count, dtype=bool))
    if (full.estimate >= 0).all():
        return full.estimate, full.standard_deviation
    best, least = np.zeros(count), np.inf
    for chosen in product((True, False), repeat=count):  # at most 31: no need to search cleverly, and sure to find it
        free = np.array(chosen)
        if not free.any() or free.all():
            continue
        solution = fit(free)
        if (solution.estimate >= 0).all() and solution.chi_square < least:
            best, least = np.zeros(count), solution.chi_square
            best[free] = solution.estimate
    return best, full.standard_deviation


def _test_inversion(
    estimate: float, variance: Callable[[float], float], own: float, tail: float
) -> tuple[float, float]:
    """Bounds of a square, in units of its standard deviation: see `Identification.interval`."""
    from scipy.optimize import brentq  # loaded where used
    from scipy.special import gammainc, gammaincc

    def outside(x: float, upper: bool) -> float:
        spread = max(variance(x), 1e-24) ** 0.5  # a process alone has none at x = 0
        skewness = max(2 * own**2 * (x / spread) ** 3, 1e-3)  # with less, the gamma distribution is a Gaussian one
        shape = 4 / skewness**2
        place = max(shape + (estimate - x) * shape**0.5 / spread, 0.0)
        return (gammainc if upper else gammaincc)(shape, place) - tail

    low = brentq(outside, 0.0, estimate, args=(False,)) if outside(0.0, False) < 0 else 0.0
    high = estimate + 1.0
    while outside(high, True) > 0:
        high *= 2
        if high > LARGEST_BOUND:
            return low, np.inf
    return low, brentq(outside, estimate, high, args=(True,))


def _warn(result: Identification) -> None:
    """``UserWarning`` where numbers came out that say little."""
    if result.condition > LARGEST_CONDITION:
        scale = np.sqrt(np.diagonal(result.squares_covariance))
        correlation = np.abs(result.squares_covariance / scale[:, None] / scale - np.eye(len(scale)))
        first, second = (result.processes[i] for i in np.unravel_index(np.argmax(correlation), correlation.shape))
        warnings.warn(
            f"`{first}` and `{second}` are hardly told apart on this record: condition number {result.condition:.0f}, "
            f"correlation {correlation.max():.4f}",
            stacklevel=3,
        )
    uncertain = result.standard_deviation > LARGEST_UNCERTAINTY * result.coefficients
    if uncertain.any():
        limits = result.interval()[:, 1]
        words = ", ".join(
            f"`{name}` (below {limit:.3g} {UNITS['si'][name][1]} at 95 %)"
            for name, limit in zip(np.array(result.processes)[uncertain], limits[uncertain], strict=True)
        )
        warnings.warn(f"the record of {result.allan.duration:g} s shows too little to determine {words}", stacklevel=3)
