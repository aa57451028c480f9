"""Tables of records and aids: round trips, axes by a tilted hull, what is refused."""

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fogkit.constants import STANDARD_GRAVITY
from fogkit.gyrocompass.covariance import Aid, Noise
from fogkit.gyrocompass.filters.records import record, take_fixes
from fogkit.gyrocompass.laws import QuasiHarmonic
from fogkit.gyrocompass.motions import Vessel
from fogkit.gyrocompass.tables import fixes_from_frame, recording_from_frame, recording_to_frame
from fogkit.navigation import increments_from_rates
from fogkit.units import DEG

LAT = 60 * DEG
LAW = QuasiHarmonic(amplitude=1.0, period=20.0)


@pytest.fixture(scope="module")
def recording():
    motion = Vessel(lat=LAT, heading=1.0, trim=2 * DEG, roll=5 * DEG).motion(4.0, 0.1, LAW)
    return record(motion, Noise(angle_random_walk=1e-5, velocity_random_walk=1e-4), np.random.default_rng(1))


def test_round_trip(recording):
    table = recording_to_frame(recording)
    again = recording_from_frame(table)
    assert again.dt == pytest.approx(recording.dt, rel=1e-12)
    for name in ("dtheta", "dv", "mount_angle"):
        assert_array_equal(getattr(again, name), getattr(recording, name))


def test_axes_of_the_hull_are_the_package_s():
    # bow up by trim, starboard down by roll: specific force points up, so ahead sin(trim) of it, to port sin(roll)
    motion = Vessel(lat=LAT, trim=2 * DEG, roll=5 * DEG).motion(1.0, 0.1)
    table = recording_to_frame(record(motion, Noise(angle_random_walk=0.0), np.random.default_rng(0)))
    force = table[["accel_x", "accel_y", "accel_z"]].iloc[0].to_numpy() / 0.1 / STANDARD_GRAVITY
    expected = [-np.cos(2 * DEG) * np.sin(5 * DEG), np.sin(2 * DEG), np.cos(2 * DEG) * np.cos(5 * DEG)]
    assert_allclose(force, expected, rtol=1e-12)


def test_rates_become_a_recording(recording):
    time = pd.Index(0.1 * np.arange(41) + 100.0, name="time")
    rates = pd.DataFrame(0.2, index=time, columns=["gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"])
    table = increments_from_rates(rates, kind="instant").reindex(time)
    table["mount_angle"] = recording.mount_angle
    made = recording_from_frame(table)
    assert_allclose(made.dtheta, 0.02, rtol=1e-9)
    assert made.duration == pytest.approx(4.0, rel=1e-9)


def test_fixes():
    motion = Vessel(lat=LAT).motion(4.0, 0.1, LAW)
    aid = Aid(std={"velocity_north": 0.1, "velocity_east": 0.1})
    fixes = take_fixes(motion, aid, np.random.default_rng(2))
    table = pd.DataFrame(fixes.values[:, [2, 0]], index=fixes.time + 7.0, columns=["velocity_east", "velocity_north"])
    again = fixes_from_frame(table, aid, start=7.0)
    assert_allclose(again.time, fixes.time, atol=1e-14)
    assert_array_equal(again.values, fixes.values)
    with pytest.raises(ValueError, match="without 'velocity_north'"):
        fixes_from_frame(table.drop(columns="velocity_north"), aid)


def test_bad_tables(recording):
    table = recording_to_frame(recording)
    with pytest.raises(ValueError, match="`table` must end with a row that holds the angle"):
        recording_from_frame(table.iloc[:-1])
    with pytest.raises(ValueError, match="without 'mount_angle'"):
        recording_from_frame(table.drop(columns="mount_angle"))
    hole = table.copy()
    hole.iloc[3, 1] = np.nan
    with pytest.raises(ValueError, match=r"`increments` must be finite, got nan at index \(3, 1\)"):
        recording_from_frame(hole)
    with pytest.raises(ValueError, match="table"):
        recording_from_frame(table.drop(index=table.index[5]))
