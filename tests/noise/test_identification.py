import warnings

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy import stats

from fogkit.estimation.consistency import chi_square_interval, nees, ratio_interval
from fogkit.noise import (
    PROCESSES,
    AllanDeviation,
    Identification,
    RandomErrors,
    allan_deviation,
    identify,
    predict,
    quantize,
    simulate,
)
from fogkit.units import ARCSEC, DEG_PER_HOUR, DEG_PER_HOUR_PER_SQRT_HOUR, DEG_PER_SQRT_HOUR

USUAL = PROCESSES[:3]
PLANTED = RandomErrors(angle_random_walk=1.0, bias_instability=0.3, rate_random_walk=0.02)
COUNT = 2**16


def exactly(errors, count=2**14, dt=1.0):
    """An Allan deviation without scatter."""
    m = 2 ** np.arange(12)
    deviation = np.sqrt(errors.allan_variance(m * dt))
    return AllanDeviation(tau=m * dt, deviation=deviation, factors=m, differences=count - 2 * m + 1, count=count, dt=dt)


# ---- without noise


@pytest.mark.parametrize("dt", [0.005, 1.0])
def test_all_five_coefficients_of_an_exact_curve(dt):
    errors = RandomErrors(
        angle_random_walk=2e-7, bias_instability=5e-8, rate_random_walk=1e-9, rate_ramp=1e-11, quantization=3e-7 * dt
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # some are too small for a record of this length
        found = identify(exactly(errors, dt=dt), processes=PROCESSES)
    assert_allclose(found.squares, errors.squares, rtol=1e-7)  # rounding, times the condition, of squares
    assert found.chi_square < 1e-12 and found.degrees_of_freedom == 7


def test_order_of_processes_is_kept():
    found = identify(exactly(PLANTED), processes=USUAL[::-1])
    assert found.processes == USUAL[::-1]
    assert_allclose(found.coefficients, [0.02, 0.3, 1.0], rtol=1e-8)


def test_units():
    # the same record in degrees per hour, and in milliseconds
    rate = simulate(PLANTED, 2**13, 1.0, np.random.default_rng(1))
    one = identify(rate, 1.0)
    scaled = identify(rate * 1e-9, 1.0)
    assert_allclose(scaled.coefficients, one.coefficients * 1e-9, rtol=1e-6)
    assert_allclose(scaled.interval(), one.interval() * 1e-9, rtol=1e-6)
    assert_allclose(scaled.chi_square, one.chi_square, rtol=1e-6)
    faster = identify(rate, 1e-3)
    assert_allclose(faster.coefficients, one.coefficients * [1e-3**0.5, 1, 1e-3**-0.5], rtol=1e-6)


# ---- against the scatter of many records


@pytest.fixture(scope="module")
def study():
    """200 records with the three usual processes planted together, and what was found in each."""
    rng = np.random.default_rng(20261122)
    return [identify(simulate(PLANTED, COUNT, 1.0, rng), 1.0) for _ in range(200)]


TRUTH = PLANTED.squares[:3] ** 0.5


@pytest.mark.slow
def test_200_seeds_bias_below_two_per_cent(study):
    coefficients = np.array([found.coefficients for found in study])
    # the requirement; the scatter of a mean of 200 is 0.03, 0.17 and 0.65 %
    assert_allclose(coefficients.mean(axis=0), TRUTH, rtol=0.02)


@pytest.mark.slow
def test_200_seeds_intervals_cover(study):
    bounds = np.array([found.interval(0.95) for found in study])
    coverage = np.mean((bounds[..., 0] <= TRUTH) & (bounds[..., 1] >= TRUTH), axis=0)
    assert (coverage >= 0.90).all() and (coverage <= 0.98).all()  # the requirement: 3 sigma of a share of 200


@pytest.mark.slow
def test_200_seeds_covariance_is_true(study):
    errors = np.array([found.coefficients for found in study]) - TRUTH
    low, high = chi_square_interval(3, 200, 0.999)
    assert low < nees(errors, np.array([found.covariance for found in study])).mean() < high
    predicted = predict(PLANTED, COUNT, 1.0).standard_deviation.to_numpy()
    low, high = ratio_interval(200, 0.999)
    ratio = predicted / errors.std(axis=0, ddof=1)
    assert (low < ratio).all() and (ratio < high).all()


@pytest.mark.slow
def test_200_seeds_chi_square_is_chi_square(study):
    values = [found.chi_square for found in study]
    assert {found.degrees_of_freedom for found in study} == {14 - 3}
    # Allan variances of few degrees of freedom are skew, so the far tail is heavier; the body is that of a chi-square
    assert stats.kstest(values, stats.chi2(11).cdf).pvalue > 0.01
    assert np.mean([found.p_value < 0.01 for found in study]) < 0.04


@pytest.mark.slow
@pytest.mark.parametrize("planted", [0.0, 0.004])
def test_weak_random_walk_is_covered_too(planted):
    rng = np.random.default_rng(2)
    errors = RandomErrors(angle_random_walk=1.0, bias_instability=0.3, rate_random_walk=planted)
    runs, inside, claimed = 100, 0, 0
    for _ in range(runs):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = identify(simulate(errors, 2**14, 1.0, rng), 1.0)
        low, high = found.interval()[2]
        inside += low <= planted <= high
        claimed += "rate_random_walk" in found.significant()
    assert inside / runs > 0.95 - 3 * np.sqrt(0.95 * 0.05 / runs)  # more where the estimate sits at zero
    # 4 % at zero, for 2.5 %, as the noise of the longest averaging times is skew; 3 sigma
    assert claimed / runs < (0.04 + 3 * np.sqrt(0.04 * 0.96 / runs) if planted == 0 else 1)


# ---- what the numbers mean


def test_interval_of_a_process_alone_is_that_of_chi_square():
    rate = simulate(RandomErrors(rate_random_walk=1.0), 64, 1.0, np.random.default_rng(3))
    found = identify(rate, 1.0, processes=["rate_random_walk"], averaging=[16])
    freedom = found.allan.degrees_of_freedom(RandomErrors(rate_random_walk=1.0))[0]
    expected = found.coefficients[0] * np.sqrt(freedom / stats.chi2.ppf([0.975, 0.025], freedom))
    assert_allclose(found.interval()[0], expected, rtol=1e-6)
    assert np.isnan(found.p_value) and found.degrees_of_freedom == 0


def test_interval_widens_with_its_level():
    found = identify(exactly(PLANTED))
    narrow, wide = found.interval(0.5), found.interval(0.99)
    assert (wide[:, 0] < narrow[:, 0]).all() and (narrow[:, 1] < wide[:, 1]).all()
    assert (narrow[:, 0] < found.coefficients).all() and (found.coefficients < narrow[:, 1]).all()


def test_residuals_show_what_was_left_out():
    rng = np.random.default_rng(4)
    rate = simulate(RandomErrors(angle_random_walk=1.0), 2**14, 0.01, rng)
    clean = identify(rate, 0.01, processes=["angle_random_walk"])
    assert clean.p_value > 0.01 and np.abs(clean.residuals).max() < 4
    line = rate + 4.0 * np.sin(2 * np.pi * 7.0 * 0.01 * np.arange(rate.size))
    shaken = identify(line, 0.01, processes=["angle_random_walk"])
    assert shaken.p_value < 1e-6 and np.abs(shaken.residuals).max() > 4


def test_quantization_and_random_walk_are_separated():
    planted = RandomErrors(angle_random_walk=1e-6, quantization=1e-6)
    rate = simulate(planted, 2**16, 0.5, np.random.default_rng(5))
    found = identify(rate, 0.5, processes=["angle_random_walk", "quantization"])
    assert (np.abs(found.coefficients - 1e-6) < 4 * found.standard_deviation).all()
    assert (found.standard_deviation < 2e-8).all()
    assert found.significant() == ("angle_random_walk", "quantization")


def test_ramp_is_found():
    planted = RandomErrors(angle_random_walk=1.0, rate_ramp=-1e-3)
    rate = simulate(planted, 2**14, 1.0, np.random.default_rng(6))
    found = identify(rate, 1.0, processes=["angle_random_walk", "rate_ramp"])
    assert abs(found.estimate.rate_ramp - 1e-3) < 4 * found.standard_deviation[1] < 1e-4


def test_prediction_is_what_a_fit_of_the_exact_curve_says():
    found = identify(exactly(PLANTED))
    table = predict(PLANTED, 2**14, 1.0, averaging=2 ** np.arange(12))
    assert_allclose(table.standard_deviation, found.standard_deviation, rtol=1e-6)
    assert_allclose(table.relative, found.standard_deviation / found.coefficients, rtol=1e-6)
    absent = predict(RandomErrors(angle_random_walk=1.0), 2**14, 1.0)
    assert np.isinf(absent.relative["rate_random_walk"])


def test_four_times_the_record_halves_the_uncertainty_of_white_noise():
    short, long = (predict(PLANTED, count, 1.0).relative for count in (2**14, 2**16))
    assert_allclose(short["angle_random_walk"] / long["angle_random_walk"], 2, rtol=0.02)  # ends of the record


# ---- zero


def test_a_process_at_zero_has_an_upper_limit_only():
    rate = simulate(RandomErrors(angle_random_walk=1.0), 2**13, 1.0, np.random.default_rng(8))
    with pytest.warns(
        UserWarning, match=r"record of 8192 s shows too little to determine .*`rate_random_walk` \(below"
    ):
        found = identify(rate, 1.0)
    zero = found.coefficients == 0
    assert zero.any() and not zero[0]
    assert np.isinf(found.standard_deviation[zero]).all()
    assert np.isnan(found.covariance[0, zero]).all()
    assert (found.interval()[zero, 0] == 0).all() and (found.interval()[zero, 1] > 0).all()
    assert found.degrees_of_freedom == len(found.allan.tau) - 3 + zero.sum()
    assert (found.squares[zero] < 0).any()
    # leaving out what is at zero changes nothing
    fewer = identify(rate, 1.0, processes=np.array(USUAL)[~zero].tolist())
    assert_allclose(fewer.coefficients, found.coefficients[~zero], rtol=1e-5)


def test_zero_is_the_best_of_all_that_is_not_negative():
    from scipy.optimize import nnls

    from fogkit.noise.covariance import allan_covariance, mean_of_squares

    for seed in range(5):
        rate = simulate(RandomErrors(angle_random_walk=1.0), 512, 1.0, np.random.default_rng(seed))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = identify(rate, 1.0, processes=PROCESSES)
        P = allan_covariance(found.estimate, found.allan.factors, 512, 1.0)
        root = np.linalg.cholesky(P)
        design = np.linalg.solve(root, mean_of_squares(tuple(found.allan.factors.tolist()), 1.0))
        scale = np.linalg.norm(design, axis=0)
        best = nnls(design / scale, np.linalg.solve(root, found.allan.variance))[0] / scale
        assert_allclose(found.coefficients**2 * scale, best * scale, atol=1e-3)  # where the iteration ends


def test_upper_limit_may_be_missing():
    # one difference: one degree of freedom; a 99.99 % limit is far, but there is one, for a process alone
    rate = simulate(RandomErrors(rate_random_walk=1.0), 8, 1.0, np.random.default_rng(9))
    with pytest.warns(UserWarning, match="too little"):
        found = identify(rate, 1.0, processes=["rate_random_walk"], averaging=[4])
    assert found.interval(0.9999)[0, 1] > 100 * found.coefficients[0]


def test_processes_that_look_alike_warn():
    # five powers of the averaging time on a single octave
    rate = simulate(PLANTED, 1024, 1.0, np.random.default_rng(10))
    with pytest.warns(UserWarning) as caught:
        found = identify(rate, 1.0, processes=PROCESSES, averaging=[4, 5, 6, 7, 8])
    words = f"hardly told apart on this record: condition number {found.condition:.0f}, correlation"
    assert any(words in str(warning.message) for warning in caught)


def test_nothing_in_common_with_the_record_is_refused():
    # a random walk is read from the shortest time, and the next one, which shares its scatter, counts against it
    curve = exactly(RandomErrors(rate_random_walk=1.0))
    peak = AllanDeviation(**{**vars(curve), "deviation": np.where(curve.factors == 2, 1.0, 1e-3)})
    with pytest.raises(ValueError, match="`processes` must hold one that the record shows"):
        identify(peak, processes=["rate_random_walk"])


def test_a_record_unlike_the_model_is_fitted_with_a_warning():
    # the error of a quantiser under a constant rate is a periodic pattern
    rate = 1.0 + 0.02 * np.random.default_rng(11).standard_normal(2**15)
    pattern = quantize(rate, 0.376, 1.0)
    with pytest.warns(UserWarning, match="unlike any mixture of `processes`, chi-square"):
        found = identify(pattern, 0.376, processes=["angle_random_walk", "quantization"])
    assert found.p_value < 1e-6 and (found.coefficients >= 0).all()


# ---- text, tables, input


def test_datasheet_table_and_text():
    errors = RandomErrors(
        angle_random_walk=0.01 * DEG_PER_SQRT_HOUR,
        bias_instability=0.3 * DEG_PER_HOUR,
        rate_random_walk=2.0 * DEG_PER_HOUR_PER_SQRT_HOUR,
    )
    found = identify(exactly(errors))
    table = found.to_frame("gyro")
    assert_allclose(table.estimate, [0.01, 0.3, 2.0], rtol=1e-6)
    assert table.unit.tolist() == ["deg/sqrt(h)", "deg/h", "deg/h/sqrt(h)"]
    assert_allclose(table.high["bias_instability"] * DEG_PER_HOUR, found.interval()[1, 1], rtol=1e-12)
    assert_allclose(found.to_frame().estimate, found.coefficients)
    again = Identification.from_json(found.to_json())
    assert again.estimate == found.estimate and again.processes == found.processes
    assert again.chi_square == found.chi_square and again.allan.dt == 1.0
    assert_array_equal(again.interval(), found.interval())
    assert_array_equal(again.residuals, found.residuals)
    assert ARCSEC > 0


def test_text_keeps_what_json_lacks():
    found = identify(exactly(PLANTED))
    odd = Identification(**{**vars(found), "condition": np.inf})
    assert Identification.from_json(odd.to_json()).condition == np.inf


def test_series_array_and_allan_deviation_give_the_same():
    rate = simulate(PLANTED, 2**13, 0.5, np.random.default_rng(11))
    two = {"processes": USUAL[:2]}
    array = identify(rate, 0.5, **two)
    series = identify(pd.Series(rate, index=np.arange(rate.size) * 0.5), **two)
    allan = identify(allan_deviation(rate, 0.5, averaging=array.allan.factors), **two)
    chosen = identify(rate, 0.5, averaging=array.allan.factors, **two)
    for other in (series, allan, chosen):
        assert_array_equal(other.coefficients, array.coefficients)


RATE = np.random.default_rng(12).standard_normal(100)


@pytest.mark.parametrize(
    ("call", "kind", "words"),
    [
        (lambda: identify(RATE, 1.0, processes="rate_ramp"), TypeError, "`processes` must be a sequence of strings"),
        (
            lambda: identify(RATE, 1.0, processes=["drift"]),
            ValueError,
            "`processes` must be one of 'angle_random_walk'",
        ),
        (lambda: identify(RATE, 1.0, processes=["rate_ramp"] * 2), ValueError, "one or several different ones"),
        (lambda: identify(RATE, 1.0, processes=[]), ValueError, "one or several different ones"),
        (lambda: identify(RATE[:20], 1.0), ValueError, "at least 3 averaging times to fit 3 processes, got 2"),
        (lambda: identify(np.stack([RATE] * 2, 1), 1.0), ValueError, "`rate` must be of one channel, got 2"),
        (lambda: identify(allan_deviation(RATE, 1.0), 1.0), ValueError, "must not be given with an AllanDeviation"),
        (lambda: identify(RATE, 1.0, averaging="all"), ValueError, "`averaging` must be one of 'octave'"),
        (lambda: identify(RATE), ValueError, "`dt` must be given"),
        (lambda: predict(None, 100, 1.0), TypeError, "`errors` must be a RandomErrors"),
        (lambda: identify(exactly(PLANTED)).to_frame("cgs"), ValueError, "`units` must be one of"),
    ],
)
def test_bad_input(call, kind, words):
    with pytest.raises(kind, match=words):
        call()


def test_a_table_of_one_channel_is_a_channel():
    table = pd.DataFrame({"gyro_x": RATE}, index=np.arange(len(RATE)) * 1.0)
    white = ["angle_random_walk"]
    assert identify(table, processes=white).estimate == identify(RATE, 1.0, processes=white).estimate
