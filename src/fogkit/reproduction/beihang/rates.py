"""The rates of the list: whole turns, what they leave of a level vector, and the scale factor against one turn."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.reproduction.beihang import slides
from fogkit.units import REVOLUTION

Array = NDArray[np.float64]

WHOLE_TURN_TOLERANCE = 1e-9
"""Part of a turn by which turns may miss a whole number: rounding of the products, far below a printed digit."""


def magnitudes() -> Array:
    """Rates of the list without sign, ascending from zero, rad/s."""
    return np.unique(np.abs(slides.RATES))


def turns(rate: ArrayLike, duration: float = slides.RATE_DURATION) -> Array:
    """Turns that a rate, rad/s, makes in the duration of one rate; negative for a negative rate."""
    return checks.finite_array("rate", rate) * duration / REVOLUTION


def closes_whole_turns(rate: ArrayLike, duration: float = slides.RATE_DURATION) -> NDArray[np.bool_]:
    """Whether a rate makes a whole number of turns, at least one."""
    count = np.abs(turns(rate, duration))
    return (np.abs(count - np.round(count)) < WHOLE_TURN_TOLERANCE) & (count > 0.5)


def horizontal_left(rate: ArrayLike, duration: float = slides.RATE_DURATION) -> Array:
    """Largest part, over the starting azimuth, of a horizontal vector in the mean of a gyro that turns with the table.

    ``|sin(theta/2) / (theta/2)|`` of the angle theta turned: 1 at rest, 0 for whole turns.
    """
    return np.abs(np.sinc(turns(rate, duration)))


def scale_deviation_of_list(angle_random_walk: float) -> float:
    """Relative standard deviation of the scale factor from all rates of the list: white noise, bias free."""
    rates = slides.RATES
    return float(angle_random_walk / np.sqrt(slides.RATE_DURATION * ((rates - rates.mean()) ** 2).sum()))


def scale_deviation_of_turns(angle_random_walk: float, rate: float) -> float:
    """Relative standard deviation of the scale factor from one turn each way at a rate: the same noise."""
    duration = slides.TURN / rate
    return float(angle_random_walk * np.sqrt(2 * duration) / (2 * slides.TURN))


def share_of_largest(count: int) -> float:
    """Part of the sum of squares of the rates, and so of the weight in the slope, in the `count` largest pairs."""
    squares = magnitudes()[1:] ** 2
    return float(np.sort(squares)[::-1][:count].sum() / squares.sum())
