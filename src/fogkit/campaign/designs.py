"""Which cases to run: every combination of levels, or points spread over ranges and distributions."""

import inspect
from collections.abc import Iterable, Mapping
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from fogkit import checks

if TYPE_CHECKING:
    from pandas import DataFrame

METHODS = {"sobol": "Sobol", "halton": "Halton", "latin hypercube": "LatinHypercube"}


def grid(levels: Mapping[str, Iterable[Any]]) -> "DataFrame":
    """Every combination of the levels of some arguments.

    Parameters
    ----------
    levels : mapping of str to iterable
        Values of each argument.

    Returns
    -------
    DataFrame
        One row for each combination, one column for each argument; the last argument varies fastest.

    Raises
    ------
    TypeError
        If the levels of an argument are a single value or a text.
    ValueError
        If an argument has no levels.

    Examples
    --------
    >>> grid({"latitude": [0.5, 1.0], "axis": ["x", "y"]})
       latitude axis
    0       0.5    x
    1       0.5    y
    2       1.0    x
    3       1.0    y
    """
    import pandas as pd

    columns = {}
    for name, values in _named("levels", levels).items():
        if isinstance(values, str) or not isinstance(values, Iterable):
            raise TypeError(
                f"`levels` must hold a list of values for `{name}`, got {values!r}. One value: [{values!r}]"
            )
        columns[name] = list(values)
        if not columns[name]:
            raise ValueError(f"`levels` must hold at least one value for `{name}`, got none")
    rows = list(product(*columns.values()))
    return pd.DataFrame({name: [row[i] for row in rows] for i, name in enumerate(columns)})


def spread(count: int, ranges: Mapping[str, Any], *, seed: int, method: str = "sobol") -> "DataFrame":
    """Points that fill ranges, or follow distributions, more evenly than independent draws would.

    Parameters
    ----------
    count : int
        Number of points.
    ranges : mapping of str to (low, high) or distribution
        For each argument an interval, in which it is uniform, or a frozen continuous distribution of `scipy.stats`.
    seed : int
        Seed of the scrambling or of the draws.
    method : {'sobol', 'halton', 'latin hypercube', 'random'}, optional
        Sequence of `scipy.stats.qmc`, or independent draws. A Sobol sequence is balanced only for a power of 2, of
        which SciPy warns. Except for the Latin hypercube, more points with the same seed begin with the same points, so
        that a campaign over them can be extended.

    Returns
    -------
    DataFrame
        One row for each point, one column for each argument.

    Raises
    ------
    TypeError, ValueError
        If a range is neither two numbers nor a distribution, if it is empty, or if a distribution is infinite at a
        point (as a normal one is at 0 and 1).

    Examples
    --------
    >>> from scipy.stats import norm
    >>> points = spread(256, {"bias": norm(0, 2), "gain": (1, 3)}, seed=1)
    >>> float(points.bias.std().round(1)), float(points.gain.mean().round(2))
    (2.0, 2.0)
    """
    import pandas as pd

    count = checks.integer("count", count, minimum=1)
    quantiles = {name: _quantile(name, values) for name, values in _named("ranges", ranges).items()}
    unit = _unit_points(count, len(quantiles), checks.integer("seed", seed, minimum=0), method)
    columns = {}
    for i, (name, quantile) in enumerate(quantiles.items()):
        columns[name] = checks.finite_array(
            f"ranges[{name!r}]", quantile(unit[:, i]), fix="Another seed avoids a point at the very end"
        )
    return pd.DataFrame(columns)


def _unit_points(count: int, dimensions: int, seed: int, method: str) -> np.ndarray:
    """Points in the unit cube, shape (count, dimensions)."""
    checks.option("method", method, (*METHODS, "random"))
    rng = np.random.default_rng(seed)
    if method == "random":
        return rng.random((count, dimensions))
    from scipy.stats import qmc

    engine = getattr(qmc, METHODS[method])
    # SciPy before 1.15 calls it seed
    name = "rng" if "rng" in inspect.signature(engine).parameters else "seed"
    return engine(dimensions, **{name: rng}).random(count)


def _quantile(name: str, values: Any):
    """Function from (0, 1) to the values of an argument."""
    if hasattr(values, "ppf"):
        return values.ppf
    low, high = checks.finite_array(f"ranges[{name!r}]", values, (2,), fix="Give (low, high) or a distribution")
    if not low < high:
        raise ValueError(f"`ranges[{name!r}]` must be (low, high) with low < high, got ({low}, {high})")
    return lambda unit: low + (high - low) * unit


def _named(argument: str, mapping: Any) -> Mapping[str, Any]:
    """The mapping, if it has names for keys and is not empty."""
    checks.instance(argument, mapping, Mapping)
    if not mapping or not all(isinstance(name, str) for name in mapping):
        raise ValueError(f"`{argument}` must name at least one argument of the function, got {list(mapping)}")
    return mapping
