import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.noise import (
    PROCESSES,
    RandomErrors,
    allan_covariance,
    allan_deviation,
    equivalent_degrees_of_freedom,
    simulate,
)
from fogkit.noise.covariance import lag_nodes
from fogkit.noise.increments import cross_covariance, squared_coincidence

EACH = [RandomErrors(**{name: 0.7}) for name in PROCESSES]
MIXED = RandomErrors(
    angle_random_walk=1.0, bias_instability=0.5, rate_random_walk=0.1, rate_ramp=0.02, quantization=0.8
)


def by_all_pairs(errors, m, n, count):
    """The covariance of two Allan variances as the double sum that it is, with a sampling time of 1."""
    centres = np.subtract.outer(np.arange(count - 2 * m + 1) + m, np.arange(count - 2 * n + 1) + n).ravel()
    pairs = np.bincount(centres - centres.min())
    lag = centres.min() + np.arange(pairs.size)
    N2, B2, K2, R2, Q2 = errors.squares
    C = np.array([N2, B2, K2, Q2]) @ cross_covariance(m, n, lag)
    total = np.sum(pairs * (2 * C**2 + 4 * R2 * m**2 * n**2 * C - 1.2 * Q2**2 * squared_coincidence(m, n, lag)))
    return total / (4 * m**2 * n**2 * centres.size)


def test_sum_over_pairs():
    # long enough that most lags are in Gauss blocks; their error is below 1e-9
    count, factors = 1500, [1, 3, 40, 500, 750]
    for errors in (*EACH, MIXED):
        P = allan_covariance(errors, factors, count, 1.0)
        brute = [[by_all_pairs(errors, m, n, count) for n in factors] for m in factors]
        assert_allclose(P, brute, rtol=1e-8, atol=1e-12 * np.max(brute))


def test_nodes_sum_smooth_functions_between_kinks():
    for last, kinks in ((3, (0, 1, 2)), (100, (0, 5, 90)), (10**6, (0, 999, 1000, 31_000))):
        lag, weight = lag_nodes(kinks, last)
        every = np.arange(last + 1.0)
        assert_allclose(weight.sum(), last + 1, rtol=1e-12)
        for kink in kinks:
            for power in (1.5, -2.0):  # the sum is made far from the kink, and near it
                at_nodes, direct = ((1 + np.abs(u - kink)) ** power for u in (lag, every))
                assert_allclose(weight @ at_nodes, direct.sum(), rtol=1e-9)
    assert lag.size < 2000  # of a million


@pytest.mark.parametrize("errors", [*EACH[:3], EACH[4], MIXED], ids=[*PROCESSES[:3], PROCESSES[4], "mixed"])
def test_scatter_of_simulated_allan_variances(errors):
    count, dt, runs = 512, 0.5, 3000
    factors = [1, 2, 4, 16, 64, 128, 256]
    rate = simulate(errors, count, dt, np.random.default_rng(1), channels=runs)
    variances = allan_deviation(rate, dt, averaging=factors).variance
    P = allan_covariance(errors, factors, count, dt)
    spread = np.sqrt(np.diagonal(P))
    observed = np.cov(variances) / spread[:, None] / spread
    expected = P / spread[:, None] / spread
    # scatter of a covariance of chi-square numbers with f degrees of freedom: variance 2 + 12/f, over the runs
    freedom = 2 * errors.allan_variance(np.array(factors) * dt) ** 2 / np.diagonal(P)
    sigma = np.sqrt((2 + 12 / np.minimum.outer(freedom, freedom)) / runs)
    assert (np.abs(observed - expected) < 4.5 * sigma).all()


def test_white_noise_in_closed_form():
    # m = 1: differences d have the autocovariance 2, -1, so the variance of mean d^2 / 2 is 2 (4 + 2 (1 - 1/M)) / 4M
    M = 99
    (variance,) = np.diagonal(allan_covariance(RandomErrors(angle_random_walk=1.0), [1], M + 1, 1.0))
    assert_allclose(variance, 2 * (4 + 2 * (1 - 1 / M)) / (4 * M), rtol=1e-13)


def test_one_difference_has_one_degree_of_freedom():
    for errors in EACH[:3]:
        assert_allclose(equivalent_degrees_of_freedom(errors, [50], 100, 2.0), 1.0, rtol=1e-12)


def test_published_degrees_of_freedom_of_white_noise():
    # Greenhall and Riley (2003); NIST SP 1065, section 5.4: of the overlapping Allan variance with white frequency
    # noise (3 (N - 1) / 2m - 2 (N - 2) / N) 4 m^2 / (4 m^2 + 5), N the number of angles, an empirical fit: 3 %
    count, m = 10_000, np.array([1, 2, 4, 16, 64, 256])
    N = count + 1
    published = (3 * (N - 1) / (2 * m) - 2 * (N - 2) / N) * 4 * m**2 / (4 * m**2 + 5)
    exact = equivalent_degrees_of_freedom(RandomErrors(angle_random_walk=3.0), m, count, 0.1)
    assert_allclose(exact, published, rtol=0.03)


def test_ramp_alone_has_no_scatter():
    assert_allclose(allan_covariance(EACH[3], [1, 8], 100, 1.0), 0, atol=0)
    assert np.isinf(equivalent_degrees_of_freedom(EACH[3], [1, 8], 100, 1.0)).all()


def test_units_of_time_and_rate():
    # a record in other units: variances of variances go with the fourth power of the rate
    slow = RandomErrors(angle_random_walk=1.0, bias_instability=0.5, rate_random_walk=0.1)
    fast = RandomErrors(angle_random_walk=1e-6, bias_instability=0.5e-5, rate_random_walk=1e-5)  # dt 100 times shorter
    one = allan_covariance(slow, [1, 10, 100], 1000, 1.0)
    other = allan_covariance(fast, [1, 10, 100], 1000, 0.01)
    assert_allclose(other, one * 1e-20, rtol=1e-12)


def test_covariances_of_many_averaging_times_are_positive_definite():
    factors = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 1000, 100_000, 450_000]
    for errors in (*EACH[:3], EACH[4], MIXED):
        P = allan_covariance(errors, factors, 1_000_000, 0.01)
        spread = np.sqrt(np.diagonal(P))
        assert np.linalg.eigvalsh(P / spread[:, None] / spread).min() > 1e-9


@pytest.mark.parametrize(
    ("factors", "words"),
    [
        ([1, 51], "at most half of the 100 samples, got 51, which needs a record of at least 102 samples"),
        ([0, 1], "integers >= 1, got 0"),
        ([1.5], "integers >= 1, got 1.5"),
        ([2, 1], "`factors` must increase"),
        ([[1, 2]], "ndim 1"),
    ],
)
def test_bad_factors(factors, words):
    with pytest.raises(ValueError, match=words):
        allan_covariance(MIXED, factors, 100, 1.0)
