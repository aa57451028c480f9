"""What a least-squares fit gives back."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from fogkit.results import FrozenArrays

if TYPE_CHECKING:
    import pandas as pd

Direction = Mapping[str, float]
"""A combination of parameters: the coefficient of each that takes part, the first one 1."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Solution(FrozenArrays):
    """Estimate of a least-squares fit, how sure it is, and what the data leave open.

    Attributes
    ----------
    names : tuple of str
        The p parameters, in the order of all arrays.
    estimate : ndarray, shape (p,)
        Estimates; NaN for a parameter that neither data nor priors determine.
    covariance : ndarray, shape (p, p)
        Covariance of the estimates; infinite variance and NaN covariances where the estimate is NaN.
    residuals : ndarray, shape (n,)
        Observations less fit, in the unit of the observations.
    whitened_residuals : ndarray, shape (n,)
        The same, decorrelated and in units of the noise that was given (of 1 where none was).
    leverage : ndarray, shape (n,)
        Share of each observation's own error that the fit follows, 0 to 1 for uncorrelated noise.
    chi_square : float
        Sum of the squared whitened residuals and of the squared departures from the priors.
    degrees_of_freedom : int
        Observations and prior rows less the parameters that they determine.
    scale : {"given", "estimated"}
        Whether the noise level was taken as given, or from the scatter of the residuals.
    noise_scale : float
        What multiplies the given noise in `covariance`: ``sqrt(chi_square / degrees_of_freedom)`` if estimated, else 1.
    condition : float
        Condition number of the whitened design with columns of unit length, without priors; infinite if `rank` < p.
    rank : int
        Number of independent combinations of parameters that the data alone determine.
    unobservable : tuple of dict
        Directions in which the parameters can move without any change in the data; priors do not count.
    undetermined : tuple of dict
        The same with priors counted: empty if every parameter has an estimate.
    evaluations : int
        Points that a nonlinear search tried, those for numerical derivatives not counted; 0 for a linear problem.
    """

    names: tuple[str, ...]
    estimate: NDArray[np.float64]
    covariance: NDArray[np.float64]
    residuals: NDArray[np.float64]
    whitened_residuals: NDArray[np.float64]
    leverage: NDArray[np.float64]
    chi_square: float
    degrees_of_freedom: int
    scale: Literal["given", "estimated"]
    noise_scale: float
    condition: float
    rank: int
    unobservable: tuple[Direction, ...] = ()
    undetermined: tuple[Direction, ...] = ()
    evaluations: int = 0

    def __getitem__(self, name: str) -> float:
        """Estimate of one parameter."""
        return float(self.estimate[self.index(name)])

    def index(self, name: str) -> int:
        """Place of a parameter in the arrays; ``KeyError`` with all names if there is none of that name."""
        if name not in self.names:
            raise KeyError(f"`{name}` is no parameter of this solution; they are {_quoted(self.names)}")
        return self.names.index(name)

    @property
    def standard_deviation(self) -> NDArray[np.float64]:
        """Standard deviations of the estimates, shape (p,); infinite where the estimate is NaN."""
        return np.sqrt(np.diagonal(self.covariance))

    @property
    def correlation(self) -> NDArray[np.float64]:
        """Correlation matrix of the estimates, shape (p, p), with ones on the diagonal."""
        deviation = np.where(np.isfinite(self.standard_deviation), self.standard_deviation, 1.0)
        deviation = np.where(deviation > 0, deviation, 1.0)  # a perfect fit with estimated scale has none
        correlation = self.covariance / deviation[:, None] / deviation
        np.fill_diagonal(correlation, 1.0)
        return correlation

    @property
    def redundancy(self) -> NDArray[np.float64]:
        """One less the leverage, shape (n,): the part of an observation's own error that its residual shows.

        Near 0 nothing checks the observation, and an error in it goes unseen into the estimates.
        """
        return 1 - self.leverage

    @property
    def p_value(self) -> float:
        """Probability of a larger chi-square by chance.

        Near 0 the noise is larger than given or the model wrong, near 1 the noise is smaller. NaN where the chi-square
        tests nothing: with an estimated scale, or without a degree of freedom.
        """
        if self.scale == "estimated" or self.degrees_of_freedom == 0:
            return math.nan
        from scipy.special import chdtrc  # loaded where used

        return float(chdtrc(self.degrees_of_freedom, self.chi_square))

    def unobservable_parameters(self) -> tuple[str, ...]:
        """Names of the parameters that take part in an unobservable direction."""
        return _participants(self.names, self.unobservable)

    def raise_if_unobservable(self, subject: str = "the data", *, priors_help: bool = False) -> None:
        """``ValueError`` that names the parameters which the data do not determine, and the combinations.

        Parameters
        ----------
        subject : str, optional
            What fails to determine them, for the message: "the plan", say.
        priors_help : bool, optional
            True: only what is open even with the priors is an error, so a nuisance parameter may rest on its prior.
        """
        directions = self.undetermined if priors_help else self.unobservable
        if directions:
            open_names = _quoted(_participants(self.names, directions))
            raise ValueError(f"{subject} does not determine {open_names}: {'; '.join(map(_in_words, directions))}")

    def to_frame(self) -> pd.DataFrame:
        """Table with the columns `estimate` and `standard_deviation`, index `name`."""
        import pandas as pd  # loaded where used

        columns = {"estimate": self.estimate, "standard_deviation": self.standard_deviation}
        return pd.DataFrame(columns, index=pd.Index(self.names, name="name"))

    def to_json(self) -> str:
        """Text that `from_json` turns into an equal record, every bit of every number included."""
        return json.dumps({field.name: _encoded(getattr(self, field.name)) for field in fields(self)}, allow_nan=False)

    @classmethod
    def from_json(cls, text: str) -> Solution:
        """Record from the text of `to_json`; ``ValueError`` if a field is missing or unknown."""
        values = json.loads(text)
        known = {field.name: field.type for field in fields(cls)}
        if not isinstance(values, dict) or set(values) != set(known):
            came = sorted(values) if isinstance(values, dict) else type(values).__name__
            raise ValueError(f"`text` must hold the fields {_quoted(known)}, got {came}")
        return cls(**{name: _decoded(values[name], kind) for name, kind in known.items()})


def _participants(names: tuple[str, ...], directions: tuple[Direction, ...]) -> tuple[str, ...]:
    """Names with a coefficient in any of the directions, in the order of the parameters."""
    return tuple(name for name in names if any(name in direction for direction in directions))


def _in_words(direction: Direction) -> str:
    """Direction as a message says it."""
    if len(direction) == 1:
        return f"no observation depends on `{next(iter(direction))}`"
    first, *others = (f"{coefficient:+.4g} `{name}`" for name, coefficient in direction.items())
    return f"no observation changes along {' '.join([first.removeprefix('+1 '), *others])}"


def _quoted(names: Any) -> str:
    """Names in backticks."""
    return ", ".join(f"`{name}`" for name in names)


def _encoded(value: Any) -> Any:
    """Value as strict JSON has it: infinities and NaN, which it lacks, as text."""
    if isinstance(value, np.ndarray):
        return _encoded(value.tolist())
    if isinstance(value, list | tuple):
        return [_encoded(entry) for entry in value]
    if isinstance(value, Mapping):
        return {name: _encoded(entry) for name, entry in value.items()}
    return repr(value) if isinstance(value, float) and not math.isfinite(value) else value


def _decoded(value: Any, kind: str) -> Any:
    """Inverse of `_encoded` for a field of a given annotation."""
    if kind.startswith("NDArray"):
        return np.array(value, dtype=object).astype(np.float64)
    if kind.startswith("tuple"):
        return tuple(value)
    return float(value) if kind == "float" else value
