"""Increments of the gyros on the mount, taken to the hull: closed form, order, the navigation of the package."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit import earth
from fogkit.gyrocompass import frames, mechanisation
from fogkit.gyrocompass.laws import OneWay, QuasiHarmonic
from fogkit.navigation import State, integrate_arrays
from fogkit.rotation import dcm_from_heading_pitch_roll, heading_pitch_roll_from_dcm
from fogkit.units import ARCSEC, DEG

NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)


def gyro_increments(law, hull_rate, dt, steps):
    """Integrals of the gyros' rates over steps, by Gauss's quadrature of eight points: exact here to rounding."""
    t = dt * (np.arange(steps)[:, np.newaxis] + (NODES + 1) / 2)
    rates = mechanisation.gyro_rates(hull_rate(t), law.angle(t), law.rate(t))
    return (rates * WEIGHTS[:, np.newaxis]).sum(axis=1) * dt / 2


def test_exact_for_steady_rates():
    steady = np.array([0.01, -0.02, 0.03])
    law, dt = OneWay(period=20.0), 0.5  # 9 degrees in a step
    dtheta = gyro_increments(law, lambda t: np.broadcast_to(steady, (*t.shape, 3)), dt, 50)
    got = mechanisation.hull_increments(dtheta, law.angle(dt * np.arange(51)))
    assert_allclose(got, np.tile(steady * dt, (50, 1)), rtol=1e-12)


def test_order_of_the_rest():
    law = QuasiHarmonic(amplitude=np.pi, period=20.0)

    def rate(t):
        return np.stack([0.1 * np.cos(1.3 * t), 0.05 * np.sin(0.7 * t), 0.08 * np.sin(1.1 * t + 0.4)], axis=-1)

    errors = []
    for steps in (200, 400, 800):
        dt = 20.0 / steps
        got = mechanisation.hull_increments(gyro_increments(law, rate, dt, steps), law.angle(dt * np.arange(steps + 1)))
        t = dt * (np.arange(steps)[:, np.newaxis] + (NODES + 1) / 2)
        truth = (rate(t) * WEIGHTS[:, np.newaxis]).sum(axis=1) * dt / 2
        errors.append(np.abs(got - truth).max())
    assert_allclose(np.log2(np.array(errors[:-1]) / errors[1:]), 3.0, atol=0.1)


def test_navigation_keeps_heading_while_the_mount_rocks():
    law, dt, steps, lat = QuasiHarmonic(amplitude=np.pi, period=60.0), 0.01, 12000, 60 * DEG
    C_h_g = frames.hull_attitude(50 * DEG, 2 * DEG, 1 * DEG)
    C_b_n = dcm_from_heading_pitch_roll(50 * DEG, 2 * DEG, 1 * DEG)
    omega_ie_h = C_h_g.T @ frames.TO_PACKAGE.T @ earth.earth_rate_n(lat)
    dtheta = gyro_increments(law, lambda t: np.broadcast_to(omega_ie_h, (*t.shape, 3)), dt, steps)
    hull = mechanisation.hull_increments(dtheta, law.angle(dt * np.arange(steps + 1)))
    dv = np.tile(-C_b_n.T @ earth.gravity_n(lat), (steps, 1)) * dt
    end = integrate_arrays(hull @ frames.TO_PACKAGE.T, dv, dt, State(lat=lat, C_b_n=C_b_n), position_fixed=True)
    heading, pitch, roll = heading_pitch_roll_from_dcm(end.C_b_n[-1])
    # 12000 steps whose rounding, of mount rates of 0.3 rad/s, is 1e-18 rad each; the third order of 0.01 s is smaller
    assert_allclose([heading, pitch, roll], np.array([50, 2, 1]) * DEG, atol=1e-5 * ARCSEC)


def test_bad_input():
    with pytest.raises(ValueError, match=r"`mount_angle` must be of shape \(3,\), got \(2,\)\. One angle at each end"):
        mechanisation.hull_increments(np.zeros((2, 3)), [0.0, 0.1])
    with pytest.raises(ValueError, match=r"must not change by more than pi in a step, got 6.18 rad: unwrap it"):
        mechanisation.hull_increments(np.zeros((1, 3)), [0.1, 2 * np.pi])
