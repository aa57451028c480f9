"""Which figures a result has: drawn from its tables alone, so that a result that was loaded shows the same."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from fogkit.cli.results import Result, Table
from fogkit.plotting import svg
from fogkit.units import DEG_PER_HOUR, DEG_PER_SECOND

Draw = Callable[[Any], Any]


def figures(result: Result) -> Iterator[tuple[str, str]]:
    """Captions and pictures (SVG) of a result.

    Parameters
    ----------
    result : Result
        Any result; one without tables has no figure.

    Yields
    ------
    tuple of str
        Caption, and text of the picture.
    """
    for caption, draw in drawings(result):
        yield caption, svg(draw)


def drawings(result: Result) -> Iterator[tuple[str, Draw]]:
    """Captions, and functions that draw into axes."""
    for name, table in result.tables.items():
        if not table or not len(next(iter(table.values()))):
            continue
        if name == "readings":
            yield "Rates over time", partial(_readings, table, result.tables.get("segments", {}))
        elif name.startswith("allan "):
            yield f"Allan deviation of {name.removeprefix('allan ')}", partial(_allan, table)
        elif name.startswith("residuals "):
            yield f"Residuals of {name.removeprefix('residuals ')}", partial(_residuals, table)
        elif name.startswith("rates "):
            yield f"Departure of {name.removeprefix('rates ')} from a straight line", partial(_rates, table)
        elif name == "departures":
            yield "Departures in standard deviations", partial(_departures, table)
        elif name == "drift":
            yield "Drift against angular acceleration", partial(_drift, table)
        elif name == "iterations":
            yield "Changes of slope from iteration to iteration", partial(_iterations, table)
        elif name == "thermal":
            yield "Bias and what temperatures explain", partial(_thermal, table)


def _readings(table: Table, segments: Table, ax: Any) -> None:
    for axis in "xyz":
        ax.plot(table["time"], table[f"gyro_{axis}"] / DEG_PER_SECOND, lw=1, label=f"gyro {axis}")
    for i, kind in enumerate(segments.get("kind", ())):
        colour = "C7" if kind == "dwell" else "C1"
        ax.axvspan(segments["begin"][i], segments["end"][i], color=colour, alpha=0.15, lw=0)
    ax.set(xlabel="time, s", ylabel="rate, deg/s; dwells grey, turns orange")
    ax.legend()


def _allan(table: Table, ax: Any) -> None:
    shown = {name: values / DEG_PER_HOUR for name, values in table.items() if name != "tau"}
    bars = np.array([shown["deviation"] - shown["low"], shown["high"] - shown["deviation"]])
    ax.errorbar(table["tau"], shown["deviation"], bars, fmt="C0o", ms=4, lw=1, label="recording, 95 %")
    ax.plot(table["tau"], shown["fit"], "C3", label="fit")
    ax.set(xscale="log", yscale="log", xlabel="averaging time, s", ylabel="Allan deviation, deg/h")
    ax.set_ylim(0.5 * shown["deviation"].min(), 4 * shown["deviation"].max())
    ax.legend()


def _residuals(table: Table, ax: Any) -> None:
    for axis in "xyz":
        ax.plot(np.arange(len(table[axis])), table[axis], "o", ms=4, label=axis)
    ax.axhline(0, color="0.3", lw=1)
    ax.set_xticks(np.arange(len(table["position"])), table["position"], rotation=90, fontsize=8)
    ax.set(ylabel="residual, standard deviations")
    ax.legend()


def _rates(table: Table, ax: Any) -> None:
    ax.plot(table["rate"] / DEG_PER_SECOND, table["residual"] / DEG_PER_HOUR, "o", ms=4)
    ax.axhline(0, color="0.3", lw=1)
    ax.set(xlabel="rate, deg/s", ylabel="departure, deg/h")


def _departures(table: Table, ax: Any) -> None:
    place = np.arange(len(table["name"]))
    ax.barh(place, table["departure"], color="C0")
    for limit in (-3, 3):
        ax.axvline(limit, color="0.3", lw=1, ls="--")
    ax.set_yticks(place, table["name"], fontsize=7)
    ax.set(xlabel="difference, standard deviations")


def _drift(table: Table, ax: Any) -> None:
    acceleration = table["acceleration_deg_s2"]
    for name, label in (("oscillation_dph", "harmonic oscillation"), ("constant_dph", "constant acceleration")):
        ax.loglog(acceleration, np.abs(table[name]), "o-", ms=4, label=label)
    ax.set(xlabel="angular acceleration, deg/s²", ylabel="size of the drift, deg/h")
    ax.legend()


def _iterations(table: Table, ax: Any) -> None:
    ax.semilogy(table["iteration"], table["rms_z"], "o-", ms=4)
    ax.set(xlabel="iteration", ylabel="changes of slope, rms, m/s²")


def _thermal(table: Table, ax: Any) -> None:
    ax.plot(table["time"], table["reading"], ".", ms=3, label="recorded")
    ax.plot(table["time"], table["model"], "C3", label="model")
    ax.set(xlabel="time, s", ylabel="means, SI")
    ax.legend()
