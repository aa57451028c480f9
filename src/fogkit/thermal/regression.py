"""The fit of a temperature model to one run or several, with what its numbers are worth.

Ordinary least squares by statsmodels. Standard errors are those of independent residuals (``covariance="ols"``), or
they allow for residuals that are correlated in time within a run (``"hac"``: Newey and West, summed run by run) or in
any way within a run (``"cluster"``, for ten runs or more). None of them repairs an estimate that noisy thermometers
have biased.

References
----------
.. [1] D. A. Belsley, E. Kuh, R. E. Welsch, Regression Diagnostics, Wiley (1980): condition numbers of 30 and more.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.results import contents
from fogkit.thermal.models import TemperatureModel

if TYPE_CHECKING:
    from pandas import DataFrame

CONDITION_LIMIT = 30.0
"""Condition number of the centred and scaled regressors above which `fit` warns, the usual limit [1]_. Two faces of a
coil pass it: they differ by a few kelvin while both go through a hundred. Then the sum of their effects is known, and
compensates, but the coefficients one by one are not."""

COVARIANCES = ("ols", "hac", "cluster")
_SINGULAR = 1e-11  # relative singular value below which regressors count as dependent: rounding of 1e-15 times 1e4 rows


@dataclass(frozen=True, kw_only=True, eq=False)
class TemperatureFit:
    """A fitted model.

    Attributes
    ----------
    model : TemperatureModel
        The model.
    estimate : ndarray, shape (k,)
        Coefficients in the order of ``model.names``, in the unit of the response, per K**power or per K/s.
    covariance : ndarray, shape (k, k)
        Their covariance.
    covariance_kind : str
        ``"ols"``, ``"hac"`` or ``"cluster"``.
    residual_deviation : float
        Standard deviation of the residuals, for the degrees of freedom left.
    r_squared : float
        Share of the variance that is explained, by run offsets too if there are any.
    observations, degrees_of_freedom : int
        Rows, and rows less coefficients and offsets.
    condition : float
        Condition number of the regressors, each centred (within its run, with offsets) and scaled; 1 if they are
        uncorrelated.
    vif : ndarray, shape (k,)
        Variance inflation factor of each coefficient by the other regressors; NaN for the constant.
    autocorrelation : float
        Correlation of neighbouring residuals within a run. If it is clearly positive, ``"ols"`` errors are too small.
    run_offsets : ndarray, shape (r,)
        Offsets of the runs, of sum zero; empty if they were not fitted.
    """

    model: TemperatureModel
    estimate: NDArray[np.float64]
    covariance: NDArray[np.float64]
    covariance_kind: str
    residual_deviation: float
    r_squared: float
    observations: int
    degrees_of_freedom: int
    condition: float
    vif: NDArray[np.float64]
    autocorrelation: float
    run_offsets: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        k = len(self.model.names)
        object.__setattr__(self, "estimate", checks.finite_array("estimate", self.estimate, shape=(k,)))
        object.__setattr__(self, "covariance", checks.finite_array("covariance", self.covariance, shape=(k, k)))
        for name in ("vif", "run_offsets"):
            object.__setattr__(self, name, np.asarray(getattr(self, name), float))

    @property
    def standard_deviation(self) -> NDArray[np.float64]:
        """Standard errors of the coefficients."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def t(self) -> NDArray[np.float64]:
        """Coefficients over their standard errors; infinite for a fit without residuals."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.estimate / self.standard_deviation

    @property
    def p_value(self) -> NDArray[np.float64]:
        """Probability of a t as large in size if the coefficient were zero."""
        from scipy import stats

        return 2 * stats.t.sf(np.abs(self.t), self.degrees_of_freedom)

    def coefficient(self, name: str) -> float:
        """Coefficient by its name."""
        checks.option("name", name, self.model.names)
        return float(self.estimate[self.model.names.index(name)])

    def predict(self, table: DataFrame) -> NDArray[np.float64]:
        """Value of the model in the rows of a table, shape (n,), without the offset of any run."""
        return self.model.design(table).to_numpy() @ self.estimate

    def to_frame(self) -> DataFrame:
        """Table with the index ``coefficient`` and estimate, standard error, t, p-value and variance inflation."""
        import pandas as pd

        columns = {
            "estimate": self.estimate,
            "standard_deviation": self.standard_deviation,
            "t": self.t,
            "p_value": self.p_value,
            "vif": self.vif,
        }
        return pd.DataFrame(columns, index=pd.Index(self.model.names, name="coefficient"))

    def to_json(self) -> str:
        """Text from which `from_json` makes an equal fit."""
        data = {name: getattr(self, name) for name in self.__dataclass_fields__ if name != "model"}
        plain = {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in data.items()}
        return json.dumps({"kind": "TemperatureFit", "model": self.model.to_dict()} | plain)

    @classmethod
    def from_json(cls, text: str) -> TemperatureFit:
        """Fit from the text of `to_json`; ``ValueError`` if that was of another kind."""
        data = contents(text, "TemperatureFit")
        return cls(model=TemperatureModel.from_dict(data.pop("model")), **data)


def runs_of(tables: DataFrame | Sequence[DataFrame], name: str = "tables") -> list[DataFrame]:
    """Runs as a list of tables, from one table (of several runs by the index level ``run``) or a sequence of them."""
    if not hasattr(tables, "columns"):
        if isinstance(tables, Mapping) or not len(tables):
            raise TypeError(f"`{name}` must be a table or a non-empty sequence of tables, got {tables!r:.60}")
        return [checks.columns(table, (), name=f"{name}[{i}]") for i, table in enumerate(tables)]
    if "run" in tables.index.names:
        return [run.droplevel("run") for _, run in tables.groupby(level="run", sort=False)]
    if not (np.diff(tables.index.to_numpy(float)) > 0).all():
        raise ValueError(
            f"`{name}` must have an increasing index, time in s, or the index level 'run' if it holds several runs. "
            "`pd.concat(runs, keys=range(len(runs)), names=['run'])` makes one table of several."
        )
    return [tables]


def responses_of(runs: Sequence[DataFrame], response: str | Sequence[ArrayLike] | ArrayLike) -> list[NDArray]:
    """Response in each run: a column by its name, or the series themselves, as many and as long as the runs."""
    if isinstance(response, str):
        for i, run in enumerate(runs):
            checks.columns(run, [response], name=f"tables[{i}]")
        return [checks.finite_array(f"tables[{i}][{response!r}]", run[response]) for i, run in enumerate(runs)]
    series = list(response)
    if len(runs) == 1 and series and np.ndim(series[0]) == 0:
        series = [response]
    if len(series) != len(runs):
        raise ValueError(f"`response` must have one series for each of the {len(runs)} runs, got {len(series)}")
    values = [checks.finite_array(f"response[{i}]", one, ndim=1) for i, one in enumerate(series)]
    for i, (one, run) in enumerate(zip(values, runs, strict=True)):
        if one.size != len(run):
            raise ValueError(
                f"`response` must be as long as the temperatures, got {one.size} values for {len(run)} rows in run {i}"
            )
    return values


def fit(
    model: TemperatureModel,
    tables: DataFrame | Sequence[DataFrame],
    response: str | Sequence[ArrayLike] | ArrayLike = "bias",
    *,
    run_offsets: bool = False,
    covariance: str = "ols",
    lags: int | None = None,
    warn: bool = True,
) -> TemperatureFit:
    """Fit a temperature model to one run or several together.

    Parameters
    ----------
    model : TemperatureModel
        The model.
    tables : pandas.DataFrame or sequence of it
        Runs: one table, several, or one with the index level ``run``; the columns that the model needs.
    response : str or array_like, optional
        Column of what is modelled, or its series, one for each run.
    run_offsets : bool, optional
        Whether each run has an offset of its own (sum zero): the bias is then not taken to repeat from run to run.
    covariance : str, optional
        ``"ols"``, ``"hac"`` or ``"cluster"``, as above.
    lags : int, optional
        Rows over which residuals may be correlated, for ``"hac"``; the default is ``4 (n / 100)**(2/9)`` with n rows.
    warn : bool, optional
        Whether to warn of collinear regressors.

    Returns
    -------
    TemperatureFit
        Coefficients, their errors, and the diagnostics.

    Raises
    ------
    ValueError
        If a column is missing, constant or not finite, if there are fewer rows than coefficients, or if regressors
        are linearly dependent. The message names the column.

    Warns
    -----
    UserWarning
        If the condition number passes `CONDITION_LIMIT`.
    """
    data = assemble(model, tables, response)
    return fit_assembled(data, run_offsets=run_offsets, covariance=covariance, lags=lags, warn=warn, stacklevel=3)


@dataclass(frozen=True, kw_only=True, eq=False)
class Assembled:
    """Regressors X, shape (n, k), response y, shape (n,), and number of the run, shape (n,), of all runs together."""

    model: TemperatureModel
    X: NDArray[np.float64]
    y: NDArray[np.float64]
    group: NDArray[np.int_]

    @property
    def runs(self) -> int:
        """Number of runs."""
        return int(self.group[-1]) + 1

    def without(self, point: str) -> Assembled:
        """The same less the columns of a point."""
        X = np.delete(self.X, self.model.of_point(point), axis=1)
        return Assembled(model=self.model.without(point), X=X, y=self.y, group=self.group)


def assemble(
    model: TemperatureModel,
    tables: DataFrame | Sequence[DataFrame],
    response: str | Sequence[ArrayLike] | ArrayLike = "bias",
) -> Assembled:
    """Checked regressors and response of all runs together; arguments as in `fit`."""
    checks.instance("model", model, TemperatureModel)
    runs = runs_of(tables)
    y = np.concatenate(responses_of(runs, response))
    X = np.concatenate([model.design(run, name=f"tables[{i}]").to_numpy() for i, run in enumerate(runs)])
    return Assembled(model=model, X=X, y=y, group=np.repeat(np.arange(len(runs)), [len(run) for run in runs]))


def fit_assembled(
    data: Assembled,
    *,
    run_offsets: bool = False,
    covariance: str = "ols",
    lags: int | None = None,
    warn: bool = True,
    stacklevel: int = 2,
) -> TemperatureFit:
    """Fit to what `assemble` made; arguments as in `fit`, and the level of the stack that a warning names."""
    from statsmodels.regression.linear_model import OLS

    checks.option("covariance", covariance, COVARIANCES)
    model, X, y, group = data.model, data.X, data.y, data.group
    offsets = _offset_columns(group) if run_offsets else np.empty((y.size, 0))
    k = X.shape[1]
    freedom = y.size - k - offsets.shape[1]
    if freedom < 1:
        raise ValueError(f"`tables` must have more rows than the {y.size - freedom} coefficients, got {y.size}")
    condition, vif = _collinearity(model, X, group if run_offsets else np.zeros_like(group))
    if warn and condition > CONDITION_LIMIT:
        worst = model.names[int(np.nanargmax(vif))]
        warnings.warn(
            f"the regressors of {model.name!r} are nearly collinear: condition number {condition:.3g}, and "
            f"{worst!r} has {np.nanmax(vif):.3g} times the variance that it would have alone",
            stacklevel=stacklevel,
        )
    X = np.column_stack([X, offsets])
    size = np.abs(X).max(axis=0)  # of columns: keeps rates of 1e-4 K/s beside 50 K
    result = OLS(y, X / size).fit(method="qr", **_covariance_options(covariance, group, lags))
    b = (result.params / size)[k:]
    return TemperatureFit(
        model=model,
        estimate=(result.params / size)[:k],
        covariance=(result.cov_params() / size / size[:, None])[:k, :k],
        covariance_kind=covariance,
        residual_deviation=float(np.sqrt(result.ssr / freedom)),
        r_squared=float(result.rsquared),
        observations=y.size,
        degrees_of_freedom=freedom,
        condition=condition,
        vif=vif,
        autocorrelation=_neighbours(result.resid, group),
        run_offsets=np.append(b, -b.sum()) if run_offsets else np.empty(0),
    )


def _offset_columns(group: NDArray) -> NDArray:
    """Indicators of all runs but the last, less that of the last: offsets of sum zero."""
    indicator = (group[:, None] == np.arange(group[-1] + 1)).astype(float)
    return indicator[:, :-1] - indicator[:, -1:]


def _covariance_options(covariance: str, group: NDArray, lags: int | None) -> dict:
    """Arguments of ``OLS.fit`` in statsmodels."""
    if covariance == "ols":
        return {"use_t": True}
    if covariance == "cluster":
        if group[-1] == 0:
            raise ValueError("`covariance` must not be 'cluster' for a single run")
        return {"cov_type": "cluster", "cov_kwds": {"groups": group}, "use_t": True}
    lags = int(4 * (group.size / 100) ** (2 / 9)) if lags is None else checks.integer("lags", lags, minimum=0)
    if group[-1] == 0:
        return {"cov_type": "HAC", "cov_kwds": {"maxlags": lags, "use_correction": True}, "use_t": True}
    options = {"groups": group, "maxlags": lags, "df_correction": False}
    return {"cov_type": "hac-panel", "cov_kwds": options, "use_t": True}


def _collinearity(model: TemperatureModel, X: NDArray, group: NDArray) -> tuple[float, NDArray]:
    """Condition number and variance inflation of the regressors, centred within groups and scaled."""
    vif = np.full(X.shape[1], np.nan)
    if X.shape[1] == 1:
        return 1.0, vif
    centred = X[:, 1:].copy()
    for run in range(group[-1] + 1):
        centred[group == run] -= centred[group == run].mean(axis=0)
    size = np.linalg.norm(centred, axis=0)
    still = size <= 1e-12 * np.linalg.norm(X[:, 1:], axis=0)
    if still.any():
        at = int(np.argmax(still)) + 1
        raise ValueError(f"`{model.names[at]}` must vary, got the constant {X[0, at]:g} in all rows of a run")
    _, singular, directions = np.linalg.svd(np.linalg.qr(centred / size, mode="r"))
    if singular[-1] < _SINGULAR * singular[0]:
        part = np.abs(directions[-1])
        names = [name for name, share in zip(model.names[1:], part, strict=True) if share > 0.1 * part.max()]
        within = " within runs" if group[-1] else ""
        raise ValueError(
            f"the columns {', '.join(map(repr, names))} must be linearly independent{within}, "
            f"got singular values down to {singular[-1] / singular[0]:.1e} of the largest. Leave one out"
        )
    vif[1:] = ((directions / singular[:, None]) ** 2).sum(axis=0)
    return float(singular[0] / singular[-1]), vif


def _neighbours(residual: NDArray, group: NDArray) -> float:
    """Correlation of neighbouring residuals within runs."""
    same = group[1:] == group[:-1]
    total = float(residual @ residual)
    return float(residual[1:][same] @ residual[:-1][same] / total) if total else 0.0
