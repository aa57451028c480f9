"""Calibration on a rough table: against the unit that was put in, and by its own derivative taken another way."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.calibration.navigation_based import (
    Compensation,
    NavigationCalibration,
    actual_matrix,
    align_to_table,
    calibrate,
    differences,
    finite_difference_matrix,
    model_matrix,
    prepare,
    require_observable,
)
from fogkit.calibration.navigation_based.turn_model import PARAMETERS
from fogkit.earth import earth_rate_n, normal_gravity
from fogkit.rotation import dcm_from_rotvec
from fogkit.stand.rough_table import RoughTable
from fogkit.stand.turn_recordings import record
from fogkit.stand.turn_tests import nine_tests
from fogkit.units import ARCSEC, DEG, PPM

MISALIGNMENTS = [f"m_g_{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3) if i != j] + ["m_a_13", "m_a_21", "m_a_32"]
SCALE_FACTORS = [f"m_{kind}_{i}{i}" for kind in "ga" for i in (1, 2, 3)]


def largest(errors, names):
    return max(abs(errors[name]) for name in names)


@pytest.fixture(scope="module")
def calibrated(case):
    return calibrate(case.recordings, case.plan, case.latitude, initial_attitude=case.starts)


def test_true_start_gives_the_unit_that_was_put_in(case, calibrated):
    # the figures asked for: 0.01 arcsec and 0.1 ppm; without noise only the steps of 100 Hz are left
    errors = differences(calibrated.compensation, case.truth)
    assert largest(errors, MISALIGNMENTS) < 0.01 * ARCSEC
    assert largest(errors, SCALE_FACTORS) < 0.1 * PPM
    assert largest(errors, ["b_a_1", "b_a_2", "b_a_3"]) < 1e-6
    assert calibrated.converged
    assert calibrated.log.rms_z.iloc[-1] < 1e-6 * calibrated.log.rms_z.iloc[0]
    assert set(calibrated.log.columns) >= {"rms_z", "rms_m_a", "rms_m_g", "rms_b_a", "chi_square", "condition"}


def test_any_matrix_has_the_same_fixed_point(case, calibrated):
    model = calibrate(
        case.recordings, case.plan, case.latitude, initial_attitude=case.starts, matrix="model", iterations=30
    )
    errors = differences(model.compensation, calibrated.compensation)
    assert largest(errors, MISALIGNMENTS) < 0.01 * ARCSEC
    # the plan's matrix converges linearly: after 8 iterations it is behind, as the paper says
    assert model.log.rms_z[6] > 10 * calibrated.log.rms_z[6]


def test_all_dwells_give_the_scale_factors_too(case):
    result = calibrate(
        case.recordings, case.plan, case.latitude, initial_attitude="levelled", scale_factor="all", iterations=8
    )
    pairs = calibrate(case.recordings, case.plan, case.latitude, initial_attitude="model")
    everywhere = [differences(r.compensation, case.truth) for r in (result, pairs)]
    assert result.solution.names[-3:] == ("m_a_11", "m_a_22", "m_a_33")
    own = ["m_a_11", "m_a_22", "m_a_33"]
    # (26) with the model start has the second order of the tilt in it, some (0.2 deg)^2 / 2 = 6 ppm; the length has not
    assert largest(everywhere[0], own) < 0.1 * PPM < 1 * PPM < largest(everywhere[1], own)


def test_start_error_biases_by_the_rotation_of_the_earth(case):
    # the paper holds that a wrong start makes no error; without the rotation of the Earth it would be so
    noise, g = np.eye(18), float(normal_gravity(case.latitude))
    headings = 2e-3 * np.random.default_rng(1).normal(size=9)
    turned = dcm_from_rotvec(headings[:, np.newaxis] * [0, 0, 1]) @ case.starts
    right, wrong = (
        calibrate(case.recordings, case.plan, case.latitude, initial_attitude=starts, noise=noise)
        for starts in (case.starts, turned)
    )
    # what points north is seen west of it: the Earth's rotation about it tilts the unit about east, and the slope north
    # grows by g Omega cos(latitude) heading from the middle of one dwell to that of the other
    grown = g * earth_rate_n(case.latitude)[1] * headings * (5.0 + 12.0)
    H = actual_matrix(prepare(case.recordings, case.plan, case.latitude).run(right.compensation), g)
    expected = np.linalg.lstsq(H, np.column_stack([np.zeros(9), grown]).ravel(), rcond=None)[0]
    found = differences(wrong.compensation, right.compensation)
    found = np.array([found[name] for name in PARAMETERS])
    assert np.abs(found[:12]).max() > 0.1 * ARCSEC
    # second order: heading times tilts of the table, 0.3 deg, times 33 rad in some elements
    assert np.linalg.norm(-found[:12] - expected[:12]) < 0.05 * np.linalg.norm(expected[:12])


def test_parabola_removes_what_the_earth_makes_of_a_wrong_start(case):
    # all but the Schuler part: (g / R) times the times of the test squared, a fifth of the Earth's
    tilts = 2e-3 * np.random.default_rng(2).normal(size=(9, 3))
    starts = dcm_from_rotvec(tilts) @ case.starts
    changes = {}
    for degree in (1, 2):
        options = {"initial_attitude": starts, "degree": degree}
        changes[degree] = prepare(case.recordings, case.plan, case.latitude, **options).run(case.truth.gauged()).change
    assert np.linalg.norm(changes[2]) < 0.3 * np.linalg.norm(changes[1])


def test_level_and_heading_of_the_start_in_three_ways(case):
    errors = {}
    for start in ("model", "levelled", "carried"):
        result = calibrate(case.recordings, case.plan, case.latitude, initial_attitude=start)
        errors[start] = np.linalg.norm([differences(result.compensation, case.truth)[name] for name in MISALIGNMENTS])
    assert errors["levelled"] < errors["model"] and errors["carried"] < errors["model"]


def test_matrix_of_actual_rotations_is_the_derivative_of_the_processing(case, calibrated):
    prepared = prepare(case.recordings, case.plan, case.latitude, initial_attitude=case.starts)
    trial = finite_difference_matrix(prepared, calibrated.compensation)
    gravity = float(normal_gravity(case.latitude))
    actual = actual_matrix(prepared.run(calibrated.compensation), gravity)
    model = model_matrix(case.plan, gravity)
    size = np.linalg.norm(trial, axis=0)
    # goal 1 %, by columns; what is left is the Earth turning an error of attitude for some 15 s: 1e-3
    assert (np.linalg.norm(actual - trial, axis=0) < 2e-3 * size).all()
    assert np.linalg.norm(model - trial) > 2 * np.linalg.norm(actual - trial)


def test_result_goes_to_text_and_back_and_to_a_table(calibrated):
    again = NavigationCalibration.from_json(calibrated.to_json())
    assert again.to_json() == calibrated.to_json()
    table = calibrated.to_frame()
    assert list(table.index) == [f"{n[0].upper()}{n[1:]}" for n in PARAMETERS] + ["M_a_11", "M_a_22", "M_a_33"]
    assert table.loc["M_g_12", "value"] == calibrated.compensation.gyro_matrix[0, 1]
    assert calibrated.slopes.shape == (18, 6)


def test_given_covariance_takes_the_place_of_the_residuals(case):
    sigma = 1e-4
    given = calibrate(case.recordings, case.plan, case.latitude, noise=lambda plan: sigma**2 * np.eye(2 * len(plan)))
    H = model_matrix(case.plan, float(normal_gravity(case.latitude)))
    expected = sigma * np.sqrt(np.diag(np.linalg.inv(H.T @ H)))  # (27), by the plan
    # an axis 0.3 deg off times 33 rad changes elements of 1 by 0.17, in few of the 18 rows
    assert_allclose(given.solution.standard_deviation, expected, rtol=0.15)


def test_tables_axes_by_turns_and_by_attitude():
    # a table with right axes and a unit that is mounted askew: alignment finds the mounting, and only that
    plan = nine_tests(turns=1, dwell=2.0, turn_duration=4.0)
    C = dcm_from_rotvec([2e-3, -1e-3, 3e-3])
    latitude = 50 * DEG
    truth = Compensation(gyro_matrix=C.T, accelerometer_matrix=C.T)  # what reads C x, its axes turned in the case
    from fogkit.imu.triads import LinearTriad
    from fogkit.imu.unit import MeasurementUnit, Sensors

    triad = Sensors(triad=LinearTriad(matrix=C))
    recordings = record(MeasurementUnit(gyros=triad, accelerometers=triad), RoughTable(latitude=latitude).motions(plan))
    turned = align_to_table(Compensation(), recordings, plan)
    # the Earth's rotation besides the turn: 7e-5 rad/s times 4 s of 8 rad, and in the plane across it over part turns
    assert_allclose(turned.compensation.gyro_matrix, truth.gyro_matrix, atol=4e-5)
    assert_allclose(turned.compensation.accelerometer_matrix, truth.accelerometer_matrix, atol=4e-5)
    assert turned.residuals.max() < 1e-4
    starts = plan[0].C_b_n @ C.T
    by_attitude = align_to_table(Compensation(), recordings, plan, by="attitude", initial_attitude=starts)
    assert_allclose(by_attitude.C_b_table, C.T, atol=1e-12)
    levelled = align_to_table(Compensation(), recordings, plan, by="attitude").C_b_table
    assert_allclose((C @ levelled)[[0, 1], 2], 0, atol=1e-5)  # tilt is found, heading is not


def test_divergence_is_stopped_and_named(case):
    # matrix of another sign: every step goes the wrong way
    H = -model_matrix(case.plan, 9.81)
    with pytest.raises(RuntimeError, match=r"diverges: in iteration \d+ the rms of the changes of slope is"):
        calibrate(case.recordings, case.plan, case.latitude, matrix=H, iterations=20)


def test_too_few_iterations_are_said(case):
    with pytest.warns(UserWarning, match="more `iterations` would change"):
        short = calibrate(case.recordings, case.plan, case.latitude, initial_attitude=case.starts, iterations=1)
    assert not short.converged


def test_tolerance_stops_before(case):
    result = calibrate(case.recordings, case.plan, case.latitude, tolerance=0.1)
    assert result.converged and len(result.log) < 8


def test_plan_that_loses_a_parameter_is_named():
    plan = list(nine_tests())
    plan[4] = plan[3]  # the half turn about y, again as a quarter turn
    with pytest.raises(ValueError, match=r"m_a_33 by \(26\)"):
        require_observable(plan)
    for i in (3, 5):
        plan[i] = plan[4]
    with pytest.raises(ValueError, match=r"the plan does not determine .*`m_g_"):
        require_observable(plan, "all")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"matrix": "actua"}, "`matrix` must be one of 'actual', 'model'"),
        ({"matrix": np.zeros((18, 14))}, r"`matrix` must be of shape \(18, 15\)"),
        ({"degree": 3}, "`degree` must be 1 or 2"),
        ({"initial_attitude": "guess"}, "`initial_attitude` must be one of"),
        ({"noise": np.eye(3)}, r"`noise` must be of shape \(18, 18\)"),
        ({"settle": 10.0}, "`settle` must leave something"),
        ({"latitude": 54.0}, "`latitude`"),
    ],
)
def test_bad_arguments(case, change, words):
    arguments = {"latitude": case.latitude} | change
    with pytest.raises(ValueError, match=words):
        calibrate(case.recordings, case.plan, **arguments)


def test_no_result_where_the_end_is_not_in_sight(case):
    # steps a fifth of what they should be, from scale factors of gyros 1 % off
    H = 5 * model_matrix(case.plan, 9.81)
    stretched = Compensation(gyro_matrix=1.01 * np.eye(3))
    with pytest.raises(RuntimeError, match="does not converge: the correction of iteration 4 still turns"):
        calibrate(case.recordings, case.plan, case.latitude, matrix=H, start=stretched, iterations=4)
