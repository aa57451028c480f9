"""Latitudes and manoeuvres: stored runs of the filter, standard deviations, and what they must obey."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose
from scipy.special import jn_zeros

from fogkit.constants import EARTH_RATE
from fogkit.estimation.consistency import chi_square_interval
from fogkit.gyrocompass.laws import ConstantSpeedReversal
from fogkit.reproduction.lechang import latitudes, manoeuvres
from fogkit.units import DEG

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def stored():
    return pd.read_csv(ROOT / latitudes.LATITUDE_RUNS)


def test_stored_runs_are_those_of_the_function(stored):
    for lat, speed, grade in ((60.0, 5.0, 1.0), (89.9, 5.0, 0.01)):
        again = latitudes.latitude_case(5, lat, 30.0, speed, grade)
        keys = {"lat": lat, "speed": speed, "grade": grade, "heading_std": 30.0, "seed": 5}
        (row,) = stored[np.logical_and.reduce([stored[key] == value for key, value in keys.items()])].to_dict("records")
        # five decimals are stored; other processors round another way
        assert_allclose([row[key] for key in again], list(again.values()), rtol=1e-3, atol=1e-3)


def test_consistent_at_every_latitude(stored):
    table = latitudes.by_latitude(stored)
    assert len(table) == 48 and (table.seeds == 20).all()
    # 48 groups of the same seeds, each within its bounds with 99.9 percent
    assert table.consistent.all()
    low, high = chi_square_interval(17, len(stored), 0.999)
    assert low < stored.nees.mean() * 1.05 and stored.nees.mean() * 0.95 < high  # seeds are shared: not independent


def test_no_latitude_does_better_than_the_bound(stored):
    table = latitudes.by_latitude(stored)
    # where heading is known from the start to less than the bound, the start counts
    found = table[table.bound < 1]
    assert (found.predicted_std > found.bound).all()
    # N/(omega_ie cos(lat) sqrt(T)) is that without biases; of 180 degrees 5 percent are lost, and at most a factor of
    # two where the hull may drift
    grade, lat = (table.index.get_level_values(name).to_numpy() for name in ("grade", "lat"))
    walk = 0.01e-3 / 34e-3 * DEG * grade
    best = walk / (EARTH_RATE * np.cos(lat * DEG) * 300**0.5) / DEG
    assert (table.bound >= best).all() and (table.bound < 2.11 * best).all()


def test_a_change_of_velocity_finds_heading_by_itself():
    # turns of the velocity by 90 degrees: heading is the direction of the change, 7.07 m/s, known as the aid knows it
    zigzag = ConstantSpeedReversal(amplitude=45 * DEG, period=100.0, reversal_time=10.0)
    for std in (0.01, 0.1):
        under_way = manoeuvres.end_of(5.0, std, turning=zigzag)["heading_deg"]
        at_rest = manoeuvres.end_of(0.0, std, turning=zigzag)["heading_deg"]
        changes, fixes = 5.0 * 2**0.5, 300  # six turns in 300 s, each known to no worse than from two fixes
        assert under_way < std * 2**0.5 / changes / 6**0.5 / DEG * 2
        assert under_way > std * 2 / changes / fixes**0.5 / DEG  # as if all fixes told of one turn
        assert at_rest > 5 * under_way


def test_amplitude_without_a_mean():
    assert_allclose(manoeuvres.NO_MEAN, jn_zeros(0, 1)[0], rtol=1e-14)
