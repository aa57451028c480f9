"""What stands on the disk: the description of a campaign, and its results in Parquet files that are whole or absent.

``campaign.json`` says what was asked; each file ``results/part-*.parquet`` holds the runs of some seconds. Each is
written under a hidden temporary name, forced to the disk and then renamed: a process that is killed leaves what was
there as it was, and at most one hidden file that nothing reads.
"""

import json
import os
import time
import uuid
from collections import defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fogkit.campaign.identity import LARGEST

if TYPE_CHECKING:
    from pandas import DataFrame
    from pyarrow import Table

FORMAT = 1
BOOKKEEPING = ("seed", "run_time", "attempts", "exception", "message", "traceback")
"""Columns of a result beside its inputs and outputs."""


class CampaignMismatchError(ValueError):
    """The folder holds the results of another campaign than the one that was asked for."""


def write_whole(path: Path, write) -> None:
    """Have a file written under a hidden name, force it to the disk, and only then give it its own name."""
    hidden = path.with_name(f".{path.name}.{uuid.uuid4().hex}")
    with open(hidden, "wb") as file:
        write(file)
        file.flush()
        os.fsync(file.fileno())
    os.replace(hidden, path)
    if os.name == "posix":  # the new name too is safe only once the folder is on the disk
        folder = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)


def describe(folder: Path, description: Mapping[str, Any]) -> dict[str, Any]:
    """Write the description of a campaign, unless one is there already; what is there, in either case."""
    (folder / "results").mkdir(parents=True, exist_ok=True)
    path = folder / "campaign.json"
    if not path.exists():
        if parts(folder):
            raise CampaignMismatchError(f"`folder` {folder} holds results but no campaign.json. Give another folder")
        text = json.dumps({"format": FORMAT} | dict(description), indent=1)
        write_whole(path, lambda file: file.write(text.encode()))
    return description_of(folder)


def description_of(folder: Path) -> dict[str, Any]:
    """The description of the campaign in a folder."""
    path = folder / "campaign.json"
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ValueError(f"`folder` must be that of a campaign, but {path} does not exist") from None
    except json.JSONDecodeError as error:
        raise ValueError(f"{path} is not the description of a campaign: {error}") from None
    if not isinstance(found, dict) or found.get("format") != FORMAT:
        raise CampaignMismatchError(f"{path} is not of format {FORMAT}, the one that this version of fogkit reads")
    return found


def parts(folder: Path) -> list[Path]:
    """The result files of a campaign, oldest first."""
    return sorted((folder / "results").glob("part-*.parquet"))


def append(folder: Path, rows: Iterable[Mapping[str, Any]]) -> None:
    """Add rows to the results: one file, or several where values of one column are of different kinds.

    A row has ``identity``, ``place``, ``repeat``, what `BOOKKEEPING` names, and the mappings ``input`` and ``output``.
    """
    import pyarrow.parquet as pq

    groups = defaultdict(list)
    for row in rows:
        flat = {key: value for key, value in row.items() if key not in ("input", "output")}
        flat |= {f"{side}.{name}": value for side in ("input", "output") for name, value in row[side].items()}
        groups[tuple((name, _kind(value)) for name, value in flat.items())].append(flat)
    for kinds, group in groups.items():
        table = _table(kinds, group)
        path = folder / "results" / f"part-{time.time_ns():020d}-{uuid.uuid4().hex[:8]}.parquet"
        write_whole(path, lambda file, table=table: pq.write_table(table, file))


def _kind(value: Any) -> str:
    """How a value is stored: null, boolean, number, text, or JSON for what a column of none of these holds exactly."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "boolean"
    if isinstance(value, float) or (isinstance(value, int) and abs(value) <= LARGEST):
        return "number"
    lone_surrogate = isinstance(value, str) and any("\ud800" <= letter <= "\udfff" for letter in value)
    return "text" if isinstance(value, str) and not lone_surrogate else "json"


def _table(kinds: tuple[tuple[str, str], ...], rows: list[dict[str, Any]]) -> "Table":
    """Table of rows whose columns are of the same kinds."""
    import pyarrow as pa

    types = {"null": pa.null(), "boolean": pa.bool_(), "text": pa.string(), "json": pa.string()}
    arrays, columns = [], []
    for name, kind in kinds:
        values = [row[name] for row in rows]
        if kind == "json":
            values = [json.dumps(value) for value in values]
        if kind == "number":
            whole = all(isinstance(value, int) for value in values)
            types[kind] = pa.int64() if whole else pa.float64()
            values = values if whole else [float(value) for value in values]
        arrays.append(pa.array(values, types[kind]))
        columns.append(pa.field(name, types[kind], metadata={"kind": kind}))
    return pa.Table.from_arrays(arrays, schema=pa.schema(columns))


def stored(folder: Path) -> dict[tuple[str, int], bool]:
    """Runs that are on the disk, by identity of the case and number of the repeat: whether each succeeded."""
    found: dict[tuple[str, int], bool] = {}
    for path in parts(folder):
        table = _read(path, ["identity", "repeat", "exception"])
        for *run, exception in zip(*(column.to_pylist() for column in table.columns), strict=True):
            found[tuple(run)] = found.get(tuple(run), False) or exception is None
    return found


def inputs_of(folder: Path, identity: str) -> dict[str, Any]:
    """Inputs of a stored case."""
    for path in parts(folder):
        for row in _read(path).to_pylist():
            if row["identity"] == identity:
                return {name.removeprefix("input."): value for name, value in row.items() if name.startswith("input.")}
    raise KeyError(identity)


def _read(path: Path, columns: list[str] | None = None) -> "Table":
    """Table of a result file; a ``ValueError`` that names the file if it is damaged."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        with pq.ParquetFile(path) as file:
            return file.read(columns)
    except (pa.ArrowException, OSError) as error:
        raise ValueError(f"{path} is damaged ({error}). Delete it: a resumed campaign runs its cases again") from None


def read_campaign(folder: str | os.PathLike) -> "DataFrame":
    """Results that a campaign has stored so far, finished or not, running or killed.

    Parameters
    ----------
    folder : path
        Folder that was given to `run_campaign`.

    Returns
    -------
    DataFrame
        One row for each run, as `run_campaign` returns it, in the order that the cases had when each was run.

    Raises
    ------
    ValueError
        If it is not the folder of a campaign, or a file in it is damaged.
    """
    folder = Path(folder)
    description = description_of(folder)
    table = gathered(folder)
    return ordered(table, table["place"], description["parameters"])


def gathered(folder: Path) -> "DataFrame":
    """All stored runs, each once: a success where there is one, else the last failure."""
    import pandas as pd

    frames, seen = [], {}
    for path in parts(folder):
        table = _read(path)
        seen |= dict.fromkeys(table.column_names)
        frame = table.to_pandas()
        for field in table.schema:
            kind = field.metadata[b"kind"]
            if kind == b"json":
                frame[field.name] = frame[field.name].map(json.loads).astype(object)
            elif kind == b"null":  # left to those files that have values: it would only blur their type
                del frame[field.name]
        frames.append(frame)
    columns = dict.fromkeys(["identity", "place", "repeat", *BOOKKEEPING]) | seen
    table = pd.concat(frames, ignore_index=True) if frames else pd.DataFrame()
    table = table.reindex(columns=list(columns))
    best_last = table.assign(_success=table["exception"].isna()).sort_values("_success", kind="stable")
    return best_last.drop_duplicates(["identity", "repeat"], keep="last").drop(columns="_success")


def ordered(table: "DataFrame", places: "Iterable[int]", parameters: Iterable[str]) -> "DataFrame":
    """Stored runs in the order of their places, under the names that the caller knows."""
    table = table.assign(place=list(places)).sort_values(["place", "identity", "repeat"], ignore_index=True)
    inputs = [f"input.{name}" for name in parameters]
    outputs = sorted(name for name in table.columns if name.startswith("output."))
    names = ["repeat", *BOOKKEEPING]
    for column in [*inputs, *outputs]:
        short = column.partition(".")[2]
        names.append(column if short in names or short in ("identity", "place") else short)
    table = table.reindex(columns=["repeat", *BOOKKEEPING, *inputs, *outputs]).set_axis(names, axis=1)
    return table[[*names[len(BOOKKEEPING) + 1 :], *names[: len(BOOKKEEPING) + 1]]]
