"""Drift of a closed-loop gyro under angular acceleration: the laws.

The two bias states see the interferometer on slopes of opposite sign but on the same curvature. If the phase moves
between them, the curvature does not cancel, and the demodulated rate is off by ``cot(depth) S eps^2 / (2 k) * sum(b_i
t_i^2)`` with the bias states b_i = -1, +1 at the times t_i (miklyashev eqs. (5), (6)). The sign of the
acceleration drops out, so that vibration makes a bias.

The laws hold for a drive without error (`Loop.v_pi_error` 0), and raise otherwise.

The functions carry the sign that follows from the paper's own eq. (6) with the negative state first. Its printed eqs.
(8) and (11) have lost it; see the errata of the book.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.optics.gyro import ClosedLoopGyro


def drift_of_states(gyro: ClosedLoopGyro, acceleration: ArrayLike, times: ArrayLike) -> NDArray[np.float64]:
    """Second-degree error of one demodulation under constant acceleration, from the times of its bias states.

    Parameters
    ----------
    gyro : ClosedLoopGyro
        The gyro; its first row of bias states is taken.
    acceleration : array_like, shape (...,)
        Angular acceleration, rad/s^2.
    times : array_like, shape (half_periods,)
        Times at which the states are sampled, s, counted from where the uncompensated rate is zero.

    Returns
    -------
    ndarray, shape (...,)
        Rate error of one regulation period, rad/s (miklyashev eq. (6); eq. (5) for two half-periods).

    Raises
    ------
    ValueError
        If `times` has another length than the loop has half-periods.
    """
    loop = gyro.loop
    times = checks.finite_array("times", times, shape=(loop.half_periods,))
    moment = loop.bias_pattern[0] @ times**2 / (2 * loop.half_periods)
    return _curvature(gyro) * moment * checks.finite_array("acceleration", acceleration) ** 2


def drift_from_rest(gyro: ClosedLoopGyro, acceleration: ArrayLike) -> NDArray[np.float64]:
    """Drift under constant acceleration if each regulation period began with nothing left uncompensated.

    Parameters
    ----------
    gyro : ClosedLoopGyro
        The gyro, of any gain: the assumption replaces the loop.
    acceleration : array_like, shape (...,)
        Angular acceleration, rad/s^2.

    Returns
    -------
    ndarray, shape (...,)
        ``1/8 cot(depth) S eps^2 dt_m dt_p``, rad/s (miklyashev eq. (8) with its sign mended), times the order sign.
    """
    return 0.5 * _steady(gyro) * checks.finite_array("acceleration", acceleration) ** 2


def steady_drift(gyro: ClosedLoopGyro, acceleration: ArrayLike) -> NDArray[np.float64]:
    """Drift under constant acceleration, or under one that is slow for the loop, to second degree.

    Parameters
    ----------
    gyro : ClosedLoopGyro
        The gyro. With a second integrator, however weak, the lag and with it this drift vanish; where the oscillation
        is not slow for that integrator, `vibration_drift` counts.
    acceleration : array_like, shape (...,)
        Angular acceleration, rad/s^2.

    Returns
    -------
    ndarray, shape (...,)
        ``1/4 cot(depth) S eps^2 dt_m dt_p / gain``, rad/s (miklyashev eq. (11) with its sign mended, which has gain 1),
        times the order sign, plus the curvature within a regulation period for orders without a first moment. For a
        harmonic acceleration the mean is half of the value at its amplitude.
    """
    loop = gyro.loop
    index = np.arange(loop.half_periods) - 0.5 * (loop.half_periods - 1)
    second_moment = (loop.bias_pattern @ index**2).mean() / (2 * loop.half_periods) * loop.half_period**2
    lag = 0.0 if loop.second_gain else _steady(gyro) / loop.gain
    return (lag + _curvature(gyro) * second_moment) * checks.finite_array("acceleration", acceleration) ** 2


def vibration_drift(gyro: ClosedLoopGyro, acceleration: ArrayLike, frequency: ArrayLike) -> NDArray[np.float64]:
    """Mean drift under harmonic angular oscillation of any frequency, to second degree, for any stable linear loop.

    Parameters
    ----------
    gyro : ClosedLoopGyro
        The gyro.
    acceleration : array_like, shape (...,)
        Amplitude of the angular acceleration, rad/s^2.
    frequency : array_like, shape (...,)
        Frequency of the oscillation, Hz, positive. Where twice the frequency is a multiple of the update rate of the
        bias pattern, sampling folds the squared signal onto zero frequency and the mean depends on the phase besides;
        the result is then its mean over all phases.

    Returns
    -------
    ndarray, shape (...,)
        Mean rate error, rad/s::

            -cot(depth) S (a / omega)^2 / (2 k) Re(conj(H) B)

        with ``B = sum_m b_m exp(j omega m dt)`` over the bias states of a regulation period and ``H`` the response
        of the feedback to the phase of the period's first half-period, `Loop.averaging_response` times
        `Loop.closed_loop_response`. It tends to half of `steady_drift` at low frequency.

    Raises
    ------
    ValueError
        If `frequency` is not positive, or above half of the rate of half-periods, or something is not finite.

    Examples
    --------
    >>> from fogkit.optics import Coil, Loop
    >>> from fogkit.units import DEG, DEG_PER_HOUR
    >>> loop = Loop(depth=3 * np.pi / 4, half_period=5e-6, half_periods=16)
    >>> gyro = ClosedLoopGyro(coil=Coil(length=1000, diameter=0.1), loop=loop)
    >>> round(float(vibration_drift(gyro, 5000 * DEG, 60.0)) / DEG_PER_HOUR, 4)
    -0.2123
    """
    loop = checks.instance("gyro", gyro, ClosedLoopGyro).loop
    frequency = checks.finite_array("frequency", frequency)
    highest = 0.5 / loop.half_period
    if (frequency <= 0).any() or (frequency > highest).any():
        worst = frequency.min() if (frequency <= 0).any() else frequency.max()
        raise ValueError(
            f"`frequency` must be positive and at most {highest:.6g} Hz, half of the sampling rate, got {worst:.6g}"
        )
    omega = 2 * np.pi * frequency
    response = loop.closed_loop_response(frequency) * loop.averaging_response(frequency)
    steps = np.exp(1j * omega[..., None] * loop.half_period * np.arange(loop.half_periods))
    states = (steps @ loop.bias_pattern.T).mean(axis=-1)
    rate = checks.finite_array("acceleration", acceleration) / omega
    return -_curvature(gyro) * rate**2 * np.real(np.conj(response) * states) / (2 * loop.half_periods)


def random_vibration_drift(gyro: ClosedLoopGyro, frequency: ArrayLike, density: ArrayLike) -> float:
    """Mean drift under random angular vibration, to second degree.

    Parameters
    ----------
    gyro : ClosedLoopGyro
        The gyro.
    frequency : array_like, shape (n,)
        Frequencies, Hz, rising, positive.
    density : array_like, shape (n,)
        One-sided power spectral density of the angular acceleration, (rad/s^2)^2/Hz.

    Returns
    -------
    float
        Mean rate error, rad/s: each band acts as an oscillation of its mean square, trapezoidal rule between
        frequencies.

    Raises
    ------
    ValueError
        If the shapes differ, a density is negative, or the frequencies do not rise.
    """
    frequency = checks.finite_array("frequency", frequency, ndim=1, min_size=2)
    density = checks.finite_array("density", density, shape=frequency.shape)
    if (np.diff(frequency) <= 0).any():
        raise ValueError("`frequency` must rise from entry to entry, in Hz")
    if (density < 0).any():
        raise ValueError(f"`density` must not be negative, got {density.min()}")
    from scipy.integrate import trapezoid

    return float(trapezoid(vibration_drift(gyro, 1.0, frequency) * 2 * density, frequency))


def full_response_drift(gyro: ClosedLoopGyro, acceleration: ArrayLike) -> NDArray[np.float64]:
    """Error of the reading under constant acceleration with the exact response of the interferometer.

    The phase moves by ``2 h = S eps dt`` from one bias state to the next, so that the pairs of a regulation period
    return ``sin(mean) sin(depth + h) / sin(depth)``. The loop settles where their mean asks for the phase gained in a
    regulation period, and the reading is off by the change of lag against a linear loop.

    Parameters
    ----------
    gyro : ClosedLoopGyro
        A gyro without second integrator and with one of the bias orders that visit the states in pairs.
    acceleration : array_like, shape (...,)
        Angular acceleration, rad/s^2.

    Returns
    -------
    ndarray, shape (...,)
        Rate error against the linear loop, rad/s; NaN where no lag can hold the loop. Its part even in the acceleration
        is the drift under slow vibration, its odd part a scale factor error of the lag.

    Raises
    ------
    ValueError
        If the loop has a second integrator or an unpaired bias order.
    """
    loop, to_phase = gyro.loop, gyro.coil.sagnac_scale_factor
    signs = np.unique(loop.bias_pattern[:, ::2])
    paired = signs.size == 1 and np.array_equal(loop.bias_pattern[:, 1::2], -loop.bias_pattern[:, ::2])
    if loop.second_gain or not paired:
        raise ValueError(
            "`gyro` must have no second integrator and the bias order 'minus-plus' or 'plus-minus', "
            f"got second_gain={loop.second_gain} and bias_order={loop.bias_order!r}"
        )
    half_step = 0.5 * to_phase * checks.finite_array("acceleration", acceleration) * loop.half_period
    lag = 2 * half_step * loop.half_periods / loop.gain  # what the linear loop settles at
    pairs = loop.half_periods // 2
    offsets = 4 * half_step[..., None] * (np.arange(pairs) - 0.5 * (pairs - 1))
    spread = np.cos(offsets).mean(axis=-1)  # mean of sin(lag + offset) over sin(lag)
    _curvature(gyro)  # refuses a drive with an error
    gain = np.sin(loop.depth - signs[0] * half_step) / np.sin(loop.depth)
    with np.errstate(invalid="ignore"):
        return (lag - np.arcsin(lag / (gain * spread))) / to_phase


def _curvature(gyro: ClosedLoopGyro) -> float:
    """``cot(depth) S``, s; ``ValueError`` for a drive with an error, whose resets the laws do not know."""
    loop = checks.instance("gyro", gyro, ClosedLoopGyro).loop
    if loop.v_pi_error:
        raise ValueError(
            f"`gyro.loop.v_pi_error` must be 0 for the drift laws, got {loop.v_pi_error}: wrong 2-pi resets "
            "shake the loop themselves. Use `measure.simulated_drift`"
        )
    return gyro.coil.sagnac_scale_factor / np.tan(loop.depth)


def _steady(gyro: ClosedLoopGyro) -> float:
    """Drift per squared acceleration at gain 1, ``1/4 cot(depth) S dt_m dt_p`` times the order sign, s^3."""
    loop = gyro.loop
    return 0.5 * _curvature(gyro) * loop.half_period * loop.regulation_period * loop.order_signs.mean()
