"""The mechanisation against closed forms, an integration in Earth-fixed coordinates, `pyins` and its own symmetries."""

from functools import cache

import numpy as np
import pandas as pd
import pyins.earth
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from pyins.strapdown import Integrator, compute_increments_from_imu
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from fogkit import earth
from fogkit.constants import EARTH_RATE, SEMI_MAJOR_AXIS
from fogkit.imu.tables import IMU_COLUMNS
from fogkit.navigation import State, increments_from_motion, integrate, integrate_arrays
from fogkit.rotation import dcm_from_heading_pitch_roll, heading_pitch_roll_from_dcm, small_angle_between
from fogkit.units import ARCSEC, DEG, HOUR

EPS = np.finfo(float).eps
LAT = 55 * DEG
ORDERS = {"none": 2, "previous": 3, "central": 4}
# The same order of a sequence of halved steps is seen in a ratio of 2**order; 0.1 leaves room for the next order.
SLOPE = 0.1


def at_rest(lat, C_b_n, dt, steps, alt=0.0):
    """Increments of a unit at rest on the Earth: constant in its axes, so exact at any step."""
    dtheta, dv = C_b_n.T @ earth.earth_rate_n(lat) * dt, -C_b_n.T @ earth.gravity_n(lat, alt) * dt
    return np.tile(dtheta, (steps, 1)), np.tile(dv, (steps, 1))


def table(dtheta, dv, dt, first=0.0):
    """Table of increments."""
    time = pd.Index(first + dt * np.arange(len(dtheta)), name="time")
    return pd.DataFrame(np.hstack([dtheta, dv]), index=time, columns=list(IMU_COLUMNS))


def orders(errors):
    """Slopes of errors at halved steps."""
    errors = np.array(errors)
    return np.log2(errors[:-1] / errors[1:])


# ---- the truth of a manoeuvre: Earth-fixed coordinates, no transport rate, no radii of curvature in the rates

MANOEUVRE = State(
    lat=0.9, lon=0.4, alt=300.0, v_eb_n=(30.0, -200.0, 5.0), C_b_n=dcm_from_heading_pitch_roll(-0.3, 0.2, -0.4)
)
MANOEUVRE_TIME = 10.0


def manoeuvre_rate(t):
    x, y = 0.5 * np.sin(1.3 * t) + 0.2, 0.6 * np.cos(1.7 * t)
    return np.stack([x, y, 0.4 * np.sin(0.9 * t + 0.3) + 0.3 * np.cos(2.3 * t)], axis=-1)


def manoeuvre_force(t):
    return np.stack([2 * np.sin(1.9 * t), 1 + 3 * np.cos(1.1 * t), 9.8 + 2 * np.sin(1.5 * t + 0.5)], axis=-1)


@cache
def manoeuvre_increments(steps):
    motion = increments_from_motion(manoeuvre_rate, manoeuvre_force, MANOEUVRE_TIME, MANOEUVRE_TIME / steps, nodes=10)
    return motion.to_numpy()[:, :3].copy(), motion.to_numpy()[:, 3:].copy(), MANOEUVRE_TIME / steps


@cache
def manoeuvre_end():
    """Attitude, velocity and position at the end, by DOP853.

    The position is integrated as the departure from a uniform motion, of a hundred metres: the Earth's radius would
    cost seven digits.
    """
    C_n_e = earth.dcm_e_n(MANOEUVRE.lat, MANOEUVRE.lon).T
    r_0, v_0 = earth.ecef_from_geodetic(MANOEUVRE.lat, MANOEUVRE.lon, MANOEUVRE.alt), C_n_e @ MANOEUVRE.v_eb_n
    omega_ie_e = np.array([0.0, 0.0, EARTH_RATE])

    def derivative(t, y):
        C_b_e, v = y[:9].reshape(3, 3), v_0 + y[9:12]
        lat, lon, alt = earth.geodetic_from_ecef(r_0 + v_0 * t + y[12:])
        g_b_e = earth.dcm_e_n(lat, lon).T @ earth.gravity_n(lat, alt)
        turn = np.cross(C_b_e, manoeuvre_rate(t) - omega_ie_e @ C_b_e)
        return np.concatenate([turn.ravel(), C_b_e @ manoeuvre_force(t) + g_b_e - 2 * np.cross(omega_ie_e, v), y[9:12]])

    begin = np.concatenate([(C_n_e @ MANOEUVRE.C_b_n).ravel(), np.zeros(6)])
    end = solve_ivp(derivative, (0, MANOEUVRE_TIME), begin, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    lat, lon, alt = earth.geodetic_from_ecef(r_0 + v_0 * MANOEUVRE_TIME + end[12:])
    C_e_n = earth.dcm_e_n(lat, lon)
    return C_e_n @ end[:9].reshape(3, 3), C_e_n @ (v_0 + end[9:12]), np.array([lat, lon, alt])


def manoeuvre_errors(steps, **options):
    """Errors of attitude, rad, velocity, m/s, and position, m, at the end."""
    end = integrate_arrays(*manoeuvre_increments(steps), MANOEUVRE, every=steps, **options).state()
    C_b_n, v_eb_n, position = manoeuvre_end()
    metres = np.array([1.0, np.cos(end.lat), 0.0]) * SEMI_MAJOR_AXIS + [0, 0, 1]
    return (
        np.linalg.norm(small_angle_between(end.C_b_n, C_b_n)),
        np.linalg.norm(end.v_eb_n - v_eb_n),
        np.linalg.norm((np.array([end.lat, end.lon, end.alt]) - position) * metres),
    )


@pytest.mark.parametrize("corrections", ORDERS)
def test_order_in_attitude_velocity_and_position(corrections):
    # 0.05 to 0.0125 s: the last error is 30 times what is left out of second order or more, in velocity and position
    errors = [manoeuvre_errors(steps, corrections=corrections) for steps in (200, 400, 800)]
    assert_allclose(orders(errors), ORDERS[corrections], atol=SLOPE)


def test_accuracy_of_a_manoeuvre():
    # at 1 kHz the terms of fourth order are below 1e-11: what is left is the truth's own error, rtol 1e-12 of 1 rad, of
    # 200 m/s and of some 100 m, 1e-9 m in the conversion from r_eb_e, and terms of second order, 3e-11 m/s and 1e-9 m
    attitude, velocity, position = manoeuvre_errors(10_000)
    assert attitude < 1e-11
    assert velocity < 2e-10
    assert position < 5e-9


def test_a_climb_in_the_plane_of_the_equator():
    # A thrust that stands still in space, from rest, for 100 s: an orbit in inertial coordinates. Its increments are
    # constant, so at steps of 1 s gravity at the right mean height shows: 6e-5 m/s of velocity depend on it.
    thrust, time = 12.0, 100.0

    def derivative(t, y):
        r = np.hypot(SEMI_MAJOR_AXIS + y[0], y[1])
        pull = earth.normal_gravity(0.0, r - SEMI_MAJOR_AXIS) + EARTH_RATE**2 * r  # gravitation alone
        return [y[2], y[3], thrust - pull * (SEMI_MAJOR_AXIS + y[0]) / r, -pull * y[1] / r]

    y = solve_ivp(derivative, (0, time), [0, 0, 0, EARTH_RATE * SEMI_MAJOR_AXIS], rtol=1e-12, atol=1e-9).y[:, -1]
    along = np.array([SEMI_MAJOR_AXIS + y[0], y[1]])
    r = np.hypot(*along)
    up, east = along @ y[2:] / r, (along[0] * y[3] - along[1] * y[2]) / r - EARTH_RATE * r

    dtheta, dv = np.zeros((100, 3)), np.tile([0.0, 0.0, thrust], (100, 1))
    end = integrate_arrays(dtheta, dv, 1.0, State(lat=0.0, C_b_n=np.eye(3)), every=100).state()
    # left out, with the step T: T^2 |g| / (12 R) of the change across, 12 m/s; T^2 |g| / (6 R) of the climb, 11 km
    assert_allclose(end.v_eb_n, [east, 0.0, up], atol=2e-6)
    assert_allclose(end.alt, r - SEMI_MAJOR_AXIS, atol=3e-3)


# ---- closed forms


@pytest.mark.parametrize("lat", [-80 * DEG, 0.0, LAT])
def test_a_unit_at_rest_stays_where_it_is(lat):
    C_b_n = dcm_from_heading_pitch_roll(0.7, -0.3, 1.1)
    dtheta, dv = at_rest(lat, C_b_n, 0.1, 36_000, alt=120.0)
    start = State(lat=lat, lon=2.0, alt=120.0, C_b_n=C_b_n)
    end = integrate_arrays(dtheta, dv, 0.1, start, every=36_000).state()
    # an hour: every step rounds alike, so an attitude of size 1 drifts by up to 2 EPS a step, 1.6e-11 rad. Of that
    # gravity makes 8 km/s per radian, and that a position; gravity there is another, by 0.05 m/s^2 per radian, and
    # errors in height grow by cosh(sqrt(2 g / R) t), 280
    assert_allclose(small_angle_between(end.C_b_n, C_b_n), 0, atol=EPS * 36_000 * 2)
    assert_allclose(end.v_eb_n, 0, atol=1.3e-7)
    assert_allclose([end.lat - lat, end.lon - 2.0], 0, atol=7e-11)
    assert_allclose(end.alt, 120.0, atol=3e-4)


def test_a_tilted_unit_swings_with_the_schuler_period():
    # A small tilt about east swings the unit along the meridian: at the equator the Earth rate, which lies along north,
    # does not rotate that tilt. Held at its height: gravity of one value, and no vertical velocity to speak of.
    tilt, dt, steps = 1 * ARCSEC, 1.0, 5000
    g = float(earth.normal_gravity(0.0))
    dtheta, dv = at_rest(0.0, np.eye(3), dt, steps)
    C_b_n = Rotation.from_rotvec([tilt, 0, 0]).as_matrix()
    trajectory = integrate_arrays(dtheta, dv, dt, State(lat=0.0, C_b_n=C_b_n), gravity=g)
    schuler = np.sqrt(g / earth.radius_meridian(0.0))
    assert 2 * np.pi / schuler / 60 == pytest.approx(84.4, abs=0.5)  # the textbook's minutes, for a mean radius
    # the Earth turns the tilt into azimuth and back, which changes the phase by (Earth rate / Schuler rate)^2 of itself
    slack = (EARTH_RATE / schuler) ** 2
    amplitude = g * tilt / schuler
    expected = -amplitude * np.sin(schuler * trajectory.time)
    assert_allclose(trajectory.v_eb_n[:, 1], expected, atol=slack * schuler * trajectory.time[-1] * amplitude)
    crossing = trajectory.time[1:-1][np.diff(np.sign(trajectory.v_eb_n[1:, 1])) != 0]
    assert_allclose(crossing, np.pi / schuler, rtol=slack, atol=dt)


def test_without_forces_a_body_flies_straight_in_space():
    # No gravity and no specific force: Coriolis alone is left, the centrifugal acceleration being a part of gravity, so
    # the velocity in Earth-fixed axes only turns: v_e = R(-2 omega t) v_0.
    v_0, duration, steps = np.array([200.0, 100.0, 50.0]), 300.0, 3000
    dt = duration / steps
    end = integrate_arrays(
        *np.zeros((2, steps, 3)), dt, State(lat=LAT, v_eb_n=v_0, C_b_n=np.eye(3)), gravity=(0, 0, 0), every=steps
    ).state()
    C_n_e = earth.dcm_e_n(LAT, 0.0).T
    omega = np.array([0, 0, EARTH_RATE])
    turned = Rotation.from_rotvec(-2 * omega * duration).as_matrix() @ C_n_e @ v_0
    # the body does not turn in space, so in Earth-fixed axes it turns back by the Earth rate
    attitude = Rotation.from_rotvec(-omega * duration).as_matrix() @ C_n_e
    C_e_n = earth.dcm_e_n(end.lat, end.lon)
    # left out of the kernel: T^2 |v|^3 / R^2 per second, 1e-9 m/s after 300 s at 0.1 s; attitude the same over |v|
    assert_allclose(end.v_eb_n, C_e_n @ turned, atol=2e-9)
    assert_allclose(small_angle_between(end.C_b_n, C_e_n @ attitude), 0, atol=1e-11)


def test_a_constant_rate_is_exact_at_any_step():
    # 0.8 rad a step, far beyond the series at small angles, and 0.08, within
    rate = np.array([0.3, -0.5, 0.55])
    for dt in (1.0, 0.1):
        steps = round(100 / dt)
        trajectory = integrate_arrays(
            np.tile(rate * dt, (steps, 1)), np.zeros((steps, 3)), dt, State(lat=LAT, C_b_n=np.eye(3)), gravity=0.0
        )
        C_i = Rotation.from_rotvec(-earth.earth_rate_n(LAT) * trajectory.time[:, None])
        expected = C_i * Rotation.from_rotvec(rate * trajectory.time[:, None])
        assert_allclose(trajectory.C_b_n, expected.as_matrix(), atol=20 * EPS * steps**0.5 + 4 * EPS * 80)


def test_force_in_a_constant_rate_is_exact():
    # Velocity gained by a force fixed to a turning body, against the integral of the matrix by 20-point quadrature:
    # [3] alone, since nothing changes from step to step; at 0.9 and 0.1 rad, either side of the switch to series.
    points, weights = np.polynomial.legendre.leggauss(20)
    force, free = np.array([1.0, -2.0, 3.0]), {"gravity": 0.0, "position_fixed": True}
    for angle in (0.9, 0.249, 0.251, 1e-4):
        rate, dt = angle * np.array([2.0, -1.0, 2.0]) / 3, 1e-12  # so short that the Earth does not turn
        turns = Rotation.from_rotvec(0.5 * (1 + points)[:, None] * rate).as_matrix()
        expected = 0.5 * np.einsum("k,kij,j->i", weights, turns, force)
        start = State(lat=LAT, C_b_n=np.eye(3))
        with pytest.warns(UserWarning, match="feels"):  # a force without gravity
            moved = integrate_arrays(rate[None], force[None], dt, start, **free)
        assert_allclose(moved.v_eb_n[1], expected, rtol=0, atol=8 * EPS)


def coning(angle, frequency):
    """Rate of a body whose z axis describes a cone, and its attitude against inertial space."""
    w = 2 * np.pi * frequency

    def rate(t):
        return np.stack(
            [-w * np.sin(angle) * np.sin(w * t), w * np.sin(angle) * np.cos(w * t), -w * (1 - np.cos(angle)) + 0 * t],
            -1,
        )

    def attitude(t):
        return Rotation.from_rotvec(angle * np.stack([np.cos(w * t), np.sin(w * t), 0 * t], -1))

    return rate, attitude


def nothing(t):
    return np.zeros((len(t), 3))


@pytest.mark.parametrize("corrections", ORDERS)
def test_coning_drift_is_removed_to_the_claimed_order(corrections):
    # 1 degree at 5 Hz. Pure coning is kind to the step before: its third order is left in the first step alone.
    angle, frequency, duration = 1 * DEG, 5.0, 2.0
    rate, attitude = coning(angle, frequency)
    start, errors = State(lat=LAT, C_b_n=attitude(np.zeros(1)).as_matrix()[0]), []
    for dt in (0.02, 0.01, 0.005):
        motion = increments_from_motion(rate, nothing, duration, dt)
        end = integrate_arrays(
            motion.to_numpy()[:, :3], motion.to_numpy()[:, 3:], dt, start, gravity=0.0, corrections=corrections
        ).state()
        back = Rotation.from_rotvec(-earth.earth_rate_n(LAT) * duration)
        expected = (back * attitude(np.array([duration]))).as_matrix()[0]
        errors.append(np.linalg.norm(small_angle_between(end.C_b_n, expected)))
    if corrections == "previous":
        assert (orders(errors) > 3).all()
    else:
        assert_allclose(orders(errors), ORDERS[corrections], atol=SLOPE)
    if corrections == "none":
        drift = 0.5 * 2 * np.pi * frequency * angle**2
        uncorrected = drift * (1 - np.sinc(2 * frequency * 0.005))  # Titterton and Weston (2004), section 11.2.4
        assert_allclose(errors[-1], uncorrected * duration, rtol=0.01)


def test_sculling_drift_is_removed():
    # A rocking about x in phase with a force along y drives the velocity along z by half the product of the amplitudes;
    # exactly, the angle of the rocking A sin(wt) and the force B sin(wt): mean of B sin(A sin wt) sin wt = B J_1(A).
    from scipy.special import j1

    A, B, w, duration = 0.02, 20.0, 2 * np.pi * 5, 2.0

    def rate(t):
        return np.stack([A * w * np.cos(w * t), 0 * t, 0 * t], -1)

    def force(t):
        return np.stack([0 * t, B * np.sin(w * t), 0 * t], -1)

    errors = []
    fixed = {"gravity": 1e-3, "position_fixed": True, "keep_attitude": False}
    for dt in (0.02, 0.01, 0.005):
        motion = increments_from_motion(rate, force, duration, dt).to_numpy()
        with pytest.warns(UserWarning, match="feels"):
            end = integrate_arrays(motion[:, :3], motion[:, 3:], dt, State(lat=0.0, C_b_n=np.eye(3)), **fixed)
        errors.append(abs(end.v_eb_n[-1, 2] - (B * j1(A) - 1e-3) * duration))
    # the Earth turns the force by 1.5e-4 rad meanwhile: along y and z of it there is no mean, so 1e-8 of it remains
    assert_allclose(orders(errors), 4, atol=2 * SLOPE)
    assert errors[-1] < 1e-3 * B * j1(A) * duration


# ---- another implementation


def pyins_end(steps):
    """End of the manoeuvre by `pyins`: heading, pitch, roll; velocity, east-north-up; latitude, longitude, height."""
    dtheta, dv, dt = manoeuvre_increments(steps)
    swap = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]])  # right-forward-up to forward-right-down, east-north-up to NED
    readings = np.vstack([np.zeros(6), np.hstack([dtheta @ swap, dv @ swap])])
    readings = pd.DataFrame(readings, columns=list(IMU_COLUMNS), index=dt * np.arange(steps + 1))
    heading, pitch, roll = (float(angle) / DEG for angle in heading_pitch_roll_from_dcm(MANOEUVRE.C_b_n))
    east, north, up = MANOEUVRE.v_eb_n
    begin = {"lat": MANOEUVRE.lat / DEG, "lon": MANOEUVRE.lon / DEG, "alt": float(MANOEUVRE.alt)}
    begin |= {"VN": north, "VE": east, "VD": -up, "roll": roll, "pitch": pitch, "heading": heading}
    increments = compute_increments_from_imu(readings, "increment")
    end = Integrator(pd.Series(begin, name=0.0)).integrate(increments).iloc[-1]
    velocity = end[["VE", "VN", "VD"]].to_numpy() * [1, 1, -1]
    position = end[["lat", "lon", "alt"]].to_numpy() * [DEG, DEG, 1]
    return end[["heading", "pitch", "roll"]].to_numpy() * DEG, velocity, position


def pyins_gravity(lat, lon, alt):
    """Gravity of `pyins`, which leaves out the flattening from its change with height."""
    return np.stack([0 * lat, 0 * lat, -pyins.earth.gravity(lat / DEG, alt)], axis=-1)


@pytest.mark.filterwarnings("ignore:The copy keyword is deprecated")  # in pyins 1.0.1 with pandas 3
def test_pyins_on_the_same_increments():
    # Both with the correction from the step before, and with one gravity. `pyins` leaves out the square of the angle in
    # the velocity gained, p^2 / 6 of the force, is of first order in Coriolis and the transport rate, and moves by
    # trapezoids: the difference must vanish with the step, at least in proportion to it.
    differences = []
    for steps in (2000, 4000):
        theirs = pyins_end(steps)
        ours = integrate_arrays(*manoeuvre_increments(steps), MANOEUVRE, corrections="previous", gravity=pyins_gravity)
        angles = np.array([angle[-1] for angle in ours.heading_pitch_roll])
        position = np.array([ours.lat[-1], ours.lon[-1], ours.alt[-1]])
        metres = np.array([SEMI_MAJOR_AXIS, SEMI_MAJOR_AXIS, 1.0])
        pairs = ((angles, theirs[0]), (ours.v_eb_n[-1], theirs[1]), (position * metres, theirs[2] * metres))
        differences.append([np.linalg.norm(one - other) for one, other in pairs])
    coarse, fine = np.array(differences)
    # at 2.5 ms: transport rate of half a step, 1e-6 rad/s^2 T / 2 for 10 s; (1 rad/s T)^2 / 6 of 12 m/s^2 for 10 s
    assert (fine < [1.2e-8, 1.3e-4, 6e-4]).all(), fine
    assert (coarse > 1.9 * fine).all(), (coarse, fine)


# ---- options


def test_many_runs_are_each_run_alone():
    rng = np.random.default_rng(3)
    dtheta, dv, dt = manoeuvre_increments(200)
    dtheta = dtheta + 1e-4 * rng.standard_normal((2, 3, 200, 3))
    dv = dv + 1e-3 * rng.standard_normal((2, 3, 200, 3))
    C_b_n = Rotation.random(3, rng=rng).as_matrix()
    lat, resets, gravity = (
        np.array([[0.1], [-0.5]]),
        rng.uniform(0, 10, (2, 3, 2)),
        rng.normal(9.8, 0.1, (2, 3, 200, 3)),
    )
    start = State(lat=lat, C_b_n=C_b_n, alt=100.0, v_eb_n=(1.0, 2.0, 3.0))
    options = {"velocity_reset": resets, "every": 7}
    for forces in ({}, {"gravity": gravity}):
        together = integrate_arrays(dtheta, dv, dt, start, **options, **forces)
        assert together.v_eb_n.shape == (2, 3, 29, 3)
        for i, j in np.ndindex(2, 3):
            alone = integrate_arrays(
                dtheta[i, j],
                dv[i, j],
                dt,
                State(lat=lat[i, 0], C_b_n=C_b_n[j], alt=100.0, v_eb_n=(1.0, 2.0, 3.0)),
                velocity_reset=resets[i, j],
                every=7,
                **({"gravity": gravity[i, j]} if forces else {}),
            )
            for name in ("lat", "lon", "alt", "v_eb_n", "quaternion"):
                np.testing.assert_array_equal(getattr(together, name)[i, j], getattr(alone, name))


def test_rows_kept_are_those_of_the_whole_trajectory():
    whole = integrate_arrays(*manoeuvre_increments(200), MANOEUVRE, start_time=5.0)
    some = integrate_arrays(*manoeuvre_increments(200), MANOEUVRE, start_time=5.0, every=30, keep_attitude=False)
    assert_allclose(some.time, 5.0 + 0.05 * 30 * np.arange(7), rtol=2 * EPS)
    np.testing.assert_array_equal(some.v_eb_n, whole.v_eb_n[::30])
    np.testing.assert_array_equal(some.alt, whole.alt[::30])
    with pytest.raises(ValueError, match="keep_attitude=True"):
        _ = some.C_b_n


def test_navigation_goes_on_from_any_row():
    # without corrections no step knows its neighbours; rounding of 6e6 m / R in the quaternion of the restart
    dtheta, dv, dt = manoeuvre_increments(200)
    whole = integrate_arrays(dtheta, dv, dt, MANOEUVRE, corrections="none")
    rest = integrate_arrays(dtheta[80:], dv[80:], dt, whole.state(80), corrections="none")
    # the mean position of the first step is predicted without Coriolis of the step before: 3e-6 s^-2 of 1e-5 m
    assert_allclose(rest.v_eb_n[-1], whole.v_eb_n[-1], atol=1e-11)
    assert_allclose(rest.C_b_n[-1], whole.C_b_n[-1], atol=1e-14)


def test_a_reset_starts_anew_from_rest():
    C_b_n = dcm_from_heading_pitch_roll(0.5, 0.1, -0.2)
    dtheta, dv = at_rest(LAT, C_b_n, 0.01, 4000)
    tilted = Rotation.from_rotvec([1e-3, -2e-3, 0]).as_matrix() @ C_b_n
    start = State(lat=LAT, C_b_n=tilted)
    whole = integrate(table(dtheta, dv, 0.01, first=100.0), start, position_fixed=True, velocity_reset=[130.0, 110.004])
    assert_allclose(whole.time[[0, 1000, -1]], [100.0, 110.0, 140.0], rtol=1e-12)
    free = integrate(table(dtheta, dv, 0.01, first=100.0), start, position_fixed=True)
    np.testing.assert_array_equal(whole.v_eb_n[:1000], free.v_eb_n[:1000])
    for row in (1000, 3000):
        np.testing.assert_array_equal(whole.v_eb_n[row], 0)
        rest = integrate_arrays(
            dtheta[row:], dv[row:], 0.01, State(lat=LAT, C_b_n=whole.C_b_n[row]), position_fixed=True
        )
        until = 2000 if row == 1000 else 1001
        assert_allclose(whole.v_eb_n[row : row + until], rest.v_eb_n[:until], atol=1e-10)  # rounding of 1000 steps
    assert np.linalg.norm(whole.v_eb_n[2999]) > 0.1  # the tilt goes on to be felt: 20 s of 2 mrad of gravity


@pytest.mark.parametrize("step", [0, 4000])
def test_a_reset_may_be_at_either_end(step):
    dtheta, dv = at_rest(LAT, np.eye(3), 0.01, 4000)
    start = State(lat=LAT, C_b_n=np.eye(3), v_eb_n=(1.0, 0.0, 0.0))
    v = integrate_arrays(dtheta, dv, 0.01, start, velocity_reset=step * 0.01, position_fixed=True).v_eb_n
    np.testing.assert_array_equal(v[step], 0)
    assert abs(v[4000 - step, 0] - (step > 0)) < 1e-4  # untouched, but for 40 s of Coriolis of its square


def test_position_fixed_differs_by_what_the_motion_would_change():
    C_b_n = Rotation.from_rotvec([0, 1e-4, 0]).as_matrix()
    dtheta, dv = at_rest(LAT, np.eye(3), 0.01, 3500)
    start = State(lat=LAT, lon=1.0, alt=50.0, C_b_n=C_b_n)
    moving, fixed = (integrate_arrays(dtheta, dv, 0.01, start, position_fixed=held) for held in (False, True))
    np.testing.assert_array_equal([fixed.lat, fixed.lon, fixed.alt], np.transpose([[LAT, 1.0, 50.0]] * 3501))
    # 35 s of a tilt of 0.1 mrad: 3 cm/s to the east, of which Coriolis makes 5 mm/s and 6 cm upwards; there gravity is
    # less by 3e-6 s^-2 of that, for a third of the time on average
    assert np.abs(fixed.v_eb_n[-1, 0]) > 0.03
    assert_allclose(moving.v_eb_n, fixed.v_eb_n, atol=6e-6)


def test_gravity_in_all_its_forms():
    dtheta, dv, dt = manoeuvre_increments(200)
    normal = integrate_arrays(dtheta, dv, dt, MANOEUVRE)

    def function(lat, lon, alt):
        return earth.gravity_n(lat, alt)

    followed = integrate_arrays(dtheta, dv, dt, MANOEUVRE, gravity=function)
    assert_allclose(followed.v_eb_n, normal.v_eb_n, atol=1e-11)

    # a constant as a number, vector, one vector a step and function: the last differs from normal gravity by up to
    # 1e-4 along the path, which is then a trapezoid: 9.8 * 3e-7 m^-1 * |a| T^2 / 12 = 7e-9 m/s^2 for 10 s
    constant = integrate_arrays(dtheta, dv, dt, MANOEUVRE, gravity=9.8)
    for same in ((0, 0, -9.8), np.tile([0, 0, -9.8], (200, 1))):
        np.testing.assert_array_equal(integrate_arrays(dtheta, dv, dt, MANOEUVRE, gravity=same).v_eb_n, constant.v_eb_n)
    followed = integrate_arrays(
        dtheta, dv, dt, MANOEUVRE, gravity=lambda lat, lon, alt: np.stack([0 * lat, 0 * lon, 0 * alt - 9.8], -1)
    )
    assert_allclose(followed.v_eb_n, constant.v_eb_n, atol=7e-8)


def level_flight_east(v_east, dt, steps):
    """Increments of level flight along the equator, heading north: constant, so exact at any step."""
    R, g = SEMI_MAJOR_AXIS, float(earth.normal_gravity(0.0))
    dtheta = np.array([0.0, EARTH_RATE + v_east / R, 0.0]) * dt
    dv = np.array([0.0, 0.0, g - 2 * EARTH_RATE * v_east - v_east**2 / R]) * dt
    return np.tile(dtheta, (steps, 1)), np.tile(dv, (steps, 1))


def test_level_flight_along_the_equator():
    v_east, dt, steps = 250.0, 0.1, 6000
    start = State(lat=0.0, lon=-1.0, v_eb_n=(v_east, 0.0, 0.0), C_b_n=np.eye(3))
    end = integrate_arrays(*level_flight_east(v_east, dt, steps), dt, start, every=steps).state()
    # rounding of 1 m/s a step, and at rest 3e-13 m/s^2 of what is left out grows as the cube of the rate: 6
    assert_allclose(end.v_eb_n, [v_east, 0, 0], atol=1e-10)
    assert_allclose(small_angle_between(end.C_b_n, np.eye(3)), 0, atol=1e-13)
    assert_allclose(end.lon, -1.0 + v_east * 600 / SEMI_MAJOR_AXIS, atol=1e-13)
    assert_allclose([end.lat, end.alt], 0, atol=1e-7)


def test_a_gravity_map_is_felt_where_the_unit_is():
    # a northward deflection that grows with longitude, flown through at constant velocity: its integral along the path
    slope, v_east, dt, steps = 1e-3, 100.0, 0.1, 1000
    start = State(lat=0.0, v_eb_n=(v_east, 0, 0), C_b_n=np.eye(3))

    def disturbed(lat, lon, alt):
        return earth.gravity_n(lat, alt) + np.stack([0 * lat, slope * lon, 0 * lat], -1)

    flight = level_flight_east(v_east, dt, steps)
    end = integrate_arrays(*flight, dt, start, gravity=disturbed, every=steps).v_eb_n[-1]
    time = steps * dt
    # the frame follows the northward way, so gravity swings it back: (t / 806 s)^2 / 12 of it, 1.3e-3
    assert_allclose(end[1], slope * v_east / SEMI_MAJOR_AXIS * time**2 / 2, rtol=2e-3)


def test_a_gravity_function_is_asked_once_where_the_position_is_fixed():
    asked = []

    def disturbed(lat, lon, alt):
        asked.append(np.shape(lat))
        return earth.gravity_n(lat, alt) + np.array([1e-4, 0, 0])

    dtheta, dv = at_rest(LAT, np.eye(3), 0.01, 1000)
    start = State(lat=np.full(2, LAT), C_b_n=np.eye(3))
    run = integrate_arrays(
        np.stack([dtheta] * 2), np.stack([dv] * 2), 0.01, start, gravity=disturbed, position_fixed=True
    )
    assert_allclose(run.v_eb_n[:, -1, 0], 1e-3, rtol=5e-5)  # the swing over 10 s: (t / 806 s)^2 / 6
    assert asked == [(2,), (2,)]


# ---- symmetries


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1))
def test_other_axes_of_the_body_change_the_attitude_alone(seed):
    dtheta, dv, dt = manoeuvre_increments(200)
    C = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    turned = State(lat=0.9, lon=0.4, alt=300.0, v_eb_n=MANOEUVRE.v_eb_n, C_b_n=MANOEUVRE.C_b_n @ C.T)
    other = integrate_arrays(dtheta @ C.T, dv @ C.T, dt, turned)
    mine = integrate_arrays(dtheta, dv, dt, MANOEUVRE)
    # rounding of 200 steps in attitude, carried into velocity by 10 m/s^2 * 10 s
    assert_allclose(other.C_b_n @ C, mine.C_b_n, atol=1e-13)
    assert_allclose(other.v_eb_n, mine.v_eb_n, atol=1e-11)


@settings(max_examples=30)
@given(lat=st.floats(-1.5, 1.5), shift=st.floats(-3, 3))
def test_longitude_is_only_counted(lat, shift):
    dtheta, dv, dt = manoeuvre_increments(200)
    states = [State(lat=lat, lon=lon, C_b_n=np.eye(3), v_eb_n=(10.0, 20.0, 0.0)) for lon in (0.0, shift)]
    here, there = (integrate_arrays(dtheta, dv, dt, state) for state in states)
    np.testing.assert_array_equal(here.v_eb_n, there.v_eb_n)
    assert_allclose(there.lon - here.lon, shift, atol=1e-14)


@settings(max_examples=30)
@given(lat=st.floats(0.0, 1.5), seed=st.integers(0, 2**32 - 1))
def test_north_and_south_are_mirror_images(lat, seed):
    # reflected in the plane of the equator: polar vectors lose the sign of north, axial ones keep only that of north
    rng = np.random.default_rng(seed)
    polar = np.array([1.0, -1.0, 1.0])
    C, v = Rotation.random(rng=rng).as_matrix(), rng.uniform(-100, 100, 3)
    dtheta, dv, dt = manoeuvre_increments(200)
    mirror = np.diag(polar)
    here = integrate_arrays(dtheta, dv, dt, State(lat=lat, C_b_n=C, v_eb_n=v))
    there = integrate_arrays(
        -dtheta * polar, dv * polar, dt, State(lat=-lat, C_b_n=mirror @ C @ mirror, v_eb_n=v * polar)
    )
    assert_allclose(there.v_eb_n, here.v_eb_n * polar, atol=1e-10)
    assert_allclose(there.lat, -here.lat, atol=1e-15)


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1), size=st.floats(1e-9, 3.0))
def test_attitude_stays_a_rotation(seed, size):
    rng = np.random.default_rng(seed)
    dtheta = size * rng.uniform(-1, 1, (1000, 3))
    run = integrate_arrays(dtheta, np.zeros((1000, 3)), 1.0, State(lat=0.3, C_b_n=np.eye(3)), gravity=0.0)
    # each step ends within rounding of unit length, whatever came before
    assert_allclose(np.linalg.norm(run.quaternion, axis=-1), 1.0, rtol=0, atol=8 * EPS)


def test_table_in_table_out():
    dtheta, dv, dt = manoeuvre_increments(200)
    trajectory = integrate(table(dtheta, dv, dt, first=50.0), MANOEUVRE)
    frame = trajectory.to_frame()
    assert frame.index.name == "time"
    assert_allclose(frame.index, 50.0 + dt * np.arange(201), rtol=1e-14)
    assert_allclose(frame[["lat", "lon", "alt"]], np.transpose([trajectory.lat, trajectory.lon, trajectory.alt]))
    assert_allclose(frame[["velocity_east", "velocity_north", "velocity_up"]], trajectory.v_eb_n)
    angles = np.transpose(heading_pitch_roll_from_dcm(trajectory.C_b_n))
    assert_allclose(frame[["heading", "pitch", "roll"]], angles, atol=1e-14)
    shuffled = table(dtheta, dv, dt, first=50.0)[list(IMU_COLUMNS)[::-1]]
    np.testing.assert_array_equal(integrate(shuffled, MANOEUVRE).v_eb_n, trajectory.v_eb_n)


# ---- bad input

REST = table(*at_rest(LAT, np.eye(3), 0.01, 200), 0.01)
START = State(lat=LAT, C_b_n=np.eye(3))


def with_value(value):
    bad = REST.copy()
    bad.iloc[17, 4] = value
    return bad


@pytest.mark.parametrize(
    ("increments", "words"),
    [
        (REST.drop(columns="accel_y"), ["without 'accel_y'"]),
        (with_value(np.nan), ["finite", "nan at index (17, 4)"]),
        (with_value(np.inf), ["finite", "inf"]),
        (REST.drop(index=REST.index[50]), ["equally spaced", "0.02 s at 0.49 s", "median is 0.01 s"]),
        (REST.iloc[::-1], ["ascending order"]),
        (REST.iloc[[0, 1, 1, 2]], ["ascending order"]),
        (REST.iloc[:1], ["at least 2"]),
        (REST.assign(gyro_z=np.full(200, 4.0)), ["at most pi", "got 4 rad"]),
    ],
)
def test_bad_tables_are_refused(increments, words):
    with pytest.raises(ValueError) as error:
        integrate(increments, START)
    assert all(word in str(error.value) for word in words), error.value


def test_jitter_of_the_stamps_is_not_a_gap():
    jittered = REST.set_axis(REST.index.to_numpy().round(4) + 2e-5 * np.sin(np.arange(200)), axis=0)
    assert_allclose(integrate(jittered, START).v_eb_n, 0, atol=1e-3)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"velocity_reset": 2.1}, ["`velocity_reset`", "0 to 2 s", "got 2.1 s"]),
        ({"velocity_reset": [-0.5, 1.0]}, ["`velocity_reset`", "got -0.5 s"]),
        ({"velocity_reset": np.ones((2, 1))}, ["leading axes"]),
        ({"corrections": "both"}, ["'none', 'previous', 'central'"]),
        ({"every": 0}, ["`every`"]),
        ({"gravity": np.zeros((7, 3))}, ["`gravity`", "(..., 200, 3)", "(7, 3)"]),
        ({"gravity": lambda lat, lon, alt: 0 * lat}, ["`gravity(lat, lon, alt)`"]),
    ],
)
def test_bad_options_are_refused(options, words):
    with pytest.raises(ValueError) as error:
        integrate(REST, START, **options)
    assert all(word in str(error.value) for word in words), error.value


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"lat": np.pi / 2}, ["`lat`", "at a pole"]),
        ({"lat": 55.0}, ["`lat`", "DEG"]),
        ({"C_b_n": 2 * np.eye(3)}, ["`C_b_n`", "orthonormal"]),
        ({"v_eb_n": (0, 0)}, ["`v_eb_n`", "(..., 3)"]),
        ({"lon": [0, 1], "alt": [0, 1, 2]}, ["leading axes", "'lon': (2,)"]),
    ],
)
def test_bad_starts_are_refused(fields, words):
    with pytest.raises(ValueError) as error:
        State(**{"lat": LAT, "C_b_n": np.eye(3)} | fields)
    assert all(word in str(error.value) for word in words), error.value


def test_shapes_must_fit():
    with pytest.raises(ValueError, match="shape of `dtheta_ib_b`"):
        integrate_arrays(np.zeros((5, 3)), np.zeros((6, 3)), 0.01, START)
    with pytest.raises(ValueError, match="`start` must broadcast"):
        integrate_arrays(np.zeros((5, 3)), np.zeros((5, 3)), 0.01, State(lat=[0.1, 0.2], C_b_n=np.eye(3)))
    with pytest.raises(TypeError, match="`start` must be a State"):
        integrate_arrays(np.zeros((5, 3)), np.zeros((5, 3)), 0.01, {"lat": 0.1})
    with pytest.raises(ValueError, match="only one run"):
        integrate_arrays(np.zeros((2, 5, 3)), np.full((2, 5, 3), 0.057), 0.01, START).to_frame()


@pytest.mark.parametrize("factor", [1 / 9.80665, 100.0])
def test_wrong_units_are_doubted(factor):
    with pytest.warns(UserWarning, match=r"feels .* m/s\^2 in the first second where gravity is 9.81"):
        integrate(REST * ([1] * 3 + [factor] * 3), START, position_fixed=True)


def test_no_doubt_where_there_is_no_ground():
    moving = State(lat=LAT, C_b_n=np.eye(3), v_eb_n=(0.0, 1.0, 0.0))
    integrate(REST * ([1] * 3 + [0.0] * 3), moving)  # free fall of what moves already


def test_leaving_the_earth_is_an_error_with_its_time():
    up = State(lat=LAT, alt=99_000.0, C_b_n=np.eye(3), v_eb_n=(0.0, 0.0, 1000.0))
    with pytest.raises(ValueError, match=r"100000 m of height.* run 0 leaves at (0.9|1)\d* s"):
        integrate(REST, up)
    north = State(lat=np.pi / 2 - 1.01e-3, C_b_n=np.eye(3), v_eb_n=(0.0, 7000.0, 0.0))
    with pytest.raises(ValueError, match="off the poles"):
        integrate(REST, north)


def test_a_gravity_that_cannot_be_followed_is_refused():
    rng = np.random.default_rng(0)
    with pytest.raises(ValueError, match="still changes by"):
        integrate(REST, START, gravity=lambda lat, lon, alt: rng.normal(0, 9, (*lat.shape, 3)))


def test_hours_are_navigated_in_memory_for_its_rows():
    dtheta, dv = at_rest(LAT, np.eye(3), 1.0, 2 * 3600)
    run = integrate_arrays(dtheta, dv, 1.0, START, every=3600, position_fixed=True)
    assert_allclose(run.time, [0.0, HOUR, 2 * HOUR])
    assert_allclose(run.v_eb_n, 0, atol=5e-9)  # what is left out at a step of 1 s: 2e-13 m/s^2, and its tilt
