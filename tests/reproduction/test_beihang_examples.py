"""What the laboratory chapters compute: covariances of means, closed forms, trials."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.calibration import multiposition
from fogkit.calibration.rate_sequence import installation_accuracy
from fogkit.noise.processes import RandomErrors
from fogkit.reproduction.beihang import examples, laboratory
from fogkit.reproduction.beihang.laboratory import PLACE, calibrate_both, example_unit, noise_free
from fogkit.stand import placements
from fogkit.stand.placements import Placement, Schedule
from fogkit.units import ARCMIN, DEG, DEG_PER_HOUR, DEG_PER_SECOND, MINUTE, PPM

NOISE = RandomErrors(angle_random_walk=2.0, bias_instability=1.5)


@pytest.fixture
def rng():
    return np.random.default_rng(24)


@pytest.fixture(scope="module")
def plan():
    return placements.twenty_four_points() + placements.full_turns()


def schedule_of(*durations: float) -> Schedule:
    return Schedule([Placement(label=str(i), axes="ENU", duration=d) for i, d in enumerate(durations)])


def test_printed_points_are_those_of_the_schedule():
    letters = {p.label: p.axes for p in placements.twenty_four_points().placements}
    assert {label: letters[label] for label in examples.PRINTED_POINTS} == examples.PRINTED_POINTS


def test_means_one_after_the_other_are_followed_through_the_recording():
    C = examples.means_covariance(schedule_of(10.0, 10.0), NOISE, 0.1)
    difference = np.array([1, -1])
    assert difference @ C @ difference / 2 == pytest.approx(NOISE.allan_variance(10.0), rel=1e-12)
    alone = examples.each_for_itself(schedule_of(10.0, 10.0), NOISE)
    assert_allclose(alone, np.diag(np.full(2, NOISE.allan_variance(10.0))))


def test_closed_forms_are_the_fit(plan):
    unit = example_unit(mechanical=True, random=False)
    observed = noise_free(unit, plan, examples.ROOM, PLACE)
    noisy = replace(observed, readings=observed.readings + np.random.default_rng(1).normal(size=(30, 6)))
    positions = multiposition.average_positions(noisy, plan)
    turned = noisy.combine(np.eye(30)[24:], plan.labels[24:])
    accelerometers, gyros = calibrate_both(noisy, plan, mechanical=True)
    zero, matrix = examples.closed_accelerometers(positions, PLACE.gravity)
    assert_allclose(zero, accelerometers.triad.bias, rtol=1e-10)
    assert_allclose(matrix, accelerometers.triad.matrix, rtol=1e-9, atol=1e-9)
    gyro_matrix = examples.closed_equivalents(turned, plan.select(range(24, 30)))
    assert_allclose(gyro_matrix, gyros.triad.matrix, rtol=1e-10, atol=1e-6)
    zero, sensitivity = examples.closed_gyros(positions, gyro_matrix, PLACE)
    assert_allclose(zero, gyros.triad.bias, rtol=1e-9, atol=1e-9)
    assert_allclose(sensitivity, gyros.triad.acceleration_sensitivity, rtol=1e-8, atol=1e-9)


def test_closed_form_errs_by_bias_and_vertical_rate_over_the_difference_in_time():
    unit = example_unit(random=False)
    triad, duration, shorter = unit.gyros.triad, 36.0, 0.9
    closed, fit = examples.closed_form_of_unequal_turns(shorter)
    offset = triad.bias[0] + triad.matrix[0][0] * PLACE.omega_ie_n[2]
    assert closed == pytest.approx(offset * duration * (1 - shorter) / (4 * np.pi * triad.matrix[0][0]), rel=1e-3)
    assert abs(fit) < 1e-12
    assert examples.closed_form_of_unequal_turns(1.0) == pytest.approx((0, 0), abs=1e-12)


def test_predicted_deviations_hold_only_if_means_are_weighted_together(rng):
    runs = 16
    found = examples.trials(runs, rng)
    together, alone = found["together"], found["each for itself"]
    assert len(together.names) == 24 and together.names[12] == "gyro bias_x"
    assert together.degrees_of_freedom == (6, 15)
    # mean of chi-square over the runs, within four of its standard deviations
    for column, freedom in enumerate(together.degrees_of_freedom):
        assert together.chi_square[:, column].mean() == pytest.approx(freedom, abs=4 * np.sqrt(2 * freedom / runs))
    assert np.mean(together.normalised**2) == pytest.approx(1, abs=0.35)
    biases = [i for i, name in enumerate(alone.names) if name.startswith("accelerometer bias")]
    assert np.sqrt(np.mean(alone.normalised[:, biases] ** 2)) > 5


def test_beside_truth_is_in_field_units(plan):
    unit = example_unit(random=False)
    observed = examples.weighted(noise_free(unit, plan, PLACE, PLACE), plan, unit)
    accelerometers, gyros = calibrate_both(observed, plan)
    frame = examples.beside_truth("gyro", gyros, unit.gyros.triad)
    assert frame.truth["gyro bias x, deg/h"] == pytest.approx(0.8)
    assert frame.truth["gyro scale factor y, ppm"] == pytest.approx(-500)
    assert frame.truth["gyro misalignment xz, arcsec"] == pytest.approx(-180)
    assert_allclose(frame.estimate, frame.truth, atol=1e-4)
    frame = examples.beside_truth("accelerometer", accelerometers, unit.accelerometers.triad)
    assert frame.truth["accelerometer bias z, µg"] == pytest.approx(400)
    assert_allclose(frame.estimate, frame.truth, atol=1e-4)
    assert len(frame) == 12 and (frame.deviation > 0).all()


def test_a_repeated_heading_leaves_a_part_of_the_horizontal_rate():
    right, wrong = examples.repeated_heading()
    assert right < 1e-9 * DEG_PER_HOUR
    # a level axis that looked south where it should have looked west: north rate over 24 points
    assert wrong == pytest.approx(PLACE.omega_ie_n[1] / 24, rel=1e-2)


def test_rates_recorded_and_fitted_noise_free():
    unit = example_unit(random=False)
    true = unit.gyros.triad
    fit = examples.fit_from(PLACE)
    assert fit.scale_factor == pytest.approx(true.scale_factor[0], rel=1e-9)
    assert fit.intercept == pytest.approx(true.input_bias[0], abs=0.005 * DEG_PER_HOUR)
    fast = examples.fit_from(PLACE, rate_scale=1 + 20 * PPM)
    assert fast.scale_factor / fit.scale_factor - 1 == pytest.approx(20 * PPM, rel=1e-3)
    north = examples.fit_from(replace(PLACE, latitude=PLACE.latitude + DEG))
    vertical = replace(PLACE, latitude=PLACE.latitude + DEG).omega_ie_n[2] - PLACE.omega_ie_n[2]
    assert north.intercept - fit.intercept == pytest.approx(vertical, rel=1e-2)


def test_recorded_sequence_is_the_slides(rng):
    sequence, observed = examples.record_sequence(example_unit(), rng, dt=1.0)
    assert len(sequence) == 29 and list(observed.labels) == sequence.labels
    assert observed.covariance.shape == (6, 29, 29)
    assert observed.covariance[0, 0, 28] > 0  # the bias instability that all have in common


def test_information_is_quadratic_in_the_rate_on_an_exact_table():
    sizes, shares = examples.information_shares(0.0)
    assert_allclose(shares, sizes**2 / np.sum(sizes**2), rtol=1e-12, atol=1e-15)
    sizes, shares = examples.information_shares(5 * PPM)
    large = sizes > 20 * DEG_PER_SECOND
    assert np.ptp(shares[large]) < 0.02 * shares[-1]


def test_the_room_is_off_level_and_unoriented():
    assert abs(examples.ROOM.level_east) >= ARCMIN - 1e-12 and abs(examples.ROOM.azimuth_error) > 10 * DEG
    assert laboratory.PLACE.azimuth_error == 0


def test_150_is_the_best_rate_where_the_earth_is_left_out_and_200_where_it_is_counted():
    runs = laboratory.installation_runs()
    rates = np.array([run.rate for run in runs])
    counted, left_out = (np.array([getattr(run, name) for run in runs]) for name in ("spread", "without_earth"))
    assert_allclose(rates[np.argmin(left_out)], 150 * DEG_PER_SECOND)
    assert_allclose(rates[np.argmin(counted)], 200 * DEG_PER_SECOND)
    limits = [installation_accuracy(rate, 2 * MINUTE, laboratory.GYRO_NOISE, PLACE) for rate in rates]
    noise, earth = (np.array([getattr(limit, name) for limit in limits]) for name in ("noise", "earth"))
    # 48 angles each, 5 sigma; a random azimuth makes of the bound its root mean square
    assert_allclose(counted, noise, rtol=5 / np.sqrt(2 * 48))
    assert_allclose(left_out, np.hypot(noise, earth / np.sqrt(2)), rtol=5 / np.sqrt(2 * 48))
