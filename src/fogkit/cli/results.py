"""What every command gives back: estimates with covariance, checks, inputs, versions; JSON that loads back exactly."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.io.errors import RecordingError
from fogkit.io.verdicts import Finding
from fogkit.results import FrozenArrays

VERSION = 1
"""Version of the form; another one is refused."""

KIND = "fogkit result"

Array = NDArray[np.float64]

Table = Mapping[str, Any]
"""Columns by name: arrays of numbers, or sequences of text."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Estimates(FrozenArrays):
    """Named quantities and how sure they are.

    Parameters
    ----------
    names : sequence of str
        Names, each once.
    units : sequence of str
        Units of the values: SI.
    values : array_like, shape (n,)
        Estimates.
    covariance : array_like, shape (n, n), optional
        Their covariance; None if nothing is known of it.
    """

    names: Sequence[str] = ()
    units: Sequence[str] = ()
    values: Any = field(default_factory=lambda: np.zeros(0))
    covariance: Any = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", tuple(self.names))
        object.__setattr__(self, "units", tuple(self.units))
        n = len(self.names)
        if len(set(self.names)) != n or len(self.units) != n:
            raise ValueError(f"`names` must differ, and have one unit each, got {n} names, {len(self.units)} units")
        values = np.array(self.values, dtype=float)
        if values.shape != (n,):
            raise ValueError(f"`values` must have shape ({n},), got {values.shape}")
        object.__setattr__(self, "values", values)
        if self.covariance is not None:
            covariance = np.array(self.covariance, dtype=float)
            if covariance.shape != (n, n):
                raise ValueError(f"`covariance` must have shape ({n}, {n}), got {covariance.shape}")
            object.__setattr__(self, "covariance", covariance)
        super().__post_init__()

    def __len__(self) -> int:
        return len(self.names)

    @property
    def standard_deviation(self) -> Array | None:
        """Standard deviations, shape (n,), or None."""
        return None if self.covariance is None else np.sqrt(np.diagonal(self.covariance))

    def of(self, name: str) -> float:
        """Value of a quantity; ``KeyError`` if there is none of that name."""
        if name not in self.names:
            raise KeyError(f"no estimate {name!r}; there are {', '.join(self.names)}")
        return float(self.values[self.names.index(name)])

    def joined(self, other: "Estimates") -> "Estimates":
        """Both, taken as independent of each other; no covariance if one has none."""
        if not len(self):
            return other
        covariance = None
        if self.covariance is not None and other.covariance is not None:
            n = len(self)
            covariance = np.zeros((n + len(other),) * 2)
            covariance[:n, :n], covariance[n:, n:] = self.covariance, other.covariance
        return Estimates(
            names=[*self.names, *other.names],
            units=[*self.units, *other.units],
            values=np.concatenate([self.values, other.values]),
            covariance=covariance,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Result:
    """What a command found.

    Parameters
    ----------
    command : str
        The command: ``"calibrate multiposition"``.
    estimates : Estimates, optional
        What was estimated.
    findings : sequence of Finding, optional
        Checks of the recording and of the result, warnings included.
    inputs : sequence of dict, optional
        Files that were read: ``name``, ``sha256``, ``bytes``.
    parameters : dict, optional
        Arguments of the command and what it took of a description, plain values.
    versions : dict, optional
        Versions of what computed it.
    tables : dict, optional
        Further numbers by name, each a `Table`: what the figures of a report are drawn from.
    correction : dict, optional
        How `fogkit.cli.corrections` makes readings true.

    Notes
    -----
    Two results are equal if their texts are; numbers that are not finite are equal to themselves.
    """

    command: str
    estimates: Estimates = field(default_factory=Estimates)
    findings: Sequence[Finding] = ()
    inputs: Sequence[Mapping[str, Any]] = ()
    parameters: Mapping[str, Any] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)
    tables: Mapping[str, Table] = field(default_factory=dict)
    correction: Mapping[str, Any] | None = None

    def __post_init__(self) -> None:
        checks.instance("estimates", self.estimates, Estimates)
        object.__setattr__(self, "findings", tuple(self.findings))
        object.__setattr__(self, "inputs", tuple(dict(entry) for entry in self.inputs))
        frozen = {name: {c: _column(values) for c, values in table.items()} for name, table in self.tables.items()}
        object.__setattr__(self, "tables", frozen)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Result) and self.to_json() == other.to_json()

    __hash__ = None  # type: ignore[assignment]

    @property
    def severity(self) -> str:
        """The worst of all findings: good, doubtful or bad."""
        order = ("good", "doubtful", "bad")
        return max((f.severity for f in self.findings), key=order.index, default="good")

    def to_json(self) -> str:
        """Text from which `from_json` makes an equal result, every bit of every number included."""
        e = self.estimates
        data = {
            "kind": KIND,
            "version": VERSION,
            "command": self.command,
            "estimates": {
                "names": list(e.names),
                "units": list(e.units),
                "values": _numbers(e.values),
                "standard_deviation": None if e.covariance is None else _numbers(e.standard_deviation),
                "covariance": None if e.covariance is None else [_numbers(row) for row in e.covariance],
            },
            "findings": [{k: _plain(v) for k, v in asdict(f).items()} for f in self.findings],
            "inputs": _plain(self.inputs),
            "parameters": _plain(self.parameters),
            "versions": dict(self.versions),
            "tables": {name: {c: _packed(v) for c, v in t.items()} for name, t in self.tables.items()},
            "correction": _plain(self.correction),
        }
        return json.dumps(data, indent=1, allow_nan=False, ensure_ascii=False) + "\n"

    @classmethod
    def from_json(cls, text: str, *, name: str = "the result") -> Self:
        """Result from its text; `RecordingError` of one sentence if it is none, or of another version."""
        try:
            data = json.loads(text)
        except (ValueError, RecursionError):
            raise RecordingError(f"{name} is not valid JSON") from None
        if not isinstance(data, dict) or data.get("kind") != KIND:
            raise RecordingError(f"{name} is no result of fogkit: its `kind` is not {KIND!r}")
        if data.get("version") != VERSION:
            raise RecordingError(f"{name} is of version {data.get('version')!r} of the form, not {VERSION}")
        try:
            e = data["estimates"]
            n = len(e["names"])
            covariance = e["covariance"]
            if covariance is not None:
                covariance = np.array([_floats(row) for row in covariance], dtype=float).reshape(n, n)
            estimates = Estimates(
                names=e["names"], units=e["units"], values=_floats(e["values"]), covariance=covariance
            )
            return cls(
                command=data["command"],
                estimates=estimates,
                findings=[Finding(**{k: _restored(v) for k, v in f.items()}) for f in data["findings"]],
                inputs=_restored(data["inputs"]),
                parameters=_restored(data["parameters"]),
                versions=data["versions"],
                tables={t: {c: _unpacked(v) for c, v in table.items()} for t, table in data["tables"].items()},
                correction=_restored(data["correction"]),
            )
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise RecordingError(f"{name} is damaged: {type(error).__name__} {error}") from None


def table_of(frame: Any) -> dict[str, Any]:
    """A pandas table as columns, its named index first."""
    frame = frame.reset_index() if frame.index.name is not None else frame
    return {str(c): frame[c].to_numpy() for c in frame.columns}


def _column(values: Any) -> Any:
    """Numbers as an array that cannot be written to, anything else as text."""
    array = np.array(values)
    if array.dtype.kind not in "fiub":
        return tuple("" if v is None else str(v) for v in np.asarray(values, dtype=object).ravel().tolist())
    array = array.astype(float)
    array.setflags(write=False)
    return array


def _number(value: float) -> float | str:
    return value if math.isfinite(value) else repr(value)


def _numbers(values: Any) -> list:
    return [_number(v) for v in np.asarray(values, dtype=float).tolist()]


def _floats(values: Sequence) -> Array:
    return np.array([float(v) for v in values], dtype=float)


def _packed(values: Any) -> Any:
    return {"numbers": _numbers(values)} if isinstance(values, np.ndarray) else list(values)


def _unpacked(values: Any) -> Any:
    return _floats(values["numbers"]) if isinstance(values, dict) else tuple(values)


def _plain(value: Any) -> Any:
    """Plain values for JSON; a number that is not finite becomes ``{"float": "nan"}``."""
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [_plain(v) for v in (value.tolist() if isinstance(value, np.ndarray) else value)]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return {"float": repr(value)}
    return value if value is None or isinstance(value, bool | int | float | str) else str(value)


def _restored(value: Any) -> Any:
    if isinstance(value, dict):
        return float(value["float"]) if set(value) == {"float"} else {k: _restored(v) for k, v in value.items()}
    return [_restored(v) for v in value] if isinstance(value, list) else value
