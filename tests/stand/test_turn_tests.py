"""Tests of dwell, turn, dwell: geometry against letters written by hand, and the plan of the nine tests."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.reproduction.klimkovich import plan_search
from fogkit.stand import TurnTest, nine_tests, turn_tests
from fogkit.stand.placements import attitude
from fogkit.units import DEG


def test_nine_tests_are_the_plan_that_the_search_recovers():
    assert [test.letters for test in nine_tests()] == [(turn.start, turn.end) for turn in plan_search.recovered_plan()]
    for test, turn in zip(nine_tests(), plan_search.recovered_plan(), strict=True):
        assert_allclose(test.axis, turn.direction)
        assert_allclose(test.angle, turn.angle, rtol=1e-15)  # rounding


def test_axes_of_the_nine_turns_lie_level_and_blocks_are_chained():
    plan = nine_tests(turns=2)
    assert_allclose([(test.C_b_n @ test.axis)[2] for test in plan], 0, atol=1e-15)
    for block in (plan[:3], plan[3:6], plan[6:]):
        for one, other in zip(block, (*block[1:], block[0]), strict=True):
            assert_allclose(one.C_b_n_end, other.C_b_n, atol=1e-13)  # rounding of 15 rad


def test_a_quarter_turn_about_x_takes_y_up():
    test = TurnTest.from_letters("ENU", "x", 90 * DEG)
    assert test.letters == ("ENU", "EUS")
    assert_allclose(test.C_b_n_end @ [0, 1, 0], [0, 0, 1], atol=1e-15)


def test_times():
    test = TurnTest.from_letters("ENU", "x", 1.0, dwell=3, turn_duration=4, dwell_after=5)
    assert test.duration == 12
    assert test.dwells == ((0, 3), (7, 12))
    assert nine_tests()[0].duration == 35


def test_directions_of_no_cube_have_no_letter():
    assert TurnTest.from_letters("ENU", "x", 1.0).letters == ("ENU", "E..")


def test_equal_tests_are_one_in_a_set():
    assert len({*nine_tests(), *nine_tests()}) == 9
    assert nine_tests()[0] != nine_tests(turns=4)[0]


def test_table_for_the_operator():
    table = turn_tests.to_frame((*nine_tests(), turn_tests.bias_test()))
    assert table.loc["1", ["start", "end", "axis"]].tolist() == ["ENU", "EUS", "x"]
    assert_allclose(table.loc["2", "rate_deg_s"], 1980 / 15)
    assert table.loc["bias", "dwell_s"] == 180


def test_the_axis_is_brought_to_unit_length_and_cannot_be_edited():
    test = TurnTest(label="a", C_b_n=np.eye(3), axis=(0, 3, 4), angle=1.0)
    assert_allclose(test.axis, (0, 0.6, 0.8), rtol=1e-15)
    with pytest.raises(ValueError, match="read-only"):
        test.axis[0] = 1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"axis": (0, 0, 0)}, "`axis` must have a direction"),
        ({"angle": 0.0}, "`angle` must not be 0"),
        ({"angle": 1890.0}, "`angle` must be .*Multiply degrees"),
        ({"C_b_n": 2 * np.eye(3)}, "`C_b_n`"),
        ({"dwell": 0.0}, "`dwell` must be finite and > 0 s"),
        ({"turn_duration": -1.0}, "`turn_duration` must be finite and > 0 s"),
        ({"label": ""}, "`label` must be"),
    ],
)
def test_what_cannot_be_is_refused(change, message):
    with pytest.raises(ValueError, match=message):
        TurnTest(**{"label": "a", "C_b_n": attitude("ENU"), "axis": (1, 0, 0), "angle": 1.0} | change)


def test_unknown_axis_is_refused():
    with pytest.raises(ValueError, match="`axis`"):
        TurnTest.from_letters("ENU", "w", 1.0)


def test_negative_turns_are_refused():
    with pytest.raises(ValueError, match="`turns`"):
        nine_tests(turns=-1)
