"""The gyrocompass's frames against directions that are known, and against the package's own attitude."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from fogkit.gyrocompass import frames
from fogkit.rotation import dcm_from_heading_pitch_roll, dcm_from_rotvec

angle = st.floats(-3.1, 3.1)


@given(angle, st.floats(-1.5, 1.5), angle)
def test_angles_are_those_of_the_package(heading, trim, roll):
    C_h_g = frames.hull_attitude(heading, trim, roll)
    # rounding of products of three matrices
    assert_allclose(frames.package_attitude(C_h_g), dcm_from_heading_pitch_roll(heading, trim, roll), atol=1e-15)
    # an angle is lost as 1/cos(trim), 14 at 1.5 rad
    assert_allclose(frames.heading_trim_roll(C_h_g), (heading, trim, roll), atol=1e-13)


def test_conversion_keeps_directions():
    north, up, east = np.eye(3)
    assert (frames.TO_PACKAGE @ north).tolist() == [0, 1, 0]
    assert (frames.TO_PACKAGE @ up).tolist() == [0, 0, 1]
    assert (frames.TO_PACKAGE @ east).tolist() == [1, 0, 0]
    assert np.linalg.det(frames.TO_PACKAGE) == 1


def test_a_hull_heeled_to_starboard():
    starboard = frames.hull_attitude(0.0, 0.0, 0.2)[:, 2]  # in north, up, east
    assert_allclose(starboard, [0, -np.sin(0.2), np.cos(0.2)], atol=1e-15)
    bow = frames.hull_attitude(0.0, 0.2, 0.0)[:, 0]
    assert_allclose(bow, [np.cos(0.2), np.sin(0.2), 0], atol=1e-15)


def test_mount_turns_counter_clockwise_from_above():
    # the mount's forward axis, turned a quarter from that of a hull heading north, points to port: west
    forward = frames.hull_attitude(0.0, 0.0, 0.0) @ frames.mount_attitude(np.pi / 2)[:, 0]
    assert_allclose(forward, [0, 0, -1], atol=1e-15)
    assert frames.mount_attitude(np.zeros((2, 5))).shape == (2, 5, 3, 3)


def test_pyramid_is_three_equal_faces():
    C = frames.pyramid_axes()
    assert_allclose(C.T @ C, np.eye(3), atol=1e-15)
    assert_allclose(C[1], 1 / np.sqrt(3), rtol=1e-15)  # each as steep: faces of one pyramid round the mount's axis
    third = dcm_from_rotvec([0, 2 * np.pi / 3, 0])
    assert_allclose(third @ C, np.roll(C, -1, axis=1), atol=1e-15)  # z, x, y follow one another by a third of a turn
    assert_allclose(C[:, 1], [np.sqrt(2 / 3), 1 / np.sqrt(3), 0], atol=1e-15)  # (13) of the thesis


def test_sequences():
    with pytest.raises(ValueError, match="`sequence` must be three letters of XYZ, got 'YZ'"):
        frames.pyramid_axes(sequence="YZ")
    with pytest.raises(ValueError, match="`sequence` must not name an axis twice running"):
        frames.pyramid_axes(sequence="YYZ")
    for sequence in map("".join, product("XYZ", repeat=3)):
        if sequence[0] != sequence[1] != sequence[2]:
            C = frames.pyramid_axes(sequence=sequence)  # orthogonal for any sequence: that does not single one out
            assert_allclose(C.T @ C, np.eye(3), atol=1e-15)


def test_bad_attitudes():
    with pytest.raises(ValueError, match="`C_h_g` must be orthonormal"):
        frames.package_attitude(2 * np.eye(3))
    with pytest.raises(ValueError, match="`C_h_g` must be a rotation"):
        frames.heading_trim_roll(np.diag([1.0, 1.0, -1.0]))
    with pytest.warns(UserWarning, match="Gimbal lock"):
        frames.heading_trim_roll(frames.hull_attitude(0.3, np.pi / 2, 0.1))
