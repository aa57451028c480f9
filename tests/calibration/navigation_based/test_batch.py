"""Batch estimate against what was planted in a simulated unit, and against the fifteen parameters."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.calibration.navigation_based import Compensation, batch, calibrate, differences
from fogkit.calibration.uncertainty import plan_covariance
from fogkit.calibration.velocity_noise import SensorNoise
from fogkit.estimation.consistency import chi_square_interval, nees
from fogkit.imu.size_effect import SizeEffect
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors
from fogkit.noise import RandomErrors
from fogkit.rotation import rotvec_from_dcm
from fogkit.stand.rough_table import RoughTable
from fogkit.stand.turn_recordings import record
from fogkit.stand.turn_tests import nine_tests
from fogkit.units import ARCSEC, DEG, DEG_PER_HOUR, DEG_PER_SQRT_HOUR, MICRO_G, MILLI_G, PPM

LATITUDE = 53.9 * DEG
NOISE = SensorNoise(
    gyros=RandomErrors(angle_random_walk=0.002 * DEG_PER_SQRT_HOUR),
    accelerometers=RandomErrors(angle_random_walk=10 * MICRO_G),
)
PLAN = nine_tests(1, dwell=4.0, turn_duration=5.0)
CENTRES = np.array([[0.0, 0.0, 0.0], [0.02, -0.03, 0.01], [-0.015, 0.025, 0.03]])
GYRO_DELAYS = (0.0, 1e-4, -2e-4)
ACCELEROMETER_DELAYS = (5e-4, 7e-4, 3e-4)
PLANTED = dict(zip(batch.SIZES, CENTRES[1:].ravel(), strict=True)) | dict(
    zip(batch.DELAYS, GYRO_DELAYS[1:] + ACCELEROMETER_DELAYS, strict=True)
)


def sensors(rng, bias, delay, errors):
    matrix = np.eye(3) + 3e-4 * rng.standard_normal((3, 3))
    return Sensors(triad=LinearTriad(bias=bias * rng.standard_normal(3), matrix=matrix), delay=delay, random=errors)


@pytest.fixture(scope="module")
def stand():
    """A unit with everything, without noise, and how a rough table turns it."""
    rng = np.random.default_rng(31)
    none = RandomErrors()
    unit = MeasurementUnit(
        gyros=sensors(rng, 1 * DEG_PER_HOUR, GYRO_DELAYS, none),
        accelerometers=sensors(rng, 1 * MILLI_G, ACCELEROMETER_DELAYS, none),
        size_effect=SizeEffect.one_point(CENTRES),
    )
    return unit, RoughTable.typical(LATITUDE, absorber=None).motions(PLAN, rng)


@pytest.fixture(scope="module")
def noisy(stand):
    unit, motions = stand
    unit = replace(
        unit,
        gyros=replace(unit.gyros, random=NOISE.gyros[0]),
        accelerometers=replace(unit.accelerometers, random=NOISE.accelerometers[0]),
    )
    return record(unit, motions, 100.0, rng=np.random.default_rng(32))


@pytest.fixture(scope="module")
def found(noisy):
    return batch.estimate(noisy, PLAN, LATITUDE, NOISE)


def covariance_of(solution, names):
    places = [solution.index(name) for name in names]
    return solution.covariance[np.ix_(places, places)]


def test_everything_planted_is_found_without_noise(stand):
    unit, motions = stand
    result = batch.estimate(record(unit, motions, 100.0), PLAN, LATITUDE, NOISE)
    errors = differences(result.compensation, Compensation.from_unit(unit))
    deviations = dict(zip(result.solution.names, result.solution.standard_deviation, strict=True))
    for name in batch.TRIADS:  # priors draw towards zero what they determine: heading and biases of gyros in part
        assert abs(errors[name]) < 0.25 * deviations[name], name
    # of 4 cm less than 1e-3, as ramps of 0.5 s are differenced by steps of 0.01 s; of delays some 1e-3
    for name, planted in PLANTED.items():
        assert abs(result.states[name] - planted) < (2e-5 if name in batch.SIZES else 1e-6), name
    for test, motion in zip(PLAN, motions, strict=True):
        turned = rotvec_from_dcm(motion.C_b_n(0.0) @ test.C_b_n.T)
        states = [result.states[f"{turn}[{test.label}]"] for turn in batch.TURNS]
        assert_allclose(states[:2], turned[:2], atol=1e-3)  # axes of the sensors, turned by their misalignments
    assert len(result.states) == 59
    assert result.solution.rank == 59


def test_errors_are_as_large_as_stated(stand, found):
    errors = differences(found.compensation, Compensation.from_unit(stand[0]))
    errors |= {name: found.states[name] - planted for name, planted in PLANTED.items()}
    names = (*batch.TRIADS, *batch.DELAYS)
    covariance = covariance_of(found.solution, names)
    low, high = chi_square_interval(len(names), probability=0.999)
    assert low < nees([errors[name] for name in names], covariance) < high
    free = found.solution.degrees_of_freedom
    assert free == 9 * 15 + 3 + 27 + 6 + 5 - 59  # observations and priors
    low, high = chi_square_interval(free, probability=0.999)
    assert low < found.solution.chi_square < high
    assert list(found.to_frame().index) == list(found.states)


def test_fifteen_parameters_take_what_is_left_out_for_their_own(stand, noisy, found):
    truth = Compensation.from_unit(stand[0])
    noise = plan_covariance(PLAN, 0.01, NOISE, scale_factors=True)
    paper = calibrate(noisy, PLAN, LATITUDE, scale_factor="all", noise=noise, iterations=6)
    wrong, right = differences(paper.compensation, truth), differences(found.compensation, truth)
    assert paper.solution.p_value < 1e-3  # chi-square says that something is missing
    stated = dict(zip(paper.solution.names, paper.solution.standard_deviation, strict=True))
    scale_factors = ("m_g_11", "m_g_22", "m_g_33")
    assert all(abs(wrong[name]) > 5 * stated[name] for name in scale_factors)
    deviations = dict(zip(found.solution.names, found.solution.standard_deviation, strict=True))
    assert all(abs(right[name]) < 4 * deviations[name] for name in batch.TRIADS)


def test_states_without_effect_may_stay_out(stand):
    unit, motions = stand
    plain = replace(
        unit,
        gyros=replace(unit.gyros, delay=(0, 0, 0)),
        accelerometers=replace(unit.accelerometers, delay=(0, 0, 0)),
        size_effect=SizeEffect(),
    )
    starts = np.stack([motion.C_b_n(0.0) for motion in motions])
    result = batch.estimate(
        record(plain, motions, 100.0), PLAN, LATITUDE, NOISE, initial_attitude=starts, groups=["start"]
    )
    assert len(result.states) == 48
    errors = differences(result.compensation, Compensation.from_unit(plain))
    assert abs(errors["m_g_11"]) < 0.3 * PPM
    assert abs(errors["m_g_12"]) < 0.3 * ARCSEC


def test_three_tests_leave_almost_everything_open(noisy, found):
    # about x alone: the chain closes, other axes turn by what the table is rough, starts are known to a degree
    few = batch.estimate(noisy[:3], PLAN[:3], LATITUDE, NOISE).solution
    whole = found.solution
    ratio = {
        name: few.standard_deviation[few.index(name)] / whole.standard_deviation[whole.index(name)]
        for name in batch.TRIADS
    }
    assert min(ratio.values()) >= 1
    assert min(ratio["m_g_12"], ratio["m_g_33"]) > 30


def test_common_part_of_what_is_relative_has_no_effect(stand):
    # all centres moved alike, all delays grown alike: the same states
    unit, motions = stand
    moved = replace(unit, size_effect=SizeEffect.one_point(CENTRES + np.array([0.01, -0.02, 0.015])))
    later = replace(
        unit,
        gyros=replace(unit.gyros, delay=tuple(np.add(GYRO_DELAYS, 2e-4))),
        accelerometers=replace(unit.accelerometers, delay=tuple(np.add(ACCELEROMETER_DELAYS, 2e-4))),
    )
    recordings = [record(one, motions[:1], 100.0)[0] for one in (unit, moved, later)]
    parts = batch.recordings_of(recordings, (PLAN[0],) * 3)
    names = batch.state_names(PLAN[:1])
    tests = [
        batch._Test.of(part, PLAN[0].C_b_n, Compensation.from_unit(unit), {"lat": LATITUDE, "alt": 0.0}, NOISE)
        for part in parts
    ]
    states = dict.fromkeys(batch._all_states(tests[0]), np.zeros(1)) | {
        name: np.array([PLANTED.get(name, 0.0)]) for name in names
    }
    first, *others = (test.observed(states)[0] for test in tests)
    deviation = np.sqrt(np.diagonal(tests[0].covariance))
    for other in others:
        assert (np.abs(other - first) < 0.1 * deviation).all()
    without = tests[0].observed(states | {"centre_y_z": np.zeros(1)})[0]
    assert (np.abs(without - first) > 3 * deviation).any()


def test_bad_input(noisy):
    with pytest.raises(ValueError, match="`prior` must be of states or groups of them, got 'lever'"):
        batch.estimate(noisy, PLAN, LATITUDE, NOISE, prior={"lever": 1.0})
    with pytest.raises(ValueError, match="`groups` must be one of"):
        batch.estimate(noisy, PLAN, LATITUDE, NOISE, groups=["delays"])
    with pytest.raises(RuntimeError, match="no convergence in 1 `iterations`"):
        batch.estimate(noisy, PLAN, LATITUDE, NOISE, iterations=1, groups=[])
    table = noisy[3].copy()
    table[["gyro_x", "gyro_y", "gyro_z"]] /= DEG
    with pytest.raises(ValueError, match=r"test 4\)` must turn by .* These look like in deg in place of rad"):
        batch.estimate([*noisy[:3], table, *noisy[4:]], PLAN, LATITUDE, NOISE)
    with pytest.raises(ValueError, match=r"test 4\)` must have \+x up in dwell 1, got .* It would fit test 6"):
        batch.estimate([*noisy[:3], noisy[5], noisy[4], noisy[3], *noisy[6:]], PLAN, LATITUDE, NOISE)
