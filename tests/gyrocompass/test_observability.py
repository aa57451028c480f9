"""Singular values of what an aid sees: against the covariance run, and against directions known from physics."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import expm

from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass.covariance import Aid, Noise, Prior, run_covariance
from fogkit.gyrocompass.error_model import STATES, system_matrix
from fogkit.gyrocompass.frames import hull_attitude, pyramid_axes
from fogkit.gyrocompass.laws import QuasiHarmonic
from fogkit.gyrocompass.mechanisation import CompassState, Reading
from fogkit.gyrocompass.motions import Vessel
from fogkit.gyrocompass.observability import _transitions, directions_seen
from fogkit.units import DEG, DEG_PER_HOUR, PERCENT

LAT = 60 * DEG
PRIOR = Prior(heading=10 * DEG, bias=10 * DEG_PER_HOUR, scale_factor=1 * PERCENT, position=1.0, height=1.0)
AID = Aid.satellite(LAT, velocity=1e-3, position=0.1)
GYROS = STATES[9:]
LAW = QuasiHarmonic(amplitude=np.pi, period=60.0)


def motion(law=None, swing=0.0, duration=200.0):
    return Vessel(lat=LAT, heading=50 * DEG, trim=2 * DEG, roll_swing=swing).motion(duration, 0.1, law)


@pytest.mark.parametrize(("law", "swing"), [(None, 5 * DEG), (LAW, 0.0)])
def test_fractions_against_the_covariance_of_perfect_gyros(law, swing):
    # sensor errors are constant: what is known of them at the start is what is known at the end
    record = motion(law, swing)
    found = directions_seen(record, AID, PRIOR, GYROS)
    run = run_covariance(record, Noise(angle_random_walk=1e-9), AID, PRIOR)
    std = np.sqrt(np.diag(PRIOR.covariance(LAT)))[9:]
    truth = np.sqrt(np.linalg.eigvalsh(run.covariance[9:, 9:] / np.outer(std, std)))
    # the run's noise is 1e-8 rad after 200 s, a thousandth of what the aid tells of a tilt then, 1e-5; in the square
    assert_allclose(found.fractions, truth, rtol=0.01)


def test_others_are_nuisances():
    record = motion(LAW, duration=60.0)
    whole = directions_seen(record, AID, PRIOR)
    V, left = whole.directions, 1 / (1 + whole.singular_values**2)
    part = directions_seen(record, AID, PRIOR, GYROS)
    truth = np.linalg.eigvalsh(((V * left) @ V.T)[9:, 9:])
    assert_allclose(part.fractions**2, truth, rtol=1e-6)  # posteriors of a part are the part of the posterior
    assert_allclose(part.directions.T @ part.directions, np.eye(6), atol=1e-12)


def test_transitions_against_exponentials():
    record = motion(LAW, duration=2.0)
    truth = np.eye(15)
    for k in range(20):
        x = 0.5 * (record.states[k] + record.states[k + 1])
        names = ("rates", "specific_force", "mount_angle", "mount_rate")
        middle = {n: 0.5 * (getattr(record, n)[k] + getattr(record, n)[k + 1]) for n in names}
        state = CompassState(heading=x[0], trim=x[1], roll=x[2], velocity=x[3:6], lat=x[6], alt=x[8])
        truth = expm(system_matrix(state, Reading(**middle), record.gravity) * record.dt) @ truth
    # what a step leaves out is (0.1 s/2 s)**2 of a growth of third order, itself a smaller part of the largest growth
    std = np.sqrt(np.diag(PRIOR.covariance(LAT)))
    error = np.abs(_transitions(record)[-1] - truth) * std / std[:, np.newaxis]
    assert error.max() < 1e-3 * np.abs(truth * std / std[:, np.newaxis] - np.eye(15)).max()


def test_at_rest_heading_hides_behind_the_east_bias():
    states = ("heading", *GYROS)
    found = directions_seen(motion(duration=100.0), AID, PRIOR, states)
    assert found.rank(threshold=1e-3) == 3  # the up bias, by its turn of heading, about one prior unit in 100 s
    assert (found.singular_values[3:] < 1e-6).all()  # rounding: nothing at all is seen of these, not little
    hidden = found.directions[:, 3:]
    # error of heading by 1: the east bias that makes the same, in the gyros' axes; no scale factor in it
    C_p_g = hull_attitude(50 * DEG, 2 * DEG, 0.0) @ pyramid_axes()
    east = C_p_g.T @ np.array([0.0, 0.0, 1.0])
    pair = np.array([10 * DEG, *(-east * EARTH_RATE * np.cos(LAT) * 10 * DEG), 0, 0, 0])
    pair /= np.array([10 * DEG, *[10 * DEG_PER_HOUR] * 3, *[1 * PERCENT] * 3])
    pair /= np.linalg.norm(pair)
    assert_allclose(np.linalg.norm(hidden.T @ pair), 1, rtol=1e-6)
    # scale factors at constant rate are biases: each pair that adds to nothing is hidden
    rates = motion(duration=10.0).rates[0]
    for j in range(3):
        pair = np.zeros(7)
        pair[1 + j], pair[4 + j] = -rates[j] * 1 * PERCENT / (10 * DEG_PER_HOUR), 1
        assert_allclose(np.linalg.norm(hidden.T @ (pair / np.linalg.norm(pair))), 1, rtol=1e-6)


def test_turning_shows_all_and_the_table_says_so():
    found = directions_seen(motion(LAW), AID, PRIOR, ("heading", *GYROS))
    assert found.rank() == 7 and found.rank(threshold=1e9) == 0
    table = found.to_frame()
    assert list(table.columns) == ["singular_value", "fraction", "heading", *GYROS]
    assert_allclose(table.fraction, (1 + table.singular_value**2) ** -0.5)
    assert (np.diff(found.singular_values) <= 0).all()


def test_bad_input():
    with pytest.raises(ValueError, match="`states` must be one of"):
        directions_seen(motion(duration=10.0), AID, PRIOR, ("yaw",))
    with pytest.raises(ValueError, match="`prior` must be above 0 for every state, got 0 for heading"):
        directions_seen(motion(duration=10.0), AID, Prior(heading=0.0))
    with pytest.raises(ValueError, match=r"`aid.interval` must be a multiple"):
        directions_seen(motion(duration=10.0), Aid(std={"lat": 1e-6}, interval=0.25), PRIOR)
    with pytest.raises(TypeError, match="`motion` must be a Motion"):
        directions_seen(None, AID, PRIOR)
