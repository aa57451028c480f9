"""Compiled sample loops of the closed-loop gyro: plain arrays in, plain arrays out, nothing checked.

State vector (float64), carried from block to block by `simulate.stream`::

    state[0]     phase step of the feedback, rad per half-period
    state[1]     register of the second integrator, rad
    state[2]     phase ramp, rad in [0, 2 pi)
    state[3]     2-pi resets so far
    state[4:4+delay]                     demodulated phases waiting in the delay line, oldest first
    state[4+delay:4+delay+lag]           increments of the feedback, newest first (for the compensation)
"""

import math

import numpy as np
from numba import njit

TWO_PI = 2.0 * math.pi
C2, C4, C6, C8, C10, C12 = (-1.0 / 2, 1.0 / 24, -1.0 / 720, 1.0 / 40320, -1.0 / 3628800, 1.0 / 479001600)
S3, S5, S7, S9, S11 = (-1.0 / 6, 1.0 / 120, -1.0 / 5040, 1.0 / 362880, -1.0 / 39916800)
UNCOMPENSATED, QUADRATIC, FULL = 0, 1, 2
LAWS = {"quadratic": QUADRATIC, "full": FULL}


@njit(cache=True, nogil=True)
def sinusoid(amplitude, cycles_per_sample, first_cycle, out):
    """Fill `out` with ``amplitude * sin(2 pi (first_cycle + n * cycles_per_sample))``."""
    block = 64  # the recurrence is restarted from an exact sine this often: its error stays near 1e-14
    c = math.cos(TWO_PI * cycles_per_sample)
    s = math.sin(TWO_PI * cycles_per_sample)
    for start in range(0, out.size, block):
        angle = TWO_PI * ((first_cycle + start * cycles_per_sample) % 1.0)
        re, im = amplitude * math.cos(angle), amplitude * math.sin(angle)
        for n in range(start, min(start + block, out.size)):
            out[n] = im
            re, im = re * c - im * s, re * s + im * c


@njit(cache=True, nogil=True, inline="always")
def _cosine_near(cosine, sine, change):
    """``cos(anchor + change)`` from cosine and sine of the anchor; Taylor to rounding for ``|change| <= 0.25``.

    Within a regulation period the residual moves little, so two library calls serve all its half-periods;
    the first neglected term is 0.25**14 / 14! = 4e-20.
    """
    x = change * change
    c = 1.0 + x * (C2 + x * (C4 + x * (C6 + x * (C8 + x * (C10 + x * C12)))))
    s = 1.0 + x * (S3 + x * (S5 + x * (S7 + x * (S9 + x * S11))))
    return cosine * c - sine * change * s


@njit(cache=True, nogil=True, inline="always")
def _horner(coefficients, x):
    value = 0.0
    for j in range(coefficients.size - 1, -1, -1):
        value = value * x + coefficients[j]
    return value


@njit(cache=True, nogil=True)
def _linearised(phase, increment, order_sign, nominal_depth, law, k):
    """Demodulated phase without the cross-term of acceleration and lag; as it came where `FULL` has no inverse."""
    half_step = increment / (2.0 * k)  # half of the phase gained from one bias state to the next
    if law == QUADRATIC:
        return phase * (1.0 - order_sign * half_step / math.tan(nominal_depth))
    spread = 1.0  # mean of the cosines of the phases at which the pairs of states stand about their middle
    if half_step != 0.0:
        spread = math.sin(k * half_step) / (0.5 * k * math.sin(2.0 * half_step))
    sine = phase * math.sin(nominal_depth) / (math.sin(nominal_depth + order_sign * half_step) * spread)
    return math.asin(sine) if abs(sine) <= 1.0 else phase


@njit(cache=True, nogil=True)
def advance(
    phase_in,  # Sagnac phase of each half-period, shape (n * k,)
    noise,  # standard normal numbers, shape (n * k,), or empty for a silent detector
    noise_levels,  # detector, shot and intensity noise of one half-period, shape (3,)
    pattern,  # bias states +1 or -1, shape (rows, k)
    order_signs,  # first moment of each row of `pattern`, see `loop.Loop.order_signs`, shape (rows,)
    first_period,  # index of the first regulation period: which row of `pattern` is due
    depth,  # actual modulation depth
    nominal_depth,  # the depth that demodulation and compensation believe
    gain,
    second_gain,
    delay,
    step_scale,  # actual phase step over the commanded one: 1 + V_pi error
    taylor_minus,  # Taylor coefficients of the power about -depth; empty for the exact response
    taylor_plus,
    law,  # UNCOMPENSATED, QUADRATIC or FULL
    lag,  # periods by which the compensation's increment is older than the phase that it corrects
    compensation_depth,
    lock_limit,  # residual phase beyond which the fringe is lost; inf switches the watch off
    state,
    out_feedback,  # phase step applied in each regulation period, shape (n,)
    out_residual,  # demodulated phase of each regulation period, shape (n,)
):
    """Run the loop over whole regulation periods; return the half-period at which lock was lost, or -1."""
    rows, k = pattern.shape
    exact = taylor_minus.size == 0
    noisy = noise.size > 0
    normalise = 1.0 / (0.5 * math.sin(nominal_depth) * k)
    feedback, second, ramp, resets = state[0], state[1], state[2], state[3]
    history = 4 + delay
    excess = step_scale - 1.0
    for i in range(out_feedback.size):
        row = (first_period + i) % rows
        demodulated = 0.0
        anchor = phase_in[i * k] - step_scale * feedback
        cos_minus, sin_minus = math.cos(anchor - depth), math.sin(anchor - depth)
        cos_plus, sin_plus = math.cos(anchor + depth), math.sin(anchor + depth)
        for m in range(k):
            n = i * k + m
            ramp += feedback
            turns = 0.0
            if ramp < 0.0 or ramp >= TWO_PI:
                turns = np.floor(ramp / TWO_PI)
                ramp -= turns * TWO_PI
                resets += abs(turns)
            # a reset of exactly 2 pi leaves the interference as it is: only its error is seen
            residual = phase_in[n] - step_scale * feedback + TWO_PI * excess * turns
            if not abs(residual) <= lock_limit:
                return n
            state_sign = pattern[row, m]
            if exact:
                change = residual - anchor
                if abs(change) > 0.25:
                    cosine = math.cos(residual + state_sign * depth)
                elif state_sign < 0:
                    cosine = _cosine_near(cos_minus, sin_minus, change)
                else:
                    cosine = _cosine_near(cos_plus, sin_plus, change)
                power = 0.5 * (1.0 + cosine)
            elif state_sign < 0:
                power = _horner(taylor_minus, residual)
            else:
                power = _horner(taylor_plus, residual)
            if noisy:
                variance = noise_levels[0] ** 2 + noise_levels[1] ** 2 * power + (noise_levels[2] * power) ** 2
                power += math.sqrt(max(variance, 0.0)) * noise[n]
            demodulated -= state_sign * power
        phase = demodulated * normalise
        out_feedback[i] = feedback
        out_residual[i] = phase

        if law != UNCOMPENSATED:
            sign = order_signs[row]
            if lag == 0:  # the increment that the phase itself asks for, then that of the corrected phase
                provisional = second + (gain + second_gain) * phase
                provisional = _linearised(phase, provisional, sign, compensation_depth, law, k)
                increment = second + (gain + second_gain) * provisional
            else:
                increment = state[history + lag - 1]
            phase = _linearised(phase, increment, sign, compensation_depth, law, k)
            for j in range(lag - 1, 0, -1):
                state[history + j] = state[history + j - 1]
            if lag > 0:
                state[history] = second + (gain + second_gain) * phase
        if delay > 0:
            oldest = state[4]
            for j in range(delay - 1):
                state[4 + j] = state[5 + j]
            state[3 + delay] = phase
            phase = oldest
        second += second_gain * phase
        feedback += gain * phase + second
    state[0], state[1], state[2], state[3] = feedback, second, ramp, resets
    return -1


@njit(cache=True, nogil=True)
def period_means(values, k, out):
    """Mean of every `k` consecutive `values`."""
    for i in range(out.size):
        total = 0.0
        for m in range(k):
            total += values[i * k + m]
        out[i] = total / k


@njit(cache=True, nogil=True)
def linearise(phases, increments, order_signs, nominal_depth, law, k, out):
    """Apply `_linearised` to every regulation period; all arrays of shape (n,), `order_signs` too."""
    for i in range(out.size):
        out[i] = _linearised(phases[i], increments[i], order_signs[i], nominal_depth, law, k)
