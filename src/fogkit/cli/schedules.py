"""``plan``: what the operator does, as a table, as CSV, or as the ``[plan]`` of a description."""

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fogkit.cli.files import versions, write_whole
from fogkit.cli.methods import chosen_plan
from fogkit.cli.results import Result, table_of
from fogkit.io.plain_toml import toml_text
from fogkit.io.plan_names import MountScan, steps
from fogkit.io.verdicts import Finding
from fogkit.stand.placements import Schedule
from fogkit.stand.plans import Plan
from fogkit.units import DEG

if TYPE_CHECKING:
    from pandas import DataFrame


def plan(args: Namespace) -> Result:
    """Schedule of a plan for the operator."""
    reference = chosen_plan(args.kind, args.parameter)
    built = reference.build()
    frame = schedule(built)
    if args.csv is not None:
        write_whole(Path(args.csv), frame.to_csv())
    section = {"kind": reference.kind, **reference.parameters}
    duration = sum(step.duration for step in steps(built))
    text = f"{len(frame)} steps, {duration:.6g} s of readings; the time between them comes on top"
    return Result(
        command="plan",
        findings=[Finding(check="plan", severity="good", text=text)],
        parameters=section | {"toml": toml_text({"plan": section})},
        versions=versions(),
        tables={"schedule": table_of(frame)},
    )


def schedule(built: Any) -> "DataFrame":
    """Table of a plan: one row for each step, angles in deg, rates in deg/s, durations in s."""
    import pandas as pd

    from fogkit.stand import turn_tests

    if isinstance(built, Schedule | Plan):
        return built.to_frame()
    if isinstance(built, MountScan):
        angles = [angle / DEG for angle in built.angles]
        rows = {"axis": built.axis, "angle_deg": angles, "dwell_s": built.dwell, "turn_s": built.turn_duration}
        index = pd.Index([f"dwell {i + 1}" for i in range(len(angles))], name="step")
        return pd.DataFrame(rows, index=index)
    return turn_tests.to_frame(built)
