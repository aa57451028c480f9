"""Mechanisation against the package's frames and matrices; the linear error model against differences of it."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.constants import EARTH_RATE, STANDARD_GRAVITY
from fogkit.gyrocompass import error_model, frames, mechanisation
from fogkit.gyrocompass.mechanisation import EARTH_RADIUS, CompassState, Reading
from fogkit.rotation import dcm_from_heading_pitch_roll, dcm_from_rotvec, heading_pitch_roll_from_dcm, skew

# Largest steps at which the fourth-order differences below are right to 1e-9 of the largest entry
STEPS = np.array([1e-3] * 3 + [1.0] * 3 + [1e-3, 1e-3, 1000.0] + [1e-3] * 6)


def cases(number, steep=1.2):
    rng = np.random.default_rng(7)
    for _ in range(number):
        state = CompassState(
            heading=rng.uniform(-3, 3),
            trim=rng.uniform(-steep, steep),
            roll=rng.uniform(-2, 2),
            velocity=rng.uniform(-200, 200, 3),
            lat=rng.uniform(-1.3, 1.3),
            lon=rng.uniform(-3, 3),
            alt=rng.uniform(0, 2e4),
        )
        yield (
            state,
            Reading(
                rates=rng.uniform(-1, 1, 3),
                specific_force=rng.uniform(-15, 15, 3),
                mount_angle=rng.uniform(-3, 3),
                mount_rate=rng.uniform(-0.6, 0.6),
            ),
        )


def rate_by_matrices(state, reading):
    """Rates of the nine quantities in the package's east-north-up frame, by matrices and vectors throughout."""
    P = frames.TO_PACKAGE
    C_b_n = dcm_from_heading_pitch_roll(state.heading, state.trim, state.roll)
    v = P @ state.velocity
    lat, radius = state.lat, EARTH_RADIUS + state.alt
    omega_ie_n = EARTH_RATE * np.array([0, np.cos(lat), np.sin(lat)])
    omega_en_n = np.array([-v[1], v[0], v[0] * np.tan(lat)]) / radius
    # gyros stand on a mount that is turned about the body's z, the third axis of the package
    C_m_b = dcm_from_rotvec([0, 0, reading.mount_angle])
    omega_ib_b = C_m_b @ (P @ frames.pyramid_axes() @ reading.rates) - [0, 0, reading.mount_rate]
    C_rate = C_b_n @ skew(omega_ib_b) - skew(omega_ie_n + omega_en_n) @ C_b_n
    step = 1e-4  # s; angles by central differences of the attitude after a step forth and back
    turn = C_b_n.T @ C_rate
    turn = np.array([turn[2, 1], turn[0, 2], turn[1, 0]])
    forth, back = (np.array(heading_pitch_roll_from_dcm(C_b_n @ dcm_from_rotvec(s * step * turn))) for s in (1, -1))
    angles = (forth - back + np.pi) % (2 * np.pi) - np.pi
    g = np.array([0, 0, -STANDARD_GRAVITY * (EARTH_RADIUS / radius) ** 2])
    dv = C_b_n @ P @ reading.specific_force + g - np.cross(2 * omega_ie_n + omega_en_n, v)
    return np.array([*angles / (2 * step), *(P.T @ dv), v[1] / radius, v[0] / (radius * np.cos(lat)), v[2]])


def test_rates_against_matrices_in_the_package_frame():
    for state, reading in cases(30):
        # the difference of angles is wrong by the square of the angle of a step, (2e-4 / cos(trim))**2, and rounding
        got, truth = mechanisation.state_rate(state, reading), rate_by_matrices(state, reading)
        assert_allclose(got[:3], truth[:3], atol=1e-6 * np.abs(truth[:3]).max())
        assert_allclose(got[3:], truth[3:], rtol=1e-11, atol=1e-13)


def test_at_rest_nothing_moves():
    state = CompassState(heading=0.7, trim=0.1, roll=-0.2, lat=1.0)
    C_h_g = frames.hull_attitude(0.7, 0.1, -0.2)
    earth = C_h_g.T @ mechanisation.geographic_rate(1.0, np.zeros(3))
    rates = mechanisation.gyro_rates(earth, 2.0, 0.3)  # the mount turns, the hull does not
    reading = Reading(rates=rates, specific_force=C_h_g.T @ [0, STANDARD_GRAVITY, 0], mount_angle=2.0, mount_rate=0.3)
    assert_allclose(mechanisation.state_rate(state, reading), 0, atol=1e-14)


def test_a_turn_to_starboard_raises_heading():
    rates = mechanisation.angle_rates([0.0, -0.1, 0.0], 0.0, 0.0)  # about down
    assert_allclose(rates, [0.1, 0, 0], atol=1e-17)


def differences(state, reading):
    """Matrix of the derivatives of the nonlinear rates, by central differences of the fourth order."""

    def rate(x):
        moved = CompassState(heading=x[0], trim=x[1], roll=x[2], velocity=x[3:6], lat=x[6], lon=x[7], alt=x[8])
        wrong = replace(reading, rates=reading.rates * (1 + x[12:]) + x[9:12])
        return mechanisation.state_rate(moved, wrong)

    x = np.concatenate([state.to_vector(), np.zeros(6)])
    columns = []
    for h, e in zip(STEPS, np.eye(15), strict=True):
        one, two = (rate(x + k * h * e) - rate(x - k * h * e) for k in (1, 2))
        columns.append((8 * one - two) / (12 * h))
    return np.array(columns).T


def test_error_model_against_differences():
    for state, reading in cases(12):
        F, numeric = error_model.system_matrix(state, reading), differences(state, reading)
        assert not F[9:].any()
        for block in (slice(0, 3), slice(3, 6), slice(6, 9)):  # each of one unit, lest gravity hide what is small
            largest = np.abs(numeric[block]).max(axis=0)
            scale = np.where(largest > 0, largest, 1)
            # 1e-6 of the column is what is asked of the model; the differences themselves are right to 1e-8
            assert_allclose(F[block] / scale, numeric[block] / scale, atol=1e-6)


def test_inputs_are_columns_of_the_error_model():
    for state, reading in cases(5):
        F = error_model.system_matrix(state, reading)
        G = error_model.noise_input(state.trim, state.roll, reading.mount_angle)
        assert_allclose(G, F[:, 9:12], atol=1e-15 / np.cos(state.trim))
        force = error_model.accelerometer_input(state.heading, state.trim, state.roll)
        step = replace(reading, specific_force=reading.specific_force + np.eye(3)[1])
        change = mechanisation.state_rate(state, step) - mechanisation.state_rate(state, reading)
        assert_allclose(force[:9, 1], change, atol=1e-13)


def test_measurement():
    H = error_model.measurement_matrix()
    assert H.shape == (6, 15)
    assert_allclose(H @ np.arange(15.0), [3, 4, 5, 6, 7, 8])
    assert error_model.measurement_matrix(["heading"]).argmax() == 0
    with pytest.raises(ValueError, match="unaided filter"):
        error_model.measurement_matrix([])
    with pytest.raises(ValueError, match="`measured` must be one of"):
        error_model.measurement_matrix(["yaw"])
    with pytest.raises(ValueError, match="each state once"):
        error_model.measurement_matrix(["lat", "lat"])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"trim": np.pi / 2}, "`trim` must be in .*bow is vertical"),
        ({"lat": np.pi / 2}, "`lat` must be in .*not defined at a pole"),
        ({"lat": 59.9}, "`lat` must be in .*fogkit.units.DEG"),
        ({"velocity": (0.0, 1.0)}, "`velocity` must be of shape"),
        ({"heading": np.nan}, "`heading` must be finite"),
    ],
)
def test_bad_states(change, words):
    with pytest.raises(ValueError, match=words):
        CompassState(**{"heading": 0.0, "lat": 1.0, **change})


def test_bad_readings():
    with pytest.raises(ValueError, match="`rates` must be finite"):
        Reading(rates=(0.0, np.inf, 0.0))
    with pytest.raises(ValueError, match="`trim` must be in"):
        mechanisation.angle_rates([0.0, 0.1, 0.0], [0.0, 1.5705], 0.0)
    with pytest.raises(ValueError, match="`lat` must be in"):
        mechanisation.geographic_rate(1.5705, np.zeros(3))
    with pytest.raises(ValueError, match="`gravity` must be finite and > 0"):
        mechanisation.state_rate(CompassState(heading=0.0, lat=1.0), Reading(rates=np.zeros(3)), gravity=-9.8)
