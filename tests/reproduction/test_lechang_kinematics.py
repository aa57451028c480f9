"""Angles against a matrix near a vertical bow."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.reproduction.lechang import kinematics
from fogkit.units import ARCSEC, DEG


def test_order_of_the_rule():
    errors = [kinematics.over_the_top(10 * DEG, dt)[0] for dt in (0.4, 0.2)]
    # the fourth order; the end of the loop moves by up to a step between the two, which matters to a tenth
    assert_allclose(np.log2(errors[0] / errors[1]), 4, atol=0.3)


def test_angles_fail_towards_the_vertical_and_a_matrix_does_not():
    far, near = (kinematics.over_the_top(angle * DEG, 0.1) for angle in (30, 2))
    assert near[0] > 100 * far[0]
    assert max(far[1], near[1]) < 1e-6 * ARCSEC  # rounding of 157 products of rotations
    with pytest.raises(ValueError, match="Heading and roll are not defined apart"):
        kinematics.over_the_top(0.01 * DEG, 0.05)
    with pytest.raises(ValueError, match="`closest` must be"):
        kinematics.over_the_top(0.0)
