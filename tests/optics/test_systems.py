import warnings

import control
import numpy as np
import pytest
from loops import LOOPS
from numpy.testing import assert_allclose

from fogkit.optics import Loop, simulate, systems

ROUNDING = 1e-12  # of the largest value: some hundred operations on numbers near one
BASE = {"depth": 2.0, "half_period": 5e-6, "half_periods": 16}


@pytest.mark.parametrize("name", LOOPS)
def test_frequency_responses_are_the_loops_own(make_gyro, name):
    loop = make_gyro(**LOOPS[name]).loop
    frequency = np.array([0.5, 20, 900, 6000])
    for system, expected in (
        (systems.open_loop(loop), loop.open_loop_response(frequency)),
        (systems.closed_loop(loop), loop.closed_loop_response(frequency)),
        (systems.error_function(loop), 1 - loop.closed_loop_response(frequency)),
    ):
        assert system.dt == loop.regulation_period
        # at 0.5 Hz the error function of two integrators is the difference of numbers 1e7 times larger
        assert_allclose(
            control.frequency_response(system, 2 * np.pi * frequency).complex, expected, rtol=1e-9, atol=1e-15
        )


@pytest.mark.parametrize("name", LOOPS)
@pytest.mark.parametrize("shape", ["step", "ramp", "noise"])
def test_linear_simulation_is_the_forced_response(make_gyro, name, shape):
    gyro = make_gyro(**LOOPS[name])
    k = gyro.loop.half_periods
    rates = {
        "step": np.full(200 * k, 0.3),
        "ramp": np.linspace(0, 1, 200 * k),
        "noise": np.random.default_rng(1).standard_normal(200 * k),
    }[shape]
    record = simulate.run(gyro, rates, degree=1, initial_rate=0.0)
    inputs = rates.reshape(-1, k).mean(axis=1)
    for system, signal in (
        (systems.closed_loop(gyro.loop), record.rate),
        (systems.error_function(gyro.loop), record.residual),
    ):
        response = control.forced_response(system, U=inputs)
        assert_allclose(signal, response.outputs, atol=ROUNDING * np.abs(inputs).max() * 10)


@pytest.mark.parametrize("name", ["unit gain", "low gain", "delay", "two integrators"])
@pytest.mark.parametrize("frequency", [20.0, 700.0, 5200.0])
def test_simulated_frequency_response_is_that_of_control(make_gyro, name, frequency):
    # the simulator is driven by a phasor's two quadratures after the start has died away; commensurate, so that the
    # discrete Fourier coefficient is exact
    gyro = make_gyro(**LOOPS[name])
    loop = gyro.loop
    periods = 1250  # of 80 us: 0.1 s, a whole number of cycles of every frequency
    t = np.arange(4 * periods * loop.half_periods) * loop.half_period
    record = simulate.run(gyro, 0.2 * np.cos(2 * np.pi * frequency * t), degree=1)
    kernel = np.exp(-2j * np.pi * frequency * loop.regulation_period * np.arange(periods))
    output, truth = record.rate[-periods:] @ kernel, record.true_rate[-periods:] @ kernel
    expected = control.frequency_response(systems.closed_loop(loop), 2 * np.pi * frequency).complex
    assert_allclose(output / truth, expected, rtol=1e-9)


@pytest.mark.parametrize("degree", [None, 1, 2, 5])
@pytest.mark.parametrize(
    "loop",
    [
        {},
        {"gain": 0.4, "delay": 2, "bias_order": "alternating"},
        {"gain": 0.5, "second_gain": 0.05, "v_pi_error": 0.01},
        {"gain": 0.3, "second_gain": 0.02, "delay": 1, "bias_order": "balanced", "v_pi_error": -0.02},
    ],
)
def test_nonlinear_system_is_the_simulator_sample_by_sample(make_gyro, degree, loop):
    gyro = make_gyro(**loop)
    k = gyro.loop.half_periods
    t = np.arange(80 * k) * gyro.loop.half_period
    rates = 0.5 * np.sin(2 * np.pi * 300 * t) + 1.5 * t / t[-1]
    response = control.input_output_response(
        systems.nonlinear_system(gyro, degree=degree), t, np.vstack([rates, 0 * t])
    )
    record = simulate.run(gyro, rates, initial_rate=0.0, degree=degree)
    assert record.resets > 0
    assert_allclose(response.outputs[0][::k], record.rate, atol=1e-13)


def test_nonlinear_system_can_be_wired_to_another(make_gyro):
    gyro = make_gyro(gain=0.5)
    gyro_system = systems.nonlinear_system(gyro)
    alpha = 0.01
    smoother = control.ss(
        [[1 - alpha]], [[alpha]], [[1]], 0, gyro.loop.half_period, inputs="rate_estimate", outputs="smooth", name="s"
    )
    both = control.interconnect(
        [gyro_system, smoother], inputs=["rate", "power_noise"], outputs=["smooth"], check_unused=False
    )
    t = np.arange(3000) * gyro.loop.half_period
    response = control.input_output_response(both, t, np.vstack([np.full(t.size, 0.1), 0 * t]))
    assert_allclose(np.ravel(response.outputs)[-1], 0.1, rtol=1e-9)  # 3000 steps are 30 time constants of the smoother


def spectral_radius(loop, factor):
    """Largest pole of the closed loop with both gains multiplied."""
    scaled = systems.open_loop(loop) * factor
    return np.abs(control.feedback(scaled, 1).poles()).max()


@pytest.mark.parametrize("name", LOOPS)
def test_gain_margin_is_where_a_pole_leaves_the_unit_circle(make_gyro, name):
    loop = make_gyro(**LOOPS[name]).loop
    margin = systems.figures(loop).gain_margin
    assert spectral_radius(loop, 0.9999 * margin) < 1 < spectral_radius(loop, 1.0001 * margin)


@pytest.mark.parametrize("gain", [0.1, 0.5, 0.9])
def test_margins_and_bandwidth_of_the_plain_integrator_in_closed_form(gain):
    figures = systems.figures(Loop(**BASE, gain=gain))
    # |z - 1| = gain at the crossover, whose angle there is pi/2 + theta/2
    theta = 2 * np.arcsin(gain / 2)
    assert_allclose(figures.gain_margin, 2 / gain, rtol=1e-9)
    assert_allclose(figures.gain_crossover, theta / (2 * np.pi * 80e-6), rtol=1e-9)
    assert_allclose(figures.phase_margin, np.pi / 2 - theta / 2, rtol=1e-9)
    cosine = (1 + (1 - gain) ** 2 - 2 * gain**2) / (2 * (1 - gain))
    expected = np.arccos(cosine) / (2 * np.pi * 80e-6) if cosine > -1 else np.inf
    assert_allclose(figures.bandwidth, expected, rtol=1e-9)


def test_phase_margin_and_crossover_are_those_of_control(make_gyro):
    # control's phase margin is sound for these loops; its gain margin is not (chapter 1)
    for name in ("low gain", "delay", "two integrators"):
        loop = make_gyro(**LOOPS[name]).loop
        with warnings.catch_warnings():  # control warns of its own rounding on the way
            warnings.simplefilter("ignore")
            _, phase_margin, _, crossover = control.margin(systems.open_loop(loop))
        ours = systems.figures(loop)
        assert_allclose(np.rad2deg(ours.phase_margin), phase_margin, rtol=1e-6)
        assert_allclose(2 * np.pi * ours.gain_crossover, crossover, rtol=1e-6)


def test_peak_is_that_of_the_closed_loop(make_gyro):
    loop = make_gyro(gain=0.4, delay=2).loop
    frequency = np.linspace(1, 6250, 50_000)
    response = control.frequency_response(systems.closed_loop(loop), 2 * np.pi * frequency).magnitude
    assert_allclose(systems.figures(loop).peak, response.max(), rtol=1e-5)  # two grids on a smooth maximum


def test_outputs_of_the_nonlinear_system_are_phase_and_power(make_gyro):
    gyro = make_gyro()
    t = np.arange(4) * gyro.loop.half_period
    noise = np.array([0.0, 0.1, 0.0, 0.0])
    response = control.input_output_response(systems.nonlinear_system(gyro), t, np.vstack([np.full(4, 0.2), noise]))
    phase = gyro.coil.phase(0.2)
    bias = gyro.loop.depth * np.array([-1, 1, -1, 1])
    assert_allclose(response.outputs[1], phase, rtol=1e-12)
    assert_allclose(response.outputs[2], 0.5 * (1 + np.cos(phase + bias)) + noise, atol=1e-14)
