from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

from fogkit.imu import Construction, GyroTriad
from fogkit.imu.readings import input_harmonics, mean_and_mean_size, mean_readings

coefficients = st.floats(-2, 2)


@given(c=coefficients, p=coefficients, q=coefficients, angle=st.floats(-20, 20))
def test_means_are_those_of_quadrature(c, p, q, angle):
    mean, size = mean_and_mean_size([c, p, q], angle)
    if abs(angle) < 1e-3:
        angle = np.copysign(1e-3, angle)  # the mean over nothing is the value; near it quadrature has no digits
        mean, size = mean_and_mean_size([c, p, q], angle)
    edges = np.linspace(0, angle, 41)

    def value(x):
        return c + p * np.cos(x) + q * np.sin(x)

    kinks = [quad(lambda x: abs(value(x)), a, b, limit=200)[0] for a, b in pairwise(edges)]
    assert_allclose(mean, quad(value, 0, angle, limit=400)[0] / angle, atol=1e-9)
    assert_allclose(size, sum(kinks) / angle, atol=1e-6)  # quadrature across a kink


def test_input_is_that_of_a_case_turned_step_by_step():
    rng = np.random.default_rng(3)
    axis = rng.standard_normal(3)
    axis /= np.linalg.norm(axis)
    omega_start, rate, time = rng.standard_normal(3), 0.7, 2.3
    C_start_now = Rotation.from_rotvec(axis * rate * time).as_matrix()  # turns the case; its axes in those of the start
    expected = C_start_now.T @ omega_start + rate * axis
    angle = rate * time
    result = np.array([1, np.cos(angle), np.sin(angle)]) @ input_harmonics(axis, rate, omega_start)
    assert_allclose(result, expected, atol=1e-14)


def test_readings_are_those_of_a_fine_time_step():
    triad = GyroTriad(
        bias=(0.1, -0.2, 0.3),
        scale_positive=(1.7, 1.6, 1.5),
        scale_negative=(1.71, 1.58, 1.52),
        misalignments=np.array([3, -2, 1, 4, -5, 2]) * 1e-3,
    )
    C_0_g1 = Construction(name="trihedral").C_0_g1(0.4)
    axis, rate, duration = np.array([0.6, 0.0, 0.8]), -0.02, 200.0
    omega_start = np.array([0.01, -0.03, 0.02])
    time = (np.arange(200_000) + 0.5) * duration / 200_000
    turned = Rotation.from_rotvec(axis * rate * time[:, None]).inv().apply(omega_start) + rate * axis
    inputs = turned @ (triad.A_g @ C_0_g1).T
    scale = np.where(inputs > 0, triad.scale_positive, triad.scale_negative)
    expected = (np.array(triad.bias) + inputs / scale).mean(axis=0)
    # midpoint rule of 200 000 steps: (rate * step)^2 / 24 of the input
    assert_allclose(mean_readings(triad, C_0_g1, axis, rate, omega_start, duration), expected, atol=1e-10)
