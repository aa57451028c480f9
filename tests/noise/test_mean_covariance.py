"""Covariance of means in the pieces of one recording."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.noise import RandomErrors, mean_covariance, simulate

RUNS = 20_000
EDGES = [0, 16, 24, 64, 80]  # samples; the third piece is left out: a gap
DT = 0.5


@pytest.mark.parametrize("process", ["angle_random_walk", "bias_instability", "rate_random_walk", "quantization"])
def test_it_is_that_of_simulated_records(process):
    errors = RandomErrors(**{process: 2.0})
    records = simulate(errors, EDGES[-1], DT, np.random.default_rng(7), channels=RUNS)
    if process in ("bias_instability", "rate_random_walk"):  # relative to the first sample
        records = records - records[0]
    pieces = [pair for i, pair in enumerate(pairwise(EDGES)) if i != 2]
    means = np.stack([records[a:b].mean(axis=0) for a, b in pieces])
    start, stop = (DT * np.array(side) for side in zip(*pieces, strict=True))
    expected = mean_covariance(errors, start, stop, DT)
    spread = np.sqrt(np.diag(expected))
    # a covariance of `RUNS` records has a standard deviation of at most sqrt(2 / RUNS) = 0.01 of the product of both
    assert_allclose(means @ means.T / RUNS / np.outer(spread, spread), expected / np.outer(spread, spread), atol=0.05)


def test_neighbouring_means_differ_by_the_allan_variance():
    errors = RandomErrors(angle_random_walk=1.0, bias_instability=0.5, rate_random_walk=0.2, quantization=0.3)
    C = mean_covariance(errors, [0.0, 10.0], [10.0, 20.0], 0.1)
    assert (C[0, 0] + C[1, 1] - 2 * C[0, 1]) / 2 == pytest.approx(errors.allan_variance(10.0), rel=1e-11)


def test_order_of_the_pieces_and_origin_of_time_do_not_matter():
    errors = RandomErrors(angle_random_walk=1.0, bias_instability=0.5, rate_random_walk=0.2)
    start, stop = np.array([0.0, 30.0, 100.0]), np.array([20.0, 100.0, 160.0])
    C = mean_covariance(errors, start, stop, 0.1)
    back = mean_covariance(errors, start[::-1] + 1e4, stop[::-1] + 1e4, 0.1)[::-1, ::-1]
    assert_allclose(back, C, rtol=1e-7)  # 1e4 s have 2e-12 s of rounding; differences of t^2 ln t lose four digits more
    assert np.linalg.eigvalsh(C).min() > 0


@pytest.mark.parametrize(
    ("start", "stop", "errors", "match"),
    [
        ([0.0, 10.0], [10.0, 10.0], RandomErrors(bias_instability=1.0), "`stop` must be later"),
        ([0.0, 5.0], [10.0, 20.0], RandomErrors(bias_instability=1.0), "do not overlap"),
        ([0.0], [10.0], RandomErrors(rate_ramp=1.0), "`errors` must be without a ramp"),
    ],
)
def test_bad_pieces_are_refused(start, stop, errors, match):
    with pytest.raises(ValueError, match=match):
        mean_covariance(errors, start, stop, 0.1)
