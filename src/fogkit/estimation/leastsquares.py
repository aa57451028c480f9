"""The one least-squares door of the package.

Observations with any noise covariance, and whatever is known of the parameters beforehand, become rows of unit
variance; the columns are brought to unit length; a singular-value decomposition then gives the estimate, its covariance
and the directions that the data leave open. Normal equations, which square the condition number, are never formed.

The noise level is ``scale="given"`` (the covariance is believed, and chi-square tests it) or ``scale="estimated"`` (it
is known up to a factor, which the residuals give, and chi-square tests nothing); the solution says which. A direction
that neither data nor priors determine gets no number: its parameters come back as NaN with infinite standard deviation,
and `Solution.raise_if_unobservable` names them.

Weights w are standard deviations ``1 / sqrt(w)`` with ``scale="estimated"``.

References
----------
.. [1] Å. Björck, Numerical Methods for Least Squares Problems, SIAM, 1996: whitening, column scaling, rank.
.. [2] D. M. Bates, D. G. Watts, Nonlinear Regression Analysis and Its Applications, Wiley, 1988, section 2.2.3: the
   relative offset, by which `nonlinear` judges convergence.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.estimation import _rows, _solve
from fogkit.estimation.solution import Solution

RANK_TOLERANCE = 1e-10
"""Smallest singular value, of the largest, that counts as determined. Designs built from sines of angles carry rounding
of 1e-13 or so; a direction left with 1e-10 has a standard deviation 1e10 times that of the best one."""

NUMERIC_RANK_TOLERANCE = 1e-8
"""The same for a Jacobian by central differences, whose error is some ``eps**(2/3) = 4e-11`` of the model's size."""

LARGEST_CONDITION = 1e8
"""Condition number above which a warning comes: half of the 16 digits are lost, and a design that is wrong in its ninth
digit (a small-angle model is) gives another answer."""

OFFSET_TOLERANCE = 1e-3
"""Largest Gauss-Newton step, in standard deviations, that is left at a converged solution: it changes no conclusion."""

STEP_TOLERANCE = 1e-9
"""The same in parameter scales, for residuals so small that the standard deviation is itself rounding."""

Scale = Literal["given", "estimated"]
Array = NDArray[np.float64]


def linear(
    design: ArrayLike,
    observations: ArrayLike,
    *,
    covariance: ArrayLike | None = None,
    standard_deviation: ArrayLike | None = None,
    scale: Scale | None = None,
    prior_mean: ArrayLike | Mapping[str, float] | None = None,
    prior_covariance: ArrayLike | None = None,
    prior_standard_deviation: ArrayLike | Mapping[str, float] | None = None,
    names: Iterable[str] | None = None,
    rank_tolerance: float = RANK_TOLERANCE,
) -> Solution:
    """Parameters x that best explain ``observations = design @ x + noise``, with whatever is known of x beforehand.

    Parameters
    ----------
    design : array_like, shape (n, p)
        Change of each observation with each parameter. Columns may be of any size.
    observations : array_like, shape (n,)
        Readings.
    covariance : array_like, shape (n, n), optional
        Covariance of the noise, positive definite.
    standard_deviation : array_like, shape (n,) or (), optional
        Standard deviations of uncorrelated noise, instead of `covariance`.
    scale : {"given", "estimated"}, optional
        Whether the noise level is believed or taken from the scatter of the residuals; by default "given" where a noise
        argument is given and "estimated" where none is.
    prior_mean : array_like, shape (p,) or (), or mapping, optional
        Expected values, 0 by default. A mapping goes from names to values.
    prior_covariance : array_like, shape (p, p), optional
        Covariance of the parameters about `prior_mean`; a parameter with infinite variance and zeros beside it has no
        prior.
    prior_standard_deviation : array_like, shape (p,) or (), or mapping, optional
        Standard deviations of uncorrelated priors, instead of `prior_covariance`; infinite, or not in the mapping: no
        prior.
    names : iterable of str, optional
        Names of the parameters; by default x0, x1, ...
    rank_tolerance : float, optional
        Smallest singular value of the scaled design, of the largest, that counts as determined.

    Returns
    -------
    Solution
        Estimate, covariance, residuals, chi-square, condition and unobservable directions.

    Raises
    ------
    ValueError
        If shapes do not fit, an entry is not finite, a deviation is not positive, a covariance is singular, names
        repeat, there are too few observations to estimate the noise level, or a prior meets an estimated noise level
        (how much it counts would then depend on the scatter).

    Warns
    -----
    UserWarning
        If the condition number exceeds `LARGEST_CONDITION`, with the parameters that are hard to separate.

    Examples
    --------
    >>> line = linear([[1, 0], [1, 1], [1, 2]], [1.0, 3.0, 5.3], standard_deviation=0.1, names=["bias", "slope"])
    >>> print(f"{line['slope']:.3f} +- {line.standard_deviation[1]:.3f}, chi-square {line.chi_square:.1f}")
    2.150 +- 0.071, chi-square 1.5
    """
    design = checks.finite_array("design", design, ndim=2)
    count, parameters = design.shape
    observations = checks.finite_array("observations", observations, shape=(count,))
    names = _rows.parameter_names(names, parameters)
    noise = _rows.noise(count, covariance, standard_deviation)
    prior = _rows.priors(names, prior_mean, prior_covariance, prior_standard_deviation)
    scale = _scale(scale, noise, prior)
    tolerance = checks.in_open_interval("rank_tolerance", rank_tolerance, 0, 1)
    fit = _solve.fit(noise.whiten(design), noise.whiten(observations), prior, names, tolerance)
    _warn_if_collinear("design", fit, names)
    residuals = observations - design @ fit.step
    return _solution(names, fit.step, residuals, fit, noise, prior, scale)


def nonlinear(
    residuals: Callable[[Array], ArrayLike],
    start: ArrayLike,
    *,
    jacobian: Callable[[Array], ArrayLike] | None = None,
    covariance: ArrayLike | None = None,
    standard_deviation: ArrayLike | None = None,
    scale: Scale | None = None,
    prior_mean: ArrayLike | Mapping[str, float] | None = None,
    prior_covariance: ArrayLike | None = None,
    prior_standard_deviation: ArrayLike | Mapping[str, float] | None = None,
    names: Iterable[str] | None = None,
    parameter_scale: ArrayLike | Mapping[str, float] | None = None,
    rank_tolerance: float | None = None,
    max_evaluations: int | None = None,
) -> Solution:
    """Parameters that make residuals smallest, by Gauss-Newton steps in a trust region.

    Parameters
    ----------
    residuals : callable
        From parameters (p,) to observations less model (n,), in the unit of the observations.
    start : array_like, shape (p,)
        Where the search starts.
    jacobian : callable, optional
        From parameters to the derivative of `residuals`, (n, p): for a linear model minus its design. By default
        central differences.
    covariance, standard_deviation, scale, prior_mean, prior_covariance, prior_standard_deviation, names
        As in `linear`.
    parameter_scale : array_like, shape (p,) or (), or mapping, optional
        Typical size of each parameter, positive, from which the steps of central differences follow; by default
        ``|start|``, and 1 where that is 0. Give it wherever a parameter that starts at 0 is nowhere near 1.
    rank_tolerance : float, optional
        As in `linear`; by default `RANK_TOLERANCE` with a Jacobian and `NUMERIC_RANK_TOLERANCE` without.
    max_evaluations : int, optional
        Most calls of `residuals` besides those for derivatives; by default ``100 * p``.

    Returns
    -------
    Solution
        As from `linear`, with the covariance of the problem linearised at the estimate. Along an unobservable direction
        the search goes nowhere: the other parameters belong to the start's position along it.

    Raises
    ------
    ValueError
        As in `linear`.
    RuntimeError
        If the search (`scipy.optimize.least_squares`) does not converge: it runs out of evaluations, or stops where the
        Gauss-Newton step is longer than `OFFSET_TOLERANCE` standard deviations (a wrong `jacobian` does that).

    Examples
    --------
    >>> time = np.array([0.0, 1.0, 2.0, 3.0])
    >>> reading = np.array([2.0, 1.213, 0.735, 0.447])
    >>> decay = nonlinear(lambda x: reading - x[0] * np.exp(-x[1] * time), [1, 1], names=["start", "rate"])
    >>> print(f"{decay['rate']:.4f} +- {decay.standard_deviation[1]:.4f}")
    0.5000 +- 0.0004
    """
    from scipy.optimize import least_squares  # loaded where used

    start = checks.finite_array("start", start, ndim=1)
    first = checks.finite_array("residuals(start)", residuals(start.copy()), ndim=1)
    names = _rows.parameter_names(names, start.size)
    noise = _rows.noise(first.size, covariance, standard_deviation)
    rows, values = prior = _rows.priors(names, prior_mean, prior_covariance, prior_standard_deviation)
    scale = _scale(scale, noise, prior)
    unit = np.where(start == 0, 1.0, np.abs(start)) if parameter_scale is None else parameter_scale
    unit = _rows.positive_by_name("parameter_scale", unit, names)
    if rank_tolerance is None:
        rank_tolerance = RANK_TOLERANCE if jacobian else NUMERIC_RANK_TOLERANCE
    tolerance = checks.in_open_interval("rank_tolerance", rank_tolerance, 0, 1)
    if max_evaluations is not None:
        max_evaluations = checks.integer("max_evaluations", max_evaluations, minimum=1)
    if jacobian is not None:
        checks.finite_array("jacobian(start)", jacobian(start.copy()), shape=(first.size, start.size))

    def weighted(u: Array) -> Array:
        return np.concatenate([noise.whiten(np.asarray(residuals(u * unit), dtype=float)), rows @ (u * unit) - values])

    def slope(u: Array) -> Array:
        return np.concatenate([noise.whiten(np.asarray(jacobian(u * unit), dtype=float)), rows]) * unit

    result = least_squares(
        weighted,
        start / unit,
        jac="3-point" if jacobian is None else slope,
        method="trf",  # "lm" takes no fewer residuals than parameters
        x_scale="jac",
        ftol=1e-14,  # stops at rounding: noise-free data shall give the parameters to all digits
        xtol=1e-14,
        gtol=None,  # an absolute gradient means nothing for residuals of any unit
        max_nfev=max_evaluations,
    )
    estimate = result.x * unit
    whitened_design = -result.jac[: first.size] / unit
    left = (rows, values - rows @ estimate)
    fit = _solve.fit(whitened_design, result.fun[: first.size], left, names, tolerance)
    final = np.asarray(residuals(estimate.copy()), dtype=float)
    solution = _solution(names, estimate, final, fit, noise, prior, scale, int(result.nfev))
    _require_converged(result, fit, solution, np.maximum(unit, np.abs(estimate)))
    _warn_if_collinear("jacobian", fit, names)
    return solution


def _solution(
    names: tuple[str, ...],
    estimate: Array,
    residuals: Array,
    fit: _solve.Fit,
    noise: _rows.Noise,
    prior: tuple[Array, Array],
    scale: Scale,
    evaluations: int = 0,
) -> Solution:
    """Record from a solved problem, the estimate and its residuals."""
    whitened = noise.whiten(residuals)
    departure = prior[1] - prior[0] @ estimate
    chi_square = float(whitened @ whitened + departure @ departure)
    free = residuals.size + departure.size - fit.rank_with_priors
    if scale == "estimated" and free < 1:
        raise ValueError(
            f"`observations` must be at least {fit.rank_with_priors + 1} to estimate the noise level, "
            f"got {residuals.size}. Give `standard_deviation` or `covariance` if it is known."
        )
    noise_scale = float(np.sqrt(chi_square / free)) if scale == "estimated" else 1.0
    open_ = [names.index(name) for name in names if any(name in direction for direction in fit.undetermined)]
    estimate, covariance = estimate.copy(), noise_scale**2 * fit.covariance
    estimate[open_] = covariance[open_, :] = covariance[:, open_] = np.nan
    covariance[open_, open_] = np.inf
    return Solution(
        names=names,
        estimate=estimate,
        covariance=covariance,
        residuals=residuals,
        whitened_residuals=whitened,
        leverage=noise.leverage(fit.left),
        chi_square=chi_square,
        degrees_of_freedom=free,
        scale=scale,
        noise_scale=noise_scale,
        condition=fit.condition,
        rank=fit.rank,
        unobservable=fit.unobservable,
        undetermined=fit.undetermined,
        evaluations=evaluations,
    )


def _scale(scale: Scale | None, noise: _rows.Noise, prior: tuple[Array, Array]) -> Scale:
    """Choice of the noise level, stated or by default, if it can be carried out."""
    if scale is None:
        scale = "estimated" if noise.root is None else "given"
    scale = checks.option("scale", scale, ("given", "estimated"))
    if scale == "given" and noise.root is None:
        raise ValueError("`scale` must be 'estimated' without `covariance` or `standard_deviation`, got 'given'")
    if scale == "estimated" and prior[1].size:
        raise ValueError(
            "`scale` must be 'given' with priors, got 'estimated': what a prior counts depends on the noise level. "
            "Give `standard_deviation` or `covariance`; `noise_scale` of a fit without priors is one."
        )
    return scale


def _require_converged(result, fit: _solve.Fit, solution: Solution, size: Array) -> None:
    """``RuntimeError`` if the search ended by its limit, or where a Gauss-Newton step still leads on."""
    if result.status == 0:
        raise RuntimeError(
            f"no convergence in {result.nfev} evaluations of `residuals` from `start`, chi-square "
            f"{solution.chi_square:.6g}. Start nearer, give `parameter_scale`, or raise `max_evaluations`."
        )
    offset = fit.explained / max(solution.noise_scale, np.finfo(float).tiny)
    if offset > OFFSET_TOLERANCE and np.max(np.abs(fit.step) / size) > STEP_TOLERANCE:
        raise RuntimeError(
            f"the search stopped {offset:.3g} standard deviations from where `residuals` and their derivative say "
            "the minimum is. Check `jacobian`, `parameter_scale`, and that `residuals` are smooth."
        )


def _warn_if_collinear(argument: str, fit: _solve.Fit, names: tuple[str, ...]) -> None:
    """``UserWarning`` with the condition number and the parameters of the weakest direction."""
    if fit.solved_condition > LARGEST_CONDITION:
        part = np.abs(fit.weakest) > 0.1 * np.abs(fit.weakest).max()  # those that a reader should look at
        involved = ", ".join(f"`{name}`" for name, takes_part in zip(names, part, strict=True) if takes_part)
        kept = 16 - np.log10(fit.solved_condition)
        warnings.warn(
            f"`{argument}` has the condition number {fit.solved_condition:.3g} with columns of unit length: "
            f"{involved} are hardly separated, and their digits from {kept:.0f} on are rounding",
            stacklevel=3,
        )
