"""The linear model against numbers worked by hand, its forms there and back, and its errors."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from laboratories import random_triad
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from fogkit.imu.triads import LinearTriad

SEEDS = st.integers(0, 2**32 - 1)
EPS = np.finfo(float).eps

BY_HAND = LinearTriad(bias=(1, 2, 3), matrix=((3, 4, 0), (0, 2, 0), (-1, 2, -2)))


def test_forms_by_hand():
    # rows of lengths 5, 2, 3, so every quotient is short: equal to the last bit or nearly
    assert_allclose(BY_HAND.equivalents, [5, 2, 3], rtol=2 * EPS)
    assert_allclose(BY_HAND.cosines, [[0.6, 0.8, 0], [0, 1, 0], [-1 / 3, 2 / 3, -2 / 3]], rtol=2 * EPS)
    assert_array_equal(BY_HAND.scale_factor, [3, 2, -2])
    assert_allclose(BY_HAND.misalignment, [[0, 4 / 3, 0], [0, 0, 0], [0.5, -1, 0]], rtol=4 * EPS)
    assert_allclose(BY_HAND.input_bias, [1 / 3, 1, -1.5], rtol=2 * EPS)
    assert_allclose(BY_HAND.scale_factor_error([2.5, 2, -1]), [0.2, 0, 1], rtol=4 * EPS)


def test_readings_by_hand():
    assert_array_equal(BY_HAND.readings([[1, 0, 0], [0, 1, 1]]), [[4, 2, 2], [5, 4, 3]])
    mechanical = LinearTriad(acceleration_sensitivity=[[0, 0, 2], [0, 0, 0], [1, 0, 0]])
    assert_array_equal(mechanical.readings([5, 6, 7], [10, 20, 30]), [65, 6, 17])


def test_an_ideal_triad_reads_its_input():
    assert_array_equal(LinearTriad().readings([1.5, -2.5, 3.5]), [1.5, -2.5, 3.5])


def test_the_scale_factor_is_the_callers_own():
    scale = BY_HAND.scale_factor
    scale[0] = 99
    assert BY_HAND.matrix[0][0] == 3


@given(SEEDS)
def test_slides_form_there_and_back(seed):
    triad = random_triad(np.random.default_rng(seed), 1e5, 1e-6, 1e-6)
    back = LinearTriad.from_equivalents(triad.bias, triad.equivalents, triad.cosines, triad.acceleration_sensitivity)
    # a quotient and a product, on entries whose row has the size of its equivalent
    assert (np.abs(np.subtract(back.matrix, triad.matrix)) <= 4 * EPS * triad.equivalents[:, None]).all()
    assert_array_equal(back.bias, triad.bias)
    assert_array_equal(back.acceleration_sensitivity, triad.acceleration_sensitivity)


@given(SEEDS)
def test_standard_form_there_and_back(seed):
    triad = random_triad(np.random.default_rng(seed), 1e5, 1e-6, 1e-6)
    back = LinearTriad.from_standard(
        scale_factor=triad.scale_factor,
        input_bias=triad.input_bias,
        misalignment=triad.misalignment,
        acceleration_sensitivity=triad.acceleration_sensitivity,
    )
    assert (np.abs(np.subtract(back.matrix, triad.matrix)) <= 4 * EPS * triad.equivalents[:, None]).all()
    assert_allclose(back.bias, triad.bias, rtol=4 * EPS)  # a quotient and a product
    assert_array_equal(back.acceleration_sensitivity, triad.acceleration_sensitivity)


@given(SEEDS)
def test_both_forms_describe_the_same_sensor(seed):
    triad = random_triad(np.random.default_rng(seed), 1e5, 1e-6)
    # small angles apart, a misalignment is the tangent of what the cosines say
    own = np.diagonal(triad.cosines)
    assert_allclose(triad.cosines / own[:, None] - np.eye(3), triad.misalignment, atol=8 * EPS)  # of numbers about 1
    assert_allclose(np.abs(triad.scale_factor), triad.equivalents * np.abs(own), rtol=8 * EPS)


@given(SEEDS)
def test_correction_inverts_readings(seed):
    rng = np.random.default_rng(seed)
    triad = random_triad(rng, 10.0 ** rng.uniform(-3, 6), 0.1, sensitivity=0.1)
    inputs, force = rng.uniform(-1, 1, (2, 4, 5, 3))
    # rounding times the condition of the matrix, below 4 * 1.5, and a few operations; the inputs are of size 1
    assert_allclose(triad.correct(triad.readings(inputs, force), force), inputs, atol=200 * EPS)


@given(SEEDS)
def test_turned_sensors_read_the_same_of_the_same_world(seed):
    rng = np.random.default_rng(seed)
    triad = random_triad(rng, 1.0, 0.1, sensitivity=0.1)
    turn = Rotation.random(random_state=seed)
    rate_b2, force_b2 = rng.uniform(-1, 1, (2, 7, 3))
    turned = triad.turned(turn.as_matrix())
    # the world in the first axes, by another implementation; sums of six products of size 2
    same = triad.readings(turn.apply(rate_b2), turn.apply(force_b2))
    assert_allclose(turned.readings(rate_b2, force_b2), same, atol=50 * EPS)
    assert_allclose(turned.equivalents, triad.equivalents, rtol=20 * EPS)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: LinearTriad(bias=(1, 2)), r"`bias` must be .*\(3,\)"),
        (lambda: LinearTriad(bias=(1, 2, np.nan)), "`bias`"),
        (lambda: LinearTriad(matrix=np.eye(2)), r"`matrix` must be .*\(3, 3\)"),
        (lambda: LinearTriad(matrix=np.diag([1, 0, 1])), "`matrix` must have no row of zeros"),
        (lambda: LinearTriad(acceleration_sensitivity=np.zeros(3)), "`acceleration_sensitivity`"),
        (lambda: LinearTriad.from_equivalents(np.zeros(3), [1, -1, 1], np.eye(3)), "`equivalents` must be > 0"),
        (lambda: LinearTriad.from_equivalents(np.zeros(3), np.ones(3), 1.001 * np.eye(3)), "`cosines` must have unit"),
        (lambda: LinearTriad.from_standard(scale_factor=[1, 0, 1]), "`matrix` must have no row of zeros"),
        (
            lambda: LinearTriad.from_standard(scale_factor=np.ones(3), misalignment=np.eye(3)),
            "`misalignment` must be 0",
        ),
        (lambda: BY_HAND.readings([1, 2]), "`inputs`"),
        (lambda: BY_HAND.correct([1, 2]), "`readings`"),
        (lambda: BY_HAND.turned(2 * np.eye(3)), "`C_b_b2`"),
        (lambda: BY_HAND.scale_factor_error([1, np.inf, 1]), "`nominal`"),
        (
            lambda: LinearTriad(acceleration_sensitivity=np.eye(3)).readings(np.ones(3)),
            "`specific_force` must be given",
        ),
        (lambda: LinearTriad(acceleration_sensitivity=np.eye(3)).correct(np.ones(3)), "`specific_force` must be given"),
    ],
)
def test_errors_name_the_argument(make, message):
    with pytest.raises(ValueError, match=message):
        make()
