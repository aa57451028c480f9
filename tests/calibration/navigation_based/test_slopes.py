"""Slopes against polynomials known, numpy's regression, and the instant at which a growing tilt drops out."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.calibration.navigation_based import scale_factor_deviation, turns_needed
from fogkit.calibration.navigation_based.slopes import SlopeFit
from fogkit.calibration.navigation_based.turn_model import measurement_rows
from fogkit.stand.turn_tests import nine_tests


def test_line_and_variance_against_numpy():
    rng = np.random.default_rng(1)
    t = 25 + 0.01 * np.arange(400)
    samples = 3 + 0.2 * (t - 25)[:, None] + rng.normal(size=(400, 2))
    slope, variance = SlopeFit.of(t, 1)(samples)
    for i in range(2):
        coefficients, covariance = np.polyfit(t, samples[:, i], 1, cov=True)
        assert_allclose(slope[i], coefficients[0], rtol=1e-10)
        assert_allclose(variance[i], covariance[0, 0], rtol=1e-10)


def test_parabola_at_an_instant_and_its_second_derivative():
    t = np.linspace(10, 20, 101)
    samples = (1 + 2 * t - 0.3 * t**2)[:, None]
    assert_allclose(SlopeFit.of(t, 2, 30.0)(samples)[0], 2 - 0.6 * 30, rtol=1e-11)
    assert_allclose(SlopeFit.of(t, 2, derivative=2)(samples)[0], -0.6, rtol=1e-9)


def test_common_growth_of_tilt_drops_out_in_the_middle_of_the_turn_only_with_a_parabola():
    before, after = np.linspace(0, 10, 101), np.linspace(25, 35, 101)
    change = {}
    for degree in (1, 2):
        first, last = (SlopeFit.of(t, degree, 17.5)((0.5 * 1e-3 * t**2)[:, None])[0][0] for t in (before, after))
        change[degree] = last - first
    assert_allclose(change[1], 1e-3 * 25, rtol=1e-10)  # growth from middle to middle
    assert_allclose(change[2], 0, atol=1e-12)
    noise = [np.linalg.norm(SlopeFit.of(before, degree, 17.5).weights) for degree in (1, 2)]
    assert 9 < noise[1] / noise[0] < 11  # the price that the module states


def test_samples_are_too_few():
    with pytest.raises(ValueError, match="at least 4 entries"):
        SlopeFit.of([0.0, 1.0, 2.0], 2)


@pytest.mark.parametrize("turns", [1, 5, 8])
def test_turns_needed_against_the_covariance_of_the_plan(turns):
    g, sigma = 9.8, 2e-4
    H = np.concatenate([measurement_rows(t.C_b_n, t.axis, t.angle, g) for t in nine_tests(turns=turns)])
    deviation = sigma * np.sqrt(np.diag(np.linalg.inv(H.T @ H)))
    for column in (3, 7, 11):
        assert_allclose(scale_factor_deviation(turns, sigma, g), deviation[column], rtol=1e-10)
    assert_allclose(turns_needed(sigma, deviation[3], g), turns, rtol=1e-9)
    # (28) as printed asks for more: of one test, not of three
    assert turns_needed(sigma, deviation[3], g, printed=True) > 1.5 * turns
