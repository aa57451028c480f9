"""``thermal``: which temperatures does a channel depend on, and how? And a simulated test of it."""

from argparse import Namespace
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fogkit.cli.arguments import UsageError
from fogkit.cli.loading import load
from fogkit.cli.results import Estimates, Result
from fogkit.earth import earth_rate_n, normal_gravity
from fogkit.imu.tables import ACCEL_COLUMNS, GYRO_COLUMNS
from fogkit.io.errors import RecordingError
from fogkit.io.verdicts import Finding
from fogkit.thermal import experiment, network, rates, regression, selection
from fogkit.thermal.models import TemperatureModel, several_points
from fogkit.units import DEG_PER_HOUR, DEG_PER_SQRT_HOUR, HOUR

if TYPE_CHECKING:
    from pandas import DataFrame

TEMPERATURE = "temperature_"

LARGEST_CORRELATION = 0.3
"""Correlation of residuals one window apart from which ordinary standard errors are doubtful."""


def thermal(args: Namespace) -> Result:
    """Regression of a channel on temperatures and their rates, over windows of a recording at rest."""
    loaded = load(args.recording)
    table = loaded.recording.table
    if args.channel not in (*GYRO_COLUMNS, *ACCEL_COLUMNS) or args.channel not in table:
        raise UsageError(f"--channel must be a gyro or accelerometer that was recorded, got {args.channel!r}")
    points = [c.removeprefix(TEMPERATURE) for c in table.columns if c.startswith(TEMPERATURE)]
    if not points:
        raise RecordingError("a regression on temperatures needs some: describe their columns in [temperature]")
    if any(s.kind == "turn" for s in loaded.segmentation.segments):
        raise RecordingError("the unit turned: a regression on temperatures needs a unit at rest in one position")
    reduced = rates.reduce(table[[args.channel, *(TEMPERATURE + p for p in points)]], args.window)
    reference = float(reduced[[TEMPERATURE + p for p in points]].to_numpy().mean())
    model = several_points(points, reference=reference)
    findings = []
    if args.keep_all:
        fit = regression.fit(model, reduced, args.channel, covariance="hac")
    else:
        pruned = selection.prune(reduced, model, args.channel, covariance="hac")
        fit = pruned.fit
        dropped = [s.point for s in pruned.steps if s.dropped]
        text = f"kept {', '.join(fit.model.points) or 'none'}; dropped {', '.join(dropped) or 'none'}"
        findings.append(Finding(check="measuring points", severity="good", text=text))
    text = f"R squared {fit.r_squared:.4f}, residuals of {fit.residual_deviation:.3g}, condition {fit.condition:.3g}"
    findings.append(Finding(check="fit", severity="good", text=text, channel=args.channel))
    if abs(fit.autocorrelation) > LARGEST_CORRELATION:
        text = f"residuals of neighbouring windows correlate, {fit.autocorrelation:.2f}: the model leaves something"
        findings.append(Finding(check="autocorrelation", severity="doubtful", text=text))
    unit = "rad/s" if args.channel in GYRO_COLUMNS else "m/s^2"
    return loaded.result(
        "thermal",
        estimates=Estimates(
            names=[f"{args.channel}.{name}" for name in fit.model.names],
            units=[unit, *(f"{unit}/(K/s)" if t.rate else f"{unit}/K" for t in fit.model.terms)],
            values=fit.estimate,
            covariance=fit.covariance,
        ),
        findings=findings,
        parameters={"channel": args.channel, "window": args.window, "reference": reference},
        tables={
            "thermal": {
                "time": reduced.index.to_numpy(dtype=float),
                "reading": reduced[args.channel].to_numpy(),
                "model": fit.predict(reduced),
            }
        },
        correction={
            "form": "temperature",
            "column": args.channel,
            "model": fit.model.to_dict(),
            "estimate": fit.estimate.tolist(),
            "window": args.window,
        },
    )


def predicted(correction: Mapping[str, Any], table: "DataFrame") -> NDArray[np.float64]:
    """What temperatures add to a channel in each sample, without the constant.

    Rates are slopes over the window of the fit. At both ends, half a window long, the nearest whole window is taken.
    """
    model = TemperatureModel.from_dict(dict(correction["model"]))
    columns = [TEMPERATURE + point for point in model.points]
    if missing := [c for c in columns if c not in table]:
        raise RecordingError(f"the correction needs {', '.join(missing)}, which the recording does not have")
    if not columns:
        return np.zeros(len(table))
    smooth = rates.add_rates(table[columns], rates.RateFilter(window=correction["window"]))
    smooth = smooth.reindex(table.index, method="nearest")
    smooth[columns] = table[columns]
    design = model.design(smooth).to_numpy()
    return design[:, 1:] @ np.asarray(correction["estimate"], dtype=float)[1:]


def simulated(rng: np.random.Generator, duration: float | None, lat: float) -> "tuple[DataFrame, Estimates]":
    """Table of a unit at rest in a chamber that goes up and down, and the truth of its first gyro."""
    length = 12 * HOUR if duration is None else duration
    gyro = experiment.CoilBias(
        temperature={"coil_core": 0.01 * DEG_PER_HOUR, "electronics": -0.02 * DEG_PER_HOUR},
        rate={"coil_core": 5 * DEG_PER_HOUR, "electronics": 2 * DEG_PER_HOUR},
        angle_random_walk=0.001 * DEG_PER_SQRT_HOUR,
    )
    levels = (20.0, 50.0, 0.0, 30.0, -20.0)
    profile = network.steps(levels, hold=length / len(levels), rate=1 / 60)
    inside = experiment.alone()
    read = experiment.simulate(inside, profile, length, effects={"gyro_x": gyro}, powered=True, interval=10.0, rng=rng)
    read = read[["gyro_x", *(TEMPERATURE + point for point in gyro.temperature)]].copy()
    walk = gyro.angle_random_walk / np.sqrt(10.0)  # axes east, north, up: the Earth does not turn about the first
    for name, value in zip(GYRO_COLUMNS[1:], earth_rate_n(lat)[1:], strict=True):
        read[name] = value + walk * rng.standard_normal(len(read))
    for name, value in zip(ACCEL_COLUMNS, (0.0, 0.0, normal_gravity(lat)), strict=True):
        read[name] = value + 1e-5 * rng.standard_normal(len(read))
    temperatures = [c for c in read if c.startswith(TEMPERATURE)]
    names = [*(f"gyro_x.temperature_{p}" for p in gyro.temperature), *(f"gyro_x.rate_{p}" for p in gyro.rate)]
    units = ["rad/s/K"] * len(gyro.temperature) + ["rad/s/(K/s)"] * len(gyro.rate)
    values = [*gyro.temperature.values(), *gyro.rate.values()]
    truth = Estimates(names=names, units=units, values=values)
    return read[[*GYRO_COLUMNS, *ACCEL_COLUMNS, *temperatures]], truth
