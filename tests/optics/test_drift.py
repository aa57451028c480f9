import numpy as np
import pytest
import sympy
from loops import LOOPS
from numpy.testing import assert_allclose

from fogkit.optics import drift, measure
from fogkit.optics.motion import AngularOscillation, Ramp
from fogkit.units import DEG, DEG_PER_HOUR

PAPER = 5000 * DEG  # rad/s^2 at 60 Hz, the paper's case
DEVICES = {"1": {}, "2": {"depth": 7 * np.pi / 8, "half_periods": 32}}


def settled_drift(gyro, acceleration, degree):
    """Late difference between nonlinear and linear reading under constant acceleration."""
    error = measure.nonlinear_error(gyro, Ramp(acceleration=acceleration), 0.03, degree=degree)
    rows = gyro.loop.bias_pattern.shape[0]
    return error.rate[-rows:].mean()


@pytest.mark.parametrize("device", DEVICES)
def test_formula_11_is_what_the_second_degree_loop_does(make_gyro, device):
    # constant acceleration: the only other term is the second-degree effect on the lag itself, a relative
    # cot(depth) * S * eps * dt / 2 = 1e-3 at 5000 deg/s^2
    gyro = make_gyro(**DEVICES[device])
    simulated = 0.5 * (settled_drift(gyro, PAPER, 2) + settled_drift(gyro, -PAPER, 2))
    assert_allclose(simulated, drift.steady_drift(gyro, PAPER), rtol=1e-5)
    assert simulated < 0


@pytest.mark.parametrize("device", DEVICES)
def test_mean_under_vibration_is_half_of_formula_11(make_gyro, device):
    gyro = make_gyro(**DEVICES[device])
    measured = measure.simulated_drift(gyro, AngularOscillation(acceleration=PAPER, frequency=60), 2.0, degree=2)
    assert_allclose(measured.drift, drift.steady_drift(gyro, PAPER) / 2, rtol=1e-3)  # the loop's own phase at 60 Hz


def test_sign_and_factors_of_the_paper_by_symbols():
    # from the paper's (1) and its steady state (10): sum over the pairs, nothing of the package
    phi, S, eps, dt, t = sympy.symbols("phi S epsilon dt t")
    k = 6
    for start, factor in ((0, sympy.Rational(1, 8)), (eps * k * dt / 2, sympy.Rational(1, 4))):
        total = 0
        for m in range(k):
            residual = S * (start + eps * (m + sympy.Rational(1, 2)) * dt)
            bias = -1 if m % 2 == 0 else 1  # P_1, at -phi, comes first
            second = sympy.series((1 + sympy.cos(t + bias * phi)) / 2, t, 0, 3).removeO().coeff(t, 2)
            total += -bias * second * residual**2
        error = total / (sympy.sin(phi) / 2 * k) / S
        expected = factor * sympy.cot(phi) * S * eps**2 * (2 * dt) * (k * dt)
        assert sympy.simplify(sympy.expand_trig(error - expected).rewrite(sympy.cos)) == 0


def test_functions_of_5_6_8_agree_with_each_other(make_gyro):
    # from rest the residual grows as eps t: the sum over the states at the middles of half-periods is (8) exactly
    gyro = make_gyro()
    times = (np.arange(16) + 0.5) * 5e-6
    assert_allclose(drift.drift_of_states(gyro, PAPER, times), drift.drift_from_rest(gyro, PAPER), rtol=1e-12)
    # and (11) is the sum with each time later by half a regulation period
    assert_allclose(drift.drift_of_states(gyro, PAPER, times + 40e-6), drift.steady_drift(gyro, PAPER), rtol=1e-12)
    two = make_gyro(half_periods=2)
    expected = 0.25 / np.tan(3 * np.pi / 4) * two.coil.sagnac_scale_factor * PAPER**2 * ((7e-6) ** 2 - (2e-6) ** 2)
    assert_allclose(drift.drift_of_states(two, PAPER, [2e-6, 7e-6]), expected, rtol=1e-12)


@pytest.mark.parametrize("name", [*LOOPS, "plus-minus"])
@pytest.mark.parametrize("frequency", [20.0, 60.0, 330.0, 1100.0, 4100.0])
def test_law_for_any_loop_and_frequency_is_what_the_simulator_does(make_gyro, name, frequency):
    gyro = make_gyro(**LOOPS.get(name, {"bias_order": name}))
    # residuals below 0.05 rad: the fourth power of them is the next term
    acceleration = min(PAPER, 600 * frequency * DEG)
    oscillation = AngularOscillation(acceleration=acceleration, frequency=frequency, phase=0.7)
    measured = measure.simulated_drift(gyro, oscillation, 1.0 if frequency < 60 else None, degree=2)
    law = drift.vibration_drift(gyro, acceleration, frequency)
    # rounding of a rate of 1 rad/s over some thousand readings, besides the fourth power
    assert_allclose(measured.drift, law, rtol=3e-5, atol=3e-17 * oscillation.rate_amplitude * 1e3)


@pytest.mark.parametrize("name", LOOPS)
def test_law_tends_to_half_the_steady_one_at_low_frequency(make_gyro, name):
    gyro = make_gyro(**LOOPS[name])
    low, steady = drift.vibration_drift(gyro, 1.0, 0.5), drift.steady_drift(gyro, 1.0) / 2
    # terms of second order in frequency times regulation period, 4e-5, over the loop's gain
    scale = abs(drift.steady_drift(make_gyro(), 1.0))
    assert_allclose(low, steady, rtol=1e-4, atol=1e-4 * scale)


def test_alternating_order_cancels(make_gyro):
    gyro = make_gyro(bias_order="alternating")
    measured = measure.simulated_drift(gyro, AngularOscillation(acceleration=PAPER, frequency=60), degree=2)
    assert abs(measured.drift) < 1e-8 * abs(drift.steady_drift(make_gyro(), PAPER))


@pytest.mark.parametrize("loop", [{}, {"gain": 0.3}, {"bias_order": "plus-minus"}, {"depth": 1.0}])
@pytest.mark.parametrize("acceleration", [20000 * DEG, -60000 * DEG])
def test_full_response_under_constant_acceleration(make_gyro, loop, acceleration):
    gyro = make_gyro(**loop)
    error = measure.nonlinear_error(gyro, Ramp(acceleration=acceleration), 0.02)
    assert_allclose(error.rate[-1], drift.full_response_drift(gyro, acceleration), rtol=1e-9)


def test_full_response_says_where_no_lag_holds(make_gyro):
    assert np.isnan(drift.full_response_drift(make_gyro(gain=0.05), 1e5 * DEG))
    with pytest.raises(ValueError, match="second integrator"):
        drift.full_response_drift(make_gyro(gain=0.5, second_gain=0.1), 1.0)
    with pytest.raises(ValueError, match="bias order"):
        drift.full_response_drift(make_gyro(bias_order="mirrored"), 1.0)


def test_random_vibration_is_the_sum_of_its_bands(make_gyro):
    # two thousand tones of equal power and random phase, simulated; the sum of their single drifts is no input of it
    gyro = make_gyro(gain=0.5)
    rng = np.random.default_rng(8)
    n = 2**20
    spectrum = np.zeros(n // 2 + 1, complex)
    frequency = np.fft.rfftfreq(n, 5e-6)
    band = (frequency > 100) & (frequency < 600)
    density = 4000.0  # (rad/s^2)^2 / Hz
    amplitude = np.sqrt(2 * density * frequency[1]) / (2 * np.pi * frequency[band])
    spectrum[band] = amplitude * np.exp(2j * np.pi * rng.random(band.sum())) * n / 2
    rates = np.fft.irfft(spectrum, n)
    error = measure.nonlinear_error(gyro, rates, degree=2)
    expected = drift.random_vibration_drift(gyro, np.linspace(100, 600, 501), np.full(501, density))
    # the record is periodic, so that only products of different tones remain: none at zero frequency but by folding
    assert_allclose(error.rate[100:].mean(), expected, rtol=0.02)  # start of the loop


def test_drift_is_at_most_in_deg_per_hour_where_the_paper_puts_it(make_gyro):
    # order of magnitude from the paper's text: tenths of a degree per hour at 5000 deg/s^2
    assert 0.1 < abs(drift.steady_drift(make_gyro(), PAPER) / 2 / DEG_PER_HOUR) < 0.4


@pytest.mark.parametrize("frequency", [0.0, -1.0, np.nan, []])
def test_impossible_frequencies_are_refused(make_gyro, frequency):
    with pytest.raises(ValueError, match="`frequency`"):
        drift.vibration_drift(make_gyro(), 1.0, frequency)


@pytest.mark.parametrize(
    ("name", "frequency", "density"),
    [("frequency", [2.0, 1.0], [1.0, 1.0]), ("density", [1.0, 2.0], [1.0, -1.0]), ("density", [1.0, 2.0], [1.0])],
)
def test_impossible_densities_are_refused(make_gyro, name, frequency, density):
    with pytest.raises(ValueError, match=f"`{name}`"):
        drift.random_vibration_drift(make_gyro(), frequency, density)


def test_times_must_fit_the_half_periods(make_gyro):
    with pytest.raises(ValueError, match="`times`"):
        drift.drift_of_states(make_gyro(), 1.0, [1e-6, 2e-6])


@pytest.mark.parametrize("acceleration", [50_000, 300_000])
@pytest.mark.parametrize("depth", [3 * np.pi / 4, 7 * np.pi / 8])
def test_a_mirrored_vibration_makes_no_drift_in_the_alternating_order_at_any_amplitude(make_gyro, acceleration, depth):
    # by symmetry: reversed motion with reversed states is the same run half a cycle and one regulation period later
    gyro = make_gyro(bias_order="alternating", depth=depth)
    oscillation = AngularOscillation(acceleration=acceleration * DEG, frequency=60, phase=0.4)
    measured = measure.simulated_drift(gyro, oscillation, 2.0)
    assert abs(measured.drift) < 1e-10 * oscillation.rate_amplitude  # leakage of the window, 120 cycles: 4e-14


@pytest.mark.parametrize("law", [drift.steady_drift, drift.full_response_drift, drift.drift_from_rest])
def test_laws_refuse_a_drive_with_an_error(make_gyro, law):
    with pytest.raises(ValueError, match="v_pi_error"):
        law(make_gyro(v_pi_error=0.01), 1.0)


def test_an_order_that_changes_is_judged_row_by_row(make_gyro):
    # two rows, the first with twice the moment of the second: the first demodulation, and the mean of both
    rows = [[-1, 1, -1, 1], [-1, 1, 1, -1]]
    gyro = make_gyro(half_periods=4, bias_order=rows)
    alone = [make_gyro(half_periods=4, bias_order=[row]) for row in rows]
    times = (np.arange(4) + 0.5) * 5e-6
    assert_allclose(drift.drift_of_states(gyro, 1.0, times), drift.drift_of_states(alone[0], 1.0, times), rtol=1e-12)
    mean = np.mean([drift.vibration_drift(one, 1.0, 60.0) for one in alone])
    assert_allclose(drift.vibration_drift(gyro, 1.0, 60.0), mean, rtol=1e-12)
    oscillation = AngularOscillation(acceleration=PAPER, frequency=60)
    measured = measure.simulated_drift(gyro, oscillation, degree=2)
    assert_allclose(measured.drift, drift.vibration_drift(gyro, PAPER, 60.0), rtol=1e-4)
