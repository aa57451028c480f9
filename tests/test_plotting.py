import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit import plotting
from fogkit.optics import systems
from fogkit.reproduction.miklyashev import FIGURE_1_ACCELERATION, SIMULATED, make_gyro


@pytest.fixture(autouse=True)
def close_figures():
    with mpl.rc_context():
        plotting.use_style()
        yield
    plt.close("all")


def overlaps(legend, ax):
    """Whether a legend covers part of an axes."""
    figure = ax.figure
    figure.canvas.draw()
    return legend.get_window_extent().overlaps(ax.get_window_extent())


def test_working_points_lie_on_the_curve_and_slopes_touch_it_there():
    ax = plotting.working_points(2.0)
    curve, *rest = ax.get_lines()
    for line in rest:
        if line.get_marker() == "o":
            x, y = line.get_xydata()[0]
            assert_allclose(y, np.interp(x, *curve.get_data()), atol=1e-3)  # 400 points of the curve
    slopes = [np.diff(line.get_ydata()) / np.diff(line.get_xdata()) for line in rest if line.get_marker() != "o"]
    assert_allclose(slopes[0], -slopes[1])


def test_bode_shows_the_crossover_where_the_figures_have_it():
    gyro = make_gyro(gain=0.3)
    axes = plotting.bode({"loop": gyro.loop})
    frequency, gain = axes[0].get_lines()[0].get_data()
    crossover = np.interp(0, -np.log(gain), np.log(frequency))
    # interpolation between 400 points of a curve
    assert_allclose(np.exp(crossover), systems.figures(gyro.loop).gain_crossover, rtol=1e-3)
    assert all(ax.get_ylabel() for ax in axes) and axes[-1].get_xlabel()


def test_residual_settles_about_the_line_that_is_drawn_for_it():
    ax = plotting.residual_within_periods(SIMULATED, FIGURE_1_ACCELERATION)
    path, *_, steady = ax.get_lines()
    k = SIMULATED.loop.half_periods
    assert_allclose(path.get_ydata()[-k:].mean(), steady.get_ydata()[0], rtol=1e-9)


def test_a_legend_below_hides_no_data_and_axes_passed_in_are_used():
    _, mine = plt.subplots()
    ax = plotting.residual_within_periods(SIMULATED, FIGURE_1_ACCELERATION, ax=mine)
    assert ax is mine
    assert len(ax.figure.legends) == 1
    assert not overlaps(ax.figure.legends[0], ax)
