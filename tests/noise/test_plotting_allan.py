import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit import plotting
from fogkit.noise import RandomErrors, allan_deviation, identify, simulate
from fogkit.units import DEG_PER_HOUR

PLANTED = RandomErrors(angle_random_walk=1e-6, bias_instability=3e-7)


@pytest.fixture(autouse=True)
def close_figures():
    with mpl.rc_context():
        plotting.use_style()
        yield
    plt.close("all")


def test_points_curves_and_units():
    rate = simulate(PLANTED, 2**13, 1.0, np.random.default_rng(1))
    fit = identify(rate, 1.0, processes=["angle_random_walk", "bias_instability"])
    mine = plt.subplots()[1]
    ax = plotting.allan(fit.allan, fit, truth=PLANTED, ax=mine)
    assert ax is mine and ax.get_xscale() == ax.get_yscale() == "log"
    lines = {line.get_label(): line for line in ax.get_lines()}
    tau, deviation = lines["planted"].get_data()
    assert_allclose(deviation * DEG_PER_HOUR, np.sqrt(PLANTED.allan_variance(tau)), rtol=1e-12)
    assert {"planted", "fit", "angle random walk", "bias instability"} <= set(lines)
    (container,) = ax.containers
    tau, deviation = container[0].get_data()
    assert_allclose(deviation * DEG_PER_HOUR, fit.allan.deviation, rtol=1e-12)
    bars = container[2][0].get_segments()
    low, high = fit.allan.interval(0.95, fit.estimate)
    assert_allclose([bar[:, 1] for bar in bars], np.stack([low, high], 1) / DEG_PER_HOUR, rtol=1e-9)


def test_points_alone():
    allan = allan_deviation(np.random.default_rng(2).standard_normal(500), 1.0)
    labels = plotting.allan(allan, level=0.9).get_legend_handles_labels()[1]
    assert labels == ["record, 90 %"]
