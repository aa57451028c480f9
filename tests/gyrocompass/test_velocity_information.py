"""Heading from all velocities at once: against the bound, against closed forms, and at its limits.

Against the covariance of the full error model it stands in `test_covariance`.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import jv

from fogkit.constants import EARTH_RATE, STANDARD_GRAVITY
from fogkit.gyrocompass.accuracy import heading_bound, mean_direction
from fogkit.gyrocompass.covariance import Aid, Noise, Prior, run_covariance
from fogkit.gyrocompass.laws import ConstantSpeedReversal, Fixed, QuasiHarmonic
from fogkit.gyrocompass.motions import Vessel
from fogkit.gyrocompass.velocity_information import bias_left, heading_from_velocities
from fogkit.units import DEG, DEG_PER_HOUR, PERCENT

LAT, WALK = 60 * DEG, 0.0176 * DEG / 60
LEVEL = EARTH_RATE * np.cos(LAT)
BIAS = 20 * DEG_PER_HOUR
LAWS = {
    "thesis": QuasiHarmonic(amplitude=np.pi, period=60.0),
    "off centre": QuasiHarmonic(amplitude=1.1, period=75.0, centre=0.5, phase=0.3),
    "reversal": ConstantSpeedReversal(amplitude=2.0, period=50.0, reversal_time=5.0),
    "not the same from its end": QuasiHarmonic(amplitude=1.1, period=170.0, centre=0.5, phase=0.3),
}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_perfect_velocities_reach_the_bound(law):
    prior = Prior(heading=20 * DEG, bias=BIAS, scale_factor=0)
    bound = heading_bound(law, 300.0, LAT, WALK, bias_std=BIAS, drift_std=BIAS).std
    found = heading_from_velocities(law, 300.0, LAT, WALK, 1e-7, prior, interval=0.5)
    # tilt rates between velocities 0.5 s apart, less the first second for the unknown start
    assert_allclose(found, (bound**-2 + prior.heading**-2) ** -0.5, rtol=0.01)


@pytest.mark.parametrize("scale_factor", [0, 1 * PERCENT])
@pytest.mark.parametrize("drift", [None, 0.0])
def test_what_is_known_leaves_the_fit(drift, scale_factor):
    prior = Prior(heading=20 * DEG, bias=0, scale_factor=scale_factor)
    found = heading_from_velocities(LAWS["thesis"], 300.0, LAT, WALK, 1e-7, prior, drift_std=drift, interval=0.5)
    bound = heading_bound(LAWS["thesis"], 300.0, LAT, WALK, bias_std=0.0).std
    assert_allclose(found, (bound**-2 + prior.heading**-2) ** -0.5, rtol=0.02)


def test_scale_factors_matter_to_a_slow_law():
    # one swing in the whole time: a scale factor turns heading by up to 1.8 degrees meanwhile. The full error model has
    # them; without them heading would come out 9 per cent better
    law = QuasiHarmonic(amplitude=np.pi, period=300.0)
    prior = Prior(heading=20 * DEG, bias=BIAS)
    still = Aid(std=dict.fromkeys(("velocity_north", "velocity_up", "velocity_east"), 1e-3))
    motion = Vessel(lat=LAT, heading=50 * DEG).motion(300.0, 0.1, law)
    truth = run_covariance(motion, Noise(angle_random_walk=WALK), still, prior).of("heading")[-1]
    found = heading_from_velocities(law, 300.0, LAT, WALK, 1e-3, prior, heading=50 * DEG)
    assert_allclose(found, truth, rtol=0.005)
    known = Prior(heading=20 * DEG, bias=BIAS, scale_factor=0)
    assert heading_from_velocities(law, 300.0, LAT, WALK, 1e-3, known) < 0.93 * truth


def test_biases_split_from_heading_make_the_bound_again():
    # noise of heading, plus what is left of a bias by the mean direction: the Schur complement in two steps
    for law in list(LAWS.values())[:3]:  # those with whole periods in the time
        left = bias_left(law, 300.0, WALK, 0.0, BIAS)
        m = abs(mean_direction(law))
        std = np.hypot(WALK / (LEVEL * np.sqrt(300.0)), m * left / LEVEL)
        # means over 4096 points there, a thousand lines here: 1e-4 where the rate has corners
        assert_allclose(std, heading_bound(law, 300.0, LAT, WALK, bias_std=BIAS).std, rtol=1e-4)


def test_bias_left_in_closed_form():
    k = np.arange(1, 80)
    density = WALK**2 + 0.1**2 * 0.5 * (2 * np.pi * k / 60) ** 4 / STANDARD_GRAVITY**2
    information = 300.0 * 2 * (jv(k, np.pi) ** 2 / density).sum()
    found = bias_left(LAWS["thesis"], 300.0, WALK, 0.1, BIAS, interval=0.5)
    assert_allclose(found, (information + BIAS**-2) ** -0.5, rtol=1e-9)
    assert_allclose(bias_left(Fixed(), 300.0, WALK, 0.1, BIAS), BIAS, rtol=1e-12)


@pytest.mark.parametrize("velocity_std", [1e-3, 1e-2, 0.1])
@pytest.mark.parametrize("period", [20.0, 60.0])
def test_the_two_terms_explain_a_poor_aid(velocity_std, period):
    law = QuasiHarmonic(amplitude=np.pi, period=period)
    prior = Prior(heading=20 * DEG, bias=BIAS)
    known = Prior(heading=20 * DEG, bias=0)
    whole = heading_from_velocities(law, 300.0, LAT, WALK, velocity_std, prior)
    without = heading_from_velocities(law, 300.0, LAT, WALK, velocity_std, known, drift_std=BIAS)
    variance = 1 / (without**-2 - prior.heading**-2)
    variance += (abs(mean_direction(law)) * bias_left(law, 300.0, WALK, velocity_std, BIAS) / LEVEL) ** 2
    # lines are right for many periods; the edges of five of them take a tenth of the information on a bias at most
    assert_allclose((1 / variance + prior.heading**-2) ** -0.5, whole, rtol=0.05)


def test_bad_input():
    law, prior = LAWS["thesis"], Prior()
    with pytest.raises(ValueError, match=r"`duration` must be in \[0.0, 1000.0\] s"):
        heading_from_velocities(law, 2000.0, LAT, WALK, 0.1, prior)
    with pytest.raises(ValueError, match="`duration` must be a multiple"):
        heading_from_velocities(law, 300.5, LAT, WALK, 0.1, prior)
    with pytest.raises(ValueError, match="`velocity_std` must be finite and > 0"):
        heading_from_velocities(law, 300.0, LAT, WALK, 0.0, prior)
    with pytest.raises(ValueError, match="not defined at a pole"):
        heading_from_velocities(law, 300.0, np.pi / 2, WALK, 0.1, prior)
    with pytest.raises(TypeError, match="`prior` must be a Prior"):
        heading_from_velocities(law, 300.0, LAT, WALK, 0.1, 0.1)
    with pytest.raises(ValueError, match="`velocity_std` must be finite and >= 0"):
        bias_left(law, 300.0, WALK, -0.1, BIAS)
    assert heading_from_velocities(law, 300.0, LAT, WALK, 0.1, Prior(heading=0)) == 0.0
