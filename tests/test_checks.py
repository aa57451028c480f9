"""The checks accept what they should, convert it, and word their errors: which argument, what was needed, what came."""

from fractions import Fraction

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from fogkit import checks

SCALAR_CHECKS = [
    checks.positive,
    checks.non_negative,
    lambda name, value, **kw: checks.in_open_interval(name, value, 0, 10, **kw),
    lambda name, value, **kw: checks.in_closed_interval(name, value, 0, 10, **kw),
]


@pytest.mark.parametrize("check", SCALAR_CHECKS)
@pytest.mark.parametrize("value", [2, 2.0, np.float32(2), np.int64(2), np.array(2), Fraction(2)])
def test_scalar_is_returned_as_a_float(check, value):
    checked = check("x", value)
    assert type(checked) is float
    assert checked == 2.0


@pytest.mark.parametrize("check", [*SCALAR_CHECKS, checks.integer])
@pytest.mark.parametrize("value", [True, np.True_, np.array(True), "2", None, 2j, [2], np.array([2.0])])
def test_what_is_no_real_number_is_a_type_error(check, value):
    with pytest.raises(TypeError, match=r"^`x` must be a"):
        check("x", value)


@pytest.mark.parametrize("check", SCALAR_CHECKS)
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, -1e-300])
def test_scalar_out_of_range_is_a_value_error(check, value):
    with pytest.raises(ValueError, match=f"^`x` must be .*, got {value}$"):
        check("x", value)


def test_limits_of_the_ranges():
    assert checks.non_negative("x", 0) == 0.0
    assert checks.in_closed_interval("x", 0, 0, 1) == 0.0
    assert checks.in_closed_interval("x", 1, 0, 1) == 1.0
    assert checks.in_open_interval("x", 5e-324, 0, np.inf) == 5e-324
    for check in (checks.positive, lambda name, value: checks.in_open_interval(name, value, 0, 1)):
        with pytest.raises(ValueError, match=r"got 0\.0$"):
            check("x", 0)
    with pytest.raises(ValueError, match=r"got 1\.0$"):
        checks.in_open_interval("x", 1, 0, 1)
    with pytest.raises(ValueError, match=r"got inf$"):  # an unbounded range still holds numbers only
        checks.in_closed_interval("x", np.inf, 0, np.inf)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: checks.positive("length", -3, "m"), "`length` must be finite and > 0 m, got -3.0"),
        (lambda: checks.non_negative("noise", -3), "`noise` must be finite and >= 0, got -3.0"),
        (lambda: checks.positive("x", "3"), "`x` must be a real number, got '3'"),
        (
            lambda: checks.in_open_interval("lat", 2, -1.5, 1.5, "rad", fix="Give radians."),
            "`lat` must be in the open interval (-1.5, 1.5) rad, got 2.0. Give radians.",
        ),
        (lambda: checks.in_closed_interval("duty", 2, 0, 1), "`duty` must be in [0.0, 1.0], got 2.0"),
        (lambda: checks.integer("n", 2.5), "`n` must be an integer, got 2.5"),
        (lambda: checks.integer("n", 0, minimum=1), "`n` must be an integer >= 1, got 0"),
        (lambda: checks.integer("n", 3, minimum=2, even=True), "`n` must be an even integer >= 2, got 3"),
        (lambda: checks.integer("n", True), "`n` must be an integer, got True"),
        (lambda: checks.finite_array("a", []), "`a` must be non-empty, got shape (0,)"),
        (lambda: checks.finite_array("a", [1, 2], min_size=3), "`a` must be of at least 3 entries, got shape (2,)"),
        (lambda: checks.finite_array("a", [1, 2], ndim=2), "`a` must be an array with ndim 2, got shape (2,)"),
        (lambda: checks.finite_array("a", [1, 2], (..., 3)), "`a` must be of shape (..., 3), got (2,)"),
        (lambda: checks.finite_array("a", [1, 2, 3], (None, 3)), "`a` must be of shape (n, 3), got (3,)"),
        (lambda: checks.finite_array("a", [[1]], (None,)), "`a` must be of shape (n,), got (1, 1)"),
        (lambda: checks.finite_array("a", np.nan), "`a` must be finite, got nan"),
        (
            lambda: checks.finite_array("a", [[0, 1], [np.inf, np.nan]]),
            "`a` must be finite, got inf at index (1, 0), one of 2 such entries of 4",
        ),
        (
            lambda: checks.finite_array("a", [[1, 2], [3]]),
            "`a` must be a rectangular array, got rows of different lengths",
        ),
        (lambda: checks.finite_array("a", [1j]), "`a` must be an array of real numbers, got dtype complex128"),
        (
            lambda: checks.array_in_closed_interval("a", [0, -2, 3], -1, 1, "rad", fix="Give radians."),
            "`a` must be in [-1.0, 1.0] rad, got -2.0 at index (1,), one of 2 such entries of 3. Give radians.",
        ),
        (lambda: checks.option("kind", "c", ("a", "b")), "`kind` must be one of 'a', 'b', got 'c'"),
        (lambda: checks.option("kind", 1, ("a", "b")), "`kind` must be one of 'a', 'b', got 1"),
        (
            lambda: checks.rotation_matrix("C_b_n", 1.001 * np.eye(3)),
            "`C_b_n` must be orthonormal, |C C^T - I| <= 1e-06, got 0.002. "
            "`fogkit.rotation.orthonormalise` gives the nearest rotation.",
        ),
        (
            lambda: checks.rotation_matrix("C_b_n", -np.eye(3)),
            "`C_b_n` must be a rotation (determinant +1), got a reflection. Are both sets of axes right-handed?",
        ),
        (
            lambda: checks.generator("rng", np.random.RandomState(0)),
            "`rng` must be a numpy.random.Generator, got RandomState. Make one with `np.random.default_rng(seed)`.",
        ),
        (lambda: checks.columns(np.zeros(3), ["a"]), "`table` must be a pandas DataFrame, got ndarray"),
        (
            lambda: checks.columns(pd.DataFrame(), ["a"], fix="See IMU_COLUMNS."),
            "`table` must be a table with the columns 'a', got one with none, so without 'a'. See IMU_COLUMNS.",
        ),
    ],
)
def test_message(call, message):
    with pytest.raises((TypeError, ValueError)) as caught:
        call()
    assert str(caught.value) == message


@pytest.mark.parametrize("value", [4, 4.0, np.int8(4), np.float32(4), np.array(4)])
def test_integer_is_returned_as_an_int(value):
    checked = checks.integer("n", value, minimum=4, even=True)
    assert type(checked) is int
    assert checked == 4


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_integer_is_finite(value):
    with pytest.raises(ValueError, match="must be an integer"):
        checks.integer("n", value)


@pytest.mark.parametrize(
    "value", [3, [1, 2], (1.5, 2), np.arange(3, dtype=np.int16), pd.Series([1, 2]), pd.DataFrame({"a": [1.0]})]
)
def test_array_keeps_values_and_shape(value):
    checked = checks.finite_array("a", value)
    assert checked.dtype == np.float64
    assert checked.shape == np.shape(value)
    np.testing.assert_array_equal(checked, np.asarray(value))


def test_array_is_not_copied():
    a = np.arange(3.0)
    assert checks.finite_array("a", a) is a


@pytest.mark.parametrize(
    "value", ["1", ["1", "2"], [None, 1.0], [True, False], [{}], np.array(["2020"], "datetime64[Y]")]
)
def test_array_of_what_is_no_real_number_is_a_type_error(value):
    with pytest.raises(TypeError, match=r"^`a` must be an array of real numbers"):
        checks.finite_array("a", value)


SHAPES = [
    ((), (...,), True),
    ((), (..., 3), False),
    ((3,), (..., 3), True),
    ((5, 2, 3), (..., 3), True),
    ((5, 2), (..., 3), False),
    ((3,), (None, 3), False),
    ((5, 3), (None, 3), True),
    ((2, 5, 3), (None, 3), False),
    ((3, 3), (..., 3, 3), True),
    ((3,), (..., 3, 3), False),
    ((4, 3, 3), (3, 3), False),
    ((2, 7, 8, 3), (2, ..., 3), True),
    ((1, 7, 3), (2, ..., 3), False),
    ((2, 3), (2, ..., 3), True),
    ((3,), (3, ..., 3), False),  # one axis cannot serve as the first and as the last
]


@pytest.mark.parametrize(("shape", "wanted", "fits"), SHAPES)
def test_shape_patterns(shape, wanted, fits):
    if fits:
        assert checks.finite_array("a", np.zeros(shape), wanted).shape == shape
    else:
        with pytest.raises(ValueError, match="must be of shape"):
            checks.finite_array("a", np.zeros(shape), wanted)


@given(
    shape=st.lists(st.integers(1, 3), max_size=3).map(tuple),
    before=st.lists(st.integers(1, 3), max_size=2).map(tuple),
    after=st.lists(st.integers(1, 3), max_size=2).map(tuple),
)
@settings(deadline=None)  # the first call of a run pays for imports
def test_ellipsis_stands_for_any_axes(shape, before, after):
    value = np.zeros(before + shape + after)
    assert checks.finite_array("a", value, (*before, ..., *after)) is value


def test_empty_array_can_be_allowed():
    assert checks.finite_array("a", np.zeros((0, 3)), shape=(None, 3), min_size=0).shape == (0, 3)


def test_ends_of_an_array_interval_are_inside():
    np.testing.assert_array_equal(checks.array_in_closed_interval("a", [-1, 1], -1, 1), [-1, 1])


def test_option_is_returned():
    assert checks.option("kind", "a", iter(["a", "b"])) == "a"
    with pytest.raises(TypeError, match="`kind`"):
        checks.option("kind", None, ("a",))


def test_rotations_pass_and_their_neighbours_do_not():
    C = Rotation.random(50, rng=np.random.default_rng(1)).as_matrix()
    np.testing.assert_array_equal(checks.rotation_matrix("C", C.reshape(10, 5, 3, 3)), C.reshape(10, 5, 3, 3))
    C[17, 1, 2] += 1e-5  # ten times the tolerance, in one matrix of the stack
    with pytest.raises(ValueError, match="orthonormal"):
        checks.rotation_matrix("C", C)
    checks.rotation_matrix("C", C, tolerance=1e-4)
    C[17] = -Rotation.identity().as_matrix()
    with pytest.raises(ValueError, match="reflection"):
        checks.rotation_matrix("C", C)


def test_rotation_rounded_to_four_digits_is_refused():
    C = Rotation.from_rotvec([0.1, 0.2, 0.3]).as_matrix().round(4)
    with pytest.raises(ValueError, match="orthonormalise"):
        checks.rotation_matrix("C", C)


def test_generator_is_returned():
    rng = np.random.default_rng(0)
    assert checks.generator("rng", rng) is rng


@pytest.mark.parametrize("value", [None, 0, np.random, np.random.default_rng])
def test_only_a_generator_is_one(value):
    with pytest.raises(TypeError, match="default_rng"):
        checks.generator("rng", value)


def test_table_with_its_columns_is_returned():
    table = pd.DataFrame({"a": [1.0], "b": [2.0], "c": [3.0]})
    assert checks.columns(table, ["c", "a"]) is table
    with pytest.raises(ValueError, match=r"`imu` .* so without 'd', 'e'$"):
        checks.columns(table, ["a", "d", "e"], name="imu")
