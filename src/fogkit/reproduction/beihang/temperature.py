"""What the slides state about temperature (section 3.4), tested in the networks of `fogkit.thermal.experiment`.

The slides have no data. Each function puts one statement to a simulated test and returns numbers, rates in rad/s. They
hold for these networks and this gyro; that a real gyro's bias is linear in temperatures and rates is assumed, not
tested.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.results import Record
from fogkit.thermal import experiment, models, rates, selection
from fogkit.thermal.network import CHAMBER, ThermalNetwork, soak
from fogkit.thermal.regression import fit
from fogkit.units import DEG_PER_HOUR, HOUR

if TYPE_CHECKING:
    from pandas import DataFrame

TRUE_POINTS = ("coil_top", "coil_bottom", "electronics")
"""Points that the bias of the simulated gyro depends on, which are those that the slides keep."""

TREATMENTS = ("samples", "samples, hac", "rows", "rows and thermometers")
"""How `pruning_rates` makes regression rows of samples; the last is right."""


def root_mean_square(values: Sequence[NDArray]) -> float:
    """Root mean square of several series together."""
    return float(np.sqrt(np.mean(np.concatenate(values) ** 2)))


def _left(result, tables: list[DataFrame]) -> float:
    """What a fit leaves of the bias of some runs."""
    return root_mean_square([table["bias"].to_numpy() - result.predict(table) for table in tables])


def _plan() -> list[experiment.Run]:
    """Starts and warm runs."""
    return experiment.start_ups() + experiment.warm_runs()


def _row_noise(thermometer: experiment.Thermometer, interval: float = 10.0) -> tuple[float, float]:
    """Errors of the rows of a campaign."""
    return rates.row_noise(thermometer.deviation, interval, experiment.WINDOW)


@dataclass(frozen=True, kw_only=True)
class LevelComparison(Record):
    """Root mean squares over runs not used in a fit, rad/s.

    Attributes
    ----------
    before : float
        Bias in the unit, about its mean.
    gyro_at_gyro : float
        Left by the gyro-level fit at gyro level: what its maker sees.
    gyro_in_unit : float
        Left by the same fit in the unit, less its mean: a constant is always found anew.
    unit_in_unit : float
        Left by the fit of the system-level test, less its mean.
    ratio : float
        Of the last two.
    """

    before: float
    gyro_at_gyro: float
    gyro_in_unit: float
    unit_in_unit: float
    ratio: float


def gyro_level_against_system_level(
    noise_factor: float = 1.0, seed: int = 34, *, asymmetry: float = 0.0
) -> LevelComparison:
    """Compensation from a test of the gyro alone, used in the unit, against one from a test of the unit.

    "The result of a temperature test of the gyro alone can only be a reference and cannot replace the test of the whole
    system, the more so the higher the accuracy." The gyro-level model is what pruning keeps at that level.

    Parameters
    ----------
    noise_factor : float, optional
        Factor on all noise, of gyro and thermometers, and on the repeatability: below 1 for a more accurate gyro.
    seed : int, optional
        Seed of the noise.
    asymmetry : float, optional
        Of the gyro alone, as in `fogkit.thermal.experiment.alone`.
    """
    factor = checks.positive("noise_factor", noise_factor)
    rng = np.random.default_rng(seed)
    gyro = experiment.example_gyro()
    gyro = replace(
        gyro,
        angle_random_walk=factor * gyro.angle_random_walk,
        bias_repeatability=factor * gyro.bias_repeatability,
    )
    meter = experiment.Thermometer(noise=0.01 * factor, resolution=0.005 * factor)
    options = {"effects": {"bias": gyro}, "thermometer": meter, "rng": rng}
    alone, unit = experiment.alone(asymmetry), experiment.in_unit()
    gyro_runs, gyro_test, unit_runs, unit_test = (
        experiment.campaign(network, _plan(), **options) for network in (alone, alone, unit, unit)
    )
    candidates = [point for point in experiment.POINTS if point in alone.nodes]
    at_gyro = selection.prune(gyro_runs, candidates, noise=_row_noise(meter)).fit
    at_unit = fit(models.steady_state(), unit_runs, warn=False)
    residuals = [[t["bias"].to_numpy() - f.predict(t) for t in unit_test] for f in (at_gyro, at_unit)]
    gyro_in_unit, unit_in_unit = (float(np.concatenate(r).std()) for r in residuals)
    return LevelComparison(
        before=float(np.concatenate([t["bias"] for t in unit_test]).std()),
        gyro_at_gyro=_left(at_gyro, gyro_test),
        gyro_in_unit=gyro_in_unit,
        unit_in_unit=unit_in_unit,
        ratio=gyro_in_unit / unit_in_unit,
    )


@dataclass(frozen=True, kw_only=True)
class CoilField(Record):
    """Difference of temperature between the faces of the coil half an hour after the power on, K.

    Attributes
    ----------
    alone, in_unit : float
        In the test of the gyro alone and in the unit.
    """

    alone: float
    in_unit: float


def field_in_unit() -> CoilField:
    """Temperature field at the coil with and without neighbours that heat, in a steady chamber, exact.

    Alone the difference is zero because the network is symmetric; what a real chamber leaves is not known.

    "In a system other instruments and circuits heat too, and the field is very different."
    """

    def difference(network: ThermalNetwork) -> float:
        temperatures, _ = network.solve(np.array([0.0, 0.5 * HOUR]), soak(20.0))
        top, bottom = (network.nodes.index(point) for point in ("coil_top", "coil_bottom"))
        return float(abs(temperatures[-1, top] - temperatures[-1, bottom]))

    return CoilField(alone=difference(experiment.alone()), in_unit=difference(experiment.in_unit()))


@dataclass(frozen=True, kw_only=True)
class SteadyStateDrift(Record):
    """Drift of a warm unit in a chamber that moves, rad/s.

    Attributes
    ----------
    deviation : float
        Smallest standard deviation of the bias in a run, without noise.
    noise : float
        Of one row of the regression.
    repeatability : float
        From run to run.
    """

    deviation: float
    noise: float
    repeatability: float


def steady_state_drift() -> SteadyStateDrift:
    """Bias of a warm unit while the ambient temperature moves: "the ambient temperature still disturbs it"."""
    gyro = experiment.example_gyro()
    tables = experiment.campaign(experiment.in_unit(), experiment.warm_runs())
    return SteadyStateDrift(
        deviation=float(min(table["bias"].std() for table in tables)),
        noise=float(gyro.angle_random_walk / np.sqrt(experiment.WINDOW)),
        repeatability=gyro.bias_repeatability,
    )


@dataclass(frozen=True, kw_only=True)
class Repeatability(Record):
    """What is left after compensation against how well the bias repeats, by level, rad/s.

    Attributes
    ----------
    deviation : tuple of float
        Standard deviation of the bias from run to run that was put in.
    left : tuple of float
        Root mean square in runs not used in the fit.
    removed : tuple of float
        Share of the drift that is removed.
    """

    deviation: tuple[float, ...]
    left: tuple[float, ...]
    removed: tuple[float, ...]


def repeatability(
    levels: Iterable[float] = (0, 0.01, 0.03, 0.1, 0.3), seeds: Iterable[int] = range(4)
) -> Repeatability:
    """Compensation of a gyro whose bias repeats less and less well from run to run; levels in deg/h.

    "Temperature error can be compensated only if drift is a definite function of temperature, with good repeatability."
    One campaign for each seed; a level scales the same offsets of its runs. What is left is linear in them, so its mean
    square is a parabola of the level, and three levels determine it.
    """
    levels = checks.array_in_closed_interval("levels", list(levels), 0, np.inf, "deg/h") * DEG_PER_HOUR
    gyro, rows = experiment.example_gyro(bias_repeatability=0.0), []
    probe = 0.1 * DEG_PER_HOUR
    for seed in seeds:
        rng = np.random.default_rng(seed)
        tables = experiment.campaign(experiment.in_unit(), _plan(), effects={"bias": gyro}, rng=rng)
        offsets = rng.standard_normal(len(tables))
        for level in (0.0, probe, -probe):
            bias = [table["bias"] + level * offset for table, offset in zip(tables, offsets, strict=True)]
            row = selection.cross_validate([models.steady_state()], tables, bias).iloc[0]
            rows.append((row["before"], row["after"]))
    none, plus, minus = np.mean(np.reshape(rows, (-1, 3, 2)) ** 2, axis=0)
    share = levels[:, None] / probe
    squares = none + 0.5 * (plus - minus) * share + (0.5 * (plus + minus) - none) * share**2
    before, left = np.sqrt(squares).T
    return Repeatability(
        deviation=tuple(levels.tolist()), left=tuple(left.tolist()), removed=tuple((1 - left / before).tolist())
    )


@dataclass(frozen=True, kw_only=True)
class ShortRunLimit(Record):
    """How long the change of the bias after the power on may be neglected.

    Attributes
    ----------
    noise_time : float
        Time at which the neglected part passes the white noise of a mean over that time, s.
    repeatability_time : float
        Time at which it passes the repeatability of the bias, s.
    hundredth_time : float
        Time at which it passes 0.01 deg/h, s.
    after_minute, after_ten_minutes, after_hour : float
        Neglected part of runs of these lengths, rad/s.
    spread : float
        By how much the neglected part after ten minutes differs between starts from -40 and from 60 degC, rad/s.
    """

    noise_time: float
    repeatability_time: float
    hundredth_time: float
    after_minute: float
    after_ten_minutes: float
    after_hour: float
    spread: float


def short_run_limit() -> ShortRunLimit:
    """Time for which only the temperature at the power on matters: exact, without noise.

    "In short operation the change of temperature within the run can be neglected." What is neglected in a run of
    length t is the mean of the bias over the run less the bias at its start. The network is linear, so it is the same
    at any start temperature.
    """
    gyro, network = experiment.example_gyro(), experiment.in_unit()
    time = np.append(0.0, np.geomspace(0.01, 2 * HOUR, 4000))
    neglected = np.array([_mean_change(gyro, network, time, start) for start in (-40.0, 60.0)])
    worst = np.abs(neglected).max(axis=0)
    noise = gyro.angle_random_walk / np.sqrt(np.maximum(time, 1e-9))

    def first(limit: NDArray | float) -> float:
        return float(time[np.argmax(worst > limit)])

    after = {t: float(np.interp(t, time, worst)) for t in (60, 600, HOUR)}
    at_ten = int(np.searchsorted(time, 600))
    return ShortRunLimit(
        noise_time=first(noise),
        repeatability_time=first(gyro.bias_repeatability),
        hundredth_time=first(0.01 * DEG_PER_HOUR),
        after_minute=after[60],
        after_ten_minutes=after[600],
        after_hour=after[HOUR],
        spread=float(np.abs(np.diff(neglected[:, at_ten]))[0]),
    )


def _mean_change(gyro: experiment.CoilBias, network: ThermalNetwork, time: NDArray, start: float) -> NDArray:
    """Mean of the bias from the power on to each time, less the bias at the power on."""
    from scipy.integrate import cumulative_simpson

    bias = gyro.truth(network.nodes, *network.solve(time, soak(start)))
    change = cumulative_simpson(bias - bias[0], x=time, initial=0.0)
    return change / np.where(time > 0, time, 1.0)


@dataclass(frozen=True, kw_only=True)
class StartUpAndSteadyState(Record):
    """Root mean squares left in new runs, less the mean of each, rad/s, by where a model was fitted and is used."""

    start_in_start: float
    start_in_steady: float
    steady_in_steady: float
    steady_in_start: float


def start_up_against_steady_state(
    points: Sequence[str] = TRUE_POINTS, thermometer_noise: float = 0.01, seed: int = 34
) -> StartUpAndSteadyState:
    """Models fitted to starts used in steady operation, and the other way round.

    "Similar in that changes of the inner temperature field cause drift; different in that the heat source is inside
    in one case and outside in the other."

    Parameters
    ----------
    points : sequence of str, optional
        Points of the model. Without one that counts, the coefficients of one case are not those of the other.
    thermometer_noise : float, optional
        Noise of a sample of the thermometers, K; their resolution is half of it.
    seed : int, optional
        Seed of the noise.
    """
    meter = experiment.Thermometer(noise=thermometer_noise, resolution=0.5 * thermometer_noise)
    options = {"rng": np.random.default_rng(seed), "thermometer": meter}
    model = models.several_points(points)
    unit = experiment.in_unit()
    starts, steady = experiment.start_ups(), experiment.warm_runs()
    fits = [fit(model, experiment.campaign(unit, plan, **options), warn=False) for plan in (starts, steady)]
    tests = [experiment.campaign(unit, plan, **options) for plan in (starts, steady)]
    left = [[_left_within(result, tables) for tables in tests] for result in fits]
    return StartUpAndSteadyState(
        start_in_start=left[0][0], start_in_steady=left[0][1], steady_in_start=left[1][0], steady_in_steady=left[1][1]
    )


def _left_within(result, tables: list[DataFrame]) -> float:
    """What a fit leaves of some runs, less the mean of each."""
    residuals = [table["bias"].to_numpy() - result.predict(table) for table in tables]
    return root_mean_square([residual - residual.mean() for residual in residuals])


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
    tables = experiment.campaign(experiment.in_unit(), _plan(), rng=rng, thermometer=meter)
    compared = {
        "one": models.single_point(),
        "two": models.start_up_long(),
        "three": models.steady_state(),
        "six": models.several_points(experiment.POINTS),
    }
    rows = selection.cross_validate(compared, tables)
    kept = selection.prune(tables, experiment.POINTS, noise=_row_noise(meter)).kept
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
    options = {"noise": _row_noise(meter)} if treatment == TREATMENTS[-1] else {}
    options |= {"covariance": "hac", "lags": 24} if treatment == "samples, hac" else {}
    found = []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        effects = {"bias": gyro}
        tables = experiment.campaign(
            experiment.in_unit(), _plan(), window=window, effects=effects, thermometer=meter, rng=rng
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


EXACT = 1e-6
"""Noise of thermometers that is none, K."""


def _field_is_another_one() -> bool:
    field = field_in_unit()
    return field.in_unit > 10 * field.alone


def _gyro_level_does_not_replace() -> bool:
    levels = gyro_level_against_system_level()
    return min(levels.ratio, levels.gyro_in_unit / levels.gyro_at_gyro) > 3


def _more_so_for_higher_accuracy() -> bool:
    coarse, fine = (gyro_level_against_system_level(factor).ratio for factor in (1.0, 1 / 3))
    return fine > 2 * coarse


def _what_does_not_repeat_is_left() -> bool:
    found = repeatability()
    return bool((np.diff(found.left) > 0).all() and (np.diff(found.removed) < 0).all())


def _long_runs_need_a_model() -> bool:
    gyro, limit = experiment.example_gyro(), short_run_limit()
    noise = gyro.angle_random_walk / np.sqrt(HOUR)
    return limit.after_hour > 3 * max(gyro.bias_repeatability, noise)


def _ambient_disturbs() -> bool:
    drift = steady_state_drift()
    return drift.deviation > 3 * max(drift.noise, drift.repeatability)


def _one_law_serves_both() -> bool:
    left = start_up_against_steady_state(thermometer_noise=EXACT)
    return left.steady_in_start < 1.5 * left.start_in_start


def _one_point_does_not() -> bool:
    left = start_up_against_steady_state(("coil_top",), thermometer_noise=EXACT)
    return left.start_in_steady > 2 * left.steady_in_steady


def _pruning_finds_the_points() -> bool:
    return set(points_needed().kept) == set(TRUE_POINTS)


STATEMENTS = {
    "system": _field_is_another_one,
    "not-replaced": _gyro_level_does_not_replace,
    "more-so": _more_so_for_higher_accuracy,
    "repeatable": _what_does_not_repeat_is_left,
    "long": _long_runs_need_a_model,
    "steady-ambient": _ambient_disturbs,
    "steady-similar": _one_law_serves_both,
    "steady-mechanism": _one_point_does_not,
    "steady-pruning": _pruning_finds_the_points,
}
"""Statements of the slides by the end of their row in the ledger: whether they hold in the simulated networks."""
