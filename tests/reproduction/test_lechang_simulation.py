"""What the thesis's simulation can have seen: observability with the mount off and on, and how fast heading settles."""

import numpy as np
from numpy.testing import assert_allclose

from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass.accuracy import heading_bound
from fogkit.gyrocompass.frames import hull_attitude, pyramid_axes
from fogkit.reproduction.lechang import paper, simulation
from fogkit.units import DEG


def test_mount_off_at_rest_leaves_four_directions():
    fractions, directions = simulation.unseen(None, rolling=False)
    assert (fractions[:3] < 0.05).all() and (fractions[3:] > 0.9).all()
    # heading and the three scale factors lie in the space of those four
    assert ((directions[[0, 4, 5, 6], 3:] ** 2).sum(axis=1) > 0.9).all()


def test_rolling_leaves_heading_with_the_east_bias():
    fractions, directions = simulation.unseen(None, rolling=True)
    assert (fractions[:6] < 0.3).all() and fractions[6] > 0.9
    last = directions[:, 6] * np.sign(directions[0, 6])
    assert last[0] > 0.95
    # biases that turn heading: their east part, over the level Earth rate, is what heading is wrong by
    hull = hull_attitude(paper.HEADING, paper.TRIM, paper.ROLL_MEAN)
    bias = last[1:4] * 10 * DEG / 3600
    drift = hull @ pyramid_axes() @ bias
    assert_allclose(-drift[2] / (EARTH_RATE * np.cos(paper.ASSUMED_LATITUDE)), last[0] * 10 * DEG, rtol=0.01)
    assert np.abs(drift[:2]).max() < 0.02 * abs(drift[2])  # and no bias up or north: those are seen


def test_mount_on_shows_all():
    for rolling in (False, True):
        assert simulation.unseen(simulation.mount(), rolling=rolling)[0].max() < 0.05


def test_gyros_on_a_cube_show_their_biases_as_well():
    # the thesis has only the azimuth gyro's errors observable there; of scale factors that is so, of biases it is not
    fractions, directions = simulation.unseen(simulation.mount(), rolling=False, axes=simulation.CUBE)
    covariance = directions @ np.diag(fractions**2) @ directions.T
    heading, *biases = np.sqrt(np.diag(covariance))[:4]
    assert max(heading, *biases) < 0.05
    scale_x, scale_y, scale_z = np.sqrt(np.diag(covariance))[4:]
    assert scale_y < 0.01 < 0.1 < min(scale_x, scale_z)


def test_settling():
    table = simulation.settling()
    switched_on = table.xs(0.0, level="time_on")
    assert (switched_on.heading_deg > 9.7).all()  # of 10: with the mount off nothing is learnt of heading
    assert (switched_on.bias_dph < 4.0).all()  # of 6: but of biases it is
    later, end = (table.xs(t, level="time_on") for t in (200.0, 500.0))
    assert (later.heading_deg < 1.0).all() and (later.scale_percent < 0.03).all()
    # not below what gyro noise leaves when all biases are known, over all 900 s; and still falling: the root of time
    floor = heading_bound(simulation.mount(), 900.0, paper.ASSUMED_LATITUDE, paper.SIMULATED_RANDOM_WALK, bias_std=0)
    assert (end.heading_deg > floor.std / DEG).all() and (end.heading_deg < 0.8 * later.heading_deg).all()
