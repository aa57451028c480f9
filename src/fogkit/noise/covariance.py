"""Covariance of Allan variances: how far off one is by chance, and together with which others.

An overlapping Allan variance is a mean of squared second differences ``d`` of the angle. For Gaussian noise
``cov(d**2, e**2) = 2 cov(d, e)**2``, so the covariance of two Allan variances is a sum of squares of the closed forms
of `fogkit.noise.increments` over all pairs of differences: exact, for any mixture of processes and any averaging times.
The pairs depend on their distance only, and where the summand is smooth the sum over distances is a Gauss quadrature.
Two parts are not Gaussian noise: the ramp, a mean of the differences, adds ``4 mean(d) mean(e) cov(d, e)``; and the
error of a quantiser is uniform, which its fourth cumulant ``-6/5 Q**4`` accounts for.

References
----------
.. [1] C. A. Greenhall, W. J. Riley, "Uncertainty of stability variances based on finite differences", Proc. 35th PTTI
   (2003): the same sum for a single power law and a single averaging time.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.noise.increments import cross_covariance, squared_coincidence
from fogkit.noise.processes import FACTORS, PROCESSES, SLOPES, RandomErrors

Array = NDArray[np.float64]

NODES = 8
"""Gauss nodes in a block of lags that is as long as its distance from the next kink: an error of 6**-16 or so."""

BLOCK = 32
"""Lags up to this distance from a kink are summed one by one."""

UNIFORM_CUMULANT = -6 / 5
"""Fourth cumulant of a uniform error over its squared variance."""


def allan_covariance(errors: RandomErrors, factors: ArrayLike, count: int, dt: float) -> Array:
    """Covariance matrix of the overlapping Allan variances of one record.

    Parameters
    ----------
    errors : RandomErrors
        Coefficients of the noise in the record.
    factors : array_like of int, shape (j,)
        Averaging factors m: averaging times are ``m * dt``, up to half of the record.
    count : int
        Samples of the record.
    dt : float
        Sampling time, s.

    Returns
    -------
    ndarray, shape (j, j)
        Covariances of the Allan variances, (rad/s)^4; zero for errors that are a ramp only.

    Raises
    ------
    ValueError
        If a factor is below 1 or beyond half of the record.

    Examples
    --------
    Of white noise, with m much shorter than the record: two neighbouring octaves share much of their scatter.

    >>> P = allan_covariance(RandomErrors(angle_random_walk=1.0), [8, 16, 128], 100_000, 1.0)
    >>> print(f"{P[0, 1] / (P[0, 0] * P[1, 1]) ** 0.5:.2f}, {P[0, 2] / (P[0, 0] * P[2, 2]) ** 0.5:.2f}")
    0.53, 0.02
    """
    checks.instance("errors", errors, RandomErrors)
    count = checks.integer("count", count, minimum=2)
    dt = checks.positive("dt", dt, "s")
    return covariance_of_squares(errors.squares, checked_factors(factors, count), count, dt)


def mean_covariance(errors: RandomErrors, start: ArrayLike, stop: ArrayLike, reference: float) -> Array:
    """Covariance matrix of the mean errors in several pieces of one recording.

    White noise is new in each piece. Bias instability and rate random walk are not: they wander on from piece to piece.
    They have no level of their own, so their mean over a short reference at the beginning of the first piece stands
    for it: what is left of them is how far they have wandered since.

    Parameters
    ----------
    errors : RandomErrors
        Coefficients of the noise, without a ramp.
    start, stop : array_like, shape (n,)
        Times at which the pieces begin and end, s; pieces do not overlap.
    reference : float
        Length of the reference, s: a sampling time, say.

    Returns
    -------
    ndarray, shape (n, n)
        Covariances, (rad/s)^2.

    Raises
    ------
    ValueError
        If a piece does not end after it begins, pieces overlap, or there is a ramp, which is no chance.

    Examples
    --------
    Two means of a minute, next to each other and an hour apart: a bias that wanders makes them differ more.

    >>> bias = RandomErrors(bias_instability=1.0)
    >>> for later in (60.0, 3600.0):
    ...     P = mean_covariance(bias, [0.0, later], [60.0, later + 60.0], 1.0)
    ...     print(f"{np.sqrt(P[0, 0] + P[1, 1] - 2 * P[0, 1]):.2f}")
    0.94
    1.89
    """
    checks.instance("errors", errors, RandomErrors)
    start = checks.finite_array("start", start, ndim=1)
    stop = checks.finite_array("stop", stop, shape=start.shape)
    reference = checks.positive("reference", reference, "s")
    if (stop <= start).any():
        raise ValueError("`stop` must be later than `start` in every piece")
    order = np.argsort(start)
    rounding = 1e-9 * float(np.ptp(np.append(start, stop)))
    if (start[order][1:] < stop[order][:-1] - rounding).any():
        raise ValueError("`start` and `stop` must be of pieces that do not overlap")
    if errors.rate_ramp:
        raise ValueError(f"`errors` must be without a ramp, which is no chance, got {errors.rate_ramp}")
    first = float(start.min())
    edges = np.array([np.append(start, first), np.append(stop, first + reference)]) - first
    length = edges[1] - edges[0]
    lag = np.abs(edges[:, None, :, None] - edges[None, :, None, :])

    def shared(angle: Array) -> Array:
        """Covariance of means from the generalised covariance of the angle at all lags, shape (2, 2, n + 1, n + 1)."""
        return (angle[1, 1] - angle[1, 0] - angle[0, 1] + angle[0, 0]) / (length[:, None] * length)

    wandering = errors.bias_instability**2 * lag**2 * np.log(np.where(lag > 0, lag, 1.0)) / (2 * np.pi)
    wander = shared(wandering + errors.rate_random_walk**2 * lag**3 / 12)
    wander = wander[:-1, :-1] - wander[:-1, -1:] - wander[-1:, :-1] + wander[-1, -1]
    coincident = lag <= rounding
    fresh = shared(np.where(coincident, errors.quantization**2, 0.0))[:-1, :-1]
    return wander + fresh + np.diag(errors.angle_random_walk**2 / length[:-1])


def equivalent_degrees_of_freedom(errors: RandomErrors, factors: ArrayLike, count: int, dt: float) -> Array:
    """Degrees of freedom of the chi-square with mean and variance of each Allan variance: ``2 mean**2 / variance``.

    Parameters
    ----------
    errors, factors, count, dt
        As in `allan_covariance`.

    Returns
    -------
    ndarray, shape (j,)
        Degrees of freedom; infinite for errors that are a ramp only.
    """
    variance = np.diagonal(allan_covariance(errors, factors, count, dt))
    mean = errors.allan_variance(np.asarray(factors) * dt)
    with np.errstate(divide="ignore"):
        return 2 * mean**2 / variance


def covariance_of_squares(squares: Array, factors: tuple[int, ...], count: int, dt: float) -> Array:
    """`allan_covariance` from squared coefficients, shape (5,), nothing checked."""
    scaled = squares * dt**SLOPES  # as with a sampling time of 1
    return np.einsum("p,q,pqij->ij", scaled, scaled, _tensor(factors, count))


def quadratic_form(weights: Array, factors: tuple[int, ...], count: int, dt: float) -> Array:
    """Matrix (5, 5) whose quadratic form of the squares is the variance of a weighted sum of Allan variances."""
    scale = dt**SLOPES
    return scale[:, None] * np.einsum("pqij,i,j->pq", _tensor(factors, count), weights, weights) * scale


def mean_of_squares(factors: tuple[int, ...], dt: float) -> Array:
    """Allan variances per squared coefficient, shape (j, 5)."""
    return FACTORS * (dt * np.array(factors, dtype=float))[:, None] ** SLOPES


def checked_factors(factors: ArrayLike, count: int, name: str = "factors") -> tuple[int, ...]:
    """Averaging factors as ints; ``ValueError`` if one does not fit the record, or they do not increase."""
    values = checks.finite_array(name, factors, ndim=1)
    for value in values:
        if value < 1 or value != np.rint(value):
            raise ValueError(f"`{name}` must be numbers of samples, integers >= 1, got {value:g}")
        if 2 * value > count:
            raise ValueError(
                f"`{name}` must be at most half of the {count} samples, got {value:.0f}, "
                f"which needs a record of at least {2 * value:.0f} samples"
            )
    if (np.diff(values) <= 0).any():
        raise ValueError(f"`{name}` must increase, got some that do not")
    return tuple(int(value) for value in values)


@lru_cache(maxsize=32)
def _tensor(factors: tuple[int, ...], count: int) -> Array:
    """Covariances of Allan variances per product of two squared coefficients, dt = 1: shape (5, 5, j, j)."""
    size = len(factors)
    tensor = np.zeros((len(PROCESSES), len(PROCESSES), size, size))
    for i, m in enumerate(factors):
        for j, n in enumerate(factors[i:], start=i):
            tensor[:, :, i, j] = tensor[:, :, j, i] = _pair(m, n, count)
    tensor.setflags(write=False)  # cached
    return tensor


def _pair(m: int, n: int, count: int) -> Array:
    """Entry of `_tensor` for two averaging factors ``m <= n``: shape (5, 5)."""
    places_m, places_n = count - 2 * m + 1, count - 2 * n + 1
    last = count - m - n  # largest distance of the centres of two differences that the record has
    lag, weight = lag_nodes((0, n - m, m, n, n + m), last)
    pairs = np.minimum(places_n, last - lag + 1) * np.where(lag == 0, 1, 2)  # a distance to either side
    # in the order of PROCESSES, with the ramp, whose differences are all m**2, as if it were noise
    ramp, step = PROCESSES.index("rate_ramp"), PROCESSES.index("quantization")
    C = np.insert(cross_covariance(m, n, lag), ramp, float(m) ** 2 * float(n) ** 2, axis=0)
    weighted = C * (weight * pairs)
    total = 2 * weighted @ C.T
    total[ramp, ramp] = 0.0  # a product of two means is no covariance
    total[step, step] += UNIFORM_CUMULANT * np.sum(weight * pairs * squared_coincidence(m, n, lag))
    return total / (4.0 * float(m) ** 2 * float(n) ** 2 * places_m * places_n)


def lag_nodes(kinks: tuple[int, ...], last: int) -> tuple[Array, Array]:
    """Nodes and weights for a sum over the lags 0 ... last of a function that is smooth between kinks."""
    edges = sorted({0, last, *(kink for kink in kinks if kink < last)})
    nodes, weights = [np.array(edges, dtype=float)], [np.ones(len(edges))]
    for low, high in pairwise(edges):
        for start, length in _blocks(low + 1, high - 1):
            x, w = _block(length)
            nodes.append(start + x)
            weights.append(w)
    return np.concatenate(nodes), np.concatenate(weights)


def _blocks(first: int, last: int) -> list[tuple[int, int]]:
    """Start and length of blocks that fill first ... last, longer the farther they are from both ends."""
    blocks, length = [], BLOCK
    while last - first + 1 > 2 * length:
        blocks += [(first, length), (last - length + 1, length)]
        first, last = first + length, last - length
        # a block may be as long as its distance from the kink, which is the sum of those before it
        length = sum(size for _, size in blocks) // 2
    half = first + (last - first + 1) // 2
    return [*blocks, *((start, end - start) for start, end in ((first, half), (half, last + 1)) if end > start)]


@lru_cache(maxsize=4096)
def _block(length: int) -> tuple[Array, Array]:
    """Nodes in 0 ... length - 1 and weights: all of a short block, Gauss nodes of a long one."""
    if length <= BLOCK:
        return np.arange(float(length)), np.ones(length)
    nodes, gauss, first, third = _gauss()
    h = 2 / length
    # sum = integral from -1/2 to length - 1/2, corrected by Euler and Maclaurin for midpoints
    weights = (gauss - h**2 / 24 * first + 7 * h**4 / 5760 * third) / h
    return (length - 1) / 2 + nodes / h, weights


@lru_cache(maxsize=1)
def _gauss() -> tuple[Array, Array, Array, Array]:
    """Gauss nodes and weights on (-1, 1), and weights that give f'(1) - f'(-1) and the same of f''' from the nodes."""
    from numpy.polynomial import Polynomial

    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    lagrange = [Polynomial.fromroots(np.delete(nodes, i)) for i in range(NODES)]
    lagrange = [p / p(x) for p, x in zip(lagrange, nodes, strict=True)]
    first, third = (np.array([p.deriv(k)(1.0) - p.deriv(k)(-1.0) for p in lagrange]) for k in (1, 3))
    return nodes, weights, first, third
