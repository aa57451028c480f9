"""The thermal network against closed forms, an independent integrator, and the balance of energy."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import simpson, solve_ivp

from fogkit.thermal import ThermalNetwork, experiment, network
from fogkit.thermal.network import Profile

BODY = ThermalNetwork(capacities={"body": 100.0}, conductances={("body", "chamber"): 0.5}, heat={"body": 2.0})
TIME = np.linspace(0, 3600, 361)


def test_one_body_warms_exponentially():
    temperature, rate = BODY.solve(TIME, network.soak(20.0), switch_on=600.0)
    since = np.maximum(TIME - 600, 0)
    assert_allclose(temperature[:, 0], 20 + 4 * (1 - np.exp(-since / 200)), rtol=1e-14)  # rounding
    assert_allclose(rate[:, 0], (TIME >= 600) * 0.02 * np.exp(-since / 200), atol=1e-16)


def test_one_body_follows_a_ramp_with_a_lag():
    # T = T_chamber - r tau (1 - exp(-t / tau)) on the ramp, and decays towards its end after it
    temperature, rate = BODY.solve(TIME, network.ramp(0, 100, rate=0.05), switch_on=1e9)
    on = TIME <= 2000
    assert_allclose(temperature[on, 0], 0.05 * (TIME[on] - 200 * (1 - np.exp(-TIME[on] / 200))), atol=1e-12)
    assert_allclose(100 - temperature[~on, 0], 10 * (1 - np.exp(-10)) * np.exp((2000 - TIME[~on]) / 200), atol=1e-12)
    # at the end of the ramp only the rate of the rate jumps
    assert_allclose(rate[on, 0][-1], 0.05 * (1 - np.exp(-10)), rtol=1e-12)


def test_two_bodies_have_the_modes_of_the_quadratic():
    # C = (1, 2), joined by 3, the first to the chamber by 4: s^2 - 8.5 s + 6 = 0 from det(G - s C) = 0
    pair = ThermalNetwork(capacities={"a": 1, "b": 2}, conductances={("a", "b"): 3, ("a", "chamber"): 4})
    s = np.roots([2, -17, 12])
    assert_allclose(pair.time_constants, np.sort(1 / s)[::-1], rtol=1e-13)
    time = np.linspace(0, 2, 21)
    temperature, _ = pair.solve(time, network.soak(0.0), start=[0.0, 1.0])
    # a' = -7 a + 3 b, so a(0) = 0 and a'(0) = 3 fix the amplitudes of the two modes
    fast, slow = max(s), min(s)
    expected = 3 / (fast - slow) * (np.exp(-slow * time) - np.exp(-fast * time))
    assert_allclose(temperature[:, 0], expected, atol=1e-14)


PROFILES = {
    "soak": network.soak(40.0),
    "ramp": network.ramp(20, -40, rate=0.03, begin=500),
    "steps": network.steps([20, 50, -10], hold=700),
    "ramped steps": network.steps([20, 50, -10], hold=700, rate=0.1),
    "sine": network.sine(10, 20, period=1800, duration=3600),
}


@pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)
def test_temperatures_and_rates_are_those_of_an_integrator(profile):
    unit = experiment.in_unit()
    capacity = np.array(list(unit.capacities.values()))
    start = 1.0 * np.arange(len(unit.nodes))
    corners = [0.0, *(t for t in np.unique([*profile.times, 900.0]) if 0 < t < 3600), 3600.0]
    state, expected, times = start, [], []
    for begin, end in pairwise(corners):  # the integrator must not step over a corner
        middle = 0.5 * (begin + end)
        value, slope = profile.line(middle)

        def flow(t, T, value=value, slope=slope, middle=middle, power=unit.power * (middle > 900)):
            chamber = value + slope * (t - middle)
            return (unit.to_chamber * chamber + power - unit.conductance_matrix @ T) / capacity

        result = solve_ivp(flow, (begin, end), state, t_eval=[middle, end], method="DOP853", rtol=1e-12, atol=1e-12)
        state = result.y[:, -1]
        times.append(middle)
        expected.append((result.y[:, 0], flow(middle, result.y[:, 0])))
    time = np.unique([0.0, *times, 3600.0])
    temperature, rate = unit.solve(time, profile, switch_on=900.0, start=start)
    at = np.searchsorted(time, times)
    # 1e-9 K: the integrator's tolerance over some hundred steps
    assert_allclose(temperature[at], [e[0] for e in expected], atol=1e-9)
    assert_allclose(rate[at], [e[1] for e in expected], atol=1e-9)


def test_energy_is_kept():
    unit, profile = experiment.in_unit(), network.sine(10, 20, period=1800, duration=3600)
    time = np.linspace(0, 3600, 48 * 2 * 20 + 1)  # the corners of the polygon are on the grid
    temperature, _ = unit.solve(time, profile)
    stored = temperature @ np.array(list(unit.capacities.values()))
    brought = simpson(unit.heat_from_chamber(temperature, profile.at(time)) + unit.power.sum(), x=time)
    # Simpson's error: (dt / shortest time constant)^4 / 180 = 1e-8 of some 1e5 J
    assert_allclose(stored[-1] - stored[0], brought, atol=1e-2)


def test_a_long_time_leads_to_the_steady_state():
    unit = experiment.in_unit()
    end = unit.steady_state(-10.0)
    temperature, rate = unit.solve([0, 40 * unit.time_constants[0]], network.soak(-10.0))
    assert_allclose(temperature[-1], end, atol=1e-11)
    assert_allclose(rate[-1], 0, atol=1e-14)
    # all the heat goes to the chamber
    assert_allclose(unit.heat_from_chamber(end, -10.0), -unit.power.sum(), rtol=1e-13)
    assert_allclose(unit.steady_state(7.0, powered=False), 7.0, rtol=1e-14)


@given(shift=st.floats(-50, 50), hold=st.floats(10, 3000))
def test_a_warmer_chamber_shifts_everything(shift, hold):
    time = np.linspace(0, 4000, 9)
    cold, cold_rate = experiment.in_unit().solve(time, network.steps([0, 30], hold=hold, rate=0.1))
    warm, warm_rate = experiment.in_unit().solve(time, network.steps([shift, 30 + shift], hold=hold, rate=0.1))
    assert_allclose(warm - cold, shift, atol=1e-11)
    assert_allclose(warm_rate, cold_rate, atol=1e-13)


def test_the_gyro_alone_is_symmetric_and_in_the_unit_not():
    profile = network.ramp(-40, 60, rate=0.02)
    for net, equal in ((experiment.alone(), True), (experiment.in_unit(), False)):
        temperature, _ = net.solve(TIME, profile)
        top, bottom = (temperature[:, net.nodes.index(f"coil_{face}")] for face in ("top", "bottom"))
        assert (np.abs(top - bottom).max() < 1e-10) == equal
    assert np.abs(top - bottom).max() > 1


def test_profiles():
    steps = network.steps([0, 10], hold=5.0)
    assert_allclose(steps.at([-1, 0, 4.9, 5, 20]), [0, 0, 0, 10, 10])
    ramped = network.steps([0, 10], hold=5.0, rate=2.0)
    assert_allclose(ramped.at([5, 7.5, 10]), [0, 5, 10])
    assert_allclose(ramped.line([4, 6, 10])[1], [0, 2, 0])
    wave = network.sine(1.0, 2.0, period=48.0, duration=100.0, begin=10.0)
    time = np.linspace(10, 110, 1001)
    # sagitta of an arc of 1/48 of a period
    assert_allclose(wave.at(time), 1 + 2 * np.sin(2 * np.pi * (time - 10) / 48), atol=2 * (np.pi / 48) ** 2 / 2)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: Profile(times=[0, 1], temperatures=[1]), "`temperatures` must be as many as `times`, got 1 and 2"),
        (lambda: Profile(times=[0, 2, 1], temperatures=[1, 2, 3]), "`times` must not decrease, got 1.0 s after 2.0 s"),
        (lambda: network.ramp(0, 1, rate=0), "`rate`"),
        (lambda: network.steps([0, 1], hold=1, rate=-1), "`rate`"),
        (lambda: ThermalNetwork(capacities={"chamber": 1}, conductances={}), "'chamber', whose temperature"),
        (lambda: ThermalNetwork(capacities={"a": 0}, conductances={}), r"`capacities\['a'\]`"),
        (lambda: ThermalNetwork(capacities={"a": 1}, conductances={}), r"no path from \['a'\]"),
        (lambda: ThermalNetwork(capacities={"a": 1}, conductances={("a", "b"): 1}), "'a', 'chamber', got 'b'"),
        (lambda: ThermalNetwork(capacities={"a": 1}, conductances={("a", "a"): 1}), "again or alone"),
        (lambda: ThermalNetwork(capacities={"a": 1}, conductances={}, heat={"b": 1}), "`heat`"),
        (lambda: BODY.solve([0, 0], network.soak(1)), "`time` must increase"),
        (lambda: BODY.solve([0, 1], network.soak(1), start=[1, 2]), "`start`"),
    ],
)
def test_bad_input_is_named(call, words):
    with pytest.raises(ValueError, match=words):
        call()


def test_a_pair_named_twice_is_refused():
    both = {("a", "chamber"): 1, ("chamber", "a"): 1}
    with pytest.raises(ValueError, match="each pair"):
        ThermalNetwork(capacities={"a": 1}, conductances=both)
