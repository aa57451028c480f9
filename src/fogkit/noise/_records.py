"""Text form of the results of this package that hold arrays and coefficients."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, fields
from typing import Any, Self

import numpy as np

from fogkit.noise.processes import RandomErrors
from fogkit.results import FrozenArrays, contents


class ArrayRecord(FrozenArrays):
    """Mixin of frozen dataclasses of numbers, arrays, names, `RandomErrors` and other such records."""

    def to_json(self) -> str:
        """Text from which `from_json` makes an equal record, every bit of every number included."""
        values = {field.name: _encoded(getattr(self, field.name)) for field in fields(self)}
        return json.dumps({"kind": type(self).__name__} | values, allow_nan=False)

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Record from the text of `to_json`; ``ValueError`` if that was of another kind."""
        return cls(**{name: _decoded(value) for name, value in contents(text, cls.__name__).items()})


def _encoded(value: Any) -> Any:
    """Value as strict JSON has it; what is no number, text or None says its kind."""
    if isinstance(value, np.ndarray):
        return {"array": value.tolist(), "dtype": str(value.dtype)}
    if isinstance(value, RandomErrors):
        return {"errors": asdict(value)}
    if isinstance(value, ArrayRecord):
        return {"record": value.to_json(), "of": type(value).__name__}
    if isinstance(value, tuple):
        return {"tuple": [_encoded(entry) for entry in value]}
    return {"number": repr(value)} if isinstance(value, float) and not math.isfinite(value) else value


def _decoded(value: Any) -> Any:
    """Inverse of `_encoded`."""
    if not isinstance(value, dict):
        return value
    if "array" in value:
        return np.array(value["array"], dtype=value["dtype"])
    if "errors" in value:
        return RandomErrors(**value["errors"])
    if "record" in value:
        kinds = {kind.__name__: kind for kind in ArrayRecord.__subclasses__()}
        return kinds[value["of"]].from_json(value["record"])
    return tuple(map(_decoded, value["tuple"])) if "tuple" in value else float(value["number"])
