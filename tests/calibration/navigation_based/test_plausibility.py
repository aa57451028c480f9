"""Recordings that are not what they should be: each is refused, or warned of, by name."""

import numpy as np
import pandas as pd
import pytest

from fogkit.calibration.navigation_based import calibrate, model_matrix, prepare
from fogkit.calibration.navigation_based.plausibility import warn_of_few_turns
from fogkit.calibration.navigation_based.recordings import find_dwells
from fogkit.calibration.navigation_based.turn_model import PARAMETERS
from fogkit.estimation import linear
from fogkit.imu.tables import ACCEL_COLUMNS, GYRO_COLUMNS
from fogkit.stand.turn_tests import nine_tests
from fogkit.units import DEG

GYRO, ACCEL = list(GYRO_COLUMNS), list(ACCEL_COLUMNS)


def spoil(case, test, change):
    """Recordings with one of them changed."""
    tables = list(case.recordings)
    tables[test] = change(tables[test].copy())
    return tables


def scaled(columns, factor):
    def change(table):
        table[columns] *= factor
        return table

    return change


def rate_in(first, last, rate, axis="gyro_x"):
    """A motion that the plan knows nothing of."""

    def change(table):
        table.loc[(table.index >= first) & (table.index < last), axis] += rate * 0.01
        return table

    return change


def saturated(table):
    limit = 0.97 * table.gyro_y.abs().max()
    table.gyro_y = table.gyro_y.clip(-limit, limit)
    return table


def resampled(table):
    """Every other sample kept, as if it were a rate."""
    return table.iloc[::2]


CASES = {
    "gap": (0, lambda t: t.drop(t.index[500:600]), r"recordings\[0\] \(test 1\)\.index` must be equally spaced"),
    "order": (1, lambda t: t.iloc[::-1], r"recordings\[1\] \(test 2\)\.index` must be times in ascending order"),
    "resampled": (2, resampled, r"must feel gravity, 9\.8.* A recording is thinned out by sums"),
    "not from 0": (3, lambda t: t.set_index(t.index + 5.0), "must begin at 0 s, got 5 s"),
    "missing dwell": (4, lambda t: t.iloc[:1700], r"test 5\)` .* The second dwell, from 17 to 22 s, is missing"),
    "short dwell": (4, lambda t: t.iloc[:2000], "The second dwell, to 22 s, is cut short"),
    "moving dwell": (5, rate_in(2.0, 4.0, 1 * DEG), r"test 6\)` must be at rest in dwell 1"),
    "moving second dwell": (5, rate_in(18.0, 20.0, 2 * DEG), "must be at rest in dwell 2, .* largest at"),
    "specific force": (6, scaled(ACCEL, 100), "specific forces in place of increments"),
    "g": (6, scaled(ACCEL, 1 / 9.80665), "in units of g s"),
    "degrees": (7, scaled(GYRO, 1 / DEG), r"test 8\)` must turn by .* These look like in deg in place of rad"),
    "rates": (7, scaled(GYRO, 100), "These look like rates in place of increments"),
    "rates in deg/s": (7, scaled(GYRO, 100 / DEG), "These look like rates in deg/s"),
    "half the turn": (7, scaled(["gyro_z"], 0.5), r"must turn by \[0\.0, 0\.0, 1980\.0\] deg about x, y, z, got"),
    "other sense": (7, scaled(GYRO, -1), r"must turn by \[0\.0, 0\.0, 1980\.0\] deg about x, y, z, got \[.*-1981"),
    "lost step": (
        0,
        lambda t: t.drop(t.index[1100]).set_index(t.index[:-1]),
        "must be as long as its test, 22 s, got 21.99",
    ),
    "saturated": (3, saturated, r"test 4\)` must not be saturated, got \d+ equal readings of .* in 'gyro_y'"),
    "not finite": (
        8,
        lambda t: t.replace(t.accel_y.iloc[100], np.nan),
        r"recordings\[8\] \(test 9\).*must be finite, got nan",
    ),
    "no column": (8, lambda t: t.drop(columns="gyro_z"), "so without 'gyro_z'"),
}


@pytest.mark.parametrize("name", CASES)
def test_bad_recordings(case, name):
    test, change, words = CASES[name]
    with pytest.raises(ValueError, match=words):
        calibrate(spoil(case, test, change), case.plan, case.latitude)


def test_a_noisy_channel_that_hangs(case):
    # half a second of equal gyro readings in the turn: the calibration would be off by tens of arcsec
    def noisy(table):
        table += 1e-6 * np.random.default_rng(1).normal(size=table.shape)
        table.iloc[900:950, 0] = table.iloc[900, 0]
        return table

    with pytest.raises(ValueError, match=r"test 1\)` must not hang, got 50 equal readings of .* 'gyro_x' from 9 s"):
        calibrate(spoil(case, 0, noisy), case.plan, case.latitude)


def test_swapped_recordings_are_recognised(case):
    tables = list(case.recordings)
    tables[0], tables[7] = tables[7], tables[0]
    with pytest.raises(ValueError, match=r"test 1\)` must have \+z up in dwell 1, got -x up .* would fit test 8"):
        calibrate(tables, case.plan, case.latitude)


def test_wrong_number_or_kind(case):
    with pytest.raises(ValueError, match="one for each of the 9 tests of the plan, got 8"):
        calibrate(case.recordings[:8], case.plan, case.latitude)
    with pytest.raises(TypeError, match="must be a sequence of tables"):
        calibrate(pd.concat(case.recordings), case.plan, case.latitude)
    with pytest.raises(TypeError, match=r"`plan\[0\]` must be a TurnTest"):
        calibrate(case.recordings, ["1"] * 9, case.latitude)


def test_slight_motion_is_a_warning(case):
    tables = spoil(case, 5, rate_in(19.0, 19.5, 0.3 * DEG))
    with pytest.warns(UserWarning, match=r"test 6\)` moves by 0.1\d* deg in dwell 2"):
        calibrate(tables, case.plan, case.latitude)


def test_dwells_from_the_gyros(case):
    for table, test in zip(case.recordings, case.plan, strict=True):
        (first, stop), (begin, end) = find_dwells(table[GYRO].to_numpy(), 0.01)
        assert first == 0 and end == len(table)
        # a window or two of 0.5 s clear of the turn, and inside of the dwells of the plan
        assert test.dwell - 1.5 <= stop * 0.01 <= test.dwell
        assert 0 <= begin * 0.01 - test.dwell - test.turn_duration <= 1.5
    assert find_dwells(np.zeros((1000, 3)), 0.01) is None
    detected = prepare(case.recordings, case.plan, case.latitude, dwells="detected")
    assert all(recording.dwells[0][1] < 500 for recording in detected.recordings)


def test_few_turns_are_a_warning():
    plan = nine_tests(turns=0)
    H = model_matrix(plan, 9.8)
    solution = linear(H, np.zeros(18), standard_deviation=1e-4, names=PARAMETERS)
    with pytest.warns(UserWarning, match="more than 180 deg about [xyz]: the scale factor of that gyro is known to"):
        warn_of_few_turns(plan, solution)
