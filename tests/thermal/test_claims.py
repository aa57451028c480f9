"""The statements of the slides on temperature, each as the simulated test finds it."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.reproduction.beihang import temperature_drift, temperature_points, temperature_tests, temperature_transfer
from fogkit.thermal import experiment
from fogkit.units import DEG_PER_HOUR


def test_a_gyro_level_test_does_not_replace_a_system_level_one_the_more_so_the_better_the_gyro():
    found = [temperature_transfer.gyro_level_against_system_level(factor) for factor in (10.0, 1.0, 0.1)]
    for result in found:
        # the gyro-level fit is as good at its own level as the other at its own: nothing there warns of it
        assert_allclose(result.gyro_at_gyro, result.unit_in_unit, rtol=0.2)
    assert found[0].ratio < found[1].ratio < found[2].ratio
    assert found[1].ratio > 5


def test_a_gyro_level_test_need_not_be_symmetric_to_fail():
    assert temperature_transfer.gyro_level_against_system_level(asymmetry=0.1).ratio > 5


def test_what_does_not_repeat_remains():
    result = temperature_transfer.repeatability((0.0, 0.1, 0.3))
    # each run adds its offset, and a tenth in variance by the fit; 3 sigma of a deviation from 40 numbers, of which the
    # long runs, with most of the rows, are 16
    expected = np.hypot(result.left[0], np.array(result.deviation[1:]) * np.sqrt(1.1))
    assert_allclose(result.left[1:], expected, rtol=3 / np.sqrt(32))
    assert result.removed[0] > 0.95 > 0.5 > result.removed[2]
    with pytest.raises(ValueError, match="`levels`"):
        temperature_transfer.repeatability((-0.1,))


def test_the_bias_after_a_short_time_is_the_rate_of_the_electronics_at_first():
    result = temperature_drift.short_run_limit()
    assert 0.1 < result.repeatability_time < result.hundredth_time < 60
    assert result.noise_time < 60
    assert result.after_minute > 0.01 * DEG_PER_HOUR
    assert result.spread < 1e-3 * result.after_ten_minutes  # a linear network: the same at any start temperature
    # closed form of the first seconds: half the change of the bias at its initial rate
    gyro, unit = experiment.example_gyro(), experiment.in_unit()
    time = np.array([0.0, 1e-3, 1.0])
    bias = gyro.truth(unit.nodes, *unit.solve(time, experiment.soak(20.0)))
    slope = abs(bias[1] - bias[0]) / 1e-3
    assert_allclose(result.repeatability_time * slope / 2, gyro.bias_repeatability, rtol=0.05)


def test_start_up_and_steady_state_differ_as_long_as_points_are_missing_or_noisy():
    noisy = temperature_transfer.start_up_against_steady_state()
    assert noisy.start_in_steady > 2 * noisy.steady_in_steady
    exact = temperature_transfer.start_up_against_steady_state(thermometer_noise=0.0)
    assert exact.steady_in_start < 1.3 * exact.start_in_start  # all points, exactly known: one law for both
    assert exact.start_in_steady > 10 * exact.steady_in_steady  # but starts do not determine it
    single = temperature_transfer.start_up_against_steady_state(("coil_top",), thermometer_noise=0.0)
    assert single.start_in_steady > 2 * single.steady_in_steady > 10 * exact.steady_in_steady


def test_three_points_are_kept_and_enough():
    result = temperature_points.points_needed()
    assert set(result.kept) == set(temperature_tests.TRUE_POINTS)
    assert result.three < 0.2 * min(result.one, result.two)
    assert_allclose(result.six, result.three, rtol=0.25)


def test_orders_of_the_polynomials():
    assert temperature_points.accelerometer_order().order == 3
    assert temperature_points.scale_factor_order().order == 1


def test_collinearity_of_starts():
    result = temperature_points.start_up_collinearity()
    assert result.single_constant > 1e6
    assert result.unit_six_starts < result.unit_from_power_on < result.unit_after_half_hour
    assert result.six_starts_with_offsets > 2 * result.unit_six_starts


def test_results_are_records():
    result = temperature_drift.short_run_limit()
    assert type(result).from_json(result.to_json()) == result
    with pytest.raises(ValueError, match="`treatment`"):
        temperature_points.pruning_rates([0], "guess")
