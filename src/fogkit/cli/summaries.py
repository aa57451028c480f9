"""How a result reads on a screen: estimates in the units of the field, findings, and where there is more."""

import numpy as np

from fogkit.cli.results import Result
from fogkit.units import ARCSEC, DEG, DEG_PER_HOUR, DEG_PER_HOUR_PER_SQRT_HOUR, DEG_PER_SQRT_HOUR, MICRO_G, PPM

READABLE = {
    "rad/s": (DEG_PER_HOUR, "deg/h"),
    "m/s^2": (MICRO_G, "ug"),
    "rad/sqrt(s)": (DEG_PER_SQRT_HOUR, "deg/sqrt(h)"),
    "rad/s/sqrt(s)": (DEG_PER_HOUR_PER_SQRT_HOUR, "deg/h/sqrt(h)"),
    "rad": (ARCSEC, "arcsec"),
    "rad/s/K": (DEG_PER_HOUR, "deg/h/K"),
}
"""Factor and name of the unit in which a quantity is shown, by its SI unit."""


def readable(name: str, unit: str, value: float, deviation: float | None) -> tuple[str, str, str]:
    """Value, standard deviation and unit as they are shown.

    A pure number near 1 is shown as it is and its deviation in ppm; a heading in degrees.
    """
    if name.startswith("heading"):
        return f"{value / DEG:.4f}", "" if deviation is None else f"{deviation / DEG:.4f}", "deg"
    if unit == "1":
        return f"{value:.8f}", "" if deviation is None else f"{deviation / PPM:.2g} ppm", ""
    factor, shown = READABLE.get(unit, (1.0, unit))
    return f"{value / factor:.6g}", "" if deviation is None else f"{deviation / factor:.2g}", shown


def rows(result: Result) -> list[tuple[str, str, str, str]]:
    """Name, value, standard deviation and unit of each estimate."""
    e = result.estimates
    deviations = [None] * len(e) if e.covariance is None else e.standard_deviation.tolist()
    return [
        (name, *readable(name, unit, value, deviation))
        for name, unit, value, deviation in zip(e.names, e.units, e.values.tolist(), deviations, strict=True)
    ]


def summary(result: Result) -> str:
    """Text of a result for a terminal."""
    lines = []
    if estimates := rows(result):
        widths = [max(len(row[i]) for row in estimates) for i in range(4)]
        sign = "+-" if result.estimates.covariance is not None else "  "
        for name, value, deviation, unit in estimates:
            lines.append(
                f"{name:<{widths[0]}}  {value:>{widths[1]}} {sign} {deviation:<{widths[2]}}  {unit}".rstrip(" +-")
                if not deviation
                else f"{name:<{widths[0]}}  {value:>{widths[1]}} {sign} {deviation:<{widths[2]}}  {unit}".rstrip()
            )
        lines.append("")
    if schedule := result.tables.get("schedule"):
        lines += [*_aligned(schedule), "", result.parameters["toml"].strip(), ""]
    if drift := result.tables.get("drift"):
        lines += [*_aligned(drift), ""]
    wrong = [f for f in result.findings if f.severity != "good"]
    lines.append(f"{result.command}: {result.severity}, {len(result.findings)} checks, {len(wrong)} findings")
    shown = wrong if len(result.findings) > 3 else result.findings
    lines += [f"  {f.severity:<8}  {f.check}{f', {f.channel}' * bool(f.channel)}: {f.text}" for f in shown]
    return "\n".join(lines)


def _aligned(table: dict) -> list[str]:
    """A table as lines."""
    columns = [[name, *(_cell(v) for v in values)] for name, values in table.items()]
    widths = [max(map(len, column)) for column in columns]
    return [
        "  ".join(f"{cell:>{w}}" for cell, w in zip(row, widths, strict=True)) for row in zip(*columns, strict=True)
    ]


def _cell(value: object) -> str:
    if isinstance(value, str):
        return value
    return f"{value:.6g}" if np.isfinite(value) else ""
