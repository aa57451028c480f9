"""A recording on disk, with the description that reads it back. Nothing half-written is left behind."""

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fogkit import checks
from fogkit.imu.tables import ACCEL_COLUMNS, GYRO_COLUMNS
from fogkit.io.description import Channels, Clock, FileFormat, RecordingDescription
from fogkit.io.errors import RecordingError
from fogkit.io.plan_names import PlanReference
from fogkit.io.readers import ROWS
from fogkit.io.recordings import description_factor

if TYPE_CHECKING:
    from pandas import DataFrame


def describe(
    table: "DataFrame",
    path: str,
    *,
    sample_rate: float | None = None,
    latitude: float | None = None,
    gravity: float | None = None,
    plan: PlanReference | None = None,
) -> RecordingDescription:
    """Description of a table that is written as it is: SI and radians, columns by their own names.

    Parameters
    ----------
    table : pandas.DataFrame
        The one table, index ``time`` in s.
    path : str
        Name of the data file; its suffix says the kind.
    sample_rate : float, optional
        Samples per second, if the clock is to be compared with it.
    latitude, gravity : float, optional
        rad and m/s^2.
    plan : PlanReference, optional
        What was done.

    Returns
    -------
    RecordingDescription
    """
    checks.columns(table, GYRO_COLUMNS, name="table")
    has = set(table.columns)
    temperatures = {str(c).removeprefix("temperature_"): str(c) for c in table if str(c).startswith("temperature_")}
    accel = Channels(columns=ACCEL_COLUMNS, unit="m/s^2") if set(ACCEL_COLUMNS) <= has else None
    known = {*GYRO_COLUMNS, *temperatures.values(), *(ACCEL_COLUMNS if accel else ()), "angle", "clock", "position"}
    if unknown := [c for c in table.columns if c not in known]:
        raise ValueError(f"`table` must have the columns of a recording only, got {', '.join(map(repr, unknown))}")
    second = {"second_column": "clock", "second_unit": "s"} if "clock" in has else {}
    return RecordingDescription(
        file=FileFormat(path=path, rows=len(table)),
        clock=Clock(column="time", unit="s", sample_rate=sample_rate, **second),
        gyro=Channels(columns=GYRO_COLUMNS, unit="rad/s"),
        accel=accel,
        temperatures=temperatures,
        temperature_unit="degC" if temperatures else None,
        angle="angle" if "angle" in has else None,
        angle_unit="rad" if "angle" in has else None,
        position="position" if "position" in has else None,
        latitude=latitude,
        gravity=gravity,
        plan=plan,
    )


def write(table: "DataFrame", description: RecordingDescription, path: str | Path) -> Path:
    """Data file and description of a recording.

    Parameters
    ----------
    table : pandas.DataFrame
        The one table: SI, body axes, means over each sample.
    description : RecordingDescription
        How it is to be written: units, axes, signs, increments or rates, form of the file. `describe` makes one.
    path : str or Path
        The description's own file; the data stand beside it, under the path that it says.

    Returns
    -------
    Path
        That of the description.

    Raises
    ------
    RecordingError
        If the folder cannot be written to, or a number of the clock would be lost.
    ValueError
        If the table lacks a column of the description.

    Notes
    -----
    Both files are written under other names first and moved into place when they are whole. Numbers are written with
    all their digits: in SI they come back exactly, in another unit within rounding.
    """
    checks.instance("description", description, RecordingDescription)
    path = Path(path)
    needed = [*description.names, *(["position"] if description.position is not None else [])]
    checks.columns(table, needed, name="table")
    columns = _columns(table, description)
    description = replace(description, file=replace(description.file, rows=len(table)))
    data = path.parent / description.file.path
    if data.resolve() == path.resolve():
        raise ValueError(f"`path` must differ from that of the data, got {path.name!r} for both")
    writer = {"csv": _text, "parquet": _parquet, "npz": _npz, "matlab": _matlab}[description.file.kind]
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        _whole(data, lambda target: writer(target, description.file, columns))
        _whole(path, lambda target: target.write_text(description.to_toml(), encoding="utf-8"))
    except OSError as error:
        raise RecordingError(f"{path.name} cannot be written: {error.strerror or error}") from None
    return path


def _columns(table: "DataFrame", description: RecordingDescription) -> dict[Any, Any]:
    """Columns of the file in the units of the description, in order of their numbers where they are numbers."""
    time = table.index.to_numpy(dtype=float)
    clock = description.clock
    steps = np.diff(time)
    dt = 1 / clock.sample_rate if clock.sample_rate else (float(steps.mean()) if steps.size else 1.0)
    columns: dict[Any, Any] = {}
    if clock.column is not None:
        columns[clock.column] = time / description_factor(description)
    elif steps.size and np.abs(time - np.arange(len(time)) * dt).max() > 1e-6 * dt * max(1, len(time)):
        raise RecordingError("the times of the table are not those of `sample_rate`: give the clock a column")
    for name, (column, factor, zero) in description.sources(_reader_dt(description, time, dt)).items():
        columns[column] = (table[name].to_numpy(dtype=float) - zero) / factor
    if description.position is not None:
        labels = table["position"].astype(object)
        columns[description.position] = labels.where(labels.notna(), None).to_numpy()
    if not description.file.numbered:
        return columns
    width = max(columns)
    return {i: columns.get(i, np.zeros(len(table))) for i in range(1, width + 1)}


def _reader_dt(description: RecordingDescription, time: Any, dt: float) -> float:
    """Sampling time that the reader will find, s."""
    from fogkit.io.recordings import spacing

    return spacing(description, time) if description.clock.column is not None else dt


def _whole(path: Path, write_to: Callable[[Path], Any]) -> None:
    """Write a file under another name and move it into place."""
    path.parent.mkdir(parents=True, exist_ok=True)
    target = path.with_name(f".{path.stem}.{os.getpid()}.partial{path.suffix}")
    try:
        write_to(target)
        target.replace(path)
    finally:
        target.unlink(missing_ok=True)


def _text(target: Path, file: FileFormat, columns: dict) -> None:
    import pandas as pd

    frame = pd.DataFrame({str(name): values for name, values in columns.items()})
    plain = file.decimal == "." and file.header and not file.skip_rows and file.delimiter != "whitespace"
    if plain and file.encoding.lower().replace("_", "-") in ("utf-8", "utf8"):
        import pyarrow as pa
        import pyarrow.csv

        options = pa.csv.WriteOptions(delimiter=file.delimiter, quoting_style="needed")
        pa.csv.write_csv(pa.Table.from_pandas(frame, preserve_index=False), target, options)
        return
    delimiter = " " if file.delimiter == "whitespace" else file.delimiter
    with target.open("w", encoding=file.encoding, newline="") as stream:
        stream.write("#\n" * file.skip_rows)
        options = {"index": False, "header": file.header, "sep": delimiter, "decimal": file.decimal}
        frame.to_csv(stream, na_rep="nan", float_format=_digits if file.decimal == "." else None, **options)


def _digits(value: float) -> str:
    """All digits of a number."""
    return repr(float(value))


def _parquet(target: Path, _: FileFormat, columns: dict) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pa.table({name: pa.array(values, from_pandas=False) for name, values in columns.items()})
    pq.write_table(table, target, row_group_size=ROWS)  # one is read whole


def _arrays(file: FileFormat, columns: dict) -> dict[str, Any]:
    """Arrays by name, or one matrix."""
    if file.variable is not None:
        return {file.variable: np.column_stack([np.asarray(values, dtype=float) for values in columns.values()])}
    texts = {name: values.dtype == object for name, values in columns.items()}
    return {
        str(name): np.array([v or "" for v in values], dtype=str) if texts[name] else values
        for name, values in columns.items()
    }


def _npz(target: Path, file: FileFormat, columns: dict) -> None:
    with target.open("wb") as stream:
        np.savez(stream, **_arrays(file, columns))


def _matlab(target: Path, file: FileFormat, columns: dict) -> None:
    from scipy.io import savemat

    savemat(target, _arrays(file, columns), appendmat=False, oned_as="column")
