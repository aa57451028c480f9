import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.optics import measure, simulate
from fogkit.optics.compensation import AfterLoop
from fogkit.optics.motion import AngularOscillation
from fogkit.units import DEG, DEG_PER_SQRT_HOUR

OSCILLATION = AngularOscillation(acceleration=5000 * DEG, frequency=60)


@pytest.mark.parametrize("cycles", [10.5, 20.5, 40.5])
def test_window_leaks_as_told(cycles):
    t = np.arange(200_000) / 200_000
    worst = max(
        abs(measure.windowed_mean(np.cos(2 * np.pi * cycles * t + phase))) for phase in np.linspace(0, np.pi, 9)
    )
    # half-way between two nulls; nine phases come within 1 - cos(pi / 16) of the worst
    assert_allclose(worst, measure.leakage(cycles), rtol=0.02)


def test_window_keeps_a_constant():
    assert_allclose(measure.windowed_mean(np.full(77, 3.25)), 3.25, rtol=1e-15)


def test_fit_finds_the_mean_under_a_large_oscillation():
    rng = np.random.default_rng(4)
    t = np.arange(5000) * 80e-6  # 24 cycles of 60 Hz
    angle = 2 * np.pi * 60 * t
    noise = 1e-3
    estimates = []
    for _ in range(200):
        values = 0.02 + 13 * np.sin(angle + 0.3) + 0.1 * np.cos(2 * angle) + noise * rng.standard_normal(t.size)
        estimates.append(measure.harmonic_fit(t, values, 60, harmonics=2))
    means, deviations = np.array(estimates).T
    assert_allclose(deviations.mean(), noise / np.sqrt(t.size), rtol=0.02)  # nearly orthogonal columns
    assert_allclose(means.std(), deviations.mean(), rtol=3 / np.sqrt(400))  # 3 sigma of 200
    assert abs(means.mean() - 0.02) < 3 * deviations.mean() / np.sqrt(200)


def test_three_ways_to_the_same_drift(make_gyro):
    gyro = make_gyro()
    windowed = measure.simulated_drift(gyro, OSCILLATION, 2.0).drift
    record = simulate.run(gyro, OSCILLATION, 2.0)
    settled = record.time > 0.1
    fitted, _ = measure.harmonic_fit(record.time[settled], record.rate[settled], 60, harmonics=5)
    difference = measure.nonlinear_error(gyro, OSCILLATION, 2.0)
    settled = difference.time > 1 / 3  # 100 whole cycles are left, and 1250 / 3 periods in each twenty
    assert_allclose(fitted, windowed, rtol=1e-5)
    assert_allclose(difference.rate[settled].mean(), windowed, rtol=1e-4)


def test_standard_deviation_of_a_noisy_measurement(make_gyro):
    gyro = make_gyro(detector_noise=1e-3)
    rng = np.random.default_rng(2)
    runs = [measure.simulated_drift(gyro, OSCILLATION, 0.35, rng=rng) for _ in range(200)]
    spread = np.std([run.drift for run in runs], ddof=1)
    assert_allclose(spread, runs[0].standard_deviation, rtol=3 / np.sqrt(400))  # 3 sigma of a deviation from 200


def test_stream_uses_memory_that_does_not_grow(make_gyro, monkeypatch):
    sizes = []
    original = simulate._kernels.period_means
    monkeypatch.setattr(simulate._kernels, "period_means", lambda *a: (sizes.append(a[0].size), original(*a))[1])
    measured = measure.simulated_drift(make_gyro(), OSCILLATION, 10.0)
    assert measured.samples == 2_000_000
    assert max(sizes) <= simulate.SAMPLES_PER_BLOCK


def test_too_short_a_record_is_refused(make_gyro):
    with pytest.raises(ValueError, match=r"`duration` must be at least 20 cycles"):
        measure.simulated_drift(make_gyro(), OSCILLATION, 0.1)


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("harmonics", (np.arange(9.0), np.zeros(9), 1.0, 0)),
        ("time", ([0.0, 1.0], [0.0, 1.0], 1.0, 1)),
        ("values", (np.arange(9.0), np.zeros(8), 1.0, 1)),
        ("frequency", (np.arange(9.0), np.zeros(9), 0.0, 1)),
    ],
)
def test_impossible_fits_are_refused(name, arguments):
    with pytest.raises(ValueError, match=f"`{name}`"):
        measure.harmonic_fit(*arguments)


@pytest.mark.parametrize("gain", [0.3, 1.0])
def test_lock_holds_below_its_limit_and_not_above(make_gyro, gain):
    gyro = make_gyro(gain=gain)
    limit = measure.largest_acceleration_in_lock(gyro, 60.0)
    for factor, held in ((0.99, True), (1.02, False)):
        oscillation = AngularOscillation(acceleration=factor * limit, frequency=60)
        lost = simulate.run(gyro, oscillation, 5 / 60, on_lock_loss="nan").lock_lost_at
        assert np.isnan(lost) == held
    # the sine returns at most 1 rad: a loop cannot gain more than `gain` rad in a regulation period for long
    assert limit > 0.9 * gain / (gyro.coil.sagnac_scale_factor * 80e-6)


def test_noise_for_a_wanted_angle_random_walk(make_gyro):
    gyro = make_gyro(shot_noise=1e-3).with_angle_random_walk(0.01 * DEG_PER_SQRT_HOUR)
    assert_allclose(gyro.angle_random_walk, 0.01 * np.pi / 180 / 60, rtol=1e-12)
    assert gyro.shot_noise == 0


def test_runs_at_rest_are_checked(make_gyro):
    with pytest.raises(ValueError, match="`runs`"):
        measure.simulated_noise_bias(make_gyro(), AfterLoop(), np.random.default_rng(1), runs=1)
    with pytest.raises(TypeError, match="`rng`"):
        measure.simulated_noise_bias(make_gyro(), AfterLoop(), 1)


def test_a_measurement_tells_what_the_oscillation_may_have_left(make_gyro):
    weak = AngularOscillation(acceleration=100 * DEG, frequency=60)
    short, long = (measure.simulated_drift(make_gyro(), weak, cycles / 60) for cycles in (20.5, 60.5))
    assert abs(short.drift - long.drift) <= short.leakage + long.leakage
    assert short.leakage > 1e-3 * abs(long.drift) > 10 * long.leakage


def test_a_measurement_goes_to_a_table_and_to_text_and_back(make_gyro):
    measured = measure.simulated_drift(make_gyro(), OSCILLATION)
    assert measure.DriftMeasurement.from_json(measured.to_json()) == measured
    assert measured.to_frame().value["drift"] == measured.drift
    with pytest.raises(ValueError, match="`text`"):
        measure.DriftMeasurement.from_json('{"kind": "LoopFigures"}')


def test_other_motions_are_refused_by_name(make_gyro):
    with pytest.raises(TypeError, match="`oscillation`"):
        measure.simulated_drift(make_gyro(), np.sin)


def test_differences_of_readings_have_no_true_rate(make_gyro):
    error = measure.nonlinear_error(make_gyro(), OSCILLATION, 0.02)
    assert_allclose(error.error, error.rate)


def test_harmonics_that_the_samples_cannot_tell_apart_are_refused():
    time = np.arange(100) * 0.01
    with pytest.raises(ValueError, match="`time`"):
        measure.harmonic_fit(time, np.zeros(100), 100.0)


def test_duration_and_samples_are_those_that_were_run(make_gyro):
    measured = measure.simulated_drift(make_gyro(), OSCILLATION, 0.5)
    assert_allclose(measured.duration, 0.5, rtol=1e-12)
    assert measured.samples == 100_000
