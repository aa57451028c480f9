"""What a straight line through the velocity of a dwell tells, and what it does not: (21)-(24) with real noise.

(24) takes the residuals of the line for all that is wrong with its slope. That is right for errors of the velocity that
are new in every sample. Angle and velocity random walk are not: the velocity adds them up. `noise_in_slopes` computes,
for each, the variance that the difference of two slopes really has and what (23) and (24) make of the residuals.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.claims import Proof
from fogkit.stand.turn_tests import DWELL, TURN_DURATION

if TYPE_CHECKING:
    from sympy import Expr

Array = NDArray[np.float64]

KINDS = ("white velocity", "velocity random walk", "angle random walk")
"""What `noise_in_slopes` knows: independent errors of the samples of velocity, of the specific force, of the rate."""

_SAME = 1e-9  # relative; sums of a few hundred products of ordered size


def slope_variance(count: int = 5) -> tuple[Expr, Expr]:
    """Variance of the slope of a line through independent errors of variance 1 at any times, and (24) with S = 1.

    Parameters
    ----------
    count : int, optional
        Number of samples; their times stay symbols.

    Returns
    -------
    tuple of sympy.Expr
        Sum of the squared weights of least squares, and the print's expression.
    """
    import sympy as sp

    tau = sp.Matrix(sp.symbols(f"tau_1:{count + 1}", real=True))
    design = sp.ones(count, 1).row_join(tau)
    normal = design.T * design
    mean, mean_of_squares = sum(tau) / count, tau.dot(tau) / count
    return normal[0, 0] / normal.det(), 1 / (count * (mean_of_squares - mean**2))


def eq24_holds() -> bool:
    """Whether (24) is the variance of the slope, identically in the times of the samples."""
    import sympy as sp

    derived, printed = slope_variance()
    return sp.expand(1 / derived - 1 / printed) == 0


def residual_freedom(count: int) -> int:
    """Mean of the sum of squared residuals of a line, in units of the variance: the divisor of S^2, exactly.

    Times are square numbers; any that differ give the same.
    """
    import sympy as sp

    design = sp.Matrix([[1, i**2] for i in range(count)])
    hat = design * (design.T * design).inv() * design.T
    return int((sp.eye(count) - hat).trace())


def eq21_range() -> Proof:
    """Whether samples of the first dwell fulfil the printed range, and the corrected one.

    The index of a sample as that of the end makes every time its own bound.
    """
    times = np.arange(0.5, DWELL)
    return Proof(printed=bool(((times > 0) & (times < times)).all()), corrected=bool((times < DWELL).all()))


def eq22_shapes() -> Proof:
    """Whether the printed product, and its correction, have the shape 18 x 18 that the text gives, for a column r."""
    import sympy as sp

    r = sp.MatrixSymbol("r", 18, 1)  # the column of (20)
    return Proof(printed=(r.T * r).shape == (18, 18), corrected=(r * r.T).shape == (18, 18))


@dataclass(frozen=True)
class NoiseInSlopes:
    """Difference of the slopes of two dwells under one kind of noise.

    Attributes
    ----------
    variance : float
        Of the difference of the slopes, in units of the variance of one step's noise.
    reported : float
        What (23) and (24) find on average.
    slope_correlation : float
        Between the slopes of the two dwells; (23) has none.
    residual_correlation : float
        The largest between a residual of one dwell and one of the other.
    neighbour_correlation : float
        Between neighbouring residuals in the middle of a dwell; -1 over their number or so, if (24) is to hold.
    """

    variance: float
    reported: float
    slope_correlation: float
    residual_correlation: float
    neighbour_correlation: float

    @property
    def shortfall(self) -> float:
        """True over reported variance."""
        return self.variance / self.reported


def noise_in_slopes(
    kind: str, dwell: float = DWELL, turn_duration: float = TURN_DURATION, rate: float = 10.0
) -> NoiseInSlopes:
    """Compute true and reported variance of the change of slope over a test.

    Parameters
    ----------
    kind : str
        One of `KINDS`. Angle random walk is taken about a level axis, velocity random walk along one.
    dwell, turn_duration : float, optional
        s; the velocity is set to zero at the end of the turn.
    rate : float, optional
        Samples per second.

    Returns
    -------
    NoiseInSlopes
        By covariances, without random numbers. Gravity is 1: it is common to both variances.

    Raises
    ------
    ValueError
        If the kind is unknown, a duration not positive, or a dwell has fewer than three samples.
    """
    checks.option("kind", kind, KINDS)
    rate = checks.positive("rate", rate, "Hz")
    still, turning = (
        round(checks.positive(name, value, "s") * rate)
        for name, value in (("dwell", dwell), ("turn_duration", turn_duration))
    )
    if still < 3:
        raise ValueError(f"`dwell` must hold three samples or more at `rate`, got {still}")
    responses = _responses(kind, still, turning, 1 / rate)
    covariance = np.block([[a @ b.T for b in responses] for a in responses])
    design = np.column_stack([np.ones(still), np.arange(still) / rate])
    estimate = np.linalg.pinv(design)
    slopes = np.kron(np.eye(2), estimate[1])
    residuals = np.kron(np.eye(2), np.eye(still) - design @ estimate)
    of_slopes = slopes @ covariance @ slopes.T
    of_residuals = residuals @ covariance @ residuals.T
    slope_of_white = np.linalg.inv(design.T @ design)[1, 1]
    reported = slope_of_white * np.trace(of_residuals) / (still - 2)  # S^2 of either dwell, then (24) and (23)
    deviations = np.sqrt(np.diag(of_residuals))
    correlation = of_residuals / np.outer(deviations, deviations)
    middle = still // 2
    return NoiseInSlopes(
        variance=float(of_slopes[0, 0] + of_slopes[1, 1] - 2 * of_slopes[0, 1]),
        reported=float(reported),
        slope_correlation=float(of_slopes[0, 1] / np.sqrt(of_slopes[0, 0] * of_slopes[1, 1])),
        residual_correlation=float(np.abs(correlation[:still, still:]).max()),
        neighbour_correlation=float(correlation[middle, middle + 1]),
    )


def _responses(kind: str, still: int, turning: int, dt: float) -> tuple[Array, Array]:
    """Velocity samples of the two dwells by the noise of every step of the test, shapes (still, steps)."""
    steps = 2 * still + turning
    if kind == "white velocity":
        added = np.eye(steps)
    else:
        added = np.tril(np.full((steps, steps), dt))  # velocity random walk
        if kind == "angle random walk":
            added = added @ np.tril(np.full((steps, steps), dt))
    return added[:still], added[still + turning :]  # setting the velocity to zero changes no slope


def residuals_tell_the_slope(kind: str) -> bool:
    """Whether (23) and (24) report the true variance for a kind of noise."""
    found = noise_in_slopes(kind)
    return bool(np.isclose(found.variance, found.reported, rtol=_SAME, atol=0))
