"""The closed forms of the error budget against drawn noise."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.signal import welch

from fogkit.calibration.accuracy import (
    TurnBudget,
    angle_random_walk_from_density,
    direction_error,
    scale_factor_budget,
)
from fogkit.estimation.consistency import ratio_interval
from fogkit.units import ARCSEC

LEVELS = {"readout_noise": 2 * ARCSEC, "bias_deviation": 0.01 * ARCSEC, "angle_random_walk": 0.1 * ARCSEC}
ANGLE, DURATION = 2 * np.pi * 36, 360.0


@pytest.mark.parametrize("sided", ["one", "two"])
@pytest.mark.parametrize("per", ["hertz", "radian"])
def test_random_walk_from_a_measured_density(sided, per):
    # white rate noise, its density measured, stated in each way, and its angle after a time
    random_walk, step, count = 3e-6, 0.01, 2_000_000
    rate = random_walk / np.sqrt(step) * np.random.default_rng(4).standard_normal(count)
    _, density = welch(rate, fs=1 / step, nperseg=1024, return_onesided=sided == "one", detrend=False)
    power = density[1:500].mean()  # per Hz
    if per == "radian":
        power /= 2 * np.pi  # the same power in 2 pi times as many units of frequency
    found = angle_random_walk_from_density(np.sqrt(power), sided=sided, per=per)
    # 500 of 512 bins use almost all numbers of the record: 1 / sqrt(2 count) = 5e-4, Hann window 1.1; 5 sigma
    assert_allclose(found, random_walk, rtol=3e-3)
    angle = rate.reshape(-1, 1000).sum(axis=1) * step  # turned in 10 s, 2000 times
    low, high = ratio_interval(2000, 0.999, mean_known=True)
    assert low < found * np.sqrt(10) / np.sqrt(np.mean(angle**2)) < high


def test_budget_is_that_of_drawn_turns():
    runs, rng = 20_000, np.random.default_rng(2)
    step = 3.6
    drift = LEVELS["angle_random_walk"] / np.sqrt(step) * rng.standard_normal((runs, 100))
    bias = LEVELS["bias_deviation"] * rng.standard_normal((runs, 1))
    ends = LEVELS["readout_noise"] * rng.standard_normal((2, runs))
    # integral of rate less its error, over the difference of two readings of the angle
    read = ANGLE + ends[1] - ends[0]
    scale = read / (ANGLE + ((drift + bias) * step).sum(axis=1))
    budget = scale_factor_budget(ANGLE, DURATION, **LEVELS)
    low, high = ratio_interval(runs, 0.999)
    assert low < budget.total / scale.std(ddof=1) < high
    for name, part in (("readout", ends[1] - ends[0]), ("bias", bias[:, 0] * DURATION), ("noise", drift.sum(1) * step)):
        assert low < getattr(budget, name) / (part / ANGLE).std(ddof=1) < high, name


def test_direction_error_is_that_of_drawn_turns():
    runs, rng, cosine = 20_000, np.random.default_rng(3), 0.4  # large, so that each part counts
    levels = {"readout_noise": 60 * ARCSEC, "bias_deviation": 0.05 * ARCSEC, "angle_random_walk": 2 * ARCSEC}

    def turn():
        noise = rng.standard_normal((4, runs))
        error = levels["bias_deviation"] * noise[0] * DURATION
        error = error + levels["angle_random_walk"] * np.sqrt(DURATION) * noise[1]
        return ANGLE + levels["readout_noise"] * (noise[2] - noise[3]), error

    own_angle, own_error = turn()
    scale = own_angle / (ANGLE + own_error)
    angle, error = turn()
    found = scale * (cosine * ANGLE + error) / angle
    low, high = ratio_interval(runs, 0.999)
    predicted = direction_error(scale_factor_budget(ANGLE, DURATION, **levels), cosine)
    assert low < predicted / found.std(ddof=1) < high


def test_limits_of_the_budget():
    budget = scale_factor_budget(ANGLE, DURATION, readout_noise=1e-5, bias_deviation=0, angle_random_walk=0)
    assert_allclose(budget.total, np.sqrt(2) * 1e-5 / ANGLE, rtol=1e-14)
    assert direction_error(budget, 0.0) == 0.0  # nothing reads along an axis across
    one, four = (scale_factor_budget(n * ANGLE, n * DURATION, **LEVELS) for n in (1, 4))
    # at the same rate: readout with the time, noise with its root, a bias not at all
    ratio = [getattr(one, name) / getattr(four, name) for name in ("readout", "noise", "bias")]
    assert_allclose(ratio, [4, 2, 1], rtol=1e-14)
    assert_allclose(TurnBudget(readout=2.0, bias=3.0, noise=6.0).total, 7.0, rtol=1e-15)


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"angle": 0.0}, "angle"),
        ({"angle": np.nan}, "angle"),
        ({"duration": -1.0}, "duration"),
        ({"readout_noise": -1e-6}, "readout_noise"),
        ({"bias_deviation": np.inf}, "bias_deviation"),
        ({"angle_random_walk": np.nan}, "angle_random_walk"),
    ],
)
def test_impossible_turns_are_refused_by_name(changes, name):
    with pytest.raises(ValueError, match=f"`{name}`"):
        scale_factor_budget(**({"angle": ANGLE, "duration": DURATION} | LEVELS | changes))


def test_densities_without_a_convention_are_refused_by_name():
    with pytest.raises(ValueError, match="`sided`"):
        angle_random_walk_from_density(1.0, sided="both", per="hertz")
    with pytest.raises(ValueError, match="`per`"):
        angle_random_walk_from_density(1.0, sided="two", per="second")
    with pytest.raises(ValueError, match="`density`"):
        angle_random_walk_from_density(-1.0, sided="two", per="hertz")
    with pytest.raises(TypeError):
        angle_random_walk_from_density(1.0)
