"""Readings of the bench against a simulation in time steps, and its noise against the stated levels."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from fogkit.constants import EARTH_RATE
from fogkit.imu import Construction, GyroTriad
from fogkit.stand import BenchRecord, Plan, RateTable, bench, plans
from fogkit.units import ARCMIN, DEG

TRIAD = GyroTriad(
    bias=(2e-6, -1e-6, 3e-6),
    scale_positive=(1.7, 1.6, 1.5),
    scale_negative=(1.72, 1.57, 1.53),
    misalignments=np.array([4, -5, 3, 5, -2, 4]) * ARCMIN,
)
TABLE = RateTable(
    latitude=55 * DEG,
    level_east=2e-3,
    level_north=-1e-3,
    azimuth_error=5e-3,
    outer_middle=1e-3,
    middle_inner=-3e-3,
    mounting=(1e-3, -2e-3, 3e-3),
)
SIX_SIGMA = 6 / np.sqrt(2)  # of a standard deviation from n numbers, times its square root of n


def stepped_readings(segment, construction, steps=20_000):
    """Mean readings from attitudes at many times: the rate of the case is that of its attitude, plus the Earth's."""
    turned = segment.rate * segment.duration * np.arange(2 * steps + 1) / (2 * steps)
    outer, middle, inner = (
        (getattr(segment, name) + turned * (segment.turning == name))[:, None] for name in ("outer", "middle", "inner")
    )
    errors = TABLE.geometry
    attitude = (
        Rotation.from_rotvec(errors[:3])
        * Rotation.from_euler("z", outer)
        * Rotation.from_euler("y", errors[3])
        * Rotation.from_euler("x", middle)
        * Rotation.from_euler("y", errors[4])
        * Rotation.from_euler("z", inner)
        * Rotation.from_rotvec(errors[5:])
    )
    earth = EARTH_RATE * np.array([0, np.cos(TABLE.latitude), np.sin(TABLE.latitude)])
    against_earth = (attitude[:-2:2].inv() * attitude[2::2]).as_rotvec() / (segment.duration / steps)
    inputs = (against_earth + attitude[1::2].inv().apply(earth)) @ (
        TRIAD.A_g @ construction.C_0_g1(segment.block_angle)
    ).T
    return (np.array(TRIAD.bias) + inputs / np.where(inputs > 0, TRIAD.scale_positive, TRIAD.scale_negative)).mean(0)


@pytest.mark.parametrize("name", ["plain", "block", "trihedral"])
def test_mean_readings_are_those_of_a_simulation_in_time_steps(name):
    construction = Construction(name=name, block_tilt=(0, 0) if name == "plain" else (1e-3, -2e-3))
    # slow turns, about the rate of the Earth and not whole: the sign of the cross inputs changes on the way
    slow = plans.turns(construction, (0.02, -0.02), 500.0)
    plan = Plan(construction, plans.four_positions(construction, 60.0, heading=0.7) + slow)
    record = bench.run(plan, TRIAD, TABLE)
    expected = [stepped_readings(segment, construction) for segment in plan.segments]
    # midpoint rule: (angle per step)^2 / 24 of the Earth's rate, 1e-12; a kink is met to Earth rate * asymmetry / steps
    assert_allclose(record.readings, expected, atol=1e-10)
    assert_allclose(record.turned, [s.rate * s.duration for s in plan.segments], rtol=1e-15)
    assert_allclose(bench.expected_readings(plan, TRIAD, TABLE, record.turned), record.readings, rtol=1e-14)


def test_temperature_drift_is_that_of_the_middle_of_each_segment():
    plan = plans.three_stage(Construction(name="plain"), bias_duration=100.0, count=1)
    slope = np.array([1e-9, -2e-9, 3e-9])
    drifting = GyroTriad(scale_positive=(2, 2, 2), scale_negative=(2, 2, 2), bias_drift=slope)
    steady = GyroTriad(scale_positive=(2, 2, 2), scale_negative=(2, 2, 2))
    change = bench.run(plan, drifting, TABLE).readings - bench.run(plan, steady, TABLE).readings
    middle = [50, 150, 250, 350, 405, 415, 425, 435, 445, 455]  # s; a turn takes 10 s
    assert_allclose(change, np.outer(middle, slope / 2), atol=1e-15)


def test_noise_is_as_stated():
    runs = 4000
    noisy = GyroTriad(
        scale_positive=(2, 1, 1),
        scale_negative=(2, 1, 1),
        angle_random_walk=1e-6,
        bias_instability=1e-7,
    )
    table = RateTable(latitude=0.9, readout_noise=3e-5, latch_time_error=1e-4)
    plan = plans.three_stage(Construction(name="plain"), bias_duration=400.0, count=1)
    record = bench.run(plan, noisy, table, rng=np.random.default_rng(5), runs=runs)
    assert record.readings.shape == (runs, 10, 3)
    duration = np.array([400.0] * 4 + [10.0] * 6)
    stated = np.sqrt(1e-12 / duration + 1e-14)[:, None] / [2, 1, 1]
    # 6 sigma: 30 numbers are compared, and 6
    assert_allclose(record.readings.std(axis=0) / stated, 1, atol=SIX_SIGMA / np.sqrt(runs))
    ends = np.sqrt(2 * (3e-5**2 + (36 * DEG * 1e-4) ** 2))
    assert_allclose(record.turned.std(axis=0)[4:] / ends, 1, atol=SIX_SIGMA / np.sqrt(runs))
    assert (record.turned[:, :4] == 0).all()
    together = np.concatenate([record.readings, record.turned[..., None]], axis=-1).reshape(runs, -1)
    together = together[:, together.std(axis=0) > 0]
    off = np.corrcoef(together.T) - np.eye(together.shape[1])
    assert np.abs(off).max() < 6 / np.sqrt(runs)  # all independent


def test_rate_noise_moves_reading_and_angle_alike():
    runs = 4000
    table = RateTable(latitude=0.9, rate_stability=5e-6)
    plan = plans.three_stage(Construction(name="plain"), count=1)
    record = bench.run(plan, GyroTriad(), table, rng=np.random.default_rng(6), runs=runs)
    relative = record.turned[:, 4:] / (2 * np.pi * np.array([1, -1] * 3)) - 1
    assert_allclose(relative.std(axis=0) / 5e-6, 1, atol=SIX_SIGMA / np.sqrt(runs))
    turning_gyro = record.readings[:, [4, 5, 6, 7, 8, 9], [0, 0, 1, 1, 2, 2]]
    moved = turning_gyro - turning_gyro.mean(axis=0)
    rates = record.turned[:, 4:] / 10
    # the Earth's rate changes over the extra part of a turn: 3e-5 rad of it
    assert_allclose(moved, rates - rates.mean(axis=0), atol=1e-4 * EARTH_RATE)


def test_noise_is_repeated_by_its_generator_and_left_out_without():
    plan = plans.three_stage(Construction(name="plain"))
    noisy, table = GyroTriad(angle_random_walk=1e-6), RateTable(latitude=0.9, readout_noise=1e-5)
    one, two = (bench.run(plan, noisy, table, rng=np.random.default_rng(1)) for _ in range(2))
    assert (one.readings == two.readings).all()
    assert (one.turned == two.turned).all()
    quiet = bench.run(plan, noisy, table)
    assert (quiet.readings == bench.run(plan, GyroTriad(), RateTable(latitude=0.9)).readings).all()
    with pytest.raises(TypeError, match="`rng`"):
        bench.run(plan, noisy, table, rng=1)
    with pytest.raises(ValueError, match="`runs`"):
        bench.run(plan, noisy, table, runs=0)


def changed(**changes):
    plan = plans.three_stage(Construction(name="plain"))
    record = bench.run(plan, TRIAD, TABLE)
    values = {"readings": record.readings.copy(), "turned": record.turned.copy()}
    for name, change in changes.items():
        values[name] = change(values[name])
    return BenchRecord(plan=plan, latitude=TABLE.latitude, **values)


def set_at(index, value):
    def change(values):
        values[index] = value
        return values

    return change


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"readings": set_at((4, 1), np.nan)}, r"`readings` .* segment 5 \(turn about x, \+36 deg/s\)"),
        ({"turned": set_at(7, np.inf)}, r"`turned` .* segment 8 \(turn about y, -36 deg/s\)"),
        ({"readings": lambda r: r[:-1]}, r"`readings` .*\(9, 3\)"),
        ({"readings": lambda r: r.T}, "`readings`"),
        ({"turned": lambda t: t[:, None]}, "`turned`"),
        ({"turned": lambda t: np.stack([t, t])}, "`readings` and `turned`"),
        ({"turned": lambda t: np.mod(t, 2 * np.pi)}, r"`turned` .* wraps: segment 5 \(turn about x"),
        ({"turned": lambda t: np.rad2deg(t)}, "`turned`"),
    ],
)
def test_impossible_records_are_refused_and_name_the_segment(changes, message):
    with pytest.raises(ValueError, match=message):
        changed(**changes)


def test_a_wrapped_angle_of_one_run_among_many_is_shown():
    plan = plans.three_stage(Construction(name="plain"))
    record = bench.run(plan, TRIAD, TABLE, runs=3)
    turned = record.turned.copy()
    turned[2, 6] = 1.25
    with pytest.raises(ValueError, match=r"segment 7 \(turn about y.* reads 1.25 rad"):
        BenchRecord(plan=plan, latitude=0.9, readings=record.readings, turned=turned)


def test_table_of_a_run():
    plan = plans.three_stage(Construction(name="plain"))
    frame = bench.run(plan, TRIAD, TABLE).to_frame()
    assert list(frame.columns[-4:]) == ["gyro_x", "gyro_y", "gyro_z", "turned, rad"]
    assert_allclose(frame["turned, rad"], 2 * np.pi * frame["turns"], rtol=1e-14)
    assert_allclose(frame.loc[5, "gyro_x"], 36 * DEG / 1.7, rtol=1e-4)  # Earth 7e-5, misalignment 1e-6
    with pytest.raises(ValueError, match="`readings`"):
        bench.run(plan, TRIAD, TABLE, runs=2).to_frame()


def test_a_position_that_turned_is_refused():
    record = bench.run(plans.three_stage(Construction(name="plain")), TRIAD, TABLE)
    turned = record.turned.copy()
    turned[2] = 0.1
    with pytest.raises(ValueError, match=r"`turned` must be 0 where a position is held.*segment 3"):
        BenchRecord(plan=record.plan, latitude=record.latitude, readings=record.readings, turned=turned)
