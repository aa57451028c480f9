import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import stats

from fogkit.estimation.consistency import chi_square_interval, nees, ratio_interval


def test_nees_by_hand():
    # inverse of [[2, 1], [1, 2]] is [[2, -1], [-1, 2]] / 3
    assert_allclose(nees([1, 2], [[2, 1], [1, 2]]), (2 * 1 - 2 * 2 + 2 * 4) / 3, rtol=1e-15)
    many = nees(np.ones((4, 5, 2)), np.eye(2) * np.arange(1, 6)[:, None, None])  # one covariance for each of five
    assert_allclose(many, np.broadcast_to(2 / np.arange(1, 6), (4, 5)), rtol=1e-15)


def test_nees_knows_no_units():
    units = np.array([1e-12, 1e6])
    assert_allclose(nees([1, 2] * units, [[2, 1], [1, 2]] * np.outer(units, units)), 2, rtol=1e-14)  # rounding


@pytest.mark.parametrize("probability", [0.5, 0.95, 0.9999])
def test_intervals_hold_their_probability(probability):
    # the distribution function of another implementation, evaluated at the bounds; its rounding
    low, high = chi_square_interval(6, 300, probability)
    inside = stats.chi2.cdf(high * 300, 1800) - stats.chi2.cdf(low * 300, 1800)
    assert_allclose(inside, probability, rtol=1e-12)
    low, high = ratio_interval(50, probability)
    inside = stats.chi2.cdf(49 / low**2, 49) - stats.chi2.cdf(49 / high**2, 49)
    assert_allclose(inside, probability, rtol=1e-12)
    known = ratio_interval(49, probability, mean_known=True)
    assert_allclose(known, (low, high), rtol=1e-14)  # one degree of freedom less is one run less


def test_share_of_true_predictions_inside():
    rng = np.random.default_rng(1)
    observed = np.std(rng.standard_normal((4000, 20)), axis=1, ddof=1)
    low, high = ratio_interval(20, 0.9)
    share = np.mean((low < 1 / observed) & (1 / observed < high))
    assert abs(share - 0.9) < 4 * np.sqrt(0.9 * 0.1 / 4000)  # 4 sigma of a share


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: nees([1, 2], np.eye(3)), r"`covariances` must be of shape \(\.\.\., 2, 2\)"),
        (lambda: nees([1, 2], np.ones((2, 2))), "`covariances` must be positive definite"),
        (lambda: nees([1, np.nan], np.eye(2)), "`errors` must be finite"),
        (lambda: nees(np.ones((4, 2)), np.ones((3, 1, 1)) * np.eye(2)), r"one for each error, got \(3, 2, 2\)"),
        (lambda: chi_square_interval(0), "`degrees_of_freedom` must be an integer >= 1"),
        (lambda: chi_square_interval(1, 0), "`count` must be an integer >= 1"),
        (lambda: chi_square_interval(1, 1, 1.0), "`probability` must be in the open interval"),
        (lambda: ratio_interval(1), "`count` must be an integer >= 2"),
    ],
)
def test_bad_input_is_named(call, words):
    with pytest.raises(ValueError, match=words):
        call()
