"""Closed forms of the nine tests against the matrix, and judgements against chi-square's own distribution."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose
from scipy.stats import chi2

from fogkit.calibration.navigation_based.turn_model import PARAMETERS
from fogkit.calibration.turn_plans import difference_variance
from fogkit.calibration.uncertainty import design
from fogkit.calibration.velocity_noise import SensorNoise
from fogkit.estimation.consistency import chi_square_interval
from fogkit.noise import RandomErrors
from fogkit.reproduction.klimkovich import campaigns, confidence, paper, plan_search, tables
from fogkit.stand.turn_tests import nine_tests
from fogkit.units import PPM

STORED = Path(__file__).parents[2] / "data" / "derived" / "klimkovich_batch_deviations.csv"


def test_closures_are_all_that_no_error_reaches():
    H = plan_search.measurement_matrix()
    rows = confidence.closures()
    assert_allclose(rows @ H, 0, atol=1e-12 * np.abs(H).max())  # rounding of sums of three elements
    assert np.linalg.matrix_rank(np.column_stack([H, rows.T])) == 18


def test_chi_square_of_the_fit_is_that_of_the_closures():
    rng = np.random.default_rng(3)
    for _ in range(5):
        changes, deviations = rng.standard_normal(18), rng.uniform(0.2, 5, 18)
        fitted = confidence.fitted_chi_square(changes, deviations)
        assert_allclose(confidence.closure_chi_square(changes, deviations), fitted, rtol=1e-9)  # rounding x condition


@pytest.mark.parametrize("turns", [0, 1, 5])
def test_block_in_closed_form_for_any_diagonal_covariance(turns):
    """Against (27) with the whole matrix; unequal levels in all rows."""
    levels = np.random.default_rng(turns).uniform(0.5, 3, 18)
    plan = nine_tests(turns)
    H = np.concatenate([design(test, gravity=1.0) for test in plan])
    found = dict(zip(PARAMETERS, tables.deviations(levels, H), strict=True))
    across = 1 - confidence.closures().sum(axis=0)
    for block, (name, cells) in enumerate(confidence.TRIPLES.items()):
        chosen = levels[np.flatnonzero(across[6 * block : 6 * block + 6]) + 6 * block]
        closed = confidence.block_deviations(chosen, turns)
        assert_allclose(closed["scale_factor"], found[name], rtol=1e-9)
        assert_allclose(closed["bias"], found[cells[0]], rtol=1e-9)
        assert_allclose(closed["sum"] ** 2, found[cells[2]] ** 2 - found[cells[1]] ** 2, rtol=1e-9)


def test_scale_factor_cells_follow_from_the_others_for_any_diagonal_covariance(monkeypatch):
    """A table made with random levels: the rule gives its scale factors back."""
    levels = np.random.default_rng(8).uniform(1.5e-5, 3e-5, 18)
    made = dict(zip(PARAMETERS, tables.deviations(levels), strict=True))
    table = {name: value / tables.unit(name) for name, value in made.items()}
    monkeypatch.setattr(paper, "TABLE_1", table)
    assert_allclose(
        confidence.scale_factors_of_table_1().follows, [made[name] / PPM for name in confidence.TRIPLES], rtol=1e-9
    )


def test_printed_scale_factors_do_not_follow():
    table = confidence.scale_factors_of_table_1()
    assert ((table.low < table.follows) & (table.follows < table.high)).all()
    # the rounding of three cells to 3 or 4 digits leaves about half a percent
    assert ((table.high - table.low) / table.follows < 0.02).all()
    assert (table.printed > table.high).all()
    fitted = [tables.fitted(name) for name in table.index]
    assert_allclose(table.follows, fitted, rtol=0.02)  # four levels leave 0.8 % in the other cells


def test_judged_by_the_right_noise_all_is_well():
    noise = campaigns.NOISE["walk"]
    found = confidence.judge(nine_tests(), noise, noise, rng=np.random.default_rng(1), dt=0.1, draws=20000)
    assert_allclose(found.ratio, 1, rtol=1e-6)  # rounding x condition of the normal equations
    assert found.degrees_of_freedom == 18
    quantiles = np.linspace(0.05, 0.95, 7)
    expected = chi2(18).ppf(quantiles)
    assert_allclose(np.quantile(found.chi_square, quantiles), expected, rtol=0.02)  # 4 sigma of 20000 draws
    assert abs(found.rejected() - 0.05) < 4 * np.sqrt(0.05 * 0.95 / 20000)


def test_twice_the_noise_is_twice_the_deviation_and_four_times_chi_square():
    noise = campaigns.NOISE["white"]
    errors = noise.accelerometers[0]
    double = SensorNoise(accelerometers=replace(errors, quantization=2 * errors.quantization))
    options = {"dt": 0.1, "scale_factors": False}
    found = confidence.judge(nine_tests(), noise, double, rng=np.random.default_rng(2), **options)
    assert_allclose(found.ratio, 2, rtol=1e-6)
    assert_allclose(found.chi_square.mean(), 4 * 3, rtol=4 * np.sqrt(2 / 3 / 20000))


def test_vertical_slopes_do_not_see_gyros():
    """Angle random walk of twice the size: the eighteen degrees of freedom notice it no better than the three."""
    walk = campaigns.NOISE["walk"]
    double = SensorNoise(
        gyros=RandomErrors(angle_random_walk=2 * walk.gyros[0].angle_random_walk), accelerometers=walk.accelerometers[0]
    )
    table = confidence.judgements(nine_tests(), walk, {"double": double}, rng=np.random.default_rng(4))
    row = table.loc["double"]
    assert row.rejected < row.rejected_level
    variances = [difference_variance(noise, 10.0, 15.0) for noise in (double, walk)]
    # the closed form leaves out terms of the step over the dwell, 1e-3
    assert_allclose(row.largest_ratio, np.sqrt(variances[0] / variances[1]), rtol=3e-3)


def test_swaying_against_lines_through_sampled_sines():
    """Many phases, numpy's own fit; and the limit of fast sway, 6 / (pi f sqrt(12 dt T))."""
    dwell, dt, frequency = 4.0, 0.02, 3.3
    time = dt * np.arange(round(dwell / dt))
    slopes, variances = [], []
    for phase in 2 * np.pi * np.arange(16) / 16:
        velocity = np.sin(2 * np.pi * frequency * time + phase)
        fit, (ssr, *_) = np.polynomial.polynomial.polyfit(time, velocity, 1, full=True)
        slopes.append(fit[1])
        variances.append(ssr[0] / (len(time) - 2) / np.sum((time - time.mean()) ** 2))
    expected = np.sqrt(np.mean(np.square(slopes)) / np.mean(variances))
    assert_allclose(confidence.swaying(frequency, dwell, dt), expected, rtol=1e-9)
    # weights of a slope pass 12 |cos(pi f T)| / (2 pi f T^2) of a fast sway, white noise sqrt(12 dt / T^3)
    fast, dwell, dt = np.linspace(5.0, 10.0, 501), 10.0, 5e-3  # whole periods of the cosine
    ratio = np.sqrt(np.mean((confidence.swaying(fast, dwell, dt) * fast) ** 2))
    limit = 6 / (np.sqrt(2) * np.pi * np.sqrt(12 * dt * dwell))
    assert_allclose(ratio, limit, rtol=0.02)  # of the second order in f dt and in 1 / (f T)


def test_stored_batch_deviations_are_those_of_the_code():
    stored = pd.read_csv(STORED, index_col="state")
    assert list(stored.columns) == list(confidence.BATCH_KINDS)
    fresh = confidence.batch_deviations(["changes of slope"])
    column = fresh.columns[0]
    assert_allclose(fresh[column], stored[column], rtol=1e-5)  # stored with 7 digits
    grown = stored.iloc[:, 1:].to_numpy()
    assert (np.diff(grown, axis=1) > -1e-6 * grown[:, 1:]).all()  # more states never sharpen any


def test_runs_with_other_seeds_are_repeatable_and_consistent():
    stored = pd.read_csv(STORED.with_name("klimkovich_noise_runs_again.csv"))
    assert list(stored.seed) == list(range(600, 1200))
    fresh = campaigns.noise_run(700, "walk", "paper", "noise")
    row = stored.set_index("seed").loc[700]
    names = [name for name in stored.columns if name[:2] in ("m_", "b_")]
    # the iteration ends when the correction is below 0.01 of a deviation
    assert_allclose([fresh[name] for name in names], row[names].astype(float), rtol=1e-2, atol=2e-2)
    for name, freedom in (("nees", 18), ("chi_square", 18)):
        low, high = chi_square_interval(freedom, len(stored), 0.95)
        assert low < stored[name].mean() < high


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: confidence.block_deviations([1.0, 2.0]), "`across`"),
        (lambda: confidence.swaying(60.0, 10.0), "`frequency`"),
        (lambda: confidence.batch_deviations(["no"]), "`kinds`"),
        (lambda: confidence.closure_chi_square(np.ones(17), np.ones(18)), "`changes`"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(ValueError, match=message):
        call()
