"""Figures: data in, axes out. Nothing is computed here that a figure does not need for its drawing.

Every function takes axes or makes them, and returns them. `use_style` sets the look of the book's figures.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np

from fogkit.noise import AllanDeviation, Identification, RandomErrors
from fogkit.noise.processes import PROCESSES
from fogkit.optics import interferometer, simulate
from fogkit.optics.gyro import ClosedLoopGyro
from fogkit.optics.loop import Loop
from fogkit.optics.motion import Ramp
from fogkit.stand.turn_tests import TurnTest
from fogkit.units import DEG, DEG_PER_HOUR, DEG_PER_SECOND, MICROSECOND

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STYLE = {
    "figure.figsize": (7.2, 4.2),
    "figure.constrained_layout.use": True,
    "font.size": 11,
    "axes.grid": True,
    "grid.alpha": 0.35,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 1.8,
    "legend.frameon": False,
    "savefig.dpi": 150,
}


def use_style() -> None:
    """Give all figures that follow the look of the book."""
    plt.rcParams.update(STYLE)


def below(ax: "Axes", columns: int = 3, **options) -> None:
    """Legend of an axes below it, where it hides no data.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        The axes, of a figure in constrained layout.
    columns : int, optional
        Entries side by side.
    **options
        Further options of ``Figure.legend``.
    """
    handles, labels = ax.get_legend_handles_labels()
    ax.figure.legend(handles, labels, loc="outside lower center", ncols=columns, **options)


def working_points(depth: float, ax: "Axes | None" = None) -> "Axes":
    """Power of the interferometer against phase, with the two bias states and the slope in each.

    Parameters
    ----------
    depth : float
        Modulation depth, rad.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.
    """
    ax = plt.subplots()[1] if ax is None else ax
    phase = np.linspace(-1.25 * np.pi, 1.25 * np.pi, 400)
    ax.plot(phase / np.pi, interferometer.power(phase), color="0.35", label="power of the interferometer")
    near = np.linspace(-0.6, 0.6, 2)
    for sign, name, color in ((-1, "bias −φ₀", "C0"), (1, "bias +φ₀", "C3")):
        slope = interferometer.taylor_power(near, sign * depth, 1)
        ax.plot((sign * depth + near) / np.pi, slope, color=color, lw=3, alpha=0.6, label=f"slope at {name}")
        ax.plot(sign * depth / np.pi, interferometer.power(depth), "o", color=color, ms=8)
    ax.set(xlabel="phase difference, units of π rad", ylabel="power / full power", ylim=(-0.05, 1.05))
    below(ax)
    return ax


def bode(loops: Mapping[str, Loop]) -> "np.ndarray":
    """Open and closed loop of several loops: gain of both, phase of the open loop, up to the Nyquist frequency.

    Parameters
    ----------
    loops : mapping of Loop
        Loops by label.

    Returns
    -------
    ndarray of matplotlib.axes.Axes, shape (3,)
        Open-loop gain, open-loop phase, closed-loop gain.
    """
    _, axes = plt.subplots(3, sharex=True, figsize=(7.2, 7.2))
    for label, loop in loops.items():
        frequency = np.geomspace(1e-3, 1, 400) * 0.5 / loop.regulation_period
        opened, closed = loop.open_loop_response(frequency), loop.closed_loop_response(frequency)
        axes[0].loglog(frequency, np.abs(opened), label=label)
        axes[1].semilogx(frequency, np.rad2deg(np.unwrap(np.angle(opened))))
        axes[2].loglog(frequency, np.abs(closed))
    axes[0].axhline(1, color="0.3", lw=1, ls="--")
    axes[1].axhline(-180, color="0.3", lw=1, ls="--")
    axes[2].axhline(np.sqrt(0.5), color="0.3", lw=1, ls="--")
    axes[0].set_ylabel("open-loop gain")
    axes[1].set_ylabel("open-loop phase, deg")
    axes[2].set(ylabel="closed-loop gain", xlabel="frequency, Hz")
    below(axes[0], columns=2)
    return axes


def residual_within_periods(
    gyro: ClosedLoopGyro, acceleration: float, periods: int = 4, ax: "Axes | None" = None
) -> "Axes":
    """Uncompensated rate under constant acceleration from a compensated start, half-period by half-period.

    Parameters
    ----------
    gyro : ClosedLoopGyro
        The gyro; its linear response is drawn.
    acceleration : float
        Angular acceleration, rad/s^2.
    periods : int, optional
        Regulation periods to draw.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.
    """
    ax = plt.subplots()[1] if ax is None else ax
    loop = gyro.loop
    motion = Ramp(acceleration=acceleration)
    record = simulate.run(gyro, motion, periods * loop.regulation_period, degree=1, initial_rate=0.0)
    time = (np.arange(periods * loop.half_periods) + 0.5) * loop.half_period
    rate = motion.sample(0, time.size, loop.half_period) - np.repeat(record.rate, loop.half_periods)
    states = np.resize(loop.bias_pattern.ravel(), time.size)
    ax.plot(time / MICROSECOND, rate / DEG_PER_SECOND, color="0.6", lw=1)
    for state, name, color in ((-1, "bias −φ₀", "C0"), (1, "bias +φ₀", "C3")):
        at = states == state
        ax.plot(time[at] / MICROSECOND, rate[at] / DEG_PER_SECOND, "o", ms=4, color=color, label=name)
    steady = acceleration * loop.regulation_period / loop.gain / DEG_PER_SECOND
    ax.axhline(steady, color="0.3", lw=1, ls="--", label="ε Δt / gain, mean of the steady state")
    ax.set(xlabel="time, µs", ylabel="uncompensated rate, deg/s")
    below(ax)
    return ax


def allan(
    result: AllanDeviation,
    fit: "Identification | None" = None,
    *,
    truth: "RandomErrors | None" = None,
    level: float = 0.95,
    ax: "Axes | None" = None,
) -> "Axes":
    """Allan deviation of a gyro with its confidence intervals, and the processes that were found in it.

    Parameters
    ----------
    result : AllanDeviation
        Points, of one channel.
    fit : Identification, optional
        What was found: drawn as the sum and, thin, each process by itself. Its coefficients also give the intervals.
    truth : RandomErrors, optional
        What was planted.
    level : float, optional
        Probability of the intervals.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, in deg/h against s.
    """
    ax = plt.subplots()[1] if ax is None else ax
    low, high = result.interval(level, None if fit is None else fit.estimate)
    bars = np.array([result.deviation - low, high - result.deviation]) / DEG_PER_HOUR
    ax.errorbar(
        result.tau, result.deviation / DEG_PER_HOUR, bars, fmt="C0o", ms=4, lw=1, label=f"record, {100 * level:g} %"
    )
    tau = np.geomspace(result.tau[0], result.tau[-1], 200)
    bottom = 0.5 * float(low.min()) / DEG_PER_HOUR
    if truth is not None:
        ax.plot(tau, np.sqrt(truth.allan_variance(tau)) / DEG_PER_HOUR, "k--", lw=1.2, label="planted")
    if fit is not None:
        ax.plot(tau, np.sqrt(fit.estimate.allan_variance(tau)) / DEG_PER_HOUR, "C3", label="fit")
        for i, name in enumerate(PROCESSES):
            if value := getattr(fit.estimate, name):
                alone = np.sqrt(RandomErrors(**{name: value}).allan_variance(tau)) / DEG_PER_HOUR
                shown = alone > bottom  # a line that leaves the figure would stretch it
                ax.plot(tau[shown], alone[shown], color=f"C{4 + i}", lw=1.5, ls=":", label=name.replace("_", " "))
    ax.set(xscale="log", yscale="log", xlabel="averaging time, s", ylabel="Allan deviation, deg/h")
    ax.set_ylim(bottom, 4 * float(result.deviation.max()) / DEG_PER_HOUR)  # the last bars may be a decade longer
    below(ax)
    return ax


def turn_plan(plan: Sequence[TurnTest], columns: int = 3) -> "np.ndarray":
    """Axes of a unit before and after each test of a plan, seen from above and from the south.

    Parameters
    ----------
    plan : sequence of TurnTest
        Tests.
    columns : int, optional
        Pictures side by side.

    Returns
    -------
    ndarray of matplotlib.axes.Axes
        One for each test; the axis of the turn is drawn thick.
    """
    rows = -(-len(plan) // columns)
    fig, axes = plt.subplots(rows, columns, figsize=(7.2, 1.45 * rows), squeeze=False)
    directions = {"E": np.eye(3)[0], "N": np.eye(3)[1], "U": np.eye(3)[2]}
    seen = np.array([[1.0, 0.5, 0.0], [0.0, 0.36, 1.0]])  # east to the right, north to the back, up
    for ax in axes.ravel():
        ax.set(xlim=(-1.5, 4.8), ylim=(-2.1, 1.4), aspect="equal")
        ax.axis("off")
    for ax, test in zip(axes.ravel(), plan, strict=False):
        for place, C in ((0.0, test.C_b_n), (3.3, test.C_b_n_end)):
            for i, name in enumerate("xyz"):
                along = abs(test.axis[i]) > 0.99
                tip = seen @ C[:, i] + [place, 0]
                style = {"arrowstyle": "-|>", "color": f"C{i}", "lw": 3 if along else 1.3, "mutation_scale": 10}
                ax.annotate("", tip, (place, 0), arrowprops=style | {"shrinkA": 0, "shrinkB": 0})
                at = 1.28 * seen @ C[:, i] + [place, 0]
                ax.text(*at, name, color=f"C{i}", ha="center", va="center", weight="bold" if along else "normal")
        ax.text(1.65, -2.1, f"{test.label}:  {test.angle / DEG:.0f}°", ha="center", va="bottom", fontsize=10)
        ax.annotate("", (2.0, 0.75), (1.3, 0.75), arrowprops={"arrowstyle": "->", "color": "0.4"})
    key = fig.add_axes((0.0, 0.0, 0.09, 0.14))
    key.set(xlim=(-0.4, 1.6), ylim=(-0.4, 1.6), aspect="equal")
    key.axis("off")
    for name, vector in directions.items():
        key.annotate("", seen @ vector, (0, 0), arrowprops={"arrowstyle": "->", "color": "0.4", "lw": 1})
        key.text(*(1.3 * seen @ vector), name, color="0.4", ha="center", va="center", fontsize=9)
    fig.get_layout_engine().set(rect=(0.06, 0, 0.94, 1))
    return axes


def entries(difference: "np.ndarray", marked: Sequence[tuple[int, int]] = (), ax: "Axes | None" = None) -> "Axes":
    """Elements of a matrix as a map: colour by sign and size, rings where marked.

    Parameters
    ----------
    difference : ndarray, shape (m, n)
        Elements, drawn up to 2 in size.
    marked : sequence of tuple of int
        Rows and columns, from 0, that get a ring.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.
    """
    ax = plt.subplots(figsize=(7.2, 6.4))[1] if ax is None else ax
    image = ax.imshow(difference, cmap="RdBu_r", vmin=-2, vmax=2, aspect="auto")
    ax.figure.colorbar(image, ax=ax, extend="both", shrink=0.7)
    for row, column in marked:
        ax.plot(column, row, "o", ms=17, mfc="none", mec="k", mew=1.8)
    ax.grid(False)
    return ax


def svg(draw: "Callable[[Axes], object]") -> str:
    """Picture of axes that a function draws into, as SVG text that is the same for the same drawing.

    Parameters
    ----------
    draw : callable
        Takes axes of matplotlib; what it returns is not looked at.

    Returns
    -------
    str
        The picture; letters are drawn as outlines, so that it looks alike everywhere.
    """
    from io import StringIO

    with plt.rc_context({**STYLE, "svg.hashsalt": "fogkit"}):
        figure, ax = plt.subplots()
        try:
            draw(ax)
            target = StringIO()
            figure.savefig(target, format="svg", metadata={"Date": None})
        finally:
            plt.close(figure)
    return target.getvalue()
