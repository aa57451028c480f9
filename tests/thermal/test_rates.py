"""Rates from sampled temperatures: exact on polynomials, with the noise and delay that are stated."""

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose
from scipy.signal import savgol_coeffs

from fogkit.thermal import rates
from fogkit.thermal.rates import RateFilter


def table(values, interval=2.0, **more):
    return pd.DataFrame(
        {"temperature_a": values, **more}, index=pd.Index(interval * np.arange(len(values)), name="time")
    )


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_weights_are_those_of_savitzky_and_golay(degree):
    for causal, pos in ((False, 10), (True, 20)):
        mine = RateFilter(window=42.0, degree=degree, causal=causal).weights(2.0)
        peer = savgol_coeffs(21, degree, deriv=1, delta=2.0, pos=pos, use="dot")
        assert_allclose(mine, peer, atol=1e-13)


def test_rates_of_polynomials_and_their_delay():
    time = 2.0 * np.arange(200)
    parabola = 3 + 0.1 * time + 1e-3 * time**2
    true = 0.1 + 2e-3 * time
    for degree, causal, delay in ((1, False, 0.0), (2, False, 0.0), (1, True, 20.0), (2, True, 0.0)):
        rate_filter = RateFilter(window=42.0, degree=degree, causal=causal)
        assert_allclose(rate_filter.delay(2.0), delay, atol=1e-10)
        rate = rate_filter.apply(parabola, 2.0)
        full = ~np.isnan(rate)
        assert full.sum() == 200 - 20
        assert_allclose(rate[full], true[full] - delay * 2e-3, rtol=1e-10)
    assert np.isnan(rate[:20]).all()  # causal: none before the window is full


def test_noise_of_rates_is_the_one_stated():
    noise = np.random.default_rng(1).standard_normal(200_000)
    line = RateFilter(window=60.0, causal=True)
    assert_allclose(line.noise_gain(2.0), np.sqrt(12 / (30 * (30**2 - 1))) / 2, rtol=1e-12)
    parabola = RateFilter(window=60.0, degree=2, causal=True)
    assert 3.5 < parabola.noise_gain(2.0) / line.noise_gain(2.0) < 4  # 4 for long windows
    for rate_filter in (line, parabola, RateFilter(window=60.0)):
        rate = rate_filter.apply(noise, 2.0)
        # 5 sigma of a deviation from 200 000 / 30 independent windows
        assert_allclose(np.nanstd(rate), rate_filter.noise_gain(2.0), rtol=5 / np.sqrt(2 * 200_000 / 30))


def test_reduce_keeps_linear_relations_whatever_the_window():
    # bias = 2 T + 50 dT/dt, fast compared with the window: exact but for the trapezoid of a sample, (w dt)^2 / 12
    omega, dt = 2 * np.pi / 400, 1.0
    time = dt * np.arange(4000)
    T, rate = np.sin(omega * time), omega * np.cos(omega * time)
    reduced = rates.reduce(table(T, dt, bias=2 * T + 50 * rate), 200.0)
    expected = 2 * reduced.temperature_a + 50 * reduced.rate_a
    assert_allclose(reduced.bias, expected, atol=50 * omega * (omega * dt) ** 2 / 12)
    assert reduced.rate_a.abs().max() < 0.7 * omega  # and the window does smooth
    assert_allclose(reduced.index, 99.5 + 200 * np.arange(20))


def test_noise_of_reduced_rows():
    rng = np.random.default_rng(2)
    reduced = rates.reduce(table(rng.standard_normal(300_000)), 24.0)
    temperature, rate = rates.row_noise(1.0, 2.0, 24.0)
    tolerance = 5 / np.sqrt(2 * len(reduced))  # 5 sigma of a deviation
    assert_allclose(reduced.temperature_a.std(), temperature, rtol=tolerance)
    assert_allclose(reduced.rate_a.std(), rate, rtol=tolerance)
    # one is even in the window, the other odd: independent, and so are rows
    assert abs(np.corrcoef(reduced.temperature_a, reduced.rate_a)[0, 1]) < 5 / np.sqrt(len(reduced))
    assert abs(reduced.temperature_a.autocorr()) < 5 / np.sqrt(len(reduced))
    assert_allclose(rates.mean_noise_gain(400) * 20, np.sqrt(1.2), rtol=1e-4)


def test_add_rates_drops_rows_without_a_full_window():
    added = rates.add_rates(table(np.arange(50.0)), RateFilter(window=10.0))
    assert list(added.index[[0, -1]]) == [4.0, 94.0]
    assert_allclose(added.rate_a, 0.5, rtol=1e-12)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: rates.reduce(table(np.arange(9.0)).drop(4.0), 6.0), "`table` must be equally sampled"),
        (lambda: rates.reduce(table(np.arange(9.0)).iloc[::-1], 6.0), "`table` must be equally sampled"),
        (lambda: rates.reduce(table([1.0, np.nan, 2.0, 3.0]), 6.0), "`temperature_a` must be finite, got nan"),
        (lambda: rates.add_rates(table([1.0, np.nan, 2, 3]), RateFilter(window=6)), "`temperature_a` must be finite"),
        (lambda: rates.reduce(table(np.arange(9.0)), 4.0), "`window` must hold 3 to 9 samples of 2 s, got 4 s"),
        (lambda: rates.reduce(table(np.arange(9.0)), 40.0), "`window` must hold 3 to 9 samples"),
        (lambda: rates.reduce(table(np.arange(9.0)).rename(columns={"temperature_a": "b"}), 6.0), "temperature_"),
        (lambda: RateFilter(window=2.0, degree=2, causal=True).weights(1.0), "`window` must be longer than 2 s"),
        (lambda: RateFilter(window=20.0).apply(np.arange(5.0), 1.0), "`values` must fill the window of 21 samples"),
        (lambda: RateFilter(window=-1.0), "`window`"),
        (lambda: RateFilter(window=1.0, degree=0), "`degree`"),
    ],
)
def test_bad_input_is_named(call, words):
    with pytest.raises(ValueError, match=words):
        call()
