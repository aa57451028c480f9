"""Rotations against hand-made attitudes, the matrix exponential and the laws of the group."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from fogkit import rotation

EPS = np.finfo(float).eps
# Rounding of a few products of 3x3 rotations.
ROUNDING = 20 * EPS

vectors = arrays(np.float64, 3, elements=st.floats(-1e3, 1e3))
angles = st.floats(-np.pi, np.pi)
# The first call of a run pays for imports.
unhurried = settings(deadline=None)


@pytest.fixture
def rng():
    return np.random.default_rng(20240611)


@pytest.fixture
def attitudes(rng):
    return Rotation.random(60, rng=rng).as_matrix().reshape(5, 12, 3, 3)


def turn(axis, angle):
    """Rotation about one axis, written out: the truth for products of them."""
    c, s = np.cos(angle), np.sin(angle)
    i, j, k = axis, (axis + 1) % 3, (axis + 2) % 3
    C = np.zeros((3, 3))
    C[i, i], C[j, j], C[k, k], C[k, j], C[j, k] = 1, c, c, s, -s
    return C


@given(vectors, vectors)
@unhurried
def test_skew_is_the_cross_product(a, b):
    # Products of two numbers up to 1e3, two roundings each.
    assert_allclose(rotation.skew(a) @ b, np.cross(a, b), rtol=0, atol=4 * EPS * 1e6)


@given(vectors)
@unhurried
def test_vector_inverts_skew(v):
    np.testing.assert_array_equal(rotation.vector(rotation.skew(v)), v)
    np.testing.assert_array_equal(rotation.skew(v).T, -rotation.skew(v))


def test_vector_refuses_what_is_not_skew():
    Omega = rotation.skew([1e-6, 2e-6, 3e-6])
    rotation.vector(Omega + 1e-16)
    with pytest.raises(ValueError, match=r"`Omega` must be skew .* 3\.33e-08"):  # relative: 1e-13 over 3e-6
        rotation.vector(Omega + 1e-13 * np.eye(3))
    with pytest.raises(ValueError, match="small_angle_between"):
        rotation.vector(turn(0, 1e-3) - np.eye(3))


@given(arrays(np.float64, 3, elements=st.floats(-10, 10)))
@unhurried
def test_dcm_is_the_exponential_of_the_skew_matrix(v):
    with mp.workdps(30):  # the exponential in double precision is the less accurate of the two
        exponential = np.array(mp.expm(mp.matrix(rotation.skew(v).tolist())).tolist(), dtype=float)
    # The angle itself is rounded: EPS times 17 rad at most.
    assert_allclose(rotation.dcm_from_rotvec(v), exponential, rtol=0, atol=ROUNDING + 2 * EPS * np.linalg.norm(v))


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("angle", [-2.0, 1e-9, 0.7, np.pi])
def test_dcm_of_a_turn_about_one_axis(axis, angle):
    assert_allclose(rotation.dcm_from_rotvec(angle * np.eye(3)[axis]), turn(axis, angle), rtol=0, atol=ROUNDING)


@given(arrays(np.float64, 3, elements=st.floats(-1, 1)), st.floats(0, np.pi - 1e-6))
@unhurried
def test_rotvec_inverts_dcm(direction, angle):
    norm = np.linalg.norm(direction)
    v = angle * direction / norm if norm > 1e-3 else np.zeros(3)
    C = rotation.dcm_from_rotvec(v)
    assert_allclose(C @ C.T, np.eye(3), rtol=0, atol=ROUNDING)
    assert_allclose(rotation.rotvec_from_dcm(C), v, rtol=0, atol=ROUNDING)


def test_a_microarcsecond_survives():
    # The quaternion in between keeps small angles: nothing is subtracted from the one on the diagonal.
    v = np.array([1.0, -2.0, 3.0]) * 5e-12
    assert_allclose(rotation.rotvec_from_dcm(rotation.dcm_from_rotvec(v)), v, rtol=4 * EPS)


def test_half_turn_has_either_sign():
    v = rotation.rotvec_from_dcm(turn(2, np.pi))
    assert_allclose(np.abs(v), [0, 0, np.pi], rtol=0, atol=ROUNDING)


def test_rotvec_refuses_what_is_no_rotation():
    with pytest.raises(ValueError, match="`C` must be orthonormal"):
        rotation.rotvec_from_dcm(1.01 * np.eye(3))


EAST, NORTH, UP = np.eye(3)
RIGHT, FORWARD, TOP = np.eye(3)  # in body axes


@pytest.mark.parametrize(
    ("heading", "pitch", "roll", "axis", "direction"),
    [
        (0, 0, 0, FORWARD, NORTH),
        (0, 0, 0, RIGHT, EAST),
        (0, 0, 0, TOP, UP),
        (90, 0, 0, FORWARD, EAST),
        (90, 0, 0, RIGHT, -NORTH),
        (180, 0, 0, FORWARD, -NORTH),
        (-90, 0, 0, FORWARD, -EAST),
        (45, 0, 0, FORWARD, (EAST + NORTH) / np.sqrt(2)),
        (0, 90, 0, FORWARD, UP),  # nose up
        (0, 90, 0, TOP, -NORTH),
        (90, 30, 0, FORWARD, np.sqrt(3) / 2 * EAST + UP / 2),
        (0, 0, 90, RIGHT, -UP),  # right side down
        (0, 0, 90, TOP, EAST),
        (180, 0, 30, RIGHT, -np.sqrt(3) / 2 * EAST - UP / 2),
        (0, 90, 90, RIGHT, NORTH),  # pitched first, then rolled about the forward axis that points up
    ],
)
def test_attitudes_one_can_picture(heading, pitch, roll, axis, direction):
    C_b_n = rotation.dcm_from_heading_pitch_roll(*np.deg2rad([heading, pitch, roll]))
    assert_allclose(C_b_n @ axis, direction, rtol=0, atol=ROUNDING)


@given(angles, angles, angles)
@unhurried
def test_attitude_is_the_product_of_its_turns(heading, pitch, roll):
    product = turn(2, -heading) @ turn(0, pitch) @ turn(1, roll)
    C_b_n = rotation.dcm_from_heading_pitch_roll(heading, pitch, roll)
    assert_allclose(C_b_n, product, rtol=0, atol=ROUNDING)
    assert_allclose(C_b_n @ C_b_n.T, np.eye(3), rtol=0, atol=ROUNDING)


@given(angles, st.floats(-1.57, 1.57), angles)
@unhurried
def test_angles_come_back(heading, pitch, roll):
    C_b_n = rotation.dcm_from_heading_pitch_roll(heading, pitch, roll)
    back = rotation.heading_pitch_roll_from_dcm(C_b_n)
    # Heading and roll lose 1 / cos(pitch), 1256 at most; angles of -pi and pi are the same.
    difference = np.array(back) - [heading, pitch, roll]
    assert_allclose(np.sin(difference / 2), 0, atol=ROUNDING / np.cos(pitch))


def test_angles_have_their_ranges(attitudes):
    heading, pitch, roll = rotation.heading_pitch_roll_from_dcm(attitudes)
    assert np.abs(heading).max() <= np.pi
    assert np.abs(pitch).max() <= np.pi / 2
    assert np.abs(roll).max() <= np.pi


@pytest.mark.parametrize("pitch", [-np.pi / 2, np.pi / 2])
def test_vertical_forward_axis_warns_and_keeps_the_attitude(pitch):
    C_b_n = rotation.dcm_from_heading_pitch_roll(0.3, pitch, 0.2)
    with pytest.warns(UserWarning, match="Gimbal lock"):
        heading, back, roll = rotation.heading_pitch_roll_from_dcm(C_b_n)
    assert roll == 0
    # SciPy calls it gimbal lock within 1e-7 rad, so that is what the angles can be wrong by.
    assert_allclose(rotation.dcm_from_heading_pitch_roll(heading, back, roll), C_b_n, rtol=0, atol=1e-7)


def test_nearest_rotation_is_the_polar_factor(rng):
    # C = R S with S symmetric and positive definite determines R; no decomposition is repeated here.
    C = Rotation.random(200, rng=rng).as_matrix() + 0.1 * rng.standard_normal((200, 3, 3))
    R = rotation.orthonormalise(C)
    S = np.swapaxes(R, -1, -2) @ C
    atol = 100 * EPS  # LAPACK's iterations leave some tens of EPS in the singular vectors
    assert_allclose(S, np.swapaxes(S, -1, -2), rtol=0, atol=atol)
    assert np.linalg.eigvalsh(S).min() > 0
    assert_allclose(R @ np.swapaxes(R, -1, -2), np.broadcast_to(np.eye(3), R.shape), rtol=0, atol=atol)
    assert_allclose(np.linalg.det(R), 1, rtol=atol)


def test_rotation_is_its_own_nearest(attitudes):
    assert_allclose(rotation.orthonormalise(attitudes), attitudes, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize(("C", "words"), [(np.diag([1, 1, 0.0]), "regular"), (np.diag([1, 1, -1.0]), "right-handed")])
def test_no_rotation_is_nearest(C, words):
    with pytest.raises(ValueError, match=words):
        rotation.orthonormalise(np.stack([np.eye(3), C]))


def test_attitude_error_has_the_sign_of_the_convention(rng):
    # (I - skew(psi_n)) @ C_b_n is the estimate up to psi^2 / 2: ten times smaller angles, a hundred times smaller rest.
    C_b_n = Rotation.random(rng=rng).as_matrix()
    direction = rng.standard_normal(3)
    rest = []
    for size in (1e-3, 1e-4):
        C_b_n_est = rotation.orthonormalise((np.eye(3) - rotation.skew(size * direction)) @ C_b_n)
        psi_n = rotation.small_angle_between(C_b_n_est, C_b_n)
        assert_allclose(psi_n, size * direction, rtol=0, atol=(size * np.linalg.norm(direction)) ** 2)
        rest.append(np.linalg.norm((np.eye(3) - rotation.skew(psi_n)) @ C_b_n - C_b_n_est))
    assert_allclose(np.log10(rest[0] / rest[1]), 2, atol=0.01)  # next order: 1e-3 of the ratio, 4e-4 of its logarithm


def test_turning_by_the_attitude_error_makes_true(attitudes, rng):
    C_b_n_est = Rotation.random(60, rng=rng).as_matrix().reshape(attitudes.shape)
    psi_n = rotation.small_angle_between(C_b_n_est, attitudes)
    assert_allclose(rotation.dcm_from_rotvec(psi_n) @ C_b_n_est, attitudes, rtol=0, atol=ROUNDING)
    assert_allclose(rotation.small_angle_between(attitudes, attitudes), 0, atol=ROUNDING)


@pytest.mark.parametrize(
    ("function", "shapes"),
    [
        (rotation.skew, [(3,)]),
        (rotation.dcm_from_rotvec, [(3,)]),
        (rotation.dcm_from_heading_pitch_roll, [(), (), ()]),
        (lambda v: rotation.vector(rotation.skew(v)), [(3,)]),
        (lambda v: rotation.rotvec_from_dcm(rotation.dcm_from_rotvec(v)), [(3,)]),
        (lambda v: np.stack(rotation.heading_pitch_roll_from_dcm(rotation.dcm_from_rotvec(v)), axis=-1), [(3,)]),
        (lambda v: rotation.orthonormalise(rotation.dcm_from_rotvec(v) + 0.01), [(3,)]),
        (lambda v, w: rotation.small_angle_between(*map(rotation.dcm_from_rotvec, (v, w))), [(3,), (3,)]),
    ],
)
def test_leading_axes_are_a_loop(function, shapes, rng):
    stacks = [rng.uniform(-1, 1, (4, 2, *shape)) for shape in shapes]
    together = function(*stacks)
    for i, j in np.ndindex(4, 2):
        # SciPy may take the stack in another order of operations.
        assert_allclose(together[i, j], function(*(stack[i, j] for stack in stacks)), rtol=0, atol=ROUNDING)


def test_angles_broadcast():
    assert rotation.dcm_from_heading_pitch_roll(np.zeros((4, 1)), np.zeros(5), 0.0).shape == (4, 5, 3, 3)
    with pytest.raises(ValueError, match="shape mismatch"):
        rotation.dcm_from_heading_pitch_roll(np.zeros(4), np.zeros(5), 0.0)


def test_takes_arrays_that_cannot_be_written_to():
    rotvec = np.array([0.1, 0.2, 0.3])
    rotvec.setflags(write=False)
    assert_allclose(rotation.dcm_from_rotvec(rotvec) @ rotvec, rotvec, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: rotation.skew([1.0, 2.0]), "v"),
        (lambda: rotation.vector(np.eye(2)), "Omega"),
        (lambda: rotation.dcm_from_rotvec(1.0), "rotvec"),
        (lambda: rotation.dcm_from_heading_pitch_roll(np.nan, 0, 0), "heading"),
        (lambda: rotation.dcm_from_heading_pitch_roll(0, np.inf, 0), "pitch"),
        (lambda: rotation.dcm_from_heading_pitch_roll(0, 0, []), "roll"),
        (lambda: rotation.heading_pitch_roll_from_dcm(-np.eye(3)), "C_b_n"),
        (lambda: rotation.orthonormalise([1.0, 2.0, 3.0]), "C"),
        (lambda: rotation.small_angle_between(2 * np.eye(3), np.eye(3)), "C_b_n_est"),
        (lambda: rotation.small_angle_between(np.eye(3), 2 * np.eye(3)), "C_b_n"),
    ],
)
def test_error_names_the_argument(call, name):
    with pytest.raises(ValueError, match=f"^`{name}` must be"):
        call()


def test_rotation_vectors_that_cannot_be_written_to_are_taken():
    kept = np.array([0.1, -0.2, 0.3])
    kept.setflags(write=False)
    assert_allclose(rotation.dcm_from_rotvec(kept), Rotation.from_rotvec([0.1, -0.2, 0.3]).as_matrix(), rtol=0)
