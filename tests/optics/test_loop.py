import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from fogkit.optics import BIAS_ORDERS, Loop, stable_gains

BASE = {"depth": 2.0, "half_period": 5e-6, "half_periods": 16}


def run_linear_loop(gain, second_gain, delay, steps=6000):
    """Largest late residual of the loop's difference equations, started by an impulse: no polynomial, no frequency."""
    feedback, second, waiting, late = 1.0, 0.0, [0.0] * delay, 0.0
    for i in range(steps):
        waiting.append(-feedback)
        acted_on = waiting.pop(0)
        second += second_gain * acted_on
        feedback += gain * acted_on + second
        if abs(feedback) > 1e6:
            return np.inf
        if i > 0.9 * steps:
            late = max(late, abs(feedback))
    return late


@pytest.mark.parametrize(("second_gain", "delay"), [(0, 0), (0, 1), (0, 3), (0.3, 0), (0.05, 1), (0.02, 3)])
def test_stable_gains_are_where_the_loop_itself_settles(second_gain, delay):
    low, high = stable_gains(second_gain, delay)
    for gain in (1.02 * high, *([0.9 * low] if low > 0 else [])):
        assert run_linear_loop(gain, second_gain, delay) > 1
    for gain in (0.97 * high, *([1.1 * low] if low > 0 else [])):
        assert run_linear_loop(gain, second_gain, delay) < 0.1


def test_without_second_integrator_the_limit_is_the_textbook_one():
    # integrator with d + 1 samples of delay: 2 sin(pi / (4 d + 2))
    for delay in range(6):
        assert_allclose(stable_gains(0, delay), (0, 2 * np.sin(np.pi / (4 * delay + 2))), rtol=1e-12)


def test_no_gain_is_stable_with_too_strong_a_second_integrator():
    assert np.isnan(stable_gains(5.0, 0)).all()
    with pytest.raises(ValueError, match=r"`gain`.*second_gain"):
        Loop(**BASE, gain=0.5, second_gain=5.0)


@given(gain=st.floats(0.05, 1.8), frequency=st.floats(1, 6000))
def test_closed_loop_response_is_that_of_the_fed_back_open_loop(gain, frequency):
    loop = Loop(**BASE, gain=gain)
    open_loop = loop.open_loop_response(frequency)
    assert_allclose(loop.closed_loop_response(frequency), open_loop / (1 + open_loop), rtol=1e-12)


def test_closed_loop_passes_a_constant_rate_whole():
    for parameters in ({}, {"gain": 0.4, "delay": 2}, {"gain": 0.5, "second_gain": 0.1}):
        assert Loop(**BASE, **parameters).closed_loop_response(0.0) == 1.0


@pytest.mark.parametrize("name", BIAS_ORDERS)
def test_named_orders_visit_both_states_alike(name):
    pattern = Loop(**BASE, bias_order=name).bias_pattern
    assert_array_equal(np.unique(pattern), [-1, 1])
    assert_array_equal(pattern.sum(axis=1), 0)


def test_orders_have_the_moments_that_they_are_named_for():
    times = np.arange(16)
    moments = {
        name: [Loop(**BASE, bias_order=name).bias_pattern[0] @ times**power for power in (1, 2)] for name in BIAS_ORDERS
    }
    assert moments["minus-plus"][0] == -moments["plus-minus"][0] == 8
    assert moments["mirrored"][0] == 0 and moments["mirrored"][1] != 0
    assert moments["balanced"] == [0, 0]


def test_an_order_may_be_given_state_by_state_and_the_loop_stays_hashable():
    loop = Loop(depth=2.0, half_period=5e-6, half_periods=4, bias_order=np.array([-1, 1, 1, -1]))
    assert loop == Loop(depth=2.0, half_period=5e-6, half_periods=4, bias_order=[[-1, 1, 1, -1]])
    assert isinstance(hash(loop), int)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("depth", {"depth": 0.0}),
        ("depth", {"depth": np.pi}),
        ("depth", {"depth": np.nan}),
        ("half_period", {"half_period": -1e-6}),
        ("half_periods", {"half_periods": 0}),
        ("half_periods", {"half_periods": 15}),
        ("half_periods", {"half_periods": 14, "bias_order": "mirrored"}),
        ("half_periods", {"half_periods": 12, "bias_order": "balanced"}),
        ("gain", {"gain": 0.0}),
        ("gain", {"gain": 2.0}),
        ("gain", {"gain": 1.01, "delay": 1}),
        ("gain", {"gain": 0.01, "second_gain": 0.05, "delay": 1}),
        ("second_gain", {"second_gain": -0.1}),
        ("delay", {"delay": -1}),
        ("bias_order", {"bias_order": "random"}),
        ("bias_order", {"bias_order": [1, -1]}),
        ("bias_order", {"bias_order": [1] * 16}),
        ("bias_order", {"bias_order": [2, -2] * 8}),
        ("v_pi_error", {"v_pi_error": np.inf}),
        ("depth * (1 + v_pi_error)", {"depth": 3.1, "v_pi_error": 0.05}),
    ],
)
def test_impossible_loops_are_refused_by_name(name, change):
    with pytest.raises(ValueError) as caught:
        Loop(**BASE | change)
    assert f"`{name}`" in str(caught.value)


def test_an_unstable_gain_is_told_the_allowed_range():
    with pytest.raises(ValueError, match=r"\(0, 2\).*got 2.5"):
        Loop(**BASE, gain=2.5)


@pytest.mark.parametrize(
    "change", [{"gain": 1.95}, {"gain": 0.97, "delay": 1}, {"gain": 0.054, "second_gain": 0.05, "delay": 1}]
)
def test_a_gain_near_the_limit_warns(change):
    with pytest.warns(UserWarning, match="within 5 % of a limit of stability"):
        Loop(**BASE | change)


def test_a_gain_well_inside_does_not_warn():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Loop(**BASE, gain=1.89)
        Loop(**BASE, gain=1e-3)
