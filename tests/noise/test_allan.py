import allantools
import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from fogkit.noise import AllanDeviation, RandomErrors, allan_deviation, simulate
from fogkit.noise.allan import octaves

WHITE = RandomErrors(angle_random_walk=1.0)


def nbs14():
    """The 1000 points of NIST Special Publication 1065, section 12.4, from their generator."""
    values = [1234567890]
    while len(values) < 1000:
        values.append(16807 * values[-1] % 2147483647)
    return np.array(values) / 2147483647


# ---- outside truth


def test_published_values():
    # NIST Special Publication 1065, table 31, printed with seven digits
    allan = allan_deviation(nbs14(), 1.0, averaging=[1, 10, 100])
    assert_allclose(allan.deviation, [2.922319e-01, 9.159953e-02, 3.241343e-02], rtol=0, atol=5.1e-8)


@pytest.mark.slow
def test_equals_allantools_on_ten_hours_at_100_hz():
    rng = np.random.default_rng(1)
    errors = RandomErrors(angle_random_walk=3e-7, bias_instability=1.5e-8, rate_random_walk=1e-10, quantization=1e-9)
    rate = simulate(errors, 3_600_000, 0.01, rng) + 7e-5  # and the Earth's rotation
    tau, deviation, _, differences = allantools.oadev(rate, rate=100.0, data_type="freq", taus="octave")
    allan = allan_deviation(rate, 0.01)
    assert_allclose(allan.tau, tau, rtol=1e-14)
    assert_array_equal(allan.differences, differences)
    assert_allclose(allan.deviation, deviation, rtol=1e-9)


def test_equals_the_sum_by_its_definition():
    rng = np.random.default_rng(2)
    rate = rng.standard_normal(50)
    for m in (1, 2, 7, 25):
        means = np.array([rate[k : k + m].mean() for k in range(51 - m)])
        expected = np.sqrt(np.mean((means[m:] - means[:-m]) ** 2) / 2)
        assert_allclose(allan_deviation(rate, 3.0, averaging=[m]).deviation, expected, rtol=1e-13)


# ---- laws


@given(st.integers(0, 2**32), st.integers(4, 300), st.floats(-1e3, 1e3), st.floats(1e-9, 1e9))
def test_laws(seed, count, constant, scale):
    rate = np.random.default_rng(seed).standard_normal(count)
    plain = allan_deviation(rate, 0.1).deviation
    rounding = 1e-10  # constants up to a thousand times the noise
    assert_allclose(allan_deviation(rate + constant, 0.1).deviation, plain, rtol=rounding, atol=1e-10)
    assert_allclose(allan_deviation(scale * rate, 0.1).deviation, scale * plain, rtol=rounding, atol=1e-12 * scale)
    assert_allclose(allan_deviation(rate[::-1], 0.1).deviation, plain, rtol=rounding, atol=1e-12)
    assert_array_equal(allan_deviation(rate, 17.0).deviation, plain)  # the sampling time moves the tau axis only


def test_a_large_constant_costs_no_digits():
    # 2**30 times the noise, whose values are multiples of 2**-20: each sum of the two is exact in 53 bits
    noise = np.rint(np.random.default_rng(8).standard_normal(2**17) * 2**20) / 2**20
    plain = allan_deviation(noise, 1.0).deviation
    # what is left is the rounding of the mean, 2**-22, which is a rate and leaves second differences alone
    assert_allclose(allan_deviation(noise + 2.0**30, 1.0).deviation, plain, rtol=1e-7)


def test_ramp_and_sine_in_closed_form():
    ramp = allan_deviation(0.5 * np.arange(4096.0), 2.0)
    assert_allclose(ramp.deviation, 0.25 * ramp.tau / np.sqrt(2), rtol=1e-9)  # slope 0.25 per second
    # the variance of a sine of amplitude A, averaged over phases: A^2 sin^4(pi f tau) / (pi f tau)^2
    f, count = 64 / 4096, 4096
    allan = allan_deviation(3 * np.sin(2 * np.pi * f * (np.arange(count) + 0.5)), 1.0, averaging=[1, 5, 16, 30, 32])
    x = np.pi * f * allan.tau
    x0 = np.pi * f  # sampled at mid-points, not averaged over the sample
    expected = 3 * np.sin(x) ** 2 / x * (x0 / np.sin(x0))
    assert_allclose(allan.deviation, expected, rtol=0.02, atol=1e-12)  # the last period is not whole


def test_channels_are_taken_by_themselves():
    rate = np.random.default_rng(3).standard_normal((1000, 3))
    allan = allan_deviation(rate, 1.0)
    assert allan.deviation.shape == (len(octaves(1000)), 3)
    for i in range(3):
        single = allan_deviation(rate[:, i], 1.0)
        assert_array_equal(allan.channel(i).deviation, single.deviation)
        for errors in (None, WHITE):
            assert_allclose(allan.interval(0.9, errors)[0][:, i], single.interval(0.9, errors)[0], rtol=1e-13)
    assert list(allan.to_frame().columns[:3]) == ["factor", "differences", "deviation_0"]
    assert len(allan.to_frame().columns) == 2 + 9


def test_octaves():
    assert octaves(2) == (1,)
    assert octaves(1023) == tuple(2**k for k in range(9))
    assert octaves(1024) == tuple(2**k for k in range(10))
    assert allan_deviation(np.arange(8.0) ** 2, 1.0).differences.tolist() == [7, 5, 1]


# ---- error bars


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize("name", ["angle_random_walk", "bias_instability", "rate_random_walk", "quantization"])
def test_intervals_hold_their_level(name, known):
    runs = 600
    errors = RandomErrors(**{name: 1.0})
    allan = allan_deviation(simulate(errors, 1024, 1.0, np.random.default_rng(4), channels=runs), 1.0)
    low, high = allan.interval(0.9, errors if known else None)
    truth = np.sqrt(errors.allan_variance(allan.tau))[:, None]
    share = np.mean((low < truth) & (truth < high), axis=1)
    # 4 sigma of a share; at few degrees of freedom the shape of a chi-square is an approximation, and the slope, where
    # it is not known, is guessed from the very points that scatter: a few per cent
    bound = 4 * np.sqrt(0.9 * 0.1 / runs)
    assert (np.abs(share - 0.9)[:6] < bound).all()
    assert (np.abs(share - 0.9)[6:] < bound + 0.04).all()


def test_interval_of_pure_processes_is_that_of_the_slope():
    allan = allan_deviation(simulate(WHITE, 2**16, 1.0, np.random.default_rng(5)), 1.0, averaging=octaves(2**10))
    assert_allclose(allan.interval(0.95)[1], allan.interval(0.95, WHITE)[1], rtol=1e-12)
    single = allan_deviation(np.random.default_rng(5).standard_normal(100), 1.0, averaging=[1])
    assert_allclose(single.interval(), single.interval(errors=WHITE), rtol=1e-12)


def test_errors_without_scatter_have_no_width():
    allan = allan_deviation(np.arange(100.0), 1.0, averaging=[1, 2])
    low, high = allan.interval(errors=RandomErrors(rate_ramp=1.0))
    assert_allclose(low, high)


def test_text_and_table():
    allan = allan_deviation(nbs14(), 0.25)
    again = AllanDeviation.from_json(allan.to_json())
    for name in ("tau", "deviation", "factors", "differences"):
        assert_array_equal(getattr(again, name), getattr(allan, name))
        assert getattr(again, name).dtype == getattr(allan, name).dtype
    assert (again.count, again.dt, again.duration) == (1000, 0.25, 250.0)
    table = allan.to_frame(0.9)
    assert (table.low < table.deviation).all() and (table.deviation < table.high).all()
    assert_array_equal(table.index, allan.tau)
    with pytest.raises(ValueError, match="read-only"):
        allan.deviation[0] = 1.0
    with pytest.raises(ValueError, match="must be that of a AllanDeviation"):
        AllanDeviation.from_json(WHITE.to_json())


# ---- input


def test_tables_bring_their_time():
    rate = np.random.default_rng(6).standard_normal(200)
    time = np.arange(200) * 0.005 + 17.0
    expected = allan_deviation(rate, 0.005)
    for table in (pd.Series(rate, index=time), pd.Series(rate, index=time.round(6))):
        allan = allan_deviation(table)
        assert_allclose(allan.tau, expected.tau, rtol=1e-6)
        assert_array_equal(allan.deviation, expected.deviation)
    frame = pd.DataFrame({"gyro_x": rate, "gyro_y": 2 * rate}, index=time)
    assert_allclose(allan_deviation(frame, 0.005).deviation[:, 1], 2 * expected.deviation, rtol=1e-12)


def gap(rate):
    """A table from which a sample is missing."""
    return pd.Series(rate, index=np.arange(len(rate)) * 0.5).drop(index=5.0)


RATE = np.random.default_rng(7).standard_normal(100)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: allan_deviation(np.where(np.arange(100) == 42, np.nan, RATE), 1.0), r"nan at index \(42,\)"),
        (lambda: allan_deviation(gap(RATE)), r"sampled evenly, got 1 s after t = 4.5 s \(sample 9\) where 0.5 s"),
        (lambda: allan_deviation(pd.Series(RATE[:3], index=[0.0, -1.0, -2.0])), "sampled evenly, got -1 s"),
        (lambda: allan_deviation(pd.Series(RATE), 2.0), "`dt` must be the spacing of the index of `rate`, 1 s, got 2"),
        (lambda: allan_deviation(RATE), "`dt` must be given for an array"),
        (lambda: allan_deviation(RATE, 1.0, averaging=[64]), "got 64, which needs a record of at least 128 samples"),
        (lambda: allan_deviation(RATE, 1.0, averaging="decade"), "`averaging` must be one of 'octave'"),
        (lambda: allan_deviation(np.full(100, 3.0), 1.0), "must vary, got 3 in all 100 samples: a frozen sensor"),
        (lambda: allan_deviation(np.stack([RATE, 0 * RATE], 1), 1.0), "in channel 1: a frozen sensor"),
        (lambda: allan_deviation([1.0], 1.0), "at least 2 samples, got 1"),
        (lambda: allan_deviation(RATE.reshape(10, 5, 2), 1.0), r"of shape \(n,\) or \(n, channels\)"),
        (lambda: allan_deviation(RATE, 1.0).interval(1.0), "`level` must be in the open interval"),
        (lambda: allan_deviation(RATE, 1.0).channel(0), "`index` must not be given"),
    ],
)
def test_bad_input(call, words):
    with pytest.raises(ValueError, match=words):
        call()
