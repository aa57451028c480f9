"""The loop as `control` systems: linear for design, nonlinear for wiring into systems of one's own.

The linear systems have the regulation period as their time step. Input is the mean rate of a regulation period, output
the rate fed back during it. Margins and bandwidth are computed here from the loop's own formulas: for these loops
`control` 0.10 misses phase crossings at the Nyquist frequency, takes rounding near zero frequency for one where there
are two integrators, and has no bandwidth for most of them (chapter *How a closed-loop FOG measures rate*).
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from fogkit import checks
from fogkit.optics.gyro import ClosedLoopGyro
from fogkit.optics.interferometer import power, taylor_power
from fogkit.optics.loop import Loop, stable_gains
from fogkit.results import Record

if TYPE_CHECKING:
    from control import NonlinearIOSystem, StateSpace


def open_loop(loop: Loop) -> "StateSpace":
    """Open loop from residual to feedback.

    Parameters
    ----------
    loop : Loop
        The loop.

    Returns
    -------
    control.StateSpace
        One input ``residual``, one output ``rate_estimate``, time step the regulation period.

    Examples
    --------
    >>> loop = Loop(depth=2.0, half_period=5e-6, half_periods=16, gain=0.5)
    >>> open_loop(loop).poles().real.tolist()
    [1.0]
    """
    import control

    checks.instance("loop", loop, Loop)
    second, delay = int(loop.second_gain > 0), loop.delay
    n = 1 + second + delay
    A, B, C = np.zeros((n, n)), np.zeros((n, 1)), np.zeros((1, n))
    names = ["feedback"] + ["second"] * second + [f"waiting_{j}" for j in range(delay)]
    # states: feedback, [second], residuals waiting (oldest first); the oldest waiting one, or the input, is acted on
    drive = np.zeros(n), 0.0 if delay else 1.0
    if delay:
        drive[0][1 + second] = 1.0
        A[np.arange(1 + second, n - 1), np.arange(2 + second, n)] = 1.0
        B[n - 1] = 1.0
    A[0, 0] = 1.0
    A[0] += (loop.gain + loop.second_gain) * drive[0]
    B[0] += (loop.gain + loop.second_gain) * drive[1]
    if second:
        A[0, 1] = A[1, 1] = 1.0
        A[1] += loop.second_gain * drive[0]
        B[1] += loop.second_gain * drive[1]
    C[0, 0] = 1.0
    return control.ss(
        A, B, C, 0.0, loop.regulation_period, inputs="residual", outputs="rate_estimate", states=names, name="open_loop"
    )


def closed_loop(loop: Loop) -> "StateSpace":
    """Closed loop from the mean rate of a regulation period to the rate fed back during it; see `open_loop`."""
    import control

    return control.ss(control.feedback(open_loop(loop), 1), inputs="rate", outputs="rate_estimate", name="closed_loop")


def error_function(loop: Loop) -> "StateSpace":
    """Mean rate of a regulation period to the residual that is left of it; see `open_loop`."""
    import control

    unit = control.ss([], [], [], 1.0, loop.regulation_period)
    return control.ss(control.feedback(unit, open_loop(loop)), inputs="rate", outputs="residual", name="error_function")


@dataclass(frozen=True, kw_only=True)
class LoopFigures(Record):
    """What a designer asks of a loop.

    Attributes
    ----------
    gain_margin : float
        Factor by which all gains may rise before the loop is unstable.
    phase_margin : float
        Phase left at the gain crossover, rad.
    gain_crossover : float
        Frequency at which the open loop has gain 1, Hz.
    bandwidth : float
        Frequency at which the closed loop has fallen by 3 dB, Hz; infinite if it does not below the Nyquist frequency.
    peak : float
        Largest gain of the closed loop.
    """

    gain_margin: float
    phase_margin: float
    gain_crossover: float
    bandwidth: float
    peak: float


def figures(loop: Loop, points: int = 20001) -> LoopFigures:
    """Margins, bandwidth and peak of a loop, from its closed-form responses.

    Parameters
    ----------
    loop : Loop
        The loop.
    points : int, optional
        Frequencies, up to the Nyquist frequency, among which crossings are looked for before they are refined.

    Returns
    -------
    LoopFigures
        The figures; the averaging over the regulation period, which is the same for all loops, is not in them.
    """
    nyquist = 0.5 / checks.instance("loop", loop, Loop).regulation_period
    points = checks.integer("points", points, minimum=100)
    grid = np.linspace(nyquist / points, nyquist, points)

    def open_gain(frequency):
        return np.abs(loop.open_loop_response(frequency)) - 1

    def closed_gain(frequency):
        return np.abs(loop.closed_loop_response(frequency)) - np.sqrt(0.5)

    gain_crossover = _first_fall(open_gain, grid)
    bandwidth = _first_fall(closed_gain, grid)
    phase = np.angle(loop.open_loop_response(gain_crossover)) if np.isfinite(gain_crossover) else np.nan
    return LoopFigures(
        gain_margin=_gain_margin(loop),
        phase_margin=float((phase + np.pi) % (2 * np.pi)),
        gain_crossover=gain_crossover,
        bandwidth=bandwidth,
        peak=float(np.abs(loop.closed_loop_response(grid)).max()),
    )


def _gain_margin(loop: Loop) -> float:
    """Factor on both gains at which the loop becomes unstable, from `stable_gains`."""
    ratio = loop.second_gain / loop.gain
    if ratio == 0:
        return stable_gains(0.0, loop.delay)[1] / loop.gain

    def distance(factor):  # NaN limits mean that no gain is stable any more
        low, high = stable_gains(factor * loop.second_gain, loop.delay)
        return high - factor * loop.gain if low < factor * loop.gain else -1.0

    return float(brentq(distance, 1.0, 2.0 / loop.gain + 1))


def _first_fall(function, grid) -> float:
    """Lowest frequency at which a function falls through zero, inf if it never does."""
    values = function(grid)
    falls = np.flatnonzero((values[:-1] > 0) & (values[1:] <= 0))
    return float(brentq(function, grid[falls[0]], grid[falls[0] + 1])) if falls.size else np.inf


def nonlinear_system(gyro: ClosedLoopGyro, *, degree: int | None = None) -> "NonlinearIOSystem":
    """The whole gyro as a nonlinear `control` system, to be wired into systems of one's own.

    Parameters
    ----------
    gyro : ClosedLoopGyro
        The gyro. Its noise is not drawn: it comes in through the input ``power_noise``.
    degree : int, optional
        As in `simulate.stream`.

    Returns
    -------
    control.NonlinearIOSystem
        Time step half a modulation period. Inputs ``rate``, rad/s, and ``power_noise``, relative power; outputs
        ``rate_estimate``, rad/s, ``residual_phase``, rad, and ``power``, relative. States: feedback, second integrator
        and ramp, rad; demodulator sum; index of the half-period within the bias pattern; residuals waiting. It starts
        at rest from zero states, and equals `simulate.run` with ``initial_rate=0`` sample by sample; there is no watch
        on fringe lock.

    Notes
    -----
    ``control.interconnect`` wants ``check_unused=False`` where an output or ``power_noise`` is left open.
    """
    import control

    loop, to_phase = checks.instance("gyro", gyro, ClosedLoopGyro).loop, gyro.coil.sagnac_scale_factor
    if degree is not None:
        degree = checks.integer("degree", degree, minimum=1)
    pattern = loop.bias_pattern.ravel()
    k, delay, scale = loop.half_periods, loop.delay, 1.0 + loop.v_pi_error

    def look(x, u):
        """Ramp after this half-period's step, residual phase and relative power."""
        ramp = x[2] + x[0]
        turns = np.floor(ramp / (2 * np.pi))
        residual = to_phase * u[0] - scale * x[0] + 2 * np.pi * (scale - 1) * turns
        bias = pattern[round(x[4])] * loop.actual_depth
        light = power(residual + bias) if degree is None else taylor_power(residual, bias, degree)
        return ramp - 2 * np.pi * turns, residual, light + u[1]

    def update(t, x, u, params):
        ramp, _, light = look(x, u)
        index = round(x[4])
        new = np.array(x, dtype=float)
        new[2], new[3], new[4] = ramp, x[3] - pattern[index] * light, (index + 1) % pattern.size
        if (index + 1) % k == 0:
            acted_on = new[3] / (0.5 * np.sin(loop.depth) * k)
            if delay:
                acted_on, new[5:] = new[5], np.r_[new[6:], acted_on]
            new[1] += loop.second_gain * acted_on
            new[0] += loop.gain * acted_on + new[1]
            new[3] = 0.0
        return new

    def output(t, x, u, params):
        _, residual, light = look(x, u)
        return np.array([x[0] / to_phase, residual, light])

    return control.nlsys(
        update,
        output,
        inputs=["rate", "power_noise"],
        outputs=["rate_estimate", "residual_phase", "power"],
        states=["feedback", "second", "ramp", "demodulator", "index"] + [f"waiting_{j}" for j in range(delay)],
        dt=loop.half_period,
        name="gyro",
    )
