"""Bounds of heading against least squares of three gyros' readings, and against closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import j0, jv

from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass import accuracy, frames, mechanisation
from fogkit.gyrocompass.encoder import Encoder, UnsteadyLaw
from fogkit.gyrocompass.laws import ConstantSpeedReversal, DwellAndTurn, Fixed, OneWay, QuasiHarmonic
from fogkit.units import ARCMIN, DEG, DEG_PER_HOUR, DEG_PER_SQRT_HOUR

LAT, NOISE = 60 * DEG, 0.0176 * DEG_PER_SQRT_HOUR
IDEAL = NOISE / (EARTH_RATE * np.cos(LAT) * np.sqrt(300.0))


def readings(law, t, x):
    """Readings of the three gyros at rest: `x` is heading at the end, heading rate, biases, scale factors."""
    heading = x[0] + x[1] * (t - t[-1])
    C_h_g = frames.hull_attitude(heading, 0.0, 0.0)
    hull = C_h_g.swapaxes(-1, -2) @ mechanisation.geographic_rate(LAT, np.zeros(3)) - np.array([0, 1, 0]) * x[1]
    return mechanisation.gyro_rates(hull, law.angle(t), law.rate(t)) * (1 + x[5:]) + x[2:5]


def by_least_squares(law, duration, free, priors=(), steps=3000, heading=0.7):
    """Standard deviation of heading from the normal equations of sampled readings, with numerical derivatives."""
    dt = duration / steps
    t = dt * (np.arange(steps) + 0.5)
    x0, step = np.zeros(8), np.array([1e-4, 1e-6, *[1e-6] * 3, *[1e-4] * 3])
    x0[0] = heading
    columns = []
    for k in free:
        e = step * np.eye(8)[k]
        columns.append(((readings(law, t, x0 + e) - readings(law, t, x0 - e)) / (2 * step[k])).ravel())
    A = np.array(columns).T * np.sqrt(dt) / NOISE
    rows = [np.eye(len(free))[list(free).index(k)] / std for k, std in dict(priors).items()]
    A = np.vstack([A, *rows])
    scale = np.linalg.norm(A, axis=0)
    return float(np.sqrt(np.linalg.inv((A / scale).T @ (A / scale))[0, 0]) / scale[0])


BIASES, SCALES = (2, 3, 4), (5, 6, 7)
LAWS = {
    "half a turn": QuasiHarmonic(amplitude=np.pi / 2, period=60.0),
    "thesis": QuasiHarmonic(amplitude=np.pi, period=60.0),
    "off centre": QuasiHarmonic(amplitude=1.1, period=75.0, centre=0.5, phase=0.3),
    "reversal": ConstantSpeedReversal(amplitude=2.0, period=50.0, reversal_time=5.0),
    "two positions": DwellAndTurn(dwell=20.0, turn_duration=10.0),
}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_bound_against_least_squares_of_three_gyros(law):
    # sums over 3000 steps against means over 4096 points: the square of the step's angle over 24, 1e-4 at most.
    # The up bias is free as well: a hull that is known to stand still takes it out of heading.
    bound = accuracy.heading_bound(law, 300.0, LAT, NOISE)
    assert_allclose(bound.std, by_least_squares(law, 300.0, (0, *BIASES)), rtol=1e-4)
    assert_allclose(bound.std, by_least_squares(law, 300.0, (0, *BIASES), heading=2.6), rtol=1e-4)  # any heading
    assert_allclose(bound.std, IDEAL / np.sqrt(bound.efficiency), rtol=1e-12)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_scale_factors_cost_nothing_over_whole_periods(law):
    # the rate of the mount is the derivative of its angle: over whole periods it has no mean with exp(i beta)
    with_them = by_least_squares(law, 300.0, (0, *BIASES, *SCALES))
    assert_allclose(with_them, accuracy.heading_bound(law, 300.0, LAT, NOISE).std, rtol=1e-3)


def test_bound_of_a_heading_that_may_drift():
    law = QuasiHarmonic(amplitude=1.1, period=170.0, centre=0.5, phase=0.3)  # not the same from its end
    # heading rate and up bias come together: with the heading rate read off the up gyro its bias is what is not known
    for std in (np.inf, 5 * DEG_PER_HOUR):
        priors = () if std == np.inf else ((1, std),)
        # up components of the gyros are weighed out by a prior-free up bias, as the drift is that of the up gyro
        truth = by_least_squares(law, 300.0, (0, 1, *BIASES), priors)
        assert_allclose(accuracy.heading_bound(law, 300.0, LAT, NOISE, drift_std=std).std, truth, rtol=1e-3)
    free = accuracy.heading_bound(OneWay(period=60.0), 600.0, LAT, NOISE, drift_std=np.inf).std
    known = accuracy.heading_bound(OneWay(period=60.0), 600.0, LAT, NOISE).std
    assert_allclose(free / known, 2.0, rtol=0.01)  # the end of a fitted line, but for the biases' share of the line


def test_bound_with_known_biases():
    fixed = accuracy.heading_bound(Fixed(), 300.0, LAT, NOISE, bias_std=0.1 * DEG_PER_HOUR)
    level = EARTH_RATE * np.cos(LAT)
    assert_allclose(fixed.std, np.hypot(IDEAL, 0.1 * DEG_PER_HOUR / level), rtol=1e-9)
    assert accuracy.heading_bound(Fixed(), 300.0, LAT, NOISE).std == np.inf
    assert_allclose(accuracy.heading_bound(Fixed(), 300.0, LAT, NOISE, bias_std=0).std, IDEAL, rtol=1e-12)
    truth = by_least_squares(LAWS["reversal"], 300.0, (0, *BIASES), [(k, 1 * DEG_PER_HOUR) for k in BIASES])
    bound = accuracy.heading_bound(LAWS["reversal"], 300.0, LAT, NOISE, bias_std=1 * DEG_PER_HOUR)
    assert_allclose(bound.std, truth, rtol=1e-4)


@pytest.mark.parametrize("amplitude", [0.3, np.pi / 2, 2.404825557695773, np.pi, 7.0])
def test_means_in_closed_form(amplitude):
    harmonic = accuracy.mean_direction(QuasiHarmonic(amplitude=amplitude, period=60.0))
    assert_allclose(harmonic, j0(amplitude), atol=1e-12)  # the midpoint rule on a period of a smooth function
    reversal = accuracy.mean_direction(ConstantSpeedReversal(amplitude=amplitude, period=60.0))
    assert_allclose(reversal, np.sin(amplitude) / amplitude, atol=2e-6)  # here it has the square of the step


def test_best_amplitude():
    best = accuracy.best_harmonic_amplitude()

    def std(amplitude):
        return accuracy.heading_bound(QuasiHarmonic(amplitude=amplitude, period=60.0), 300.0, LAT, NOISE).std

    assert_allclose(std(best), IDEAL, rtol=1e-9)
    assert min(std(best - 0.1), std(best + 0.1)) > IDEAL * 1.001
    # what the thesis recommends and what it uses: 13.4 and 5.0 per cent above the least
    assert_allclose(std(np.pi / 2) / IDEAL, 1 / np.sqrt(1 - j0(np.pi / 2) ** 2), rtol=1e-9)
    assert_allclose(std(np.pi) / IDEAL, 1 / np.sqrt(1 - j0(np.pi) ** 2), rtol=1e-9)


def test_period_does_not_matter_for_white_noise():
    slow, fast = (accuracy.heading_bound(QuasiHarmonic(amplitude=2.0, period=p), 300.0, LAT, NOISE) for p in (150, 5))
    assert_allclose(slow.std, fast.std, rtol=1e-9)


def test_noise_of_other_spectra():
    law = QuasiHarmonic(amplitude=2.0, period=10.0)
    white = accuracy.steady_heading_std(law, 300.0, LAT, lambda f: np.full_like(f, NOISE**2))
    assert_allclose(white, accuracy.heading_bound(law, 300.0, LAT, NOISE).std, rtol=1e-9)
    # rate random walk, K**2/(2 pi f)**2: in closed form by Bessel functions
    walk = 1e-7
    k = np.arange(1, 60)
    information = (
        300.0 * (EARTH_RATE * np.cos(LAT)) ** 2 * 2 * (jv(k, 2.0) ** 2 * (2 * np.pi * k / 10 / walk) ** 2).sum()
    )
    std = accuracy.steady_heading_std(law, 300.0, LAT, lambda f: (walk / (2 * np.pi * f)) ** 2)
    assert_allclose(std, information**-0.5, rtol=1e-9)
    with pytest.raises(ValueError, match="`duration` must be at least five periods"):
        accuracy.steady_heading_std(law, 40.0, LAT, lambda f: f)
    with pytest.raises(ValueError, match="`spectrum` must be above 0"):
        accuracy.steady_heading_std(law, 60.0, LAT, lambda f: 0 * f)


def test_rate_random_walk_against_generalised_least_squares():
    law, dt = QuasiHarmonic(amplitude=2.0, period=20.0), 0.5
    t = dt * (np.arange(800) + 0.5)
    walk = 2e-7
    covariance = NOISE**2 / dt * np.eye(800) + walk**2 * np.minimum.outer(t, t)
    signal = EARTH_RATE * np.cos(LAT) * np.exp(1j * law.angle(t))
    whitened = np.linalg.solve(np.linalg.cholesky(covariance), np.stack([signal, np.ones(800), 1j * np.ones(800)]).T)
    std = np.sqrt(np.linalg.inv((whitened.conj().T @ whitened).real)[0, 0])
    steady = accuracy.steady_heading_std(law, 400.0, LAT, lambda f: NOISE**2 + (walk / (2 * np.pi * f)) ** 2)
    # a spectrum of lines is right for many periods: an edge of 20 of them counts a few per cent
    assert_allclose(steady, std, rtol=0.03)


def test_tilt_under_any_law():
    # an east drift of omega sin(lat) tilt over the level rate
    assert_allclose(accuracy.accelerometer_share(LAT, 1e-3), 1e-3 * np.tan(LAT), rtol=1e-15)


def heading_by_three_gyros(law, encoder, steps=12000):
    """Heading less the true one, from readings at rest fitted with the angle and rate that the encoder gives."""
    t = 300.0 * (np.arange(steps) + 0.5) / steps
    x = np.array([0.7, 0, 0, 0, 0, 0, 0, 0])
    truth = readings(law, t, x)
    wrong = law.angle(t) + encoder.error(law, t)

    def fitted(heading):
        C_h_g = frames.hull_attitude(heading, 0.0, 0.0)
        hull = np.tile(C_h_g.T @ mechanisation.geographic_rate(LAT, np.zeros(3)), (steps, 1))
        return mechanisation.gyro_rates(hull, wrong, law.rate(t))

    slope = (fitted(0.7001) - fitted(0.6999)).ravel() / 2e-4
    residual = (truth - fitted(0.7)).ravel()
    A = np.column_stack([slope, *np.tile(np.eye(3), (steps, 1)).T])
    return np.linalg.lstsq(A / np.linalg.norm(A, axis=0), residual)[0][0] / np.linalg.norm(slope)


ENCODERS = {
    "offset": Encoder(offset=ARCMIN),
    "once a turn": Encoder(harmonic=ARCMIN, phase=np.pi / 2),
    "delay": Encoder(delay=0.01),
    "twist": Encoder(compliance=0.05 * ARCMIN),
}


@pytest.mark.parametrize("encoder", ENCODERS.values(), ids=ENCODERS)
@pytest.mark.parametrize("name", ["off centre", "reversal"])
def test_encoder_share_against_a_fit_of_three_gyros(name, encoder):
    truth = heading_by_three_gyros(LAWS[name], encoder)
    # the square of the error, at most 11 arcmin or 3e-3 rad for the delay: 1e-5; sums as above
    assert_allclose(accuracy.encoder_share(LAWS[name], encoder, 300.0), truth, atol=1e-5, rtol=1e-3)


def test_hard_reversals_cost_no_heading():
    hard = ConstantSpeedReversal(amplitude=np.pi, period=60.0, reversal_time=0.2)
    gentle = LAWS["thesis"]
    for encoder in (ENCODERS["delay"], ENCODERS["twist"], Encoder(backlash=6 * ARCMIN)):
        # delay, 11 arcmin at the largest rate: none of it but the square of the sum's step
        for law in (hard, gentle):
            assert abs(accuracy.encoder_share(law, encoder, 300.0)) < 0.01 * ARCMIN
    eccentric = ENCODERS["once a turn"]
    assert abs(accuracy.encoder_share(gentle, eccentric, 300.0)) > 0.1 * ARCMIN
    assert abs(accuracy.encoder_share(hard, eccentric, 300.0)) < 0.01 * ARCMIN
    # an unsteady speed is no error of the angle, but another law: its mean direction alone counts
    unsteady = UnsteadyLaw(law=hard, fraction=0.05)
    known = accuracy.heading_bound(unsteady, 300.0, LAT, NOISE)
    assert_allclose(known.std, IDEAL, rtol=1e-3)
    with pytest.raises(ValueError, match="`law` must turn the mount"):
        accuracy.encoder_share(Fixed(), eccentric, 300.0)


def test_bad_input():
    law = LAWS["thesis"]
    with pytest.raises(ValueError, match=r"`lat` must be in .*not defined at a pole"):
        accuracy.heading_bound(law, 300.0, np.pi / 2, NOISE)
    with pytest.raises(ValueError, match="`angle_random_walk` must be finite and > 0"):
        accuracy.heading_bound(law, 300.0, LAT, 0.0)
    with pytest.raises(ValueError, match="`bias_std` must be finite and >= 0"):
        accuracy.heading_bound(law, 300.0, LAT, NOISE, bias_std=-1.0)
    with pytest.raises(TypeError, match="`law` must be a MountLaw"):
        accuracy.heading_bound("rocking", 300.0, LAT, NOISE)
