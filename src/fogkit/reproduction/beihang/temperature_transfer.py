"""Where a compensation may be used: another level of assembly, another run, another state of heat (section 3.4).

The slides have no data. Each function puts one statement to a simulated test and returns numbers, rates in rad/s. They
hold for these networks and this gyro; that a real gyro's bias is linear in temperatures and rates is assumed, not
tested.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fogkit import checks
from fogkit.reproduction.beihang.temperature_tests import TRUE_POINTS, left_over, plan, root_mean_square, row_noise
from fogkit.results import Record
from fogkit.thermal import experiment, models, selection
from fogkit.thermal.regression import fit
from fogkit.units import DEG_PER_HOUR

if TYPE_CHECKING:
    from pandas import DataFrame


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
        experiment.campaign(network, plan(), **options) for network in (alone, alone, unit, unit)
    )
    candidates = [point for point in experiment.POINTS if point in alone.nodes]
    at_gyro = selection.prune(gyro_runs, candidates, noise=row_noise(meter)).fit
    at_unit = fit(models.steady_state(), unit_runs, warn=False)
    residuals = [[t["bias"].to_numpy() - f.predict(t) for t in unit_test] for f in (at_gyro, at_unit)]
    gyro_in_unit, unit_in_unit = (float(np.concatenate(r).std()) for r in residuals)
    return LevelComparison(
        before=float(np.concatenate([t["bias"] for t in unit_test]).std()),
        gyro_at_gyro=left_over(at_gyro, gyro_test),
        gyro_in_unit=gyro_in_unit,
        unit_in_unit=unit_in_unit,
        ratio=gyro_in_unit / unit_in_unit,
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
        tables = experiment.campaign(experiment.in_unit(), plan(), effects={"bias": gyro}, rng=rng)
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
