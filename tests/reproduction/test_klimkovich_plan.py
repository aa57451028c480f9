"""The recovered plan of the nine tests: what the search finds, how unique it is."""

from itertools import product

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fogkit.reproduction.klimkovich import paper, plan_search
from fogkit.rotation import dcm_from_rotvec

ROUNDING = 1e-12  # matrices of ones and of angles up to 35 rad, a few products deep


@pytest.fixture(scope="module")
def found():
    return plan_search.search()


# The print


def test_the_print_has_51_elements_in_as_many_places():
    assert len(paper.MATRIX) == len({(entry.row, entry.column) for entry in paper.MATRIX}) == 51
    assert np.count_nonzero(paper.printed_matrix(9.8)) == 51
    assert str(paper.MATRIX[6]) == r"H_{1,3} = -10,5\pi g_0"
    assert str(paper.MATRIX[3]) == "H_{1,13} = -1"
    assert [e.of_gravity for e in paper.MATRIX] == [e.column < 12 for e in paper.MATRIX]
    assert_allclose(paper.printed_matrix(9.8)[[1, 3], [3, 14]], [-10.5 * np.pi * 9.8, 2])


# The search


def test_each_test_has_two_candidates_and_they_are_twins(found):
    assert len(plan_search.ATTITUDES) == 24
    assert [len(test.turns) for test in found] == [2] * 9
    for test in found:
        one, other = test.turns
        assert one.twin == other and other.twin == one
        assert test.next_cells > test.cells
    assert [test.cells for test in found] == [1, 0, 0, 2, 0, 0, 0, 0, 2]
    assert plan_search.count_plans(found) == 512


def test_text_and_chain_leave_the_same_single_plan(found):
    plan = plan_search.recovered_plan()
    assert plan_search.chained_plans(found) == [plan]
    positive = [[turn for turn in test.turns if turn.quarters > 0] for test in found]
    assert list(product(*positive)) == [plan]
    assert plan[0].start == paper.START_OF_TEST_1
    # the angles are 90, 180, 90 deg and five whole turns, about the axes of the headings, which lie level
    assert [turn.quarters - 4 * paper.TURNS for turn in plan] == [1, 2, 1] * 3
    assert ["xyz"[turn.axis] for turn in plan] == [axis for axis, tests in paper.BLOCKS.items() for _ in tests]
    assert "".join(turn.along for turn in plan) == "EEEEEENNN"
    # each chain also closes: the three turns about an axis end where they began
    assert all(plan[tests[-1] - 1].end == plan[tests[0] - 1].start for tests in paper.BLOCKS.values())


def test_the_tests_of_eq26_are_those_that_turn_an_axis_upside_down():
    assert plan_search.upended_axes(plan_search.recovered_plan()) == paper.SCALE_FACTOR_TESTS


def test_three_printed_elements_are_wrong():
    pairs = [(str(m.printed), str(m.correct)) for m in plan_search.misprints()]
    assert pairs == [
        ("H_{0,0} = g_0", "H_{0,0} = -g_0"),
        ("H_{7,5} = -g_0", "H_{7,0} = -g_0"),
        ("H_{17,10} = -g_0", "H_{17,8} = -g_0"),
    ]
    mended = paper.printed_matrix()
    for misprint in plan_search.misprints():
        mended[misprint.printed.row, misprint.printed.column] = 0
        mended[misprint.correct.row, misprint.correct.column] = misprint.correct.value()
    assert_allclose(mended, plan_search.measurement_matrix(), atol=ROUNDING)
    # a turn about y shows no error in proportion to the turn about z, nor the reverse: columns 5 and 10 cannot be
    gyros = {axis: [3 + 3 * k + "xyz".index(axis) for k in range(3)] for axis in "xyz"}
    assert 5 not in gyros["y"] and 10 not in gyros["z"]


def test_the_signs_of_eqs_3_and_4_fit_the_appendix_much_worse(found):
    cells = {
        signs: sum(test.cells for test in plan_search.search(gyro_sign=signs[0], force_sign=signs[1]))
        for signs in product((1, -1), repeat=2)
    }
    assert sum(test.cells for test in found) == cells[1, 1] == 5
    assert min(cells[-1, 1], cells[-1, -1]) >= 18 and cells[1, -1] >= 13


def test_the_search_finds_a_plan_that_is_put_in():
    rng = np.random.default_rng(6)
    counts = [sign * count for sign in (1, -1) for count in range(1, 25)]
    plan = [
        plan_search.Turn(str(rng.choice(plan_search.ATTITUDES)), int(rng.integers(3)), int(rng.choice(counts)))
        for _ in range(9)
    ]
    for turn, test in zip(plan, plan_search.search(plan_search.measurement_matrix(plan)), strict=True):
        assert test.cells == 0
        assert {turn, turn.twin} <= set(test.turns)


def test_misprints_of_another_plan_are_not_explained():
    with pytest.raises(ValueError, match="row 0 differs from the plan by more than one number or column"):
        plan_search.misprints(plan_search.recovered_plan()[::-1])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(("ENU", 3, 1), "`axis` must be 0, 1 or 2"), (("END", 0, 1), "right-handed"), (("ENU", 0, 0.5), "`quarters`")],
)
def test_impossible_turns(arguments, words):
    with pytest.raises((TypeError, ValueError), match=words):
        plan_search.Turn(*arguments)


# The table


def test_one_table_does_all_nine_tests():
    for turn in plan_search.recovered_plan():
        outer, inner, turning = plan_search.table_angles(turn)
        angles = np.array([outer, inner])
        for axes in (turn.start, turn.end):
            C_b_n = dcm_from_rotvec([angles[0], 0, 0]) @ dcm_from_rotvec([0, 0, angles[1]])
            assert_allclose(C_b_n, plan_search.attitude(axes), atol=100 * ROUNDING)
            angles[["outer", "inner"].index(turning)] += turn.angle


def test_table_of_another_kind():
    with pytest.raises(ValueError, match="outer axis east"):
        plan_search.table_angles(plan_search.Turn("NWU", 0, 1))  # turns about north by the outer axis
    with pytest.raises(ValueError, match="outer axis east"):
        plan_search.table_angles(plan_search.Turn("NUE", 2, 1))  # z east: out of reach


def test_plan_table():
    table = plan_search.plan_table()
    assert_array_equal(table["turn, deg"], [1890, 1980, 1890] * 3)
    assert_array_equal(table["outer, deg"], [0, 90, -90, -90, 0, 180, -90, -90, -90])
    assert_array_equal(table["inner, deg"], [0, 0, 0, -90, -90, -90, 0, 90, -90])
    assert list(table["end"].iloc[:2]) == ["EUS", "EDN"]
