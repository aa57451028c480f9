"""The rough table against rotations by hand, and what it draws against its deviations."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from fogkit.earth import normal_gravity
from fogkit.stand.rough_table import RoughTable
from fogkit.stand.turn_motion import Absorber, Harmonic
from fogkit.stand.turn_tests import TurnTest, nine_tests
from fogkit.units import DEG

LATITUDE = 53.9 * DEG
PLAN = nine_tests()
TABLE = ((0, 0), (90, 0), (-90, 0), (-90, -90), (0, -90), (180, -90), (-90, 0), (-90, 90), (-90, -90))
"""Outer and inner angle at the start of each test, deg."""


def test_an_ideal_table_does_what_it_is_told():
    table = RoughTable.typical(LATITUDE, 0.0)
    assert table == RoughTable(latitude=LATITUDE)
    for test, motion in zip(PLAN, table.motions(PLAN), strict=True):
        # rounding of 33 rad, and of the plan's own rotation vector
        assert_allclose(motion.C_b_n(test.duration), test.C_b_n_end, atol=2e-14)
        assert_allclose(motion.C_b_n([0.0, test.dwell]), [test.C_b_n] * 2, atol=1e-15)
        assert motion.dwells == test.dwells
        assert_allclose(motion.velocity(np.linspace(0, 35, 50)), 0, atol=0)
    assert table.gravity == normal_gravity(LATITUDE)
    assert RoughTable(latitude=LATITUDE, altitude=300.0).gravity == normal_gravity(LATITUDE, 300.0)
    assert RoughTable(latitude=LATITUDE, gravity=9.8).motions(PLAN)[0].gravity == 9.8


def test_geometry_of_the_two_axes_by_hand():
    errors = {"level_east": 1e-2, "level_north": -2e-2, "azimuth_error": 3e-2, "non_orthogonality": 4e-2}
    base, lean = Rotation.from_rotvec([1e-2, -2e-2, 3e-2]), Rotation.from_euler("y", 4e-2)
    motions = RoughTable(latitude=LATITUDE, **errors).motions(PLAN)
    for (outer, inner), motion in zip(np.array(TABLE) * DEG, motions, strict=True):
        first, last = Rotation.from_euler("x", outer), Rotation.from_euler("z", inner)
        assert_allclose(motion.C_b_n(0.0), (base * first * lean * last).as_matrix(), atol=1e-14)
        end, angle = motion.C_b_n(35.0), motion.angle
        if motion.test.label in "123456":
            expected = base * Rotation.from_euler("x", outer + angle) * lean * last
        else:
            expected = base * first * lean * Rotation.from_euler("z", inner + angle)
        assert_allclose(end, expected.as_matrix(), atol=1e-13)


def test_a_turn_back_goes_the_same_way():
    # an error of the table itself belongs to the angle of its axis, whichever way it turns
    wobble = [
        Harmonic(order=1, amplitude=(1e-2, 2e-2, 3e-3), phase=(1, 2, 3)),
        Harmonic(order=2, amplitude=(5e-3, -1e-2, 4e-3), phase=(-1, 0.5, 4)),
    ]
    table = RoughTable(latitude=LATITUDE, non_orthogonality=0.02, level_east=0.03, wobble=wobble)
    for test in (PLAN[0], PLAN[4], PLAN[7], TurnTest.from_letters("ENU", "z", 2.0, turn_duration=15.0)):
        back = replace(test, C_b_n=test.C_b_n_end, angle=-test.angle)
        turned = replace(test, C_b_n=test.C_b_n_end, axis=-test.axis)
        there, *others = table.motions([test, back, turned])
        time = np.linspace(0, test.duration, 60)
        for other in others:
            assert_allclose(other.C_b_n(test.duration - time), there.C_b_n(time), atol=1e-13)


def test_wobble_goes_on_from_test_to_test():
    wobble = [Harmonic(order=3, amplitude=(1e-2, 2e-2, 3e-3), phase=(1, 2, 3))]
    motions = RoughTable(latitude=LATITUDE, wobble=wobble, non_orthogonality=0.01).motions(PLAN)
    for first, second in ((0, 1), (1, 2), (3, 4), (4, 5), (6, 7), (7, 8)):
        assert_allclose(motions[first].C_b_n(35.0), motions[second].C_b_n(0.0), atol=1e-13)


def test_tests_that_the_axes_can_not_do_get_what_is_drawn():
    oblique = TurnTest(label="o", C_b_n=np.eye(3), axis=[1, 1, 1], angle=3.0)
    steep = TurnTest(label="s", C_b_n=Rotation.from_rotvec([0, 0.5, 0]).as_matrix(), axis=[0, 0, 1], angle=3.0)
    table = RoughTable(latitude=LATITUDE, level_east=0.02, non_orthogonality=0.1)
    base = Rotation.from_rotvec([0.02, 0, 0]).as_matrix()
    for test, motion in zip((oblique, steep), table.motions([oblique, steep]), strict=True):
        assert_allclose(motion.C_b_n(0.0), base @ test.C_b_n, atol=1e-15)
        assert_allclose(motion.C_b_n(35.0), base @ test.C_b_n_end, atol=1e-14)


def test_drawn_errors_have_their_deviations():
    table = RoughTable(latitude=LATITUDE, start_error=1e-3, axis_error=2e-3, angle_error=3e-3)
    runs = 600
    motions = table.motions([PLAN[3]] * runs, np.random.default_rng(1))
    start = np.array([Rotation.from_matrix(PLAN[3].C_b_n.T @ motion.C_case_n).as_rotvec() for motion in motions])
    axes = np.array([motion.axis for motion in motions])
    angles = np.array([motion.angle - PLAN[3].angle for motion in motions])
    five_sigma = 5 / np.sqrt(2 * runs)  # of a standard deviation; squares of the angles are 1e-3 of it
    assert_allclose(start.std(axis=0), 1e-3, rtol=five_sigma)
    assert_allclose(axes[:, [0, 2]].std(axis=0), 2e-3, rtol=five_sigma)
    assert_allclose(np.linalg.norm(axes, axis=1), 1, rtol=1e-15)
    assert_allclose(angles.std(), 3e-3, rtol=five_sigma)
    drawn = np.column_stack([start, axes[:, [0, 2]], angles])
    assert np.abs(np.corrcoef(drawn.T) - np.eye(6)).max() < 5 / np.sqrt(runs)


def test_roughness_scales_what_a_typical_table_does():
    fine, rough = (RoughTable.typical(LATITUDE, size).motions(PLAN, np.random.default_rng(2)) for size in (1e-3, 2e-3))
    time = np.array([0.0, 10.3, 17.0, 25.05, 35.0])
    for test, one, two in zip(PLAN, fine, rough, strict=True):
        ideal = RoughTable(latitude=LATITUDE).motions([test])[0].C_b_n(time)
        small, large = (
            Rotation.from_matrix(np.einsum("nji,njk->nik", ideal, m.C_b_n(time))).as_rotvec() for m in (one, two)
        )
        # products of two errors: 1e-5 rad each, turned by 33 rad; an error of 1e-5 is 0.2 deg / 1000 and more
        assert_allclose(large, 2 * small, atol=1e-9)
        assert np.abs(small).max() > 2e-6


def test_a_typical_table_is_off_by_tenths_of_a_degree():
    motions = RoughTable.typical(LATITUDE).motions(PLAN * 20, np.random.default_rng(3))
    off = [Rotation.from_matrix(m.test.C_b_n.T @ m.C_b_n(0.0)).magnitude() / DEG for m in motions]
    assert 0.2 < np.median(off) < 0.5
    changed = RoughTable.typical(LATITUDE, 1.0, absorber=None, offset=(0, 0, 0))
    assert changed.absorber is None
    assert changed.offset == (0, 0, 0)


def test_drawn_errors_come_from_the_generator_and_not_by_chance():
    table = RoughTable.typical(LATITUDE)
    one, same, other = (table.motions(PLAN, np.random.default_rng(seed))[4].C_case_n for seed in (5, 5, 6))
    assert_array_equal(one, same)
    assert np.abs(one - other).max() > 1e-4


@pytest.mark.parametrize(
    ("make", "kind", "message"),
    [
        (lambda: RoughTable(latitude=53.9), ValueError, "`latitude`"),
        (lambda: RoughTable(latitude=0.9, altitude=1e6), ValueError, "`alt`"),
        (lambda: RoughTable(latitude=0.9, gravity=-1), ValueError, "`gravity`"),
        (lambda: RoughTable(latitude=0.9, level_east=0.6), ValueError, "`level_east`"),
        (lambda: RoughTable(latitude=0.9, non_orthogonality=-2), ValueError, "`non_orthogonality`"),
        (lambda: RoughTable(latitude=0.9, start_error=-1e-3), ValueError, "`start_error`"),
        (lambda: RoughTable(latitude=0.9, axis_error=0.6), ValueError, "`axis_error`"),
        (lambda: RoughTable(latitude=0.9, angle_error=np.nan), ValueError, "`angle_error`"),
        (lambda: RoughTable(latitude=0.9, wobble=[1.0]), TypeError, "`wobble`"),
        (lambda: RoughTable(latitude=0.9, absorber="soft"), TypeError, "`absorber`"),
        (lambda: RoughTable(latitude=0.9, offset=0.05), ValueError, "`offset`"),
        (lambda: RoughTable(latitude=0.9, ramp=0), ValueError, "`ramp`"),
        (lambda: RoughTable.typical(0.9, -1.0), ValueError, "`roughness`"),
        (lambda: RoughTable.typical(0.9).motions(PLAN), ValueError, "`rng` must be given"),
        (lambda: RoughTable.typical(0.9).motions(PLAN, 42), TypeError, "`rng`"),
        (lambda: RoughTable(latitude=0.9).motions([]), ValueError, "`plan`"),
        (lambda: RoughTable(latitude=0.9).motions(PLAN[0]), ValueError, "`plan`"),
        (lambda: RoughTable(latitude=0.9).motions(["ENU"]), TypeError, "`plan`"),
        (lambda: RoughTable(latitude=0.9, ramp=9.0).motions(PLAN), ValueError, "`ramp` .* in test '1'"),
        (
            lambda: RoughTable(latitude=0.9, absorber=Absorber(frequency=0.3)).motions(PLAN),
            ValueError,
            "`absorber` must turn",
        ),
    ],
)
def test_errors_name_the_argument(make, kind, message):
    with pytest.raises(kind, match=message):
        make()
