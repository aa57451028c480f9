"""The numbers of a file, in pieces: text, Parquet, NPZ and MATLAB, each as columns by name or number.

Everything that is wrong with a file ends in one `RecordingError`, whichever library met it.
"""

import csv
import io
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fogkit.io.description import Column, FileFormat
from fogkit.io.errors import RecordingError, first_sentence

Piece = dict[Column, NDArray]

ROWS = 262_144
"""Rows of a piece, unless told otherwise."""

LONGEST_ROW = 1_000_000
"""Bytes within which the first row of a text file must end."""

MISSING = ("", "nan", "NaN", "NAN", "NA", "N/A", "null", "NULL", "None")
"""What stands for a missing number in a text file."""


def pieces(
    file: FileFormat, folder: Path, columns: tuple[Column, ...], text: Column | None = None, rows: int | None = ROWS
) -> Iterator[Piece]:
    """Columns of a file, piece by piece.

    Parameters
    ----------
    file : FileFormat
        Which file, and of what form.
    folder : Path
        Where a relative path begins.
    columns : tuple of str or int
        Columns wanted.
    text : str or int, optional
        The one of them that holds labels; they come as objects, missing ones as None.
    rows : int, optional
        Most rows of a piece; None makes one piece of everything.

    Yields
    ------
    dict
        Arrays of one length by column, float64 or object.

    Raises
    ------
    RecordingError
        If the file is not there, not of its kind, cut off, without a column, or holds what is no number.
    """
    path = folder / file.path
    reader = {"csv": _text, "parquet": _parquet, "npz": _npz, "matlab": _matlab}[file.kind]
    count = 0
    for piece in _guarded(path, lambda: reader(path, file, columns, text, rows)):
        piece = {column: _numbers(path, column, values, column == text) for column, values in piece.items()}
        count += len(next(iter(piece.values())))
        yield piece
    if count == 0:
        raise RecordingError(f"{path.name} holds no samples")
    if file.rows is not None and count != file.rows:
        raise RecordingError(f"{path.name} must hold {file.rows} samples by its description, got {count}: is it whole?")


def _guarded(path: Path, start: Callable[[], Iterator[Piece]]) -> Iterator[Piece]:
    """Pieces of a reader; anything that goes wrong below is a `RecordingError`."""
    try:
        yield from start()
    except (RecordingError, GeneratorExit):
        raise
    except FileNotFoundError:
        raise RecordingError(f"{path.name} is not there; a relative path counts from the description") from None
    except UnicodeError as error:
        raise RecordingError(
            f"{path.name} is not in the encoding of its description: {first_sentence(error)}"
        ) from None
    except Exception as error:  # broken files make these libraries raise anything
        raise RecordingError(f"{path.name} cannot be read: {first_sentence(error)}") from None


def _numbers(path: Path, column: Column, values: Any, is_text: bool) -> NDArray:
    """One column as float64, or labels as objects."""
    values = np.asarray(values)
    if is_text:
        values = values.astype(object)
        wrong = [v for v in values[:1000] if not (v is None or isinstance(v, str) or v != v)]
        if wrong:
            raise RecordingError(f"{path.name}: column {column!r} must hold labels as text, got {wrong[0]!r}")
        return np.array([v if isinstance(v, str) and v else None for v in values], dtype=object)
    if values.dtype.kind not in "iuf":
        raise RecordingError(f"{path.name}: column {column!r} must hold real numbers, got {values.dtype}")
    return values.astype(np.float64, copy=False)


def _header(path: Path, file: FileFormat) -> list[str]:
    """Names of the columns of a text file, or numbers as text; blanks around them are no part of a name."""
    with path.open("rb") as stream:
        raw = stream.read(LONGEST_ROW)
    if file.encoding.replace("_", "-").lower() in ("utf-8", "utf8"):
        raw = raw.removeprefix(b"\xef\xbb\xbf")
    lines = raw.decode(file.encoding, errors="ignore").splitlines()[file.skip_rows :]
    line = next(iter(lines), None)
    if line is None or not line.strip():
        raise RecordingError(
            f"{path.name} holds no row after {file.skip_rows} rows" if raw else f"{path.name} is empty"
        )
    if file.delimiter == "whitespace":
        names = line.split()
    else:
        names = next(csv.reader([line], delimiter=file.delimiter), [])
    if not file.header:
        return [str(i) for i in range(1, len(names) + 1)]
    return [name.strip().lstrip("\ufeff") for name in names]


def _text(path: Path, file: FileFormat, columns: tuple, text: Column | None, rows: int | None) -> Iterator[Piece]:
    names = _header(path, file)
    for column in columns:
        found = names.count(str(column))
        if found == 0:
            held = f"{len(names)} columns" if file.numbered else ", ".join(map(repr, names))[:150]
            hint = " Is `delimiter` right?" if len(names) == 1 else ""
            raise RecordingError(f"{path.name} must have the column {column!r}, got {held}.{hint}")
        if found > 1:
            raise RecordingError(f"{path.name} has the column {column!r} {found} times")
    if file.delimiter == "whitespace":
        yield from _blank_separated(path, file, names, columns, text, rows)
        return
    import pyarrow as pa
    import pyarrow.csv

    unique = [name if names.count(name) == 1 else f"{name} ({i})" for i, name in enumerate(names)]
    wanted = [str(column) for column in columns]
    read = pa.csv.ReadOptions(
        column_names=unique, skip_rows=file.skip_rows + file.header, encoding=file.encoding, block_size=1 << 23
    )
    parse = pa.csv.ParseOptions(delimiter=file.delimiter)
    convert = pa.csv.ConvertOptions(
        include_columns=wanted,
        column_types={str(c): pa.string() if c == text else pa.float64() for c in columns},
        null_values=list(MISSING),
        strings_can_be_null=True,
        decimal_point=file.decimal,
    )
    options = {"read_options": read, "parse_options": parse, "convert_options": convert}
    if rows is None:
        yield from _arrow([pa.csv.read_csv(path, **options)], columns)
    else:
        with pa.csv.open_csv(path, **options) as stream:
            yield from _arrow(stream, columns)


def _blank_separated(path, file, names, columns, text, rows) -> Iterator[Piece]:
    import pandas as pd

    wanted = [str(column) for column in columns]
    types = {str(c): str if c == text else np.float64 for c in columns}
    options = {"sep": r"\s+", "header": None, "names": names, "usecols": wanted, "dtype": types, "index_col": False}
    options |= {"skiprows": file.skip_rows + file.header, "decimal": file.decimal, "encoding": file.encoding}
    with pd.read_csv(path, chunksize=rows or 1 << 40, na_values=list(MISSING), **options) as reader:
        for frame in reader:
            yield {column: frame[str(column)].to_numpy() for column in columns}


def _arrow(batches, columns: tuple) -> Iterator[Piece]:
    """Pieces of Arrow batches or tables; missing numbers become NaN."""
    for batch in batches:
        found = {}
        for column in columns:
            values = batch.column(str(column))
            if hasattr(values, "combine_chunks"):
                values = values.combine_chunks()
            if hasattr(values, "num_chunks"):  # nothing to combine
                values = values.chunk(0) if values.num_chunks else values.to_numpy()
            found[column] = values.to_numpy(zero_copy_only=False) if hasattr(values, "null_count") else values
        if len(next(iter(found.values()))):
            yield found


def _parquet(path: Path, file: FileFormat, columns: tuple, text: Column | None, rows: int | None) -> Iterator[Piece]:
    import pyarrow.parquet as pq

    with path.open("rb") as handle, pq.ParquetFile(handle, pre_buffer=False) as source:  # else all of it
        names = source.schema_arrow.names
        for column in columns:
            if names.count(column) != 1:
                held = ", ".join(map(repr, names))[:150]
                raise RecordingError(f"{path.name} must have the column {column!r} once, got {held}")
            kind = str(source.schema_arrow.field(column).type)
            if column != text and not kind.startswith(("float", "double", "halffloat", "int", "uint")):
                raise RecordingError(f"{path.name}: column {column!r} must hold real numbers, got {kind}")
        if rows is None:
            yield from _arrow([source.read(columns=list(columns))], columns)
        else:
            yield from _arrow(source.iter_batches(batch_size=rows, columns=list(columns)), columns)


def _npz(path: Path, file: FileFormat, columns: tuple, text: Column | None, rows: int | None) -> Iterator[Piece]:
    """Members of an NPZ file, each streamed, compressed or not."""
    with zipfile.ZipFile(path) as archive:
        if file.variable is not None:
            with _Member(archive, file.variable, path, 2) as member:
                _require_numbers(path, columns, member.shape[1])
                for part in member.read(rows):
                    yield {column: part[:, int(column) - 1] for column in columns}
            return
        members = {column: _Member(archive, str(column), path, 1) for column in columns}
        try:
            _require_one_length(path, {column: member.shape[0] for column, member in members.items()})
            for parts in zip(*(member.read(rows) for member in members.values()), strict=True):
                yield dict(zip(columns, parts, strict=True))
        finally:
            for member in members.values():
                member.stream.close()


class _Member:
    """One array of an NPZ file, read from its beginning to its end."""

    def __init__(self, archive: zipfile.ZipFile, name: str, path: Path, ndim: int) -> None:
        held = {entry.filename.removesuffix(".npy"): entry for entry in archive.infolist()}
        if name not in held:
            raise RecordingError(
                f"{path.name} must have the array {name!r}, got {', '.join(map(repr, held))[:150] or 'none'}"
            )
        info = held[name]
        self.stream = archive.open(info)
        self.where = f"{path.name}: array {name!r}"
        version = np.lib.format.read_magic(self.stream)
        reader = {(1, 0): np.lib.format.read_array_header_1_0}.get(version, np.lib.format.read_array_header_2_0)
        self.shape, fortran, self.dtype = reader(self.stream)
        if len(self.shape) != ndim:
            raise RecordingError(f"{self.where} must have {ndim} dimensions, got shape {self.shape}")
        if fortran and ndim > 1:
            raise RecordingError(f"{self.where} is stored column by column: save `np.ascontiguousarray` of it")
        if self.dtype.kind not in "iufU":
            raise RecordingError(f"{self.where} must hold real numbers, got {self.dtype}")
        size = int(np.prod([int(n) for n in self.shape], dtype=object)) * self.dtype.itemsize
        if size != info.file_size - self.stream.tell():
            raise RecordingError(f"{self.where} must have {size} bytes by its header, got another number")

    def __enter__(self) -> "_Member":
        return self

    def __exit__(self, *_: object) -> None:
        self.stream.close()

    def read(self, rows: int | None) -> Iterator[NDArray]:
        """Rows, piece by piece."""
        count, width = self.shape[0], int(np.prod(self.shape[1:], dtype=int))
        rows = rows or max(count, 1)
        for first in range(0, count, rows):
            n = min(rows, count - first)
            data = self.stream.read(n * width * self.dtype.itemsize)
            if len(data) != n * width * self.dtype.itemsize:
                raise RecordingError(f"{self.where} is cut off")
            values = np.frombuffer(data, dtype=self.dtype).reshape(n, *self.shape[1:])
            yield values.astype(object) if self.dtype.kind == "U" else values


def _matlab(path: Path, file: FileFormat, columns: tuple, text: Column | None, rows: int | None) -> Iterator[Piece]:
    """Variables of a MATLAB file up to version 7, which is loaded whole."""
    from scipy.io import loadmat

    raw = path.read_bytes()  # a broken file is parsed in memory
    if raw[:8] == b"\x89HDF\r\n\x1a\n" or b"MATLAB 7.3" in raw[:128]:
        raise RecordingError(f"{path.name} is a MATLAB 7.3 file (HDF5): save it in MATLAB with '-v7', or as text")
    wanted = [file.variable] if file.variable is not None else [str(column) for column in columns]
    found = loadmat(io.BytesIO(raw), variable_names=wanted)
    for name in wanted:
        if name not in found:
            raise RecordingError(f"{path.name} must have the variable {name!r}")
    if file.variable is not None:
        matrix = np.asarray(found[file.variable])
        if matrix.ndim != 2:
            raise RecordingError(f"{path.name}: {file.variable!r} must have 2 dimensions, got shape {matrix.shape}")
        _require_numbers(path, columns, matrix.shape[1])
        arrays = {column: matrix[:, int(column) - 1] for column in columns}
    else:
        arrays = {column: _line(path, str(column), found[str(column)]) for column in columns}
        _require_one_length(path, {column: len(array) for column, array in arrays.items()})
    count = len(next(iter(arrays.values())))
    for first in range(0, count, rows or max(count, 1)):
        yield {column: array[first : first + (rows or count)] for column, array in arrays.items()}


def _line(path: Path, name: str, values: Any) -> NDArray:
    """A row or column of a MATLAB file as one dimension; a cell array of texts as texts."""
    values = np.asarray(values)
    if values.ndim == 2 and 1 in values.shape:
        values = values.reshape(-1)
    if values.ndim != 1:
        raise RecordingError(f"{path.name}: {name!r} must be a row or a column, got shape {values.shape}")
    if values.dtype == object:
        return np.array([str(v.flat[0]) if isinstance(v, np.ndarray) and v.size == 1 else None for v in values], object)
    return np.char.rstrip(values).astype(object) if values.dtype.kind == "U" else values


def _require_numbers(path: Path, columns: tuple, width: int) -> None:
    for column in columns:
        if int(column) > width:
            raise RecordingError(f"{path.name} must have the column {column}, got {width} columns")


def _require_one_length(path: Path, lengths: dict[Column, int]) -> None:
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{column!r}: {length}" for column, length in lengths.items())
        raise RecordingError(f"{path.name} must hold columns of one length, got {told[:200]}")
