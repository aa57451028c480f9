import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.optics import compensation, drift, measure, simulate
from fogkit.optics.compensation import AfterLoop, InsideLoop
from fogkit.optics.motion import AngularOscillation, Ramp
from fogkit.units import DEG

OSCILLATION = AngularOscillation(acceleration=5000 * DEG, frequency=60)
DEVICE_2 = {"depth": 7 * np.pi / 8, "half_periods": 32}


@pytest.mark.parametrize(
    "loop", [{}, {"gain": 0.4}, {"gain": 0.5, "second_gain": 0.05}, {"bias_order": "plus-minus"}, DEVICE_2]
)
@pytest.mark.parametrize(
    "remedy",
    [
        AfterLoop(),
        AfterLoop(acceleration="ahead"),
        AfterLoop(law="full"),
        InsideLoop(),
        InsideLoop(lag=2),
        InsideLoop(law="full"),
    ],
)
def test_every_remedy_takes_nearly_all_of_the_drift(make_gyro, loop, remedy):
    gyro = make_gyro(**loop)
    without = measure.simulated_drift(gyro, OSCILLATION, 1.0).drift
    left = measure.simulated_drift(gyro, OSCILLATION, 1.0, compensation=remedy).drift
    # an acceleration that is n regulation periods old is turned by 2 pi 60 Hz n dt_r, 0.12 rad for the slowest loop;
    # a second integrator makes the residual small but turns it by a right angle, so that this counts at first order
    # there: measured against the same loop without it
    scale = abs(drift.vibration_drift(make_gyro(**loop | {"second_gain": 0.0}), OSCILLATION.acceleration, 60.0))
    assert abs(left) < 0.04 * scale
    assert abs(left) < 0.2 * abs(without)


@pytest.mark.parametrize("acceleration", [50000 * DEG, -50000 * DEG])
def test_the_full_law_makes_the_loop_linear_at_extreme_accelerations(make_gyro, acceleration):
    gyro = make_gyro(**DEVICE_2)
    motion = Ramp(acceleration=acceleration)
    quadratic, full = (
        measure.nonlinear_error(gyro, motion, 0.03, compensation=remedy).rate[-1]
        for remedy in (InsideLoop(), InsideLoop(law="full"))
    )
    assert abs(full) < 0.001 * abs(quadratic)


@pytest.mark.parametrize("acceleration", [5_000, 50_000, 200_000])
def test_the_full_law_after_the_loop_leaves_the_same_share_at_every_amplitude(make_gyro, acceleration):
    # what is left is the error of the central difference, (2 pi 60 Hz dt_r)^2 / 6 of the acceleration at 60 Hz, 2e-4
    oscillation = AngularOscillation(acceleration=acceleration * DEG, frequency=60)
    gyro = make_gyro()
    left = measure.simulated_drift(gyro, oscillation, 1.0, compensation=AfterLoop(law="full")).drift
    assert abs(left) < 3e-4 * abs(measure.simulated_drift(gyro, oscillation, 1.0).drift)


def test_the_reading_after_the_loop_has_no_lag(make_gyro):
    record = simulate.run(make_gyro(gain=0.3), Ramp(acceleration=10), 0.05)
    corrected = compensation.after_loop(record, AfterLoop())
    assert abs(record.error[-1]) > 1e-3
    assert abs(corrected.error[-1]) < 1e-5 * abs(record.error[-1])  # sine of a residual of 4e-3 rad


@pytest.mark.parametrize(
    "loop",
    [
        {"gain": 0.3},
        {"gain": 1.0},
        {"gain": 0.4, "delay": 1},
        {"gain": 0.5, "second_gain": 0.2},
        {"bias_order": "plus-minus"},
    ],
)
@pytest.mark.parametrize(
    "remedy",
    [AfterLoop(), AfterLoop(acceleration="ahead"), InsideLoop(lag=0), InsideLoop(lag=1, depth=2.2), InsideLoop(lag=2)],
)
def test_bias_from_noise_is_the_one_predicted(make_gyro, loop, remedy):
    # noise so strong that the bias is far above the scatter of the mean, small enough for a linear response
    gyro = make_gyro(detector_noise=0.02, **loop)
    predicted = compensation.noise_bias(gyro, remedy)
    simulated, deviation = measure.simulated_noise_bias(gyro, remedy, np.random.default_rng(7), duration=0.8)
    # 4 sigma of 16 runs, and the third moment of the noise through the loop's own sine, its variance 1e-4
    assert abs(simulated - predicted) < 4 * deviation + 0.02 * abs(predicted)


@pytest.mark.parametrize("remedy", [InsideLoop(), InsideLoop(lag=1), InsideLoop(lag=1, law="full")])
def test_the_increment_is_the_whole_one_and_its_memory_is_its_own(make_gyro, remedy):
    # under constant acceleration every period asks for the same increment, whatever part of it the second integrator
    # or a delay holds: with the full law the reading is that of the linear loop
    for loop in ({"gain": 0.4, "delay": 2}, {"gain": 0.5, "second_gain": 0.1}):
        gyro = make_gyro(**loop)
        plain, left = (
            sum(
                measure.nonlinear_error(gyro, Ramp(acceleration=sign * 20000 * DEG), 0.05, compensation=used).rate[-1]
                for sign in (1, -1)
            )
            for used in (None, remedy)
        )
        # in the sum over both directions the quadratic law leaves the fourth degree, the residual squared: 0.01
        assert abs(left) < 0.05 * abs(plain) + 1e-12


def test_alternating_records_are_corrected_with_the_sign_of_their_row(make_gyro):
    gyro = make_gyro(bias_order="alternating")
    record = simulate.run(gyro, Ramp(acceleration=20000 * DEG), 0.03, degree=2)
    corrected = compensation.after_loop(record, AfterLoop())
    # the reading of each period is off to its own side without the remedy
    before = np.abs(np.diff((record.rate + record.residual - record.true_rate)[-20:])).max()
    assert np.abs(np.diff(corrected.error[-20:])).max() < 0.05 * before


def test_a_remedy_with_nothing_to_act_on_warns(make_gyro):
    gyro = make_gyro(bias_order="mirrored")
    with pytest.warns(UserWarning, match="takes nothing out"):
        simulate.run(gyro, np.zeros(64), compensation=InsideLoop())


def test_noise_bias_in_the_cases_that_can_be_done_by_hand(make_gyro):
    gyro = make_gyro(detector_noise=1e-3)
    unit = -1 / np.tan(gyro.loop.depth) / 32 * gyro.residual_noise**2 / gyro.coil.sagnac_scale_factor
    expected = {
        InsideLoop(lag=0): 2,
        InsideLoop(lag=1): -1,
        InsideLoop(lag=2): 0,
        AfterLoop(): 0.5,
        AfterLoop(acceleration="ahead"): 0,
    }
    for remedy, factor in expected.items():
        assert_allclose(compensation.noise_bias(gyro, remedy), factor * unit, atol=1e-12 * abs(unit))


@pytest.mark.parametrize("depth_error", [-0.02, 0.02])
def test_a_wrong_depth_leaves_its_share_of_the_cotangent(make_gyro, depth_error):
    gyro = make_gyro()
    believed = gyro.loop.depth * (1 + depth_error)
    without = measure.simulated_drift(gyro, OSCILLATION, 1.0).drift
    left = measure.simulated_drift(gyro, OSCILLATION, 1.0, compensation=AfterLoop(depth=believed)).drift
    inside = measure.simulated_drift(gyro, OSCILLATION, 1.0, compensation=InsideLoop(depth=believed)).drift
    share = 1 - np.tan(gyro.loop.depth) / np.tan(believed)
    assert_allclose(
        [left / without, inside / without], share, rtol=0.05
    )  # third-degree remainder of the correction itself


@pytest.mark.parametrize(
    ("name", "make"),
    [
        ("law", lambda: InsideLoop(law="cubic")),
        ("lag", lambda: InsideLoop(lag=-1)),
        ("depth", lambda: InsideLoop(depth=4.0)),
        ("law", lambda: AfterLoop(law="cubic")),
        ("acceleration", lambda: AfterLoop(acceleration="behind")),
        ("depth", lambda: AfterLoop(depth=0.0)),
    ],
)
def test_impossible_remedies_are_refused(name, make):
    with pytest.raises(ValueError, match=f"`{name}`"):
        make()


def test_too_short_a_record_is_refused(make_gyro):
    with pytest.raises(ValueError, match=r"`record`.*at least 4"):
        compensation.after_loop(simulate.run(make_gyro(), np.zeros(48)), AfterLoop())
