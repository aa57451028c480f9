import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from fogkit.imu import Construction
from fogkit.imu.constructions import TRIHEDRAL_ALPHA, TRIHEDRAL_BETA, pyramid_matrix

angle = st.floats(-7, 7)


@given(alpha=angle, beta=angle, block=angle)
def test_direction_cosines_are_rotations(alpha, beta, block):
    for C in (pyramid_matrix(alpha, beta), Construction(name="trihedral").C_0_g1(block)):
        assert_allclose(C @ C.T, np.eye(3), atol=1e-14)
        assert_allclose(np.linalg.det(C), 1, rtol=1e-13)


def test_trihedral_is_symmetric_about_the_axis_of_the_block():
    C_B_g1 = pyramid_matrix(TRIHEDRAL_ALPHA, TRIHEDRAL_BETA)
    # a cube on its corner: each axis at the angle of the space diagonal, its shadows 120 degrees apart
    assert_allclose(C_B_g1[:, 2], 1 / np.sqrt(3), rtol=1e-14)
    shadows = np.sort(np.rad2deg(np.arctan2(C_B_g1[:, 1], C_B_g1[:, 0])))
    assert_allclose(np.diff(shadows), 120, rtol=1e-12)


def test_a_third_of_a_turn_of_the_block_brings_the_next_axis_into_place():
    trihedral = Construction(name="trihedral")
    y = trihedral.C_0_g1(0.0)[1]
    assert_allclose(trihedral.C_0_g1(np.deg2rad(120))[0], y, atol=1e-15)
    assert_allclose(trihedral.C_0_g1(np.deg2rad(240))[2], y, atol=1e-15)


def test_a_plain_unit_has_no_block_to_turn():
    assert_allclose(Construction(name="plain").C_0_g1(), np.eye(3))
    with pytest.raises(ValueError, match="`block_angle`"):
        Construction(name="plain").C_0_g1(0.1)
    with pytest.raises(ValueError, match="`name`"):
        Construction(name="cube")
