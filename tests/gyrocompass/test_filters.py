"""Filters and smoother against motion, covariance, all measurements at once; any heading, near the pole, under way."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.constants import EARTH_RATE, STANDARD_GRAVITY
from fogkit.estimation.consistency import chi_square_interval, nees
from fogkit.gyrocompass.covariance import Aid, Noise, Prior, run_covariance
from fogkit.gyrocompass.error_model import MEASUREMENTS
from fogkit.gyrocompass.filters.extended import run_extended
from fogkit.gyrocompass.filters.records import Fixes, Recording, draw_start, record, take_fixes
from fogkit.gyrocompass.filters.smoother import smooth_wander
from fogkit.gyrocompass.filters.wander import run_wander
from fogkit.gyrocompass.laws import OneWay, QuasiHarmonic, SwitchedOn
from fogkit.gyrocompass.mechanisation import CompassState, hull_increments
from fogkit.gyrocompass.motions import Vessel
from fogkit.units import ARCSEC, DEG, DEG_PER_HOUR, PERCENT

LAT = 60 * DEG
WALK = 0.0176 * DEG / 60
NOISE = Noise(angle_random_walk=WALK)
LAW = QuasiHarmonic(amplitude=np.pi, period=60.0)
ROLLING = Vessel(lat=LAT, heading=50 * DEG, trim=2 * DEG, roll=1 * DEG, roll_swing=5 * DEG)
PRIOR = Prior(heading=10 * DEG, level=0.1 * DEG, velocity=0.1, bias=6 * DEG_PER_HOUR, scale_factor=0.5 * PERCENT)
FILTERS = {"extended": run_extended, "wander": run_wander}
BOTH = pytest.mark.parametrize("run", FILTERS.values(), ids=FILTERS.keys())


def true_start(motion):
    x = motion.states[0]
    return CompassState(heading=x[0], trim=x[1], roll=x[2], velocity=x[3:6], lat=x[6], lon=x[7], alt=x[8])


def perfect(motion, aid):
    """Measurements without errors of an aid that is taken to have some."""
    fixes = take_fixes(motion, aid, np.random.default_rng(0))
    truth = motion.states[np.rint(fixes.time / motion.dt).astype(int), 3:9]
    return Fixes(time=fixes.time, values=np.where(np.isnan(fixes.values), np.nan, truth), aid=aid)


def drawn(motion, prior, aid, seed, noise=NOISE):
    """Record, measurements and start with errors as the prior says, and the true biases and scale factors."""
    rng = np.random.default_rng(seed)
    bias, scale = prior.bias * rng.standard_normal(3), prior.scale_factor * rng.standard_normal(3)
    recording = record(motion, noise, rng, bias=bias, scale_factor=scale)
    return recording, take_fixes(motion, aid, rng), draw_start(motion, prior, rng), bias, scale


@BOTH
@pytest.mark.parametrize("turning", [None, QuasiHarmonic(amplitude=1.0, period=100.0)], ids=["straight", "zigzag"])
def test_mechanisation_keeps_the_motion(run, turning):
    # an aid that says next to nothing: what is left is the integration of a record without errors
    motion = replace(ROLLING, speed=10.0, heading=120 * DEG, turning=turning).motion(120.0, 0.01, LAW)
    recording = record(motion, Noise(angle_random_walk=0.0), np.random.default_rng(1))
    aid = Aid(std=dict.fromkeys(MEASUREMENTS, 1e4))
    sure = Prior(heading=1e-6, level=1e-6, velocity=1e-4, position=0.1, height=0.1, bias=1e-12, scale_factor=1e-9)
    errors = run(recording, perfect(motion, aid), NOISE, true_start(motion), sure).errors(motion)
    # rolling: (1e-4 rad in a step)**2 of gravity; record: fourth order of 0.01 s in 60 s. In a turn coning within a
    # step is left out, dt**2/12 of 0.06 rad/s by 9e-4 rad/s**2: 5e-10 rad/s for the time of a swing
    coning = 0.0 if turning is None else 5e-10 * 60
    assert np.abs(errors[:, :3]).max() < 1e-3 * ARCSEC + coning
    assert np.abs(errors[:, 3:6]).max() < 1e-5 + coning * STANDARD_GRAVITY * 60
    assert np.abs(errors[:, 8]).max() < 1e-3
    assert np.abs(errors[:, 6:8]).max() * 6.4e6 < 1e-2


@BOTH
def test_covariance_is_that_of_the_linear_model(run):
    # where heading is known to 0.3 degrees both filters and the covariance along the true motion are the same model
    motion = ROLLING.motion(200.0, 0.05, LAW)
    prior, aid = replace(PRIOR, heading=0.3 * DEG, scale_factor=1e-4), Aid.satellite(LAT, velocity=0.01)
    recording = record(motion, Noise(angle_random_walk=0.0), np.random.default_rng(1))
    got = run(recording, perfect(motion, aid), NOISE, true_start(motion), prior)
    truth = run_covariance(motion, NOISE, aid, prior)
    # the length of the axis is free in the one filter, to the second order of 0.3 degrees; steps of 0.05 s at their
    # start or middle: 0.05 s of the mount's 60 s
    assert_allclose(got.std[[50, 200], 0], truth.std[[50, 200], 0], rtol=3e-3)
    assert_allclose(got.std[-1], truth.std[-1], rtol=0.01)
    # steps of 0.05 s: increments are right to their third order
    assert_allclose(got.estimate[-1, :3], motion.states[-1, :3], atol=3e-6)


def test_heading_against_all_velocities_at_once():
    # Level, at rest: velocities are twice the integral of level rates, linear in heading, its drift, the level biases
    # and the start. One fit by least squares, its covariance that of integrated white noise, no filter.
    vessel, duration, dt = Vessel(lat=LAT, heading=50 * DEG), 300, 0.05
    motion = vessel.motion(float(duration), dt, LAW)
    prior = replace(PRIOR, heading=2 * DEG, level=0.02 * DEG, velocity=0.01, bias=1 * DEG_PER_HOUR, scale_factor=1e-7)
    velocities = dict.fromkeys(MEASUREMENTS[:3], 0.01)
    recording, fixes, start, *_ = drawn(motion, prior, Aid(std=velocities), 5)
    start = replace(start, lat=LAT, lon=0.0, alt=0.0)

    U, K = EARTH_RATE * np.cos(LAT), start.heading
    turns = hull_increments(recording.dtheta, recording.mount_angle)
    turns -= EARTH_RATE * dt * np.array([np.cos(LAT) * np.cos(K), np.sin(LAT), -np.cos(LAT) * np.sin(K)])
    t, k = dt * (np.arange(len(turns)) + 0.5), np.arange(duration + 1.0)
    kernel = STANDARD_GRAVITY * np.maximum(k[:, np.newaxis] - t, 0)
    cos_b, sin_b, one = np.cos(LAW.angle(t)), np.sin(LAW.angle(t)), np.ones_like(t)
    north_east = fixes.values[:, [0, 2]]
    ahead = north_east @ [np.cos(K), np.sin(K)]
    abeam = north_east @ [-np.sin(K), np.cos(K)]

    def velocity(forward, starboard, tilts=(0.0, 0.0), begin=(0.0, 0.0)):
        """Forward and starboard velocity from rates of tilt, tilts and velocity at the start."""
        g = STANDARD_GRAVITY * k
        return np.concatenate(
            [-kernel @ starboard - g * tilts[1] + begin[0], kernel @ forward + g * tilts[0] + begin[1]]
        )

    level = {"forward": start.roll, "starboard": start.trim}  # errors of level: the true ones are zero
    begin = start.velocity[0] * np.array([np.cos(K), -np.sin(K)]) + start.velocity[2] * np.array([np.sin(K), np.cos(K)])
    nominal = velocity(turns[:, 0] / dt * dt, turns[:, 2] / dt * dt, (level["forward"], level["starboard"]), begin)
    y = nominal - np.concatenate([ahead, abeam])
    zero = np.zeros_like(t)
    columns = [
        velocity(U * np.sin(K) * one * dt, U * np.cos(K) * one * dt),  # heading at the start
        velocity(U * np.sin(K) * t * dt, U * np.cos(K) * t * dt),  # its drift
        velocity(cos_b * dt, -sin_b * dt),  # biases ahead and abeam in the mount
        velocity(sin_b * dt, cos_b * dt),
        *(velocity(zero, zero, tilts=e) for e in np.eye(2)),
        *(velocity(zero, zero, begin=e) for e in np.eye(2)),
    ]
    A = np.array(columns).T
    stds = [prior.heading, *[prior.bias] * 3, *[prior.level] * 2, *[prior.velocity] * 2]
    covariance = kernel @ kernel.T * WALK**2 * dt + 0.01**2 * np.eye(len(k))
    root = np.linalg.cholesky(np.kron(np.eye(2), covariance))
    whitened, y = np.linalg.solve(root, A), np.linalg.solve(root, y)
    scaled = whitened * stds
    information = scaled.T @ scaled + np.eye(8)
    x = stds * np.linalg.solve(information, scaled.T @ y)
    P = np.linalg.inv(information) * np.outer(stds, stds)
    at_end = np.array([1.0, duration, *np.zeros(6)])
    std = np.sqrt(at_end @ P @ at_end)
    heading = start.heading - turns[:, 1].sum() - at_end @ x
    for run in FILTERS.values():
        got, got_std = run(recording, fixes, NOISE, start, prior).of("heading")
        # left out of the fit: the Earth's turn of the tilts, 1 % of what 1 deg/h does
        assert_allclose(got[-1], heading, atol=0.12 * std)
        assert_allclose(got_std[-1], std, rtol=0.02)
    assert 2 * std < abs(start.heading - vessel.heading)  # there was something to find


@pytest.fixture(scope="module")
def from_30_degrees():
    """Normalised errors of both filters, from headings 30 degrees wrong, over 30 seeds."""
    motion, prior = ROLLING.motion(300.0, 0.05, SwitchedOn(law=LAW, start=100.0)), replace(PRIOR, heading=30 * DEG)
    aid, found = Aid.satellite(LAT, velocity=0.01), []
    for seed in range(30):
        recording, fixes, start, *true = drawn(motion, prior, aid, seed)
        run = run_wander(recording, fixes, NOISE, start, prior)
        plain = run_extended(recording, fixes, NOISE, start, prior, output_interval=100.0)
        own = nees(run.wander_errors(motion, *true)[[100, 200, 300]], run.wander_covariance[[100, 200, 300]])
        heading = run.errors(motion, *true)[-1, 0] / run.std[-1, 0]
        found.append([own, nees(plain.errors(motion, *true)[1:], plain.covariance[1:]), [heading**2] * 3])
    return np.array(found).mean(axis=0)


@pytest.mark.filterwarnings("ignore:the aid departs")
def test_wander_is_consistent_from_30_degrees_and_the_extended_filter_is_not(from_30_degrees):
    wander, extended, heading = from_30_degrees
    low, high = chi_square_interval(17, 30, 0.999)
    assert (low < wander).all() and (wander < high).all()
    low, high = chi_square_interval(1, 30, 0.999)
    assert low < heading[0] < high
    assert (extended > 5 * chi_square_interval(15, 30, 0.999)[1]).all()


@pytest.mark.parametrize("heading", [-130 * DEG, 10 * DEG, 170 * DEG])
def test_heading_found_when_nothing_is_known_of_it(heading):
    motion = replace(ROLLING, heading=heading).motion(300.0, 0.05, LAW)
    recording, fixes, start, *true = drawn(motion, PRIOR, Aid.satellite(LAT, velocity=0.01), 3)
    run = run_wander(recording, fixes, NOISE, replace(start, heading=0.0), PRIOR, heading_known=False)
    error, std = run.errors(motion, *true)[-1, 0], run.std[-1, 0]
    assert std < 2.5 * DEG and abs(error) < 3.5 * std
    assert_allclose(run.std[0, 0], 0.5**0.5, rtol=0.01)  # of the sine of an angle of which nothing is known


CIRCLE = OneWay(period=200.0)


@pytest.mark.parametrize(
    ("lat", "walk", "heading", "speed", "aid", "turning"),
    [
        (60, WALK, 30, 5.0, 0.1, None),
        (60, WALK, 10, 20.0, 0.01, None),
        (60, WALK, 30, 5.0, 0.1, CIRCLE),
        (89, WALK / 50, 30, 5.0, 0.01, None),
        (89.9, WALK / 500, 30, 2.0, 0.01, None),
    ],
)
def test_consistent_under_way_in_a_turn_and_near_the_pole(lat, walk, heading, speed, aid, turning):
    vessel = Vessel(lat=lat * DEG, heading=80 * DEG, trim=1 * DEG, roll_swing=3 * DEG, speed=speed, turning=turning)
    motion, noise = vessel.motion(300.0, 0.05, LAW), Noise(angle_random_walk=walk)
    # gyros for 89.9 degrees hold azimuth to 1e-7 rad, which products of tilts of 0.1 degrees, 3e-6, would swamp
    level = 0.01 * DEG if lat > 89.5 else PRIOR.level
    bias, scale_factor = PRIOR.bias * walk / WALK, 0.01 * PERCENT
    prior = replace(PRIOR, heading=heading * DEG, level=level, bias=bias, scale_factor=scale_factor)
    aid, values, seen = Aid.satellite(lat * DEG, velocity=aid), [], []
    for seed in range(16):
        recording, fixes, start, *true = drawn(motion, prior, aid, seed, noise)
        run = run_wander(recording, fixes, noise, start, prior, course_follows_heading=turning is not None)
        values.append(nees(run.wander_errors(motion, *true)[-1], run.wander_covariance[-1]))
        seen.append(run.std[-1, 0])
    low, high = chi_square_interval(17, 16, 0.999)
    assert low < np.mean(values) < high
    assert np.mean(seen) < 8 * DEG  # something was found


def test_a_turn_under_way_with_heading_hardly_known_is_warned_of():
    motion = replace(ROLLING, speed=5.0, turning=CIRCLE).motion(30.0, 0.05, LAW)
    recording, fixes, start, *_ = drawn(motion, PRIOR, Aid.satellite(LAT, velocity=0.1), 1)
    with pytest.warns(UserWarning, match=r"turns by up to 5.* deg under way at 5.* m/s with heading known to 10 deg"):
        run_wander(recording, fixes, NOISE, start, PRIOR)
    run_wander(recording, fixes, NOISE, start, PRIOR, course_follows_heading=True)  # warnings are errors
    run_wander(recording, fixes, NOISE, start, replace(PRIOR, heading=1 * DEG))


def test_smoother():
    motion = ROLLING.motion(200.0, 0.05, LAW)
    recording, fixes, start, *true = drawn(motion, PRIOR, Aid.satellite(LAT, velocity=0.01), 8)
    filtered, smoothed = smooth_wander(recording, fixes, NOISE, start, PRIOR)
    # what does not change is known at every time as it is at the end: biases, scale factors
    std = filtered.std[-1, 9:]
    assert_allclose(smoothed.estimate[:, 9:] / std, np.tile(filtered.estimate[-1, 9:] / std, (201, 1)), atol=1e-4)
    assert_allclose(smoothed.std[:, 9:] / std, 1.0, rtol=1e-4)
    # the hull's heading is constant as well, but known at the start through the gyros' up noise only
    assert_allclose(smoothed.estimate[0, 0], filtered.estimate[-1, 0], atol=0.6 * filtered.std[-1, 0])
    assert (smoothed.std <= filtered.std * (1 + 1e-6)).all()
    assert smoothed.std[0, 0] < 0.2 * filtered.std[0, 0]
    errors = smoothed.wander_errors(motion, *true)[[20, 100, 180]]
    values = nees(errors, smoothed.wander_covariance[[20, 100, 180]])
    assert (values < chi_square_interval(17, 1, 0.9999)[1]).all()
    again = run_wander(recording, fixes, NOISE, start, PRIOR)
    assert_allclose(again.estimate, filtered.estimate, rtol=1e-12, atol=1e-15)


@pytest.mark.filterwarnings("ignore:the aid departs")
def test_joseph_keeps_a_covariance_under_extreme_aids():
    motion = ROLLING.motion(20.0, 0.05, LAW)
    poor = Prior(heading=30 * DEG, velocity=1e4, position=1e6, height=1e6, bias=1e-3)
    recording, fixes, start, *_ = drawn(motion, PRIOR, Aid.satellite(LAT, velocity=1e-5, position=1e-3), 1)
    for run in FILTERS.values():
        got = run(recording, fixes, NOISE, start, poor)
        scale = got.std[-1]
        assert np.linalg.eigvalsh(got.covariance[-1] / np.outer(scale, scale))[0] > -1e-9


def test_lost_late_and_missing_aid():
    motion = replace(ROLLING, speed=5.0).motion(60.0, 0.05, LAW)
    aid, rng = Aid.satellite(LAT, velocity=0.01), np.random.default_rng(2)
    recording, start = record(motion, NOISE, rng), true_start(motion)
    for run in FILTERS.values():
        with pytest.warns(
            UserWarning, match=r"`fixes` has no measurement for 21 s from 19 s, where one comes every 1 s"
        ):
            lost = run(recording, take_fixes(motion, aid, rng, lost=((20.0, 39.0),)), NOISE, start, PRIOR)
        assert lost.std[39, 3] > 2 * lost.std[19, 3]
        with pytest.warns(UserWarning, match=r"the aid departs from what the filter expects by .* late or biased aid"):
            run(recording, take_fixes(motion, aid, rng, delay=20.0), NOISE, start, replace(PRIOR, position=1.0))
    fixes = take_fixes(motion, aid, rng)
    with pytest.raises(ValueError, match="an unaided filter observes nothing"):
        Fixes(time=fixes.time, values=np.full((61, 6), np.nan), aid=aid)
    with pytest.raises(ValueError, match=r"`time` must ascend, got 0 s after 60 s"):
        Fixes(time=np.roll(fixes.time, 1), values=fixes.values, aid=aid)
    with pytest.raises(ValueError, match=r"standard deviation of 'velocity_north'"):
        Fixes(time=fixes.time, values=fixes.values, aid=Aid(std={"lat": 1e-6}))
    with pytest.raises(ValueError, match="velocity and position only"):
        Fixes(time=fixes.time, values=fixes.values, aid=Aid(std={"heading": 1e-6}))
    with pytest.raises(ValueError, match=r"must lie on the recording's steps of 0.05 s, got"):
        run_wander(recording, replace(fixes, time=fixes.time + 0.01), NOISE, start)
    with pytest.raises(ValueError, match=r"must be in the recording, \[0, 60\] s, got 65 s"):
        run_wander(recording, replace(fixes, time=fixes.time + 5.0), NOISE, start)


def test_vertical_bow_pole_and_no_covariance():
    steep = replace(ROLLING, trim=89.9 * DEG, roll_swing=0.0).motion(5.0, 0.05)
    aid, rng = Aid.satellite(LAT), np.random.default_rng(2)
    still = replace(PRIOR, level=1e-6)
    start = replace(true_start(steep), trim=89.9 * DEG)
    recording = record(steep, NOISE, rng)
    tipped = replace(recording, dtheta=recording.dtheta + 1e-5 * recording.axes[2])  # bow up, by 1e-3 rad in all
    fixes = take_fixes(steep, aid, rng)
    with pytest.raises(
        ValueError, match=r"`recording` must keep trim 0.001 rad from the vertical.*`wander.run_wander`"
    ):
        run_extended(tipped, fixes, NOISE, start, still)
    with pytest.warns(UserWarning, match="trim comes within .* rad of the vertical.*use `C_h_w`"):
        run = run_wander(tipped, fixes, NOISE, start, still, output_interval=0.05)
    assert np.isfinite(run.wander_covariance).all()
    north = Vessel(lat=np.pi / 2 - 1.0001e-3, heading=0.0, speed=100.0)
    with pytest.raises(ValueError, match="`lat` must be in"):
        north.motion(60.0, 0.05, LAW)
    near = Vessel(lat=np.pi / 2 - 1.0002e-3).motion(5.0, 0.05, LAW)
    moving = replace(true_start(near), velocity=(1000.0, 0.0, 0.0))
    only_height = Aid(std={"alt": 1.0})
    for run in FILTERS.values():
        with pytest.raises(ValueError, match=r"must keep 0.001 rad from a pole"):
            run(record(near, NOISE, rng), take_fixes(near, only_height, rng), NOISE, moving, PRIOR)
    flat = ROLLING.motion(5.0, 0.05, LAW)
    vanishing = take_fixes(flat, Aid(std=dict.fromkeys(MEASUREMENTS[:3], 1e-200)), rng)
    for run in FILTERS.values():
        with pytest.raises(ValueError, match="not positive semi-definite at 0 s"):
            run(record(flat, NOISE, rng), vanishing, NOISE, true_start(flat), replace(PRIOR, velocity=0.0, level=0.0))
    indefinite = np.eye(15)
    indefinite[0, 1] = indefinite[1, 0] = 2.0
    with pytest.raises(ValueError, match="`prior` must be positive semi-definite"):
        run_extended(record(flat, NOISE, rng), take_fixes(flat, aid, rng), NOISE, true_start(flat), indefinite)


def test_bad_recordings():
    with pytest.raises(ValueError, match=r"`mount_angle` must be of shape \(3,\)"):
        Recording(dt=0.1, dtheta=np.zeros((2, 3)), dv=np.zeros((2, 3)), mount_angle=np.zeros(2))
    with pytest.raises(ValueError, match="must not change by more than pi in a step, got 4 rad: unwrap it"):
        Recording(dt=0.1, dtheta=np.zeros((1, 3)), dv=np.zeros((1, 3)), mount_angle=[0.0, 4.0])
    with pytest.raises(ValueError, match="`dt` must be finite and > 0"):
        Recording(dt=-0.1, dtheta=np.zeros((1, 3)), dv=np.zeros((1, 3)), mount_angle=[0.0, 0.0])


def test_table():
    motion = ROLLING.motion(5.0, 0.05, LAW)
    recording, fixes, start, *_ = drawn(motion, PRIOR, Aid.satellite(LAT), 1)
    frame = run_wander(recording, fixes, NOISE, start, PRIOR).to_frame()
    assert frame.index.name == "time" and list(frame.columns[:2]) == ["heading", "trim"]
    assert_allclose(frame.heading_std.iloc[0], 10 * DEG, rtol=0.05)
