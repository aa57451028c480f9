import math

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from fogkit.optics import interferometer

phases = st.floats(-3, 3)
depths = st.floats(0.1, 3.0)


def test_power_is_that_of_two_equal_waves_added():
    phase = np.linspace(-7, 7, 101)
    assert_allclose(interferometer.power(phase), np.abs(0.5 + 0.5 * np.exp(1j * phase)) ** 2, atol=1e-15)  # rounding


@pytest.mark.parametrize("degree", range(6))
def test_taylor_coefficients_are_those_of_a_symbolic_series(degree):
    x, b = sympy.symbols("x b")
    series = sympy.series((1 + sympy.cos(b + x)) / 2, x, 0, degree + 1).removeO()
    expected = [float(series.coeff(x, j).subs(b, 2.2)) for j in range(degree + 1)]
    assert_allclose(interferometer.taylor_coefficients(2.2, degree), expected, atol=1e-16)


@given(deviation=phases, bias=phases, degree=st.integers(0, 12))
def test_taylor_polynomial_is_within_its_remainder(deviation, bias, degree):
    error = interferometer.taylor_power(deviation, bias, degree) - interferometer.power(bias + deviation)
    bound = abs(deviation) ** (degree + 1) / (2 * math.factorial(degree + 1))
    assert abs(error) <= bound + 1e-13  # rounding of terms up to 3**12 / 12! * 13


@given(mean=phases, half_step=st.floats(-0.5, 0.5), depth=depths)
def test_a_moving_phase_acts_as_a_change_of_depth(mean, half_step, depth):
    minus = interferometer.power(mean - half_step - depth)
    plus = interferometer.power(mean + half_step + depth)
    expected = np.sin(mean) * np.sin(depth + half_step) / np.sin(depth)
    assert_allclose(interferometer.demodulate(minus, plus, depth), expected, atol=1e-14)  # rounding over sin(0.1)


@pytest.mark.parametrize("depth", [0, -1, np.pi, 4, np.nan])
def test_depth_outside_the_open_half_circle_is_refused(depth):
    with pytest.raises(ValueError, match=r"`depth` must be in the open interval \(0.0, 3.14"):
        interferometer.demodulate(0.5, 0.5, depth)


def test_a_negative_degree_is_refused():
    with pytest.raises(ValueError, match="`degree`"):
        interferometer.taylor_coefficients(1.0, -1)
