import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy import integrate, signal

from fogkit.noise import PROCESSES, RandomErrors, allan_deviation, processes, quantize, simulate
from fogkit.noise.allan import octaves
from fogkit.noise.increments import flicker_covariance
from fogkit.noise.processes import embedding
from fogkit.units import ARCSEC, DEG_PER_HOUR, DEG_PER_SQRT_HOUR, HOUR

EACH = [RandomErrors(**{name: 0.7}) for name in PROCESSES]
ALL = RandomErrors(angle_random_walk=1.0, bias_instability=0.5, rate_random_walk=0.1, rate_ramp=0.01, quantization=2.0)


# ---- closed forms


def test_allan_variance_by_hand():
    tau = 4.0
    by_hand = 1 / 4 + 2 * np.log(2) / np.pi * 0.25 + 0.01 * 4 / 3 + 1e-4 * 16 / 2 + 3 * 4 / 16
    assert_allclose(ALL.allan_variance(tau), by_hand, rtol=1e-15)
    assert ALL.allan_variance(np.ones((2, 3))).shape == (2, 3)


@pytest.mark.parametrize("errors", EACH[:3], ids=PROCESSES[:3])
@pytest.mark.parametrize("tau", [0.1, 30.0])
def test_allan_variance_is_the_integral_of_the_spectrum(errors, tau):
    # IEEE 952, annex C: 4 times the integral of the two-sided spectrum from 0, times sin^4 / x^2 of x = pi f tau
    def integrand(x):
        return float(errors.power_spectral_density(x / (np.pi * tau))) * np.sin(x) ** 4 / x**2 / (np.pi * tau)

    pieces = [integrate.quad(integrand, k * np.pi, (k + 1) * np.pi, limit=200)[0] for k in range(1, 400)]
    total = integrate.quad(integrand, 1e-9, np.pi, limit=200)[0] + sum(pieces)
    # cut off at x = 400 pi, where white noise has (3/8) / x of an integral of pi/4 left: 4e-4
    assert_allclose(4 * total, errors.allan_variance(tau), rtol=5e-4)


def test_spectrum_of_quantization_is_that_of_the_samples():
    dt, Q = 0.01, 3.0
    rate = simulate(RandomErrors(quantization=Q), 2**18, dt, np.random.default_rng(1))
    f, density = signal.welch(rate, 1 / dt, nperseg=256, detrend=False)
    inside = slice(4, -4)  # the window smears the steep ends
    expected = RandomErrors(quantization=Q).power_spectral_density(f[inside], dt)
    # some 2000 segments: 2 % each, of 120 frequencies
    assert_allclose(density[inside] / 2, expected, rtol=4.5 * 0.022 * 1.4)


def test_spectrum_of_a_sum_is_the_sum_of_spectra():
    f = np.array([0.1, 1.0])
    parts = [errors.power_spectral_density(f, 0.1) for errors in EACH]
    together = RandomErrors(**dict.fromkeys(PROCESSES, 0.7)).power_spectral_density(f, 0.1)
    assert_allclose(together, np.sum(parts, axis=0), rtol=1e-15)
    assert_array_equal(parts[3], 0)  # the ramp has none


def test_squares_there_and_back():
    assert RandomErrors.from_squares(ALL.squares) == ALL
    assert_allclose(RandomErrors(rate_ramp=-2.0).squares, [0, 0, 0, 4, 0])


def test_tables_and_text():
    errors = RandomErrors(angle_random_walk=0.001 * DEG_PER_SQRT_HOUR, quantization=2 * ARCSEC)
    table = errors.to_frame("gyro")
    assert_allclose(table.value, [0.001, 0, 0, 0, 2], rtol=1e-15)
    assert table.unit.tolist() == ["deg/sqrt(h)", "deg/h", "deg/h/sqrt(h)", "deg/h/h", "arcsec"]
    assert_allclose(errors.to_frame().value["quantization"], 2 * ARCSEC, rtol=1e-15)
    assert RandomErrors.from_json(errors.to_json()) == errors
    rows = RandomErrors(rate_random_walk=1.0).to_frame("accelerometer")
    # 1 m/s^2/sqrt(s) over an hour is sqrt(3600) m/s^2, in micro-g 60 / 9.80665e-6
    assert_allclose(rows.value["rate_random_walk"], 60 / 9.80665e-6, rtol=1e-12)


# ---- simulation


def test_flicker_covariance_gives_the_closed_form_of_the_allan_variance_at_every_time():
    # The angle's second difference at step m is a sum of increments of the simulated means, with triangular weights:
    # its variance from their covariance, over 2 m^2, is the Allan variance
    for m in (1, 2, 3, 10, 100, 1000):
        weights = m - np.abs(np.arange(1 - m, m))
        lags = np.arange(2 * m - 1)
        spectrum = np.correlate(weights, weights, "full")[2 * m - 2 :]
        covariance = flicker_covariance(1, 1, lags.astype(float)) / (2 * np.pi)
        variance = spectrum[0] * covariance[0] + 2 * np.sum(spectrum[1:] * covariance[1:])
        assert_allclose(variance / (2 * m**2), 2 * np.log(2) / np.pi, rtol=1e-9)  # m^3 terms that cancel to m^2


@pytest.mark.parametrize("half", [1, 2, 3, 10, 999, 1000, 2**17])
def test_embedding_is_exact_and_not_negative(half):
    spectrum = embedding(half)
    assert spectrum.min() > 0
    covariance = np.fft.irfft(spectrum, 2 * half)[: half + 1]
    # rounding of a transform whose largest value is about 1
    assert_allclose(covariance, flicker_covariance(1, 1, np.arange(half + 1.0)) / (2 * np.pi), atol=1e-13)


def test_an_embedding_that_is_negative_is_refused(monkeypatch):
    monkeypatch.setattr(processes, "flicker_covariance", lambda m, n, lag: np.cos(lag) - 2.0)
    with pytest.raises(ArithmeticError, match="10 flicker increments has the eigenvalue -"):
        embedding(10)


@pytest.mark.parametrize("count", [2, 3, 4, 5, 7])
def test_flicker_increments_have_their_covariance(count):
    # all covariances of short records, from many of them
    runs = 20_000
    rate = simulate(RandomErrors(bias_instability=1.0), count, 0.3, np.random.default_rng(2), channels=runs)
    assert_array_equal(rate[0], 0)
    increments = np.diff(rate, axis=0)
    lags = np.abs(np.subtract.outer(np.arange(count - 1), np.arange(count - 1)))
    expected = flicker_covariance(1, 1, lags.ravel().astype(float)).reshape(lags.shape) / (2 * np.pi)
    # 4.5 sigma of a covariance from so many runs: 1 in 10^5, and there are some 50
    assert_allclose(increments @ increments.T / runs, expected, atol=4.5 * expected[0, 0] * np.sqrt(2 / runs))


def test_walk_means_have_the_covariance_of_the_integrated_wiener_process():
    runs, count = 40_000, 4
    rate = simulate(RandomErrors(rate_random_walk=2.0), count, 0.25, np.random.default_rng(3), channels=runs)
    # the mean of min(s, t) over two intervals: dt (k + 1/2) for the earlier one k, and dt (k + 1/3) for one with itself
    first = np.minimum.outer(np.arange(count), np.arange(count))
    expected = 4 * 0.25 * (first + 0.5 - np.eye(count) / 6)
    deviation = np.sqrt((expected**2 + np.outer(np.diagonal(expected), np.diagonal(expected))) / runs)
    assert (np.abs(rate @ rate.T / runs - expected) < 4.5 * deviation).all()


@pytest.mark.parametrize("errors", EACH, ids=PROCESSES)
def test_allan_variance_of_records_is_the_closed_form_at_every_octave(errors):
    dt, runs = 0.2, 300
    rate = simulate(errors, 2048, dt, np.random.default_rng(4), channels=runs)
    allan = allan_deviation(rate, dt)
    variance = allan.variance
    # 4.5 sigma of the mean over runs, by their own scatter; rounding of a ramp, which has no scatter
    deviation = variance.std(axis=1, ddof=1) / np.sqrt(runs)
    expected = errors.allan_variance(allan.tau)
    assert (np.abs(variance.mean(axis=1) - expected) < 4.5 * deviation + 1e-11 * expected).all()


def test_processes_add_up_and_channels_are_independent():
    rng = np.random.default_rng(5)
    rate = simulate(ALL, 4096, 0.5, rng, channels=60)
    allan = allan_deviation(rate, 0.5, averaging=octaves(4096)[:9])
    deviation = allan.variance.std(axis=1, ddof=1) / np.sqrt(60)
    assert (np.abs(allan.variance.mean(axis=1) - ALL.allan_variance(allan.tau)) < 4.5 * deviation).all()
    white = simulate(RandomErrors(angle_random_walk=1.0), 10_000, 1.0, rng, channels=3)
    correlation = np.corrcoef(white.T) - np.eye(3)
    assert np.abs(correlation).max() < 4.5 / np.sqrt(10_000)  # of a correlation from so many samples


def test_ramp_starts_at_zero_and_means_are_mid_sample():
    rate = simulate(RandomErrors(rate_ramp=-0.5), 3, 2.0, np.random.default_rng(1))
    assert_allclose(rate, [-0.5, -1.5, -2.5], rtol=1e-15)


def test_same_generator_same_record():
    one, two = (simulate(ALL, 100, 1.0, np.random.default_rng(6)) for _ in range(2))
    assert_array_equal(one, two)
    assert simulate(RandomErrors(bias_instability=1.0), 1, 1.0, np.random.default_rng(1)) == 0
    assert_array_equal(simulate(RandomErrors(), 5, 1.0, np.random.default_rng(1)), np.zeros(5))


# ---- quantiser


def test_quantised_angle_is_never_off_by_more_than_half_a_step():
    rng = np.random.default_rng(7)
    rate = rng.standard_normal((5000, 2))
    quantised = quantize(rate, 0.1, 0.03)
    error = np.cumsum(quantised - rate, axis=0) * 0.1
    assert np.abs(error).max() <= 0.015 * (1 + 1e-9)  # rounding of the sums
    steps = quantised * 0.1 / 0.03
    assert_allclose(steps, np.rint(steps), atol=1e-9)


def test_busy_quantiser_has_the_allan_variance_of_its_coefficient():
    # a rate that moves the angle by several steps a sample, off any rational number of them
    step, dt = 1e-5, 0.01
    walk = RandomErrors(angle_random_walk=3 * step / np.sqrt(dt))  # three steps of noise a sample
    rate = simulate(walk, 2**17, dt, np.random.default_rng(8)) + 123.456 * step / dt
    allan = allan_deviation(quantize(rate, dt, step) - rate, dt, averaging=[1, 2, 4, 8, 16])
    expected = RandomErrors(quantization=step / np.sqrt(12)).allan_variance(allan.tau)
    # 4 sigma: each variance from 2**17 differences of a white sequence, neighbours correlated (35/18 as many at worst)
    assert_allclose(allan.variance, expected, rtol=4 * np.sqrt(2 * 35 / 18 / 2**17))


def test_idle_quantiser_has_not():
    rate = np.full(10_000, 1e-4)  # an angle that moves a step in 10_000 samples
    assert np.count_nonzero(quantize(rate, 1.0, 1.0)) == 1


@given(st.integers(-50, 50), st.floats(0.01, 10))
def test_whole_steps_pass_a_quantiser(count, step):
    assert_allclose(quantize([count * step / 0.5] * 3, 0.5, step), count * step / 0.5, rtol=1e-12)


# ---- bad input


@pytest.mark.parametrize(
    ("call", "kind", "words"),
    [
        (
            lambda: RandomErrors(angle_random_walk=-1.0),
            ValueError,
            "`angle_random_walk` must be finite and >= 0 rad/sq",
        ),
        (lambda: RandomErrors(rate_ramp=np.inf), ValueError, r"`rate_ramp` must be finite, in rad/s\^2, got inf"),
        (lambda: RandomErrors.from_squares([-1, 0, 0, 0, 0]), ValueError, "`squares` must be in"),
        (lambda: ALL.allan_variance([1.0, 0.0]), ValueError, "`tau` must be > 0 s, got 0.0"),
        (lambda: ALL.power_spectral_density(1.0), ValueError, "`dt` must be given for errors with quantization"),
        (lambda: ALL.to_frame("imperial"), ValueError, "`units` must be one of 'si', 'gyro', 'accelerometer'"),
        (lambda: simulate(None, 1, 1.0, None), TypeError, "`errors` must be a RandomErrors"),
        (lambda: simulate(ALL, 10, 1.0, 5), TypeError, "`rng` must be a numpy.random.Generator"),
        (lambda: simulate(ALL, 0, 1.0, None), ValueError, "`count` must be an integer >= 1"),
        (lambda: simulate(ALL, 10, 0.0, None), ValueError, "`dt` must be finite and > 0 s"),
        (lambda: quantize(np.ones((2, 2, 2)), 1.0, 1.0), ValueError, r"`rate` must be of shape \(n,\)"),
        (lambda: quantize([1.0], 1.0, -1.0), ValueError, "`step` must be finite and > 0 rad"),
    ],
)
def test_bad_input(call, kind, words):
    with pytest.raises(kind, match=words):
        call()


def test_datasheet_example():
    gyro = RandomErrors(angle_random_walk=0.01 * DEG_PER_SQRT_HOUR)
    assert_allclose(np.sqrt(gyro.allan_variance(HOUR)) / DEG_PER_HOUR, 0.01, rtol=1e-14)  # what the unit means
