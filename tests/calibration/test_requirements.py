"""Requirements against brute force: gyros simulated sample by sample, exact rotations, drawn angle readings."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import trapezoid

from fogkit.calibration import requirements as req
from fogkit.constants import EARTH_RATE
from fogkit.earth import earth_rate_n
from fogkit.rotation import dcm_from_rotvec
from fogkit.units import ARCSEC, DEG, DEG_PER_HOUR, DEG_PER_SECOND

DRIFT = 0.01 * DEG_PER_HOUR


def simulated_rocking_drift(positive, negative, amplitude, samples=2_000_000, periods=4):
    """Mean of reading less truth under harmonic rocking of a gyro with two scale factors, read with their mean."""
    phase = 2 * np.pi * periods * (np.arange(samples) + 0.5) / samples
    rate = amplitude * np.sin(phase)
    reading = np.where(rate > 0, positive, negative) * rate / ((positive + negative) / 2)
    return np.mean(reading - rate)


@pytest.mark.parametrize(("positive", "negative"), [(1.0000005, 0.9999995), (1.730345, 1.730357), (2.1, 1.9)])
def test_rocking_drift_is_that_of_a_simulated_gyro(positive, negative):
    amplitude = req.rocking_rate_amplitude(30 * DEG, 6.0)
    drift = req.drift_from_asymmetry(req.asymmetry(positive, negative), amplitude)
    # midpoint rule on |sin|, 5e5 samples per period: (pi / 5e5)^2 / 6; 1e-9 for the rounding of 1 +- 5e-7
    assert_allclose(drift, simulated_rocking_drift(positive, negative, amplitude), rtol=2e-9)


def test_rocking_drift_with_the_scale_factor_of_one_sign_for_both():
    # another reading of "uncompensated": M+ used throughout; the drift is the same, from the negative half alone
    phase = 2 * np.pi * (np.arange(100_000) + 0.5) / 100_000
    rate = 0.5 * np.sin(phase)
    reading = np.where(rate > 0, 1.0, 1.0 - 1e-6) * rate
    expected = req.drift_from_asymmetry(req.asymmetry(1.0, 1.0 - 1e-6), 0.5)
    assert_allclose(np.mean(reading - rate), expected, rtol=1e-6)  # the asymmetry is over the mean: 5e-7


def test_rocking_rate_amplitude_is_the_largest_slope_of_the_angle():
    t = np.linspace(0, 6, 600_001)
    slope = np.gradient(30 * DEG * np.sin(2 * np.pi * t / 6), t)
    assert_allclose(req.rocking_rate_amplitude(30 * DEG, 6), slope.max(), rtol=1e-9)


def test_turn_with_a_wrong_scale_factor():
    rate, t = 6 * DEG_PER_SECOND, np.linspace(0, 60, 6001)
    heading = trapezoid(np.full(t.size, rate * (1 + 1e-6)), t)  # one turn
    assert_allclose((heading - 2 * np.pi) / 60, req.drift_from_scale_error(1e-6, rate), rtol=1e-8)


def test_turn_with_a_leaning_axis():
    angle = 100 * ARCSEC
    axis = dcm_from_rotvec([0, angle, 0]) @ [1, 0, 0]  # x leans towards -z
    assert_allclose(axis @ [0, 0, -0.1], req.drift_from_misalignment(angle, 0.1), rtol=1e-12)


def test_earth_rate_error_is_that_of_a_rotated_table_to_first_order():
    psi, lat = np.array([3e-4, -2e-4, 5e-4]), 0.9

    def remainder(scale):
        C_t_n = dcm_from_rotvec(scale * psi)  # axes of the turned table in n
        exact = earth_rate_n(lat) - C_t_n.T @ earth_rate_n(lat)
        return np.linalg.norm(exact - req.earth_rate_error(scale * psi, lat)) / EARTH_RATE

    assert remainder(1) < np.linalg.norm(psi) ** 2
    assert_allclose(remainder(1) / remainder(0.5), 4, rtol=1e-3)  # second order


def test_azimuth_and_levelling_are_the_worst_cases_of_the_vector():
    lat, error = 60 * DEG, 0.002 * DEG_PER_HOUR
    azimuth, level = req.azimuth_from_rate_error(error, lat), req.levelling_from_rate_error(error)
    assert_allclose(np.linalg.norm(req.earth_rate_error([0, 0, azimuth], lat)), error, rtol=1e-12)
    direction = np.linspace(0, 2 * np.pi, 361)
    tilts = level * np.stack([np.cos(direction), np.sin(direction), 0 * direction], axis=-1)
    assert_allclose(np.linalg.norm(req.earth_rate_error(tilts, lat), axis=-1).max(), error, rtol=1e-12)


def test_readout_against_drawn_readings():
    rng, runs = np.random.default_rng(7), 200_000
    turned = 72 * np.pi + rng.normal(0, 3 * ARCSEC, runs) - rng.normal(0, 3 * ARCSEC, runs)
    # 3 sigma of a standard deviation from this many draws
    assert_allclose(
        req.scale_error_from_readout(3 * ARCSEC, 72 * np.pi),
        np.std(turned / (72 * np.pi)),
        rtol=3 / np.sqrt(2 * runs),
    )


def test_table_stability_is_a_share_of_the_gyros_drift():
    # a table that misses its rate by 5e-6 at 30 deg/s is wrong by 0.54 deg/h
    error = req.drift_from_table_stability(5e-6, -30 * DEG_PER_SECOND, margin=1)
    assert_allclose(error, 0.54 * DEG_PER_HOUR, rtol=1e-12)
    assert_allclose(req.drift_from_table_stability(5e-6, 30 * DEG_PER_SECOND), 5 * error, rtol=1e-12)


@pytest.mark.parametrize(
    ("there", "back", "other"),
    [
        (req.drift_from_asymmetry, req.asymmetry_from_drift, [0.2, 1.0]),
        (req.drift_from_scale_error, req.scale_error_from_drift, [-0.2, 1.0]),
        (req.drift_from_misalignment, req.misalignment_from_drift, [-0.2, 1.0]),
        (req.drift_from_table_stability, req.table_stability_from_drift, [-0.2, 1.0]),
        (req.scale_error_from_readout, req.readout_from_scale_error, [-0.2, 1.0]),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_inverses(there, back, other):
    errors = np.array([[1e-7], [3e-3]])
    assert_allclose(back(there(errors, other), other), errors * np.ones(2), rtol=1e-12)


def test_angle_for_a_scale_factor():
    angle = req.angle_from_scale_error(1e-6, 3 * ARCSEC)
    assert_allclose(req.scale_error_from_readout(3 * ARCSEC, angle), 1e-6, rtol=1e-12)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: req.asymmetry(0.0, 1.0), ["`positive`", "> 0", "got 0.0"]),
        (lambda: req.asymmetry(1.0, [1.0, -1.0]), ["`negative`", "got -1.0"]),
        (lambda: req.rocking_rate_amplitude(-1.0, 6), ["`angle`", ">= 0 rad"]),
        (lambda: req.rocking_rate_amplitude(1.0, 0), ["`period`", "> 0 s"]),
        (lambda: req.drift_from_asymmetry(np.nan, 1.0), ["`asymmetry`", "finite"]),
        (lambda: req.drift_from_asymmetry(1e-6, 0.0), ["`rate_amplitude`", "> 0 rad/s"]),
        (lambda: req.asymmetry_from_drift(DRIFT, -1.0), ["`rate_amplitude`"]),
        (lambda: req.scale_error_from_drift(DRIFT, 0), ["`rate`", "other than 0 rad/s"]),
        (lambda: req.drift_from_misalignment(3.0, 1.0), ["`misalignment`", "ARCSEC"]),
        (lambda: req.misalignment_from_drift(2.0, 1.0), ["`drift`", "`cross_rate`", "2 times"]),
        (lambda: req.earth_rate_error([0, 0, 30.0], 0.5), ["`misorientation`", "ARCSEC"]),
        (lambda: req.earth_rate_error([0, 0], 0.5), ["`misorientation`", "(..., 3)"]),
        (lambda: req.earth_rate_error([0, 0, 1e-4], 60.0), ["`lat`"]),
        (lambda: req.azimuth_from_rate_error(DRIFT, np.pi / 2), ["`lat`"]),
        (lambda: req.levelling_from_rate_error(np.inf), ["`rate_error`"]),
        (lambda: req.table_stability_from_drift(DRIFT, 1.0, margin=0), ["`margin`"]),
        (lambda: req.drift_from_table_stability(-1e-6, 1.0), ["`stability`", ">= 0"]),
        (lambda: req.scale_error_from_readout(ARCSEC, 0.0), ["`angle`"]),
        (lambda: req.readout_from_scale_error(-1e-6, 1.0), ["`scale_error`"]),
        (lambda: req.angle_from_scale_error(0.0, ARCSEC), ["`scale_error`", "> 0"]),
    ],
)
def test_bad_input_is_named(call, words):
    with pytest.raises(ValueError) as caught:
        call()
    assert all(word in str(caught.value) for word in words), str(caught.value)
