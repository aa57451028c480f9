"""Recordings of a turn against the increments of its motion, and against units that sit elsewhere."""

import numpy as np
import pytest
from laboratories import random_triad
from numpy.testing import assert_allclose, assert_array_equal

from fogkit.constants import EARTH_RATE
from fogkit.imu.size_effect import SizeEffect
from fogkit.imu.tables import IMU_COLUMNS
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors, Shape
from fogkit.noise.processes import RandomErrors
from fogkit.stand.rough_table import RoughTable
from fogkit.stand.turn_recordings import exact_inputs, record
from fogkit.stand.turn_tests import nine_tests
from fogkit.units import DEG

PLAN = nine_tests(dwell=1.0, turn_duration=6.0)[3:5]
MOTIONS = RoughTable.typical(53.9 * DEG).motions(PLAN, np.random.default_rng(1))
IDEAL = MeasurementUnit()


def test_an_ideal_unit_records_the_increments():
    tables = record(IDEAL, MOTIONS)
    assert len(tables) == 2
    for table, motion in zip(tables, MOTIONS, strict=True):
        assert tuple(table.columns) == IMU_COLUMNS
        assert table.index.name == "time"
        assert_allclose(table.index, np.arange(800) / 100, rtol=1e-15)
        assert_allclose(table.to_numpy(), motion.increments(100.0), rtol=1e-14, atol=1e-18)


def test_triads_shapes_and_range_act_on_the_means():
    rng = np.random.default_rng(2)
    gyros, accelerometers = random_triad(rng, 1e3, 0.1, sensitivity=1e-3), random_triad(rng, 10.0, 0.1)
    shape = Shape(quadratic=(1e-3, 2e-3, 3e-3), asymmetry=(1e-2, 0, 0))
    unit = MeasurementUnit(
        gyros=Sensors(triad=gyros), accelerometers=Sensors(triad=accelerometers, shape=shape, range=9.0)
    )
    (table,) = record(unit, MOTIONS[:1], 50.0)
    means = MOTIONS[0].increments(50.0) * 50
    expected = gyros.readings(means[:, :3], means[:, 3:]), unit.accelerometers.expected(means[:, 3:])
    # rounding of readings of up to 2e4 and 200
    assert_allclose(table.to_numpy()[:, :3], expected[0] / 50, atol=2e4 * 1e-15)
    assert_allclose(table.to_numpy()[:, 3:], expected[1] / 50, atol=200 * 1e-15)


def test_a_delay_of_steps_is_a_shift():
    unit = MeasurementUnit(gyros=Sensors(delay=(0.03, 0, -0.01)), accelerometers=Sensors(delay=(0, 0.02, 0)))
    delayed, exact = (record(which, MOTIONS)[0].to_numpy() for which in (unit, IDEAL))
    for column, steps in enumerate((3, 0, -1, 0, 2, 0)):
        moved = np.roll(exact[:, column], steps)
        assert_allclose(delayed[10:-10, column], moved[10:-10], atol=1e-13)  # rounding of times, by gravity
    # rest goes on before and after
    assert_allclose(delayed[:3, 0], exact[0, 0], atol=1e-18)


def test_a_delay_of_less_than_a_step_is_that_of_finer_steps():
    unit = MeasurementUnit(gyros=Sensors(delay=(0.0025,) * 3), accelerometers=Sensors(delay=(0.005,) * 3))
    delayed, fine = record(unit, MOTIONS)[0].to_numpy(), record(IDEAL, MOTIONS, 400.0)[0].to_numpy()
    for columns, quarter in ((slice(0, 3), 1), (slice(3, 6), 2)):
        sums = np.concatenate([fine[:1, columns]] * quarter + [fine[:, columns]])[: len(fine)]
        assert_allclose(delayed[:, columns], sums.reshape(-1, 4, 3).sum(axis=1), atol=1e-13)


def test_one_centre_is_a_unit_that_sits_there():
    centre = np.array([0.02, -0.03, 0.01])
    table = RoughTable.typical(53.9 * DEG, 1.0, absorber=None)  # absorbers turn the block about the reference point
    there = RoughTable.typical(53.9 * DEG, 1.0, absorber=None, offset=table.offset + centre)
    here, moved = (which.motions(PLAN, np.random.default_rng(1)) for which in (table, there))
    unit = MeasurementUnit(size_effect=SizeEffect.one_point(np.tile(centre, (3, 1))))
    seen, expected = record(unit, here)[1], record(IDEAL, moved)[1]
    # the Earth's rotation presses the centre outwards by 2e-10 m/s^2, which the moved unit leaves out
    assert_allclose(seen, expected, atol=EARTH_RATE**2 * 0.04 / 100 + 1e-13)
    assert (seen - record(IDEAL, here)[1]).abs().to_numpy().max() > 1e-3 * 0.01


def test_two_centres_by_hand_and_each_with_its_delay():
    rng = np.random.default_rng(4)
    first, second = rng.uniform(-0.03, 0.03, (2, 3, 3))
    axes = random_triad(rng, 1.0, 0.0)
    delay = (0.01, 0.0, 0.02)
    unit = MeasurementUnit(
        accelerometers=Sensors(triad=axes, delay=delay),
        size_effect=SizeEffect(acceleration_centres=first, velocity_centres=second),
    )
    motion = MOTIONS[0]
    read = record(unit, [motion], 100.0)[0].to_numpy()[:, 3:]
    nodes, weights = np.polynomial.legendre.leggauss(8)
    for step in (50, 110, 400, 695, 703, 750):
        for i in range(3):
            time = (step + 0.5 + nodes / 2) / 100 - delay[i]
            w, h = motion.omega_ib_b(time), 1e-4
            alpha = (motion.omega_ib_b(time + h) - motion.omega_ib_b(time - h)) / (2 * h)
            felt = motion.f_ib_b(time) + np.cross(alpha, first[i]) + np.cross(w, np.cross(w, second[i]))
            # third derivative of the ringing rate, 0.05 rad/s * (94/s)^3, times h^2 / 6 and 3 cm, over a step
            assert_allclose(read[step, i], weights @ felt / 200 @ np.array(axes.matrix)[i], atol=5e-8)
    assert not np.allclose(read, record(MeasurementUnit(accelerometers=unit.accelerometers), [motion])[0].iloc[:, 3:])


def test_only_the_noise_is_drawn_anew():
    white = RandomErrors(angle_random_walk=1e-3)
    unit = MeasurementUnit(gyros=Sensors(random=white), accelerometers=Sensors(random=white))
    exact, rng = exact_inputs(unit, MOTIONS), np.random.default_rng(3)
    runs = np.array([exact.arrays(rng)[1] for _ in range(4)])
    errors = runs - MOTIONS[1].increments(100.0)
    # N * sqrt(dt), 5 sigma of the deviation of 19200 numbers
    assert_allclose(errors.std(), 1e-3 * np.sqrt(0.01), rtol=5 / np.sqrt(2 * errors.size))
    assert np.abs(np.corrcoef(errors.transpose(0, 2, 1).reshape(24, -1)) - np.eye(24)).max() < 5.5 / np.sqrt(800)
    again = record(unit, MOTIONS, rng=np.random.default_rng(3))
    assert_array_equal(again[1].to_numpy(), runs[0])


def test_pulses_are_whole_in_each_test():
    unit = MeasurementUnit(
        gyros=Sensors(triad=LinearTriad(matrix=1e5 * np.eye(3)), pulse=1.0),
        accelerometers=Sensors(triad=LinearTriad(matrix=1e4 * np.eye(3)), pulse=1.0),
    )
    for table, motion in zip(record(unit, MOTIONS), MOTIONS, strict=True):
        assert_allclose(table, np.rint(table), atol=1e-9)  # rounding of a product of up to 1e4
        lost = np.cumsum(table.to_numpy() - motion.increments(100.0) * np.repeat([1e5, 1e4], 3), axis=0)
        assert np.abs(lost).max() <= 0.5 + 1e-6


@pytest.mark.parametrize(
    ("make", "kind", "message"),
    [
        (lambda: record("unit", MOTIONS), TypeError, "`unit`"),
        (lambda: record(IDEAL, []), ValueError, "`motions`"),
        (lambda: record(IDEAL, MOTIONS[0]), ValueError, "`motions`"),
        (lambda: record(IDEAL, PLAN), TypeError, "`motions`"),
        (lambda: record(IDEAL, MOTIONS, 0.0), ValueError, "`rate`"),
        (lambda: record(IDEAL, MOTIONS, 33.3), ValueError, "`rate` must give a whole number of steps"),
        (lambda: record(IDEAL, MOTIONS, rng=42), TypeError, "`rng`"),
        (
            lambda: record(MeasurementUnit(gyros=Sensors(random=RandomErrors(rate_ramp=1e-9))), MOTIONS),
            ValueError,
            "`rng` must be given",
        ),
    ],
)
def test_errors_name_the_argument(make, kind, message):
    with pytest.raises(kind, match=message):
        make()
