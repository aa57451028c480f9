import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit import plotting
from fogkit.optics import systems
from fogkit.reproduction.miklyashev import FIGURE_1_ACCELERATION, SIMULATED, make_gyro
from fogkit.stand.turn_tests import nine_tests


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


def test_plan_shows_both_attitudes_of_each_test():
    plan = nine_tests()
    axes = plotting.turn_plan(plan).ravel()
    assert [ax.texts[-1].get_text() == "" for ax in axes] == [True] * 9  # the arrow between the two
    captions = [text.get_text() for text in axes[1].texts if "°" in text.get_text()]
    assert captions == ["2:  1980°"]
    tips = [text.xy for text in axes[6].texts if isinstance(text, mpl.text.Annotation)][:6]
    # test 7: x east, y down, z north before; x down, y west, z north after
    north = np.array([0.5, 0.36])
    assert_allclose(tips[:3], [(1, 0), (0, -1), north])
    assert_allclose(np.array(tips[3:]) - np.array(tips[5]), [(0, -1) - north, (-1, 0) - north, (0, 0)], atol=1e-12)


def test_entries_are_drawn_with_rings_where_marked():
    values = np.arange(6.0).reshape(2, 3)
    ax = plotting.entries(values, [(1, 2)])
    assert_allclose(ax.images[0].get_array(), values)
    assert [tuple(line.get_xydata()[0]) for line in ax.lines] == [(2, 1)]  # column, row
