"""Mean readings of a gyro triad while the case turns steadily about an axis fixed in it.

The input of each gyro is then a constant plus a sinusoid of the angle of the turn: its own share of the turn, and the
rotation of the Earth. All means are closed forms, for any part of a turn; no time step enters.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit.imu.errors import GyroTriad


def input_harmonics(axis: ArrayLike, rate: ArrayLike, omega_ie_start: ArrayLike) -> NDArray[np.float64]:
    """Rate of the case in its own axes during a steady turn, as coefficients of 1, cos and sin of the angle turned.

    Parameters
    ----------
    axis : array_like, shape (..., 3)
        Unit vector of the axis of the turn in axes of the case.
    rate : array_like, shape (...,)
        Rate of the turn against the Earth, rad/s.
    omega_ie_start : array_like, shape (..., 3)
        Rotation of the Earth in axes of the case at the start, rad/s.

    Returns
    -------
    ndarray, shape (..., 3, 3)
        Vectors of the constant, the cosine and the sine, rad/s, in the last-but-one axis.
    """
    axis, omega = np.broadcast_arrays(np.asarray(axis, float), np.asarray(omega_ie_start, float))
    along = axis * (axis * omega).sum(axis=-1, keepdims=True)
    constant = along + axis * np.asarray(rate, float)[..., None]
    # a vector fixed in space turns backwards in axes of the case
    parts = np.broadcast_arrays(constant, omega - along, -np.cross(axis, omega))
    return np.stack(parts, axis=-2)


def mean_and_mean_size(harmonics: ArrayLike, angle: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean of a constant plus a sinusoid over a turn from zero to `angle`, and mean of its absolute value.

    Parameters
    ----------
    harmonics : array_like, shape (..., 3)
        Coefficients of 1, cos and sin of the angle.
    angle : array_like, shape (...,)
        Angle of the turn, rad, of either sign; at 0 the values there are returned.

    Returns
    -------
    mean, mean_size : ndarray, shape (...,)
        In units of the coefficients.
    """
    c, p, q = np.moveaxis(np.asarray(harmonics, float), -1, 0)
    angle = np.asarray(angle, float)
    c, p, q, angle = np.broadcast_arrays(c, p, q, angle)
    amplitude, phase = np.hypot(p, q), np.arctan2(q, p)
    still = angle == 0
    span = np.where(still, 1.0, angle)
    mean = c + (p * np.sin(angle) + q * (1 - np.cos(angle))) / span
    size = (_size_integral(c, amplitude, angle - phase) - _size_integral(c, amplitude, -phase)) / span
    return np.where(still, c + p, mean), np.where(still, np.abs(c + p), size)


def _size_integral(c: NDArray, amplitude: NDArray, angle: NDArray) -> NDArray:
    """Integral of ``|c + amplitude cos(x)|`` from 0 to `angle`."""
    ratio = np.divide(-c, amplitude, out=np.where(c < 0, 1.0, -1.0), where=amplitude > 0)
    turn_over = np.arccos(np.clip(ratio, -1.0, 1.0))  # positive inside plus or minus this angle, negative beyond

    def within(x):
        """The integral for |x| up to pi."""
        size = np.abs(x)
        inner = np.minimum(size, turn_over)
        positive = c * inner + amplitude * np.sin(inner)
        negative = c * (size - inner) + amplitude * (np.sin(size) - np.sin(inner))
        return np.sign(x) * (positive - negative)

    whole = np.round(angle / (2 * np.pi))
    return 2 * whole * within(np.full_like(angle, np.pi)) + within(angle - 2 * np.pi * whole)


def mean_readings(
    triad: GyroTriad,
    C_0_g1: ArrayLike,
    axis: ArrayLike,
    rate: ArrayLike,
    omega_ie_start: ArrayLike,
    duration: ArrayLike,
) -> NDArray[np.float64]:
    """Noise-free mean readings of a triad during a steady turn.

    Parameters
    ----------
    triad : GyroTriad
        The gyros.
    C_0_g1 : array_like, shape (..., 3, 3)
        Nominal gyro axes in the case (`Construction.C_0_g1`).
    axis, rate, omega_ie_start
        As in `input_harmonics`.
    duration : array_like, shape (...,)
        Duration of the turn, s, positive.

    Returns
    -------
    ndarray, shape (..., 3)
        Mean readings, each part of the input scaled by the scale factor of its own sign.
    """
    harmonics = input_harmonics(axis, rate, omega_ie_start)
    inputs = np.einsum("ij,...jk,...hk->...ih", triad.A_g, np.asarray(C_0_g1, float), harmonics)
    angle = np.asarray(rate, float) * np.asarray(duration, float)
    mean, size = mean_and_mean_size(inputs, angle[..., None])
    plus, minus = 1 / np.array(triad.scale_positive), 1 / np.array(triad.scale_negative)
    return np.array(triad.bias) + 0.5 * (plus + minus) * mean + 0.5 * (plus - minus) * size
