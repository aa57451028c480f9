"""The factors against printed conversions and against each other."""

import math

import pytest
from numpy.testing import assert_allclose

from fogkit import units
from fogkit.constants import EARTH_RATE


@pytest.mark.parametrize(
    ("factor", "printed"),  # NIST Special Publication 811 (2008), appendix B.8, seven digits
    [
        (units.DEG, 1.745329e-2),
        (units.ARCMIN, 2.908882e-4),
        (units.ARCSEC, 4.848137e-6),
        (units.REVOLUTION, 6.283185),
        (units.REVOLUTION / units.MINUTE, 1.047198e-1),  # revolution per minute
        (units.MILLI_G * 1e3, 9.806650),
    ],
)
def test_factor_agrees_with_nist(factor, printed):
    assert_allclose(factor, printed, rtol=0.5e-6)  # half a unit of the seventh digit, at its worst in 1.000000


def test_earth_rate_in_degrees_per_hour():
    # 15.041067 arcsec per second of mean solar time, Explanatory Supplement to the Astronomical Almanac; 8 digits
    assert_allclose(EARTH_RATE / units.DEG_PER_HOUR, 15.041067, rtol=0, atol=1e-6)
    assert_allclose(EARTH_RATE / units.DEG_PER_SECOND * 3600, 15.041067, rtol=0, atol=1e-6)


def test_angle_random_walk_in_both_its_units():
    # IEEE 952: N[deg/sqrt(h)] = N[deg/h/sqrt(Hz)] / 60. Two roundings.
    assert_allclose(0.6 * units.DEG_PER_HOUR_PER_SQRT_HZ, 0.01 * units.DEG_PER_SQRT_HOUR, rtol=1e-15)


def test_random_walks_and_ramps_reach_one_unit_in_an_hour():
    root_hour = math.sqrt(units.HOUR)
    assert_allclose(units.DEG_PER_SQRT_HOUR * root_hour, math.radians(1), rtol=1e-15)
    assert_allclose(units.M_PER_S_PER_SQRT_HOUR * root_hour, 1, rtol=1e-15)
    assert_allclose(units.DEG_PER_HOUR_PER_SQRT_HOUR * root_hour, math.radians(1) / 3600, rtol=1e-15)
    assert_allclose(units.DEG_PER_HOUR_PER_HOUR * units.HOUR, math.radians(1) / 3600, rtol=1e-15)


def test_velocity_random_walk_in_both_its_units():
    # 1 m/s/sqrt(h) = 1/60 (m/s^2)/sqrt(Hz) = 1699.5 micro-g/sqrt(Hz)
    assert_allclose(units.M_PER_S_PER_SQRT_HOUR / units.MICRO_G_PER_SQRT_HZ, 1e6 / (60 * 9.80665), rtol=1e-15)


def test_drift_under_one_g():
    assert_allclose(units.DEG_PER_HOUR_PER_G * units.MILLI_G, 1e-3 * math.radians(1) / 3600, rtol=1e-15)
