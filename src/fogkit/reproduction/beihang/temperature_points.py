"""Which points and which order a temperature model needs, and what the data can tell (section 3.4).

The slides have no data. Each function puts one statement to a simulated test and returns numbers, rates in rad/s. They
hold for these networks and this gyro; that a real gyro's bias is linear in temperatures and rates is assumed, not
tested.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fogkit import checks
from fogkit.reproduction.beihang.temperature_tests import TRUE_POINTS, plan, row_noise
from fogkit.results import Record
from fogkit.thermal import experiment, models, rates, selection
from fogkit.thermal.network import CHAMBER, ThermalNetwork, soak
from fogkit.thermal.regression import fit
from fogkit.units import HOUR

if TYPE_CHECKING:
    from pandas import DataFrame


TREATMENTS = ("samples", "samples, hac", "rows", "rows and thermometers")
"""How `pruning_rates` makes regression rows of samples; the last is right."""


@dataclass(frozen=True, kw_only=True)
class PointsNeeded(Record):
    """Drift in runs not used in the fit, rad/s, before and after compensation with some points; and the points kept."""

    before: float
    one: float
    two: float
    three: float
    six: float
    kept: tuple[str, ...]


def points_needed(seed: int = 34) -> PointsNeeded:
    """Drift left with one, two, three and six points, and which of six are kept.

    "Take at least two positions"; "points of insignificant effect are dropped, and both faces of the coil and the
    electronics kept".
    """
    meter = experiment.Thermometer()
    rng = np.random.default_rng(seed)
    tables = experiment.campaign(experiment.in_unit(), plan(), rng=rng, thermometer=meter)
    compared = {
        "one": models.single_point(),
        "two": models.start_up_long(),
        "three": models.steady_state(),
        "six": models.several_points(experiment.POINTS),
    }
    rows = selection.cross_validate(compared, tables)
    kept = selection.prune(tables, experiment.POINTS, noise=row_noise(meter)).kept
    return PointsNeeded(before=float(rows["before"].iloc[0]), kept=kept, **rows["after"].to_dict())


@dataclass(frozen=True, kw_only=True)
class PruningRates(Record):
    """Shares of campaigns in which pruning kept every true point, and in which it found exactly these.

    Attributes
    ----------
    runs : int
        Campaigns.
    kept_true, exact : float
        Shares.
    false_points : float
        Mean number of points without effect that were kept.
    """

    runs: int
    kept_true: float
    exact: float
    false_points: float


def pruning_rates(
    seeds: Iterable[int] = range(200),
    treatment: str = TREATMENTS[-1],
    *,
    strength: float = 1.0,
    thermometer_noise: float = 0.01,
) -> PruningRates:
    """How often pruning six points finds the three that count.

    The rates are those of this network, gyro, schedule and thermometers: where effects are weaker or thermometers
    noisier, the points are not told apart.

    Parameters
    ----------
    seeds : iterable of int, optional
        One campaign of ten runs, 32 h, for each.
    treatment : str, optional
        ``"samples"``: a regression row for every sample of 10 s, with the running rate of its window, as if rows were
        independent and thermometers exact; ``"samples, hac"``: the same with errors that allow for correlated
        residuals; ``"rows"``: one row per window, thermometers as if exact; ``"rows and thermometers"``: with their
        noise.
    strength : float, optional
        Factor on all coefficients of the gyro.
    thermometer_noise : float, optional
        Noise of a sample of the thermometers, K; their resolution is half of it.
    """
    checks.option("treatment", treatment, TREATMENTS)
    gyro, factor = experiment.example_gyro(), checks.positive("strength", strength)
    gyro = replace(
        gyro,
        temperature={point: factor * value for point, value in gyro.temperature.items()},
        rate={point: factor * value for point, value in gyro.rate.items()},
    )
    sampled = treatment.startswith("samples")
    window = None if sampled else experiment.WINDOW
    meter = experiment.Thermometer(noise=thermometer_noise, resolution=0.5 * thermometer_noise)
    options = {"noise": row_noise(meter)} if treatment == TREATMENTS[-1] else {}
    options |= {"covariance": "hac", "lags": 24} if treatment == "samples, hac" else {}
    found = []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        effects = {"bias": gyro}
        tables = experiment.campaign(
            experiment.in_unit(), plan(), window=window, effects=effects, thermometer=meter, rng=rng
        )
        if sampled:
            running = rates.RateFilter(window=experiment.WINDOW)
            tables = [rates.add_rates(table, running) for table in tables]
        found.append(set(selection.prune(tables, experiment.POINTS, **options).kept))
    true = set(TRUE_POINTS)
    return PruningRates(
        runs=len(found),
        kept_true=float(np.mean([kept >= true for kept in found])),
        exact=float(np.mean([kept == true for kept in found])),
        false_points=float(np.mean([len(kept - true) for kept in found])),
    )


@dataclass(frozen=True, kw_only=True)
class PolynomialOrder(Record):
    """Which order of a polynomial in temperature the data support.

    Attributes
    ----------
    p_values : tuple of float
        p-value of the highest term of the polynomials of order 1 to 4.
    deviations : tuple of float
        Standard deviation of their residuals, in the unit of the quantity.
    order : int
        Highest order whose term is significant at 1 %.
    """

    p_values: tuple[float, ...]
    deviations: tuple[float, ...]
    order: int


def accelerometer_order(seed: int = 34) -> PolynomialOrder:
    """Order of the bias of an accelerometer in its temperature, from the warm runs: "a third-order model"."""
    return _order(experiment.example_accelerometer(), seed)


def scale_factor_order(seed: int = 34) -> PolynomialOrder:
    """Order of the scale factor of a gyro in the temperature of its source, from the warm runs: "a linear model"."""
    return _order(experiment.example_scale_factor(), seed)


def _order(effect: experiment.PolynomialEffect, seed: int) -> PolynomialOrder:
    """Order of a quantity in the temperature of its point."""
    rng = np.random.default_rng(seed)
    plan = experiment.warm_runs()
    tables = experiment.campaign(experiment.in_unit(), plan, effects={"quantity": effect}, rng=rng)
    results = [
        fit(models.start_up_short(effect.point, degree=degree), tables, "quantity", warn=False)
        for degree in (1, 2, 3, 4)
    ]
    p = [float(result.p_value[-1]) for result in results]
    order = max((i for i, value in enumerate(p, start=1) if value < 0.01), default=0)
    return PolynomialOrder(
        p_values=tuple(p), deviations=tuple(result.residual_deviation for result in results), order=order
    )


@dataclass(frozen=True, kw_only=True)
class StartUpCollinearity(Record):
    """Condition numbers of temperature and rate, and the factors on standard errors that they mean.

    Attributes
    ----------
    single_constant : float
        Condition number in the warm-up of a body with a single time constant, thermometer exact.
    unit_from_power_on, unit_after_half_hour : float
        In one start of the unit, at the upper face of the coil: from the power on, and from half an hour after it.
    unit_six_starts : float
        In six starts from different temperatures together.
    six_starts_with_offsets : float
        The same with a bias of its own for each start.
    """

    single_constant: float
    unit_from_power_on: float
    unit_after_half_hour: float
    unit_six_starts: float
    six_starts_with_offsets: float


def start_up_collinearity(point: str = "coil_top", seed: int = 34) -> StartUpCollinearity:
    """Whether data of starts can tell the effect of a temperature from that of its rate."""
    body = ThermalNetwork(capacities={"body": 500.0}, conductances={("body", CHAMBER): 0.5}, heat={"body": 5.0})
    warm_up = experiment.Run(name="warm-up", profile=soak(20.0), duration=HOUR, powered=False)
    exact = experiment.campaign(body, [warm_up], effects={})
    rng = np.random.default_rng(seed)
    tables = experiment.campaign(experiment.in_unit(), experiment.start_ups(), rng=rng)
    one = tables[3]  # at 20 degC

    def condition(data: list[DataFrame], point: str, run_offsets: bool = False) -> float:
        return selection.separability(data, point, run_offsets=run_offsets, warn=False).condition

    return StartUpCollinearity(
        single_constant=condition(exact, "body"),
        unit_from_power_on=condition([one], point),
        unit_after_half_hour=condition([one[one.index > 0.5 * HOUR]], point),
        unit_six_starts=condition(tables, point),
        six_starts_with_offsets=condition(tables, point, run_offsets=True),
    )
