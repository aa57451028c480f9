"""Models of the effect of temperature: which temperatures and rates enter, and to which power.

The slides that these models come from have lost their formulas; each constructor says how it was rebuilt from the text.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

import numpy as np

from fogkit import checks
from fogkit.thermal.rates import RATE, TEMPERATURE

if TYPE_CHECKING:
    from pandas import DataFrame

CONSTANT = "constant"
"""Name of the coefficient that every model has."""


@dataclass(frozen=True, kw_only=True)
class Term:
    """One term of a model: a power of a temperature less the reference, or the rate of a temperature.

    Parameters
    ----------
    point : str
        The measuring point: ``coil_top`` for the columns ``temperature_coil_top`` and ``rate_coil_top``.
    power : int, optional
        Power of the temperature.
    rate : bool, optional
        Whether the term is the rate.
    """

    point: str
    power: int = 1
    rate: bool = False

    def __post_init__(self) -> None:
        checks.instance("point", self.point, str)
        checks.integer("power", self.power, minimum=1)
        if self.rate and self.power != 1:
            raise ValueError(f"`power` must be 1 for a rate, got {self.power}")

    @property
    def column(self) -> str:
        """Column of the table that the term needs."""
        return (RATE if self.rate else TEMPERATURE) + self.point

    @property
    def name(self) -> str:
        """Name of the coefficient."""
        return self.column + (f"^{self.power}" if self.power > 1 else "")


@dataclass(frozen=True, kw_only=True)
class TemperatureModel:
    """A constant plus a linear combination of terms.

    Parameters
    ----------
    name : str
        What the model is called in tables.
    terms : sequence of Term
        Its terms, no two alike.
    reference : float, optional
        Temperature that is taken off every temperature, degC. It moves the constant, and where higher powers stand, the
        lower ones.

    Examples
    --------
    >>> steady_state().names
    ('constant', 'temperature_coil_top', 'rate_coil_top', ..., 'temperature_electronics', 'rate_electronics')
    """

    name: str
    terms: Sequence[Term]
    reference: float = 0.0

    def __post_init__(self) -> None:
        terms = tuple(checks.instance("terms", term, Term) for term in self.terms)
        if len(set(terms)) < len(terms):
            raise ValueError(f"`terms` must be different, got {[term.name for term in terms]}")
        object.__setattr__(self, "terms", terms)
        object.__setattr__(self, "reference", checks.finite("reference", self.reference, "degC"))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coefficients, the constant first."""
        return (CONSTANT, *(term.name for term in self.terms))

    @property
    def points(self) -> tuple[str, ...]:
        """Measuring points, in the order in which they enter."""
        return tuple(dict.fromkeys(term.point for term in self.terms))

    def of_point(self, point: str) -> list[int]:
        """Positions in `names` of the coefficients of a point: its temperature together with its rate."""
        checks.option("point", point, self.points)
        return [i for i, term in enumerate(self.terms, start=1) if term.point == point]

    def without(self, point: str) -> TemperatureModel:
        """The model less a point with its rate."""
        checks.option("point", point, self.points)
        kept = [term for term in self.terms if term.point != point]
        return TemperatureModel(name=self.name, terms=kept, reference=self.reference)

    def design(self, table: DataFrame, *, name: str = "table") -> DataFrame:
        """Regressors, one column for each of `names`, in the rows of the table.

        Raises
        ------
        ValueError
            If a column is missing or holds a NaN; the message names it.
        """
        import pandas as pd

        fix = "`thermal.rates.reduce` or `add_rates` makes the columns rate_*"
        checks.columns(table, dict.fromkeys(term.column for term in self.terms), name=name, fix=fix)
        columns = {CONSTANT: np.ones(len(table))}
        for term in self.terms:
            values = checks.finite_array(f"{name}[{term.column!r}]", table[term.column].to_numpy(), ndim=1)
            columns[term.name] = values if term.rate else (values - self.reference) ** term.power
        return pd.DataFrame(columns, index=table.index)

    def to_dict(self) -> dict:
        """Plain values from which `from_dict` makes an equal model."""
        return {"name": self.name, "terms": [asdict(term) for term in self.terms], "reference": self.reference}

    @classmethod
    def from_dict(cls, data: dict) -> TemperatureModel:
        """Model from the values of `to_dict`."""
        terms = [Term(**term) for term in data["terms"]]
        return cls(name=data["name"], terms=terms, reference=data["reference"])


def constant_only() -> TemperatureModel:
    """No model: one number for the bias. What the others are compared with."""
    return TemperatureModel(name="constant", terms=())


def several_points(points: Iterable[str], *, name: str | None = None, reference: float = 0.0) -> TemperatureModel:
    """Multiple linear regression on temperatures and rates of m points.

    ``D = a_0 + sum_i (a_i T_i + b_i dT_i/dt) + e``. The text names the temperature and the rate of the i-th position,
    the coefficients, the response and a random error: rebuilt as the sum over points. It asks for at least two.
    """
    points = tuple(points)
    terms = [Term(point=point, rate=rate) for point in points for rate in (False, True)]
    name = f"{len(points)} points with rates" if name is None else name
    return TemperatureModel(name=name, terms=terms, reference=reference)


def single_point(point: str = "coil_top", *, reference: float = 0.0) -> TemperatureModel:
    """Bias against one temperature and its rate: ``B = B_0 + k_T T + k_R dT/dt``.

    The text names the bias, a constant, and the coefficients of the temperature and of its rate.
    """
    return several_points([point], name="one point", reference=reference)


def start_up_short(point: str = "coil_top", *, degree: int = 1, reference: float = 25.0) -> TemperatureModel:
    """Bias of a short run against the temperature of one monitored point, without rates: ``B = B_0 + k (T - T_ref)``.

    The text names the monitored temperature, a reference temperature and a random error, and not the degree: rebuilt as
    linear, with a polynomial as an option.
    """
    terms = [Term(point=point, power=power) for power in range(1, checks.integer("degree", degree, minimum=1) + 1)]
    return TemperatureModel(name="short start-up", terms=terms, reference=reference)


def start_up_long(optics: str = "coil_top", electronics: str = "electronics") -> TemperatureModel:
    """Bias of a long run from the power on, against temperatures of optics and electronics and their rates.

    Four variables, as the text counts them.
    """
    return several_points([optics, electronics], name="long start-up")


def steady_state(points: Iterable[str] = ("coil_top", "coil_bottom", "electronics")) -> TemperatureModel:
    """Bias in steady operation against temperatures of both faces of the coil and of the electronics, and their rates.

    Six variables, as the text counts them.
    """
    return several_points(points, name="steady state")


def accelerometer_bias(point: str = "accelerometer", *, reference: float = 25.0) -> TemperatureModel:
    """Bias of an accelerometer, of third order: ``K = K_0 + K_1 (T - T_ref) + K_2 (T - T_ref)^2 + K_3 (T - T_ref)^3``.

    The text names the bias at some temperature and the coefficients of first, second and third order; that the powers
    are those of a difference from that temperature is rebuilt.
    """
    terms = [Term(point=point, power=power) for power in (1, 2, 3)]
    return TemperatureModel(name="accelerometer bias", terms=terms, reference=reference)


def scale_factor(point: str = "source", *, reference: float = 0.0) -> TemperatureModel:
    """Scale factor, linear in one temperature: ``S = s_0 + s_1 T``; the text names both coefficients."""
    return TemperatureModel(name="scale factor", terms=[Term(point=point)], reference=reference)
