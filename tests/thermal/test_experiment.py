"""The simulated temperature test: Shupe's integral, the noise that is stated, and schedules."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import quad

from fogkit.thermal import ThermalNetwork, experiment, network
from fogkit.thermal.experiment import CoilBias, PolynomialEffect, Run, Thermometer, simulate
from fogkit.units import DEG_PER_HOUR


@pytest.mark.parametrize(
    ("weight", "share"),
    # w(l): the part of the upper face in the temperature at the place l of the fibre, in units of its length
    [(lambda x: float(x < 0.5), 1.0), (lambda x: 1 - x, 2 / 3), (lambda x: 0.5, 0.0), (lambda x: float(x > 0.5), -1.0)],
)
def test_two_point_form_is_shupes_integral(weight, share):
    coil, top, bottom = experiment.COIL, 0.01, 0.004
    L, n = coil.length, coil.index
    integrand = lambda x: (1 - 2 * x) * (weight(x) * top + (1 - weight(x)) * bottom)  # noqa: E731
    integral = quad(integrand, 0, 1, points=[0.5])[0] * L**2
    rate = n / (coil.diameter * L) * (1e-5 + n * 5.5e-7) * integral
    two_point = experiment.shupe_coefficient(coil, share=share) * (top - bottom)
    assert_allclose(two_point, rate, rtol=1e-10, atol=1e-18)


def test_a_coil_that_warms_evenly_reads_nothing_by_rate():
    gyro = experiment.example_gyro()
    assert_allclose(gyro.rate["coil_top"] + gyro.rate["coil_bottom"], 0, atol=1e-20)
    nodes = ("coil_top", "coil_bottom", "electronics")
    assert_allclose(gyro.truth(nodes, [25, 25, 25], [0.1, 0.1, 0]), gyro.constant, rtol=1e-12)


def test_readings_have_the_noise_that_is_stated():
    body = ThermalNetwork(capacities={"a": 1e3}, conductances={("a", "chamber"): 1.0})
    gyro = CoilBias(constant=1.0, temperature={"a": 2.0}, angle_random_walk=3.0, bias_repeatability=100.0)
    rng = np.random.default_rng(1)
    effects = {"bias": gyro, "other": PolynomialEffect(point="a", coefficients=[1, 1, 1], noise=0.5)}
    meter = Thermometer(noise=0.3, resolution=1.0)
    options = {"effects": effects, "interval": 4.0, "thermometer": meter, "truth": True}
    runs = [simulate(body, network.soak(30.0), 20_000.0, rng=rng, **options) for _ in range(40)]
    error = [run.bias - run.true_bias for run in runs]
    assert_allclose(runs[0].true_bias, 11.0, rtol=1e-12)
    assert_allclose(runs[0].true_other, 31.0, rtol=1e-12)
    n = len(error[0])
    # 5 sigma of a deviation from n numbers
    assert_allclose(error[0].std(), 3.0 / np.sqrt(4.0), rtol=5 / np.sqrt(2 * n))
    assert_allclose((runs[0].other - runs[0].true_other).std(), 0.5, rtol=5 / np.sqrt(2 * n))
    assert_allclose(np.std([e.mean() for e in error], ddof=1), 100.0, rtol=5 / np.sqrt(80))
    assert set(runs[0].temperature_a % 1.0) == {0.0}
    assert_allclose(meter.deviation, np.hypot(0.3, 1 / np.sqrt(12)))
    assert_array_equal(runs[0].true_temperature_a, 30.0)


def test_without_a_generator_everything_is_true():
    unit, profile = experiment.in_unit(), network.ramp(0, 50, rate=0.02)
    run = simulate(unit, profile, 3600.0, truth=True)
    assert_array_equal(run.bias, run.true_bias)
    temperature, rate = unit.solve(run.index.to_numpy(), profile)
    for i, node in enumerate(unit.nodes):
        assert_array_equal(run[f"temperature_{node}"], temperature[:, i])
        assert_array_equal(run[f"true_rate_{node}"], rate[:, i])
    assert_array_equal(run.temperature_chamber, profile.at(run.index))
    assert run.index.name == "time" and run.index[-1] == 3600.0


def test_power_before_the_run_starts_it_in_the_steady_state():
    unit = experiment.in_unit()
    before = simulate(unit, network.soak(10.0), 600.0, powered=True, effects={})
    assert_allclose(before[[f"temperature_{n}" for n in unit.nodes]], np.tile(unit.steady_state(10.0), (61, 1)))
    after = simulate(unit, network.soak(10.0), 600.0, effects={})
    assert_allclose(after.iloc[0], 10.0, rtol=1e-13)


def test_schedule():
    plan = experiment.start_ups((0, 20), 3600.0) + experiment.warm_runs()
    table = experiment.schedule_table(plan)
    assert list(table["power"]) == ["on at the start"] * 2 + ["on before"] * 4
    assert_allclose(table["fastest ramp, K/min"].to_numpy(float)[[0, 2, 4, 5]], [0, 3, 1, 1])
    assert table["duration, h"].sum() == 22
    tables = experiment.campaign(experiment.in_unit(), plan, effects={})
    assert [len(t) for t in tables] == [30, 30, *[150] * 4]
    assert "rate_chamber" in tables[0]
    raw = experiment.campaign(experiment.in_unit(), plan[:1], window=None, effects={})
    assert len(raw[0]) == 361


def test_example_effects():
    nodes = experiment.in_unit().nodes
    rates = np.zeros(len(nodes))
    accelerometer, scale = experiment.example_accelerometer(), experiment.example_scale_factor()
    assert_allclose(accelerometer.truth(nodes, np.full(len(nodes), 25.0), rates), 500e-6 * 9.80665)
    assert_allclose(scale.truth(nodes, np.full(len(nodes), 35.0), rates), 1 + 80e-6, rtol=1e-15)
    assert experiment.example_gyro().bias_repeatability == 0.002 * DEG_PER_HOUR


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: CoilBias(temperature={"x": 1.0}).truth(("a",), [1.0], [0.0]), ValueError, "`nodes`.* got 'x'"),
        (lambda: CoilBias(rate={"a": np.nan}), ValueError, r"`rate\['a'\]`"),
        (lambda: CoilBias(angle_random_walk=-1), ValueError, "`angle_random_walk`"),
        (lambda: PolynomialEffect(point="x", coefficients=[1]).truth(("a",), [1.0], [0.0]), ValueError, "`point`"),
        (lambda: PolynomialEffect(point="x", coefficients=[np.nan]), ValueError, "`coefficients`"),
        (lambda: Thermometer(noise=-1), ValueError, "`noise`"),
        (lambda: simulate(experiment.alone(), network.soak(1), 10.0, rng=3), TypeError, "`rng`"),
        (lambda: simulate(experiment.alone(), 20.0, 10.0), TypeError, "`profile`"),
        (lambda: simulate("unit", network.soak(1), 10.0), TypeError, "`network`"),
        (lambda: Run(name="r", profile=network.soak(1), duration=0, powered=True), ValueError, "`duration`"),
        (lambda: experiment.shupe_coefficient("coil"), TypeError, "`coil`"),
    ],
)
def test_bad_input_is_named(call, error, words):
    with pytest.raises(error, match=words):
        call()
