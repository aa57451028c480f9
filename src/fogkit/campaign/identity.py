"""Which case is it: what its values are as text, its digest, and the random stream that belongs to it alone."""

import hashlib
import importlib
import inspect
import json
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import PurePath
from typing import Any

import numpy as np

LARGEST = 2**53
"""Whole numbers up to this one are exact as float64 too."""

ARRAY_IN_FULL = 64
"""Entries up to which an array among the inputs is written in full; a longer one by its digest."""

FIX = "Give numbers, text, lists, dicts, arrays or dataclasses of these, and make anything else inside the function"


def plain(value: Any) -> Any:
    """A NumPy scalar as a Python one; anything else as it is."""
    return value.item() if isinstance(value, np.generic) else value


def encoded(name: str, value: Any, *, full: bool = True) -> Any:
    """Value in terms of JSON; a ``TypeError`` that begins with `name` if it is of a kind that cannot be.

    A dataclass is a dict of its fields with its class; an array a list, or, unless `full`, its digest if it is long.
    """
    value = plain(value)
    if value is None or (isinstance(value, bool | int | float | str) and not isinstance(value, Enum)):
        return value
    if isinstance(value, Enum):
        return {"class": qualified_name(type(value)), "name": value.name}
    if isinstance(value, PurePath):
        return str(value)
    if is_dataclass(value) and not isinstance(value, type):
        inner = {f.name: encoded(f"{name}.{f.name}", getattr(value, f.name), full=full) for f in fields(value)}
        return {"class": qualified_name(type(value)), **inner}
    if isinstance(value, np.ndarray) and value.dtype.kind in "biufU":
        if full or value.size <= ARRAY_IN_FULL:
            return value.tolist()
        digest = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
        return {"dtype": str(value.dtype), "shape": list(value.shape), "sha256": digest}
    if isinstance(value, list | tuple):
        return [encoded(f"{name}[{i}]", inner, full=full) for i, inner in enumerate(value)]
    if isinstance(value, Mapping) and all(isinstance(key, str) for key in value):
        return {key: encoded(f"{name}[{key!r}]", inner, full=full) for key, inner in value.items()}
    if isinstance(value, type) or inspect.isroutine(value):
        return importable_name(name, value)
    raise TypeError(f"{name} cannot be stored: it is a {type(value).__name__}. {FIX}")


def case_identity(inputs: Mapping[str, Any]) -> str:
    """Digest of the encoded inputs of a case, 32 hexadecimal digits; equal values in any order of names have one."""
    text = json.dumps(_whole(inputs), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def _whole(value: Any) -> Any:
    """Encoded value with 1.0 as 1: a table turns whole numbers into floats when one of its rows needs it."""
    if isinstance(value, float) and value.is_integer():
        return int(value)
    if isinstance(value, list):
        return [_whole(inner) for inner in value]
    if isinstance(value, dict):
        return {key: _whole(inner) for key, inner in value.items()}
    return value


def seed_text(seed: int, identity: str, repeat: int) -> str:
    """Seed of one run as text: entropy and spawn key of its ``SeedSequence``.

    The key is the digest of the case in four words, then the number of the repeat, as if spawned: a stream depends on
    these and on the campaign's seed, and on no other case.
    """
    words = [int(identity[i : i + 8], 16) for i in range(0, 32, 8)]
    return json.dumps({"entropy": seed, "spawn_key": [*words, repeat]})


def case_generator(seed: str) -> np.random.Generator:
    """The random stream of one run of a campaign, from the text in its column ``seed``, to repeat that run alone.

    Examples
    --------
    >>> third = np.random.default_rng(np.random.SeedSequence(7).spawn(3)[2])
    >>> case_generator('{"entropy": 7, "spawn_key": [2]}').random() == third.random()
    True
    """
    parts = json.loads(seed)
    return np.random.default_rng(np.random.SeedSequence(parts["entropy"], spawn_key=tuple(parts["spawn_key"])))


def qualified_name(thing: Any) -> str:
    """Module and name of a class or function."""
    return f"{thing.__module__}.{thing.__qualname__}"


def importable_name(argument: str, thing: Callable[..., Any]) -> str:
    """Module and name of a function or class that can be found by these; ``TypeError`` for a lambda and the like."""
    try:
        found = importlib.import_module(thing.__module__)
        for part in thing.__qualname__.split("."):
            found = getattr(found, part)
        if found is thing:
            return qualified_name(thing)
    except (AttributeError, ImportError, TypeError):
        pass  # a partial has no name, a lambda or inner function cannot be found by its own
    raise TypeError(
        f"{argument} must be a function that can be imported by its name, got {thing!r}. Define it in a module with "
        "def; arguments that stay the same go into `common`"
    )


def source_digest(function: Callable[..., Any]) -> str | None:
    """Digest of the text of a function, or None where it has none to read."""
    try:
        return hashlib.sha256(inspect.getsource(inspect.unwrap(function)).encode()).hexdigest()
    except (OSError, TypeError):
        return None
