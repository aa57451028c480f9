"""Readings on the plate and the table against attitudes in time steps, and the energy of what is read."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from laboratories import ACCELEROMETERS, CROOKED, EXACT, GYROS, LABORATORY
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from fogkit.constants import EARTH_RATE
from fogkit.imu.tables import IMU_COLUMNS
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors
from fogkit.noise.processes import RandomErrors
from fogkit.stand.laboratory import Laboratory
from fogkit.stand.placements import Placement, Schedule, full_turns, six_positions, twenty_four_points
from fogkit.units import DEG

DIRECTIONS = {"E": [1, 0, 0], "N": [0, 1, 0], "U": [0, 0, 1], "W": [-1, 0, 0], "S": [0, -1, 0], "D": [0, 0, -1]}
IDEAL = MeasurementUnit()
FACE = {"xU": 0, "xD": 1, "yU": 2, "yD": 3, "zU": 4, "zD": 5}  # order of the documentation


def stepped(laboratory, placement, start, stop, steps=4000):
    """Mean rate and specific force from attitudes at many times, by the rule of midpoints."""
    times = np.linspace(start, stop, 2 * steps + 1)
    nominal = Rotation.from_matrix(np.transpose([DIRECTIONS[letter] for letter in placement.axes]))
    upright = next(f"{name}{letter}" for name, letter in zip("xyz", placement.axes, strict=True) if letter in "UD")
    attitude = (
        Rotation.from_rotvec([laboratory.level_east, laboratory.level_north, laboratory.azimuth_error])
        * Rotation.from_euler("z", (placement.rate * times)[:, None])
        * nominal
        * Rotation.from_rotvec(laboratory.faces[FACE[upright]])
        * Rotation.from_rotvec(laboratory.mounting)
    )
    earth = EARTH_RATE * np.array([0, np.cos(laboratory.latitude), np.sin(laboratory.latitude)])
    against_earth = (attitude[:-2:2].inv() * attitude[2::2]).as_rotvec() * steps / (stop - start)
    middle = attitude[1::2].inv()
    return np.mean(against_earth + middle.apply(earth), axis=0), middle.apply([0, 0, laboratory.gravity]).mean(axis=0)


@pytest.mark.parametrize("rate", [0.0, 1e-4, 0.3, -0.3, 2.6])
@pytest.mark.parametrize("axes", ["UEN", "SDE", "ENU"])
def test_mean_inputs_are_those_of_a_simulation_in_time_steps(axes, rate):
    placement = Placement(label="1", axes=axes, duration=7.0, rate=rate)
    for start, stop in ((0.0, 7.0), (2.3, 2.9)):
        omega, force = stepped(CROOKED, placement, start, stop)
        # midpoints: (angle of a step)^2 / 24, below (18 / 4000)^2 / 24 = 1e-6, of the horizontal parts, 6e-5 rad/s
        # and 4e-3 * 9.8 m/s^2; rotation vectors of 1e-3 rad carry their 1e-16 of rounding over dt
        assert_allclose(CROOKED.mean_inputs(placement, start, stop)[0], omega, atol=2e-10)
        assert_allclose(CROOKED.mean_inputs(placement, start, stop)[1], force, atol=4e-8)
    assert_array_equal(CROOKED.mean_inputs(placement), CROOKED.mean_inputs(placement, 0.0, 7.0))


@given(latitude=st.floats(-1.5, 1.5), seed=st.integers(0, 2**32 - 1))
def test_at_rest_gravity_and_the_earths_rotation_are_read_whole(latitude, seed):
    rng = np.random.default_rng(seed)
    laboratory = Laboratory(
        latitude=latitude, level_east=0.1 * rng.standard_normal(), faces=rng.uniform(-0.2, 0.2, (6, 3))
    )
    for placement in six_positions().placements:
        omega, force = laboratory.mean_inputs(placement)
        # lengths kept by rotations, and the angle between the vectors too; rounding of three products
        assert_allclose(np.linalg.norm(omega), EARTH_RATE, rtol=1e-14)
        assert_allclose(np.linalg.norm(force), laboratory.gravity, rtol=1e-14)
        assert_allclose(omega @ force, EARTH_RATE * laboratory.gravity * np.sin(latitude), atol=1e-14 * 7e-4)


def test_means_add_up_over_time():
    placement = Placement(label="1", axes="WNU".replace("N", "S"), duration=10.0, rate=0.4)
    edges = np.array([0, 1.5, 4.0, 4.7, 10])
    parts = CROOKED.mean_inputs(placement, edges[:-1], edges[1:])
    for part, whole in zip(parts, CROOKED.mean_inputs(placement), strict=True):
        assert part.shape == (4, 3)
        assert_allclose(np.diff(edges) @ part / 10, whole, rtol=0, atol=1e-14 * np.abs(whole).max())  # rounding


def test_a_point_at_the_equator_by_hand():
    laboratory = Laboratory(latitude=0.0, gravity=9.8)
    # x up, y east, z north: only the third axis sees the Earth turn
    omega, force = laboratory.mean_inputs(twenty_four_points().placements[0])
    assert_allclose(omega, [0, 0, EARTH_RATE], atol=1e-20)
    assert_allclose(force, [9.8, 0, 0], atol=1e-15)


def test_signs_of_the_plates_errors_by_hand():
    placement = Placement(label="1", axes="ENU", duration=1.0)
    size = 1e-6  # squares, 1e-12, are the truncation
    g, (_, north, up) = LABORATORY.gravity, LABORATORY.omega_ie_n
    cases = {
        "level_east": ([0, north + size * up, up - size * north], [0, size * g, g]),  # north edge up: y sees up
        "level_north": ([-size * up, north, up], [-size * g, 0, g]),  # x east dips
        "azimuth_error": ([size * north, north, up], [0, 0, g]),  # x goes from east to north
    }
    for name, (omega, force) in cases.items():
        seen = Laboratory(latitude=LABORATORY.latitude, **{name: size}).mean_inputs(placement)
        assert_allclose(seen[0], omega, atol=1e-12 * EARTH_RATE)
        assert_allclose(seen[1], force, atol=1e-12 * g)


def test_a_recording_holds_the_means_of_its_samples():
    schedule = twenty_four_points(3.0).select([0, 9]) + full_turns(120 * DEG).select([3])
    recording = CROOKED.record(EXACT, schedule, np.random.default_rng(0), sample_rate=4.0)
    assert list(recording.columns) == [*IMU_COLUMNS, "position"]
    assert recording.index.name == "time"
    assert_allclose(recording.index, np.arange(36) / 4, rtol=1e-15)
    assert list(recording["position"]) == ["1.1"] * 12 + ["3.2"] * 12 + ["y -360"] * 12
    for sample in (2, 15, 30):
        placement = schedule.placements[sample // 12]
        start = sample % 12 / 4
        omega, force = stepped(CROOKED, placement, start, start + 0.25)
        read = recording[list(IMU_COLUMNS)].to_numpy()[sample]
        # as above, times the scale factors; the angle of a step is 1e-4 rad, so the midpoint rule is exact to 1e-9
        assert_allclose(read[:3], GYROS.readings(omega), atol=4e5 * 1e-12)
        assert_allclose(read[3:], ACCELEROMETERS.readings(force), atol=1e4 * 1e-10)


def test_drawn_errors_have_their_deviations():
    laboratory = Laboratory(latitude=0.5, placement_error=1e-3, turn_error=2e-3, rate_error=1e-3)
    runs = 300
    level = Schedule([Placement(label=str(i), axes="UEN", duration=1.0) for i in range(runs)])
    tilt = laboratory.record(IDEAL, level, np.random.default_rng(1), sample_rate=2.0).iloc[::2]
    turns = Schedule([Placement(label=str(i), axes="UEN", duration=2.0, rate=1.0) for i in range(runs)])
    turned = Laboratory(latitude=0.5, turn_error=2e-3, rate_error=1e-3).record(
        IDEAL, turns, np.random.default_rng(2), sample_rate=1.0
    )
    five_sigma = 5 / np.sqrt(2 * runs)  # of a standard deviation; the tilts' squares are 1e-3 of it
    for name in ("accel_y", "accel_z"):
        assert_allclose(tilt[name].std() / laboratory.gravity, 1e-3, rtol=five_sigma)
    # an angle off by 2 mrad in 2 s, and a rate off by a thousandth
    assert_allclose(turned["gyro_x"].iloc[::2].std(), np.hypot(1e-3, 1e-3), rtol=five_sigma)


def test_drawn_errors_stay_during_a_placement():
    laboratory = Laboratory(latitude=0.5, placement_error=1e-3)
    recording = laboratory.record(IDEAL, six_positions(2.0), np.random.default_rng(3))
    spread = recording.groupby("position", observed=True)[list(IMU_COLUMNS)].agg(np.ptp)
    assert_allclose(spread, 0, atol=1e-14)  # rounding of the same product


def test_mechanical_gyros_feel_the_specific_force():
    gyros = Sensors(triad=LinearTriad(acceleration_sensitivity=np.diag([0, 0, 2.0])))
    unit = MeasurementUnit(gyros=gyros)
    laboratory = Laboratory(latitude=0.0, gravity=9.8)
    recording = laboratory.record(unit, six_positions(1.0), np.random.default_rng(0))
    means = recording.groupby("position", observed=True)["gyro_z"].mean()
    assert_allclose(means.loc[["5", "6"]], [19.6, -19.6], rtol=1e-14)  # z up and down; the Earth's rotation is level


def test_noise_goes_on_over_the_placements():
    # a rate random walk that began anew at each placement would start near zero there
    unit = MeasurementUnit(gyros=Sensors(random=RandomErrors(rate_random_walk=1.0)))
    recording = LABORATORY.record(unit, six_positions(100.0), np.random.default_rng(5), sample_rate=1.0)
    steps = recording["gyro_x"].diff()[1:]
    assert np.abs(steps).max() < 5 * np.sqrt(2 / 3)  # means of a walk differ by K^2 dt * 2 / 3; 5 sigma


@pytest.mark.parametrize(
    ("make", "kind", "message"),
    [
        (lambda: Laboratory(latitude=40), ValueError, "`latitude`"),
        (lambda: Laboratory(latitude=0.7, gravity=-9.8), ValueError, "`gravity`"),
        (lambda: Laboratory(latitude=0.7, level_east=0.6), ValueError, "`level_east`"),
        (lambda: Laboratory(latitude=0.7, level_north=-0.6), ValueError, "`level_north`"),
        (lambda: Laboratory(latitude=0.7, azimuth_error=1.0), ValueError, "`azimuth_error`"),
        (lambda: Laboratory(latitude=0.7, faces=np.zeros((5, 3))), ValueError, "`faces`"),
        (lambda: Laboratory(latitude=0.7, mounting=(0, 0, 1)), ValueError, "`mounting`"),
        (lambda: Laboratory(latitude=0.7, placement_error=-1e-3), ValueError, "`placement_error`"),
        (lambda: Laboratory(latitude=0.7, turn_error=-1e-3), ValueError, "`turn_error`"),
        (lambda: Laboratory(latitude=0.7, rate_error=np.nan), ValueError, "`rate_error`"),
        (lambda: LABORATORY.record(IDEAL, six_positions(), 1), TypeError, "`rng`"),
        (
            lambda: LABORATORY.record(IDEAL, six_positions(), np.random.default_rng(0), sample_rate=0),
            ValueError,
            "`sample_rate`",
        ),
        (
            lambda: LABORATORY.record(IDEAL, six_positions(0.1), np.random.default_rng(0)),
            ValueError,
            "`sample_rate` must give each placement two samples, got 10.0 Hz for '1' of 0.1 s",
        ),
    ],
)
def test_errors_name_the_argument(make, kind, message):
    with pytest.raises(kind, match=message):
        make()
