"""The simulations behind the chapters: against closed forms and against the bench's own mean readings."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.calibration import three_stage
from fogkit.imu import GyroTriad
from fogkit.imu.readings import mean_readings
from fogkit.reproduction.volynskii import budget, chapters, instruments, simulation
from fogkit.rotation import dcm_from_rotvec
from fogkit.stand import bench
from fogkit.units import ARCSEC, DEG, DEG_PER_HOUR, DEG_PER_SECOND

TRIAD = GyroTriad(
    bias=(1e-6, -2e-6, 3e-6),
    scale_positive=(1.7, 1.6, 1.5),
    scale_negative=(1.6, 1.7, 1.4),
    misalignments=np.array([1, -2, 3, -4, 5, -3]) * 1e-3,
)


@pytest.fixture
def rng():
    return np.random.default_rng(2011)


def test_sampled_rates_have_the_mean_of_the_bench():
    axis, rate, samples = np.array([0.6, 0, 0.8]), 0.01, 20_000
    earth = np.array([3e-5, -6e-5, 2e-5])
    angle = 2 * np.pi * (np.arange(samples) + 0.5) / samples
    omega = rate * axis + dcm_from_rotvec(angle[:, None] * axis).swapaxes(-1, -2) @ earth
    closed = mean_readings(TRIAD, np.eye(3), axis, rate, earth, 2 * np.pi / rate)
    # ideal gyros believed: the computed rates are the readings
    assert_allclose(chapters.sampled_rates(TRIAD, omega).mean(axis=0), closed, rtol=1e-8)


def test_a_true_calibration_gives_true_rates(rng):
    omega = rng.normal(size=(100, 3))
    assert_allclose(chapters.sampled_rates(TRIAD, omega, believed=TRIAD), omega, atol=1e-14)


@pytest.mark.parametrize("phase", [0.0, 0.7, np.pi / 2])
def test_perfect_gyros_keep_the_attitude(phase):
    ship = chapters.roll_and_pitch(30 * DEG, 5 * DEG, 6.0, phase)
    # rounding of a thousand products of matrices
    assert_allclose(chapters.attitude_errors(*ship, 6.0, GyroTriad()), 0, atol=1e-12)


@pytest.mark.parametrize("phase", [0.3, np.pi / 2, 2.5])
def test_locked_motion_drifts_by_the_law_at_small_angles(phase):
    roll, pitch, period = 0.01, 0.02, 6.0
    ship = chapters.roll_and_pitch(roll, pitch, period, phase)
    law = chapters.locked_drift(roll, pitch, period, phase)
    scale = GyroTriad(scale_positive=(1 + 1e-4,) * 3, scale_negative=(1 + 1e-4,) * 3)
    leaning = GyroTriad(misalignments=(0, 1e-4, 0, 0, 0, 0))
    # next order: the squares of roll and pitch, and 1e-4 of the error itself
    heading = chapters.attitude_errors(*ship, period, scale)[-1, 2] / period
    assert_allclose(abs(heading), law * 1e-4, rtol=2e-3)
    level = np.linalg.norm(chapters.attitude_errors(*ship, period, leaning)[-1]) / period
    assert_allclose(level, law * 1e-4, rtol=2e-3)


def test_a_circle_undoes_the_tilt_of_a_misaligned_gyro_but_not_the_heading():
    rate, angle = 3 * DEG_PER_SECOND, 3 * ARCSEC
    course, duration = chapters.circles(rate, 1), 120.0
    tilt = chapters.attitude_errors(*course, duration, GyroTriad(misalignments=(0, 0, -angle, 0, 0, 0)))
    assert_allclose(np.abs(tilt[:, :2]).max(), 2 * angle, rtol=1e-4)
    assert_allclose(tilt[-1, :2], 0, atol=1e-4 * angle)
    heading = chapters.attitude_errors(*course, duration, GyroTriad(scale_positive=(1 + 1e-6,) * 3))
    assert_allclose(heading[-1, 2], -2 * np.pi * 1e-6, rtol=1e-5)


@pytest.mark.parametrize("factor", budget.NOISE_FACTORS.values())
@pytest.mark.parametrize("shared", [True, False])
def test_example_bench_scatters_as_the_corrected_equation_says(shared, factor, rng):
    runs = 1000
    plan, triad, table = chapters.example_bench(shared_bias=shared, noise_factor=factor)
    found = three_stage.calibrate(bench.run(plan, triad, table, rng=rng, runs=runs))
    test = budget.at_rate(instruments.TEST_RATES[1], noise_factor=factor)
    spread = found.estimate[:, 3:6].std(axis=0)
    assert_allclose(spread, test.deviation, rtol=4 / np.sqrt(2 * runs))
    asymmetry = test.asymmetry_deviation
    if not shared:  # once each way, and twice the half that the mean of the four positions keeps; white noise of these
        parts, instability = test.parts, triad.bias_instability
        means = 4 * (instability**2 / 4 + triad.angle_random_walk**2 / (4 * instruments.BIAS_DURATION))
        biases = (2 * instability**2 + means) * test.duration**2
        asymmetry = np.sqrt(2 * (parts["readout"] ** 2 + parts["noise"] ** 2) + biases) / test.angle
    assert_allclose(found.asymmetry.std(axis=0), asymmetry, rtol=4 / np.sqrt(2 * runs))


def test_the_half_hour_test_fits_and_has_whole_turns():
    plan = chapters.half_hour_plan()
    assert plan.duration <= instruments.TEST_DURATION
    assert all(segment.is_whole for segment in plan.segments)


def test_causes_of_a_spread_leave_their_marks():
    warm = chapters.warming_scale_factors(scale_per_kelvin=1e-6)
    elapsed = np.array([s.duration for s in chapters.half_hour_plan().segments])
    middle = (np.cumsum(elapsed) - elapsed / 2) / elapsed.sum()
    assert_allclose(warm.to_numpy().ravel(), 1e-6 * middle, rtol=1e-6)
    bias = chapters.warming_scale_factors(bias_error=0.01 * ARCSEC)
    assert_allclose(bias.negative, 0.01 * ARCSEC / (bias.index.to_numpy() * DEG_PER_SECOND), rtol=1e-5)
    assert_allclose(bias.positive, -bias.negative, rtol=1e-5)
    assert chapters.spread(bias) == pytest.approx(0.01 / 3600 * (1 - 1 / 36), rel=1e-5)


def test_drifts_of_the_tables_against_products():
    drifts = chapters.drifts_of_the_tables().drift
    assert drifts["bias x"] == pytest.approx(0.008)
    assert drifts["mounting"] == pytest.approx(3 * ARCSEC * 6 * DEG_PER_SECOND / DEG_PER_HOUR, rel=1e-6)
    spread = simulation.relative_spreads()["y+"]
    assert drifts["scale y+"] == pytest.approx(spread * 6 * 3600)
