"""What results can do: records of numbers become a table, and go to text and back; those of arrays cannot be edited."""

import json
from dataclasses import asdict, fields
from typing import TYPE_CHECKING, Any, Self

import numpy as np

if TYPE_CHECKING:
    from pandas import DataFrame


class Record:
    """Mixin of frozen dataclasses whose fields are all numbers."""

    def to_frame(self) -> "DataFrame":
        """Table with the index ``quantity`` and the column ``value``, in SI units."""
        import pandas as pd

        return pd.DataFrame({"value": asdict(self)}).rename_axis("quantity")

    def to_json(self) -> str:
        """Text from which `from_json` makes an equal record."""
        return json.dumps({"kind": type(self).__name__} | asdict(self))

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Record from the text of `to_json`; ``ValueError`` if that was of another kind."""
        return cls(**contents(text, cls.__name__))


def contents(text: str, kind: str) -> dict[str, Any]:
    """Fields of a record from its text, as `to_json` makes it; ``ValueError`` if that was of another kind."""
    data = json.loads(text)
    if not isinstance(data, dict) or data.pop("kind", None) != kind:
        raise ValueError(f"`text` must be that of a {kind}, got {text[:60]!r}")
    return data


class FrozenArrays:
    """Mixin of frozen dataclasses: arrays are kept as copies that cannot be written to.

    A covariance that is edited would no longer belong to its estimate.
    """

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                kept = value.copy()
                kept.setflags(write=False)
                object.__setattr__(self, field.name, kept)
