"""The closed forms against the sums of nine terms that they stand for, in 60 digits."""

import mpmath
import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.noise.increments import FAR, cross_covariance, flicker_covariance, squared_coincidence

COEFFICIENTS = {-1: 1, 0: -2, 1: 1}


def square_log(t):
    """t^2 ln|t| in extended precision."""
    t = abs(mpmath.mpf(t))
    return t**2 * mpmath.log(t) if t else mpmath.mpf(0)


def fourth_difference(function, m, n, lag):
    """The sum as it is defined."""
    return sum(
        a * b * function(mpmath.mpf(lag) + i * m - j * n)
        for i, a in COEFFICIENTS.items()
        for j, b in COEFFICIENTS.items()
    )


@pytest.mark.parametrize(("m", "n"), [(1, 1), (1, 2), (3, 1000), (1, 2**20), (2**19, 2**20)])
def test_flicker_covariance_keeps_its_digits_at_every_lag(m, n):
    near = [0, 1, 2, 0.5, m, n, n - m, n + m, n - m + 0.5, n + 5]
    lags = near + [scale * (m + n) for scale in (2, 0.99 * FAR, FAR, 1.01 * FAR, 100, 1e6 + 0.25)]
    with mpmath.workdps(60):
        exact = [float(fourth_difference(square_log, m, n, lag)) for lag in lags]
    # rounding, times FAR**2 for the direct form at its far end and some ten for the terms that cancel
    assert_allclose(flicker_covariance(m, n, np.array(lags)), exact, rtol=1e-12, atol=1e-13 * m**2)


@pytest.mark.parametrize(("m", "n"), [(1, 1), (2, 5), (7, 4)])
def test_polynomial_covariances(m, n):
    lags = np.concatenate([np.arange(0.0, 40.0), [0.25, 3.5, 1e6]])
    white, _, walk, step = cross_covariance(m, n, lags)
    with mpmath.workdps(60):
        for function, got in (
            (lambda t: -abs(t) / 2, white),
            (lambda t: abs(t) ** 3 / 12, walk),
            (lambda t: mpmath.mpf(t == 0), step),
        ):
            exact = [float(fourth_difference(function, m, n, lag)) for lag in lags]
            assert_allclose(got, exact, rtol=1e-13, atol=1e-12)  # zero beyond m + n, where the walk cancels


def test_flicker_enters_the_table_with_its_coefficient():
    lags = np.arange(5.0)
    assert_allclose(cross_covariance(2, 3, lags)[1], flicker_covariance(2, 3, lags) / (2 * np.pi), rtol=1e-15)


def test_symmetries():
    lags = np.array([0.0, 1.5, 7.0, 100.0])
    assert_allclose(cross_covariance(2, 9, -lags), cross_covariance(9, 2, lags), rtol=1e-14)


def test_squared_coincidence_counts_shared_angles():
    # at lag 0 and equal steps all three angles are shared: 1 + 16 + 1; at lag 2 m only one outer pair
    assert_allclose(squared_coincidence(3, 3, np.array([0.0, 3.0, 6.0, 1.0])), [18, 8, 1, 0], rtol=0)
