"""The recovered plan of the nine tests: the model behind it by other means, what the search finds, how unique it is."""

from itertools import product

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from fogkit.calibration.navigation_based import turn_model
from fogkit.reproduction.klimkovich import paper, plan_search
from fogkit.rotation import dcm_from_rotvec
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


@pytest.fixture(scope="module")
def found():
    return plan_search.search()


# The model


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
    first = plan_search.recovered_plan()[0]
    slopes = turn_model.slope_change(first.C_b_n, first.direction, first.angle, errors, gravity=9.8)
    assert_allclose(slopes, [0, -9.8 * (5 * 360 + 90) * DEG * ARCSEC], atol=1e-6 * ARCSEC)


def test_attitude_error_at_the_start_alone_changes_no_slope():
    # without Earth rate; the calibration is perfect
    for C_b_n, axis, angle in zip(*random_tests(5, 3), strict=True):
        slopes = turn_model.slope_change(C_b_n, axis, angle, np.zeros(21), gravity=9.8, start=[0.01, -0.02, 0.03])
        assert_allclose(slopes, 0, atol=1e3 * ROUNDING)


def test_the_plan_leaves_out_the_frame_and_the_accelerometer_scale_factors_and_nothing_else():
    plan = plan_search.recovered_plan()
    full = np.concatenate([turn_model.differentiated_rows(t.C_b_n, t.direction, t.angle) for t in plan])
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
