"""Motion in a turn against closed forms, against a numerical integration of its own equations, and navigated back."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import quad_vec, solve_ivp
from scipy.spatial.transform import Rotation

from fogkit.constants import EARTH_RATE
from fogkit.earth import normal_gravity
from fogkit.navigation import State, integrate_arrays
from fogkit.stand.turn_motion import Absorber, Harmonic, TurnMotion
from fogkit.stand.turn_tests import TurnTest
from fogkit.units import DEG

LATITUDE = 53.9 * DEG
EARTH = EARTH_RATE * np.array([0, np.cos(LATITUDE), np.sin(LATITUDE)])
GRAVITY = float(normal_gravity(LATITUDE))
TEST = TurnTest(label="t", C_b_n=np.eye(3), axis=[1, 0, 0], angle=10.0, dwell=2.0, turn_duration=6.0, dwell_after=3.0)
SAG = np.array([[2, -8, 3], [8, -1, -4], [-3, 4, 2]]) * 1e-3
ROUGH = {
    "C_case_n": Rotation.from_rotvec([0.3, -0.2, 1.0]).as_matrix(),
    "axis": [1.0, 0.1, -0.2],
    "wobble": (
        Harmonic(order=1, amplitude=(1e-3, 2e-3, 3e-3), phase=(1, 2, 3)),
        Harmonic(order=3, amplitude=(2e-3, 1e-3, -1e-3), phase=(-1, 0.5, 4)),
    ),
    "absorber": Absorber(sag=SAG, frequency=8.0, damping=0.05, coupling=np.eye(3) + 0.2),
    "offset": (0.1, -0.2, 0.15),
    "ramp": 0.3,
}


def motion(**changes):
    simple = {"test": TEST, "C_case_n": np.eye(3), "axis": [1, 0, 0], "angle": 10.0}
    return TurnMotion(**simple | {"omega_ie_n": EARTH, "gravity": GRAVITY} | changes)


@pytest.fixture(scope="module")
def rough():
    return motion(**ROUGH)


def by_hand(seen, time):
    """Attitude from the documentation's [1], with SciPy's rotations, from angle and lag."""
    C, phi = seen.C_case_n, seen.turned(time)
    along = np.array(ROUGH["axis"]) / np.linalg.norm(ROUGH["axis"])
    level = np.cross([0, 0, 1], C @ along)
    level = C.T @ level / np.linalg.norm(level)
    axes = [level, np.cross(along, level), along]
    parts = [
        a * np.cos(h.order * phi[:, None] + p) * axis
        for h in ROUGH["wobble"]
        for a, p, axis in zip(h.amplitude, h.phase, axes, strict=True)
    ]
    case = Rotation.from_matrix(C) * Rotation.from_rotvec(sum(parts)) * Rotation.from_rotvec(phi[:, None] * along)
    up = case.inv().apply([0, 0, 1])
    turn = up @ SAG.T * GRAVITY / 9.80665 + seen.lag(time)[:, None] * ((np.eye(3) + 0.2) @ along)
    return case, case * Rotation.from_rotvec(turn)


def test_attitude_is_the_composition_that_is_documented(rough):
    time = np.linspace(-1, 12, 400)
    case, body = by_hand(rough, time)
    # rounding of an angle of 10 rad, and of five rotations
    assert_allclose(rough.C_b_n(time), body.as_matrix(), atol=2e-14)
    assert_allclose(rough.position(time), case.apply(ROUGH["offset"]), atol=1e-14)


def test_the_lag_is_that_of_an_oscillator_that_is_integrated(rough):
    natural = 2 * np.pi * 8.0

    def slope(t, y):
        rising, falling = (t - 2) / 0.3, (8 - t) / 0.3  # derivative of the smooth step is 30 x^2 (1 - x)^2
        x = rising if 0 < rising < 1 else falling if 0 < falling < 1 else 0.0
        acceleration = 10 / 5.7 / 0.3 * 30 * x**2 * (1 - x) ** 2 * (1 if t < 5 else -1)
        return [y[1], -2 * 0.05 * natural * y[1] - natural**2 * y[0] - acceleration]

    time = np.linspace(2, 9, 300)
    solved = solve_ivp(slope, (2, 9), [0, 0], "DOP853", time, rtol=1e-10, atol=1e-14, max_step=0.02)
    assert_allclose(rough.lag(time), solved.y[0], atol=1e-10)  # tolerance of the lag, 5e-3, in some hundred steps
    assert np.abs(rough.lag(time)).max() > 1e-3


def test_ringing_has_its_frequency_and_decay(rough):
    h = 0.01
    lag = rough.lag(8 + h * np.arange(100))
    # a decaying oscillation obeys x[n+1] = 2 q cos(w h) x[n] - q^2 x[n-1] with q = exp(-d h)
    first, second = np.linalg.lstsq(np.stack([lag[1:-1], lag[:-2]], axis=-1), lag[2:])[0]
    natural = 2 * np.pi * 8.0
    assert_allclose(np.log(-second) / 2, -0.05 * natural * h, rtol=1e-9)  # rounding over what has faded
    assert_allclose(np.arccos(first / 2 / np.sqrt(-second)), natural * np.sqrt(1 - 0.05**2) * h, rtol=1e-9)


def test_angle_is_reached_and_the_rate_is_smooth():
    seen = motion(angle=33.0)
    assert_allclose(seen.turned([0, 2.0, 5.0, 8.0, 11]), [0, 0, 16.5, 33.0, 33.0], rtol=1e-15)
    # acceleration has no jump: second differences of the angle over h are continuous to the jerk, 150 rad/s^3, times h
    h = 1e-3
    rate = np.diff(seen.turned(np.arange(1.9, 8.1, h))) / h
    assert_allclose(rate.max(), 33.0 / (6.0 - 0.5), rtol=1e-11)
    assert np.abs(np.diff(rate, n=2)).max() / h < 150 * h


def test_at_rest_the_earth_turns_and_gravity_is_felt():
    C = Rotation.from_rotvec([0.3, -0.2, 1.0]).as_matrix()
    seen = motion(C_case_n=C, offset=(0.1, 0.2, 0.3))
    for time in (-5.0, 0.0, 2.0):
        assert_allclose(seen.omega_ib_b(time), C.T @ EARTH, atol=1e-19)
        assert_allclose(seen.f_ib_b(time), C.T @ [0, 0, GRAVITY], atol=1e-14)
        assert (seen.velocity(time) == 0).all()


def test_steady_turn_by_hand():
    seen = motion(offset=(0.4, 0.3, 0.0))
    rate, time = 10.0 / 5.5, np.array([2.6, 4.0, 7.0])
    phi = seen.turned(time)
    omega = np.stack([np.full(3, rate), *(Rotation.from_rotvec([[-p, 0, 0] for p in phi]).apply(EARTH).T[1:])], axis=-1)
    assert_allclose(seen.omega_ib_b(time), omega, atol=1e-14)
    assert_allclose(np.linalg.norm(seen.velocity(time), axis=-1), 0.3 * rate, rtol=1e-14)
    # inwards 0.3 w^2; Coriolis 2 W x v is 0.3 * 2 w * W, 8e-5 m/s^2 at most; gravity turns
    force = np.stack([0 * phi, GRAVITY * np.sin(phi) - 0.3 * rate**2, GRAVITY * np.cos(phi)], axis=-1)
    assert_allclose(seen.f_ib_b(time), force, atol=1.1 * 0.3 * 2 * rate * EARTH_RATE)
    v = seen.velocity(time)
    coriolis = np.einsum("nji,nj->ni", seen.C_b_n(time), 2 * np.cross(EARTH, v))
    assert_allclose(seen.f_ib_b(time), force + coriolis, atol=1e-13)


def test_wobble_comes_back_with_every_turn():
    seen = motion(wobble=ROUGH["wobble"])
    time = np.linspace(2.6, 3.6, 7)
    period = 2 * np.pi / seen.rate
    assert_allclose(seen.C_b_n(time + period), seen.C_b_n(time), atol=1e-14)
    assert np.abs(seen.C_b_n(time + period / 2) @ np.diag([1, -1, -1]) - seen.C_b_n(time)).max() > 1e-3


def slope_of_state(seen):
    """Derivative of attitude and velocity by the rate and the specific force that the motion gives."""

    def slope(t, y):
        C, v = y[:9].reshape(3, 3), y[9:]
        w, f = seen.omega_ib_b(t), seen.f_ib_b(t)
        turn = C @ np.cross(w, np.eye(3), axisb=0, axisc=0) - np.cross(EARTH, C, axisb=0, axisc=0)
        return np.concatenate([turn.ravel(), C @ f - 2 * np.cross(EARTH, v) - [0, 0, GRAVITY]])

    return slope


def test_rate_and_specific_force_integrate_to_attitude_and_velocity(rough):
    start = np.concatenate([rough.C_b_n(1.9).ravel(), np.zeros(3)])
    ends = np.array([2.2, 4.0, 7.9, 8.3])
    solved = solve_ivp(slope_of_state(rough), (1.9, 8.3), start, "DOP853", ends, rtol=1e-11, atol=1e-12, max_step=0.03)
    # the tolerances of some hundred steps; velocity grows by g times the attitude's error
    assert_allclose(solved.y[:9].T.reshape(-1, 3, 3), rough.C_b_n(ends), atol=1e-9)
    assert_allclose(solved.y[9:].T, rough.velocity(ends), atol=1e-8)


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_attitude_and_rate_fit_for_any_motion(seed):
    rng = np.random.default_rng(seed)
    wobble = [
        Harmonic(order=int(rng.integers(1, 6)), amplitude=rng.uniform(-0.1, 0.1, 3), phase=rng.uniform(-3, 3, 3))
        for _ in range(rng.integers(0, 3))
    ]
    absorber = Absorber(sag=rng.uniform(-0.01, 0.01, (3, 3)), frequency=rng.uniform(5, 15), damping=rng.uniform(0, 0.9))
    seen = motion(
        C_case_n=Rotation.random(random_state=rng).as_matrix(),
        axis=rng.standard_normal(3),
        angle=rng.uniform(-20, 20),
        wobble=wobble,
        absorber=absorber if rng.random() < 0.7 else None,
        offset=rng.uniform(-0.3, 0.3, 3),
    )
    time, h = rng.uniform(1, 10, 8), 1e-5
    C = seen.C_b_n(time)
    assert_allclose(np.einsum("nij,nkj->nik", C, C), np.broadcast_to(np.eye(3), C.shape), atol=1e-14)
    before, after = seen.C_b_n(time - h), seen.C_b_n(time + h)
    rate = Rotation.from_matrix(np.einsum("nji,njk->nik", before, after)).as_rotvec() / (2 * h)
    earth = np.einsum("nji,j->ni", C, EARTH)
    # rounding 1e-14 / h, and the third derivative, at most 0.2 rad * (20 rad/s)^3 in the wobble, times h^2 / 6
    assert_allclose(seen.omega_ib_b(time), rate + earth, atol=3e-7)
    v = (seen.position(time + h) - seen.position(time - h)) / (2 * h)
    assert_allclose(seen.velocity(time), v, atol=3e-7)
    a = (seen.velocity(time + h) - seen.velocity(time - h)) / (2 * h)
    force = a + 2 * np.cross(EARTH, v) + [0, 0, GRAVITY]
    assert_allclose(np.einsum("nij,nj->ni", C, seen.f_ib_b(time)), force, atol=3e-6)


@pytest.mark.parametrize(("rate", "delay"), [(25.0, 0.0), (100.0, 0.00123), (2000.0, -0.3)])
def test_increments_against_adaptive_quadrature(rough, rate, delay):
    sums = rough.increments(rate, delay, products=True)
    assert sums.shape == (11 * rate, 15)

    def integrand(t):
        w, f = rough.omega_ib_b(t), rough.f_ib_b(t)
        return np.concatenate([w, f, w * w, [w[0] * w[1], w[0] * w[2], w[1] * w[2]]])

    cuts = [2.0, 2.3, 7.7, 8.0]
    for time in (0.5, 1.999, 2.1, 2.299, 5.0, 7.7, 7.85, 7.999, 8.05, 10.5):
        step = int(np.floor(time * rate))
        start, stop = step / rate - delay, (step + 1) / rate - delay
        inside = [cut for cut in cuts if start < cut < stop]
        whole, _ = quad_vec(integrand, start, stop, epsabs=1e-15, epsrel=1e-13, points=inside)
        change = rough.omega_ib_b(stop) - rough.omega_ib_b(start)
        # rounding of the times, 11 s * 1e-16, times the rate, 5 rad/s with the ringing, its square and gravity
        assert_allclose(sums[step, :3], whole[:3], atol=2e-14)
        assert_allclose(sums[step, 3:6], whole[3:6], atol=1e-13)
        assert_allclose(sums[step, 6:12], whole[6:], atol=1e-13)
        assert_allclose(sums[step, 12:], change, atol=2e-12)  # an acceleration of up to 100 rad/s^2


def test_a_step_of_any_length_holds_what_its_parts_hold(rough):
    coarse, fine = rough.increments(10.0, products=True), rough.increments(2000.0, products=True)
    # rounding of 200 sums and of the times of their ends
    assert_allclose(fine.reshape(-1, 200, 15).sum(axis=1), coarse, atol=1e-12)


def test_nothing_rings_for_ever_and_without_damping_it_does(rough):
    assert_allclose(rough.lag(30.0), 0, atol=1e-18)
    forever = motion(absorber=Absorber(damping=0.0), ramp=0.05)
    assert np.ptp(forever.increments(100.0)[-50:, 0]) > 1e-4
    quiet = motion(absorber=Absorber(damping=0.5), ramp=0.05).increments(100.0)
    assert np.ptp(quiet[-200:, 0]) == 0  # the same number is taken for all steps
    assert_allclose(quiet[-1, :3], quiet[-220, :3], atol=1e-17)  # and it is what was there before


def test_navigated_increments_return_to_the_truth_in_fourth_order():
    seen = motion(**ROUGH | {"offset": (0, 0, 0)})  # moved, east and north would turn by 0.3 m over the Earth's radius
    errors = []
    for rate in (100.0, 200.0, 400.0, 2000.0):
        sums = seen.increments(rate)
        start = State(lat=LATITUDE, C_b_n=seen.C_b_n(0.0))
        found = integrate_arrays(sums[:, :3], sums[:, 3:], 1 / rate, start, position_fixed=True)
        rows = slice(None, None, int(rate / 50))
        attitude = np.abs(found.C_b_n[rows] - seen.C_b_n(found.time[rows])).max()
        errors.append([attitude, np.abs(found.v_eb_n - seen.velocity(found.time)).max()])
    errors = np.array(errors)
    assert_allclose(errors[:-2] / errors[1:-1], 16, rtol=0.15)  # the next order is h^2 of the ringing's (50 h)^2
    # rounding: 22000 steps of 1e-16 in attitude, and gravity times that for 11 s
    assert errors[-1, 0] < 1e-11
    assert errors[-1, 1] < 3e-9


@pytest.mark.parametrize(
    ("make", "kind", "message"),
    [
        (lambda: motion(test="t"), TypeError, "`test`"),
        (lambda: motion(C_case_n=2 * np.eye(3)), ValueError, "`C_case_n`"),
        (lambda: motion(axis=(0, 0, 0)), ValueError, "`axis` must have a direction"),
        (lambda: motion(angle=np.inf), ValueError, "`angle`"),
        (lambda: motion(gravity=-9.8), ValueError, "`gravity`"),
        (lambda: motion(ramp=3.1), ValueError, "`ramp` must be at most half of the turn, 3 s in test 't'"),
        (lambda: motion(wobble=[0.1]), TypeError, "`wobble`"),
        (lambda: motion(wobble=[Harmonic(order=1, amplitude=(0.4, 0.4, 0))]), ValueError, "`wobble` must turn"),
        (lambda: motion(absorber=0.1), TypeError, "`absorber`"),
        (lambda: motion(absorber=Absorber(frequency=0.5)), ValueError, "`absorber` must turn"),
        (lambda: Absorber(damping=1.0), ValueError, "`damping`"),
        (lambda: Absorber(frequency=0), ValueError, "`frequency`"),
        (lambda: Absorber(sag=0.1), ValueError, "`sag`"),
        (lambda: Harmonic(order=0, amplitude=(0, 0, 0)), ValueError, "`order`"),
        (lambda: Harmonic(order=1, amplitude=0.1), ValueError, "`amplitude`"),
        (lambda: motion().increments(0.0), ValueError, "`rate`"),
        (lambda: motion().increments(3.3), ValueError, "`rate` must give a whole number of steps"),
        (lambda: motion().increments(10.0, np.nan), ValueError, "`delay`"),
        (lambda: motion().C_b_n(np.nan), ValueError, "`time`"),
    ],
)
def test_errors_name_the_argument(make, kind, message):
    with pytest.raises(kind, match=message):
        make()
