"""The experiments behind the claims in words: laws that they must follow, other routes to the same numbers."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose

from fogkit import claims
from fogkit.calibration.navigation_based import Compensation
from fogkit.earth import earth_rate_n, normal_gravity, radius_transverse
from fogkit.imu.size_effect import SizeEffect
from fogkit.navigation import State, integrate
from fogkit.reproduction.klimkovich import (
    bias_sources,
    convergence,
    gyro_bias_test,
    paper,
    tables,
    trials,
    verdicts,
)
from fogkit.reproduction.klimkovich.estimates import LATITUDE
from fogkit.stand.turn_tests import bias_test
from fogkit.units import ARCSEC, DEG, DEG_PER_HOUR, DEG_PER_SQRT_HOUR

SLOW = {"rate": 50.0}  # samples per second: the motion is smooth


@pytest.fixture(scope="module")
def rough():
    return trials.Trial(**SLOW)


# Trials


def test_the_truth_leaves_no_measurement(rough):
    # from the true start with the true parameters; mechanisation and the circle on which the unit moves: 1e-7 m/s^2
    found = rough.calibrated(attitude="true", start=rough.truth.gauged(), iterations=1)
    assert found.log["rms_z"].iloc[0] < 1e-7
    assert max(rough.errors(rough.truth).values()) < 1e-6


def test_another_seed_is_another_unit_table_and_noise():
    one, other = (trials.Trial(seed=seed) for seed in (1, 2))
    assert not np.isclose(one.unit.gyros.triad.matrix, other.unit.gyros.triad.matrix).any()
    assert abs(one.motions[0].angle - other.motions[0].angle) > 1e-6
    assert trials.Trial(roughness=0).motions[0].angle == one.plan[0].angle


def test_largest():
    errors = {f"m_{kind}_{i}{j}": 0.0 for kind in "ag" for i in (1, 2, 3) for j in (1, 2, 3)}
    errors |= {f"b_{kind}_{i}": 0.0 for kind in "ag" for i in (1, 2, 3)}
    errors |= {
        "m_g_12": -3 * ARCSEC,
        "m_g_31": 2 * ARCSEC,
        "m_g_22": 5e-6,
        "m_a_33": -7e-6,
        "b_a_2": 4e-5,
        "b_g_1": 1.0,
    }
    assert trials.largest(errors) == pytest.approx(
        {
            "gyro_angle_arcsec": 3,
            "gyro_scale_ppm": 5,
            "accelerometer_angle_arcsec": 0,
            "accelerometer_scale_ppm": 7,
            "accelerometer_bias_um_s2": 40,
        }
    )


def test_words_that_are_no_choice(rough):
    with pytest.raises(ValueError, match="`matrix`"):
        rough.calibrated("best")
    with pytest.raises(ValueError, match="`attitude`"):
        rough.calibrated(attitude="best")


# Convergence


def test_steps_one_by_one_are_the_iteration(rough):
    history = convergence.history(rough, iterations=4)
    found = rough.calibrated(iterations=4)
    assert_allclose(history["rms_z"], found.log["rms_z"], rtol=1e-9)
    assert history.iloc[-1][list(trials.QUANTITIES)].to_dict() == pytest.approx(
        {name: rough.errors(found.compensation)[name] for name in trials.QUANTITIES}, rel=1e-6
    )


@pytest.mark.parametrize(
    ("values", "expected"),
    [([9, 3, 1, 1], 3), ([1, 1, 1], 1), ([5, 1, 4, 1, 1], 4), ([5, 4, 3, 2], 4), ([2, 1.05, 1], 2)],
)
def test_iterations_to_floor(values, expected):
    log = pd.DataFrame({"rms_z": values}, index=range(1, len(values) + 1), dtype=float)
    assert convergence.iterations_to_floor(log) == expected


def test_slopes_of_the_figures_are_those_of_the_method(rough):
    found = rough.calibrated(iterations=1)
    assert_allclose(
        convergence.slopes(convergence.velocities(rough), rough),
        found.slopes.loc["1", ["east", "north"]].to_numpy(),
        rtol=1e-6,
    )


def test_comparison_of_matrices_keeps_its_rows():
    table = convergence.compare_matrices(trials.Trial(roughness=0.0, **SLOW), iterations=4)
    assert list(table.index) == list(trials.MATRICES)
    # on an ideal table the actual matrix becomes that of the plan
    assert_allclose(table.loc["model", "rms_z"], table.loc["actual", "rms_z"], rtol=0.01)
    assert table.loc["printed", "rms_z"] > 3 * table.loc["actual", "rms_z"]


# What biases the result


def effect(trial, reference, **options):
    changes = convergence.disagreement(
        trial.calibrated(attitude="true", **options), reference.calibrated(attitude="true", **options)
    )
    return changes["gyro_angle_arcsec"]


def test_delays_act_by_rate_times_delay_times_the_axis_error():
    still = {"absorber": None, "wobble": ()}
    base = trials.Trial(table=still, **SLOW)
    half, full = (
        effect(replace(base, gyro_delay=tuple(scale * d for d in (1e-4, -1e-4, 2e-4))), base) for scale in (0.5, 1.0)
    )
    assert_allclose(full, 2 * half, rtol=0.02)
    # the largest: rate * difference of delays * error of the axis
    rate, difference = base.motions[0].rate, 3e-4
    lean = max(np.linalg.norm(m.axis - m.test.axis) for m in base.motions)
    assert 0.2 < full * ARCSEC / (rate * difference * lean) < 2


def test_size_effect_moves_the_level_by_the_way_over_the_radius():
    centres = np.zeros((3, 3))
    centres[1] = (0.0, 0.0, 0.03)  # accelerometer y, 3 cm along z: it feels the ramps of a turn about x
    base = trials.Trial(roughness=0.0, error=0.0, accelerometer_bias=0.0, rate=50.0)
    trial = replace(base, size_effect=SizeEffect.one_point(centres))
    table = convergence.velocities(trial)
    (_, begin), (end, _) = trial.plan[0].dwells
    way = np.trapezoid(table["north"].loc[begin : end - 1e-6], dx=1 / trial.rate)
    change = np.diff(convergence.slopes(table, trial), axis=0)[0, 1]
    # an apparent way north tips the computed level about east: a level that is wrong by theta shows -g theta north
    expected = way / float(radius_transverse(LATITUDE)) * float(normal_gravity(LATITUDE))
    assert abs(way) > 0.3
    assert_allclose(abs(change), abs(expected), rtol=0.1)  # the meridian's radius is 0.6 % less; the ramps' share


def test_without_a_source_nothing_changes():
    assert max(bias_sources.effect("gyro delay, common", 0.0).values()) < 0.02
    assert_allclose(bias_sources.effect("start of the model", 0.0)["gyro_angle_arcsec"], 0, atol=0.03)
    assert bias_sources.effect("gyro bias x", 0.0)["gyro_angle_arcsec"] > 0.2
    assert list(bias_sources.table(0.0).index) == list(bias_sources.SOURCES)


# Gyro biases and azimuth


def test_biases_by_the_equations_as_printed():
    trial = gyro_bias_test.BiasTrial(tilt=(1e-4, -2e-4, 3e-4))
    test, g = bias_test(trial.dwell), float(normal_gravity(LATITUDE))
    run = integrate(
        trial.recording,
        State(lat=LATITUDE, C_b_n=np.eye(3)),
        position_fixed=True,
        velocity_reset=[test.dwells[1][0]],
    )
    heading = np.unwrap(run.heading_pitch_roll[0])
    second, yaw = [], []
    for begin, end in test.dwells:
        inside = (run.time > begin + 1e-6) & (run.time < end + 1e-6)
        t = run.time[inside] - begin
        second.append(2 * np.polyfit(t, run.v_eb_n[inside, :2], 2)[0])
        yaw.append(np.polyfit(t, heading[inside], 1)[0])
    (V1_1, V2_1), (V1_2, V2_2) = second
    printed = [(V2_2 - V2_1) / (2 * g), -(V1_2 - V1_1) / (2 * g), -(yaw[1] + yaw[0]) / 2]
    assert_allclose(gyro_bias_test.estimate(trial).bias, printed, atol=1e-12)


def test_figure_6_converges_to_the_biases():
    found = gyro_bias_test.figure_6()
    assert_allclose(found.iloc[-1][["x", "y", "z"]], np.array(gyro_bias_test.BIAS) / DEG_PER_HOUR, atol=1e-6)
    assert np.abs(found["left_z"].iloc[0]) > 1e-4  # Schuler's part of one estimate


def test_tilt_enters_the_vertical_bias_by_the_earth_rate():
    # a start turned from the truth by -tilt, whose drift about up is Omega_N times it
    angle = 1e-3
    found = gyro_bias_test.effect_of_start(0, angle)[2]
    assert_allclose(abs(found), angle * earth_rate_n(LATITUDE)[1], rtol=0.1)


def test_azimuths_show_a_level_bias_as_one_period():
    bias = np.array([3e-8, -2e-8, 0.0])
    change = gyro_bias_test.azimuths(bias) - gyro_bias_test.azimuths()
    angle = np.array(list(paper.TABLE_2)) * DEG
    # x points east and y north at 0, the azimuth is clockwise; a bias east turns what is taken for north clockwise
    expected = (bias[0] * np.cos(angle) + bias[1] * np.sin(angle)) / earth_rate_n(LATITUDE)[1] / DEG
    assert_allclose(change, expected, atol=0.03 * np.abs(expected).max())  # noise turns the axes a little


def test_harmonic_of_table_2():
    found = tables.table_2_harmonic()
    angle, errors = np.array(list(paper.TABLE_2)) * DEG, np.array(list(paper.TABLE_2.values()))
    design = np.column_stack([np.cos(angle), np.sin(angle), np.ones(8)])
    fit, (left,), *_ = np.linalg.lstsq(design, errors)
    assert_allclose(found["amplitude"], np.hypot(*fit[:2]))
    assert_allclose(found["share"], 1 - left / np.sum(errors**2), atol=1e-6)
    scatter = found["walk"] / np.sqrt(300) / float(earth_rate_n(LATITUDE)[1]) / DEG
    assert_allclose(scatter, tables.table_2_statistics()["deviation"])


# The ledger


@pytest.fixture(scope="module")
def notes():
    return {claim.id.removeprefix("klimkovich-"): claim.note for claim in claims.load("klimkovich")}


def errors_of(seed, noisy, matrix):
    return verdicts.errors_with_both_matrices()[seed, noisy][("actual", "model").index(matrix)]


def worst(quantity):
    return max(verdicts.errors(seed=seed)[quantity] for seed in verdicts.SEEDS)


@pytest.mark.parametrize(
    ("row", "text", "value"),
    [
        ("abs-residual", "4.69", lambda: errors_of(1, True, "actual")),
        ("abs-residual", "4.68", lambda: errors_of(1, True, "model")),
        ("abs-residual", "4.60", lambda: errors_of(2, True, "actual")),
        ("abs-residual", "4.62", lambda: errors_of(2, True, "model")),
        ("abs-residual", "2.20", lambda: errors_of(3, True, "actual")),
        ("abs-rough", "1.4", lambda: worst("gyro_angle_arcsec")),
        ("abs-rough", "0.34", lambda: worst("gyro_scale_ppm")),
        ("abs-rough", "28", lambda: worst("accelerometer_bias_um_s2")),
        ("table-errors", "24", lambda: verdicts.errors()["accelerometer_scale_ppm"]),
        ("intro-model-bias", "3.0", verdicts.left_by_the_model_matrix),
        ("differences-delays", "0.89", lambda: bias_sources.effect("gyro delays, unequal")["gyro_angle_arcsec"]),
        ("differences-delays", "0.03", lambda: bias_sources.effect("gyro delays, unequal", 0.0)["gyro_angle_arcsec"]),
        ("differences-size", "0.03", lambda: bias_sources.effect("size effect, one point")["gyro_angle_arcsec"]),
        ("angles-actual", "6.4e-3", lambda: convergence.errors_of_turns(convergence.standard_trial())[0]),
        ("angles-actual", "7.9e-6", lambda: convergence.errors_of_turns(convergence.standard_trial())[1]),
        ("fig3-oscillations", "0.7", lambda: convergence.oscillations()["none"] * 1e3),
        ("fig3-oscillations", "0.10", lambda: convergence.oscillations()["size effect"]),
        ("fig3-oscillations", "1.6", lambda: convergence.oscillations()["delays"]),
        ("fig3-oscillations", "0.09", lambda: convergence.oscillations()["off the axis"]),
        ("fig4-floor", "0.0439", lambda: verdicts.floors()["actual"] * 1e3),
        ("fig4-floor", "0.083", lambda: verdicts.floors()["printed"] * 1e3),
        ("bias-heading", "4.5e-8", lambda: abs(gyro_bias_test.effect_of_start(0)[2])),
        ("bias-heading", "1.9e-7", lambda: abs(gyro_bias_test.effect_of_start(1)[2])),
        ("start-from-dwell", "0.02", lambda: verdicts.errors(attitude="levelled")["accelerometer_scale_ppm"]),
        ("start-from-dwell", "0.8", lambda: verdicts.errors(attitude="levelled")["gyro_angle_arcsec"]),
        ("concl-algorithm", "3e-10", lambda: verdicts.measurement_of_a_perfect_unit(50.0)),
        ("concl-algorithm", "2e-11", lambda: verdicts.measurement_of_a_perfect_unit(100.0)),
        ("concl-works", "1.4", lambda: worst("gyro_angle_arcsec")),
        ("concl-works", "0.34", lambda: worst("gyro_scale_ppm")),
        ("model-start", "1.1", lambda: bias_sources.effect("start of the model")["gyro_angle_arcsec"]),
        ("eq33", "0.23", lambda: bias_sources.effect("gyro bias x", 0.0)["gyro_angle_arcsec"]),
    ],
)
def test_numbers_in_the_notes(notes, row, text, value):
    assert text in notes[row]
    digits = len(re.sub(r"e.*|^0*\.?0*|\.", "", text))
    assert f"{value():.{digits - 1}e}" == f"{float(text):.{digits - 1}e}"


def test_actual_beats_model_by_one_iteration(notes):
    counts = [
        convergence.iterations_to_floor(convergence.standard_calibration(matrix).log) for matrix in ("actual", "model")
    ]
    assert counts == [3, 4]
    assert "3 against 4" in notes["abs-iterations"]


def test_model_matrix_stopped_early_and_later():
    # linear convergence: at five times the roughness arcsec after 8 iterations, hundredths after 15
    assert verdicts.left_by_the_model_matrix(iterations=15) < 0.1
    assert verdicts.left_by_the_model_matrix(1.0) < 0.01
    actual = convergence.standard_trial(roughness=5.0).calibrated(attitude="true")
    assert convergence.standard_trial(roughness=5.0).errors(actual.compensation)["gyro_angle_arcsec"] < 1e-3


def test_from_the_true_start_the_table_shows_in_a_rotation_only():
    assert verdicts.table_shows_in_a_rotation_only("true")
    assert max(list(verdicts.errors(attitude="true").values())[:4]) < 1e-4
    assert not verdicts.table_shows_in_a_rotation_only("levelled")


def test_compensation_is_needed(rough):
    assert rough.errors(Compensation())["gyro_angle_arcsec"] > 50
    assert DEG_PER_SQRT_HOUR * 1e-3 < trials.ANGLE_RANDOM_WALK < DEG_PER_SQRT_HOUR * 1e-2
