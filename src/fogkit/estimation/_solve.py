"""Rows of unit variance solved by singular values: estimate, covariance, and what is left open."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fogkit.estimation.solution import Direction

Array = NDArray[np.float64]

PARTICIPATION = 1e-6
"""Smallest coefficient, of the largest and in scaled columns, that is part of a direction: below it is rounding."""


@dataclass(frozen=True)
class Fit:
    """Solved linear problem in rows of unit variance."""

    step: Array  # estimate; the shortest one, in scaled columns, along what is not determined
    covariance: Array  # for unit noise; the part that is determined
    left: Array  # left singular vectors, rows of the data
    explained: float  # length of the right-hand side's part in the column space: the step in standard deviations
    condition: float
    rank: int
    rank_with_priors: int
    unobservable: tuple[Direction, ...]
    undetermined: tuple[Direction, ...]
    solved_condition: float  # priors included, undetermined directions left out
    weakest: Array  # direction with the smallest singular value that was used, scaled columns


def fit(
    design: Array, observations: Array, prior: tuple[Array, Array], names: tuple[str, ...], tolerance: float
) -> Fit:
    """Singular-value solution of whitened rows with columns scaled to unit length."""
    rows, values = prior
    data = _Decomposition.of(design, tolerance)
    full = _Decomposition.of(np.concatenate([design, rows]), tolerance) if rows.size else data
    used = slice(full.rank)
    projected = full.left[:, used].T @ np.concatenate([observations, values])
    scaled = full.right[used].T / full.singular[used]
    root = scaled / full.lengths[:, None]
    determined = full.rank == len(names)
    return Fit(
        step=scaled @ projected / full.lengths,
        covariance=root @ root.T,
        left=full.left[: len(design), used],
        explained=float(np.linalg.norm(projected)),
        condition=float(data.singular[0] / data.singular[-1]) if data.rank == len(names) else np.inf,
        rank=data.rank,
        rank_with_priors=full.rank,
        unobservable=() if data.rank == len(names) else _directions(data, names),
        undetermined=() if determined else _directions(full, names),
        solved_condition=float(full.singular[0] / full.singular[full.rank - 1]) if full.rank else 1.0,
        weakest=full.right[full.rank - 1],
    )


@dataclass(frozen=True)
class _Decomposition:
    """Singular values and vectors of a matrix whose columns were divided by their lengths."""

    left: Array
    singular: Array
    right: Array
    lengths: Array
    rank: int

    @classmethod
    def of(cls, matrix: Array, tolerance: float) -> _Decomposition:
        count, parameters = matrix.shape
        lengths = np.linalg.norm(matrix, axis=0)
        lengths[lengths == 0] = 1.0
        scaled = np.zeros((max(count, parameters), parameters))  # rows of zeros: all right vectors, null ones too
        scaled[:count] = matrix / lengths
        left, singular, right = np.linalg.svd(scaled, full_matrices=False)
        rank = int(np.count_nonzero(singular > tolerance * singular[0]))
        return cls(left[:count], singular, right, lengths, rank)


def _directions(decomposition: _Decomposition, names: tuple[str, ...]) -> tuple[Direction, ...]:
    """Null directions with as few parameters in each as elimination gives, since any mixture of them is one as well."""
    basis = decomposition.right[decomposition.rank :].copy()
    pivots: list[int] = []
    for row in range(len(basis)):
        remaining = np.abs(basis[row:])
        remaining[:, pivots] = 0.0
        best, column = np.unravel_index(np.argmax(remaining), remaining.shape)
        basis[[row, row + best]] = basis[[row + best, row]]
        basis[row] /= basis[row, column]
        others = np.arange(len(basis)) != row
        basis[others] -= np.outer(basis[others, column], basis[row])
        pivots.append(int(column))
    basis = basis[np.argsort([np.argmax(_takes_part(row)) for row in basis], kind="stable")]
    return tuple(_named(row, decomposition.lengths, names) for row in basis)


def _takes_part(row: Array) -> NDArray[np.bool_]:
    """Which coefficients of a direction are more than rounding."""
    return np.abs(row) > PARTICIPATION * np.abs(row).max()


def _named(row: Array, lengths: Array, names: tuple[str, ...]) -> Direction:
    """Null direction in the parameters' own units, the first coefficient 1."""
    taking_part = np.flatnonzero(_takes_part(row))
    coefficients = row[taking_part] / lengths[taking_part]
    coefficients /= coefficients[0]
    return {names[i]: float(value) for i, value in zip(taking_part, coefficients, strict=True)}
