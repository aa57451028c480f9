"""Increments against integrals in closed form."""

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose

from fogkit.imu.tables import IMU_COLUMNS
from fogkit.navigation import increments_from_motion, increments_from_rates
from fogkit.navigation.increments import time_step

EPS = np.finfo(float).eps
# amplitude and angular frequency, rad/s, of a sinusoid in each column
AMPLITUDES, FREQUENCIES = np.array([1.0, -2.0, 0.5, 3.0, -1.0, 9.8]), np.array([3.0, 5.0, 7.0, 2.0, 4.0, 6.0])


def sinusoids(t):
    return AMPLITUDES * np.sin(np.outer(t, FREQUENCIES) + 0.3)


def integrals(t):
    return -AMPLITUDES / FREQUENCIES * np.cos(np.outer(t, FREQUENCIES) + 0.3)


def readings(values, time):
    return pd.DataFrame(values, index=pd.Index(time, name="time"), columns=list(IMU_COLUMNS))


def test_increments_of_a_motion_are_its_integrals():
    motion = increments_from_motion(lambda t: sinusoids(t)[:, :3], lambda t: sinusoids(t)[:, 3:], 2.0, 0.02)
    assert list(motion.columns) == list(IMU_COLUMNS)
    assert motion.index.name == "time"
    assert_allclose(motion.index, 0.02 * np.arange(100), rtol=2 * EPS)
    exact = np.diff(integrals(0.02 * np.arange(101)), axis=0)
    assert_allclose(motion, exact, atol=8 * EPS)  # difference of integrals of up to 5


def test_quadrature_error_that_the_docstring_states():
    # sinusoid with one period per step, which ends where it began
    def wave(t):
        return np.stack([np.cos(2 * np.pi * t), np.sin(2 * np.pi * t), np.cos(2 * np.pi * t + 1)], axis=-1)

    error = np.abs(increments_from_motion(wave, wave, 1.0, 1.0).to_numpy()).max()
    assert 2e-11 < error < 1e-10


def test_means_are_multiplied_by_the_step():
    time = 5.0 + 0.02 * np.arange(101)
    exact = np.diff(integrals(time), axis=0)
    back = increments_from_rates(readings(exact / 0.02, time[:-1]))
    assert_allclose(back, exact, rtol=1e-12)  # rounding of the times of 5 s
    assert_allclose(back.index, time[:-1])


def test_order_of_instantaneous_readings():
    errors = []
    for step in (0.02, 0.01, 0.005):
        time = step * np.arange(round(1 / step) + 1)
        back = increments_from_rates(readings(sinusoids(time), time), kind="instant")
        error = np.abs(back - np.diff(integrals(time), axis=0))
        errors.append([error.iloc[1:-1].to_numpy().max(), error.iloc[[0, -1]].to_numpy().max()])
        bound = 11 / 720 * step**5 * AMPLITUDES.max() * 6.0**4
        assert errors[-1][0] < bound * 1.01
        np.testing.assert_array_equal(back.index, time[:-1])
    assert_allclose(np.diff(np.log2(errors), axis=0), [[-5, -4]] * 2, atol=0.1)


def test_cubics_are_integrated_exactly():
    time = 0.1 * np.arange(20)
    cubic = np.polynomial.Polynomial([1.0, -2.0, 3.0, -4.0])
    back = increments_from_rates(readings(np.tile(cubic(time)[:, None], 6), time), kind="instant")
    exact = np.diff(cubic.integ()(time))
    assert_allclose(back.gyro_x[1:-1], exact[1:-1], atol=30 * EPS * np.abs(cubic.integ()(time)).max())


def test_time_step_is_the_mean_one():
    first, step = time_step(readings(np.zeros((4, 6)), [2.0, 2.1001, 2.2, 2.3]))
    assert (first, step) == (2.0, pytest.approx(0.1))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda t: t.drop(columns="gyro_z"), "without 'gyro_z'"),
        (lambda t: t.iloc[:3], "at least 4"),
        (lambda t: t.replace(0.0, np.nan), "finite"),
        (lambda t: t.drop(index=t.index[3]), "`readings.index` must be equally spaced"),
        (lambda t: t.set_axis([*"abcdefghij"], axis=0), "real numbers"),
    ],
)
def test_bad_readings_are_refused(change, words):
    good = readings(np.zeros((10, 6)), 0.1 * np.arange(10))
    with pytest.raises((ValueError, TypeError), match=words):
        increments_from_rates(change(good), kind="instant")
    with pytest.raises(ValueError, match="'mean', 'instant'"):
        increments_from_rates(good, kind="median")


def test_bad_motions_are_refused():
    def still(t):
        return np.zeros((len(t), 3))

    with pytest.raises(ValueError, match=r"whole number of steps of 0\.3 s, got 3\.333"):
        increments_from_motion(still, still, 1.0, 0.3)
    with pytest.raises(ValueError, match=r"`f_ib_b\(t\)` must be of shape"):
        increments_from_motion(still, lambda t: np.zeros(len(t)), 1.0, 0.1)
    with pytest.raises(ValueError, match="`step` must be finite and > 0 s"):
        increments_from_motion(still, still, 1.0, 0.0)
