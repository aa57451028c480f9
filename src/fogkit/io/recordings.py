"""A recording as the one table: SI and radians, body axes, means over each sample.

`read` takes all of it into memory, `blocks` gives it piece by piece, and both go the same way.
"""

import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.imu.tables import ACCEL_COLUMNS, GYRO_COLUMNS
from fogkit.io import readers
from fogkit.io.description import RecordingDescription, read_description
from fogkit.io.errors import RecordingError

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

FIRST = 65_536
"""Samples at the beginning from which the sampling time is taken."""

USUAL_STEP = 0.5
"""Departure from the median, relative, up to which a step of the time is one between neighbours."""


@dataclass(frozen=True, eq=False)
class Block:
    """Some samples of a recording.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Beginning of each sample, s.
    values : ndarray, shape (k, n)
        One row for each of `RecordingDescription.names`, SI.
    labels : ndarray of object, shape (n,), or None
        Labels of positions, None between them.
    first : int
        Number of the first sample, from 0.
    dt : float
        Sampling time of the recording, s.
    """

    time: Array
    values: Array
    labels: NDArray | None
    first: int
    dt: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Recording:
    """A recording in memory.

    Attributes
    ----------
    table : pandas.DataFrame
        Index ``time``, s, the beginning of each sample; columns ``gyro_x, gyro_y, gyro_z``, rad/s, and as far as
        described ``accel_x, accel_y, accel_z``, m/s^2, ``temperature_*``, degC, ``angle``, rad, ``clock``, s, and
        ``position``, text.
    description : RecordingDescription
        Where it came from.
    dt : float
        Sampling time, s.
    """

    table: "DataFrame"
    description: RecordingDescription
    dt: float

    def __post_init__(self) -> None:
        checks.columns(self.table, GYRO_COLUMNS, name="table")
        checks.instance("description", self.description, RecordingDescription)
        object.__setattr__(self, "dt", checks.positive("dt", self.dt, "s"))

    def __repr__(self) -> str:
        return f"<Recording of {len(self.table)} samples, {self.duration:.6g} s at {1 / self.dt:.6g} Hz>"

    @property
    def duration(self) -> float:
        """Duration of all samples, s; gaps are not counted."""
        return len(self.table) * self.dt

    @property
    def has_accelerometers(self) -> bool:
        """Whether accelerometers were recorded."""
        return self.description.accel is not None

    def block(self) -> Block:
        """All samples as one block."""
        names = list(self.description.names)
        labels = None
        if "position" in self.table:
            column = self.table["position"].astype(object)
            labels = column.where(column.notna(), None).to_numpy()
        values = np.ascontiguousarray(self.table[names].to_numpy(dtype=float).T)
        return Block(self.table.index.to_numpy(dtype=float), values, labels, 0, self.dt)

    def increments(self) -> "DataFrame":
        """Integrals over each sample, rad and m/s, of gyros and accelerometers: what navigation takes."""
        columns = [*GYRO_COLUMNS, *(ACCEL_COLUMNS if self.has_accelerometers else ())]
        return self.table[columns] * self.dt


def read(source: str | Path | RecordingDescription, *, folder: str | Path = ".") -> Recording:
    """A whole recording.

    Parameters
    ----------
    source : str, Path or RecordingDescription
        Path of a description, ``recording.toml``; or the description itself.
    folder : str or Path, optional
        Where the path of the data begins, for a description that is given itself.

    Returns
    -------
    Recording
        Everything in the file, NaN included: nothing is dropped, filled or clipped. `fogkit.io.check` judges it.

    Raises
    ------
    RecordingError
        If description or file cannot be used; the message is one sentence.

    Warns
    -----
    UserWarning
        If numbers are missing, or beyond what double precision holds.
    """
    import pandas as pd

    description, folder = located(source, folder)
    (block,) = blocks(description, folder, rows=None)
    bad = int(np.count_nonzero(~np.isfinite(block.values)))
    if bad:
        warnings.warn(f"{description.file.path} holds {bad} missing or infinite numbers", stacklevel=2)
    table = pd.DataFrame(block.values.T, index=pd.Index(block.time, name="time"), columns=list(description.names))
    if block.labels is not None:
        table["position"] = block.labels
    return Recording(table=table, description=description, dt=block.dt)


def located(source: str | Path | RecordingDescription, folder: str | Path = ".") -> tuple[RecordingDescription, Path]:
    """Description, and the folder from which its path counts."""
    if isinstance(source, RecordingDescription):
        return source, Path(folder)
    path = Path(checks.instance("source", source, (str, Path), fix="Give the path of a recording.toml."))
    return read_description(path), path.parent


def blocks(description: RecordingDescription, folder: Path, rows: int | None = readers.ROWS) -> Iterator[Block]:
    """A recording piece by piece, in SI and body axes.

    Parameters
    ----------
    description : RecordingDescription
        The description.
    folder : Path
        Where a relative path begins.
    rows : int, optional
        Most samples of a block; None makes one of everything.

    Yields
    ------
    Block

    Raises
    ------
    RecordingError
        As `fogkit.io.readers.pieces`.
    """
    clock, dt, first = description.clock, None, 0
    for piece in _begun(readers.pieces(description.file, folder, description.columns, description.position, rows)):
        count = len(next(iter(piece.values())))
        with np.errstate(over="ignore", invalid="ignore"):
            if clock.column is None:
                time = (first + np.arange(count)) / clock.sample_rate
            else:
                time = piece[clock.column] * description_factor(description)
            if dt is None:
                dt = spacing(description, time)
            values = np.empty((len(description.names), count))
            for row, (column, factor, zero) in zip(values, description.sources(dt).values(), strict=True):
                np.multiply(piece[column], factor, out=row)
                if zero:
                    row += zero
        labels = None if description.position is None else piece[description.position]
        yield Block(time, values, labels, first, dt)
        first += count


def _begun(pieces: Iterator[readers.Piece]) -> Iterator[readers.Piece]:
    """Pieces, the first ones as one of at least `FIRST` samples: the sampling time must not depend on their size."""
    start: list[readers.Piece] = []
    count = 0
    for piece in pieces:
        if count >= FIRST:
            yield piece
            continue
        start.append(piece)
        count += len(next(iter(piece.values())))
        if count >= FIRST:
            yield start[0] if len(start) == 1 else {c: np.concatenate([p[c] for p in start]) for c in piece}
    if 0 < count < FIRST:
        yield {c: np.concatenate([p[c] for p in start]) for c in start[0]}


def description_factor(description: RecordingDescription) -> float:
    """SI value of the unit of the clock's column."""
    from fogkit.io.unit_names import si_factor

    return si_factor("time", str(description.clock.unit))


def spacing(description: RecordingDescription, time: Array) -> float:
    """Sampling time, s: as declared, or as the first steps have it that are between neighbours.

    Raises
    ------
    RecordingError
        If the clock does not advance, or far from as fast as the declared rate says.
    """
    declared = None if description.clock.sample_rate is None else 1 / description.clock.sample_rate
    if description.clock.column is None:
        return float(declared)  # type: ignore[arg-type]
    steps = np.diff(time[:FIRST])
    steps = steps[np.isfinite(steps) & (steps > 0)]
    if not steps.size:
        raise RecordingError(f"the clock {description.clock.column!r} of {description.file.path} does not advance")
    usual = np.median(steps)
    found = float(steps[np.abs(steps - usual) <= USUAL_STEP * usual].mean())
    if not 1e-9 < found < 1e9:
        raise RecordingError(
            f"the clock {description.clock.column!r} of {description.file.path} has steps of {found:.3g} s: is its "
            "unit right?"
        )
    if declared is not None and not 0.9 < found / declared < 1.1:
        raise RecordingError(
            f"the clock {description.clock.column!r} of {description.file.path} has steps of {found:.6g} s, "
            f"{found / declared:.4g} times those of `sample_rate`: which of them, or the clock's unit, is wrong?"
        )
    return found if declared is None else declared
