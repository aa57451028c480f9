"""Fits: exact on exact data, errors that hold over many seeds, and equal to statsmodels."""

import numpy as np
import pandas as pd
import pytest
import statsmodels.formula.api as smf
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from fogkit.thermal import TemperatureFit, experiment, fit, models, regression
from fogkit.units import DEG_PER_HOUR

TWO = models.several_points(["a", "b"])


def runs(rng, count=3, rows=60, noise=0.1, offset=0.0, correlation=0.0):
    """Runs with two points and a bias that depends on the first."""
    tables = []
    for _ in range(count):
        columns = {n: rng.standard_normal(rows).cumsum() * 0.3 for n in ("temperature_a", "temperature_b")}
        columns |= {n: 0.1 * rng.standard_normal(rows) for n in ("rate_a", "rate_b")}
        error = noise * rng.standard_normal(rows)
        for i in range(1, rows):
            error[i] = correlation * error[i - 1] + np.sqrt(1 - correlation**2) * error[i]
        bias = 1 + 0.5 * columns["temperature_a"] - 2 * columns["rate_a"] + error + offset * rng.standard_normal()
        tables.append(pd.DataFrame(columns | {"bias": bias}, index=pd.Index(10.0 * np.arange(rows), name="time")))
    return tables


TRUTH = np.array([1, 0.5, -2, 0, 0])


def test_exact_data_give_the_coefficients_to_rounding():
    gyro, unit = experiment.example_gyro(), experiment.in_unit()
    plan = experiment.start_ups() + experiment.warm_runs()
    tables = experiment.campaign(unit, plan, window=None, truth=True)
    for table in tables:
        for column in [c for c in table if c.startswith("true_rate_")]:
            table[column.removeprefix("true_")] = table[column]
    result = fit(models.steady_state(), tables, warn=False)
    truth = [value for p in result.model.points for value in (gyro.temperature[p], gyro.rate[p])]
    # rounding of 1e-16 in a bias of 1e-6 times a condition number of some 1e3, over coefficients of 5e-8 per 50 K
    assert_allclose(result.estimate[1:], truth, rtol=1e-9)
    constant = gyro.constant - gyro.reference * sum(gyro.temperature.values())
    assert_allclose(result.estimate[0], constant, rtol=1e-9)


@pytest.mark.parametrize("offsets", [False, True])
def test_numbers_are_those_of_statsmodels(offsets):
    tables = runs(np.random.default_rng(1), offset=0.5)
    result = fit(TWO, tables, run_offsets=offsets)
    stacked = pd.concat(tables, keys=range(3), names=["run"])
    assert_allclose(fit(TWO, stacked, run_offsets=offsets).estimate, result.estimate, rtol=1e-15)
    formula = "bias ~ temperature_a + rate_a + temperature_b + rate_b" + " + C(run, Sum)" * offsets
    peer = smf.ols(formula, stacked.reset_index()).fit()
    names = list(TWO.names[1:])
    assert_allclose(result.estimate[1:], peer.params[names], rtol=1e-10)
    assert_allclose(result.estimate[0], peer.params["Intercept"], rtol=1e-10)
    assert_allclose(result.standard_deviation[1:], peer.bse[names], rtol=1e-10)
    assert_allclose(result.p_value[1:], peer.pvalues[names], rtol=1e-8)
    assert_allclose(result.r_squared, peer.rsquared, rtol=1e-10)
    assert result.degrees_of_freedom == peer.df_resid
    assert_allclose(result.residual_deviation**2, peer.scale, rtol=1e-10)
    if offsets:
        assert_allclose(result.run_offsets[:2], peer.params.filter(like="C(run"), rtol=1e-10)
        assert_allclose(result.run_offsets.sum(), 0, atol=1e-14)
    else:
        from statsmodels.stats.outliers_influence import variance_inflation_factor

        X = TWO.design(stacked).to_numpy()
        assert_allclose(result.vif[1:], [variance_inflation_factor(X, i) for i in range(1, 5)], rtol=1e-10)


@pytest.mark.parametrize(
    ("covariance", "correlation", "low", "high"),
    # nominal 95 %; 5 sigma of a share of 300 is 6 %. Robust errors of three runs of 60 rows are a little short.
    [("ols", 0.0, 0.89, 1.0), ("ols", 0.8, 0.0, 0.75), ("hac", 0.0, 0.86, 1.0), ("hac", 0.8, 0.80, 1.0)],
)
def test_coverage_of_intervals(covariance, correlation, low, high):
    from scipy import stats

    at, inside = TWO.names.index("temperature_a"), []
    rng = np.random.default_rng(7)
    for _ in range(300):
        tables = runs(rng, correlation=correlation, rows=120)
        result = fit(TWO, tables, covariance=covariance, lags=12 if covariance == "hac" else None)
        size = stats.t.ppf(0.975, result.degrees_of_freedom) * result.standard_deviation
        inside.append(np.abs(result.estimate - TRUTH)[at] < size[at])
    assert low < np.mean(inside) < high


def test_cluster_errors_cover_offsets_that_were_not_fitted():
    rng = np.random.default_rng(3)
    results = {kind: [] for kind in ("ols", "cluster")}
    for _ in range(100):
        tables = runs(rng, count=20, rows=20, offset=0.5)
        for kind, values in results.items():
            values.append(fit(TWO, tables, covariance=kind))
    scatter = np.std([r.estimate[0] for r in results["ols"]], ddof=1)
    stated = {kind: np.mean([r.standard_deviation[0] for r in values]) for kind, values in results.items()}
    assert stated["ols"] < 0.5 * scatter
    # 5 sigma of a deviation from 100 numbers
    assert_allclose(stated["cluster"], scatter, rtol=5 / np.sqrt(200))


def test_hac_of_one_run_is_that_of_statsmodels():
    (table,) = runs(np.random.default_rng(5), count=1, correlation=0.6)
    result = fit(TWO, table, covariance="hac", lags=5)
    formula = "bias ~ temperature_a + rate_a + temperature_b + rate_b"
    peer = smf.ols(formula, table).fit(cov_type="HAC", cov_kwds={"maxlags": 5, "use_correction": True}, use_t=True)
    assert_allclose(result.standard_deviation, peer.bse.to_numpy(), rtol=1e-9)
    assert fit(TWO, table, covariance="hac").covariance_kind == "hac"  # default lags
    assert 0.4 < result.autocorrelation < 0.8


@given(shift=st.floats(-40, 40), factor=st.floats(0.1, 100))
@settings(max_examples=20)
def test_reference_moves_the_constant_and_units_scale(shift, factor):
    tables = runs(np.random.default_rng(2))
    base = fit(TWO, tables)
    moved = fit(models.several_points(["a", "b"], reference=shift), tables)
    assert_allclose(moved.estimate[1:], base.estimate[1:], rtol=1e-9, atol=1e-12)
    change = shift * (base.coefficient("temperature_a") + base.coefficient("temperature_b"))
    assert_allclose(moved.estimate[0], base.estimate[0] + change, rtol=1e-9, atol=1e-11)
    assert_allclose([moved.condition, *moved.vif[1:]], [base.condition, *base.vif[1:]], rtol=1e-8)
    scaled = fit(TWO, tables, [factor * table.bias for table in tables])
    assert_allclose(scaled.estimate, factor * base.estimate, rtol=1e-9, atol=1e-12)
    assert_allclose(scaled.t, base.t, rtol=1e-8, atol=1e-10)


def test_prediction_frame_and_json():
    tables = runs(np.random.default_rng(4))
    result = fit(TWO, tables, run_offsets=True)
    again = TemperatureFit.from_json(result.to_json())
    assert_allclose(again.predict(tables[0]), result.predict(tables[0]), rtol=1e-15)
    assert again.to_json() == result.to_json()
    left = np.concatenate([t.bias - result.predict(t) - o for t, o in zip(tables, result.run_offsets, strict=True)])
    assert_allclose(np.sqrt(left @ left / result.degrees_of_freedom), result.residual_deviation, rtol=1e-12)
    frame = result.to_frame()
    assert list(frame.index) == list(TWO.names) and frame.p_value["temperature_a"] < 1e-10
    constant = fit(models.constant_only(), tables)
    assert_allclose(constant.estimate, np.concatenate([t.bias for t in tables]).mean(), rtol=1e-14)
    assert constant.condition == 1.0
    with pytest.raises(ValueError, match="`text` must be that of a TemperatureFit"):
        TemperatureFit.from_json('{"kind": "Other"}')


def test_collinear_regressors_warn_with_the_condition_number():
    (table,) = runs(np.random.default_rng(5), count=1)
    close = table.assign(temperature_b=table.temperature_a + 1e-4 * table.temperature_b)
    with pytest.warns(UserWarning, match=r"'2 points with rates' are nearly collinear: condition number \d"):
        fit(TWO, close)
    with pytest.raises(ValueError, match="'temperature_a', 'temperature_b' must be linearly independent, got"):
        fit(TWO, table.assign(temperature_b=3 - 2 * table.temperature_a))
    by_run = [table.assign(temperature_b=c - 2 * table.temperature_a) for c in (1.0, 2.0)]
    with pytest.raises(ValueError, match="independent within runs"):
        fit(TWO, by_run, run_offsets=True)


ONE = runs(np.random.default_rng(6), count=1)[0]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: fit(TWO, ONE, ONE.bias[:-1]), "`response` must be as long as the temperatures, got 59 values for 60"),
        (lambda: fit(TWO, [ONE, ONE], [ONE.bias]), "`response` must have one series for each of the 2 runs, got 1"),
        (lambda: fit(TWO, ONE, "drift"), r"`tables\[0\]` must be a table with the columns 'drift'"),
        (lambda: fit(TWO, ONE.assign(bias=np.nan)), r"`tables\[0\]\['bias'\]` must be finite"),
        (lambda: fit(TWO, [ONE, ONE.drop(columns="rate_b")]), r"`tables\[1\]` must be .* without 'rate_b'"),
        (lambda: fit(TWO, ONE.assign(temperature_b=21.5)), "`temperature_b` must vary, got the constant 21.5"),
        (lambda: fit(TWO, ONE[:5]), "`tables` must have more rows than the 5 coefficients, got 5"),
        (lambda: fit(TWO, ONE, covariance="white"), "`covariance`"),
        (lambda: fit(TWO, ONE, covariance="cluster"), "must not be 'cluster' for a single run"),
        (lambda: fit(TWO, ONE, covariance="hac", lags=-1), "`lags`"),
        (lambda: fit(TWO, ONE).coefficient("c"), "`name`"),
    ],
)
def test_bad_input_is_named(call, words):
    with pytest.raises(ValueError, match=words):
        call()


@pytest.mark.parametrize("tables", [[], {"a": ONE}, [1.0]])
def test_tables_must_be_tables(tables):
    with pytest.raises(TypeError, match="`tables"):
        fit(TWO, tables)


def test_noisy_thermometers_bias_the_estimate_and_no_covariance_says_so():
    # the attenuation of one regressor by its noise is closed-form: var(T) / (var(T) + s^2)
    rng = np.random.default_rng(8)
    T = rng.standard_normal(40_000)
    read = T + 0.5 * rng.standard_normal(T.size)
    table = pd.DataFrame({"temperature_a": read, "bias": T}, index=pd.Index(np.arange(T.size), name="time"))
    result = fit(models.scale_factor("a"), table, covariance="hac")
    # 5 sigma: the slope has the standard error sqrt(0.2 * 0.8) / sqrt(n)
    assert_allclose(result.estimate[1], 0.8, atol=5 * 0.4 / np.sqrt(T.size))
    assert abs(result.estimate[1] - 1) > 50 * result.standard_deviation[1]


def test_fit_of_the_simulated_gyro_is_near_the_truth():
    gyro = experiment.example_gyro()
    plan = experiment.start_ups() + experiment.warm_runs()
    tables = experiment.campaign(experiment.in_unit(), plan, rng=np.random.default_rng(9))
    with pytest.warns(UserWarning, match="condition number 6.*'temperature_coil_top'"):  # two faces of one coil
        result = fit(models.steady_state(), tables)
    assert result.condition > regression.CONDITION_LIMIT
    assert 0.004 < result.residual_deviation / DEG_PER_HOUR < 0.01  # noise of rows 0.006 deg/h, and thermometers
    assert_allclose(result.coefficient("rate_coil_top"), gyro.rate["coil_top"], rtol=0.05)
