"""Positions and turns: coefficients back to rounding, closed forms, statistics of many runs, another tool."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from imucal import FerrarisCalibration, FerrarisSignalRegions
from laboratories import (
    ACCEL_PULSES,
    ACCELEROMETERS,
    CROOKED,
    EXACT,
    GYRO_PULSES,
    GYROS,
    LABORATORY,
    NOISY,
    WHITE,
    aligned,
    measured,
    random_triad,
    scattered,
)
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from fogkit.calibration.multiposition import (
    LinearCalibration,
    average_positions,
    calibrate_accelerometers,
    calibrate_gyros,
    parameter_names,
    turn_differences,
)
from fogkit.calibration.rate_sequence import without_earth
from fogkit.constants import EARTH_RATE
from fogkit.estimation.consistency import chi_square_interval, nees, ratio_interval
from fogkit.imu.tables import ACCEL_COLUMNS, GYRO_COLUMNS
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors
from fogkit.stand.laboratory import Laboratory
from fogkit.stand.means import observations
from fogkit.stand.placements import Placement, Schedule, full_turns, six_positions, twenty_four_points
from fogkit.units import DEG

SEEDS = st.integers(0, 2**32 - 1)
POINTS = twenty_four_points(2.0)
TURNS = full_turns(36 * DEG)
PLAN = POINTS + TURNS
ROUNDING = 1e-11
"""Of a coefficient's scale. Readings are sums of some 100 samples, each right to 2e-16 of the largest, and the largest
reading, in a turn, is some 1e4 times what the Earth's rotation makes: 2e-12, with a margin for the solution."""


def averaged(schedule, observed):
    """What the slides calibrate gyros from: means of the positions, and differences of the turns."""
    return average_positions(observed, schedule).joined(turn_differences(observed, schedule))


def assert_recovered(found, true, input_scale):
    """Coefficients equal to rounding: bias and sensitivity on the scale of what the sensors read at rest."""
    size = np.abs(true.equivalents)
    assert_allclose(np.array(found.matrix) / size[:, None], np.array(true.matrix) / size[:, None], atol=ROUNDING)
    at_rest = size * input_scale + np.abs(true.bias)
    assert_allclose(np.array(found.bias) / at_rest, np.array(true.bias) / at_rest, atol=ROUNDING)


def test_all_24_coefficients():
    observed = measured(EXACT, PLAN)
    gyros = calibrate_gyros(averaged(PLAN, observed)).triad
    assert_recovered(gyros, GYROS, EARTH_RATE)
    assert_recovered(calibrate_accelerometers(average_positions(observed, PLAN)).triad, ACCELEROMETERS, 9.8)
    assert_array_equal(gyros.acceleration_sensitivity, np.zeros((3, 3)))


@settings(max_examples=15)
@given(seed=SEEDS, latitude=st.floats(-1.5, 1.5), azimuth=st.floats(-0.49, 0.49))
def test_any_unit_at_any_place_with_the_plate_turned_anyhow(seed, latitude, azimuth):
    rng = np.random.default_rng(seed)
    gyros, accelerometers = random_triad(rng, 4e5, 1e-6), random_triad(rng, 1e4, 0.1)
    unit = MeasurementUnit(gyros=Sensors(triad=gyros), accelerometers=Sensors(triad=accelerometers))
    believed = Laboratory(latitude=latitude)
    signs = np.sign(np.diagonal(np.array([*gyros.matrix, *accelerometers.matrix]).reshape(2, 3, 3), axis1=1, axis2=2))
    plate = replace(believed, azimuth_error=azimuth)
    recording = plate.record(unit, PLAN, rng, sample_rate=2.0)
    observed = observations(recording, PLAN, believed, equivalents=signs.ravel())
    assert_recovered(calibrate_gyros(averaged(PLAN, observed)).triad, gyros, EARTH_RATE)
    assert_recovered(calibrate_accelerometers(average_positions(observed, PLAN)).triad, accelerometers, 9.8)


@settings(max_examples=10)
@given(seed=SEEDS)
def test_mechanical_gyros_have_nine_more(seed):
    rng = np.random.default_rng(seed)
    gyros = random_triad(rng, 4e5, 1e-6, sensitivity=1e-6)
    unit = MeasurementUnit(gyros=Sensors(triad=gyros), accelerometers=EXACT.accelerometers)
    believed = replace(LABORATORY, latitude=rng.uniform(-1.5, 1.5))
    laboratory = replace(believed, azimuth_error=rng.uniform(-0.4, 0.4))
    observed = measured(unit, PLAN, laboratory, believed=believed, sample_rate=2.0)
    calibration = calibrate_gyros(averaged(PLAN, observed), acceleration_sensitivity=True)
    assert_recovered(calibration.triad, gyros, EARTH_RATE)
    found, true = (np.array(t.acceleration_sensitivity) * 9.8 for t in (calibration.triad, gyros))
    assert_allclose(found / gyros.equivalents[:, None], true / gyros.equivalents[:, None], atol=ROUNDING * 1e-5)
    names = [f"acceleration_sensitivity_{a}{b}" for a in "xyz" for b in "xyz"]
    for form in ("parameters", "slides", "standard"):
        assert [name for name in calibration.to_frame(form).index if name in names] == names


def test_positions_at_known_headings_tell_bias_matrix_and_sensitivity_of_mechanical_gyros():
    gyros = replace(GYROS, acceleration_sensitivity=0.1 * np.arange(9).reshape(3, 3))
    unit = MeasurementUnit(gyros=Sensors(triad=gyros))
    calibration = calibrate_gyros(measured(unit, POINTS), acceleration_sensitivity=True)
    assert_recovered(calibration.triad, gyros, EARTH_RATE)
    with pytest.raises(ValueError, match=r"the plan does not determine .*`acceleration_sensitivity_xx`"):
        calibrate_gyros(average_positions(measured(unit, POINTS), POINTS), acceleration_sensitivity=True)


@settings(max_examples=20)
@given(seed=SEEDS)
def test_any_positions_of_any_durations(seed):
    rng = np.random.default_rng(seed)
    # five suffice for the accelerometers if they are these or others of full rank; more never spoil it
    order = rng.permutation(24)[: rng.integers(5, 25)]
    schedule = Schedule([replace(POINTS.placements[i], duration=rng.uniform(1.0, 4.0)) for i in order])
    observed = measured(EXACT, schedule, CROOKED, sample_rate=5.0)
    _, force = CROOKED.mean_inputs(schedule.placements[0])
    design = np.column_stack([np.ones(len(order)), observed.f_ib_b / np.linalg.norm(force)])
    condition = np.linalg.cond(design)
    if condition < 100:  # the tilts of the laboratory, 1e-3, alone separate the rest
        assert_recovered(calibrate_accelerometers(observed).triad, ACCELEROMETERS, 9.8)


def test_durations_that_differ_leave_the_averages_exact():
    rng = np.random.default_rng(6)
    points = [replace(p, duration=rng.uniform(1.0, 4.0)) for p in POINTS.placements]
    # opposite turns at other rates: the bias stays in the difference, and the fit knows how much
    turns = [
        replace(p, duration=p.duration * s, rate=p.rate / s) for p in TURNS.placements for s in [rng.uniform(1, 2)]
    ]
    schedule = Schedule(points + turns)
    laboratory = replace(LABORATORY, azimuth_error=0.4)
    observed = measured(EXACT, schedule, laboratory, believed=LABORATORY)
    combined = averaged(schedule, observed)
    assert np.abs(combined.bias_share[6:]).min() > 1e-3
    assert_recovered(calibrate_gyros(combined).triad, GYROS, EARTH_RATE)
    assert_recovered(calibrate_accelerometers(average_positions(observed, schedule)).triad, ACCELEROMETERS, 9.8)


def test_what_a_tilted_plate_does_to_the_accelerometers():
    tilted = replace(LABORATORY, level_east=0.03, level_north=0.04)
    observed = measured(EXACT, POINTS, tilted, believed=LABORATORY)
    found = calibrate_accelerometers(average_positions(observed, POINTS)).triad
    # the level parts cancel over four headings; upright is left cos(0.05): second order, the same for all
    assert_allclose(found.matrix, np.cos(0.05) * np.array(ACCELEROMETERS.matrix), atol=ROUNDING * ACCEL_PULSES)
    assert_allclose(found.bias, ACCELEROMETERS.bias, atol=ROUNDING * ACCEL_PULSES * 9.8)


def test_what_a_tilted_plate_does_to_the_gyros():
    tilt = 0.05
    observed = measured(EXACT, PLAN, replace(LABORATORY, level_east=tilt), believed=LABORATORY)
    found = calibrate_gyros(averaged(PLAN, observed)).triad
    # the Earth's upright part changes by EARTH_RATE * tilt, with opposite signs up and down: none of it in the bias
    assert_allclose(found.bias, GYROS.bias, atol=ROUNDING * GYRO_PULSES * EARTH_RATE)
    # in the matrix it weighs as the square of the Earth's rotation to the turns': (7e-5 / 0.6)^2 * 2 * tilt = 1.4e-9
    assert_allclose(np.array(found.matrix) / GYRO_PULSES, np.array(GYROS.matrix) / GYRO_PULSES, atol=1.4e-9)


def test_a_unit_mounted_askew_is_calibrated_in_the_axes_of_the_cube():
    askew = replace(LABORATORY, mounting=(0.01, -0.02, 0.03))
    observed = measured(EXACT, PLAN, askew, believed=LABORATORY)
    # by another implementation: cube from unit is the rotation, unit from cube its inverse
    from_cube = Rotation.from_rotvec(askew.mounting).inv().as_matrix()
    found = calibrate_gyros(averaged(PLAN, observed)).triad
    assert_recovered(found, GYROS.turned(from_cube), EARTH_RATE)
    found = calibrate_accelerometers(average_positions(observed, PLAN)).triad
    assert_recovered(found, ACCELEROMETERS.turned(from_cube), 9.8)


def test_tilts_of_the_cubes_faces_do_not_cancel():
    faces = np.zeros((6, 3))
    faces[0] = [0, 0, 1e-3]  # x up leans: y takes a thousandth of gravity at all four headings
    observed = measured(EXACT, POINTS, replace(LABORATORY, faces=faces), believed=LABORATORY)
    error = (
        calibrate_accelerometers(average_positions(observed, POINTS)).triad.misalignment - ACCELEROMETERS.misalignment
    )
    # half of it, as x down has none; its square and its product with misalignments of 2e-3 are left
    assert_allclose(error[1, 0], -0.5e-3, atol=3e-6)


# the slides' closed forms, typed from their text: F holds one row a position, x up, x down, y up, ...


def slides_accelerometers(F, gravity):
    zero = F.mean(axis=0)
    components = (F[0::2] - F[1::2]).T / (2 * gravity)
    return zero, components, np.sqrt((components**2).sum(axis=1))


def slides_gyros(F, plus, minus, latitude, gravity):
    components = (plus - minus).T / (2 * 360 * 3600)  # pulses per arcsec
    per_rad = components * 360 * 3600 / (2 * np.pi)
    upright = EARTH_RATE * np.sin(latitude)
    by_gravity = ((F[0::2] - F[1::2]).T / 2 - per_rad * upright) / gravity
    return F.mean(axis=0), components, by_gravity


def test_closed_forms_of_the_slides_on_noisy_readings():
    observed = measured(NOISY, PLAN, random=WHITE, seed=3)
    F = average_positions(observed, PLAN)
    turn_time = TURNS.placements[0].duration
    plus, minus = observed.readings[24::2, :3] * turn_time, observed.readings[25::2, :3] * turn_time
    zero, components, equivalents = slides_accelerometers(F.readings[:, 3:], LABORATORY.gravity)
    calibration = calibrate_accelerometers(F)
    # equal weights and inputs at right angles: the same numbers, but for the rounding of the solution
    assert_allclose(calibration.triad.bias, zero, rtol=1e-13, atol=1e-12 * ACCEL_PULSES)
    assert_allclose(calibration.triad.matrix, components, atol=1e-13 * ACCEL_PULSES)
    assert_allclose(calibration.triad.equivalents, equivalents, rtol=1e-13)

    zero, per_arcsec, by_gravity = slides_gyros(F.readings[:, :3], plus, minus, LABORATORY.latitude, LABORATORY.gravity)
    observed_turns = averaged(PLAN, observed)
    calibration = calibrate_gyros(observed_turns, acceleration_sensitivity=True)
    pulses = np.array(calibration.triad.matrix) * DEG / 3600
    assert_allclose(pulses, per_arcsec, atol=1e-13 * 2)  # two pulses per arcsec
    assert_allclose(calibration.triad.acceleration_sensitivity, by_gravity, atol=1e-13 * GYRO_PULSES * EARTH_RATE)
    assert_allclose(calibration.triad.bias, zero, atol=1e-13 * GYRO_PULSES * 0.6)  # beside readings of the turns
    # without sensitivity the positions say a little of the matrix too; not so the biases
    optical = calibrate_gyros(observed_turns).triad
    assert_allclose(optical.bias, zero, atol=1e-13 * GYRO_PULSES * 0.6)
    blind = calibrate_gyros(averaged(PLAN, without_earth(observed, PLAN))).triad
    assert_allclose(np.array(blind.matrix) * DEG / 3600, per_arcsec, atol=1e-13 * 2)


def test_averages_and_differences_by_hand():
    observed = measured(NOISY, PLAN, random=WHITE)
    F = average_positions(observed, PLAN)
    assert F.labels == ("x up", "x down", "y up", "y down", "z up", "z down")
    assert_allclose(F.readings, observed.readings[:24].reshape(6, 4, 6).mean(axis=1), rtol=1e-12)
    assert_allclose(F.covariance[0, 2, 2], observed.covariance[0, 0, 0] / 4, rtol=1e-12)
    upright = EARTH_RATE * np.sin(LABORATORY.latitude)
    signs = np.kron(np.eye(3), [[1], [-1]])
    assert_allclose(F.omega_ib_b, upright * signs, atol=1e-19)  # the Earth's level part is gone
    assert_allclose(F.f_ib_b, LABORATORY.gravity * signs, atol=1e-14)
    D = turn_differences(observed, PLAN)
    assert D.labels == ("x +360", "y +360", "z +360")
    assert_allclose(D.omega_ib_b, 36 * DEG * np.eye(3), atol=1e-19)
    assert_array_equal(D.bias_share, np.zeros(3))
    assert_allclose(D.covariance[0], observed.covariance[0, 24, 24] / 2 * np.eye(3), rtol=1e-12)


def test_several_turns_are_paired_in_their_order():
    turns = Schedule(
        [
            Placement(label=name, axes="UEN", duration=10.0, rate=r)
            for name, r in zip("abcd", [0.2, 0.2, -0.2, -0.2], strict=True)
        ]
    )
    D = turn_differences(measured(EXACT, turns), turns)
    assert D.labels == ("a", "b")


# statistics: 300 runs, intervals that a true prediction leaves once in a thousand tests
RUNS, SURE = 300, 0.999


def runs_of(observed, calibrate, seed):
    rng = np.random.default_rng(seed)
    return [calibrate(scattered(observed, rng)) for _ in range(RUNS)]


def truth_of(triad):
    return np.column_stack([triad.bias, triad.matrix])


CASES = {
    "accelerometers": (calibrate_accelerometers, ACCELEROMETERS, six_positions(2.0), lambda s, o: o),
    "accelerometers, 24 points": (
        calibrate_accelerometers,
        ACCELEROMETERS,
        POINTS,
        lambda s, o: average_positions(o, s),
    ),
    "gyros": (calibrate_gyros, GYROS, PLAN, averaged),
    "gyros, unequal": (calibrate_gyros, GYROS, six_positions(7.0) + TURNS, lambda s, o: o),
}


@pytest.fixture(scope="module", params=CASES)
def campaign(request):
    calibrate, true, schedule, prepare = CASES[request.param]
    observed = measured(EXACT, schedule, random=WHITE)
    return true, runs_of(prepare(schedule, observed), calibrate, seed=11)


def test_errors_and_residuals_are_as_large_as_predicted(campaign):
    true, runs = campaign
    for j in range(3):
        estimates = np.array([run.solutions[j].estimate for run in runs])
        values = nees(estimates - truth_of(true)[j], runs[0].solutions[j].covariance)
        low, high = chi_square_interval(4, RUNS, SURE)
        assert low < values.mean() < high
    free = runs[0].degrees_of_freedom
    assert free == 3 * (len(runs[0].solutions[0].residuals) - 4)
    low, high = chi_square_interval(free, RUNS, SURE)
    assert low < np.mean([run.chi_square for run in runs]) < high


def test_deviations_of_all_forms_are_those_of_many_runs(campaign):
    # the errors are 1e-5 of the numbers or less, so their squares, which the deviations leave out, are too
    _, runs = campaign
    low, high = ratio_interval(RUNS, 1 - (1 - SURE) / 10)
    for name in ("bias", "matrix", "equivalents", "cosines", "misalignment", "input_bias"):
        observed = np.std([np.array(getattr(run.triad, name)) for run in runs], axis=0, ddof=1)
        predicted = getattr(runs[0], f"{name}_deviation")
        if name == "misalignment":
            assert_array_equal(np.diagonal(predicted), np.zeros(3))
            observed, predicted = (part[~np.eye(3, dtype=bool)] for part in (observed, predicted))
        if name == "cosines":  # along an axis they change in second order only; the first order is a product of angles
            observed, predicted = (part[~np.eye(3, dtype=bool)] for part in (observed, predicted))
        assert (predicted / observed > low).all(), name
        assert (predicted / observed < high).all(), name


def test_deviations_where_all_parts_count():
    # sensors far off their axes, biases as large as gravity, and a plan that knows one direction 8 times as well
    matrix = ACCEL_PULSES * np.array([[1, 0.3, -0.2], [0.3, 1, 0.2], [0.1, -0.3, 1]])
    triad = LinearTriad(bias=ACCEL_PULSES * np.array([30, -40, 50]), matrix=matrix)
    unit = MeasurementUnit(accelerometers=Sensors(triad=triad))
    durations = [64.0, 64.0, 1.0, 1.0, 2.0, 2.0]
    schedule = Schedule(
        [replace(p, duration=time) for p, time in zip(six_positions().placements, durations, strict=True)]
    )
    runs = runs_of(measured(unit, schedule, random=WHITE), calibrate_accelerometers, seed=12)
    low, high = ratio_interval(RUNS, 1 - (1 - SURE) / 15)
    for name in ("cosines", "equivalents", "input_bias"):
        observed = np.std([getattr(run.triad, name) for run in runs], axis=0, ddof=1)
        ratio = getattr(runs[0], f"{name}_deviation") / observed
        assert (ratio > low).all(), name
        assert (ratio < high).all(), name


def test_recordings_with_scatter_for_covariance_are_consistent():
    # all the way from samples: 40 runs of 12 means of 40 to 100 samples, turns on a crooked plate among them
    schedule = six_positions(4.0) + TURNS
    chi_squares, free = [], 0
    for seed in range(40):
        observed = measured(NOISY, schedule, CROOKED, seed=seed)
        fits = calibrate_gyros(observed), calibrate_accelerometers(observed)
        chi_squares.append([fit.chi_square for fit in fits])
        free = fits[0].degrees_of_freedom
    # a variance from n samples makes chi-square larger by about 1 + 2 / n, here up to 5 %, which the bound takes in
    low, high = chi_square_interval(free, 40, SURE)
    assert (low < np.mean(chi_squares, axis=0)).all()
    assert (np.mean(chi_squares, axis=0) < 1.05 * high).all()


# imucal 2.6: matrix K_a @ R_a, bias from each sensor's own axis up and down


def ferraris(recording, gravity):
    parts = {label: piece for label, piece in recording.groupby("position", observed=True)}
    holds = ["x_p", "x_a", "y_p", "y_a", "z_p", "z_a"]
    regions = {}
    for kind, columns in (("acc", ACCEL_COLUMNS), ("gyr", GYRO_COLUMNS)):
        for hold, label in zip(holds, "123456", strict=True):
            regions[f"{kind}_{hold}"] = parts[label][list(columns)].to_numpy()
        for axis in "xyz":
            regions[f"{kind}_{axis}_rot"] = parts[f"{axis} +360"][list(columns)].to_numpy()
    tool = FerrarisCalibration(grav=gravity, expected_angle=2 * np.pi)  # counter-clockwise, and in rad
    return tool.compute(FerrarisSignalRegions(**regions), 10.0, from_acc_unit="a.u.", from_gyr_unit="a.u.")


SHORT = six_positions(3.0) + TURNS


def test_imucal_finds_the_same_without_noise():
    recording = LABORATORY.record(EXACT, SHORT, np.random.default_rng(0))
    theirs = ferraris(recording, LABORATORY.gravity)
    ours = calibrate_accelerometers(measured(EXACT, six_positions(3.0))).triad
    assert_allclose(ours.matrix, theirs.K_a @ theirs.R_a, atol=ROUNDING * ACCEL_PULSES)
    assert_allclose(ours.bias, theirs.b_a, atol=ROUNDING * ACCEL_PULSES * 9.8)


def test_imucal_finds_the_same_matrix_in_noise_and_a_bias_from_two_positions():
    schedule = six_positions(3.0)
    recording = LABORATORY.record(NOISY, SHORT, np.random.default_rng(1))
    theirs = ferraris(recording, LABORATORY.gravity)
    observed = measured(NOISY, SHORT, random=WHITE, seed=1)
    observed = observed.combine(np.eye(12)[:6], schedule.labels)
    ours = calibrate_accelerometers(observed)
    assert_allclose(ours.triad.matrix, theirs.K_a @ theirs.R_a, atol=ROUNDING * ACCEL_PULSES)
    means = observed.readings[:, 3:]
    assert_allclose(theirs.b_a, [means[2 * j : 2 * j + 2, j].mean() for j in range(3)], rtol=1e-12)
    assert_allclose(ours.triad.bias, means.mean(axis=0), atol=1e-13 * ACCEL_PULSES * 9.8)
    # two means or six: their bias has sqrt(3) times the deviation of ours
    rng = np.random.default_rng(2)
    pairs = np.array([scattered(observed, rng).readings[:, 3:] for _ in range(RUNS)])
    own = np.stack([pairs[:, 2 * j : 2 * j + 2, j].mean(axis=1) for j in range(3)], axis=-1)
    low, high = ratio_interval(RUNS, SURE)
    ratio = np.sqrt(3) * ours.bias_deviation / own.std(axis=0, ddof=1)
    assert (low < ratio).all()
    assert (ratio < high).all()


def test_imucal_takes_the_earths_rotation_for_a_sensitivity_to_acceleration():
    unit = MeasurementUnit(gyros=Sensors(triad=aligned(GYROS)), accelerometers=Sensors(triad=aligned(ACCELEROMETERS)))
    theirs = ferraris(LABORATORY.record(unit, SHORT, np.random.default_rng(0)), LABORATORY.gravity)
    upright = EARTH_RATE * np.sin(LABORATORY.latitude)
    # an optical gyro has none of it: 10 deg/h per g at this latitude
    scale = aligned(GYROS).scale_factor
    assert_allclose(np.diag(theirs.K_ga), scale * upright / LABORATORY.gravity, rtol=1e-9)  # difference of 3e-5 in 2
    # what it subtracts so it subtracts in the turn too, where it is right along the axis; across it takes the level
    # rotation, which differs between up and down too, for a sensitivity and the matrix is off by cos(lat) / rate
    level = EARTH_RATE * np.cos(LABORATORY.latitude) / (36 * DEG)
    expected = scale[:, None] * (np.eye(3) - level * np.roll(np.eye(3), 1, axis=1))
    assert level > 8e-5  # rad: 18 arcsec, where ours has none
    assert_allclose(theirs.K_g @ theirs.R_g, expected, atol=1e-9 * GYRO_PULSES)


# results there and back, and errors


def test_json_there_and_back():
    for observed in (measured(NOISY, six_positions(3.0), random=WHITE), measured(EXACT, six_positions(3.0))):
        calibration = calibrate_accelerometers(observed)
        back = LinearCalibration.from_json(calibration.to_json())
        assert back.triad == calibration.triad
        assert_array_equal(back.misalignment_deviation, calibration.misalignment_deviation)
        assert (back.chi_square, back.degrees_of_freedom) == (calibration.chi_square, calibration.degrees_of_freedom)


def test_tables_hold_triad_and_deviations():
    calibration = calibrate_accelerometers(measured(NOISY, six_positions(3.0), random=WHITE))
    triad = calibration.triad
    table = calibration.to_frame()
    assert list(table.index) == [name for j in range(3) for name in parameter_names(j)]
    assert table.loc["matrix_yx", "estimate"] == triad.matrix[1][0]
    assert table.loc["bias_z", "standard_deviation"] == calibration.bias_deviation[2]
    slides = calibration.to_frame("slides")
    assert len(slides) == 15
    assert_array_equal(slides.loc["cosine_xz"], [triad.cosines[0, 2], calibration.cosines_deviation[0, 2]])
    assert_array_equal(slides.loc["equivalent_y"], [triad.equivalents[1], calibration.equivalents_deviation[1]])
    assert_array_equal(slides.loc["zero_z"], [triad.bias[2], calibration.bias_deviation[2]])
    standard = calibration.to_frame("standard")
    assert len(standard) == 12
    assert_array_equal(
        standard.loc["misalignment_zx"], [triad.misalignment[2, 0], calibration.misalignment_deviation[2, 0]]
    )
    assert_array_equal(standard.loc["scale_factor_x"], [triad.scale_factor[0], calibration.matrix_deviation[0, 0]])
    assert_array_equal(standard.loc["bias_y"], [triad.input_bias[1], calibration.input_bias_deviation[1]])


def of(schedule, **kwargs):
    return measured(EXACT, schedule, **kwargs)


TURNED = Schedule([*TURNS.placements[:5]])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        # three positions, with and without anything known of the noise
        (lambda: calibrate_accelerometers(of(POINTS.select([0, 4, 8]))), "the plan does not determine .*`matrix_xz`"),
        (
            lambda: calibrate_accelerometers(of(POINTS.select([0, 4, 8]), random=WHITE)),
            "the plan does not determine .*`matrix_xz`",
        ),
        # up only, at any number of headings, tells the sums of bias and scale factors
        (
            lambda: calibrate_accelerometers(of(POINTS.select([0, 1, 2, 3, 8, 9, 16, 17]))),
            "the plan does not determine `bias_x`, `matrix_xx`, `matrix_xy`, `matrix_xz`: no observation changes along",
        ),
        (lambda: calibrate_gyros(of(TURNS.select([0, 1, 2, 3]))), "the plan does not determine .*`matrix_xz`"),
        (lambda: calibrate_accelerometers(of(POINTS.select([0, 4, 8, 16]))), "to estimate the noise level"),
        (lambda: average_positions(of(TURNS), TURNS), "`schedule` must hold positions at rest"),
        (lambda: average_positions(of(POINTS), PLAN), "`observed` must hold one observation for each placement"),
        (lambda: turn_differences(of(POINTS), POINTS), "`schedule` must hold turns"),
        (lambda: turn_differences(of(TURNED), TURNED), r"the opposite of each turn, got none of 'z \+360'"),
        (lambda: calibrate_accelerometers(of(six_positions(2.0))).to_frame("table"), "`form`"),
        (lambda: LinearCalibration.from_json(json.dumps({"kind": "Solution"})), "`text` must be that of a Linear"),
        (lambda: LinearCalibration.from_json("[1, 2]"), "`text` must be that of a Linear"),
    ],
)
def test_errors_name_what_is_missing(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_swapped_gyros_are_doubted():
    observed = measured(NOISY, PLAN)
    swapped = replace(observed, readings=observed.readings[:, [1, 0, 2, 3, 4, 5]])
    with pytest.warns(UserWarning, match="hardly reads along [xy], .* but along [yx], .* channels swapped") as caught:
        calibrate_gyros(averaged(PLAN, swapped))
    assert [str(warning.message).split("`")[1] for warning in caught] == ["gyro_x", "gyro_y"]


def test_a_difference_of_turns_is_that_of_their_pulses_over_the_time_of_both():
    there, back = full_turns().placements[:2]
    turns = Schedule([there, replace(back, rate=back.rate / 2, duration=2 * back.duration)])
    observed = measured(EXACT, turns)
    pulses = observed.readings * np.array([[there.duration], [2 * back.duration]])
    difference = turn_differences(observed, turns)
    assert_allclose(difference.readings[0], (pulses[0] - pulses[1]) / (3 * there.duration), rtol=1e-12)
    assert difference.bias_share == pytest.approx([-1 / 3])
