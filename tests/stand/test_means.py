"""Means of recordings, their covariance, their combinations, and the recordings that are refused."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from laboratories import ACCELEROMETERS, CROOKED, EQUIVALENTS, EXACT, GYROS, LABORATORY, NOISY, WHITE, measured
from numpy.testing import assert_allclose, assert_array_equal

from fogkit.estimation.consistency import chi_square_interval
from fogkit.imu.tables import IMU_COLUMNS
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors
from fogkit.noise.processes import RandomErrors
from fogkit.reproduction.beihang.examples import ROOM
from fogkit.reproduction.beihang.laboratory import PLACE, example_unit
from fogkit.stand.laboratory import Laboratory
from fogkit.stand.means import expected_inputs, observations, with_inputs
from fogkit.stand.placements import (
    Placement,
    Schedule,
    full_turns,
    rate_sequence,
    six_positions,
    three_positions_east,
    twenty_four_points,
)
from fogkit.units import ARCSEC, DEG, DEG_PER_SQRT_HOUR

SIX = six_positions(3.0)
POINTS = twenty_four_points(3.0)
TURNS = full_turns(36 * DEG)


def recorded(schedule=SIX, unit=NOISY, laboratory=LABORATORY, seed=0):
    table = laboratory.record(unit, schedule, np.random.default_rng(seed))
    return table.assign(position=table["position"].astype(object))


def test_means_are_what_the_unit_reads_of_the_expected_inputs():
    schedule = POINTS + TURNS
    observed = measured(EXACT, schedule, CROOKED)
    omega, force = expected_inputs(schedule, CROOKED)
    # rounding of the mean of 100 samples of size 2.5e5 and 1e5
    assert_allclose(observed.readings[:, :3], GYROS.readings(omega), atol=1e-15 * 100 * 2.5e5)
    assert_allclose(observed.readings[:, 3:], ACCELEROMETERS.readings(force), atol=1e-15 * 100 * 1e5)
    assert_array_equal(observed.omega_ib_b, omega)
    assert_array_equal(observed.f_ib_b, force)
    assert_array_equal(observed.bias_share, np.ones(30))
    assert observed.covariance is None  # nothing is known of the noise where there is none
    assert observed.labels == tuple(schedule.labels)
    table = observed.to_frame()
    assert list(table.columns) == list(IMU_COLUMNS)
    assert_array_equal(table.loc["y +360"], observed.readings[26])


def test_samples_between_placements_are_left_out():
    table = recorded()
    gap = table.iloc[:7].assign(position=np.nan, gyro_x=1e9)
    pieces = [part for _, piece in table.groupby("position", sort=False) for part in (gap, piece)]
    longer = pd.concat(pieces)
    longer.index = np.arange(len(longer)) * 0.1
    assert_allclose(
        observations(longer, SIX, LABORATORY).readings, observations(table, SIX, LABORATORY).readings, rtol=1e-14
    )
    text = longer.assign(position=longer["position"].astype("string"))  # whose missing label is another object
    assert_allclose(observations(text, SIX, LABORATORY).readings, observations(table, SIX, LABORATORY).readings)


def test_positions_may_come_in_any_order():
    table = recorded()
    back = pd.concat([piece for _, piece in table.groupby("position")][::-1])
    assert_array_equal(observations(back, SIX, LABORATORY).readings, observations(table, SIX, LABORATORY).readings)


def test_covariance_from_stated_errors_follows_the_recording():
    schedule = Schedule(
        [Placement(label="1", axes="UEN", duration=4.0), Placement(label="2", axes="DES", duration=4.0)]
    )
    random = (RandomErrors(angle_random_walk=3.0), RandomErrors(bias_instability=2.0))
    equivalents = [1, 2, 3, EQUIVALENTS[3], 5, -6]  # with x up and down the recording shows that of accelerometer x
    observed = observations(recorded(schedule), schedule, LABORATORY, random=random, equivalents=equivalents)
    assert_allclose(observed.covariance[1], 4 * 9 / 4 * np.eye(2), rtol=1e-14)  # equivalent^2 N^2 / tau
    # half the mean square of a difference of neighbours is the Allan variance, whatever was before
    (a, c), (_, b) = observed.covariance[5]
    assert_allclose((a + b - 2 * c) / 2, 36 * 2 * np.log(2) / np.pi * 4, rtol=1e-12)
    assert c > 0


def test_time_between_positions_counts_for_a_bias_that_wanders():
    schedule = Schedule([Placement(label=label, axes="UEN", duration=4.0) for label in "12"])
    table = recorded(schedule)
    later = table.set_axis(np.where(table.position == "1", table.index, table.index + 3600.0)).rename_axis("time")
    wandering = (RandomErrors(bias_instability=2.0),) * 2

    def apart(recording):
        C = observations(recording, schedule, LABORATORY, random=wandering).covariance[0]
        return C[0, 0] + C[1, 1] - 2 * C[0, 1]

    assert apart(later) > 3 * apart(table)


@pytest.mark.parametrize("laboratory", [LABORATORY, CROOKED], ids=["level", "crooked"])
def test_covariance_from_scatter_is_that_of_the_noise(laboratory):
    # in a turn the scatter of the samples is mostly that of tilts and of the Earth's rotation, a thousand times as much
    schedule = six_positions(20.0) + TURNS + rate_sequence([0.3, -0.003], 20.0)
    random_walks = np.repeat([errors.angle_random_walk for errors in WHITE], 3)
    equivalents = np.concatenate([GYROS.equivalents, ACCELEROMETERS.equivalents])
    durations = np.array([placement.duration for placement in schedule.placements])
    truth = (random_walks * equivalents)[:, None] ** 2 / durations  # white noise of the rate, averaged
    found = np.diagonal(measured(NOISY, schedule, laboratory, seed=4).covariance, axis1=1, axis2=2)
    free = np.round(durations * 10) - np.where([placement.rate != 0 for placement in schedule.placements], 3, 1)
    # chi-square of a variance, for the worst of 6 * 18 of them: 1e-5 each is 1e-3 for all
    for ratio, count in zip((found / truth).T, free, strict=True):
        low, high = np.array(chi_square_interval(int(count), 1, 1 - 1e-5)) / count
        assert (low < ratio).all()
        assert (ratio < high).all()


def test_scatter_of_two_or_three_samples():
    schedule = Schedule([Placement(label="1", axes="UEN", duration=0.3, rate=1.0)])
    observed = observations(recorded(schedule), schedule, LABORATORY)
    values = recorded(schedule)[list(IMU_COLUMNS)].to_numpy()
    assert_allclose(observed.covariance[:, 0, 0], values.var(axis=0, ddof=1) / 3, rtol=1e-10)  # squares cancel


def test_combinations_by_hand():
    observed = measured(NOISY, SIX, random=WHITE)
    difference = observed.combine([[0.5, -0.5, 0, 0, 0, 0], [0, 0, 1, 1, 0, 0]], ["half", "sum"])
    assert difference.labels == ("half", "sum")
    assert_allclose(difference.readings[0], (observed.readings[0] - observed.readings[1]) / 2, rtol=1e-14)
    assert_allclose(difference.omega_ib_b[1], observed.omega_ib_b[2] + observed.omega_ib_b[3], atol=1e-18)
    assert_allclose(difference.f_ib_b[0], [LABORATORY.gravity, 0, 0], atol=1e-14)
    assert_array_equal(difference.bias_share, [0, 2])
    variance = observed.covariance[0, 0, 0]
    assert_allclose(difference.covariance[0], variance * np.diag([0.5, 2]), rtol=1e-14)


def test_joined_observations_are_independent():
    one, two = measured(NOISY, SIX, random=WHITE), measured(NOISY, TURNS, random=WHITE, seed=1)
    both = one.joined(two)
    assert both.labels == one.labels + two.labels
    assert_array_equal(
        both.covariance[2], np.diag(np.concatenate([c[2].diagonal() for c in (one.covariance, two.covariance)]))
    )
    assert_array_equal(both.readings[6:], two.readings)
    assert_array_equal(both.omega_ib_b[:6], one.omega_ib_b)
    assert one.joined(replace(two, covariance=None)).covariance is None


def changed(position, channel, value, at=slice(None)):
    """Recording whose channel was overwritten in a position."""

    def change(table):
        rows = np.flatnonzero(table["position"] == position)[at]
        table.iloc[rows, table.columns.get_loc(channel)] = value
        return table

    return change


def clipped(position, channel, share):
    def change(table):
        rows = table["position"] == position
        limit = table.loc[rows, channel].quantile(1 - share)
        table.loc[rows, channel] = table.loc[rows, channel].clip(upper=limit)
        return table

    return change


def relabelled(names):
    return lambda table: table.assign(position=table["position"].replace(names))


def stretched(table):
    table.index = np.arange(len(table)) * 0.1 + 0.01 * (np.arange(len(table)) > 40)
    return table


def slowed(table):
    table.index = table.index * 1.5
    return table


def stood_still(table):
    table.index = np.zeros(len(table))
    return table


REFUSED = {
    "missing": (lambda t: t[t["position"] != "3"], "`recording` must hold every position .* got none of '3'$"),
    "empty": (lambda t: t.iloc[:0], "got none of '1', '2', '3', '4', '5', '6'$"),
    "unknown": (relabelled({"3": "3a"}), "got none of '3'"),
    "too many": (lambda t: pd.concat([t, t.iloc[:30].assign(position="7")]), "not in the schedule: '7'"),
    "repeated": (lambda t: pd.concat([t, t.iloc[:30]]), "once and in one piece, got '1' repeatedly"),
    "split": (changed("4", "position", np.nan, [12]), "once and in one piece, got '4' repeatedly"),
    "column": (lambda t: t.drop(columns="accel_y"), "accel_y"),
    "no number": (changed("2", "gyro_z", np.nan, [3]), "position '2': `gyro_z` must be finite, got nan at 3.3 s"),
    "infinite": (changed("6", "accel_x", -np.inf, [0]), "position '6': `accel_x` must be finite, got -inf at 15 s"),
    "lost": (lambda t: t.drop(t.index[40]), "position '2' must be sampled evenly, got a step of 0.2 s at 3.9 s"),
    "uneven": (stretched, "position '2' must be sampled evenly, got a step of 0.11 s at 4 s"),
    "no time": (stood_still, "position '1' must be sampled evenly, got a step of 0 s"),
    "backwards": (lambda t: t.iloc[::-1], "must be sampled evenly, got a step of -0.1 s"),
    "too short": (changed("5", "position", None, slice(20)), "position '5' must last 3 s, got 1 s of samples"),
    "one sample": (changed("5", "position", None, slice(29)), "position '5' must have at least 2 samples, got 1"),
    "too long": (slowed, "position '1' must last 3 s, got 4.5 s"),
    "clipped": (clipped("3", "accel_z", 0.4), "position '3': `accel_z` is clipped, 4[0-9]% of its samples are"),
    "frozen": (changed("2", "gyro_y", 12.5), "position '2': `gyro_y` is frozen at 12.5"),
    "swapped": (relabelled({"1": "3", "3": "1"}), "position '1' has x up by its label, but `accel_x` .* x level"),
    "one down": (relabelled({"2": "5", "5": "2"}), "position '2' has x down by its label, but `accel_x` .* x level"),
    "dead": (lambda t: t.assign(accel_y=7.0), "position '1': `accel_y` is frozen at 7"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_wrong_is_named(name):
    change, message = REFUSED[name]
    with pytest.raises(ValueError, match=message):
        observations(change(recorded()), SIX, LABORATORY)


UNSUITABLE = {
    "time as a column": (lambda t: (t.reset_index(), SIX, LABORATORY), ValueError, "set_index"),
    "labels that are numbers": (
        lambda t: (t.assign(position=t.position.astype(int)), SIX, LABORATORY),
        TypeError,
        "`recording['position']` must hold labels as text, got numbers",
    ),
    "readings that are text": (
        lambda t: (t.assign(gyro_y=t.gyro_y.astype(str)), SIX, LABORATORY),
        TypeError,
        "`recording['gyro_y']` must hold real numbers",
    ),
    "list of placements": (lambda t: (t, SIX.placements, LABORATORY), TypeError, "`schedule` must be a Schedule"),
    "latitude alone": (lambda t: (t, SIX, 0.7), TypeError, "`laboratory` must be a Laboratory, got float"),
}


@pytest.mark.parametrize("name", UNSUITABLE)
def test_what_is_of_the_wrong_kind_is_named(name):
    make, kind, message = UNSUITABLE[name]
    with pytest.raises(kind, match=re.escape(message)):
        observations(*make(recorded()))


def test_random_errors_are_those_of_both_kinds():
    with pytest.raises(TypeError, match="`random` must be two RandomErrors"):
        observations(recorded(), SIX, LABORATORY, random=RandomErrors())


def test_equivalents_that_do_not_fit_the_readings_are_doubted():
    random = (NOISY.gyros.random, NOISY.accelerometers.random)
    wrong = (*EQUIVALENTS[:4], 3 * EQUIVALENTS[4], EQUIVALENTS[5])
    with pytest.warns(UserWarning, match=re.escape(f"`equivalents` has {wrong[4]:.4g} for `accel_y`, which reads")):
        observations(recorded(), SIX, LABORATORY, random=random, equivalents=wrong)


def test_low_clipping_is_found_too():
    table = recorded()
    rows = table["position"] == "3"
    table.loc[rows, "gyro_x"] = table.loc[rows, "gyro_x"].clip(lower=table.loc[rows, "gyro_x"].median())
    with pytest.raises(ValueError, match="position '3': `gyro_x` is clipped"):
        observations(table, SIX, LABORATORY)


def test_a_gyro_turned_beyond_its_range_is_frozen_or_clipped():
    unit = replace(NOISY, gyros=replace(NOISY.gyros, range=0.2))
    schedule = rate_sequence([0.0, 0.1, 0.21], 10.0)
    with pytest.raises(ValueError, match=re.escape("position 'x +12.0321137 deg/s': `gyro_x` is frozen")):
        measured(unit, schedule)
    # noise of 3e-6 rad/s at the end of the range: half of the samples
    with pytest.raises(ValueError, match=re.escape("position 'x +11.4591559 deg/s': `gyro_x` is clipped")):
        measured(unit, rate_sequence([0.0, 0.2], 10.0), Laboratory(latitude=0.0))  # the Earth adds nothing upright


def test_two_points_swapped_among_the_24():
    table = relabelled({"1.2": "2.1", "2.1": "1.2"})(recorded(POINTS))
    with pytest.raises(
        ValueError, match=r"position '1.2' has x up by its label, but `accel_x` reads -1.00 of its span: x down"
    ):
        observations(table, POINTS, LABORATORY)


def test_tilted_about_the_wrong_axis():
    # position 5, z up, was laid down with y up
    laid = Schedule([replace(p, axes="NUE") if p.label == "5" else p for p in SIX.placements])
    with pytest.raises(ValueError, match=r"position '5' has y level by its label, but `accel_y` .* y up"):
        observations(recorded(laid), SIX, LABORATORY)


def test_a_dead_accelerometer_without_noise_is_refused_for_its_span():
    table = recorded(unit=EXACT).assign(accel_z=0.0)
    with pytest.raises(ValueError, match=r"position '5' has z up by its label, but `accel_z` reads \+0.00 of its span"):
        observations(table, SIX, LABORATORY)


COUNTED = {
    "fine": (0.05 * ARCSEC, 1e-5),
    "usual": (0.5 * ARCSEC, 1e-4),
    "coarse": (5 * ARCSEC, 1e-3),
}
PLANS = {
    "24 points": twenty_four_points(10.0),
    "turns": full_turns(6 * DEG) + six_positions(10.0),
    "turns alone": full_turns(36 * DEG),
    "low rates": rate_sequence([0.0, 1e-4, -1e-4, 1e-3, -1e-3], 20.0),
    "east": three_positions_east(20.0),
}


@pytest.mark.parametrize("plan", PLANS)
@pytest.mark.parametrize("noise", [0.0, 1.0], ids=["exact", "noisy"])
@pytest.mark.parametrize("pulse", COUNTED)
def test_no_alarm_for_counted_pulses(pulse, noise, plan):
    walk = noise * 0.001 * DEG_PER_SQRT_HOUR
    # a unit without biases: a level gyro to the east counts no pulse at all
    unit = MeasurementUnit(
        gyros=Sensors(pulse=COUNTED[pulse][0], random=RandomErrors(angle_random_walk=walk)),
        accelerometers=Sensors(pulse=COUNTED[pulse][1], random=RandomErrors(angle_random_walk=noise * 1e-4)),
    )
    schedule = PLANS[plan]
    observed = measured(unit, schedule, CROOKED)
    durations = np.array([placement.duration for placement in schedule.placements])
    # counting loses half a pulse at either end of a placement, noise is 5 sigma
    lost = COUNTED[pulse][0] + 5 * walk * np.sqrt(durations)
    assert (np.abs(observed.readings[:, :3] - observed.omega_ib_b) * durations[:, None] < lost[:, None] + 1e-12).all()


@pytest.mark.parametrize("plan", PLANS)
@settings(max_examples=10)
@given(seed=st.integers(0, 2**32 - 1))
def test_no_alarm_without_noise(plan, seed):
    rng = np.random.default_rng(seed)
    laboratory = replace(
        LABORATORY,
        latitude=rng.uniform(-1.5, 1.5),
        level_east=10.0 ** -rng.uniform(2, 16),
        mounting=rng.normal(0, 1e-3, 3),
    )
    assert measured(EXACT, PLANS[plan], laboratory, sample_rate=2.0).covariance is None


def test_no_alarm_for_rounding():
    # a noise-free channel near the crest of a slow sine: six readings one rounding apart, half of them the largest
    table = recorded(unit=EXACT)
    rows = np.flatnonzero(table["position"] == "3")
    value = table["accel_z"].iloc[rows[0]]
    steps = np.concatenate([np.arange(-15, 0) % 5 - 5, np.zeros(15)])
    table.iloc[rows, table.columns.get_loc("accel_z")] = value + np.spacing(value) * steps
    assert len(np.unique(table["accel_z"].iloc[rows])) == 6
    assert observations(table, SIX, LABORATORY).covariance is None


def test_an_accelerometer_that_points_backwards_looks_like_positions_swapped():
    matrix = np.diag([1.0, -1.0, 1.0])
    unit = replace(NOISY, accelerometers=replace(NOISY.accelerometers, triad=LinearTriad(matrix=matrix)))
    with pytest.warns(UserWarning, match=r"`accel_y` reads less with y up than with y down: .* '3', '4' were swapped"):
        observed = measured(unit, SIX)
    assert observed.readings[2, 4] < -9  # y up
    observations(recorded(unit=unit), SIX, LABORATORY, equivalents=(1, 1, 1, 1, -1, 1))
    with pytest.warns(UserWarning, match="positions '1', '2' were swapped"):
        observations(relabelled({"1": "2", "2": "1"})(recorded()), SIX, LABORATORY)


def test_readings_of_few_levels_are_not_clipped_by_chance():
    # counted in pulses at 2 Hz, a tilted unit that turns reads a sine of a few levels
    unit, plan = example_unit(), full_turns()
    for seed in range(20):
        table = ROOM.record(unit, plan, np.random.default_rng(seed), sample_rate=2.0)
        observations(table, plan, PLACE)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda o: o.combine(np.ones((1, 5)), ["a"]), "`weights`"),
        (lambda o: o.combine(np.ones((2, 6)), ["a"]), "`labels` must be one for each row of `weights`, 2, got 1"),
        (
            lambda o: observations(recorded(), SIX, LABORATORY, random=WHITE, equivalents=EQUIVALENTS[:3]),
            "`equivalents`",
        ),
    ],
)
def test_errors_name_the_argument(make, message):
    with pytest.raises(ValueError, match=message):
        make(measured(EXACT, SIX))


def test_readings_without_a_recording_need_a_row_for_each_placement():
    readings = np.ones((6, 6))
    observed = with_inputs(readings, SIX, LABORATORY)
    assert_array_equal(observed.omega_ib_b, observations(recorded(), SIX, LABORATORY).omega_ib_b)
    with pytest.raises(ValueError, match="`readings` must be of shape"):
        with_inputs(readings[:5], SIX, LABORATORY)
