"""Checks of arguments at the public edge, and the wording of their errors.

Every function takes the name of an argument and the value that came for it, returns the value in the type the code
works with, and otherwise raises an error that says which argument, what was needed, and what came: ``TypeError`` for a
value of the wrong kind, ``ValueError`` for a value or a shape. Two more arguments mean the same everywhere: `unit` is
named beside the allowed range; `fix` is a sentence added to the message, for an argument that callers usually get wrong
in one way (degrees for radians, say). Only functions and dataclasses that a reader calls check; kernels trust.

Examples
--------
>>> from fogkit import checks
>>> checks.positive("length", 1000, "m")
1000.0
>>> checks.integer("half_periods", 3, minimum=2, even=True)
Traceback (most recent call last):
    ...
ValueError: `half_periods` must be an even integer >= 2, got 3
"""

from __future__ import annotations

from collections.abc import Iterable
from numbers import Integral, Real
from types import EllipsisType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Largest entry of ``|C @ C.T - I|`` that still counts as a rotation. Axes wrong by 1e-6 rad (0.2 arcsec) pass at most
#: 1.5e-5 deg/h of Earth rate into each other, below every bias treated here; a matrix typed with five digits is caught.
ROTATION_TOLERANCE = 1e-6

Shape = tuple[int | EllipsisType | None, ...] | None


def positive(name: str, value: Any, unit: str = "", *, fix: str = "") -> float:
    """Finite number above zero, as a float; a bool, a string or an array with axes is a ``TypeError``.

    Examples
    --------
    >>> positive("wavelength", -1.55e-6, "m")
    Traceback (most recent call last):
        ...
    ValueError: `wavelength` must be finite and > 0 m, got -1.55e-06
    """
    number = _real(name, value, fix)
    return _require(0 < number < np.inf, name, f"finite and > 0{_spaced(unit)}", number, fix)


def non_negative(name: str, value: Any, unit: str = "", *, fix: str = "") -> float:
    """Finite number, zero or above, as a float."""
    number = _real(name, value, fix)
    return _require(0 <= number < np.inf, name, f"finite and >= 0{_spaced(unit)}", number, fix)


def finite(name: str, value: Any, unit: str = "", *, fix: str = "") -> float:
    """Finite number, as a float.

    Examples
    --------
    >>> finite("phase", float("nan"), "rad")
    Traceback (most recent call last):
    ...
    ValueError: `phase` must be finite, in rad, got nan
    """
    number = _real(name, value, fix)
    return _require(np.isfinite(number), name, "finite" + (f", in {unit}" if unit else ""), number, fix)


def instance(name: str, value: Any, kind: type | tuple[type, ...], *, fix: str = "") -> Any:
    """Object of a class, or of one of several, as it came; anything else is a ``TypeError``.

    Examples
    --------
    >>> instance("rate", "fast", float)
    Traceback (most recent call last):
    ...
    TypeError: `rate` must be a float, got str
    """
    if not isinstance(value, kind):
        kinds = kind if isinstance(kind, tuple) else (kind,)
        needed = " or ".join(k.__name__ for k in kinds)
        needed = ("an " if needed[0] in "AEIO" else "a ") + needed
        came = f"the class {value.__name__}" if isinstance(value, type) else type(value).__name__
        raise TypeError(_message(name, needed, came, fix))
    return value


def in_open_interval(name: str, value: Any, low: float, high: float, unit: str = "", *, fix: str = "") -> float:
    """Number with ``low < value < high``, as a float; a bound may be infinite, the value may not.

    Examples
    --------
    >>> in_open_interval("duty", 1, 0, 1)
    Traceback (most recent call last):
        ...
    ValueError: `duty` must be in the open interval (0.0, 1.0), got 1.0
    """
    number = _real(name, value, fix)
    needed = f"in the open interval ({float(low)}, {float(high)}){_spaced(unit)}"
    return _require(low < number < high, name, needed, number, fix)


def in_closed_interval(name: str, value: Any, low: float, high: float, unit: str = "", *, fix: str = "") -> float:
    """Finite number with ``low <= value <= high``, as a float."""
    number = _real(name, value, fix)
    inside = np.isfinite(number) and low <= number <= high
    return _require(inside, name, f"in [{float(low)}, {float(high)}]{_spaced(unit)}", number, fix)


def integer(name: str, value: Any, minimum: int | None = None, even: bool = False, *, fix: str = "") -> int:
    """Whole number, as an int: at least `minimum`, and even if asked; a whole float such as ``1e6`` passes, a bool not.

    Examples
    --------
    >>> integer("samples", 1e3)
    1000
    """
    needed = ("an even integer" if even else "an integer") + ("" if minimum is None else f" >= {minimum}")
    number = _unwrap(name, value, needed, fix)
    whole = isinstance(number, Integral) or float(number).is_integer()
    allowed = whole and (minimum is None or number >= minimum) and not (even and number % 2)
    return int(_require(allowed, name, needed, number, fix))


def finite_array(
    name: str, value: ArrayLike, shape: Shape = None, ndim: int | None = None, min_size: int = 1, *, fix: str = ""
) -> NDArray[np.float64]:
    """Array of finite real numbers, as float64.

    Parameters
    ----------
    name, value, fix
        As everywhere in this module; bools, strings, complex numbers and objects are a ``TypeError``.
    shape : tuple of int, None or Ellipsis, optional
        Shape needed. ``None`` stands for an axis of any length, one ``...`` for any number of axes:
        ``(..., 3)`` is one vector or any stack of them, ``(None, 3)`` a time series of vectors.
    ndim : int, optional
        Number of axes needed.
    min_size : int, optional
        Fewest entries allowed; the default rejects empty arrays.

    Returns
    -------
    ndarray of float64
        The values; `value` itself if that is already a float64 array, so do not write to it.

    Raises
    ------
    TypeError
        If the entries are not real numbers.
    ValueError
        If the array is ragged, of another shape, too small, or holds a NaN or an infinity.

    Examples
    --------
    >>> finite_array("omega_ib_b", [[0, 0, 1], [0, np.nan, 1]], shape=(..., 3))
    Traceback (most recent call last):
        ...
    ValueError: `omega_ib_b` must be finite, got nan at index (1, 1), one of 1 such entries of 6
    """
    try:
        raw = np.asarray(value)
    except ValueError:
        raise ValueError(_message(name, "a rectangular array", "rows of different lengths", fix)) from None
    if raw.dtype.kind not in "iuf":
        raise TypeError(_message(name, "an array of real numbers", f"dtype {raw.dtype}", fix))
    array = raw.astype(np.float64, copy=False)
    if ndim is not None:
        _require(array.ndim == ndim, name, f"an array with ndim {ndim}", f"shape {array.shape}", fix)
    if shape is not None:
        _require(_matches(array.shape, shape), name, f"of shape {_shape_words(shape)}", array.shape, fix)
    needed = "non-empty" if min_size == 1 else f"of at least {min_size} entries"
    _require(array.size >= min_size, name, needed, f"shape {array.shape}", fix)
    _require_all(np.isfinite(array), name, "finite", array, fix)
    return array


def array_in_closed_interval(
    name: str, value: ArrayLike, low: float, high: float, unit: str = "", *, fix: str = ""
) -> NDArray[np.float64]:
    """Array of finite numbers of any shape, each with ``low <= value <= high``, as float64; else as `finite_array`.

    Examples
    --------
    >>> array_in_closed_interval("duty", [0.5, 1.5], 0, 1)
    Traceback (most recent call last):
        ...
    ValueError: `duty` must be in [0.0, 1.0], got 1.5 at index (1,), one of 1 such entries of 2
    """
    array = finite_array(name, value, fix=fix)
    needed = f"in [{float(low)}, {float(high)}]{_spaced(unit)}"
    _require_all((low <= array) & (array <= high), name, needed, array, fix)
    return array


def option(name: str, value: Any, allowed: Iterable[str], *, fix: str = "") -> str:
    """One of a set of strings; ``TypeError`` if it is no string, ``ValueError`` if it is another one.

    Examples
    --------
    >>> option("waveform", "squre", ("square", "sine"))
    Traceback (most recent call last):
        ...
    ValueError: `waveform` must be one of 'square', 'sine', got 'squre'
    """
    allowed = tuple(allowed)
    needed = f"one of {_quoted(allowed)}"
    if not isinstance(value, str):
        raise TypeError(_message(name, needed, repr(value), fix))
    return _require(value in allowed, name, needed, repr(value), fix, value)


def rotation_matrix(
    name: str, value: ArrayLike, tolerance: float = ROTATION_TOLERANCE, *, fix: str = ""
) -> NDArray[np.float64]:
    """Rotation matrix or a stack of them, shape (..., 3, 3), as float64 and not corrected.

    ``ValueError`` if an entry of ``|C @ C.T - I|`` exceeds `tolerance`, or the matrix is a reflection (determinant -1).

    Examples
    --------
    >>> rotation_matrix("C_b_n", np.diag([1.0, 1.0, -1.0]))
    Traceback (most recent call last):
        ...
    ValueError: `C_b_n` must be a rotation (determinant +1), got a reflection. Are both sets of axes right-handed?
    """
    C = finite_array(name, value, shape=(..., 3, 3), fix=fix)
    departure = float(np.abs(C @ np.swapaxes(C, -1, -2) - np.eye(3)).max())
    needed = f"orthonormal, |C C^T - I| <= {tolerance:g}"
    hint = fix or "`fogkit.rotation.orthonormalise` gives the nearest rotation."
    _require(departure <= tolerance, name, needed, f"{departure:.3g}", hint)
    hint = fix or "Are both sets of axes right-handed?"
    _require((np.linalg.det(C) > 0).all(), name, "a rotation (determinant +1)", "a reflection", hint)
    return C


def generator(name: str, value: Any, *, fix: str = "") -> np.random.Generator:
    """A ``numpy.random.Generator``; anything else, a seed included, is a ``TypeError``.

    Examples
    --------
    >>> generator("rng", 42)
    Traceback (most recent call last):
        ...
    TypeError: `rng` must be a numpy.random.Generator, got int. Make one with `np.random.default_rng(seed)`.
    """
    if not isinstance(value, np.random.Generator):
        hint = fix or "Make one with `np.random.default_rng(seed)`."
        raise TypeError(_message(name, "a numpy.random.Generator", type(value).__name__, hint))
    return value


def columns(table: Any, names: Iterable[str], *, name: str = "table", fix: str = "") -> Any:
    """Table (pandas ``DataFrame``) with at least the columns `names`, returned as it came; its values are not checked.

    Examples
    --------
    >>> import pandas as pd
    >>> columns(pd.DataFrame({"gyro_x": [0.0]}), ["gyro_x", "gyro_y"], name="imu")
    Traceback (most recent call last):
        ...
    ValueError: `imu` must be a table with the columns 'gyro_x', 'gyro_y', got one with 'gyro_x', so without 'gyro_y'
    """
    names = tuple(names)
    if not (hasattr(table, "columns") and hasattr(table, "index")):
        raise TypeError(_message(name, "a pandas DataFrame", type(table).__name__, fix))
    missing = [column for column in names if column not in table.columns]
    came = f"one with {_quoted(table.columns) or 'none'}, so without {_quoted(missing)}"
    return _require(not missing, name, f"a table with the columns {_quoted(names)}", came, fix, table)


def _message(name: str, needed: str, came: Any, fix: str) -> str:
    """Wording of every error of this module."""
    return f"`{name}` must be {needed}, got {came}" + (f". {fix}" if fix else "")


def _require(allowed: bool, name: str, needed: str, came: Any, fix: str, result: Any = None) -> Any:
    """What came, or `result` where `came` only describes it; ``ValueError`` if it is not allowed."""
    if not allowed:
        raise ValueError(_message(name, needed, came, fix))
    return came if result is None else result


def _require_all(allowed: NDArray[np.bool_], name: str, needed: str, array: NDArray[np.float64], fix: str) -> None:
    """``ValueError`` that shows the first entry not allowed and counts the others."""
    if allowed.all():
        return
    wrong = np.argwhere(~allowed)
    index = tuple(wrong[0].tolist())
    place = f" at index {index}, one of {len(wrong)} such entries of {array.size}" if index else ""
    raise ValueError(_message(name, needed, f"{array[index]}{place}", fix))


def _spaced(unit: str) -> str:
    """Unit with the space before it, or nothing."""
    return f" {unit}" if unit else ""


def _quoted(names: Iterable[Any]) -> str:
    """Names in quotes, separated by commas."""
    return ", ".join(map(repr, names))


def _unwrap(name: str, value: Any, needed: str, fix: str) -> Any:
    """Number out of a scalar or an array without axes; a bool is an int to Python but never meant as one here."""
    number = value[()] if isinstance(value, np.ndarray) and value.ndim == 0 else value
    if isinstance(number, bool) or not isinstance(number, Real):  # np.bool_ is no Real
        raise TypeError(_message(name, needed, repr(value), fix))
    return number


def _real(name: str, value: Any, fix: str) -> float:
    """Real number as a float."""
    return float(_unwrap(name, value, "a real number", fix))


def _matches(shape: tuple[int, ...], wanted: tuple) -> bool:
    """Whether a shape fits a pattern with None and at most one Ellipsis."""
    if Ellipsis in wanted:
        at = wanted.index(Ellipsis)
        free = max(len(shape) - len(wanted) + 1, 0)
        wanted = (*wanted[:at], *[None] * free, *wanted[at + 1 :])
    return len(shape) == len(wanted) and all(w in (None, n) for n, w in zip(shape, wanted, strict=True))


def _shape_words(wanted: tuple) -> str:
    """Pattern of a shape as docstrings write it: (n, 3) for (None, 3)."""
    words = ["..." if w is Ellipsis else "n" if w is None else str(w) for w in wanted]
    return f"({', '.join(words)}{',' if len(words) == 1 else ''})"
