"""Are predicted covariances true? Statistics over many runs, and the intervals in which they must fall.

An estimator with an honest covariance P makes errors e whose ``e @ inv(P) @ e`` is chi-square distributed, and whose
scatter over runs equals the predicted standard deviation. `nees` computes the first; the two intervals say how far
either may be off by chance, so that a test of an estimator has a bound that follows from its number of runs.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks


def nees(errors: ArrayLike, covariances: ArrayLike) -> NDArray[np.float64]:
    """Normalised estimation error squared of one or many estimates.

    Parameters
    ----------
    errors : array_like, shape (..., n)
        Estimate less truth.
    covariances : array_like, shape (..., n, n)
        Predicted covariances; one of shape (n, n) serves all errors.

    Returns
    -------
    ndarray, shape (...,)
        ``e @ inv(P) @ e``: chi-square distributed with n degrees of freedom if the covariances are true.

    Raises
    ------
    ValueError
        If the shapes do not fit, an entry is not finite, or a covariance is not positive definite.

    Examples
    --------
    >>> nees([[1.0, 2.0], [0.0, 0.0]], [[1.0, 0.0], [0.0, 4.0]])
    array([2., 0.])
    """
    errors = checks.finite_array("errors", errors, shape=(..., None))
    count = errors.shape[-1]
    covariances = checks.finite_array("covariances", covariances, shape=(..., count, count))
    deviations = np.sqrt(np.abs(np.diagonal(covariances, axis1=-2, axis2=-1)))
    deviations = np.where(deviations > 0, deviations, 1.0)  # parameters of very different size would spoil the solve
    try:
        roots = np.linalg.cholesky(covariances / deviations[..., :, None] / deviations[..., None, :])
    except np.linalg.LinAlgError:
        raise ValueError("`covariances` must be positive definite, got one that is not") from None
    try:
        np.broadcast_shapes(errors.shape[:-1], covariances.shape[:-2])
    except ValueError:
        raise ValueError(
            f"`covariances` must be of shape (n, n) or one for each error, got {covariances.shape} "
            f"for errors of shape {errors.shape}"
        ) from None
    whitened = np.linalg.solve(roots, (errors / deviations)[..., None])[..., 0]
    return np.sum(whitened**2, axis=-1)


def chi_square_interval(degrees_of_freedom: int, count: int = 1, probability: float = 0.95) -> tuple[float, float]:
    """Interval in which the average of `count` independent chi-square numbers falls with a given probability.

    Parameters
    ----------
    degrees_of_freedom : int
        Degrees of freedom of each number: for `nees` the number of parameters.
    count : int, optional
        Numbers that are averaged, such as runs.
    probability : float, optional
        Probability inside; what is outside is split evenly.

    Returns
    -------
    low, high : float
        Bounds about ``degrees_of_freedom``, from the chi-square distribution of the sum.

    Examples
    --------
    >>> low, high = chi_square_interval(2, 50)
    >>> print(f"{low:.2f} {high:.2f}")
    1.48 2.59
    """
    count = checks.integer("count", count, minimum=1)
    total = checks.integer("degrees_of_freedom", degrees_of_freedom, minimum=1) * count
    low, high = _chi_square_bounds(total, probability)
    return low / count, high / count


def ratio_interval(count: int, probability: float = 0.95, *, mean_known: bool = False) -> tuple[float, float]:
    """Interval in which predicted over observed standard deviation falls if the prediction is true.

    Parameters
    ----------
    count : int
        Runs from which the standard deviation was observed, with Gaussian errors.
    probability : float, optional
        Probability inside; what is outside is split evenly.
    mean_known : bool, optional
        False: observed about the mean of the runs (``ddof=1``). True: root mean square of errors about the truth.

    Returns
    -------
    low, high : float
        Bounds about 1; for many runs ``1 -+ 1.96 / sqrt(2 count)`` at 95 %.

    Examples
    --------
    >>> low, high = ratio_interval(500)
    >>> print(f"{low:.3f} {high:.3f}")
    0.942 1.066
    """
    free = checks.integer("count", count, minimum=1 if mean_known else 2) - (not mean_known)
    low, high = _chi_square_bounds(free, probability)
    return float(np.sqrt(free / high)), float(np.sqrt(free / low))


def _chi_square_bounds(degrees_of_freedom: int, probability: float) -> tuple[float, float]:
    """Quantiles that leave equal tails; each from its own tail, so neither loses digits to 1 - q."""
    from scipy import special  # loaded where used

    tail = (1 - checks.in_open_interval("probability", probability, 0, 1)) / 2
    half = degrees_of_freedom / 2
    return float(2 * special.gammaincinv(half, tail)), float(2 * special.gammainccinv(half, tail))
