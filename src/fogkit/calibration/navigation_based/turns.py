"""How many whole turns does a test need for the scale factors of gyros to be as sure as wanted?"""

import numpy as np

from fogkit import checks
from fogkit.constants import STANDARD_GRAVITY

MEASUREMENTS = 3
"""Tests about one axis in the paper's plan, whose changes of slope add up for the scale factor of that gyro."""


def scale_factor_deviation(turns: float, slope_deviation: float, gravity: float = STANDARD_GRAVITY) -> float:
    """Standard deviation of a gyro scale factor from the nine tests.

    Parameters
    ----------
    turns : float
        Whole turns n in each test, besides a quarter, a half and a quarter.
    slope_deviation : float
        Standard deviation of a change of slope, ``sqrt(R_ii)``, m/s^2, the same in all tests.
    gravity : float, optional
        m/s^2.

    Returns
    -------
    float
        ``sqrt(3) slope_deviation / (pi gravity (6 n + 2))``.

    Notes
    -----
    The changes across the axis in the three tests about it add up to the whole angle turned, ``(3 n + 1)`` turns, times
    ``-g m``: all other errors cancel, because the third test ends where the first began. Three measurements, one
    unknown that is in no other: the sum is the best estimate.
    """
    turns = checks.non_negative("turns", turns)
    gravity = checks.positive("gravity", gravity, "m/s^2")
    deviation = checks.positive("slope_deviation", slope_deviation, "m/s^2")
    return float(np.sqrt(MEASUREMENTS) * deviation / (np.pi * gravity * (6 * turns + 2)))


def turns_needed(
    slope_deviation: float, wanted: float, gravity: float = STANDARD_GRAVITY, *, printed: bool = False
) -> float:
    """Number of whole turns n in each of the nine tests for a wanted standard deviation of gyro scale factors.

    Parameters
    ----------
    slope_deviation : float
        Standard deviation of a change of slope, ``sqrt(R_ii)``, m/s^2.
    wanted : float
        Standard deviation of the scale factors, a pure number.
    gravity : float, optional
        m/s^2.
    printed : bool, optional
        Whether by (28) of the paper, ``slope_deviation / (2 pi g wanted)``, which takes a single test and only the
        whole turns of it; by default the inverse of `scale_factor_deviation`.

    Returns
    -------
    float
        Not rounded; 0 if no whole turn is needed.
    """
    deviation = checks.positive("slope_deviation", slope_deviation, "m/s^2")
    wanted = checks.positive("wanted", wanted)
    gravity = checks.positive("gravity", gravity, "m/s^2")
    if printed:
        return float(deviation / (2 * np.pi * gravity * wanted))
    return float(max(0.0, (np.sqrt(MEASUREMENTS) * deviation / (np.pi * gravity * wanted) - 2) / 6))
