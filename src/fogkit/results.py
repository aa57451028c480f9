"""What every result that is a record of numbers can do: become a table, and go to text and back."""

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Self

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
        data = json.loads(text)
        if data.pop("kind", None) != cls.__name__:
            raise ValueError(f"`text` must be that of a {cls.__name__}, got {text[:60]!r}")
        return cls(**data)
