"""Covariance of the aided gyrocompass against full matrices and against the bound of heading."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import expm

from fogkit.gyrocompass import accuracy, error_model, mechanisation
from fogkit.gyrocompass.covariance import Aid, Noise, Prior, checked_covariance, run_covariance
from fogkit.gyrocompass.laws import ConstantSpeedReversal, QuasiHarmonic
from fogkit.gyrocompass.mechanisation import CompassState, Reading
from fogkit.gyrocompass.motions import Vessel
from fogkit.gyrocompass.velocity_information import heading_from_velocities
from fogkit.units import DEG, DEG_PER_HOUR, PERCENT

LAT = 60 * DEG
WALK = 0.0176 * DEG / 60
LAW = QuasiHarmonic(amplitude=np.pi, period=60.0)
ROLLING = Vessel(lat=LAT, heading=50 * DEG, trim=2 * DEG, roll=1 * DEG, roll_swing=5 * DEG, speed=5.0)


def test_readings_make_the_motion():
    motion = ROLLING.motion(60.0, 0.1, LAW)
    for k in (0, 17, 333):
        x = motion.states[k]
        state = CompassState(heading=x[0], trim=x[1], roll=x[2], velocity=x[3:6], lat=x[6])
        reading = Reading(
            rates=motion.rates[k],
            specific_force=motion.specific_force[k],
            mount_angle=motion.mount_angle[k],
            mount_rate=motion.mount_rate[k],
        )
        rate = mechanisation.state_rate(state, reading)
        roll_rate = 5 * DEG * 2 * np.pi / 60 * np.cos(2 * np.pi * motion.time[k] / 60)
        assert_allclose(rate[:3], [0, 0, roll_rate], atol=1e-15)
        assert_allclose(rate[3:6], 0, atol=1e-14)
        assert_allclose(rate[8], 0, atol=1e-15)
    with pytest.raises(ValueError, match="`dt` must be at most"):
        ROLLING.motion(60.0, 1.0, LAW)


def by_full_matrices(motion, P, aid, noise):
    """The same by matrix exponentials of twice the size (Van Loan) and Joseph's form with all measurements at once."""
    H = error_model.measurement_matrix(aid.std)
    R = np.diag(np.square(list(aid.std.values())))
    for k in range(len(motion.time)):
        if k % round(aid.interval / motion.dt) == 0:
            K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
            P = (np.eye(15) - K @ H) @ P @ (np.eye(15) - K @ H).T + K @ R @ K.T
        if k == len(motion.time) - 1:
            return P
        x = 0.5 * (motion.states[k] + motion.states[k + 1])
        middle = {
            "rates": 0.5 * (motion.rates[k] + motion.rates[k + 1]),
            "specific_force": 0.5 * (motion.specific_force[k] + motion.specific_force[k + 1]),
            "mount_angle": 0.5 * (motion.mount_angle[k] + motion.mount_angle[k + 1]),
            "mount_rate": 0.5 * (motion.mount_rate[k] + motion.mount_rate[k + 1]),
        }
        state = CompassState(heading=x[0], trim=x[1], roll=x[2], velocity=x[3:6], lat=x[6], alt=x[8])
        F = error_model.system_matrix(state, Reading(**middle), motion.gravity)
        G = error_model.noise_input(x[1], x[2], middle["mount_angle"])
        Q = G @ np.diag(np.square(noise.angle_random_walk)) @ G.T
        Q[3:6, 3:6] += noise.velocity_random_walk**2 * np.eye(3)
        Q[9:12, 9:12] += noise.rate_random_walk**2 * np.eye(3)
        block = expm(np.block([[-F, Q], [np.zeros((15, 15)), F.T]]) * motion.dt)
        Phi = block[15:, 15:].T
        P = Phi @ P @ Phi.T + Phi @ block[:15, 15:]
    return None


def test_kernel_against_full_matrices():
    motion = ROLLING.motion(12.0, 0.05, LAW)
    noise = Noise(angle_random_walk=(WALK, 2 * WALK, 3 * WALK), velocity_random_walk=1e-4, rate_random_walk=1e-6)
    aid = Aid.satellite(LAT, velocity=0.05, interval=0.5)
    prior = Prior(heading=5 * DEG)
    truth = by_full_matrices(motion, prior.covariance(LAT), aid, noise)
    run = run_covariance(motion, noise, aid, prior)
    std = np.sqrt(np.diag(truth))
    # noise enters a step as its first order, wrong by dt over the time in which what it drives is corrected: 0.05/1 s
    # of the share of new noise in the variance
    assert_allclose(run.std[-1], std, rtol=1e-4)
    assert_allclose(run.covariance / np.outer(std, std), truth / np.outer(std, std), atol=1e-3)
    assert_allclose(run.std[0, 0], 5 * DEG, rtol=1e-12)
    ground = np.sqrt(np.diag(prior.covariance(LAT))[6:8]) * mechanisation.EARTH_RADIUS * [1, np.cos(LAT)]
    assert_allclose(ground, prior.position, rtol=1e-12)
    frame = run.to_frame()
    assert frame.index.name == "time" and len(frame) == 13
    assert_allclose(frame.heading, run.of("heading"))


@pytest.mark.parametrize("law", [LAW, ConstantSpeedReversal(amplitude=2.0, period=50.0, reversal_time=5.0)])
def test_heading_reaches_the_bound_with_a_good_aid(law):
    bias = 20 * DEG_PER_HOUR
    motion = Vessel(lat=LAT, heading=50 * DEG).motion(300.0, 0.05, law)
    radius = mechanisation.EARTH_RADIUS
    still = dict.fromkeys(("velocity_north", "velocity_up", "velocity_east"), 1e-4)
    aid = Aid(std={**still, "lat": 1 / radius, "lon": 2 / radius, "alt": 1.0}, interval=0.5)
    prior = Prior(heading=20 * DEG, bias=bias, scale_factor=1 * PERCENT)
    run = run_covariance(motion, Noise(angle_random_walk=WALK), aid, prior)
    bound = accuracy.heading_bound(law, 300.0, LAT, WALK, bias_std=bias, drift_std=bias).std
    prior_too = (bound**-2 + (20 * DEG) ** -2) ** -0.5
    # an aid of 0.1 mm/s still hides the last 0.5 s**... of the tilts: above the bound, by little
    assert prior_too < run.of("heading")[-1] < 1.04 * prior_too
    # without knowledge of the heading's drift the up bias stays: its own noise, and the slope of heading
    assert run.of("bias_x")[-1] < 0.6 * bias


@pytest.mark.parametrize("amplitude", [np.pi, np.pi / 2, 2.4048])
@pytest.mark.parametrize("velocity_std", [1e-3, 0.1])
def test_heading_against_all_velocities_at_once(amplitude, velocity_std):
    law = QuasiHarmonic(amplitude=amplitude, period=60.0)
    prior = Prior(heading=20 * DEG, bias=25 * DEG_PER_HOUR)
    aid = Aid(std=dict.fromkeys(("velocity_north", "velocity_up", "velocity_east"), velocity_std))
    motion = Vessel(lat=LAT, heading=50 * DEG).motion(300.0, 0.1, law)
    run = run_covariance(motion, Noise(angle_random_walk=WALK), aid, prior)
    truth = heading_from_velocities(law, 300.0, LAT, WALK, velocity_std, prior, heading=50 * DEG)
    # what the truth leaves out: the Earth's turn of the tilts and Schuler's feedback, (300 s / 806 s)**2 of slow terms;
    # heading from 0.8 to 7 degrees all the same
    assert_allclose(run.of("heading")[-1], truth, rtol=0.007)


def test_poor_aiding_asks_for_a_mean_direction_of_zero():
    # In the hull heading is a steady tilt rate and a bias turns with the mount. An aid whose velocity is noisy sees
    # the steady part well and the turning part badly: what is left of the bias in the mean goes into heading.
    aid = Aid.satellite(LAT, velocity=0.1)
    prior = Prior(heading=20 * DEG, bias=20 * DEG_PER_HOUR)
    found = {}
    for name, amplitude in (("thesis", np.pi), ("best", accuracy.best_harmonic_amplitude())):
        motion = Vessel(lat=LAT, heading=50 * DEG).motion(300.0, 0.1, QuasiHarmonic(amplitude=amplitude, period=60.0))
        found[name] = run_covariance(motion, Noise(angle_random_walk=WALK), aid, prior).of("heading")[-1]
    assert found["best"] < 1.2 * DEG
    assert found["thesis"] > 4 * found["best"]


def test_bad_input():
    motion = ROLLING.motion(10.0, 0.1, LAW)
    noise, aid = Noise(angle_random_walk=WALK), Aid.satellite(LAT)
    with pytest.raises(ValueError, match=r"`aid.interval` must be a multiple of the motion's step, 0.1 s, got 0.25 s"):
        run_covariance(motion, noise, Aid(std={"lat": 1e-6}, interval=0.25))
    indefinite = np.eye(15)
    indefinite[0, 1] = indefinite[1, 0] = 2.0
    with pytest.raises(ValueError, match="`prior` must be positive semi-definite, got an eigenvalue of -1"):
        run_covariance(motion, noise, aid, indefinite)
    with pytest.raises(ValueError, match="`P` must be symmetric"):
        checked_covariance("P", np.eye(15) + 0.1 * np.eye(15, k=1))
    with pytest.raises(ValueError, match="unaided filter observes nothing"):
        Aid()
    with pytest.raises(ValueError, match=r"`std\['lat'\]` must be finite and > 0"):
        Aid(std={"lat": 0.0})
    with pytest.raises(ValueError, match="`angle_random_walk` must be one number or three"):
        Noise(angle_random_walk=-1.0)
    with pytest.warns(UserWarning, match="`heading` of 60 deg is beyond 30 deg"):
        Prior(heading=60 * DEG).covariance(LAT)
    with pytest.raises(ValueError, match="`roll_period` must be finite and > 0"):
        Vessel(lat=LAT, roll_period=-60.0)
