import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from loops import LOOPS
from numpy.testing import assert_allclose, assert_array_equal

from fogkit.optics import ClosedLoopGyro, Coil, Loop, simulate
from fogkit.optics.compensation import AfterLoop
from fogkit.optics.motion import AngularOscillation, Ramp

BALANCED_RATE = 0.4  # rad/s: about half a radian of Sagnac phase


def modulator_reading(gyro, rates):
    """Feedback of each regulation period from the voltages on the modulator and two interfering waves.

    Nothing is reduced by 2 pi and no phase step is computed: the modulator holds a wrapped ramp plus a bias staircase,
    its phase goes onto one wave now and onto the other a half-period later, and the light is the square of their sum.
    """
    loop = gyro.loop
    pattern = loop.bias_pattern.ravel()
    feedback, second, ramp, stairs, before = 0.0, 0.0, 0.0, 0.0, 0.0
    waiting, demodulated, readings = [0.0] * loop.delay, 0.0, []
    for n, rate in enumerate(rates):
        if n % loop.half_periods == 0:
            readings.append(feedback / gyro.coil.sagnac_scale_factor)
        bias = pattern[n % pattern.size]
        ramp = (ramp + feedback) % (2 * np.pi)
        stairs += bias * loop.depth
        modulator = (1 + loop.v_pi_error) * (stairs - ramp)
        wave = np.exp(1j * (gyro.coil.phase(rate) + modulator)) + np.exp(1j * before)
        before = modulator
        demodulated -= bias * np.abs(wave / 2) ** 2
        if (n + 1) % loop.half_periods == 0:
            waiting.append(demodulated / (0.5 * np.sin(loop.depth) * loop.half_periods))
            demodulated = 0.0
            acted_on = waiting.pop(0)
            second += loop.second_gain * acted_on
            feedback += loop.gain * acted_on + second
    return np.array(readings)


@pytest.mark.parametrize("name", LOOPS)
@pytest.mark.parametrize("v_pi_error", [0.0, 0.01, -0.03])
def test_kernel_is_what_waves_and_modulator_do(make_gyro, name, v_pi_error):
    gyro = make_gyro(**LOOPS[name], v_pi_error=v_pi_error)
    k = gyro.loop.half_periods
    t = np.arange(300 * k) / (300 * k)
    rates = 1.2 * t * np.cos(12 * t)
    record = simulate.run(gyro, rates, initial_rate=0.0)
    # a modulator phase of some hundred rad has lost two digits; no reset here hangs on rounding
    assert_allclose(record.rate, modulator_reading(gyro, rates), atol=1e-11)


@settings(max_examples=30)
@given(acceleration=st.floats(-900, 900), gain=st.floats(0.2, 1.5))
def test_lag_under_constant_acceleration_is_the_acceleration_error_constant(acceleration, gain):
    loop = Loop(depth=2.0, half_period=5e-6, half_periods=16, gain=gain)
    gyro = ClosedLoopGyro(coil=Coil(length=1000, diameter=0.1), loop=loop)
    record = simulate.run(gyro, Ramp(acceleration=acceleration), duration=0.02, degree=1)
    # type-1 loop: error = slope per step / gain; the start has died away by 0.8**250
    assert_allclose(record.error[-1], -acceleration * 80e-6 / gain, rtol=1e-9, atol=1e-13)


def test_second_integrator_leaves_no_lag(make_gyro):
    record = simulate.run(make_gyro(gain=0.5, second_gain=0.1), Ramp(acceleration=50), duration=0.05, degree=1)
    assert_allclose(record.error[-1], 0, atol=1e-12)


@pytest.mark.parametrize("degree", [1, 2, 3, 4, 5, 6])
def test_taylor_model_approaches_the_exact_one_at_the_order_of_its_remainder(make_gyro, degree):
    # two half-periods only: of the terms of even degree just the part survives that moves within a pair of states
    gyro = make_gyro(depth=1.0, half_periods=2)

    def difference(acceleration):
        exact, taylor = (
            simulate.run(gyro, AngularOscillation(acceleration=acceleration, frequency=300), duration=1 / 300, degree=d)
            for d in (None, degree)
        )
        return np.abs(exact.rate - taylor.rate).max()

    order = np.log2(difference(8000.0) / difference(4000.0))
    assert_allclose(order, degree + 1, atol=0.25)  # the next term's share at a residual of 0.1 rad


def test_blocks_do_not_show(make_gyro, monkeypatch):
    gyro = make_gyro(gain=0.4, delay=2, bias_order="alternating", detector_noise=1e-4)
    motion = AngularOscillation(acceleration=300, frequency=70)
    whole = simulate.run(gyro, motion, duration=0.1, rng=np.random.default_rng(3))
    monkeypatch.setattr(simulate, "SAMPLES_PER_BLOCK", 16 * 37)
    parts = simulate.run(gyro, motion, duration=0.1, rng=np.random.default_rng(3))
    assert parts.time.size == 1250 and parts.resets == whole.resets
    # the sine's recurrence restarts with each block
    assert_allclose(parts.rate, whole.rate, atol=1e-13)


def test_a_motion_may_be_an_object_a_function_or_an_array(make_gyro):
    gyro = make_gyro()
    oscillation = AngularOscillation(acceleration=100, frequency=60, phase=0.3)

    def function(t):
        return 100 / (2 * np.pi * 60) * np.sin(2 * np.pi * 60 * t + 0.3)

    records = [
        simulate.run(gyro, oscillation, duration=0.01),
        simulate.run(gyro, function, duration=0.01),
        simulate.run(gyro, function((np.arange(2000) + 0.5) * 5e-6)),
    ]
    for record in records:
        assert record.time.size == 125
        assert_allclose(record.rate, records[0].rate, atol=1e-13)


def test_true_rate_and_time_are_those_of_the_middle_of_each_period(make_gyro):
    record = simulate.run(make_gyro(), Ramp(acceleration=10, rate=0.1), duration=0.01)
    assert_allclose(record.true_rate, 0.1 + 10 * record.time, rtol=1e-12)


def test_a_perfect_drive_hides_its_resets_and_they_come_at_the_fringe_rate(make_gyro):
    gyro = make_gyro()
    record = simulate.run(gyro, Ramp(acceleration=0, rate=BALANCED_RATE), duration=0.1)
    assert_allclose(record.rate, BALANCED_RATE, rtol=1e-12)
    # one reset whenever the steps add up to 2 pi
    assert abs(record.resets - gyro.coil.phase(BALANCED_RATE) * 20000 / (2 * np.pi)) <= 1


def test_a_drive_error_spoils_single_readings_but_not_the_scale_factor(make_gyro):
    # the resets take back on average what the steps give too much, whatever the drive
    gyro = make_gyro(v_pi_error=0.01, depth=np.pi / 2, gain=0.2)
    record = simulate.run(gyro, Ramp(acceleration=0, rate=BALANCED_RATE), duration=4.0)
    settled = record.rate[1000:]
    assert settled.std() > 1e-5 * BALANCED_RATE
    assert_allclose(settled.mean(), BALANCED_RATE, rtol=3e-5)  # 49 000 readings hold a fraction of a beat more


@pytest.mark.parametrize("levels", [{"detector_noise": 1e-3}, {"shot_noise": 2e-3}, {"intensity_noise": 5e-3}])
def test_noise_makes_the_angle_random_walk_that_is_told(make_gyro, levels):
    gyro = make_gyro(**levels, gain=0.5)
    record = simulate.run(gyro, Ramp(acceleration=0), duration=8.0, rng=np.random.default_rng(11))
    chunks = record.rate.reshape(400, -1).mean(axis=1)  # 0.02 s each: long for the loop
    estimate = chunks.std(ddof=1) * np.sqrt(0.02)
    assert_allclose(estimate, gyro.angle_random_walk, rtol=3 / np.sqrt(2 * 399))  # 3 sigma of a deviation from 400


def test_noise_of_the_residual_is_the_loops_share_of_the_detectors(make_gyro):
    gyro = make_gyro(detector_noise=1e-3)
    record = simulate.run(gyro, Ramp(acceleration=0), duration=2.0, rng=np.random.default_rng(5))
    # unit gain: this period's noise less the last one's
    assert_allclose(gyro.coil.phase(record.residual).var(), 2 * gyro.residual_noise**2, rtol=3 * np.sqrt(3 / 25000))


def test_loss_of_lock_is_told_and_not_read_over(make_gyro):
    gyro = make_gyro(gain=0.05)
    motion = AngularOscillation(acceleration=6000, frequency=60, phase=0.2)
    with pytest.raises(simulate.FringeLockError, match="fringe lock lost at") as caught:
        simulate.run(gyro, motion, duration=0.1)
    record = simulate.run(gyro, motion, duration=0.1, on_lock_loss="nan")
    assert record.lock_lost_at == caught.value.time
    lost = np.isnan(record.rate)
    assert lost.any() and not lost[0]
    assert_array_equal(lost, np.isnan(record.residual))
    assert_array_equal(lost, record.time > record.lock_lost_at - 80e-6 / 2 - 1e-12)
    # until then the residual phase was inside the fringe: the phase error of the reading stays below pi
    assert np.abs(gyro.coil.phase(record.error[~lost])).max() < np.pi


def test_a_lost_fringe_really_is_another_reading(make_gyro):
    # without the watch (same waves, plain Python) the loop settles on a wrong rate
    gyro = make_gyro(gain=0.5)
    reading = modulator_reading(gyro, np.full(2000, gyro.coil.rate(3.5)))
    assert_allclose(gyro.coil.phase(reading[-1]), 3.5 - 2 * np.pi, rtol=1e-6)
    with pytest.raises(simulate.FringeLockError):
        simulate.run(gyro, np.full(2000, gyro.coil.rate(3.5)), initial_rate=0.0)


@pytest.mark.parametrize(
    ("argument", "motion", "options"),
    [
        ("motion", [], {}),
        ("motion", [[0.0] * 16], {}),
        ("motion", [np.nan] * 16, {}),
        ("motion", [0.0] * 17, {}),
        ("duration", [0.0] * 16, {"duration": 1.0}),
        ("duration", np.sin, {}),
        ("duration", np.sin, {"duration": 1e-6}),
        ("duration", np.sin, {"duration": -1.0}),
        ("motion(t)", lambda t: t[:3], {"duration": 1e-3}),
        ("motion(t)", lambda t: t * np.inf, {"duration": 1e-3}),
        ("degree", [0.0] * 16, {"degree": 0}),
        ("on_lock_loss", [0.0] * 16, {"on_lock_loss": "ignore"}),
        ("initial_rate", [0.0] * 16, {"initial_rate": np.nan}),
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value encountered in multiply:RuntimeWarning")
def test_impossible_input_is_refused_by_name(make_gyro, argument, motion, options):
    with pytest.raises(ValueError) as caught:
        simulate.run(make_gyro(), motion, **options)
    assert f"`{argument}`" in str(caught.value)


def test_a_remedy_for_records_is_refused_inside_the_loop(make_gyro):
    with pytest.raises(TypeError, match="`compensation` must be an InsideLoop"):
        simulate.run(make_gyro(), [0.0] * 16, compensation=AfterLoop())


def test_a_noisy_gyro_wants_a_generator(make_gyro):
    with pytest.raises(TypeError, match="`rng`"):
        simulate.stream(make_gyro(detector_noise=1e-3), Ramp(acceleration=0), 1.0)


@pytest.mark.parametrize(
    ("name", "value"), [("detector_noise", -1.0), ("shot_noise", np.nan), ("intensity_noise", np.inf)]
)
def test_impossible_noise_is_refused_by_name(make_gyro, name, value):
    with pytest.raises(ValueError, match=f"`{name}`"):
        make_gyro(**{name: value})


def test_a_gyro_is_made_of_a_coil_and_a_loop():
    with pytest.raises(TypeError, match=r"`loop`.*Loop"):
        ClosedLoopGyro(coil=Coil(length=1000, diameter=0.1), loop={"gain": 1})


@pytest.mark.parametrize("motion", [AngularOscillation, Ramp])
def test_motions_refuse_what_is_not_finite(motion):
    arguments = {"frequency": 60.0} if motion is AngularOscillation else {}
    with pytest.raises(ValueError, match="`acceleration`"):
        motion(acceleration=np.inf, **arguments)


def test_record_becomes_a_table(make_gyro):
    table = simulate.run(make_gyro(), Ramp(acceleration=1), duration=0.01).to_frame()
    assert table.index.name == "time"
    assert list(table.columns) == ["rate", "residual", "true_rate"]


def test_tables_are_arrays_and_classes_are_refused(make_gyro):
    import pandas as pd

    rates = np.full(160, 0.1)
    assert_array_equal(simulate.run(make_gyro(), pd.Series(rates)).rate, simulate.run(make_gyro(), rates).rate)
    with pytest.raises(TypeError, match=r"`motion`.*class AngularOscillation"):
        simulate.run(make_gyro(), AngularOscillation, 0.1)


def test_a_vibration_that_sampling_would_fold_is_refused(make_gyro):
    with pytest.raises(ValueError, match=r"`frequency`.*half the sampling rate"):
        simulate.run(make_gyro(), AngularOscillation(acceleration=1.0, frequency=150e3), 0.1)


def test_loss_of_lock_comes_out_of_a_process_whole():
    import pickle

    error = simulate.FringeLockError(1.5, 0.25)
    copy = pickle.loads(pickle.dumps(error))
    assert (copy.time, copy.rate, str(copy)) == (1.5, 0.25, str(error))


def test_a_record_of_a_real_gyro_needs_no_truth(make_gyro):
    readings = np.linspace(0, 1, 10)
    record = simulate.LoopRecord(gyro=make_gyro(), time=readings, rate=readings, residual=0 * readings)
    assert np.isnan(record.error).all() and np.isnan(record.lock_lost_at)


def test_a_half_period_away_from_the_transit_time_warns(make_gyro):
    with pytest.warns(UserWarning, match="transit time"):
        make_gyro(half_period=7e-6)


@pytest.mark.parametrize("depth", [1.0, 3 * np.pi / 4])
@pytest.mark.parametrize("v_pi_error", [-0.02, 0.02])
def test_angle_random_walk_follows_the_actual_slope(make_gyro, depth, v_pi_error):
    # at a constant zero rate there are no resets, and the loop averages its noise to zero with the slope that it has
    gyro = make_gyro(detector_noise=1e-3, depth=depth, v_pi_error=v_pi_error)
    exact = make_gyro(detector_noise=1e-3, depth=depth * (1 + v_pi_error))
    assert_allclose(gyro.angle_random_walk, exact.angle_random_walk, rtol=1e-12)


def test_weak_noise_of_any_kind_counts(make_gyro):
    for kind in ("detector_noise", "shot_noise", "intensity_noise"):
        gyro = make_gyro(**{kind: 1e-9})
        assert gyro.is_noisy
        record = simulate.run(gyro, np.zeros(160), rng=np.random.default_rng(0))
        assert np.abs(record.residual[1:]).max() > 0


def test_time_of_a_late_loss_of_lock_is_counted_from_the_start(make_gyro, monkeypatch):
    monkeypatch.setattr(simulate, "SAMPLES_PER_BLOCK", 16 * 10)
    rates = np.zeros(16 * 100)
    rates[16 * 57 + 3 :] = 3.0
    record = simulate.run(make_gyro(), rates, on_lock_loss="nan")
    assert_allclose(record.lock_lost_at, (16 * 57 + 3) * 5e-6, rtol=1e-12)


def test_resets_are_counted_in_either_direction(make_gyro):
    forth, back = (simulate.run(make_gyro(), np.full(16 * 500, rate)).resets for rate in (0.4, -0.4))
    assert abs(forth - back) <= 1 and forth > 100


def test_a_motion_of_ones_own_is_checked(make_gyro):
    class Short:
        def sample(self, first, count, step):
            return np.zeros(count - 1)

    with pytest.raises(ValueError, match="`motion`"):
        simulate.run(make_gyro(), Short(), 0.01)


def test_whole_floats_count_as_whole(make_gyro):
    gyro = make_gyro(half_periods=16.0, delay=1.0, gain=0.4)
    assert isinstance(gyro.loop.half_periods, int) and isinstance(gyro.loop.delay, int)
    assert simulate.run(gyro, np.zeros(64)).rate.size == 4
