"""Gyro biases and azimuth: against what was put in, and the Earth's rotation that (31) takes for a bias."""

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose

from fogkit.calibration.navigation_based import Compensation, estimate_gyro_biases, gyrocompass_azimuth
from fogkit.constants import EARTH_RATE
from fogkit.earth import earth_rate_n, gravity_n
from fogkit.imu.tables import IMU_COLUMNS
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors
from fogkit.noise import RandomErrors
from fogkit.rotation import dcm_from_rotvec
from fogkit.stand.rough_table import RoughTable
from fogkit.stand.turn_recordings import exact_inputs, record
from fogkit.stand.turn_tests import TurnTest, bias_test
from fogkit.units import DEG, DEG_PER_SQRT_HOUR, MICRO_G_PER_SQRT_HZ

LATITUDE = 53.9 * DEG
BIAS = np.array([1e-7, -2e-7, 3e-7])
TEST = bias_test(dwell=100.0)
TILT = 1e-3


def recorded(**table):
    unit = MeasurementUnit(gyros=Sensors(triad=LinearTriad(bias=BIAS)))
    motions = RoughTable(latitude=LATITUDE, **table).motions([TEST])
    return record(unit, motions, 50.0)[0]


@pytest.fixture(scope="module")
def tilted():
    return recorded(level_east=TILT, azimuth_error=2e-3)


def estimate(recording, **options):
    return estimate_gyro_biases(recording, TEST, Compensation(), LATITUDE, **options)


def test_biases_of_a_level_unit_by_slopes(tilted):
    level = recorded()
    found = estimate(level)
    # compensated by nothing, readings have the bias too much; iteration makes the formulas exact
    assert_allclose(found.bias, BIAS, atol=1e-10)
    assert_allclose(found.compensation.gyro_bias, -BIAS, atol=1e-10)
    first = found.log.loc[1, ["b_g_1", "b_g_2", "b_g_3"]].to_numpy(dtype=float)
    assert 1e-10 < np.abs(first - BIAS).max() < 1e-8  # (29)-(31) alone leave the bending of the bend


def test_earth_rate_on_a_tilt_passes_for_a_bias_of_the_upright_gyro(tilted):
    model = estimate(tilted, initial_attitude="model")
    wrong = model.bias - BIAS
    # computed north is below the true one or above: the drift of the heading is Omega north times the tilt
    assert_allclose(abs(wrong[2]), EARTH_RATE * np.cos(LATITUDE) * TILT, rtol=0.02)
    # of the differences (29), (30) constant terms drop out; between the dwells the Earth turns by 0.008 rad, the terms
    # of Omega times the tilt, 7e-8, by a few times that
    assert np.abs(wrong[:2]).max() < 3e-9
    levelled = estimate(tilted)
    assert np.abs(levelled.bias - BIAS).max() < 1e-9


def test_rates_of_both_dwells_give_biases_and_azimuth_together(tilted):
    found = estimate(tilted, method="rates", initial_attitude="model")
    assert_allclose(found.bias, BIAS, atol=1e-11)
    assert_allclose(found.C_b_n, dcm_from_rotvec([TILT, 0, 2e-3]), atol=1e-7)
    assert found.solution.degrees_of_freedom == 4
    assert (found.standard_deviation > 0).all()


@pytest.mark.parametrize("method", ["slopes", "rates"])
def test_stated_deviations_are_those_of_random_walks(method):
    walks = [RandomErrors(angle_random_walk=n) for n in (0.002 * DEG_PER_SQRT_HOUR, 20 * MICRO_G_PER_SQRT_HZ)]
    unit = MeasurementUnit(gyros=Sensors(random=walks[0]), accelerometers=Sensors(random=walks[1]))
    test, runs = bias_test(dwell=60.0), 100
    exact = exact_inputs(unit, RoughTable(latitude=LATITUDE).motions([test]), 20.0)
    options = {"method": method, "iterations": 2}
    found = [
        estimate_gyro_biases(exact.record(np.random.default_rng(seed))[0], test, Compensation(), LATITUDE, **options)
        for seed in range(runs)
    ]
    observed = np.sqrt(np.mean([one.bias**2 for one in found], axis=0))
    stated = np.sqrt(np.mean([one.standard_deviation**2 for one in found], axis=0))
    # 4 sigma of a deviation from 100 runs
    assert_allclose(observed, stated, rtol=4 / np.sqrt(2 * runs))


@pytest.mark.parametrize("estimate_", [estimate_gyro_biases, gyrocompass_azimuth])
def test_a_whole_result_in_place_of_the_compensation_is_named(estimate_, tilted):
    arguments = (tilted, TEST) if estimate_ is estimate_gyro_biases else (tilted,)
    with pytest.raises(TypeError, match=r"`compensation` must be .*`\.compensation`"):
        estimate_(*arguments, object(), LATITUDE)


def test_slopes_in_another_heading_of_the_start():
    test = TurnTest.from_letters("NWU", "z", np.pi, label="bias", dwell=100.0, turn_duration=5.0)
    unit = MeasurementUnit(gyros=Sensors(triad=LinearTriad(bias=BIAS)))
    recording = record(unit, RoughTable(latitude=LATITUDE).motions([test]), 50.0)[0]
    assert_allclose(estimate_gyro_biases(recording, test, Compensation(), LATITUDE).bias, BIAS, atol=1e-10)


def test_only_a_half_turn_about_the_vertical_will_do(tilted):
    with pytest.raises(ValueError, match="must be half a turn about an axis that stands upright"):
        estimate_gyro_biases(tilted, TurnTest.from_letters("ENU", "x", np.pi), Compensation(), LATITUDE)


def spoilt(table, columns, factor):
    table = table.copy()
    table[[name for name in table if name.startswith(columns)]] *= factor
    return table


def moved(table, angle, axis="gyro_z", begin=20.0):
    """A motion by an angle within 2 s."""
    table = table.copy()
    inside = (table.index >= begin) & (table.index < begin + 2)
    table.loc[inside, axis] += angle / inside.sum()
    return table


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda t: spoilt(t, "accel", 1 / 9.80665), "must feel gravity, .* in units of g s"),
        (lambda t: spoilt(t, "accel", -1), r"must have \+z up in dwell 1, got -z up"),
        (lambda t: spoilt(t, "gyro", 1 / DEG), "in deg in place of rad"),
        (lambda t: spoilt(t, "gyro", 50), "rates in place of increments"),
        (lambda t: spoilt(t, "gyro_z", 0.5), r"must turn by \[0\.0, 0\.0, 180\.0\] deg about x, y, z, got"),
        (lambda t: moved(t, 5 * DEG), "must be at rest in dwell 1, .* got a motion of"),
        (lambda t: t.iloc[:-1], "must be as long as its test"),
    ],
)
@pytest.mark.parametrize("method", ["slopes", "rates"])
def test_recordings_of_something_else(tilted, method, change, words):
    with pytest.raises(ValueError, match=words):
        estimate(change(tilted), method=method)


def test_a_dwell_that_creeps_is_a_warning(tilted):
    # 0.1 deg in 2 s of 100 s: the halves differ by 3.5e-5 rad/s, (31) would be wrong by 2e-5 rad/s
    with pytest.warns(UserWarning, match=r"rates about z in the halves of dwell 1 of `recording` differ by 3\.5e-05"):
        estimate(moved(tilted, 0.1 * DEG))


def static(C_b_n, bias=(0, 0, 0), noise=0.0, count=30_000, dt=0.01, seed=0):
    """Recording at rest, with angle random walk of the given size."""
    rng = np.random.default_rng(seed)
    readings = np.concatenate([C_b_n.T @ earth_rate_n(LATITUDE) + bias, -C_b_n.T @ gravity_n(LATITUDE)]) * dt
    table = np.tile(readings, (count, 1))
    table[:, :3] += noise * np.sqrt(dt) * rng.normal(size=(count, 3))
    return pd.DataFrame(table, index=pd.Index(dt * np.arange(count), name="time"), columns=list(IMU_COLUMNS))


@pytest.mark.parametrize("heading_deg", [0.5, 45, 200, 315])
def test_azimuth_of_a_tilted_unit(heading_deg):
    heading = heading_deg * DEG
    C_b_n = dcm_from_rotvec([0, 0, -heading]) @ dcm_from_rotvec([0.01, -0.02, 0])
    forward = C_b_n[:, 1]
    expected = np.arctan2(forward[0], forward[1]) % (2 * np.pi)
    found = gyrocompass_azimuth(static(C_b_n, count=100), Compensation(), LATITUDE)
    assert_allclose(found.heading, expected, atol=1e-11)
    assert_allclose([found.level_rate, found.vertical_rate], earth_rate_n(LATITUDE)[1:], rtol=1e-10)


def test_azimuth_error_of_a_bias_and_of_noise():
    C_b_n, level = np.eye(3), EARTH_RATE * np.cos(LATITUDE)
    bias = 1e-8
    found = gyrocompass_azimuth(static(C_b_n, bias=(bias, 0, 0), count=100), Compensation(), LATITUDE)
    # the gyro that points east reads too much: what it calls north lies to the east of it, y heads west of that
    assert_allclose((found.heading + np.pi) % (2 * np.pi) - np.pi, -bias / level, rtol=1e-3)
    walk = 1e-6
    noisy = [gyrocompass_azimuth(static(C_b_n, noise=walk, seed=i), Compensation(), LATITUDE) for i in range(3)]
    expected = walk / np.sqrt(300) / level
    # from 300 blocks: good to 1 / sqrt(600) = 4 %, three of them within 4 sigma
    assert_allclose([one.standard_deviation for one in noisy], expected, rtol=0.16)
    given = gyrocompass_azimuth(static(C_b_n, noise=walk), Compensation(), LATITUDE, angle_random_walk=walk)
    assert_allclose(given.standard_deviation, expected, rtol=1e-2)  # the level rate itself is noisy: 6e-8 of 4e-5


def test_no_azimuth():
    with pytest.raises(ValueError, match="axis y does not stand upright"):
        gyrocompass_azimuth(static(dcm_from_rotvec([np.pi / 2, 0, 0]), count=100), Compensation(), LATITUDE)
    with pytest.raises(ValueError, match="must show the Earth's level rate"):
        gyrocompass_azimuth(static(np.eye(3), bias=(0, 1e-3, 0), count=100), Compensation(), LATITUDE)
    with pytest.raises(ValueError, match="must hold at least 8 steps, got 2"):
        gyrocompass_azimuth(static(np.eye(3), count=2), Compensation(), LATITUDE)
    still = static(np.eye(3), count=1000)
    with pytest.raises(ValueError, match=r"must feel gravity, 9\.814 m/s\^2, got 1\.0"):
        gyrocompass_azimuth(spoilt(still, "accel", 1 / 9.80665), Compensation(), LATITUDE)
    for columns in ("accel", "gyro"):  # upside down: north would come out as north, or as south
        with pytest.raises(ValueError, match="Earth's rate about the vertical"):
            gyrocompass_azimuth(spoilt(still, columns, -1), Compensation(), LATITUDE)


def test_azimuth_of_a_unit_that_moves():
    # there and back: no mean rate is left, but the halves differ
    still = static(np.eye(3), noise=1e-6, count=6000)
    there_and_back = moved(moved(still, 1e-2, "gyro_x", 10.0), -1e-2, "gyro_x", 40.0)
    with pytest.warns(UserWarning, match="rates about x in the halves of `recording` differ by 0.00067 rad/s"):
        gyrocompass_azimuth(there_and_back, Compensation(), LATITUDE)
    with pytest.warns(UserWarning, match="rates about x in the halves"):
        gyrocompass_azimuth(moved(still, 1e-3, "gyro_x", 10.0), Compensation(), LATITUDE)
