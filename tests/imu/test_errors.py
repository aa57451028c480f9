import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from fogkit.imu import MISALIGNMENTS, GyroTriad
from fogkit.imu.errors import misalignment_matrix, misalignments_from_matrix
from fogkit.units import ARCMIN

angles = st.lists(st.floats(-1.2, 1.2), min_size=6, max_size=6)


@given(angles)
def test_input_axes_are_unit_vectors_and_the_angles_come_back(values):
    A_g = misalignment_matrix(values)
    assert_allclose(np.linalg.norm(A_g, axis=1), 1, rtol=1e-14)
    assert_allclose(misalignments_from_matrix(A_g), values, atol=1e-13)


@pytest.mark.parametrize("name", MISALIGNMENTS)
def test_each_angle_turns_its_gyro_about_its_axis_counter_clockwise(name):
    gyro, about = "xyz".index(name[-2]), "xyz".index(name[-1])
    values = np.zeros(6)
    values[MISALIGNMENTS.index(name)] = 0.1
    turn = Rotation.from_rotvec(0.1 * np.eye(3)[about])
    assert_allclose(misalignment_matrix(values)[gyro], turn.apply(np.eye(3)[gyro]), atol=1e-15)


def test_printed_rows_are_short_by_the_fourth_power():
    values = np.full(6, 5 * ARCMIN)
    length = np.linalg.norm(misalignment_matrix(values, exact=False), axis=1)
    # 1 - sin^2 sin^2, and its square root
    assert_allclose(1 - length, 0.5 * np.sin(5 * ARCMIN) ** 4, rtol=1e-3)


def test_asymmetry_is_the_difference_over_the_mean():
    triad = GyroTriad(scale_positive=(1.0, 2.0, 3.0), scale_negative=(1.0, 2.002, 2.997))
    assert_allclose(triad.asymmetry, [0, -0.002 / 2.001, 0.003 / 2.9985], rtol=1e-12)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("bias", (0.0, 0.0)),
        ("bias", (np.nan, 0, 0)),
        ("scale_positive", (1.0, 0.0, 1.0)),
        ("scale_negative", (1.0, -1.0, 1.0)),
        ("misalignments", (0.0,) * 5),
        ("misalignments", (2.0,) * 6),
        ("angle_random_walk", -1.0),
        ("bias_instability", np.inf),
    ],
)
def test_impossible_triads_are_refused_by_name(name, value):
    with pytest.raises(ValueError, match=f"`{name}`"):
        GyroTriad(**{name: value})
