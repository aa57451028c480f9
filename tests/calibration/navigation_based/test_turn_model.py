"""The first-order model of a turn against exact attitudes, quadrature and differences."""

import numpy as np
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from fogkit.calibration.navigation_based import turn_model
from fogkit.rotation import dcm_from_rotvec
from fogkit.stand.turn_tests import nine_tests
from fogkit.units import ARCSEC, DEG

STATE = [turn_model.FULL_PARAMETERS.index(name) for name in turn_model.PARAMETERS]
ROUNDING = 1e-12  # matrices of ones and of angles up to 35 rad, a few products deep
DIFFERENCES = 1e-6  # central differences, `turn_model._STEP`


def random_tests(count, seed):
    """Any attitude, any axis in the body, up to six turns of either sign: nothing of the plan is in them."""
    rng = np.random.default_rng(seed)
    axes = rng.normal(size=(count, 3))
    return (
        Rotation.random(count, rng=rng).as_matrix(),
        axes / np.linalg.norm(axes, axis=1, keepdims=True),
        rng.uniform(-12 * np.pi, 12 * np.pi, count),
    )


def test_integral_of_a_turn_against_quadrature():
    (axis,), (angle,) = random_tests(1, 1)[1:]
    nodes, weights = np.polynomial.legendre.leggauss(200)  # 200 nodes for six periods: exact to rounding
    turned = dcm_from_rotvec(axis * (angle / 2 * (nodes + 1))[:, np.newaxis])
    expected = angle / 2 * np.einsum("p,pij->ij", weights, turned)
    assert_allclose(turn_model.turn_integral(axis, angle), expected, atol=ROUNDING)


def test_rows_are_the_derivatives_of_the_exact_slopes():
    # (14)-(19) against two navigated attitudes, with the accelerometers read at rest
    for C_b_n, axis, angle in zip(*random_tests(20, 2), strict=True):
        derivatives = turn_model.differentiated_rows(C_b_n, axis, angle, gravity=9.8)
        rows = turn_model.measurement_rows(C_b_n, axis, angle, gravity=9.8)
        assert_allclose(rows, derivatives[:, STATE], atol=10 * DIFFERENCES)


def test_scale_factor_error_of_the_gyro_tilts_test_1():
    # Turning too far about east lifts the computed north axis: gravity's reaction then shows towards south
    errors = np.zeros(21)
    errors[turn_model.FULL_PARAMETERS.index("m_g_11")] = 1 * ARCSEC
    first = nine_tests()[0]
    slopes = turn_model.slope_change(first.C_b_n, first.axis, first.angle, errors, gravity=9.8)
    assert_allclose(slopes, [0, -9.8 * (5 * 360 + 90) * DEG * ARCSEC], atol=1e-6 * ARCSEC)


def test_attitude_error_at_the_start_alone_changes_no_slope():
    # without Earth rate; the calibration is perfect
    for C_b_n, axis, angle in zip(*random_tests(5, 3), strict=True):
        slopes = turn_model.slope_change(C_b_n, axis, angle, np.zeros(21), gravity=9.8, start=[0.01, -0.02, 0.03])
        assert_allclose(slopes, 0, atol=1e3 * ROUNDING)


def test_the_plan_leaves_out_the_frame_and_the_accelerometer_scale_factors_and_nothing_else():
    plan = nine_tests()
    full = np.concatenate([turn_model.differentiated_rows(t.C_b_n, t.axis, t.angle) for t in plan])
    unseen = np.zeros((6, 21))
    unseen[[0, 1, 2], [0, 4, 8]] = 1  # accelerometer scale factors
    for i, turned in enumerate(np.cross(np.eye(3), np.eye(3)[:, np.newaxis, :])):  # both triads turned alike
        unseen[3 + i, :18] = np.tile(turned.ravel(), 2)
    assert_allclose(full @ unseen.T, 0, atol=DIFFERENCES * 10)
    assert np.linalg.matrix_rank(full, tol=1e-3) == 15
    assert np.linalg.matrix_rank(full[:, STATE], tol=1e-3) == 15


def test_a_test_and_its_twin_have_the_same_rows_at_any_attitude():
    C_b_n, axis, angle = random_tests(20, 4)
    after = C_b_n @ dcm_from_rotvec(axis * angle[:, np.newaxis])
    twins = turn_model.measurement_rows(np.diag([-1.0, -1.0, 1.0]) @ after, axis, -angle)
    assert_allclose(twins, turn_model.measurement_rows(C_b_n, axis, angle), atol=10 * ROUNDING)
