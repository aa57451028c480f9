"""``simulate``: a recording of a method's plan with its truth, in the form of one's own."""

import tempfile
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fogkit import checks
from fogkit.cli import simulated_records as records
from fogkit.cli import simulated_units as units
from fogkit.cli.arguments import UsageError
from fogkit.cli.files import versions, write_whole
from fogkit.cli.methods import KINDS, chosen_plan, default_plan
from fogkit.cli.results import Estimates, Result
from fogkit.io.errors import RecordingError
from fogkit.io.plan_names import PlanReference
from fogkit.io.verdicts import Finding
from fogkit.io.writing import describe, write
from fogkit.stand.laboratory import Laboratory
from fogkit.stand.table import RateTable
from fogkit.units import ARCSEC, DEG

if TYPE_CHECKING:
    from pandas import DataFrame

SAMPLE_RATES = {"multiposition": 20.0, "rate-sequence": 20.0, "three-stage": 10.0, "navigation": 100.0}
READOUT_NOISE = 1 * ARCSEC
SUFFIXES = {"csv": "csv", "parquet": "parquet", "npz": "npz", "matlab": "mat"}


def simulate(args: Namespace) -> Result:
    """Write ``recording.toml``, the data beside it, and ``truth.json``, into a folder; the description comes last."""
    method, latitude = args.method, args.latitude * DEG
    rng = np.random.default_rng(args.seed)
    rate = checks.positive("--sample-rate", args.sample_rate or SAMPLE_RATES.get(method, 10.0), "Hz")
    grade_name = args.grade or ("navigation" if method in ("navigation", "north") else "tactical")
    grade = units.GRADES[grade_name]
    if method == "thermal":
        from fogkit.cli.temperature import simulated

        table, truth, plan = *simulated(rng, args.duration, latitude), None
    else:
        plan = _plan(args)
        table, truth = _carried_out(method, plan, grade, 1 / rate, latitude, rng, args)
    folder = Path(args.folder)
    target = folder / "recording.toml"
    if target.exists() and not args.overwrite:
        raise UsageError(f"{target} is there already: give another folder, or --overwrite")
    description = describe(table, f"recording.{SUFFIXES[args.format]}", latitude=latitude, plan=plan)
    parameters = {"method": method, "seed": args.seed, "sample_rate": rate, "grade": grade_name, "latitude": latitude}
    text = f"{len(table)} samples of {table.index[-1] - table.index[0]:.6g} s written to {target}"
    result = Result(
        command=f"simulate {method}",
        estimates=truth,
        findings=[Finding(check="written", severity="good", text=text)],
        parameters=parameters,
        versions=versions(),
    )
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder, prefix=".partial-") as partial:
            write(table, description, Path(partial) / "recording.toml")
            write_whole(Path(partial) / "truth.json", result.to_json())
            target.unlink(missing_ok=True)  # without its description a recording is none
            for name in (description.file.path, "truth.json", "recording.toml"):
                (Path(partial) / name).replace(folder / name)
    except OSError as error:
        raise RecordingError(f"{folder} cannot be written to: {error.strerror or error}") from None
    return result


def _plan(args: Namespace) -> PlanReference:
    if args.plan is None:
        if args.parameter:
            return chosen_plan(KINDS[args.method][0], args.parameter)
        return default_plan(args.method, args.duration)
    if args.plan not in KINDS[args.method]:
        raise UsageError(f"{args.method} takes a plan {' or '.join(KINDS[args.method])}, got {args.plan!r}")
    return chosen_plan(args.plan, args.parameter)


def _carried_out(
    method: str,
    plan: PlanReference,
    grade: units.Grade,
    dt: float,
    latitude: float,
    rng: np.random.Generator,
    args: Namespace,
) -> "tuple[DataFrame, Estimates]":
    """Table of a recording, and what its calibration should find."""
    if method == "three-stage":
        triad = units.draw_gyros(grade, rng)
        table = RateTable(latitude=latitude, readout_noise=READOUT_NOISE)
        return _table(records.on_rate_table(triad, plan.build(), table, dt, rng)), units.triad_truth(triad)
    unit = units.draw_unit(grade, rng)
    if method == "navigation":
        return _table(records.on_rough_table(unit, plan.build(), dt, latitude, rng)), units.compensation_truth(unit)
    if method == "north":
        heading = args.heading * DEG if args.heading is not None else rng.uniform(0, 2 * np.pi)
        table = _table(records.on_mount(unit, plan.build(), dt, latitude, heading, rng))
        return table, Estimates(names=["heading"], units=["rad"], values=[heading])
    table = Laboratory(latitude=latitude).record(unit, plan.build(), rng, sample_rate=1 / dt)
    truth = {
        "multiposition": lambda: units.linear_truth(unit),
        "rate-sequence": lambda: units.standard_truth(unit),
        "allan": lambda: units.noise_truth(grade),
    }[method]()
    return table.assign(position=table["position"].astype(object)), truth


def _table(columns: dict) -> "DataFrame":
    """The one table from columns."""
    import pandas as pd

    time = columns.pop("time")
    return pd.DataFrame(columns, index=pd.Index(time, name="time"))
