import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from fogkit.constants import SPEED_OF_LIGHT
from fogkit.optics import Coil


def test_sagnac_phase_is_that_of_two_waves_racing_round_the_coil():
    # by relativity, no formula of the package: in the inertial frame each wave chases or meets the moving start point,
    # t = (circumference + rate * radius * t) / c and with a minus; in vacuum, since the index cancels in the difference
    turns, radius, rate, wavelength = 200, 0.04, 1e-3, 0.83e-6
    circumference = 2 * np.pi * radius * turns
    slow = circumference / (SPEED_OF_LIGHT - rate * radius)
    fast = circumference / (SPEED_OF_LIGHT + rate * radius)
    coil = Coil(length=circumference, diameter=2 * radius, wavelength=wavelength)
    # the difference of two nearly equal times keeps 16 - 13 digits
    assert_allclose(coil.phase(rate), 2 * np.pi * SPEED_OF_LIGHT / wavelength * (slow - fast), rtol=2e-3)
    # same in closed form with the rounding taken out: c**2 - v**2 in the denominator instead of c**2, a relative 1e-26
    exact = 2 * np.pi / wavelength * circumference * 2 * rate * radius / SPEED_OF_LIGHT
    assert_allclose(coil.phase(rate), exact, rtol=1e-14)


def test_a_kilometre_of_fibre_has_a_proper_frequency_near_100_khz():
    # 5 us/km is the figure every fibre optics text gives for the transit time of silica
    assert_allclose(Coil(length=1000, diameter=0.1).transit_time, 5e-6, rtol=0.03)


@given(rate=st.floats(-10, 10))
def test_rate_undoes_phase(rate):
    coil = Coil(length=1000, diameter=0.1)
    assert_allclose(coil.rate(coil.phase(rate)), rate, rtol=1e-15)


def test_one_fringe_is_two_pi():
    coil = Coil(length=500, diameter=0.07)
    assert_allclose(coil.phase(coil.rate_of_one_fringe), 2 * np.pi, rtol=1e-15)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("length", 0),
        ("length", -1.0),
        ("diameter", np.nan),
        ("wavelength", np.inf),
        ("wavelength", 1.55),
        ("index", 0.9),
    ],
)
def test_impossible_coils_are_refused_by_name(name, value):
    with pytest.raises(ValueError, match=f"`{name}`"):
        Coil(**{"length": 1000, "diameter": 0.1} | {name: value})
