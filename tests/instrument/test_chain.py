"""Each link of the chain carries a planted error through: into the calibration, and from there into heading."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.calibration import three_stage
from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass.laws import ConstantSpeedReversal
from fogkit.imu.constructions import Construction
from fogkit.imu.unit import MeasurementUnit, Sensors
from fogkit.instrument import GRADES, METHODS, Conditions, Instrument, Stand, calibrate, errors_left
from fogkit.instrument.description import bench_triad, loop_reading
from fogkit.instrument.heading import Knowledge, Task, at_rest, on_mount
from fogkit.noise.processes import RandomErrors
from fogkit.optics.coil import Coil
from fogkit.optics.gyro import ClosedLoopGyro
from fogkit.optics.loop import Loop
from fogkit.rotation import dcm_from_heading_pitch_roll
from fogkit.stand import bench, plans
from fogkit.stand.table import RateTable
from fogkit.thermal.experiment import CoilBias, in_unit
from fogkit.units import DEG, DEG_PER_HOUR, DEG_PER_SECOND_SQUARED, DEG_PER_SQRT_HOUR, MINUTE, PPM

LATITUDE = 60 * DEG
LEVEL = EARTH_RATE * np.cos(LATITUDE)
TASK = Task(lat=LATITUDE, law=ConstantSpeedReversal(amplitude=np.pi, period=60.0), heading=0.7)
SHAKEN = Conditions(acceleration=(5000 * DEG_PER_SECOND_SQUARED, 3000 * DEG_PER_SECOND_SQUARED, 0.0))
STILL = Conditions()


@pytest.fixture(scope="module")
def instrument():
    """Large coil, hardly any noise, nothing else wrong: what is found is what was planted."""
    coil = Coil(length=1000.0, diameter=0.1)
    loop = Loop(depth=3 * np.pi / 4, half_period=coil.transit_time, half_periods=16)
    gyro = ClosedLoopGyro(coil=coil, loop=loop).with_angle_random_walk(1e-6 * DEG_PER_SQRT_HOUR)
    accelerometers = Sensors(random=RandomErrors(angle_random_walk=1e-10))  # a calibration weighs by some noise
    return Instrument(
        gyro=gyro, network=in_unit(), thermal=CoilBias(), unit=MeasurementUnit(accelerometers=accelerometers)
    )


def lag_drift(instrument, acceleration):
    """Mean drift by hand from the paper's mended eq. (11), rad/s: half of ``cot(depth) S eps^2 dt_m dt_p / 4``."""
    coil = instrument.gyro.coil
    sagnac = 2 * np.pi * coil.length * coil.diameter / (coil.wavelength * 299792458.0)
    transit = 1.468 * coil.length / 299792458.0
    dt_m, dt_p = 2 * transit, 16 * transit  # a period of modulation, and eight of them
    return -0.5 * sagnac * acceleration**2 * dt_m * dt_p / 4


def north_error(bias_east):
    """Clockwise error of the heading of the case, rad: a bias to the east turns the found north towards east."""
    return -bias_east / LEVEL


def east_of(bias):
    """Component to the east of a bias in the case that heads 0.7 rad."""
    return (dcm_from_heading_pitch_roll(0.7, 0.0, 0.0) @ bias)[0]


@pytest.mark.parametrize("method", METHODS[1:])
def test_a_planted_acceleration_drift_comes_out_as_a_bias_and_then_as_heading(instrument, method):
    found = calibrate(method, instrument.at(SHAKEN), Stand(name="ideal"), LATITUDE, np.random.default_rng(1))
    planted = np.array([lag_drift(instrument, a) for a in SHAKEN.acceleration])
    bias = -np.linalg.inv(found.compensation.gyro_matrix) @ found.compensation.gyro_bias
    # the law for slow vibration, 60 Hz against 12.8 kHz, and to the second degree: 2e-3 of the drift; noise of 1e-6
    # deg/sqrt(h) over a minute and more, 1e-5 deg/h; coning of the Earth in the navigation, 1e-5 deg/h
    assert abs(planted[0]) > 0.1 * DEG_PER_HOUR
    assert_allclose(bias, planted, rtol=4e-3, atol=1e-4 * DEG_PER_HOUR)
    left = errors_left(instrument, found, SHAKEN, STILL)
    assert_allclose(left.biases["vibration"], -planted, rtol=4e-3, atol=1e-6 * DEG_PER_HOUR)
    expected = north_error(east_of(-planted))
    assert abs(expected) > 0.5 * DEG
    # second order in the ratio of bias and Earth rate: 2 per cent
    assert_allclose(at_rest(left, TASK), expected, rtol=0.03)
    known = Knowledge(bias=1 * DEG_PER_HOUR, scale_factor=1e-5)
    # what is left of it with the mount: heading that drifts with the up gyro for half of the time
    on = on_mount(left, TASK, 1e-3 * DEG_PER_SQRT_HOUR, known)
    assert abs(on) < 0.02 * abs(expected)


def test_from_the_detector_through_three_stages_to_heading(instrument):
    # nothing but loops simulated half-period by half-period: four positions, three gyros, then a heading
    plan = plans.three_stage(Construction(name="plain"), bias_duration=60.0, count=2)
    table, silent = RateTable(latitude=LATITUDE), replace(instrument.gyro, detector_noise=0.0)
    record = bench.run(plan, bench_triad(MeasurementUnit()), table)
    readings = record.readings.copy()
    for i in plan.positions:
        readings[i] = [loop_reading(silent, rate, SHAKEN, axis) for axis, rate in enumerate(readings[i])]
    bias = three_stage.calibrate(replace(record, readings=readings)).estimate[:3]
    planted = np.array([lag_drift(instrument, a) for a in SHAKEN.acceleration])
    # the window of 24 cycles lets 1e-7 of 50 deg/s through, 0.02 deg/h at most, and as much in each position
    assert_allclose(bias, planted, rtol=4e-3, atol=2e-3 * DEG_PER_HOUR)
    true = dcm_from_heading_pitch_roll(0.7, 0.0, 0.0).T @ np.array([0.0, LEVEL, EARTH_RATE * np.sin(LATITUDE)])
    rates = np.array([loop_reading(silent, rate, STILL, axis) for axis, rate in enumerate(true)]) - bias
    heading = np.arctan2(-rates[0], rates[1])
    assert_allclose(heading - 0.7, north_error(east_of(-planted)), rtol=0.03)


def test_a_temperature_at_sea_moves_the_bias_by_the_planted_coefficients(instrument):
    per_kelvin = 0.01 * DEG_PER_HOUR
    effect = CoilBias(temperature={"coil_top": per_kelvin, "coil_bottom": 3 * per_kelvin, "electronics": -per_kelvin})
    warm = replace(instrument, thermal=effect, thermal_share=(1.0, -2.0, 0.0))
    found = calibrate("three-stage", warm.at(STILL), Stand(name="ideal"), LATITUDE, np.random.default_rng(1))
    left = errors_left(warm, found, STILL, Conditions(chamber=5.0))
    # once settled every node is 20 K colder; noise of the bench as above
    expected = np.array([1.0, -2.0, 0.0]) * 3 * per_kelvin * -20
    assert_allclose(left.bias, expected, rtol=1e-6, atol=1e-4 * DEG_PER_HOUR)
    assert_allclose(at_rest(left, TASK), north_error(east_of(expected)), rtol=0.2)  # 10 % of the Earth's rate, squared


def test_the_noise_of_the_detector_comes_out_as_the_spread_of_heading():
    unit = GRADES["middle"].draw(np.random.default_rng(1))
    random = replace(unit.at(STILL, simulated=False).gyros.random, bias_instability=0.0)
    still = nothing_left(unit)
    rng = np.random.default_rng(2)
    errors = [at_rest(still, TASK, random, rng) for _ in range(100)]
    # the power at the detector says it: sigma of the demodulated phase, by hand
    gyro = unit.gyro
    per_period = gyro.detector_noise / np.sqrt(16) / (0.5 * np.sin(3 * np.pi / 4))
    walk = per_period * np.sqrt(16 * gyro.loop.half_period) / gyro.coil.sagnac_scale_factor
    expected = walk / np.sqrt(TASK.duration) / LEVEL
    assert_allclose(np.std(errors), expected, rtol=3 / np.sqrt(2 * 100))  # 3 sigma of a deviation from 100


def test_a_tilt_of_the_accelerometers_comes_through_both_ways():
    still = nothing_left(GRADES["high"].draw(np.random.default_rng(1)))
    tilt = 0.05 * DEG
    # towards the east of the hull's attitude: all that a tilt about north can do is to take east for up
    bias = dcm_from_heading_pitch_roll(0.7, 0.0, 0.0).T @ np.array([9.82 * tilt, 0.0, 0.0])
    left = replace(still, accelerometer_bias=bias)
    known = Knowledge(bias=0.01 * DEG_PER_HOUR, scale_factor=1e-6)
    rest, mount = at_rest(left, TASK), on_mount(left, TASK, 1e-3 * DEG_PER_SQRT_HOUR, known)
    assert_allclose(abs(rest), np.tan(LATITUDE) * tilt, rtol=5e-3)  # second order, and 9.82 for the gravity there
    assert_allclose(mount, rest, rtol=0.03)  # the filter weighs its prior of the tilt, 2 mrad, against the aid


def test_asymmetry_is_heading_where_the_mount_rocks_and_nothing_where_it_keeps_its_speed():
    from fogkit.instrument.study import TASKS

    still = nothing_left(GRADES["high"].draw(np.random.default_rng(1)))
    known = Knowledge(bias=1 * DEG_PER_HOUR, scale_factor=1e-5)
    size = 10 * PPM
    answers = {
        name: np.array(
            [on_mount(replace(still, asymmetry=size * e), task, 1e-3 * DEG_PER_SQRT_HOUR, known) for e in np.eye(3)]
        )
        for name, task in TASKS.items()
    }
    # the book's law for three gyros with independent asymmetries and a mean direction zero
    swing, period = TASKS["rocking"].law.amplitude, 60.0
    law = size / (2 * np.sqrt(3)) * 4 / period * abs(np.sin(swing)) / LEVEL
    assert_allclose(np.linalg.norm(answers["rocking"]), law, rtol=0.05)  # first 10 s: tilts are being found meanwhile
    assert np.linalg.norm(answers["reversal"]) < 0.1 * law


def nothing_left(unit):
    """Errors of a perfect calibration."""
    silent = replace(unit, unit=MeasurementUnit(), thermal=CoilBias())
    found = calibrate("none", MeasurementUnit(), Stand(name="ideal"), LATITUDE, np.random.default_rng(0))
    return errors_left(silent, found, STILL, replace(STILL, powered=5 * MINUTE))
