"""Attitudes and rates against those printed in the slides, and what cannot be laid down."""

import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fogkit.stand.placements import (
    RATES,
    Placement,
    Schedule,
    attitude,
    full_turns,
    rate_sequence,
    six_positions,
    three_positions_east,
    triad_letters,
    twenty_four_points,
)
from fogkit.units import DEG, DEG_PER_SECOND

# the slides' table of points 1-1 to 2-4: where x, y and z point (up is "sky", down "earth" there)
PRINTED_POINTS = ["UEN", "USE", "UWS", "UNW", "DES", "DSW", "DWN", "DNE"]
# the slides' rates, deg/s, in their order
PRINTED_RATES = [
    *(0, 0.1, -0.1, 0.2, -0.2, 0.5, -0.5, 1, -1, 3, -3, 5, -5, 8, -8, 10, -10),
    *(20, -20, 50, -50, 80, -80, 100, -100, 150, -150, 200, -200),
]


def test_the_printed_points():
    points = twenty_four_points()
    assert [placement.axes for placement in points.placements[:8]] == PRINTED_POINTS
    assert points.labels[:8] == ["1.1", "1.2", "1.3", "1.4", "2.1", "2.2", "2.3", "2.4"]


def test_the_24_points_are_all_the_attitudes_there_are():
    points = twenty_four_points(60.0)
    # every way of pointing three axes along six directions that is a rotation: 6 * 8 choices, half of them right-handed
    turns = []
    for order in itertools.permutations(range(3)):
        for signs in itertools.product([1, -1], repeat=3):
            C = np.zeros((3, 3))
            C[list(order), range(3)] = signs
            if np.linalg.det(C) > 0:
                turns.append(C.tobytes())
    assert sorted(turns) == sorted((p.C_b_n + 0.0).tobytes() for p in points.placements)  # + 0.0: no minus zero
    assert points.duration == 24 * 60
    for k, placement in enumerate(points.placements):
        assert placement.vertical == (k // 8, 1 if k // 4 % 2 == 0 else -1)


def test_the_printed_rates():
    assert_allclose(np.array(RATES) / DEG_PER_SECOND, PRINTED_RATES, rtol=1e-15)
    sequence = rate_sequence()
    assert len(sequence) == 3 * 29
    assert {p.duration for p in sequence.placements} == {120}
    assert sequence.labels[:3] == ["x +0 deg/s", "x +0.1 deg/s", "x -0.1 deg/s"]
    assert [p.vertical for p in sequence.placements[::29]] == [(0, 1), (1, 1), (2, 1)]


def test_columns_are_where_the_axes_point():
    directions = {"E": [1, 0, 0], "N": [0, 1, 0], "U": [0, 0, 1], "W": [-1, 0, 0], "S": [0, -1, 0], "D": [0, 0, -1]}
    for axes in PRINTED_POINTS:
        for k, letter in enumerate(axes):
            assert_array_equal(attitude(axes) @ np.eye(3)[k], directions[letter])
            assert triad_letters(k, letter, axes[(k + 1) % 3]) == axes


def test_turns():
    schedule = full_turns(10 * DEG, 2)
    assert_allclose([p.turns for p in schedule.placements], [2, -2] * 3, rtol=1e-15)
    assert schedule.labels == ["x +720", "x -720", "y +720", "y -720", "z +720", "z -720"]
    assert {p.duration for p in schedule.placements} == {72.0}
    assert [p.vertical for p in schedule.placements] == [(0, 1)] * 2 + [(1, 1)] * 2 + [(2, 1)] * 2


def test_positions_of_cube_and_plate():
    assert [p.vertical for p in six_positions().placements] == [(j, s) for j in range(3) for s in (1, -1)]
    assert [p.axes.index("E") for p in three_positions_east().placements] == [0, 1, 2]
    assert three_positions_east().duration == 3 * 600
    assert six_positions().duration == 6 * 120


def test_schedule_as_a_table():
    table = (six_positions() + full_turns(36 * DEG)).select([1, 7]).to_frame()
    assert list(table.index) == [1, 2]
    assert list(table.loc[1, ["position", "x", "y", "z"]]) == ["2", "down", "east", "south"]
    assert_allclose(table.loc[2, ["rate, deg/s", "turns", "duration, s"]].astype(float), [-36, -1, 10], rtol=1e-15)


@pytest.mark.parametrize(
    ("axes", "message"),
    [
        ("UNE", "right-handed triad, got 'UNE'; with x up and y north, z points west"),
        ("UDE", "right-handed triad, got 'UDE'$"),  # opposite axes: no third one to propose
        ("UE", "`axes` must be three letters"),
        ("uen", "`axes` must be three letters"),
        ("UEX", "`axes` must be three letters"),
    ],
)
def test_axes_that_are_no_attitude(axes, message):
    with pytest.raises(ValueError, match=message):
        attitude(axes)
    with pytest.raises(ValueError, match="position 'p 1': .*" + message):
        Placement(label="p 1", axes=axes, duration=1.0)


@pytest.mark.parametrize(
    ("make", "kind", "message"),
    [
        (lambda: attitude(("U", "E", "N")), TypeError, "`axes`"),
        (lambda: Placement(label="", axes="UEN", duration=1.0), ValueError, "`label`"),
        (lambda: Placement(label=1, axes="UEN", duration=1.0), ValueError, "`label`"),
        (lambda: Placement(label="1", axes="UEN", duration=0.0), ValueError, "`duration`"),
        (lambda: Placement(label="1", axes="UEN", duration=1.0, rate=np.nan), ValueError, "`rate`"),
        # 150 deg/s given as 150 rad/s is 8594 deg/s, which no table of this kind does
        (lambda: Placement(label="1", axes="UEN", duration=1.0, rate=150), ValueError, "`rate` .*DEG_PER_SECOND"),
        (lambda: Schedule([]), ValueError, "`placements` must hold at least one"),
        (lambda: six_positions() + six_positions(), ValueError, "`placements` .* got '1', '2', '3', '4', '5', '6'"),
        (lambda: rate_sequence([0.1, 0.2, 0.1]), ValueError, r"`placements` .*'x \+5.729577951 deg/s'"),
        (lambda: rate_sequence([0.1, np.inf]), ValueError, "`rates`"),
        (lambda: rate_sequence(axes="xw"), ValueError, "`axes` .*'w'"),
        (lambda: full_turns(turns=0), ValueError, "`turns`"),
        (lambda: full_turns(rate=-0.1), ValueError, "`rate`"),
        (lambda: full_turns(turns=1.5), ValueError, "`turns`"),
    ],
)
def test_errors_name_the_argument(make, kind, message):
    with pytest.raises(kind, match=message):
        make()
