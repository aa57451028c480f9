"""Compensation: exact inverse of a unit, common rotations, and the errors that are left without them."""

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fogkit.calibration.navigation_based import Compensation, differences
from fogkit.imu.tables import IMU_COLUMNS
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors
from fogkit.rotation import dcm_from_rotvec

ROUNDING = 1e-13


def random_compensation(seed, size=1e-2):
    rng = np.random.default_rng(seed)
    return Compensation(
        gyro_matrix=np.eye(3) + size * rng.normal(size=(3, 3)),
        gyro_bias=1e-4 * rng.normal(size=3),
        accelerometer_matrix=np.eye(3) + size * rng.normal(size=(3, 3)),
        accelerometer_bias=1e-2 * rng.normal(size=3),
    )


def test_truth_of_a_unit_undoes_its_readings():
    rng = np.random.default_rng(1)
    triads = [LinearTriad(bias=rng.normal(size=3), matrix=np.eye(3) + 0.1 * rng.normal(size=(3, 3))) for _ in range(2)]
    unit = MeasurementUnit(gyros=Sensors(triad=triads[0]), accelerometers=Sensors(triad=triads[1]))
    rate, force, dt = rng.normal(size=(4, 3)), rng.normal(size=(4, 3)), 0.01
    raw = np.hstack([triads[0].readings(rate), triads[1].readings(force)]) * dt
    table = pd.DataFrame(raw, index=pd.Index(dt * np.arange(4), name="time"), columns=list(IMU_COLUMNS))
    assert_allclose(Compensation.from_unit(unit).apply(table) / dt, np.hstack([rate, force]), atol=ROUNDING)


def test_gauge_is_a_common_rotation_that_zeroes_three_elements():
    free = random_compensation(2, size=0.05)
    gauged = free.gauged()
    assert_array_equal(gauged.accelerometer_matrix[[0, 1, 2], [1, 2, 0]], 0)
    C = gauged.accelerometer_matrix @ np.linalg.inv(free.accelerometer_matrix)
    assert_allclose(C @ C.T, np.eye(3), atol=ROUNDING)
    for name in ("gyro_matrix", "gyro_bias", "accelerometer_bias"):
        assert_allclose(getattr(gauged, name), C @ getattr(free, name), atol=ROUNDING)


@pytest.mark.parametrize("shift", [1, -1])
def test_no_gauge_for_a_matrix_of_interchanged_axes(shift):
    with pytest.raises(ValueError, match="near a diagonal one"):
        Compensation(accelerometer_matrix=np.roll(np.eye(3), shift, axis=0)).gauged()


def test_differences_see_through_a_common_rotation_to_the_errors_put_in():
    truth = random_compensation(3)
    errors = {"m_a_13": 1e-4, "m_a_22": -2e-4, "m_g_12": 3e-4, "m_g_33": -1e-4, "b_a_2": 1e-3, "b_g_1": 1e-6}
    wrong = truth.with_errors(errors)
    for estimate in (wrong, wrong.turned(dcm_from_rotvec([0.03, -0.02, 0.04]))):
        found = differences(estimate, truth)
        assert len(found) == 24
        for name, value in found.items():
            # the gauge rotates by nothing here: none of the errors is one of the three zeros
            assert_allclose(value, errors.get(name, 0.0), atol=1e-12, err_msg=name)


def test_errors_in_the_gauge_itself_are_the_rotation():
    truth = Compensation()
    found = differences(truth.with_errors({"m_a_12": 1e-5}), truth)
    # accelerometer x sees y: axes turned by -1e-5 about z make it zero, and show in m_a_21 and in both gyros
    assert_allclose(found["m_a_12"], 0, atol=1e-16)
    assert_allclose([found["m_a_21"], found["m_g_12"], found["m_g_21"]], [1e-5, -1e-5, 1e-5], atol=1e-9)


def test_corrected_undoes_errors_to_first_order():
    truth = random_compensation(4, size=0.0)
    errors = {"m_g_12": 1e-4, "b_a_3": 1e-3, "b_g_2": 1e-6}
    found = differences(truth.with_errors(errors).corrected(errors), truth)
    assert max(abs(value) for value in found.values()) < 1e-7  # products: 1e-4 times a bias of 1e-4
    with pytest.raises(ValueError, match="'m_x_12'"):
        truth.corrected({"m_x_12": 1.0})
    with pytest.raises(ValueError, match="'b_a_12'"):
        truth.corrected({"b_a_12": 1.0})


def test_text_and_table_keep_every_bit():
    one = random_compensation(5)
    again = Compensation.from_json(one.to_json())
    assert_array_equal(again.to_frame(), one.to_frame())
    assert one.to_frame().loc["accel_y", "bias"] == one.accelerometer_bias[1]
    with pytest.raises(ValueError, match="must be invertible"):
        Compensation(gyro_matrix=np.ones((3, 3)))
    with pytest.raises(ValueError, match="read-only"):
        one.gyro_matrix[0, 0] = 2.0
