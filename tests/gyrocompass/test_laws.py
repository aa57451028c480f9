"""Laws of the mount: rates against differences of angles, ends, checks; the angle sensor against its definition."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from fogkit.gyrocompass import gyro_range, mechanisation
from fogkit.gyrocompass.encoder import Encoder, UnsteadyLaw
from fogkit.gyrocompass.laws import ConstantSpeedReversal, DwellAndTurn, Fixed, OneWay, QuasiHarmonic
from fogkit.units import DEG, DEG_PER_SECOND

LAWS = {
    "harmonic": QuasiHarmonic(amplitude=1.9, period=40.0, centre=0.3, phase=0.4),
    "reversal": ConstantSpeedReversal(amplitude=2.5, period=30.0, reversal_time=4.0, centre=-0.2),
    "longest reversal": ConstantSpeedReversal(amplitude=2.5, period=30.0, reversal_time=15.0),
    "dwell": DwellAndTurn(positions=(0.0, 2.0, -1.5), dwell=7.0, turn_duration=4.0),
    "one way": OneWay(period=20.0, clockwise=True, start=0.1),
    "unsteady": UnsteadyLaw(law=QuasiHarmonic(amplitude=3.0, period=50.0), fraction=0.3, order=4, phase=0.6),
    "fixed": Fixed(position=0.7),
}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@given(t=st.floats(-100.0, 200.0))
def test_rates_and_accelerations_are_derivatives(law, t):
    h = 1e-4
    before, now, after = (np.array(law.motion(np.array(t + k * h))) for k in (-1, 0, 1))
    # truncation h**2/6 of a third derivative, below 1e-8; acceleration may jump within the step: h times its jump
    assert_allclose((after[0] - before[0]) / (2 * h), now[1], atol=2e-4)
    tangent = (after[1] - before[1]) / (2 * h)
    assert min(before[2], now[2], after[2]) - 1e-3 <= tangent <= max(before[2], now[2], after[2]) + 1e-3


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_largest_rate_and_period(law):
    t = np.linspace(0, law.period, 20001)
    highest = np.abs(law.rate(t)).max()
    assert highest <= law.max_rate * (1 + 1e-12)
    if not isinstance(law, UnsteadyLaw):  # that bound needs the departure and the law at their largest at once
        assert_allclose(highest, law.max_rate, rtol=1e-5)  # a point lies within 1/20000 of a period of the peak
    turns = (law.angle(t + law.period) - law.angle(t)) / (2 * np.pi)
    assert_allclose(turns, -1.0 if isinstance(law, OneWay) else 0.0, atol=1e-12)


def test_ends():
    law = LAWS["reversal"]
    angle = law.angle(np.linspace(0, 30, 30001))
    assert_allclose([angle.min(), angle.max()], [-2.7, 2.3], atol=1e-12)
    assert_allclose(law.angle(0.0), -0.2, atol=1e-15)
    sharp = ConstantSpeedReversal(amplitude=np.pi, period=8.0)
    assert_allclose(sharp.angle([0.0, 1.0, 2.0, 3.0, 6.0]), np.pi * np.array([0, 0.5, 1, 0.5, -1]), atol=1e-15)
    dwell = LAWS["dwell"]
    assert_allclose(dwell.angle([0.0, 6.9, 11.0, 17.9, 22.0, 28.9, 32.999999]), [0, 0, 2, 2, -1.5, -1.5, 0], atol=1e-9)


def test_reversal_takes_its_time():
    law = LAWS["reversal"]
    t = np.linspace(0, law.period, 300001)[:-1]
    assert_allclose((law.motion(t)[2] != 0).mean() * law.period, 2 * 4.0, atol=1e-3)


def test_period_from_the_largest_rate():
    law = QuasiHarmonic.from_rate(np.pi / 2, 0.647)
    assert_allclose(law.max_rate, 0.647, rtol=1e-15)
    assert_allclose(law.period, 15.25, atol=0.01)  # the thesis rounds it to 15 s


def test_steadiness():
    law = UnsteadyLaw(law=OneWay(period=60.0), fraction=0.1, order=3)
    angle, rate, _ = law.motion(np.linspace(0, 60, 1001))
    commanded = law.law.angle(np.linspace(0, 60, 1001))
    assert_allclose(rate, 2 * np.pi / 60 * (1 + 0.1 * np.cos(3 * commanded)), rtol=1e-12)
    assert_allclose(angle[-1], 2 * np.pi, atol=1e-12)  # whole turns stay whole


def test_too_coarse():
    law = QuasiHarmonic(amplitude=np.pi, period=60.0)
    assert_allclose(law.sample_times(1.0, 0.25), [0, 0.25, 0.5, 0.75, 1.0])
    with pytest.raises(ValueError, match=r"`dt` must be at most 0.304 s .* 18.85 deg/s, got 1 s: 0.329 rad in a step"):
        law.sample_times(100.0, 1.0)
    with pytest.raises(ValueError, match="`duration` must be at least `dt`"):
        law.sample_times(0.1, 0.2)


def test_gyros_see_what_the_mechanisation_gives_them():
    law = QuasiHarmonic(amplitude=np.pi, period=20.0)
    hull = np.array([0.1, 0.05, 0.2])
    peaks = gyro_range.gyro_peaks(law, hull)
    rng = np.random.default_rng(3)
    signs = rng.choice([-1, 1], size=(4000, 3))
    seen = mechanisation.gyro_rates(signs * hull, rng.uniform(-np.pi, np.pi, 4000), signs[:, 1] * law.max_rate)
    highest = np.abs(seen).max(axis=0)
    assert (highest <= peaks * (1 + 1e-12)).all()
    assert_allclose(highest, peaks, rtol=1e-3)  # of 4000 angles one is within 0.01 rad of the worst: its square


def test_range():
    law = QuasiHarmonic(amplitude=np.pi, period=10.0)  # 113 deg/s, 65 of them on a gyro
    assert gyro_range.check_gyro_range(law, 80 * DEG_PER_SECOND).max() < 66 * DEG_PER_SECOND
    with pytest.raises(
        ValueError, match=r"keep gyro [xyz] within `gyro_range`, 40 deg/s, got up to 65.3 deg/s with Qu"
    ):
        gyro_range.check_gyro_range(law, 40 * DEG_PER_SECOND)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: QuasiHarmonic(amplitude=1.0, period=-60.0), "`period` must be finite and > 0 s, got -60.0"),
        (lambda: OneWay(period=-60.0), "direction of a turn is not in the sign"),
        (lambda: QuasiHarmonic(amplitude=0.0, period=60.0), "`amplitude` must be finite and > 0"),
        (lambda: QuasiHarmonic(amplitude=1e4, period=60.0), "`amplitude` must be in .*fogkit.units.DEG"),
        (lambda: ConstantSpeedReversal(amplitude=1.0, period=10.0, reversal_time=6.0), "`reversal_time` must be in"),
        (lambda: DwellAndTurn(positions=[0.0], dwell=1.0, turn_duration=1.0), "`positions` must be of at least|non-em"),
        (lambda: UnsteadyLaw(law=Fixed(), fraction=1.0), "`fraction` must be in"),
        (lambda: Encoder(delay=-1.0), "`delay` must be finite and >= 0"),
    ],
)
def test_bad_laws(make, words):
    with pytest.raises(ValueError, match=words):
        make()


def test_encoder_errors_one_by_one():
    law = QuasiHarmonic(amplitude=2.0, period=30.0)
    t = np.linspace(0, 60, 601)
    angle, rate, acceleration = law.motion(t)
    error = Encoder(offset=1e-3, harmonic=2e-3, order=2, phase=0.1).error(law, t)
    assert_allclose(error, 1e-3 + 2e-3 * np.sin(2 * angle + 0.1), atol=1e-15)
    late = Encoder(delay=0.01).error(law, t)
    assert_allclose(late, -0.01 * rate, atol=0.5 * 0.01**2 * np.abs(acceleration).max() * 1.01)  # next term of Taylor
    assert_allclose(Encoder(compliance=1e-3).error(law, t), -1e-3 * acceleration, atol=1e-15)
    assert_allclose(Encoder(backlash=2e-3).error(law, t), -1e-3 * np.sign(rate), atol=1e-15)


def test_encoder_noise():
    law, t = Fixed(position=1.0), np.zeros(20000)
    readings = Encoder(noise=0.01 * DEG).read(law, t, np.random.default_rng(1))
    assert_allclose(readings.std(), 0.01 * DEG, rtol=4 / np.sqrt(2 * 20000))  # 4 sigma
    with pytest.raises(TypeError, match=r"`rng` must be a numpy.random.Generator"):
        Encoder(noise=1e-3).read(law, t)
    assert_allclose(Encoder().read(law, t), 1.0)
