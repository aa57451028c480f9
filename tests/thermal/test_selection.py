"""F tests against statsmodels and against their size, pruning over many seeds, cross-validation, separability."""

import numpy as np
import pandas as pd
import pytest
import statsmodels.formula.api as smf
from numpy.testing import assert_allclose
from scipy import stats

from fogkit.reproduction.beihang import temperature_points
from fogkit.thermal import ThermalNetwork, cross_validate, experiment, fit, models, prune, rates, separability
from fogkit.thermal.selection import FTest, partial_f

POINTS = ("a", "b", "c")


def table(rng, rows=80, effect=1.0, noise=0.3, correlation=0.0, offset=0.0):
    """One run in which the bias depends on point a, and the points are correlated."""
    common = rng.standard_normal(rows).cumsum() * 0.2
    columns = {f"temperature_{p}": common + rng.standard_normal(rows) for p in POINTS}
    columns |= {f"rate_{p}": rng.standard_normal(rows) for p in POINTS}
    error = noise * rng.standard_normal(rows)
    for i in range(1, rows):
        error[i] = correlation * error[i - 1] + np.sqrt(1 - correlation**2) * error[i]
    bias = effect * (columns["temperature_a"] + columns["rate_a"]) + error + offset
    return pd.DataFrame(columns | {"bias": bias}, index=pd.Index(np.arange(rows), name="time"))


def test_partial_f_is_that_of_two_fits():
    data = table(np.random.default_rng(1))
    result = fit(models.several_points(POINTS), data)
    terms = {p: f"temperature_{p} + rate_{p}" for p in POINTS}
    full = smf.ols("bias ~ " + " + ".join(terms.values()), data).fit()
    for point in POINTS:
        small = smf.ols("bias ~ " + " + ".join(v for p, v in terms.items() if p != point), data).fit()
        F, p, q = full.compare_f_test(small)
        test = partial_f(result, point)
        assert_allclose([test.F, test.numerator, test.denominator], [F, q, full.df_resid], rtol=1e-9)
        assert_allclose(test.p_value, p, rtol=1e-7)
    assert FTest.from_json(test.to_json()) == test


@pytest.mark.parametrize(
    ("covariance", "correlation", "low", "high"),
    # nominal 5 %; 5 sigma of a share of 300 is 6 %
    [("ols", 0.0, 0.0, 0.11), ("hac", 0.0, 0.0, 0.13)],
)
def test_size_of_the_test(covariance, correlation, low, high):
    rng = np.random.default_rng(2)
    rejected = []
    for _ in range(300):
        result = fit(models.several_points(POINTS), table(rng, correlation=correlation), covariance=covariance)
        rejected.append(partial_f(result, "b").p_value < 0.05)
    assert low < np.mean(rejected) < high


def test_permutations_give_the_same_p_value():
    # the rows of a point without effect are exchangeable: its F over permutations has the F distribution
    rng = np.random.default_rng(3)
    data = table(rng, rows=40)
    own = ["temperature_c", "rate_c"]
    model = models.several_points(POINTS)
    data[own] = rng.standard_normal((40, 2))
    observed = partial_f(fit(model, data), "c")
    F = []
    for _ in range(400):
        shuffled = data.copy()
        shuffled[own] = data[own].to_numpy()[rng.permutation(40)]
        F.append(partial_f(fit(model, shuffled), "c").F)
    share = np.mean(np.array(F) >= observed.F)
    assert_allclose(share, observed.p_value, atol=4 * np.sqrt(0.25 / 400))  # 4 sigma of a share


def slow(rng, rows, correlation=0.95):
    """A series that is slow, as temperatures are."""
    x = rng.standard_normal(rows)
    for i in range(1, rows):
        x[i] = correlation * x[i - 1] + np.sqrt(1 - correlation**2) * x[i]
    return x


def test_correlated_residuals_make_false_points_and_averaging_or_hac_mends_it():
    # slow regressors without effect, residuals with a memory of 10 rows: nominal level 5 %
    rng = np.random.default_rng(4)
    rejected = {"samples": [], "hac": [], "blocks": []}
    for _ in range(150):
        rows = 1200
        data = pd.DataFrame({f"temperature_{p}": slow(rng, rows, 0.98) for p in "ab"})
        data["bias"] = slow(rng, rows, 0.9)
        data.index = pd.Index(1.0 * np.arange(rows), name="time")
        model = models.TemperatureModel(name="m", terms=[models.Term(point=p) for p in "ab"])
        blocks = rates.reduce(data, 60.0)
        rejected["samples"].append(partial_f(fit(model, data), "b").p_value < 0.05)
        rejected["hac"].append(partial_f(fit(model, data, covariance="hac", lags=60), "b").p_value < 0.05)
        rejected["blocks"].append(partial_f(fit(model, blocks), "b").p_value < 0.05)
    share = {name: np.mean(values) for name, values in rejected.items()}
    assert share["samples"] > 0.4  # ten times what it says
    # 5 sigma of 5 % in 150 is 9 %; HAC with a record of 20 memories stays a little short
    assert share["blocks"] < 0.14 and share["hac"] < 0.20


def test_noise_of_thermometers_is_allowed_for():
    # point b measures what a measures, as noisily, and has no effect: a test that takes a as exact keeps b for certain
    rng = np.random.default_rng(5)
    kept = {0.0: [], 0.1: []}
    for _ in range(60):
        T, rate = slow(rng, 400), slow(rng, 400)
        columns = {f"temperature_{p}": T + 0.1 * rng.standard_normal(400) for p in "ab"}
        columns |= {f"rate_{p}": rate + 0.1 * rng.standard_normal(400) for p in "ab"}
        data = pd.DataFrame(columns | {"bias": T + rate + 0.1 * rng.standard_normal(400)})
        for noise, values in kept.items():
            result = fit(models.several_points("ab"), data)
            values.append(partial_f(result, "b", noise=(noise, noise)).p_value < 0.01)
    assert np.mean(kept[0.0]) > 0.99
    assert np.mean(kept[0.1]) < 0.05


def test_patnaik_is_near_the_noncentral_f():
    data = table(np.random.default_rng(6), effect=0.05)
    result = fit(models.several_points(POINTS), data)
    test = partial_f(result, "a", noise=(0.3, 0.3))
    without = fit(models.several_points(["b", "c"]), data)
    unexplained = 0.09 * (without.estimate[1:] ** 2).sum()
    n, q, d = len(data), test.numerator, test.denominator
    variance = without.residual_deviation**2 * without.degrees_of_freedom / (d + q)
    bound = n * unexplained / (variance - unexplained)
    # the approximation is good to some per cent where p is not tiny
    assert_allclose(test.p_value, stats.ncf.sf(test.F, q, d, bound), rtol=0.1)


def test_pruning_records_its_steps():
    rng = np.random.default_rng(7)
    tables = [table(rng, offset=o) for o in (0.0, 5.0)]
    pruned = prune(tables, POINTS)
    assert pruned.kept == ("a",)
    assert_allclose(pruned.threshold, 0.01 / 3)
    frame = pruned.to_frame()
    assert list(frame.dropped) == [True, True, False] and frame.point.iloc[-1] == "a"
    assert (frame.p_value[frame.dropped] > pruned.threshold).all()
    assert len(pruned.fit.run_offsets) == 2
    assert prune(tables[0], models.several_points(POINTS)).fit.run_offsets.size == 0


def test_pruning_may_leave_nothing():
    pruned = prune(table(np.random.default_rng(8), effect=0.0), POINTS)
    assert pruned.kept == () and len(pruned.steps) == 3 and pruned.fit.model.names == ("constant",)


def test_family_wise_level_holds():
    # three points without effect: 5 sigma over 200 runs of a true share of at most 10 %
    rng = np.random.default_rng(9)
    kept = [bool(prune(table(rng, effect=0.0), POINTS, family_wise=0.1).kept) for _ in range(200)]
    assert 0.02 < np.mean(kept) < 0.1 + 5 * np.sqrt(0.09 / 200)


@pytest.mark.slow
def test_pruning_finds_the_true_points_in_200_campaigns():
    found = temperature_points.pruning_rates(range(200))
    assert found.runs == 200
    assert found.kept_true >= 0.95 and found.exact >= 0.95


def test_weak_effects_and_noisy_thermometers_hide_the_points():
    # 20 campaigns of a true share of 0.45; with 0.05 K a point that counts is never clear
    assert temperature_points.pruning_rates(range(20), strength=0.1).exact < 0.8
    assert temperature_points.pruning_rates(range(20), thermometer_noise=0.05).exact == 0


@pytest.mark.parametrize("treatment", ["samples", pytest.param("samples, hac", marks=pytest.mark.slow), "rows"])
def test_other_treatments_keep_false_points(treatment):
    found = temperature_points.pruning_rates(range(1), treatment)
    assert found.kept_true == 1 and found.exact == 0


def test_cross_validation_leaves_out_one_run():
    rng = np.random.default_rng(10)
    tables = [table(rng) for _ in range(4)]
    compared = {"none": models.constant_only(), "a": models.single_point("a"), "b": models.single_point("b")}
    rows = cross_validate(compared, tables)
    expected = []
    for i, left_out in enumerate(tables):
        others = tables[:i] + tables[i + 1 :]
        result = smf.ols("bias ~ temperature_a + rate_a", pd.concat(others)).fit()
        expected.append(left_out.bias - result.predict(left_out))
    assert_allclose(rows.after.iloc[1], np.sqrt(np.mean(np.concatenate(expected) ** 2)), rtol=1e-10)
    assert_allclose(rows.removed.iloc[0], 0, atol=1e-12)
    assert rows.removed.iloc[1] > 0.6 > rows.removed.iloc[2]
    assert (rows.within_run <= rows.after + 1e-15).all()
    labelled = cross_validate({"A": models.single_point("a")}, tables, run_offsets=True)
    assert list(labelled.index) == ["A"]
    with pytest.raises(ValueError, match="`tables` must hold at least two runs"):
        cross_validate([models.single_point("a")], tables[:1])


def test_a_single_time_constant_cannot_be_separated():
    body = ThermalNetwork(capacities={"body": 100.0}, conductances={("body", "chamber"): 0.5}, heat={"body": 2.0})
    plan = experiment.start_ups((0.0, 30.0), 3600.0)
    first, second = experiment.campaign(body, plan, effects={})
    with pytest.warns(UserWarning, match="cannot be separated over 1 run: .*less 200 s times its rate"):
        one = separability(first, "body")
    assert not one.separable and one.condition > 1e6
    # the slope of a window is the mean rate of an exponential, and both are exponentials: exactly collinear
    assert_allclose([one.correlation, one.time_constant], [-1, 200], rtol=1e-3)
    both = separability([first, second], "body")
    assert both.separable and "can be separated over 2 runs" in both.statement
    with pytest.warns(UserWarning, match="cannot be separated within runs"):
        assert not separability([first, second], "body", run_offsets=True).separable
    assert type(both).from_json(both.to_json()) == both


def test_condition_of_separability_is_that_of_the_fit():
    data = table(np.random.default_rng(11)).assign(rate_a=lambda t: t.temperature_a + 0.1 * t.rate_a)
    found = separability(data, "a", warn=False)
    result = fit(models.single_point("a"), data)
    assert_allclose(found.condition, result.condition, rtol=1e-9)
    assert_allclose(found.variance_inflation, result.vif[1], rtol=1e-9)


def test_one_model_needs_no_list():
    model, runs = models.single_point("a"), [table(np.random.default_rng(seed)) for seed in (1, 2)]
    assert cross_validate(model, runs).equals(cross_validate([model], runs))


def test_a_text_is_no_sequence_of_points():
    with pytest.raises(TypeError, match="`points` must be a sequence of names, got the text 'ab'"):
        prune(table(np.random.default_rng(12)), "ab")


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda t: prune(t, []), "`points` must name at least one"),
        (lambda t: prune(t, POINTS, family_wise=0), "`family_wise`"),
        (lambda t: prune(t, POINTS, noise=(-1, 0)), r"`noise\[0\]`"),
        (lambda t: prune(t, models.accelerometer_bias("a"), noise=(1, 1)), "`noise` must be left out"),
        (lambda t: prune(t, list("abd")), "without 'temperature_d'"),
        (lambda t: partial_f(fit(models.single_point("a"), t), "b"), "`point`"),
        (lambda t: separability(t.assign(temperature_a=2.0), "a"), "`temperature_a` must vary"),
        (
            lambda t: cross_validate([models.single_point(p) for p in "ab"], [t, t]),
            "`models` must have different names",
        ),
        (lambda t: separability(t, "e"), "without 'temperature_e'"),
        (lambda t: prune(pd.concat([t, t]), POINTS), "`tables` must have an increasing index"),
        (lambda t: cross_validate([models.single_point("a")], [t, t], [t.bias, t.bias[:-1]]), "`response` must be as"),
    ],
)
def test_bad_input_is_named(call, words):
    with pytest.raises(ValueError, match=words):
        call(table(np.random.default_rng(12)))
