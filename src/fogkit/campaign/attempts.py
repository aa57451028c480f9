"""One run, in the worker: outputs as what can be stored, or what went wrong."""

import time
import traceback
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from fogkit.campaign.identity import case_generator, encoded, qualified_name


def attempt(function: Callable[..., Any], arguments: dict[str, Any], seed: str | None, retries: int) -> dict[str, Any]:
    """One run, in the worker: outputs or what went wrong, as what can be stored; only the last attempt is timed."""
    row = {}
    for count in range(1, retries + 2):
        start = time.perf_counter()
        try:
            keywords = arguments if seed is None else arguments | {"rng": case_generator(seed)}
            outputs = _outputs(function(**keywords))
        except Exception as error:
            row = failure(error, count) | {"run_time": time.perf_counter() - start}
        else:
            good = {"output": outputs, "attempts": count, "exception": None, "message": None, "traceback": None}
            return good | {"run_time": time.perf_counter() - start}
    return row


def failure(error: BaseException, attempts: int) -> dict[str, Any]:
    """The part of a row that says what went wrong."""
    text = "".join(traceback.format_exception(error))
    return {
        "output": {},
        "attempts": attempts,
        "exception": qualified_name(type(error)).removeprefix("builtins."),
        "message": str(error),
        "traceback": text,
        "run_time": None,
    }


def _outputs(result: Any) -> dict[str, Any]:
    """Columns of a result."""
    if is_dataclass(result) and not isinstance(result, type):
        result = {field.name: getattr(result, field.name) for field in fields(result)}
    elif hasattr(result, "_asdict"):
        result = result._asdict()
    elif not isinstance(result, Mapping):
        result = {"result": result}
    if not all(isinstance(key, str) for key in result):
        raise TypeError(f"the result cannot be stored: the names of its entries are no texts, got {list(result)[:5]}")
    return {key: encoded(f"`{key}` of the result", value) for key, value in sorted(result.items())}
