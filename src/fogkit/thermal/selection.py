"""Which measuring points a model needs: F tests, pruning, cross-validation, and what the data cannot separate."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.results import Record
from fogkit.thermal.models import TemperatureModel, several_points, single_point
from fogkit.thermal.regression import TemperatureFit, assemble, fit, fit_assembled, responses_of, runs_of

if TYPE_CHECKING:
    from pandas import DataFrame

FAMILY_WISE = 0.01
"""Default probability that a pruning keeps a point that has no effect. With independent rows the chance of the exact
set is then at least 99 % if the true points are clear; what is left to 95 % is for what independence misses."""


@dataclass(frozen=True, kw_only=True)
class FTest(Record):
    """Test of whether coefficients are zero together.

    Attributes
    ----------
    F : float
        Statistic.
    p_value : float
        Probability of a larger one if they are.
    numerator, denominator : int
        Degrees of freedom.
    """

    F: float
    p_value: float
    numerator: int
    denominator: int


def partial_f(result: TemperatureFit, point: str, *, noise: tuple[float, float] = (0.0, 0.0)) -> FTest:
    """Partial F test of a measuring point: of the coefficients of its temperature and its rate together.

    Parameters
    ----------
    result : TemperatureFit
        A fit with the point.
    point : str
        The point.
    noise : (float, float), optional
        Standard deviations of the error of temperatures, K, and of rates, K/s, in the rows of the tables
        (`fogkit.thermal.rates.row_noise`). Then the p-value allows for them.

    Returns
    -------
    FTest
        Statistic and p-value.

    Notes
    -----
    ``F = b^T V^-1 b / q`` with the covariance of the fit. For ``"ols"`` this is the F of the two fits with and
    without the point; for ``"hac"`` and ``"cluster"`` it is Wald's, with their covariance.

    Thermometers with errors of covariance S leave ``beta^T S beta`` per row unexplained by the true points, and a
    point without effect that goes along with them can explain a part of that, never more. So the noncentrality of its
    F is at most ``n beta^T S beta / sigma^2``; with `noise` the p-value is that of a noncentral F with this bound,
    with the estimates without the point put in.
    """
    from scipy import stats

    at = result.model.of_point(point)
    b, V = result.estimate[at], result.covariance[np.ix_(at, at)]
    size = np.sqrt(np.diag(V))
    pull = np.linalg.solve(V / size / size[:, None], b / size) / size  # V^-1 b, scaled for its condition
    F, freedom = float(b @ pull) / len(at), result.degrees_of_freedom
    without = result.estimate - result.covariance[:, at] @ pull  # the fit that holds the point's coefficients at zero
    variance = result.residual_deviation**2 * (freedom + F * len(at)) / (freedom + len(at))
    bound = _explicable(result, without, variance, noise)
    # noncentral F by Patnaik: a central one with the same mean and variance of the numerator; exact without `noise`
    q = len(at)
    p = stats.f.sf(F * q / (q + bound), (q + bound) ** 2 / (q + 2 * bound), freedom)
    return FTest(F=F, p_value=float(p), numerator=len(at), denominator=freedom)


def _explicable(
    result: TemperatureFit, estimate: NDArray[np.float64], variance: float, noise: tuple[float, float]
) -> float:
    """Bound on the noncentrality that errors of the thermometers can give to the F of a point without effect."""
    of_temperature, of_rate = (checks.non_negative(f"noise[{i}]", value) for i, value in enumerate(noise))
    if not (of_temperature or of_rate):
        return 0.0
    if any(term.power > 1 for term in result.model.terms):
        raise ValueError("`noise` must be left out for a model with powers of temperatures")
    deviation = np.array([of_rate if term.rate else of_temperature for term in result.model.terms])
    unexplained = ((estimate[1:] * deviation) ** 2).sum()
    # the residuals hold noise of the bias and of the thermometers: what is left is the former, a tenth at least
    return float(result.observations * unexplained / max(variance - unexplained, 0.1 * variance))


@dataclass(frozen=True, kw_only=True)
class PruningStep:
    """One step: the point with the largest p-value, and what became of it."""

    point: str
    test: FTest
    dropped: bool
    condition: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Pruning:
    """What `prune` did.

    Attributes
    ----------
    steps : tuple of PruningStep
        In order; the last one ended it.
    threshold : float
        p-value above which a point left.
    fit : TemperatureFit
        Fit of what is kept.
    """

    steps: tuple[PruningStep, ...]
    threshold: float
    fit: TemperatureFit

    @property
    def kept(self) -> tuple[str, ...]:
        """Measuring points that are kept."""
        return self.fit.model.points

    def to_frame(self) -> DataFrame:
        """Table of the steps: the point, F, its p-value, whether it was dropped, condition number before."""
        import pandas as pd

        rows = [
            {"point": s.point, "F": s.test.F, "p_value": s.test.p_value, "dropped": s.dropped, "condition": s.condition}
            for s in self.steps
        ]
        columns = ["point", "F", "p_value", "dropped", "condition"]
        return pd.DataFrame(rows, columns=columns, index=pd.RangeIndex(1, len(rows) + 1, name="step"))


def prune(
    tables: DataFrame | Sequence[DataFrame],
    points: Iterable[str] | TemperatureModel,
    response: str | Sequence[ArrayLike] | ArrayLike = "bias",
    *,
    family_wise: float = FAMILY_WISE,
    noise: tuple[float, float] = (0.0, 0.0),
    **options: object,
) -> Pruning:
    """Drop measuring points without significant effect, one after another, each together with its rate.

    Parameters
    ----------
    tables, response
        As in `fogkit.thermal.regression.fit`. Rows should be independent: take them from `fogkit.thermal.rates.reduce`.
    points : iterable of str, or TemperatureModel
        Candidates; a model is pruned by its points.
    family_wise : float, optional
        Probability that any point without effect is kept. Each test has its share, `family_wise` over the number of
        candidates, which no dependence between them can upset (Bonferroni).
    noise : (float, float), optional
        Errors of temperatures and rates in the rows, as in `partial_f`. Without it, and with enough data, noisy
        thermometers keep points that have no effect.
    **options
        Of `fit`: `run_offsets` (by default on for several runs), `covariance`, `lags`.

    Returns
    -------
    Pruning
        Steps and the final fit.
    """
    if isinstance(points, str):
        raise TypeError(f"`points` must be a sequence of names, got the text {points!r}")
    model = points if isinstance(points, TemperatureModel) else several_points(points)
    if not model.points:
        raise ValueError("`points` must name at least one measuring point, got none")
    data = assemble(model, tables, response)
    options = {"run_offsets": data.runs > 1} | options
    threshold = checks.in_open_interval("family_wise", family_wise, 0, 1) / len(model.points)
    steps: list[PruningStep] = []
    result = fit_assembled(data, warn=False, **options)
    while result.model.points:
        tests = {point: partial_f(result, point, noise=noise) for point in result.model.points}
        weakest = max(tests, key=lambda point: (tests[point].p_value, -tests[point].F))
        dropped = tests[weakest].p_value > threshold
        steps.append(PruningStep(point=weakest, test=tests[weakest], dropped=dropped, condition=result.condition))
        if not dropped:
            break
        data = data.without(weakest)
        result = fit_assembled(data, warn=False, **options)
    return Pruning(steps=tuple(steps), threshold=threshold, fit=result)


def cross_validate(
    models: TemperatureModel | Iterable[TemperatureModel] | Mapping[str, TemperatureModel],
    tables: DataFrame | Sequence[DataFrame],
    response: str | Sequence[ArrayLike] | ArrayLike = "bias",
    **options: object,
) -> DataFrame:
    """Drift that each model leaves in runs that were not used in its fit: each run is left out once.

    Parameters
    ----------
    models : TemperatureModel, iterable or mapping of it
        One model or several; a mapping gives labels.
    tables, response, **options
        As in `fogkit.thermal.regression.fit`.

    Returns
    -------
    pandas.DataFrame
        One row per model, units of the response: ``before``, the root mean square about the mean of the runs of the
        fit; ``after``, of what the model leaves; ``within_run``, the same without the mean of each run, for users who
        find the bias anew at each start; ``removed``, one less the ratio of after and before.
    """
    import pandas as pd

    runs = runs_of(tables)
    if len(runs) < 2:
        raise ValueError(f"`tables` must hold at least two runs to leave one out, got {len(runs)}")
    values = responses_of(runs, response)
    labelled = _labelled(models)
    rows = {}
    for label, model in labelled.items():
        before, after, within = [], [], []
        for i, (run, y) in enumerate(zip(runs, values, strict=True)):
            others, theirs = runs[:i] + runs[i + 1 :], values[:i] + values[i + 1 :]
            left = y - fit(model, others, theirs, warn=False, **options).predict(run)
            before.append(y - np.concatenate(theirs).mean())
            after.append(left)
            within.append(left - left.mean())
        before, after, within = (float(np.sqrt(np.mean(np.concatenate(v) ** 2))) for v in (before, after, within))
        rows[label] = {"before": before, "after": after, "within_run": within, "removed": 1 - after / before}
    return pd.DataFrame(rows).T.rename_axis("model")


def _labelled(
    models: TemperatureModel | Iterable[TemperatureModel] | Mapping[str, TemperatureModel],
) -> Mapping[str, TemperatureModel]:
    """Models by label."""
    if isinstance(models, Mapping):
        return models
    models = [models] if isinstance(models, TemperatureModel) else list(models)
    names = [model.name for model in models]
    if len(set(names)) < len(names):
        raise ValueError(f"`models` must have different names, got {names}. Give a mapping of labels to models")
    return dict(zip(names, models, strict=True))


@dataclass(frozen=True, kw_only=True)
class Separability(Record):
    """Whether data can tell the effect of a temperature from that of its rate.

    Attributes
    ----------
    point : str
        The measuring point.
    correlation : float
        Correlation of temperature and rate, within runs if their offsets are free.
    condition : float
        Condition number of the pair, ``sqrt((1 + |r|) / (1 - |r|))``.
    variance_inflation : float
        ``1 / (1 - r^2)``: by how much the variance of either coefficient exceeds that with the other known.
    time_constant : float
        Minus the slope of temperature over rate, s: what a warm-up with a single time constant has.
    separable : bool
        Whether the variance inflation is below the limit.
    statement : str
        The finding in words.
    """

    point: str
    correlation: float
    condition: float
    variance_inflation: float
    time_constant: float
    separable: bool
    statement: str


INFLATION_LIMIT = 10.0
"""Variance inflation from which temperature and rate count as not separated: standard errors are more than three times
those with the other coefficient known."""


def separability(
    tables: DataFrame | Sequence[DataFrame], point: str, *, run_offsets: bool = False, warn: bool = True
) -> Separability:
    """Whether runs can separate the effect of a temperature from that of its rate.

    Parameters
    ----------
    tables : pandas.DataFrame or sequence of it
        Runs with temperatures and rates.
    point : str
        The measuring point.
    run_offsets : bool, optional
        Whether each run has an offset of its own. Then only changes within runs count, and what runs that begin at
        different temperatures tell by their levels is given away.
    warn : bool, optional
        Whether to warn if they cannot.

    Returns
    -------
    Separability
        Numbers and a statement.

    Notes
    -----
    A warm-up with one time constant has ``T = T_end - tau dT/dt``: within a run the two are the same regressor, and any
    share of ``a T`` may be exchanged for ``-a tau dT/dt`` and a constant.
    """
    model = single_point(point)
    runs = runs_of(tables)
    columns = [model.design(run, name=f"tables[{i}]").to_numpy()[:, 1:] for i, run in enumerate(runs)]
    if run_offsets:
        columns = [c - c.mean(axis=0) for c in columns]
    T, rate = (np.concatenate(columns) - np.concatenate(columns).mean(axis=0)).T
    for name, values in zip(model.names[1:], (T, rate), strict=True):
        if not values.any():
            raise ValueError(f"`{name}` must vary, got a constant")
    cross, square_T, square_rate = T @ rate, T @ T, rate @ rate
    r = float(np.clip(cross / np.sqrt(square_T * square_rate), -1, 1))
    # 1 - r^2 from the residual of one on the other, which keeps its digits where r is nearly 1
    unexplained = float(((T - rate * cross / square_rate) ** 2).sum() / square_T)
    inflation = 1 / unexplained if unexplained > 0 else np.inf
    condition = float((1 + abs(r)) * np.sqrt(inflation))
    separable = inflation < INFLATION_LIMIT
    time_constant = float(-cross / square_rate)
    verb = "can be separated" if separable else "cannot be separated"
    where = "within runs" if run_offsets else f"over {len(runs)} run{'s' * (len(runs) > 1)}"
    statement = (
        f"temperature and rate of {point!r} {verb} {where}: correlation {r:.4f}, condition number {condition:.3g}, "
        f"standard errors {np.sqrt(inflation):.3g} times those with the other known"
    )
    if not separable:
        statement += (
            f". The temperature is nearly a constant less {time_constant:.0f} s times its rate. Add runs that begin at "
            "other temperatures or a chamber programme after the warm-up, or fit one of the two"
        )
        if warn:
            warnings.warn(statement, stacklevel=2)
    return Separability(
        point=point,
        correlation=r,
        condition=condition,
        variance_inflation=inflation,
        time_constant=time_constant,
        separable=separable,
        statement=statement,
    )
