"""Delays, remedies and the accuracy of gyro biases: closed forms against simulations that know nothing of them."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.earth import earth_rate_n, radius_meridian
from fogkit.reproduction.klimkovich import bias_accuracy, gyro_bias_test, gyro_delays, paper, remedies
from fogkit.reproduction.klimkovich.estimates import LATITUDE
from fogkit.rotation import dcm_from_rotvec
from fogkit.stand.rough_table import RoughTable
from fogkit.stand.turn_tests import nine_tests
from fogkit.units import ARCSEC, DEG

DELAY = gyro_delays.DELAY
EARTH = earth_rate_n(LATITUDE)
# A ramp of 0.5 s spans a quarter turn, in which the attitude is not that of the dwell; the rate of the plateau is not
# the mean one; a quarter turn is left over whole turns. Each is a few per cent of the effect.
RAMPS = 0.06


# Delays


def test_only_a_wobble_twice_in_a_turn_grows_and_by_symbols_as_the_closed_form_says():
    level, upright = gyro_delays.by_symbols(2)
    assert (level - gyro_delays.in_closed_form()).expand() == 0 and upright == 0
    for order in (1, 3, 4):
        assert gyro_delays.by_symbols(order) == (0, 0)


@pytest.mark.parametrize("sense", [1, -1])
def test_wobble_and_unequal_delays_turn_the_attitude_alike_in_both_senses(sense):
    motion = gyro_delays.wobbling(sense=sense)
    expected = gyro_delays.by_wobble(*[gyro_delays.WOBBLE] * 2, motion.rate, motion.angle, DELAY)
    east, north, up = gyro_delays.simulated(motion, (0.0, DELAY, 0.0))
    assert_allclose(north, expected, rtol=RAMPS)
    assert abs(east) < 0.01 * ARCSEC and abs(up) < 0.05 * ARCSEC


def test_it_grows_with_the_turn_and_its_rate():
    tests = nine_tests(turns=10), nine_tests(turn_duration=29.5)
    found = [gyro_delays.simulated(gyro_delays.wobbling(test=t[0]), (0.0, DELAY, 0.0))[1] for t in tests]
    usual = gyro_delays.simulated(gyro_delays.wobbling(), (0.0, DELAY, 0.0))[1]
    # 10.25 turns for 5.25 in the same time; half the rate
    assert_allclose(np.array(found) / usual, [(10.25 / 5.25) ** 2, 0.5], rtol=RAMPS)


def test_a_delay_of_all_gyros_does_nothing():
    motion = gyro_delays.wobbling()
    east, north, up = gyro_delays.simulated(motion, (DELAY,) * 3)
    assert max(abs(north), abs(up)) < 1e-3 * ARCSEC
    # The attitude is late in the turn, so gravity makes a velocity, and this turns the level by way over radius.
    turn, dwell = motion.test.turn_duration, motion.test.dwell_after
    way = motion.gravity * motion.rate * DELAY * turn * (turn / 2 + dwell)
    assert_allclose(east, way / float(radius_meridian(LATITUDE)), rtol=RAMPS)


def test_inclined_axis():
    table = RoughTable(latitude=LATITUDE, axis_error=0.2 * DEG)
    delay = np.array([0.0, DELAY, -2 * DELAY])
    for motion in table.motions(nine_tests()[:2], np.random.default_rng(3)):
        mean = motion.rate * motion.ramp * (0.5 - 181 / 462)  # angle in a ramp, weighted with the acceleration
        ends = [motion.C_case_n @ dcm_from_rotvec(motion.axis * angle) for angle in (mean, motion.angle - mean)]
        expected = gyro_delays.by_inclined_axis(*ends, motion.rate * motion.axis, delay)
        expected += gyro_delays.by_earth_rate(ends[0] @ motion.axis, motion.angle, EARTH, -DELAY / 2)
        size = gyro_delays.by_inclined_axis(np.zeros((3, 3)), np.eye(3), motion.rate * motion.axis, delay)
        found = gyro_delays.simulated(motion, delay)
        # what the angles in a ramp differ from their mean, squared
        assert_allclose(found, expected, rtol=0, atol=0.02 * np.linalg.norm(size))


def test_earth_rate_and_a_late_clock():
    (motion,) = RoughTable(latitude=LATITUDE).motions(nine_tests()[:1])
    expected = gyro_delays.by_earth_rate(motion.axis, motion.angle, EARTH, -DELAY)
    # About the axis: twice in a turn, which leaves no more than the delay times the Earth rate times a radian or so.
    assert_allclose(gyro_delays.simulated(motion, (DELAY, 0, 0))[1:], expected[1:], rtol=0.01)


# Remedies


def test_the_staying_table_goes_on_from_where_it_stopped():
    motions = remedies.StayingTrial(roughness=3.0).motions
    for i in range(9):
        gap = np.abs(motions[i].C_b_n(0.0) - motions[i - 1].C_b_n(motions[i - 1].duration)).max()
        assert gap < 1e-9 if i % 3 else gap > 1e-2  # the sag depends on the attitude: a fixed point, eight steps


def test_a_carried_heading_serves_only_where_the_unit_stays():
    errors = remedies.starts()["gyro_angle_arcsec"]
    assert errors["stays", "carried"] < 0.05 < 0.5 < errors["returns", "carried"]
    assert errors["stays", "levelled"] > 0.5
    assert max(errors["returns", "true"], errors["stays", "true"]) < 1e-3  # table errors alone


def test_scale_factors_of_all_dwells_do_not_feel_the_tilt_twice():
    rough, rougher = (remedies.scale_factors(roughness) for roughness in (1.0, 3.0))
    assert_allclose(rougher["pairs"] / rough["pairs"], 9, rtol=0.2)  # square of the tilt
    assert_allclose(rougher["all"] / rough["all"], 3, rtol=0.2)
    assert rough["all"] < 1 < rough["pairs"]


def test_remedies_of_delays():
    errors = remedies.delays((1,)).loc[1]
    assert_allclose(errors["half as fast"] / errors["nine tests"], 0.5, rtol=0.1)
    assert errors["forth and back"] < 0.7 * errors["each twice"]
    estimated, found = remedies.delays_estimated()
    assert estimated < 0.01 * errors["nine tests"]
    late = np.array(remedies.GYRO_DELAYS)
    relative = [found.states[f"delay_gyro_{axis}"] for axis in "yz"]
    assert_allclose(relative, late[1:] - late[0], rtol=0, atol=1e-6)  # second order in the delay, at 10 ms steps


def test_biases_in_turns():
    levelled, model = (remedies.bias_rounds(start, rounds=1) for start in ("levelled", "model"))
    assert levelled["gyro_angle_arcsec"][1] < 0.02 * levelled["gyro_angle_arcsec"][0]
    # A tilted start makes the vertical bias worse than it was, by (31).
    assert model["gyro_bias"][1] > 2 * paper.GYRO_BIAS_LEFT
    rates = remedies.bias_rounds("model", "rates", rounds=1)
    assert rates["gyro_bias"][1] < 1e-3 * paper.GYRO_BIAS_LEFT


@pytest.mark.slow
def test_all_states_at_once():
    # the headings of the starts are hardly seen: a prior of 1 deg holds them, and part of their effect, back
    for prior, share in (({}, 0.5), ({"start_up": 1.0}, 0.05)):
        found = remedies.everything(noisy=False, prior=prior)
        before, after = (found.trial.errors(c) for c in (found.fifteen, found.states.compensation))
        for quantity in ("gyro_angle_arcsec", "accelerometer_scale_ppm", "accelerometer_bias_um_s2"):
            assert after[quantity] < share * before[quantity]


# Gyro biases and table 2


def test_factors_against_least_squares_on_simulated_walks():
    rng = np.random.default_rng(7)
    count, runs = 400, 4000
    t = (np.arange(count) + 1) / count
    angle = np.cumsum(rng.standard_normal((count, runs)), axis=0) / np.sqrt(count)  # N = 1, T = 1
    velocity = np.cumsum(angle, axis=0) / count
    found = {
        "bend, angle random walk": 2 * np.polyfit(t, velocity, 2)[0],
        "bend, velocity random walk": 2 * np.polyfit(t, angle, 2)[0],
        "slope, angle random walk": np.polyfit(t, angle, 1)[0],
    }
    # 4 sigma of a variance from 4000 runs, 0.09, and 1/count of sums for integrals
    for name, factor in bias_accuracy.factors().items():
        assert_allclose(found[name].var(), float(factor), rtol=0.1, err_msg=name)


def test_scatter_of_biases():
    runs, dwell = 60, 60.0
    predicted = bias_accuracy.deviations(dwell)
    rms = np.sqrt((bias_accuracy.scatter(dwell, runs) ** 2).mean(axis=0))
    tolerance = 3 / np.sqrt(2 * runs)  # 3 sigma of an rms of so many
    assert_allclose(rms, [predicted["level"]] * 2 + [predicted["vertical"]], rtol=tolerance)
    rates = np.sqrt((bias_accuracy.scatter(dwell, runs, method="rates") ** 2).mean(axis=0))
    assert_allclose(rates, [predicted["mean rate"]] * 3, rtol=tolerance)


def test_tilt_in_the_vertical_bias():
    for axis, tilt in ((0, (1e-3, 0.0)), (1, (0.0, 1e-3))):
        found = gyro_bias_test.effect_of_start(axis)[2]
        # second order: the Earth turns the tilt by 0.01 rad in a dwell, the velocity turns the level
        assert_allclose(found, bias_accuracy.yaw_rate_of_tilt(tilt), rtol=0.06)


def test_harmonics_of_a_known_series():
    azimuths = list(paper.TABLE_2)
    rng = np.random.default_rng(8)
    p_values = []
    for _ in range(300):
        noise = rng.standard_normal(8)
        p_values.append(bias_accuracy.harmonics(dict(zip(azimuths, noise, strict=True))).p_value)
    assert abs(np.mean(np.array(p_values) < 0.2) - 0.2) < 4 * np.sqrt(0.2 * 0.8 / 300)
    round_once = {a: 1 + 2 * np.cos(a * DEG) - 3 * np.sin(a * DEG) for a in azimuths}
    fit = bias_accuracy.harmonics(round_once)
    assert_allclose([fit.mean, fit.cosine, fit.sine], [1, 2, -3], rtol=1e-12)


def test_table_2_from_its_own_walk():
    walk, low, high = bias_accuracy.walk_of_table_2()
    assert low < walk < high
    errors = np.array([bias_accuracy.table_2(walk, seed=seed)["difference"] for seed in range(10)])
    found = np.sqrt((errors**2).sum() / (10 * 7))
    printed = np.array(list(paper.TABLE_2.values()))
    assert_allclose(found, printed.std(ddof=1), rtol=3 / np.sqrt(2 * 70))  # 3 sigma
    # what stays in space is taken off with the mean; what turns with the unit is not
    bias = 10 * walk / np.sqrt(paper.GYROCOMPASSING_TIME)
    fixed, turning = (bias_accuracy.table_2(walk, **{name: (bias, 0, 0)}) for name in ("bias_n", "bias_b"))
    assert bias_accuracy.harmonics(turning["error"]).amplitude > 5 * fixed["difference"].std()
    assert_allclose(abs(fixed["error"].mean()), bias / EARTH[1] / DEG, rtol=0.1)
