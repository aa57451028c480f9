"""Plans: what the operator would set up, checked by geometry."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from fogkit.constants import EARTH_RATE
from fogkit.imu import Construction
from fogkit.stand import Plan, RateTable, Segment, plans
from fogkit.units import DEG, DEG_PER_SECOND

CONSTRUCTIONS = ("plain", "block", "trihedral")
LATITUDE = 50 * DEG


def attitude(segment, turned=0.0):
    """Case to east, north, up on an ideal table, by `scipy`."""
    angles = [getattr(segment, name) + turned * (segment.turning == name) for name in ("outer", "middle", "inner")]
    return Rotation.from_euler("ZXZ", angles)


def case(name):
    return Construction(name=name)


@pytest.mark.parametrize(
    ("name", "block_angle"), [("plain", 0.0), ("block", 0.0), ("block", np.pi), ("block", 1.0), ("trihedral", 0.0)]
)
def test_each_turn_is_about_the_nominal_axis_of_its_gyro(name, block_angle):
    for segment in plans.turns(case(name), (0.5, -0.5), count=2, block_angle=block_angle):
        nominal = case(name).C_0_g1(segment.block_angle)[segment.gyro_axis]  # in the case
        before, after = (attitude(segment, turned).apply(nominal) for turned in (0.0, np.sign(segment.rate) * 1.0))
        assert_allclose(before, after, atol=1e-15)  # along the axis: it does not move
        cross = attitude(segment, 1e-3) * attitude(segment).inv()
        assert_allclose(cross.as_rotvec(), 1e-3 * before, atol=1e-15)  # and points the way of a positive turn
        east_or_up = [0, 0, 1] if name == "trihedral" or segment.gyro_axis == 2 else [1, 0, 0]
        assert_allclose(before, east_or_up, atol=1e-15)


@pytest.mark.parametrize("name", CONSTRUCTIONS)
@pytest.mark.parametrize("heading", [0.0, 0.8])
def test_earth_cancels_in_four_positions_at_any_heading_of_the_table(name, heading):
    earth = EARTH_RATE * np.array([0, np.cos(LATITUDE), np.sin(LATITUDE)])
    seen = [attitude(s).inv().apply(earth) for s in plans.four_positions(case(name), 60.0, heading=heading)]
    assert_allclose(np.mean(seen, axis=0), 0, atol=1e-15 * EARTH_RATE)
    turned_base = [attitude(s).inv().apply([0.3, 0.5, 0.7]) for s in plans.four_positions(case(name), 60.0)]
    assert_allclose(np.mean(turned_base, axis=0), 0, atol=1e-15)  # whatever the azimuth


@pytest.mark.parametrize("name", CONSTRUCTIONS)
def test_earth_cancels_in_two_positions_if_the_middle_axis_points_east(name):
    earth = np.array([0, np.cos(LATITUDE), np.sin(LATITUDE)])
    positions = plans.two_positions(case(name), 60.0)
    assert len(positions) == 2
    assert_allclose(np.mean([attitude(s).inv().apply(earth) for s in positions], axis=0), 0, atol=1e-15)
    # turned base: the part along the middle axis stays
    left = np.mean([attitude(s).inv().apply([0.1, 0.9, 0.5]) for s in positions], axis=0)
    assert_allclose(left, [0.1, 0, 0], atol=1e-15)


def test_positions_of_a_level_unit_are_those_of_the_paper():
    ups = [attitude(s).apply([0, 0, 1]) for s in plans.four_positions(case("plain"), 60.0)]
    assert_allclose(ups, [[0, 0, 1], [0, 0, 1], [0, 0, -1], [0, 0, -1]], atol=1e-15)
    x = [attitude(s).apply([1, 0, 0]) for s in plans.four_positions(case("plain"), 60.0)]
    assert_allclose(x, [[1, 0, 0], [-1, 0, 0], [-1, 0, 0], [1, 0, 0]], atol=1e-15)


@pytest.mark.parametrize("rate", [36, -1, 7.3])
@pytest.mark.parametrize("count", [1, 36, 1000])
def test_turns_by_count_are_whole(rate, count):
    for segment in plans.turns(case("plain"), [rate * DEG_PER_SECOND], count=count):
        assert segment.is_whole
        assert_allclose(segment.turns, np.sign(rate) * count, rtol=1e-14)
        assert_allclose(segment.duration, count * 360 / abs(rate), rtol=1e-14)


def test_turns_by_duration_may_end_anywhere():
    whole, part = (plans.turns(case("plain"), [36 * DEG_PER_SECOND], t)[0] for t in (30.0, 30.001))
    assert whole.is_whole
    assert not part.is_whole
    assert Segment(label="stand still", duration=1.0).is_whole


def test_plan_of_three_stages():
    plan = plans.three_stage(case("block"), bias_duration=100.0, count=2, block_angle=np.pi)
    assert plan.positions == [0, 1, 2, 3]
    assert [plan.turns_about(axis, sign) for axis in range(3) for sign in (1, -1)] == [[4], [5], [6], [7], [8], [9]]
    assert_allclose(plan.duration, 4 * 100 + 6 * 20)  # two turns at 36 deg/s take 20 s
    assert_allclose(plan.C_0_g1[4], np.diag([-1, -1, 1]), atol=1e-15)


def test_schedule_for_the_operator():
    frame = plans.three_stage(case("trihedral"), bias_duration=3600.0, count=36).to_frame()
    assert list(frame.index) == list(range(1, 11))
    assert frame.index.name == "step"
    step = frame.loc[5]
    assert step["what"] == "turn about x, +36 deg/s"
    assert step["turning axis"] == "outer"
    # a cube on its corner leans by the angle of its edge to its diagonal
    assert_allclose(step["middle, deg"], np.rad2deg(np.arccos(1 / np.sqrt(3))), rtol=1e-14)
    assert_allclose(step[["block, deg", "rate, deg/s", "turns", "duration, s"]].astype(float), [120, 36, 36, 360])
    assert_allclose(frame.loc[6, "turns"], -36)
    assert (frame.loc[1:4, "turning axis"] == "").all()


def segment(**changes):
    return Segment(**({"label": "turn", "duration": 1.0, "turning": "outer", "rate": 1.0} | changes))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"duration": 0.0}, "`duration`"),
        ({"duration": np.nan}, "`duration`"),
        ({"middle": np.nan}, "`middle`"),
        ({"rate": np.inf}, "`rate`"),
        ({"rate": 0.0}, "zero length in 'turn'"),
        ({"turning": None}, "`rate` must be 0 where no axis turns.*'turn'"),
        ({"turning": "third"}, "`turning`"),
        ({"gyro_axis": 3}, "`gyro_axis`"),
    ],
)
def test_impossible_segments_are_refused_by_name(changes, message):
    with pytest.raises(ValueError, match=message):
        segment(**changes)


def test_impossible_plans_are_refused_by_name():
    with pytest.raises(ValueError, match="`segments`"):
        Plan(case("plain"), [])
    with pytest.raises(ValueError, match="`block_angle`"):
        Plan(case("plain"), [segment(block_angle=1.0)])
    with pytest.raises(ValueError, match="`name`"):
        case("tetrahedral")
    with pytest.raises(ValueError, match="`gyro_axis`"):
        plans.placement(case("plain"), 3)
    with pytest.raises(ValueError, match="`block_angle`"):
        plans.placement(case("trihedral"), 0, 1.0)
    for both in ({}, {"duration": 1.0, "count": 1}):
        with pytest.raises(ValueError, match="`duration` and `count`"):
            plans.turns(case("plain"), [1.0], **both)
    with pytest.raises(ValueError, match="`count`"):
        plans.turns(case("plain"), [1.0], count=0)
    for length in ({"count": 1}, {"duration": 1.0}):
        with pytest.raises(ValueError, match=r"`rates` .* zero length"):
            plans.turns(case("plain"), [1.0, 0.0], **length)


def test_rates_may_come_from_an_iterator():
    assert len(plans.turns(case("plain"), iter([1.0, -1.0]), count=1)) == 6


def test_an_ideal_table_agrees_with_the_geometry_used_here():
    table = RateTable(latitude=LATITUDE)
    for s in plans.three_stage(case("trihedral")).segments:
        assert_allclose(table.C_0_n(s.outer, s.middle, s.inner), attitude(s).as_matrix(), atol=1e-15)
