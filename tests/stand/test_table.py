"""The table against products of `scipy` rotations, and against its own turns."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from fogkit.constants import EARTH_RATE
from fogkit.stand.table import AXES, GEOMETRY, RateTable
from fogkit.units import ARCSEC, DEG

ROUNDING = 1e-14  # products of seven matrices of entries up to 1
angle = st.floats(-10, 10)
small = st.lists(st.floats(-0.3, 0.3), min_size=8, max_size=8)
TABLE = RateTable(
    latitude=60 * DEG,
    level_east=0.01,
    level_north=-0.02,
    azimuth_error=0.03,
    outer_middle=0.04,
    middle_inner=-0.05,
    mounting=(0.01, -0.02, 0.03),
)


@given(errors=small, outer=angle, middle=angle, inner=angle)
def test_attitude_is_the_product_of_the_rotations_from_base_to_case(errors, outer, middle, inner):
    table = RateTable(latitude=0.5).with_geometry(errors)
    expected = (
        Rotation.from_rotvec(errors[:3])
        * Rotation.from_euler("z", outer)
        * Rotation.from_euler("y", errors[3])
        * Rotation.from_euler("x", middle)
        * Rotation.from_euler("y", errors[4])
        * Rotation.from_euler("z", inner)
        * Rotation.from_rotvec(errors[5:])
    )
    assert_allclose(table.C_0_n(outer, middle, inner), expected.as_matrix(), atol=ROUNDING)


def test_limit_cases_of_the_ideal_table():
    table = RateTable(latitude=60 * DEG)
    east, north, up = np.eye(3)
    assert_allclose(table.C_0_n(0, 0, 0), np.eye(3), atol=ROUNDING)
    # columns are the axes of the case in east, north, up; each turn is counter-clockwise from the end of its axis
    assert_allclose(table.C_0_n(90 * DEG, 0, 0).T, [north, -east, up], atol=ROUNDING)
    assert_allclose(table.C_0_n(0, 90 * DEG, 0).T, [east, up, -north], atol=ROUNDING)
    assert_allclose(table.C_0_n(0, 0, -90 * DEG).T, [-north, east, up], atol=ROUNDING)


def test_earth_turns_about_its_pole():
    assert_allclose(RateTable(latitude=90 * DEG).omega_ie_n, [0, 0, EARTH_RATE], atol=1e-20)
    assert_allclose(RateTable(latitude=-30 * DEG).omega_ie_n[2], -EARTH_RATE / 2, rtol=1e-15)


@pytest.mark.parametrize("turning", AXES)
def test_a_turning_axis_stays_put_in_the_case_and_in_space(turning):
    middle, inner, turn = 0.7, -1.1, np.linspace(0, 6, 25)
    start = dict(zip(AXES, (0.4, middle, inner), strict=True))
    attitudes = TABLE.C_0_n(*(start[name] + turn * (name == turning) for name in AXES))
    step = Rotation.from_matrix(attitudes[0].T @ attitudes[1:]).as_rotvec()  # in axes of the case at the start
    axis = TABLE.axis_in_case(turning, middle, inner)
    # rotation vectors beyond half a turn come back the other way round
    along = np.cross(step, axis)
    assert_allclose(along, 0, atol=1e-13)
    assert_allclose(np.linalg.norm(axis), 1, rtol=1e-14)
    assert step[0] @ axis > 0
    in_space = attitudes @ axis
    assert_allclose(in_space, np.broadcast_to(in_space[0], in_space.shape), atol=ROUNDING)


@pytest.mark.parametrize("turning", AXES)
def test_axes_of_many_attitudes_are_those_of_each(turning):
    middle, inner = np.array([0.1, 0.7]), np.array([2.0, -1.0])
    each = [TABLE.axis_in_case(turning, m, i) for m, i in zip(middle, inner, strict=True)]
    assert_allclose(np.broadcast_to(TABLE.axis_in_case(turning, middle, inner), (2, 3)), each, atol=ROUNDING)


def test_geometry_comes_back_and_leaves_the_noise_alone():
    errors = np.arange(1, 9) * ARCSEC
    table = RateTable(latitude=0.5, readout_noise=1e-5, azimuth_error=1.0e-3).with_geometry(errors)
    assert_allclose(table.geometry, errors, rtol=0)
    assert table.readout_noise == 1e-5
    assert len(GEOMETRY) == 8


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("latitude", 60.0),  # degrees given for radians
        ("latitude", np.nan),
        ("level_east", 1.0),
        ("azimuth_error", np.inf),
        ("mounting", (0.0, 0.0)),
        ("mounting", (0.0, np.nan, 0.0)),
        ("readout_noise", -1.0),
        ("latch_time_error", np.inf),
        ("rate_stability", -1e-6),
    ],
)
def test_impossible_tables_are_refused_by_name(name, value):
    with pytest.raises(ValueError, match=f"`{name}`"):
        RateTable(**({"latitude": 0.5} | {name: value}))


def test_bad_arguments_are_refused_by_name():
    with pytest.raises(ValueError, match=r"`turning`.*'outer', 'middle', 'inner'"):
        TABLE.axis_in_case("upper", 0, 0)
    with pytest.raises(ValueError, match="`errors`"):
        TABLE.with_geometry(np.zeros(7))
