"""What a recording is: file, columns, units by name, clock, place and plan, as ``recording.toml`` gives them.

A whole description::

    version = 1

    [file]
    path = "unit7.csv"
    delimiter = ";"

    [clock]
    column = "t"
    unit = "ms"

    [gyro]
    columns = ["w1", "w2", "w3"]
    unit = "deg/s"
    axes = ["x", "-z", "y"]

    [accel]
    columns = ["a1", "a2", "a3"]
    unit = "m/s"
    quantity = "increments"

    [place]
    latitude = 59.9
    latitude_unit = "deg"

    [plan]
    kind = "six-positions"
    duration = 120.0

Only ``version``, ``[file]``, ``[clock]`` and ``[gyro]`` must be there. A key that is not known is an error.
"""

import codecs
import tomllib
from dataclasses import dataclass, field, fields
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Self

import numpy as np

from fogkit import checks
from fogkit.imu.tables import ACCEL_COLUMNS, GYRO_COLUMNS
from fogkit.io.errors import RecordingError, first_sentence
from fogkit.io.plain_toml import toml_text
from fogkit.io.plan_names import PlanReference
from fogkit.io.unit_names import ZERO, checked_unit, si_factor

VERSION = 1
"""Version of the description's form; another one is refused."""

KINDS = {
    **dict.fromkeys((".csv", ".tsv", ".txt", ".dat"), "csv"),
    **dict.fromkeys((".parquet", ".pq"), "parquet"),
    **{".npz": "npz", ".mat": "matlab"},
}
"""Kind of a file by its suffix, where the description does not say."""

AXES = tuple(sign + axis for sign in ("", "-") for axis in "xyz")

QUANTITIES = {"gyro": ("angular rate", "angle"), "accel": ("acceleration", "velocity")}
"""Kind of unit of rates and of increments."""

LARGEST_SAMPLE_RATE = 1e6

Column = str | int


@dataclass(frozen=True, kw_only=True)
class FileFormat:
    """Where the numbers stand.

    Parameters
    ----------
    path : str
        The data file; a relative path counts from the folder of the description.
    kind : {"csv", "parquet", "npz", "matlab"}, optional
        By the suffix of the path if not given: ``.csv``, ``.tsv``, ``.txt``, ``.dat``; ``.parquet``, ``.pq``; ``.npz``;
        ``.mat``.
    delimiter : str, optional
        One character, or ``"whitespace"`` for any run of blanks, of a text file; a tab for ``.tsv``, else a comma.
    decimal : {".", ","}, optional
        Decimal mark of a text file.
    header : bool, optional
        Whether a text file begins with a row of names. Without one, columns are numbers, from 1.
    skip_rows : int, optional
        Rows of a text file before the header or the first numbers.
    encoding : str, optional
        Encoding of a text file.
    variable : str, optional
        Name of a two-dimensional array, one row per sample, in an NPZ or MATLAB file: columns are numbers, from 1.
        Without it, columns are names of one-dimensional arrays.
    rows : int, optional
        Samples that the file holds; another number is an error.
    """

    path: str
    kind: str = ""
    delimiter: str = ""
    decimal: str = "."
    header: bool = True
    skip_rows: int = 0
    encoding: str = "utf-8"
    variable: str | None = None
    rows: int | None = None

    def __post_init__(self) -> None:
        _text("path", self.path)
        suffix = Path(self.path).suffix.lower()
        kind = checks.instance("kind", self.kind, str) or KINDS.get(suffix, "")
        fix = "" if self.kind else f"The suffix {suffix!r} of `path` does not say it."
        object.__setattr__(self, "kind", checks.option("kind", kind, ("csv", "parquet", "npz", "matlab"), fix=fix))
        delimiter = checks.instance("delimiter", self.delimiter, str) or ("\t" if suffix == ".tsv" else ",")
        if delimiter != "whitespace" and (len(delimiter) != 1 or not delimiter.isascii() or delimiter in "\r\n\"'"):
            raise ValueError(f"`delimiter` must be one ASCII character or 'whitespace', got {delimiter[:20]!r}")
        object.__setattr__(self, "delimiter", delimiter)
        checks.option("decimal", self.decimal, (".", ","))
        if delimiter == self.decimal:
            raise ValueError(f"`delimiter` and `decimal` must differ, got {delimiter!r} for both")
        if (delimiter.isalnum() and delimiter != "whitespace") or delimiter in "+-":
            raise ValueError(f"`delimiter` must be no part of a number, got {delimiter!r}")
        checks.instance("header", self.header, bool)
        object.__setattr__(self, "skip_rows", checks.integer("skip_rows", self.skip_rows, minimum=0))
        checks.instance("encoding", self.encoding, str)
        try:
            known = codecs.lookup(self.encoding)
        except (LookupError, ValueError):
            raise ValueError(f"`encoding` must be one that Python knows, got {self.encoding[:40]!r}") from None
        if not known._is_text_encoding:
            raise ValueError(f"`encoding` must be one of text, got {self.encoding!r}")
        if self.variable is not None:
            _text("variable", self.variable)
            if self.kind not in ("npz", "matlab"):
                raise ValueError(f"`variable` must be given for NPZ and MATLAB files only, got it for {self.kind!r}")
        if self.rows is not None:
            object.__setattr__(self, "rows", checks.integer("rows", self.rows, minimum=1))

    @property
    def numbered(self) -> bool:
        """Whether columns are numbers, from 1, and no names."""
        return self.variable is not None or (self.kind == "csv" and not self.header)


@dataclass(frozen=True, kw_only=True)
class Clock:
    """When the samples were taken.

    Parameters
    ----------
    column : str or int, optional
        Column of the time at which each sample begins.
    unit : str, optional
        Unit of that column.
    sample_rate : float, optional
        Samples per second, Hz. At least one of `column` and `sample_rate` is needed; with both, they are compared.
    second_column : str or int, optional
        Column of another clock, against which the first is checked.
    second_unit : str, optional
        Unit of that column.
    """

    column: Column | None = None
    unit: str | None = None
    sample_rate: float | None = None
    second_column: Column | None = None
    second_unit: str | None = None

    def __post_init__(self) -> None:
        if self.column is None and self.sample_rate is None:
            raise ValueError("`column` or `sample_rate` must be given: nothing else says when samples were taken")
        for column, unit in (("column", "unit"), ("second_column", "second_unit")):
            if getattr(self, column) is None:
                if getattr(self, unit) is not None:
                    raise ValueError(f"`{unit}` must not be given without `{column}`")
                continue
            _column(column, getattr(self, column))
            checked_unit("time", getattr(self, unit), unit)
        if self.sample_rate is not None:
            rate = checks.positive("sample_rate", self.sample_rate, "Hz")
            object.__setattr__(
                self, "sample_rate", checks.in_closed_interval("sample_rate", rate, 1e-6, LARGEST_SAMPLE_RATE, "Hz")
            )


@dataclass(frozen=True, kw_only=True)
class Channels:
    """Three gyros or three accelerometers.

    Parameters
    ----------
    columns : sequence of str or int
        Columns of the three sensors.
    unit : str
        What they hold: a unit of the kind that `quantity` says.
    quantity : {"rates", "increments"}, optional
        Means over each sample (rad/s, m/s^2 in SI), or integrals over it (rad, m/s).
    axes : sequence of str, optional
        Body axis along which each column reads, with its sign: ``["x", "-z", "y"]``.
    scale : float, optional
        Size in `unit` of one of the column's counts.
    """

    columns: tuple[Column, ...]
    unit: str
    quantity: str = "rates"
    axes: tuple[str, ...] = ("x", "y", "z")
    scale: float = 1.0

    def __post_init__(self) -> None:
        for name in ("columns", "axes"):
            values = getattr(self, name)
            if not isinstance(values, list | tuple) or len(values) != 3:
                raise ValueError(f"`{name}` must be three, got {_short(values)}")
            object.__setattr__(self, name, tuple(values))
        for column in self.columns:
            _column("columns", column)
        for axis in self.axes:
            checks.option("axes", axis, AXES)
        if len({axis[-1] for axis in self.axes}) != 3:
            raise ValueError(f"`axes` must name x, y and z once each, got {', '.join(self.axes)}")
        checks.option("quantity", self.quantity, ("rates", "increments"))
        checks.instance("unit", self.unit, str)
        object.__setattr__(self, "scale", checks.positive("scale", self.scale))

    @property
    def by_axis(self) -> tuple[tuple[Column, int], ...]:
        """Column and sign for the body axes x, y, z."""
        pairs = zip(self.columns, self.axes, strict=True)
        found = {axis[-1]: (column, -1 if axis[0] == "-" else 1) for column, axis in pairs}
        return tuple(found[axis] for axis in "xyz")

    def factor(self, sensor: str, dt: float) -> float:
        """What takes a number of the file to rad/s or m/s^2, for the sensors "gyro" or "accel"."""
        kind = QUANTITIES[sensor][self.quantity == "increments"]
        return self.scale * si_factor(kind, self.unit) / (dt if self.quantity == "increments" else 1.0)


@dataclass(frozen=True, kw_only=True)
class RecordingDescription:
    """Everything that has to be known of a recording beside its numbers.

    Parameters
    ----------
    file : FileFormat
        Where the numbers stand.
    clock : Clock
        When the samples were taken.
    gyro : Channels
        Gyros.
    accel : Channels, optional
        Accelerometers, if they were recorded.
    temperatures : dict, optional
        Column by name of the sensor: ``{"coil": "T1"}`` becomes the column ``temperature_coil``.
    temperature_unit : str, optional
        Unit of all of them.
    angle : str or int, optional
        Column of the angle of a table or mount, whole turns included.
    angle_unit : str, optional
        Its unit.
    position : str or int, optional
        Column of the label of the position; empty between positions.
    latitude : float, optional
        Geodetic latitude, rad.
    gravity : float, optional
        Gravity, m/s^2; normal gravity of the latitude if not given.
    plan : PlanReference, optional
        What the operator did.

    Raises
    ------
    ValueError, TypeError
        If something is missing, of the wrong kind or out of range, or a column stands for two things.
    """

    file: FileFormat
    clock: Clock
    gyro: Channels
    accel: Channels | None = None
    temperatures: dict[str, Column] = field(default_factory=dict)
    temperature_unit: str | None = None
    angle: Column | None = None
    angle_unit: str | None = None
    position: Column | None = None
    latitude: float | None = None
    gravity: float | None = None
    plan: PlanReference | None = None

    def __post_init__(self) -> None:
        checks.instance("file", self.file, FileFormat)
        checks.instance("clock", self.clock, Clock)
        for sensor in ("gyro", "accel"):
            channels = getattr(self, sensor)
            if channels is not None or sensor == "gyro":
                checks.instance(sensor, channels, Channels)
                kind = QUANTITIES[sensor][channels.quantity == "increments"]
                _within(f"[{sensor}]", lambda c=channels, k=kind: checked_unit(k, c.unit))
        checks.instance("temperatures", self.temperatures, dict)
        object.__setattr__(self, "temperatures", dict(self.temperatures))
        for name, column in self.temperatures.items():
            if not isinstance(name, str) or not name.isidentifier():
                raise ValueError(f"`temperatures` must have names of letters, digits and _, got {_short(name)}")
            _column(f"temperatures.{name}", column)
        if self.temperatures:
            checked_unit("temperature", self.temperature_unit, "temperature_unit")
        if self.angle is not None:
            _column("angle", self.angle)
            checked_unit("angle", self.angle_unit, "angle_unit")
        if self.position is not None:
            _column("position", self.position)
        if self.latitude is not None:
            fix = "Give degrees with `latitude_unit = 'deg'`."
            latitude = checks.in_closed_interval("latitude", self.latitude, -np.pi / 2, np.pi / 2, "rad", fix=fix)
            object.__setattr__(self, "latitude", latitude)
        if self.gravity is not None:
            gravity = checks.in_closed_interval("gravity", self.gravity, 9.7, 9.9, "m/s^2")
            object.__setattr__(self, "gravity", gravity)
        if self.plan is not None:
            checks.instance("plan", self.plan, PlanReference)
        self._check_columns()

    def _check_columns(self) -> None:
        """``ValueError`` if a column is used twice, or is a number where there are names, or the reverse."""
        seen: set[Column] = set()
        for column in self.columns:
            if column in seen:
                raise ValueError(f"column {column!r} must stand for one thing only, got it twice")
            seen.add(column)
            if isinstance(column, int) != self.file.numbered:
                needed = "numbers from 1" if self.file.numbered else "names"
                raise ValueError(f"columns of this file must be {needed}, got {_short(column)}")

    @property
    def names(self) -> tuple[str, ...]:
        """Columns of the table that are numbers, in their order; without the time."""
        names = [
            *GYRO_COLUMNS,
            *(ACCEL_COLUMNS if self.accel else ()),
            *(f"temperature_{t}" for t in self.temperatures),
        ]
        names += ["angle"] if self.angle is not None else []
        return (*names, *(["clock"] if self.clock.second_column is not None else []))

    def sources(self, dt: float) -> dict[str, tuple[Column, float, float]]:
        """For each of `names`: the column of the file, the factor to SI and what is added then."""
        found: dict[str, tuple[Column, float, float]] = {}
        for sensor, columns in (("gyro", GYRO_COLUMNS), ("accel", ACCEL_COLUMNS)):
            if channels := getattr(self, sensor):
                factor = channels.factor(sensor, dt)
                for name, (column, sign) in zip(columns, channels.by_axis, strict=True):
                    found[name] = (column, sign * factor, 0.0)
        for name, column in self.temperatures.items():
            unit = str(self.temperature_unit)
            found[f"temperature_{name}"] = (column, si_factor("temperature", unit), ZERO[unit])
        if self.angle is not None:
            found["angle"] = (self.angle, si_factor("angle", str(self.angle_unit)), 0.0)
        if self.clock.second_column is not None:
            found["clock"] = (self.clock.second_column, si_factor("time", str(self.clock.second_unit)), 0.0)
        return found

    @property
    def columns(self) -> tuple[Column, ...]:
        """All columns of the file that are used."""
        numbers = [column for column, *_ in self.sources(1.0).values()]
        return tuple(c for c in (self.clock.column, *numbers, self.position) if c is not None)

    @classmethod
    def from_toml(cls, text: str, *, name: str = "recording.toml") -> Self:
        """Description from its text.

        Raises
        ------
        RecordingError
            If the text is no TOML, of another version, or holds what it must not; the message names the place.
        """
        try:
            data = tomllib.loads(text)
        except Exception as error:  # deep nesting ends in a RecursionError, huge numbers in others
            raise RecordingError(f"{name} is not valid TOML: {first_sentence(error)}") from None
        try:
            return _from_tables(cls, data)
        except (ValueError, TypeError, OverflowError) as error:
            raise RecordingError(f"{name}: {first_sentence(error, 400)}") from None

    def to_toml(self) -> str:
        """Text from which `from_toml` makes an equal description."""
        return toml_text(_to_tables(self))


def read_description(path: str | Path) -> RecordingDescription:
    """Description from a file; `RecordingError` if it cannot be read or is not one."""
    path = Path(path)
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise RecordingError(f"{path.name} cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError as error:
        raise RecordingError(f"{path.name} must be UTF-8 text, got byte {error.start} that is none") from None
    return RecordingDescription.from_toml(text, name=path.name)


_TABLES = ("version", "file", "clock", "gyro", "accel", "temperature", "angle", "position", "place", "plan")


def _from_tables(cls: type, data: dict[str, Any]) -> Any:
    """Description from the tables of its text."""
    _known("the description", data, _TABLES)
    if "version" not in data:
        raise ValueError(f"`version` must be given, {VERSION} for this form")
    if isinstance(data["version"], bool) or data["version"] != VERSION:
        raise ValueError(f"`version` must be {VERSION}, got {_short(data['version'])}")
    values: dict[str, Any] = {}
    for name, kind in (("file", FileFormat), ("clock", Clock), ("gyro", Channels), ("accel", Channels)):
        if name in data:
            values[name] = _within(f"[{name}]", lambda n=name, k=kind: _record(k, n, data[n]))
        elif name != "accel":
            raise ValueError(f"[{name}] must be given")
    if "temperature" in data:
        table = dict(_table("temperature", data["temperature"]))
        if "unit" not in table:
            raise ValueError("[temperature]: `unit` must be given")
        values |= {"temperature_unit": table.pop("unit"), "temperatures": table}
    for name, keys in (("angle", ("column", "unit")), ("position", ("column",))):
        if name in data:
            table = _table(name, data[name])
            _known(f"[{name}]", table, keys, required=keys)
            values[name] = table["column"]
            if "unit" in keys:
                values["angle_unit"] = table["unit"]
    if "place" in data:
        values |= _within("[place]", lambda: _place(_table("place", data["place"])))
    if "plan" in data:
        table = _table("plan", data["plan"])
        values["plan"] = _within("[plan]", lambda: PlanReference.from_table(table))
    return cls(**values)


def _place(table: dict[str, Any]) -> dict[str, float]:
    _known("[place]", table, ("latitude", "latitude_unit", "gravity"))
    values = {}
    if "latitude" in table:
        if "latitude_unit" not in table:
            raise ValueError("`latitude_unit` must be given with `latitude`: 'deg' or 'rad'")
        factor = si_factor("angle", table["latitude_unit"])
        latitude = checks.finite("latitude", table["latitude"])
        values["latitude"] = latitude * factor
    elif "latitude_unit" in table:
        raise ValueError("`latitude_unit` must not be given without `latitude`")
    return values | ({"gravity": table["gravity"]} if "gravity" in table else {})


def _to_tables(description: RecordingDescription) -> dict[str, Any]:
    """Tables of the text, without what has its default."""
    data: dict[str, Any] = {"version": VERSION}
    for name in ("file", "clock", "gyro", "accel"):
        if (value := getattr(description, name)) is not None:
            table = {f.name: getattr(value, f.name) for f in fields(value)}
            keep = {f.name: f.default for f in fields(value)}
            kept = {key: entry for key, entry in table.items() if entry is not None and entry != keep[key]}
            last = {key: kept.pop(key) for key in ("path", "columns", "unit") if key in kept}
            data[name] = kept | last  # what must be there comes last: a text that is cut off is then no description
    if description.temperatures:
        data["temperature"] = {"unit": description.temperature_unit, **description.temperatures}
    if description.angle is not None:
        data["angle"] = {"column": description.angle, "unit": description.angle_unit}
    if description.position is not None:
        data["position"] = {"column": description.position}
    place = {}
    if description.latitude is not None:
        place = {"latitude": description.latitude, "latitude_unit": "rad"}
    if description.gravity is not None:
        place["gravity"] = description.gravity
    if place:
        data["place"] = place
    if description.plan is not None:
        data["plan"] = {"kind": description.plan.kind, **description.plan.parameters}
    return data


def _record(kind: type, name: str, table: Any) -> Any:
    """One record from its table."""
    table = _table(name, table)
    known = [f.name for f in fields(kind)]
    required = {"file": ("path",), "gyro": ("columns", "unit"), "accel": ("columns", "unit")}.get(name, ())
    _known("", table, known, required=required)
    return kind(**table)


def _table(name: str, value: Any) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise TypeError(f"[{name}] must be a table, got {_short(value)}")
    return value


def _known(where: str, table: dict[str, Any], known, required=()) -> None:
    """``ValueError`` for a key that is not known, or one that is missing."""
    prefix = f"{where}: " if where else ""
    for key in table:
        if key not in known:
            near = get_close_matches(key, known, n=1)
            hint = f"Did you mean `{near[0]}`?" if near else f"Known are {', '.join(known)}."
            raise ValueError(f"{prefix}`{key[:40]}` is not a known key. {hint}")
    for key in required:
        if key not in table:
            raise ValueError(f"{prefix}`{key}` must be given")


def _within(where: str, build: Any) -> Any:
    """What a function makes; its error says where in the description."""
    try:
        return build()
    except (ValueError, TypeError, OverflowError) as error:
        raise type(error)(f"{where}: {error}") from None


def _text(name: str, value: Any) -> None:
    checks.instance(name, value, str)
    if not value or "\0" in value:
        raise ValueError(f"`{name}` must be a non-empty text without null bytes, got {value[:40]!r}")


def _column(name: str, value: Any) -> None:
    """``TypeError`` or ``ValueError`` for what names no column."""
    if isinstance(value, bool) or not isinstance(value, str | int):
        raise TypeError(f"`{name}` must be a name or a number from 1, got {_short(value)}")
    if isinstance(value, str):
        _text(name, value)
    elif not 1 <= value <= 100_000:
        raise ValueError(f"`{name}` must be a name or a number from 1, got {_short(value)}")


def _short(value: Any) -> str:
    try:
        text = repr(value)
    except ValueError:  # Python refuses to print very long integers
        return "a very long number"
    return text if len(text) <= 60 else text[:57] + "..."
