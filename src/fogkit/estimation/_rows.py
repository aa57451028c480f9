"""Noise and priors as rows of unit variance: what every problem is turned into before it is solved."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks

Array = NDArray[np.float64]

SYMMETRY_TOLERANCE = 1e-8
"""Largest asymmetry of a covariance, of the two standard deviations: products of computed matrices stay far below, a
mistyped or transposed entry does not."""


@dataclass(frozen=True)
class Noise:
    """Square root of the noise covariance: None for unit noise, deviations (n,), or a lower triangle (n, n)."""

    root: Array | None

    def whiten(self, rows: Array) -> Array:
        """Rows (n,) or (n, p) multiplied by the inverse of the root."""
        if self.root is None:
            return rows
        if self.root.ndim == 1:
            return (rows.T / self.root).T
        return _solve_lower(self.root, rows)

    def leverage(self, left: Array) -> Array:
        """Diagonal of the matrix that takes observations to fitted values, from the left singular vectors (n, k)."""
        if self.root is None or self.root.ndim == 1:
            return np.sum(left**2, axis=1)
        # whitened, the matrix is left @ left.T; in the observations' own terms it is root @ left @ left.T @ inv(root)
        return np.sum((self.root @ left) * _solve_lower(self.root, left, transposed=True), axis=1)


def noise(count: int, covariance: ArrayLike | None, standard_deviation: ArrayLike | None) -> Noise:
    """Noise of `count` observations from whichever of the two arguments was given."""
    if covariance is not None and standard_deviation is not None:
        raise ValueError("`covariance` must be None where `standard_deviation` is given, got both")
    if covariance is not None:
        matrix = checks.finite_array("covariance", covariance, shape=(count, count))
        return Noise(lower_root("covariance", matrix))
    if standard_deviation is None:
        return Noise(None)
    deviation = checks.finite_array("standard_deviation", standard_deviation)
    if deviation.shape not in ((), (count,)):
        raise ValueError(f"`standard_deviation` must be one number or of shape ({count},), got {deviation.shape}")
    _require_positive("standard_deviation", deviation)
    return Noise(np.broadcast_to(deviation, (count,)))


def priors(
    names: tuple[str, ...],
    mean: ArrayLike | Mapping[str, float] | None,
    covariance: ArrayLike | None,
    standard_deviation: ArrayLike | Mapping[str, float] | None,
) -> tuple[Array, Array]:
    """Rows (q, p) and values (q,) of unit variance that state what is known beforehand; q = 0 without priors."""
    count = len(names)
    if covariance is None and standard_deviation is None:
        if mean is not None:
            raise ValueError(
                "`prior_mean` must come with `prior_covariance` or `prior_standard_deviation`, got it alone"
            )
        return np.zeros((0, count)), np.zeros(0)
    if covariance is not None and standard_deviation is not None:
        raise ValueError("`prior_covariance` must be None where `prior_standard_deviation` is given, got both")
    expected = checks.finite_array("prior_mean", _by_name("prior_mean", mean, names, 0.0), shape=(count,))
    if standard_deviation is not None:
        deviation = _by_name("prior_standard_deviation", standard_deviation, names, np.inf)
        _require_positive("prior_standard_deviation", deviation)
        held = np.isfinite(deviation)
        return np.diag(1 / deviation)[held], expected[held] / deviation[held]
    root, held = _prior_root(covariance, count)
    return _solve_lower(root, np.eye(count)[held]), _solve_lower(root, expected[held])


def _prior_root(covariance: ArrayLike, count: int) -> tuple[Array, NDArray[np.bool_]]:
    """Root of the finite part of a prior covariance, and which parameters that is."""
    matrix = np.asarray(covariance, dtype=np.float64)
    if matrix.shape != (count, count):
        raise ValueError(f"`prior_covariance` must be of shape ({count}, {count}), got {matrix.shape}")
    free = np.diagonal(matrix) == np.inf
    off_diagonal = np.where(np.eye(count, dtype=bool), 0.0, matrix)
    if np.any(off_diagonal[free]) or np.any(off_diagonal[:, free]):
        raise ValueError(
            "`prior_covariance` must be 0 off the diagonal where a variance is infinite, got other entries"
        )
    held = ~free
    known = matrix[np.ix_(held, held)]
    if known.size:
        known = lower_root("prior_covariance", checks.finite_array("prior_covariance", known))
    return known, held


def lower_root(name: str, covariance: Array) -> Array:
    """Lower Cholesky factor of a covariance; ``ValueError`` if it is asymmetric, or singular to rounding."""
    variance = np.diagonal(covariance)
    if not (variance > 0).all():
        raise ValueError(f"`{name}` must have a positive diagonal, got {variance.min()}")
    deviation = np.sqrt(variance)
    correlation = covariance / deviation[:, None] / deviation  # so that the test for singularity knows no units
    if np.abs(correlation - correlation.T).max() > SYMMETRY_TOLERANCE:
        raise ValueError(f"`{name}` must be symmetric, got entries that differ from their mirror images")
    try:
        root = np.linalg.cholesky(correlation)
        # square of a diagonal entry: the part of a variance that the entries before it leave open
        singular = np.diagonal(root).min() ** 2 < len(root) * np.finfo(float).eps
    except np.linalg.LinAlgError:
        singular = True
    if singular:
        smallest = np.linalg.eigvalsh(correlation)[0]
        raise ValueError(
            f"`{name}` must be positive definite, got one whose correlation matrix has the eigenvalue {smallest:.3g}"
        )
    return root * deviation[:, None]


def parameter_names(names: Iterable[str] | None, count: int) -> tuple[str, ...]:
    """Names of the parameters: those given, or x0, x1, ..."""
    if names is None:
        return tuple(f"x{i}" for i in range(count))
    if isinstance(names, str):
        raise TypeError(f"`names` must be a sequence of strings, got {names!r}")
    names = tuple(names)
    if not all(isinstance(name, str) for name in names):
        raise TypeError(f"`names` must be strings, got {names!r}")
    if len(names) != count:
        raise ValueError(f"`names` must name {count} parameters, got {len(names)} names")
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"`names` must differ from each other, got {', '.join(map(repr, twice))} more than once")
    return names


def positive_by_name(argument: str, value: ArrayLike | Mapping, names: tuple[str, ...]) -> Array:
    """Array (p,) of finite numbers above zero, 1 for a parameter that a mapping leaves out."""
    array = checks.finite_array(argument, _by_name(argument, value, names, 1.0))
    _require_positive(argument, array)
    return array


def _by_name(argument: str, value: ArrayLike | Mapping | None, names: tuple[str, ...], default: float) -> Array:
    """Array (p,) from an array, one number for all, or a mapping of names in which those left out have the default."""
    if value is None:
        return np.full(len(names), default)
    if isinstance(value, Mapping):
        unknown = [name for name in value if name not in names]
        if unknown:
            raise ValueError(f"`{argument}` must have keys among {names}, got {', '.join(map(repr, unknown))}")
        value = [value.get(name, default) for name in names]
    array = np.asarray(value, dtype=np.float64)
    if array.shape not in ((), (len(names),)):
        raise ValueError(f"`{argument}` must be one number or of shape ({len(names)},), got {array.shape}")
    return np.broadcast_to(array, (len(names),))


def _require_positive(argument: str, values: Array) -> None:
    """``ValueError`` that shows the first entry that is not above zero, or is NaN."""
    wrong = ~(np.atleast_1d(values) > 0)
    if wrong.any():
        at = int(np.argmax(wrong))
        raise ValueError(f"`{argument}` must be > 0, got {np.atleast_1d(values)[at]} at index {at}")


def _solve_lower(root: Array, rows: Array, *, transposed: bool = False) -> Array:
    """Inverse of a lower triangle, or of its transpose, times rows."""
    from scipy.linalg.blas import dtrsm  # loaded where used

    if not rows.size:
        return rows
    # scipy's solve_triangular starts threads even for ten rows: milliseconds, where this takes microseconds
    solved = dtrsm(1.0, root.T, rows.reshape(len(rows), -1), lower=0, trans_a=not transposed)
    return solved.reshape(rows.shape)
