"""``apply``: how a result makes the readings of a recording true."""

from argparse import Namespace
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fogkit import checks
from fogkit.cli.arguments import UsageError
from fogkit.cli.files import described, read_text, versions
from fogkit.cli.loading import inputs
from fogkit.cli.results import Result
from fogkit.imu.tables import ACCEL_COLUMNS, GYRO_COLUMNS
from fogkit.imu.triads import LinearTriad
from fogkit.io import recordings
from fogkit.io.description import Channels
from fogkit.io.errors import RecordingError
from fogkit.io.verdicts import Finding
from fogkit.io.writing import write

if TYPE_CHECKING:
    from pandas import DataFrame

    from fogkit.calibration.navigation_based import Compensation
    from fogkit.calibration.triad import TriadCalibration

COLUMNS = {"gyro": GYRO_COLUMNS, "accel": ACCEL_COLUMNS}


def linear_correction(gyro: LinearTriad | None, accel: LinearTriad | None) -> dict[str, Any]:
    """Correction by the inverse of ``bias + matrix @ input``, of the sensors that were calibrated."""
    found: dict[str, Any] = {"form": "linear"}
    for name, triad in (("gyro", gyro), ("accel", accel)):
        if triad is not None:
            inverse = np.linalg.inv(np.array(triad.matrix))
            found[name] = {"matrix": inverse.tolist(), "bias": (-inverse @ np.array(triad.bias)).tolist()}
    return found


def compensation_correction(compensation: "Compensation") -> dict[str, Any]:
    """Correction by a compensation, ``bias + matrix @ reading``: the same form."""
    parts = {"gyro": "gyro", "accel": "accelerometer"}
    return {"form": "linear"} | {
        name: {
            "matrix": getattr(compensation, f"{part}_matrix").tolist(),
            "bias": getattr(compensation, f"{part}_bias").tolist(),
        }
        for name, part in parts.items()
    }


def triad_correction(calibration: "TriadCalibration") -> dict[str, Any]:
    """Correction by gyros whose scale factors depend on the sign of the rate."""
    return {"form": "two-sided", "parameters": calibration.estimate.tolist()}


def corrected(table: "DataFrame", correction: Mapping[str, Any]) -> "DataFrame":
    """Recording with its readings made true.

    Parameters
    ----------
    table : pandas.DataFrame
        The one table.
    correction : dict
        Of a `fogkit.cli.results.Result`.

    Returns
    -------
    pandas.DataFrame
        The same columns. Sensors that were not calibrated are as they were.

    Raises
    ------
    RecordingError
        If the correction is of no known form, or speaks of columns that were not recorded.
    """
    form = correction.get("form")
    result = table.copy()
    try:
        if form == "linear":
            for name, columns in COLUMNS.items():
                if name in correction:
                    checks.columns(table, columns)
                    matrix = checks.finite_array("matrix", correction[name]["matrix"], shape=(3, 3))
                    bias = checks.finite_array("bias", correction[name]["bias"], shape=(3,))
                    result[list(columns)] = table[list(columns)].to_numpy(dtype=float) @ matrix.T + bias
        elif form == "two-sided":
            from fogkit.calibration.plan_design import corrected_rate
            from fogkit.calibration.triad import triad_from_parameters

            triad = triad_from_parameters(checks.finite_array("parameters", correction["parameters"], shape=(15,)))
            result[list(GYRO_COLUMNS)] = corrected_rate(triad, table[list(GYRO_COLUMNS)].to_numpy(dtype=float))
        elif form == "temperature":
            from fogkit.cli.temperature import predicted

            column = correction["column"]
            result[column] = table[column] - predicted(correction, table)
        else:
            raise RecordingError(f"the result has a correction of the form {form!r}, which this version does not know")
    except (KeyError, ValueError, TypeError) as error:
        if isinstance(error, RecordingError):
            raise
        raise RecordingError(f"the correction does not fit the recording: {error}") from None
    return result


def apply(args: Namespace) -> Result:
    """Write the corrected recording beside its description."""
    source = Path(args.result)
    result = Result.from_json(read_text(source), name=source.name)
    if result.correction is None:
        raise RecordingError(f"{source.name} is of `fogkit {result.command}` and corrects nothing")
    recording = recordings.read(Path(args.recording))
    table = corrected(recording.table, result.correction)
    description = recording.description
    target = Path(args.folder) / Path(args.recording).name
    if target.resolve() == Path(args.recording).resolve():
        raise UsageError(f"{args.folder} is the folder of the recording itself: the raw one is not overwritten")
    plain = replace(description, file=replace(description.file, path=Path(description.file.path).name))
    write(table, _without_counts(plain), target)
    lost = len(table) - int(np.isfinite(table[list(GYRO_COLUMNS)].to_numpy(dtype=float)).all(axis=1).sum())
    severity = "doubtful" if lost else "good"
    text = f"{len(table)} samples corrected by `fogkit {result.command}`, {lost} of them with missing gyro readings"
    return Result(
        command="apply",
        findings=[Finding(check="correction", severity=severity, text=text, count=lost)],
        inputs=[described(source), *inputs(Path(args.recording), description)],
        parameters={"written": str(target), "samples": len(table)},
        versions=versions(),
    )


def _without_counts(description: Any) -> Any:
    """Description whose numbers are in SI, since corrected readings are no counts of a sensor any more."""
    units = {"gyro": "rad/s", "accel": "m/s^2"}
    parts = {
        name: Channels(columns=channels.columns, unit=unit, axes=channels.axes)
        for name, unit in units.items()
        if (channels := getattr(description, name)) is not None
    }
    return replace(description, **parts)
