"""Shape, range, pulses and noise of a unit against their definitions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from laboratories import LABORATORY, random_triad
from numpy.testing import assert_allclose, assert_array_equal

from fogkit.imu.size_effect import SizeEffect
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors, Shape
from fogkit.noise.processes import RandomErrors
from fogkit.stand.placements import six_positions

EPS = np.finfo(float).eps


def test_shape_by_hand():
    shape = Shape(asymmetry=(0.2, 0, 0), quadratic=(0, 0.5, 0), cubic=(0, 0, 0.25))
    assert_allclose(shape.apply(np.array([2.0, 2.0, 2.0])), [2.2, 4, 4], rtol=2 * EPS)
    assert_allclose(shape.apply(np.array([-2.0, -2.0, -2.0])), [-1.8, 0, -4], atol=4 * EPS)


def test_asymmetry_is_the_difference_of_the_slopes_over_their_mean():
    plus, minus = Shape(asymmetry=(3e-4,) * 3).apply(np.array([[1.0] * 3, [-1.0] * 3]))
    assert_allclose((plus - -minus) / ((plus - minus) / 2), 3e-4, rtol=10 * EPS / 3e-4)  # a difference of ones


@given(st.integers(0, 2**32 - 1))
def test_sensors_without_shape_are_the_linear_model(seed):
    rng = np.random.default_rng(seed)
    triad = random_triad(rng, 1e3, 0.1, sensitivity=0.1)
    inputs, force = rng.uniform(-2, 2, (2, 6, 3))
    # the sum in another order; terms of size 2e3 * 2
    assert_allclose(Sensors(triad=triad).expected(inputs, force), triad.readings(inputs, force), atol=1e4 * 10 * EPS)


def test_shape_acts_on_the_input_along_the_sensor():
    along = np.array([[0.6, 0.8, 0], [0, 1, 0], [0, 0, -1]])
    sensors = Sensors(triad=LinearTriad(matrix=2 * along), shape=Shape(quadratic=(0.1, 0, 0.1)))
    # inputs of 5, 4 and -2 along the three sensors, twice each, with a tenth of its square
    assert_allclose(sensors.expected([3, 4, 2]), [2 * (5 + 2.5), 8, 2 * (-2 + 0.4)], rtol=8 * EPS)


def test_beyond_the_range_the_reading_stays():
    sensors = Sensors(triad=LinearTriad(bias=(1, 1, 1), matrix=np.diag([2, 2, -2])), range=3.0)
    assert_array_equal(sensors.expected([[2, 3, 4], [-5, -3, -9]]), [[5, 7, -5], [-5, -5, 7]])


def test_noise_does_not_pass_the_end_of_the_range():
    shape = Shape(asymmetry=(0.1,) * 3)
    triad = LinearTriad(bias=(1, 1, 1), matrix=np.diag([2, 2, -2]))
    sensors = Sensors(triad=triad, shape=shape, range=3.0, random=RandomErrors(angle_random_walk=0.1))
    inputs = np.repeat([[3.0, -3.0, 3.0]], 400, axis=0)
    beyond = sensors.readings(2 * inputs, 0.1, np.random.default_rng(1))
    assert (beyond == beyond[0]).all()
    read = sensors.readings(inputs, 0.1, np.random.default_rng(1))
    # asymmetry: 5 % more one way, less the other; the third sensor points backwards
    end = np.array([1 + 2 * 3.15, 1 - 2 * 2.85, 1 - 2 * 2.85])
    assert_allclose([read[:, 0].max(), read[:, 1].min(), read[:, 2].min()], end, rtol=4 * EPS)
    at_end = np.mean(np.isclose(read, end, rtol=1e-14), axis=0)
    assert_allclose(at_end, 0.5, atol=5 * np.sqrt(0.25 / 400))  # half of the noise is outward; 5 sigma of a share


def test_noise_is_in_units_of_the_input():
    triad = LinearTriad(matrix=[[30, 40, 0], [0, 2, 0], [0, 0, -5]])
    sensors = Sensors(triad=triad, random=RandomErrors(angle_random_walk=0.01))
    n, dt = 4000, 0.25
    read = sensors.readings(np.ones((n, 3)), dt, np.random.default_rng(2))
    expected = np.array([50, 2, 5]) * 0.01 / np.sqrt(dt)  # angle random walk over the root of the sample time
    assert_allclose(read.std(axis=0), expected, rtol=5 / np.sqrt(2 * n))  # 5 sigma of a standard deviation
    assert_allclose(read.mean(axis=0), [70, 2, -5], atol=5 * 0.5 / np.sqrt(n))  # 50 * 0.01 / sqrt(dt) = 1 at most
    assert np.abs(np.corrcoef(read.T) - np.eye(3)).max() < 5 / np.sqrt(n)  # independent of each other


def test_pulses_are_counted_and_none_is_lost():
    sensors = Sensors(triad=LinearTriad(matrix=np.diag([10, 10, -10])), pulse=1.0)
    inputs = np.random.default_rng(3).uniform(-1, 1, (500, 3))
    read = sensors.readings(inputs, 0.1, np.random.default_rng(0))
    pulses = read * 0.1
    assert_allclose(pulses, np.rint(pulses), atol=1e-12)  # whole, but for the rounding of a product
    lost = np.cumsum(pulses - np.diag(sensors.triad.matrix) * inputs * 0.1, axis=0)
    assert np.abs(lost).max() <= 0.5 + 1e-12  # half a pulse at any time


def test_readings_along_the_axes_are_the_readings():
    rng = np.random.default_rng(4)
    triad = random_triad(rng, 1e3, 0.1, sensitivity=0.1)
    sensors = Sensors(triad=triad, random=RandomErrors(angle_random_walk=0.1), range=1.5)
    inputs, force = rng.uniform(-2, 2, (2, 50, 3))
    matrix = np.array(triad.matrix)
    along = inputs @ (matrix / np.linalg.norm(matrix, axis=1)[:, None]).T
    zero = np.array(triad.bias) + force @ np.transpose(triad.acceleration_sensitivity)
    read = sensors.readings_along(along, 0.1, np.random.default_rng(5), zero)
    # the same numbers in another order; readings of up to 1e4
    assert_allclose(read, sensors.readings(inputs, 0.1, np.random.default_rng(5), force), atol=1e4 * 1e-14)


def test_inputs_at_one_time_do_not_take_delays():
    sensors = Sensors(delay=(0, 1e-3, 0))
    for call in (lambda: sensors.expected([1, 2, 3]), lambda: sensors.readings(np.ones((2, 3)), 0.1, None)):
        with pytest.raises(ValueError, match="`delay` must be 0"):
            call()


@pytest.mark.parametrize(
    "unit",
    [
        MeasurementUnit(gyros=Sensors(delay=(0, 1e-3, 0))),
        MeasurementUnit(accelerometers=Sensors(delay=(0, 0, -1e-3))),
        MeasurementUnit(size_effect=SizeEffect.one_point(0.01 * np.eye(3))),
    ],
)
def test_a_plate_does_not_take_delays_and_size_effect(unit):
    with pytest.raises(ValueError, match="`unit` must have no delay and no size effect for a recording on a plate"):
        LABORATORY.record(unit, six_positions(1.0), np.random.default_rng(0))
    MeasurementUnit().require_point("a recording on a plate")


@pytest.mark.parametrize(
    ("make", "kind", "message"),
    [
        (lambda: Shape(cubic=(1, 2)), ValueError, "`cubic`"),
        (lambda: Shape(asymmetry=(1, 2, np.inf)), ValueError, "`asymmetry`"),
        (lambda: Sensors(triad="ideal"), TypeError, "`triad`"),
        (lambda: Sensors(random=0.1), TypeError, "`random`"),
        (lambda: Sensors(range=0), ValueError, "`range` must be > 0"),
        (lambda: Sensors(range=np.nan), ValueError, "`range` must be > 0"),
        (lambda: Sensors(delay=(0, 1)), ValueError, "`delay`"),
        (lambda: Sensors(delay=(0, 3, 0)), ValueError, "`delay` must be in .* Multiply milliseconds"),
        (lambda: MeasurementUnit(size_effect=0.01), TypeError, "`size_effect`"),
        (lambda: Sensors(pulse=-1), ValueError, "`pulse`"),
        (lambda: MeasurementUnit(gyros=LinearTriad()), TypeError, "`gyros`"),
        (lambda: Sensors().expected([1, 2]), ValueError, "`inputs`"),
        (
            lambda: Sensors(triad=LinearTriad(acceleration_sensitivity=np.eye(3))).expected([1, 2, 3]),
            ValueError,
            "`specific_force` must be given",
        ),
    ],
)
def test_errors_name_the_argument(make, kind, message):
    with pytest.raises(kind, match=message):
        make()
