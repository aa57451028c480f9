"""Four and six gyros for three rates: variance of the rates by least squares, and what a failed gyro leaves."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sympy import Expr, Matrix


def configurations() -> dict[str, Matrix]:
    """Input axes, one per row, of the configurations that the slides name.

    "orthogonal" is the plain triad; "skew" adds one axis equally inclined to its three; "cone" has four axes on a cone
    about z whose inclination spreads them evenly, ``cos**2 = 1/3``; "dodecahedron" has six, normal to its faces.
    """
    import sympy as sp

    third, out, golden = 1 / sp.sqrt(3), sp.sqrt(sp.Rational(2, 3)), (1 + sp.sqrt(5)) / 2
    six = sp.Matrix([[0, 1, golden], [0, 1, -golden], [1, golden, 0], [1, -golden, 0], [golden, 0, 1], [-golden, 0, 1]])
    return {
        "orthogonal": sp.eye(3),
        "skew": sp.Matrix([*sp.eye(3).tolist(), [third] * 3]),
        "cone": sp.Matrix([[out, 0, third], [-out, 0, third], [0, out, third], [0, -out, third]]),
        "dodecahedron": six / sp.sqrt(1 + golden**2),
    }


def variances(name: str) -> tuple[Expr, ...]:
    """Variances of the three rates of a configuration, in units of that of one gyro."""
    import sympy as sp

    axes = configurations()[name]
    covariance = (axes.T * axes).applyfunc(sp.simplify).inv()
    return tuple(sp.nsimplify(sp.simplify(covariance[i, i])) for i in range(3))


def survives(name: str, failed: int) -> bool:
    """Whether the three rates remain observable after any `failed` gyros of a configuration are gone."""
    import sympy as sp

    axes = configurations()[name]
    kept = combinations(range(axes.rows), axes.rows - failed)
    return all(sp.simplify((axes[list(rows), :].T * axes[list(rows), :]).det()) != 0 for rows in kept)


def mean_life(name: str) -> Expr:
    """Mean time to fewer than three independent axes, in mean lives of one gyro that fails at a constant rate."""
    import sympy as sp

    count = configurations()[name].rows
    spare = max(failed for failed in range(count - 2) if survives(name, failed))
    return sum(sp.Rational(1, working) for working in range(count - spare, count + 1))
