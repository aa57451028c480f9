"""Gravity as the compiled mechanisation takes it, from what a caller may give."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks, earth
from fogkit.navigation.states import State

Array = NDArray[np.float64]
#: What `fogkit.navigation.integrate` takes for gravity.
Gravity = float | ArrayLike | Callable[[Array, Array, Array], ArrayLike] | None

# Change of gravity from pass to pass, m/s^2, at which a gravity function counts as followed: rounding of 9.8 m/s^2.
SETTLED = 1e-14
MAX_PASSES = 50


@dataclass(frozen=True)
class GravityModel:
    """Gravity as the kernel takes it: vectors of each run and step, and whether normal gravity is added to them."""

    vectors: Array  # shape (runs or 1, n or 1, 3)
    normal: bool


def gravity_model(gravity: Gravity, start: State, runs: tuple[int, ...], steps: int) -> GravityModel:
    """Model from what the caller has; of a function, its value at the start."""
    if gravity is None:
        return GravityModel(np.zeros((1, 1, 3)), True)
    if callable(gravity):
        return GravityModel(contiguous(_evaluated(gravity, start.lat, start.lon, start.alt), -1, 1, 3), False)
    vectors = checks.finite_array("gravity", gravity)
    if vectors.ndim == 0:
        return GravityModel(np.array([[[0.0, 0.0, -float(vectors)]]]), False)
    if vectors.shape == (3,):
        return GravityModel(contiguous(vectors, 1, 1, 3), False)
    try:
        vectors = np.broadcast_to(vectors, (*(runs if vectors.ndim > 2 else ()), steps, 3))
    except ValueError:
        needed = f"None, a number, a vector of shape (3,) or vectors of shape (..., {steps}, 3), one for each step"
        raise ValueError(f"`gravity` must be {needed}, got shape {vectors.shape}") from None
    return GravityModel(contiguous(vectors, -1, steps, 3), False)


def _evaluated(gravity: Callable, lat: Array, lon: Array, alt: Array) -> Array:
    """Values of a gravity function, checked."""
    return checks.finite_array("gravity(lat, lon, alt)", gravity(lat, lon, alt), shape=(*np.shape(lat), 3))


def followed(gravity: Callable, run: Callable, origin: Array, steps: int, position_fixed: bool) -> GravityModel:
    """Model whose vectors are what a gravity function has where they lead.

    What is iterated is the small difference to normal gravity: the first pass has it right almost everywhere.
    """
    if position_fixed:
        return GravityModel(contiguous(_evaluated(gravity, *origin.T), -1, 1, 3), False)
    excess = np.zeros((1, 1, 3))
    for _ in range(MAX_PASSES):
        _, _, position = run(GravityModel(excess, True), 1, False)
        lat, lon, alt = np.moveaxis(position, -1, 0)
        at_nodes = _evaluated(gravity, lat, lon, alt) - earth.gravity_n(lat, alt)
        previous, excess = excess, 0.5 * (at_nodes[:, :-1] + at_nodes[:, 1:])
        if np.abs(excess - previous).max() <= SETTLED:
            return GravityModel(excess, True)
    change = np.abs(excess - previous).max()
    raise ValueError(
        f"`gravity` must vary smoothly enough to be followed: after {MAX_PASSES} passes it still changes by "
        f"{change:.3g} m/s^2. Navigate in shorter pieces."
    )


def contiguous(values: Array, *shape: int) -> Array:
    """Contiguous copy, reshaped: for any other layout the kernel would be compiled anew."""
    return np.array(values, order="C").reshape(shape)
