"""``check`` and ``allan``: is a recording sound, and how does it drift? One pass, whatever its length."""

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fogkit.cli.files import versions
from fogkit.cli.loading import inputs
from fogkit.cli.results import Estimates, Result
from fogkit.imu.tables import GYRO_COLUMNS
from fogkit.io.streams import Survey, survey
from fogkit.io.verdicts import Finding

if TYPE_CHECKING:
    from fogkit.noise import Identification

POINTS = 2000
"""Most points of a series in a result."""

UNITS = {
    "angle_random_walk": "rad/sqrt(s)",
    "bias_instability": "rad/s",
    "rate_random_walk": "rad/s/sqrt(s)",
}
"""Processes that are identified, with the units of their coefficients."""


def check(args: Namespace) -> Result:
    """Verdict on a recording: soundness, units, plan; with its dwells and turns."""
    seen = survey(args.recording, reduced_rate=args.rate, progress=args.progress)
    return Result(
        command="check",
        findings=seen.verdict.findings,
        inputs=inputs(Path(args.recording), seen.description),
        parameters=_about(seen),
        versions=versions(),
        tables={"segments": _segments(seen), "readings": _readings(seen)},
    )


def allan(args: Namespace) -> Result:
    """Allan deviation of the gyros, and the random errors that it shows."""
    from fogkit.noise import identify

    seen = survey(args.recording, allan=True, reduced_rate=args.rate, progress=args.progress)
    findings, tables, estimates = list(seen.verdict.findings), {}, Estimates()
    segments = () if seen.segmentation is None else seen.segmentation.segments
    if len(segments) > 1 or any(s.kind == "turn" for s in segments):
        text = "the unit did not rest in one position all the time: its motion is in the Allan deviation"
        findings.append(Finding(check="rest", severity="doubtful", text=text))
    for i, name in enumerate(GYRO_COLUMNS):
        channel = seen.allan.channel(i)
        low, high = channel.interval(0.95)
        tables[f"allan {name}"] = {"tau": channel.tau, "deviation": channel.deviation, "low": low, "high": high}
        fit = identify(channel)
        tables[f"allan {name}"] |= {"fit": np.sqrt(fit.estimate.allan_variance(channel.tau))}
        estimates = estimates.joined(_coefficients(name, fit))
        severity = "good" if fit.p_value > 1e-3 else "doubtful"
        text = (
            f"chi-square {fit.chi_square:.3g} with {fit.degrees_of_freedom} degrees of freedom, p = {fit.p_value:.2g}"
        )
        findings.append(Finding(check="fit", severity=severity, text=text, channel=name))
    return Result(
        command="allan",
        estimates=estimates,
        findings=findings,
        inputs=inputs(Path(args.recording), seen.description),
        parameters=_about(seen),
        versions=versions(),
        tables=tables,
    )


def _coefficients(gyro: str, fit: "Identification") -> Estimates:
    """Coefficients of one gyro; a coefficient at zero has an infinite standard deviation, and no covariances."""
    return Estimates(
        names=[f"{gyro}.{process}" for process in fit.processes],
        units=[UNITS[process] for process in fit.processes],
        values=fit.coefficients,
        covariance=fit.covariance,
    )


def _about(seen: Survey) -> dict[str, Any]:
    return {"samples": seen.count, "dt": seen.dt, "latitude": seen.description.latitude}


def _segments(seen: Survey) -> dict[str, Any]:
    """Dwells and turns as columns."""
    if seen.segmentation is None:
        return {}
    found = seen.segmentation.segments
    rates = np.array([s.rate for s in found]).reshape(-1, 3)
    columns = {
        "label": [s.label for s in found],
        "kind": [s.kind for s in found],
        "begin": np.array([s.begin for s in found], dtype=float),
        "end": np.array([s.end for s in found], dtype=float),
    }
    return columns | {f"rate_{axis}": rates[:, i] for i, axis in enumerate("xyz")}


def _readings(seen: Survey) -> dict[str, Any]:
    """Means over time, few enough for a figure."""
    table = seen.reduced.table
    every = -(-len(table) // POINTS)
    thinned = table.iloc[::every]
    return {"time": thinned.index.to_numpy(dtype=float)} | {
        name: thinned[name].to_numpy() for name in table.columns if name != "position"
    }
