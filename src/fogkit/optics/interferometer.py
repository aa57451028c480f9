"""The interferometer: power against phase, exactly or as a Taylor polynomial, and what demodulation makes of it.

Powers are relative to the full power P_0 (no rotation, no modulation).
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks


def power(phase: ArrayLike) -> NDArray[np.float64]:
    """Power on the detector relative to full power, ``(1 + cos(phase)) / 2``.

    Parameters
    ----------
    phase : array_like, shape (...,)
        Phase difference of the two waves, rad: Sagnac phase plus modulation plus feedback.

    Returns
    -------
    ndarray, shape (...,)
        Relative power, 0 to 1 (miklyashev eq. (1)).

    Examples
    --------
    >>> float(power(0.0))
    1.0
    """
    return 0.5 * (1 + np.cos(np.asarray(phase, dtype=float)))


def taylor_coefficients(bias: float, degree: int) -> NDArray[np.float64]:
    """Coefficients of the power in powers of the deviation from a working point.

    Parameters
    ----------
    bias : float
        Phase of the working point, rad, e.g. plus or minus the modulation depth.
    degree : int
        Highest power kept, 0 to 150.

    Returns
    -------
    ndarray, shape (degree + 1,)
        Coefficient of ``deviation**j`` at index j (miklyashev eqs. (2), (3) up to degree 3).

    Raises
    ------
    ValueError
        If `degree` is negative, above 150 or not whole.

    Examples
    --------
    >>> taylor_coefficients(np.pi / 2, 3).round(4).tolist()
    [0.5, -0.5, -0.0, 0.0833]
    """
    degree = checks.integer("degree", degree, minimum=0)
    if degree > 150:
        raise ValueError(f"`degree` must be at most 150, beyond which factorials overflow, got {degree}")
    orders = np.arange(degree + 1)
    factorials = np.array([math.factorial(j) for j in orders], dtype=float)
    # the j-th derivative of cos(x) is cos(x + j pi / 2)
    coefficients = 0.5 * np.cos(bias + orders * np.pi / 2) / factorials
    coefficients[0] += 0.5
    return coefficients


def taylor_power(deviation: ArrayLike, bias: float, degree: int) -> NDArray[np.float64]:
    """Relative power near a working point, as a Taylor polynomial in the deviation from it.

    Parameters
    ----------
    deviation : array_like, shape (...,)
        Phase beyond the working point, rad.
    bias, degree
        As in `taylor_coefficients`.

    Returns
    -------
    ndarray, shape (...,)
        Relative power; differs from `power` by less than ``|deviation|**(degree + 1) / (2 (degree + 1)!)``.
    """
    return np.polynomial.polynomial.polyval(np.asarray(deviation, dtype=float), taylor_coefficients(bias, degree))


def demodulate(power_minus: ArrayLike, power_plus: ArrayLike, depth: float) -> NDArray[np.float64]:
    """Phase estimate from the powers in the two bias states, rad, right to first order.

    Parameters
    ----------
    power_minus, power_plus : array_like, shape (...,)
        Relative power where the bias is ``-depth`` and ``+depth``.
    depth : float
        Modulation depth, rad, in (0, pi).

    Returns
    -------
    ndarray, shape (...,)
        ``(power_minus - power_plus) / sin(depth)``. For a constant phase it is ``sin(phase)`` at any depth; for a phase
        that moves by ``2 h`` between the states it is ``sin(mean) * sin(depth + h) / sin(depth)`` if the negative state
        comes first: rotation acceleration acts as a change of depth.

    Raises
    ------
    ValueError
        If `depth` is outside (0, pi).

    Examples
    --------
    >>> depth = 3 * np.pi / 4
    >>> float(demodulate(power(0.1 - depth), power(0.1 + depth), depth).round(6)) == round(math.sin(0.1), 6)
    True
    """
    depth = checks.in_open_interval("depth", depth, 0.0, np.pi, "rad")
    return (np.asarray(power_minus, dtype=float) - np.asarray(power_plus, dtype=float)) / math.sin(depth)
