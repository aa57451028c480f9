"""The cases of a campaign: their arguments one by one, and all that can be wrong with them before the first run."""

import inspect
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from fogkit.campaign.identity import case_identity, encoded, plain

if TYPE_CHECKING:
    from pandas import DataFrame


def rows(cases: "DataFrame | list[Mapping[str, Any]]") -> Iterator[dict[str, Any]]:
    """Arguments of each case, NumPy scalars as Python's."""
    if isinstance(cases, list):
        for i, case in enumerate(cases):
            if not isinstance(case, Mapping) or not all(isinstance(key, str) for key in case):
                raise TypeError(f"`cases` must hold mappings of argument names to values, got {case!r} as case {i + 1}")
            yield {key: plain(value) for key, value in case.items()}
    else:
        names = list(cases.columns)
        if not all(isinstance(name, str) for name in names) or len(set(names)) < len(names):
            raise TypeError(f"`cases` must have the names of arguments for columns, each once, got {names}")
        for values in zip(*(cases[name] for name in names), strict=True):
            yield {name: plain(value) for name, value in zip(names, values, strict=True)}


def stored_inputs(case: Mapping[str, Any], place: int) -> dict[str, Any]:
    """Arguments of a case in the form that is stored."""
    return {
        key: encoded(f"`cases`: argument `{key}` of case {place + 1}", case[key], full=False) for key in sorted(case)
    }


def places_of(function: Callable[..., Any], cases: Any, common: Mapping[str, Any], seed: int | None) -> dict[str, int]:
    """Identity of each case with its place, after all that can be wrong with cases has been looked for."""
    places: dict[str, int] = {}
    first: set[str] = set()
    for place, case in enumerate(rows(cases)):
        if not place:
            first = set(case)
            _require_call(function, {**common, **case}, set(common) & first, seed)
        if set(case) != first:
            raise ValueError(
                f"`cases` must all have the same arguments, got {sorted(case)} in case {place + 1} and {sorted(first)} "
                "in the first"
            )
        identity = case_identity(stored_inputs(case, place))
        if identity in places:
            raise ValueError(
                f"`cases` must differ, but case {place + 1} is case {places[identity] + 1} again: {brief(case)}. For "
                "several runs of one case give `repeats` and `seed`"
            )
        places[identity] = place
    if not places:
        raise ValueError("`cases` must hold at least one case, got none")
    return places


def _require_call(function: Callable[..., Any], arguments: dict[str, Any], twice: set[str], seed: int | None) -> None:
    """Find out before the first run whether the function takes the arguments."""
    if twice:
        raise ValueError(f"`common` and `cases` both give {sorted(twice)}")
    if seed is not None:
        if "rng" in arguments:
            raise ValueError("`seed` gives each run its own `rng`, so neither `cases` nor `common` may hold one")
        arguments = arguments | {"rng": None}
    try:
        inspect.signature(function).bind(**arguments)
    except ValueError:
        return  # some built-in functions do not tell
    except TypeError as error:
        raise TypeError(f"`function` cannot be called with the arguments {sorted(arguments)}: {error}") from None


def brief(case: Mapping[str, Any]) -> str:
    """A case in a few words."""
    text = ", ".join(f"{key}={value!r}" for key, value in case.items())
    return text if len(text) < 200 else text[:200] + "..."
