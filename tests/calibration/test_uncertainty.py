"""Noise of the slopes: closed forms of short steps, plain sums of drawn increments, and the navigation itself."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from fogkit.calibration import uncertainty, velocity_noise
from fogkit.calibration.navigation_based import turn_model
from fogkit.calibration.uncertainty import plan_covariance, predict, slope_covariance, stated_and_true
from fogkit.calibration.velocity_noise import SensorNoise, Steps
from fogkit.constants import STANDARD_GRAVITY
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors
from fogkit.navigation.strapdown import State, integrate_arrays
from fogkit.noise import RandomErrors, simulate
from fogkit.rotation import dcm_from_rotvec
from fogkit.stand.turn_tests import TurnTest, nine_tests
from fogkit.units import DEG

SHORT = dict(dwell=4.0, turn_duration=3.0, dwell_after=5.0)
TEST = TurnTest(label="oblique", C_b_n=dcm_from_rotvec([0.3, -0.8, 0.5]), axis=[0.6, 0, 0.8], angle=500 * DEG, **SHORT)
STEP = 0.05
MIXED = SensorNoise(  # each sensor with another level and process, so that an exchange of axes shows
    gyros=(
        RandomErrors(angle_random_walk=2e-6, quantization=1e-6),
        RandomErrors(angle_random_walk=1e-6, rate_random_walk=2e-6),
        RandomErrors(bias_instability=3e-6, quantization=2e-6),
    ),
    accelerometers=(
        RandomErrors(angle_random_walk=3e-5),
        RandomErrors(quantization=2e-5, bias_instability=2e-5),
        RandomErrors(angle_random_walk=1e-5, rate_random_walk=2e-5),
    ),
)
LEVEL_DIFFERENCE = np.array([[-1, 0, 0, 1, 0, 0], [0, -1, 0, 0, 1, 0]])


def gyro(**errors):
    return SensorNoise(gyros=RandomErrors(**errors))


def accelerometer(**errors):
    return SensorNoise(accelerometers=RandomErrors(**errors))


@cache
def continuous(process):
    """Variances of both slopes of a level axis and their covariance, for steps without length, from the integrals.

    For unit gravity, coefficient 1; by sympy, from the weight 12 (t - T/2)/T^3 of the velocity in the slope.
    """
    t, s, T, U, W = sympy.symbols("t s T U W", positive=True)

    def influence(length):  # of the velocity gained at s in the dwell, and of an angle there
        velocity = sympy.integrate(12 * (t - length / 2) / length**3, (t, s, length))
        return velocity, sympy.integrate(velocity.subs(s, t), (t, s, length))

    def whole(first, turn, last):  # influence on one slope in first dwell, turn, last dwell, by own time s
        return [(first, T), (turn, U), (last, W)]

    zero = sympy.Integer(0)
    (v1, a1), (v2, a2) = influence(T), influence(W)
    slopes = {
        "velocity": (whole(v1, zero, zero), whole(zero, zero, v2)),
        "angle": (whole(a1, zero, zero), whole(zero + 1, zero + 1, a2)),
    }
    kind, walk = {"velocity": ("velocity", 0), "angle": ("angle", 0), "rate": ("angle", 1)}[process]
    pieces = slopes[kind]
    if walk:  # a change of the rate counts with the integral of what follows
        pieces = [
            [
                (sympy.integrate(f.subs(s, t), (t, s, L)) + sum(sympy.integrate(h, (s, 0, M)) for h, M in rest), L)
                for f, L, rest in ((f, L, slope[i + 1 :]) for i, (f, L) in enumerate(slope))
            ]
            for slope in pieces
        ]
    products = [
        sum(sympy.integrate(sympy.expand(f * h), (s, 0, L)) for (f, L), (h, _) in zip(one, two, strict=True))
        for one, two in ((pieces[0], pieces[0]), (pieces[0], pieces[1]), (pieces[1], pieces[1]))
    ]
    return sympy.lambdify((T, U, W), products)


@pytest.mark.parametrize(
    ("process", "noise", "size"),
    [
        ("velocity", accelerometer(angle_random_walk=1e-4), 1e-4),
        ("angle", gyro(angle_random_walk=1e-6), 1e-6 * STANDARD_GRAVITY),
        ("rate", gyro(rate_random_walk=1e-8), 1e-8 * STANDARD_GRAVITY),
    ],
)
def test_short_steps_have_the_closed_form(process, noise, size):
    # a turn about east keeps the gyro of the east, and so its rate random walk, on one axis
    test = TurnTest.from_letters("ENU", "x", 450 * DEG, **SHORT)
    expected = size**2 * np.array(continuous(process)(4.0, 3.0, 5.0))
    for dt in (0.05, 0.0125):
        covariance = slope_covariance(test, dt, noise)
        found = covariance[[1, 1, 4], [1, 4, 4]]
        assert_allclose(found, expected, rtol=dt, atol=1e-6 * expected[2])  # T**3, a dwell T = 4 s being a step short


def test_the_formula_of_the_docstring():
    test = TurnTest.from_letters("ENU", "x", 450 * DEG, dwell=10.0, turn_duration=15.0)
    N, M, s, dt, T, U = 1e-6, 1e-4, 1e-3, 0.005, 10.0, 15.0
    noise = SensorNoise(
        gyros=RandomErrors(angle_random_walk=N),
        accelerometers=RandomErrors(angle_random_walk=M, quantization=s),
    )
    expected = (STANDARD_GRAVITY * N) ** 2 * (26 / 35 * T + U) + 12 / 5 * M**2 / T + 24 * s**2 * dt / T**3
    found = LEVEL_DIFFERENCE @ slope_covariance(test, dt, noise) @ LEVEL_DIFFERENCE.T
    assert_allclose(found, expected * np.eye(2), rtol=2e-3, atol=1e-12 * expected)  # a dwell has 2001 samples


def drawn_increments(noise, steps, runs, rng):
    """Errors of the increments of all sensors, shape (runs, count, 3) for gyros and for accelerometers."""
    return tuple(
        np.stack([simulate(one, steps.count, steps.dt, rng, channels=runs).T * steps.dt for one in sensors], axis=-1)
        for sensors in (noise.gyros, noise.accelerometers)
    )


def fitted_slopes(velocity, steps, degree):
    """Slopes by `numpy.polyfit` of both dwells, shape (runs, 6), those of a parabola in the middle of the turn.

    Velocity has shape (runs, rows, 3) and begins anew at the reset; the rows where it is zero by force are left out.
    """
    found = []
    middle = (steps.turn_begin + steps.turn_end) / 2
    for part in (slice(1, steps.turn_begin + 1), slice(steps.turn_end + 1, None)):
        time = (np.arange(velocity.shape[1])[part] - middle) * steps.dt
        values = np.moveaxis(velocity[:, part], 1, 0)
        found.append(np.polyfit(time, values.reshape(time.size, -1), degree)[-2].reshape(-1, 3))
    return np.concatenate(found, axis=-1)


def assert_covariance_of(samples, expected):
    """Mean squares and products of runs agree with a covariance, within 5 deviations of each."""
    runs = len(samples)
    scale = np.sqrt(np.diagonal(expected))
    found = samples.T @ samples / runs / np.outer(scale, scale)
    expected = expected / np.outer(scale, scale)
    assert (np.abs(found - expected) < 5 * np.sqrt((1 + expected**2) / runs)).all()


@pytest.mark.parametrize("degree", [1, 2])
def test_plain_sums_of_drawn_increments(degree):
    steps = Steps.of(TEST, STEP)
    rng = np.random.default_rng(20)
    runs = 4000
    gyros, accelerometers = drawn_increments(MIXED, steps, runs, rng)
    angle = np.cumsum(np.einsum("kij,rkj->rki", steps.C_b_n, gyros), axis=1)
    middle = angle - np.einsum("kij,rkj->rki", steps.C_b_n, gyros) / 2
    gained = np.einsum("kij,rkj->rki", steps.C_b_n, accelerometers)
    gained += STANDARD_GRAVITY * STEP * np.cross(middle, [0, 0, 1])
    velocity = np.concatenate([np.zeros((runs, 1, 3)), np.cumsum(gained, axis=1)], axis=1)
    velocity[:, steps.turn_end + 1 :] -= velocity[:, steps.turn_end, None]
    samples = fitted_slopes(velocity, steps, degree)
    assert_covariance_of(samples, slope_covariance(TEST, STEP, MIXED, degree=degree))


def test_few_steps_exactly_by_the_answer_to_each_increment():
    # white errors: the covariance is that of the answers to unit errors, one sensor and step at a time
    test = replace(TEST, dwell=5.0, turn_duration=3.0, dwell_after=6.0)
    steps = Steps.of(test, 1.0)
    noise = SensorNoise(
        gyros=[RandomErrors(angle_random_walk=n * 1e-6) for n in (1, 2, 3)],
        accelerometers=[RandomErrors(angle_random_walk=n * 1e-6) for n in (30, 10, 20)],
    )
    unit = np.einsum("kij,rkj->rki", steps.C_b_n, np.eye(steps.count * 3).reshape(-1, steps.count, 3))
    tilt = np.cumsum(unit, axis=1) - unit / 2
    expected = np.zeros((6, 6))
    for gained, sensors in ((STANDARD_GRAVITY * np.cross(tilt, [0, 0, 1]), noise.gyros), (unit, noise.accelerometers)):
        velocity = np.concatenate([np.zeros((len(unit), 1, 3)), np.cumsum(gained, axis=1)], axis=1)
        answers = fitted_slopes(velocity, steps, 1).reshape(steps.count, 3, 6)
        squares = [one.angle_random_walk**2 for one in sensors]
        expected += np.einsum("kam,kan,a->mn", answers, answers, squares)
    assert_allclose(slope_covariance(test, 1.0, noise), expected, rtol=1e-9, atol=1e-12 * expected.max())


def test_vertical_slopes_stand_behind_all_level_ones():
    plan = nine_tests(**SHORT)[:2]
    whole = plan_covariance(plan, STEP, MIXED, scale_factors=True)
    assert_allclose(whole[:4, :4], plan_covariance(plan, STEP, MIXED))
    for n, test in enumerate(plan):
        up = slope_covariance(test, STEP, MIXED)[np.ix_([2, 5], [2, 5])]
        assert_allclose(whole[4 + 2 * n : 6 + 2 * n, 4 + 2 * n : 6 + 2 * n], up)


def test_velocity_carried_through_the_turn():
    steps = Steps.of(TEST, STEP)
    runs = 4000
    gyros, accelerometers = drawn_increments(MIXED, steps, runs, np.random.default_rng(24))
    turned = np.einsum("kij,rkj->rki", steps.C_b_n, gyros)
    gained = np.einsum("kij,rkj->rki", steps.C_b_n, accelerometers)
    gained += STANDARD_GRAVITY * STEP * np.cross(np.cumsum(turned, axis=1) - turned / 2, [0, 0, 1])
    velocity = np.concatenate([np.zeros((runs, 1, 3)), np.cumsum(gained, axis=1)], axis=1)
    weights = np.zeros((2, steps.count + 1))
    weights[0, -1], weights[1, steps.turn_begin] = 1, 1  # at the end, and where the turn begins
    samples = velocity[:, [steps.count, steps.turn_begin]].reshape(runs, -1)
    assert_covariance_of(samples, velocity_noise.covariance(weights, steps, MIXED, STANDARD_GRAVITY))


@pytest.mark.parametrize("degree", [1, 2])
def test_navigation_of_drawn_increments(degree):
    steps = Steps.of(TEST, STEP)
    turning = np.arange(steps.count)
    turning = (turning >= steps.turn_begin) & (turning < steps.turn_end)
    angle = np.outer(turning, TEST.axis * TEST.angle / turning.sum())
    velocity = steps.C_b_n[:, 2] * STANDARD_GRAVITY * STEP  # rough in the turn, the same in all runs
    runs = 2000
    noise = drawn_increments(MIXED, steps, runs, np.random.default_rng(21))
    increments = [
        np.concatenate([true[None], true + error]) for true, error in zip((angle, velocity), noise, strict=True)
    ]
    navigated = integrate_arrays(
        *increments,
        STEP,
        State(lat=55 * DEG, C_b_n=TEST.C_b_n),
        gravity=STANDARD_GRAVITY,
        position_fixed=True,
        velocity_reset=[7.0],
    ).v_eb_n
    samples = fitted_slopes(navigated[1:] - navigated[0], steps, degree)
    assert_covariance_of(samples, slope_covariance(TEST, STEP, MIXED, degree=degree))


def test_attitudes_that_were_navigated_take_the_place_of_the_command():
    steps = Steps.of(TEST, STEP)
    assert_allclose(slope_covariance(TEST, STEP, MIXED, C_b_n=steps.C_b_n), slope_covariance(TEST, STEP, MIXED))
    turned = dcm_from_rotvec([0, 0, np.pi / 2]) @ steps.C_b_n  # east becomes north, north becomes west
    found = slope_covariance(TEST, STEP, MIXED, C_b_n=turned)
    expected = slope_covariance(TEST, STEP, MIXED)
    assert_allclose(found[np.ix_([1, 4], [1, 4])], expected[np.ix_([0, 3], [0, 3])], rtol=1e-9)


def test_equal_sensors_make_no_difference_between_directions():
    noise = SensorNoise(gyros=RandomErrors(angle_random_walk=1e-6), accelerometers=RandomErrors(angle_random_walk=1e-5))
    plan = nine_tests(**SHORT)
    covariance = plan_covariance(plan, STEP, noise)
    assert_allclose(covariance, covariance[0, 0] * np.eye(18), atol=1e-12 * covariance[0, 0])


@pytest.mark.parametrize("degree", [1, 2])
def test_slope_weights_are_those_of_polyfit(degree):
    time = 0.1 * np.arange(17)
    values = np.sin(time) + time**3
    weights = uncertainty.slope_weights(17, 0.1, degree, at=1.2)
    expected = np.polyval(np.polyder(np.polyfit(time, values, degree)), 1.2)
    assert_allclose(weights @ values, expected, rtol=1e-10)


def test_prediction_is_formula_27_for_white_velocity():
    plan = nine_tests(**SHORT)
    noise = accelerometer(quantization=1e-4)
    predicted = predict(plan, noise, dt=STEP)
    H = np.concatenate([turn_model.measurement_rows(t.C_b_n, t.axis, t.angle, STANDARD_GRAVITY) for t in plan])
    samples = [np.arange(STEP, T + STEP / 2, STEP) for T in (4.0, 5.0)]
    variance = sum(1e-8 / np.sum((tau - tau.mean()) ** 2) for tau in samples)  # (23), (24)
    assert_allclose(predicted.covariance, variance * np.linalg.inv(H.T @ H), rtol=1e-7, atol=1e-25)
    assert predicted.degrees_of_freedom == 3


def test_stated_is_true_for_white_velocity_only():
    plan = nine_tests(**SHORT)
    white = stated_and_true(plan, accelerometer(quantization=1e-4), dt=STEP)
    assert_allclose(white.residual_deviation, 1e-4, rtol=2e-3)  # quadrature over 60 of 80 samples
    assert_allclose(white.true / white.stated, 1, rtol=2e-3)
    assert_allclose(white.true, white.best, rtol=1e-3)
    walking = stated_and_true(plan, gyro(angle_random_walk=1e-6), dt=STEP)
    assert (walking.true / walking.stated > 10).all()


def test_residuals_of_a_random_walk_against_drawn_ones():
    steps = Steps.of(TEST, STEP)
    noise = SensorNoise(gyros=RandomErrors(angle_random_walk=1e-5), accelerometers=RandomErrors(angle_random_walk=1e-5))
    rng = np.random.default_rng(22)
    runs, n = 2000, steps.turn_begin
    tilt = 1e-5 * np.sqrt(STEP) * rng.standard_normal((n, runs))
    gained = STANDARD_GRAVITY * STEP * (np.cumsum(tilt, axis=0) - tilt / 2)
    gained += 1e-5 * np.sqrt(STEP) * rng.standard_normal((n, runs))
    left = np.polyfit(np.arange(n), np.cumsum(gained, axis=0), 1, full=True)[1]
    drawn = np.sqrt(left.mean() / (n - 2))
    found = uncertainty._residual_deviation(steps, noise, STANDARD_GRAVITY)[0]
    assert_allclose(found, drawn, rtol=0.05)  # 5 deviations of 2000 runs with some two degrees of freedom each


def test_scale_factors_from_two_upright_positions():
    # (26) with white slopes: half the sum over g, and nothing else says them in the nine tests
    noise = accelerometer(angle_random_walk=1e-5)
    plan = nine_tests(**SHORT)
    predicted = predict(plan, noise, dt=STEP, scale_factors=True)
    slopes = slope_covariance(plan[1], STEP, noise)
    paper = np.sqrt(slopes[2, 2] + slopes[5, 5]) / (2 * STANDARD_GRAVITY)
    found = predicted.standard_deviation[15:]
    assert (found < paper).all()  # other tests also stand upright
    assert predicted.rank == 18
    fewer = predict(plan, noise, dt=STEP)
    assert (predicted.standard_deviation[:15] <= fewer.standard_deviation * (1 + 1e-9)).all()


def test_design_against_differences_of_the_exact_slopes():
    rows = uncertainty.design(TEST, scale_factors=True)
    full = turn_model.differentiated_rows(TEST.C_b_n, TEST.axis, TEST.angle, STANDARD_GRAVITY)
    own = [turn_model.FULL_PARAMETERS.index(name) for name in uncertainty.SCALE_FACTORS]
    kept = [turn_model.FULL_PARAMETERS.index(name) for name in turn_model.PARAMETERS]
    assert_allclose(rows[:2], full[:, kept + own], atol=1e-6 * np.abs(full).max())  # as documented there
    errors = np.random.default_rng(23).normal(size=18)
    m = np.diag(errors[15:])
    for i, j in enumerate(turn_model.MISALIGNED_WITH):
        m[i, j] = errors[i]
    for row, C in zip(rows[2:], (TEST.C_b_n, TEST.C_b_n_end), strict=True):
        read = m @ C.T @ [0, 0, STANDARD_GRAVITY] + errors[12:15]
        assert_allclose(row @ errors, (C @ read)[2], rtol=1e-12)


def test_noise_of_a_simulated_unit():
    triad = LinearTriad(matrix=np.diag([2.0, -4.0, 1.0]))
    sensors = Sensors(triad=triad, random=RandomErrors(angle_random_walk=1e-6), pulse=1e-5)
    noise = SensorNoise.of_unit(MeasurementUnit(gyros=sensors))
    assert_allclose([one.quantization for one in noise.gyros], 1e-5 / np.sqrt(12) / np.array([2, 4, 1]))
    assert noise.accelerometers == (RandomErrors(),) * 3


def test_no_noise_has_no_weight():
    with pytest.raises(ValueError, match="`noise` must reach every measurement"):
        predict(nine_tests(**SHORT), SensorNoise(), dt=STEP)
    with pytest.raises(ValueError, match="`plan` must hold"):
        predict((), gyro(angle_random_walk=1e-6))
    with pytest.raises(ValueError, match="the plan does not determine"):
        stated_and_true(nine_tests(**SHORT)[:3], gyro(angle_random_walk=1e-6), dt=STEP)


def test_bad_input():
    with pytest.raises(ValueError, match="no `rate_ramp`"):
        gyro(rate_ramp=1e-9)
    with pytest.raises(ValueError, match="or three, got 2"):
        SensorNoise(gyros=(RandomErrors(),) * 2)
    with pytest.raises(ValueError, match="`dt` must divide"):
        slope_covariance(TEST, 0.03, MIXED)
    with pytest.raises(ValueError, match="`degree` must be 1 or 2"):
        uncertainty.slope_weights(10, 0.1, 3)
    with pytest.raises(ValueError, match="`C_b_n`"):
        slope_covariance(TEST, STEP, MIXED, C_b_n=np.eye(3)[None])
