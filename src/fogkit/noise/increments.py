"""Second differences of the angle: their covariances in closed form.

The angle of a gyro with random errors, ``theta(t) = integral of the rate error``, has no stationary covariance, but its
second differences have one. It follows from the generalised covariance g of the angle [1]_: for any two combinations
of angles that a quadratic in time does not change,

``cov(sum_i a_i theta(t_i), sum_j b_j theta(s_j)) = sum_ij a_i b_j g(t_i - s_j)``,

====================  ==================  ===================================
process               coefficient         g(t)
====================  ==================  ===================================
angle random walk     N**2                ``-|t| / 2``
bias instability      B**2                ``t**2 ln|t| / (2 pi)``
rate random walk      K**2                ``|t|**3 / 12``
quantization          Q**2                1 at t = 0, else 0
====================  ==================  ===================================

Each is the inverse Fourier transform of the two-sided spectrum of the rate over ``(2 pi f)**2``, up to a quadratic. A
fourth difference of ``t**2 ln|t|`` far from zero is what is left of numbers larger by the fourth power of the distance:
every function here uses forms that lose no digits there.

References
----------
.. [1] G. Matheron, "The intrinsic random functions and their applications", Advances in Applied Probability 5 (1973).
   For clocks: C. A. Greenhall, W. J. Riley, "Uncertainty of stability variances based on finite differences", Proc.
   35th PTTI (2003).
"""

from __future__ import annotations

from math import comb, pi

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FAR = 4.0
"""Distance, in steps of a difference, from which its series is summed: the direct form loses a factor of some
``FAR**2``, the series needs `TERMS` terms."""

TERMS = 14
"""Terms of the series: the first one left out is ``(1 / FAR)**28 = 1e-17`` of the sum."""


def cross_covariance(m: int, n: int, lag: Array) -> Array:
    """Covariances of second differences of the angle at steps m and n, for coefficients and sampling time 1.

    Parameters
    ----------
    m, n : int
        The two steps, in samples.
    lag : ndarray, shape (k,)
        Distance of the centres of the two differences, in samples; need not be whole.

    Returns
    -------
    ndarray, shape (4, k)
        Of angle random walk, bias instability, rate random walk and quantization.
    """
    m, n = min(m, n), max(m, n)
    lag = np.abs(np.asarray(lag, dtype=np.float64))
    white, cubic = (
        np.where(lag < m + n, _outer(inner, m, n, lag), 0.0)  # beyond, a straight line is differenced twice
        for inner in (_second_difference_of_modulus, _second_difference_of_cube)
    )
    return np.stack([-white / 2, flicker_covariance(m, n, lag) / (2 * pi), cubic / 12, _coincidence(m, n, lag)])


def flicker_covariance(m: int, n: int, lag: Array) -> Array:
    """Fourth difference of ``t**2 ln|t|``: second difference with step n of that with step m, at real lags.

    Times ``B**2 / (2 pi)`` it is the covariance of second differences of the angle for bias instability B, the
    sampling time having cancelled except as a factor ``dt**2``.
    """
    m, n = min(m, n), max(m, n)
    lag = np.abs(np.asarray(lag, dtype=np.float64))
    far = lag > FAR * (m + n)
    result = np.empty_like(lag)
    result[~far] = _outer(second_difference_of_log, m, n, lag[~far])
    u = lag[far]
    total = np.zeros_like(u)
    for k in range(2 * TERMS, 2, -2):
        # (m + n)**k + (m - n)**k - 2 m**k - 2 n**k as a sum of positive terms, in units of n**k so that none overflows
        bracket = 2 * sum(comb(k, 2 * i) * (m / n) ** (2 * i) for i in range(1, k // 2))
        total += bracket / (k * (k - 1) * (k - 2)) * (n / u) ** (k - 2)
    result[far] = -4 * n**2 * total
    return result


def second_difference_of_log(m: int, t: Array) -> Array:
    """``(t + m)**2 ln|t + m| - 2 t**2 ln|t| + (t - m)**2 ln|t - m|``."""
    t = np.abs(t)
    far = t > FAR * m
    result = np.empty_like(t)
    near = t[~far]
    result[~far] = _square_log(near + m) - 2 * _square_log(near) + _square_log(near - m)
    x = (m / t[far]) ** 2
    total = np.zeros_like(x)
    for i in range(TERMS, 1, -1):
        total = x * (total + 1.0 / (i * (2 * i - 1) * (2 * i - 2)))
    result[far] = m**2 * (2 * np.log(t[far]) + 3 - 2 * total)
    return result


def squared_coincidence(m: int, n: int, lag: Array) -> Array:
    """Sum of products of squared coefficients where the two differences share an angle: for fourth moments."""
    return _coincidence(m, n, np.abs(lag), power=2)


def _outer(inner, m: int, n: int, lag: Array) -> Array:
    """Second difference with the larger step n of a second difference with step m."""
    return inner(m, lag + n) - 2 * inner(m, lag) + inner(m, lag - n)


def _second_difference_of_modulus(m: int, t: Array) -> Array:
    """``|t + m| - 2 |t| + |t - m|``."""
    return 2 * np.maximum(m - np.abs(t), 0.0)


def _second_difference_of_cube(m: int, t: Array) -> Array:
    """``|t + m|**3 - 2 |t|**3 + |t - m|**3``, multiplied out."""
    t = np.abs(t)
    return np.where(t >= m, 6.0 * m**2 * t, 2.0 * m**3 + 6.0 * m * t**2 - 2.0 * t**3)


def _square_log(t: Array) -> Array:
    """``t**2 ln|t|``, 0 at 0."""
    return t**2 * np.log(np.where(t == 0, 1.0, np.abs(t)))


def _coincidence(m: int, n: int, lag: Array, power: int = 1) -> Array:
    """Products of the coefficients 1, -2, 1 of the two differences, to a power, where they meet."""
    coefficients = {-1: 1, 0: (-2) ** power, 1: 1}
    result = np.zeros_like(lag, dtype=np.float64)
    for i, a in coefficients.items():
        for j, b in coefficients.items():
            result += np.where(lag + i * m - j * n == 0, float(a * b), 0.0)
    return result
