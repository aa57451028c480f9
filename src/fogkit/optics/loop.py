"""The digital loop: its parameters, when it is stable, and how it responds.

In every regulation period of k modulation half-periods the loop demodulates the mean residual phase and corrects its
feedback once::

    second[i + 1]   = second[i] + second_gain * residual[i - delay]
    feedback[i + 1] = feedback[i] + gain * residual[i - delay] + second[i + 1]

so that the open loop from residual to feedback is ``z**-delay (gain + second_gain z / (z - 1)) / (z - 1)``. A `gain` of
1 closes on the whole estimated error at once; the second integrator removes the lag under constant acceleration. The
linear model is that of a drive without error.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks

BIAS_ORDERS: dict[str, tuple[tuple[int, ...], ...]] = {
    "minus-plus": ((-1, 1),),
    "plus-minus": ((1, -1),),
    "alternating": ((-1, 1), (1, -1)),
    "mirrored": ((-1, 1, 1, -1),),
    "balanced": ((-1, 1, 1, -1, 1, -1, -1, 1),),
}
"""Named orders of the two bias states: rows for successive regulation periods, each repeated to fill one.

``minus-plus`` is the paper's order. ``alternating`` changes the order from one regulation period to the next;
``mirrored`` cancels the first moment of the states in time, ``balanced`` (Thue-Morse) the first and the second.
"""


@dataclass(frozen=True, kw_only=True)
class Loop:
    """Modulation and digital controller of a closed-loop gyro.

    Parameters
    ----------
    depth : float
        Modulation depth, rad, in (0, pi): the bias alternates between plus and minus `depth`.
    half_period : float
        Half of the modulation period, s; the coil's transit time where it is modulated at its proper frequency.
    half_periods : int
        Half-periods of modulation per regulation period (the paper's k), even.
    gain : float, optional
        Share of the demodulated error that is corrected at once.
    second_gain : float, optional
        Gain of a second integrator ahead of the rate register; 0 leaves it out.
    delay : int, optional
        Regulation periods by which the correction comes late, beyond the one that sampling costs.
    bias_order : str or array_like of int, shape (rows, half_periods), optional
        A name from `BIAS_ORDERS`, or the states (-1, +1) themselves, each row with as many of one as of the other.
    v_pi_error : float, optional
        Relative error of the modulator's drive: every phase that it makes is ``1 + v_pi_error`` times the one asked
        for.

    Raises
    ------
    ValueError
        If a parameter is out of its range, the bias order does not fit `half_periods`, or the loop is unstable.

    Warns
    -----
    UserWarning
        If the gain is within 5 % of a limit of stability.

    Examples
    --------
    >>> loop = Loop(depth=3 * np.pi / 4, half_period=5e-6, half_periods=16)
    >>> round(1 / loop.regulation_period)                    # Hz
    12500
    """

    depth: float
    half_period: float
    half_periods: int
    gain: float = 1.0
    second_gain: float = 0.0
    delay: int = 0
    bias_order: str | ArrayLike = "minus-plus"
    v_pi_error: float = 0.0

    def __post_init__(self) -> None:
        checks.in_open_interval("depth", self.depth, 0.0, np.pi, "rad", fix="Multiply degrees by `fogkit.units.DEG`")
        checks.positive("half_period", self.half_period, "s")
        # whole floats pass the checks and are kept as integers
        object.__setattr__(
            self, "half_periods", checks.integer("half_periods", self.half_periods, minimum=2, even=True)
        )
        object.__setattr__(self, "delay", checks.integer("delay", self.delay, minimum=0))
        checks.in_open_interval("v_pi_error", self.v_pi_error, -0.5, 0.5)
        checks.in_open_interval("depth * (1 + v_pi_error)", self.depth * (1 + self.v_pi_error), 0.0, np.pi, "rad")
        self._check_stability()
        if not isinstance(self.bias_order, str):  # hashable and comparable, whatever it came as
            states = tuple(tuple(row) for row in np.atleast_2d(np.asarray(self.bias_order)).tolist())
            object.__setattr__(self, "bias_order", states)
        _ = self.bias_pattern

    def _check_stability(self) -> None:
        checks.non_negative("second_gain", self.second_gain)
        checks.positive("gain", self.gain)
        low, high = stable_gains(self.second_gain, self.delay)
        if not low < self.gain < high:
            allowed = f"in ({low:.6g}, {high:.6g})" if low < high else "smaller, with a smaller `second_gain` too,"
            raise ValueError(
                f"`gain` must be {allowed} for a stable loop with `second_gain`={self.second_gain:.6g} "
                f"and `delay`={self.delay}, got {self.gain:.6g}. Lower the gain or the delay"
            )
        if self.gain > 0.95 * high or self.gain < 1.05 * low:
            warnings.warn(
                f"`gain` {self.gain:.6g} is within 5 % of a limit of stability: "
                f"stable gains are ({low:.6g}, {high:.6g})",
                UserWarning,
                stacklevel=4,
            )

    @property
    def regulation_period(self) -> float:
        """Time between two corrections of the feedback, s."""
        return self.half_period * self.half_periods

    @property
    def actual_depth(self) -> float:
        """Modulation depth with the drive's error, rad."""
        return self.depth * (1 + self.v_pi_error)

    @property
    def bias_pattern(self) -> NDArray[np.float64]:
        """Bias states -1 and +1, shape (rows, half_periods); successive regulation periods use successive rows."""
        if isinstance(self.bias_order, str):
            rows = np.array(BIAS_ORDERS[checks.option("bias_order", self.bias_order, BIAS_ORDERS)], dtype=float)
            repeats, left = divmod(self.half_periods, rows.shape[1])
            if left:
                raise ValueError(
                    f"`half_periods` must be a multiple of {rows.shape[1]} for the bias order {self.bias_order!r}, "
                    f"got {self.half_periods}"
                )
            return np.tile(rows, repeats)
        rows = checks.finite_array("bias_order", self.bias_order, shape=(None, self.half_periods))
        if not (np.abs(rows) == 1).all() or rows.sum(axis=1).any():
            raise ValueError(
                f"`bias_order` must hold -1 and +1, as many of one as of the other in each row, got {rows.tolist()}"
            )
        return rows

    @property
    def order_signs(self) -> NDArray[np.float64]:
        """First moment of each row of the bias pattern, shape (rows,): 1 for minus-plus, -1 for plus-minus."""
        return self.bias_pattern @ np.arange(self.half_periods) * 2 / self.half_periods

    def open_loop_response(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Feedback over residual at `frequency`, Hz, of any shape; infinite at zero frequency."""
        numerator, denominator = self._open_loop_fraction(frequency)
        with np.errstate(divide="ignore", invalid="ignore"):
            return numerator / denominator

    def closed_loop_response(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Rate estimate over mean rate of a regulation period at `frequency`, Hz, any shape; 1 at zero frequency."""
        numerator, denominator = self._open_loop_fraction(frequency)
        return numerator / (denominator + numerator)

    def _open_loop_fraction(self, frequency: ArrayLike) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        z = np.exp(2j * np.pi * np.asarray(frequency, dtype=float) * self.regulation_period)
        if self.second_gain == 0:
            return np.full_like(z, self.gain), z**self.delay * (z - 1)
        return self.gain * (z - 1) + self.second_gain * z, z**self.delay * (z - 1) ** 2

    def averaging_response(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Mean over a regulation period relative to its first half-period, at `frequency`, Hz, of any shape."""
        step = 2j * np.pi * np.asarray(frequency, dtype=float) * self.half_period
        return np.exp(step[..., None] * np.arange(self.half_periods)).mean(axis=-1)


def stable_gains(second_gain: float = 0.0, delay: int = 0) -> tuple[float, float]:
    """Open interval of gains for which the loop is stable; ``(nan, nan)`` if there is none.

    Parameters
    ----------
    second_gain, delay
        As in `Loop`.

    Returns
    -------
    tuple of float
        Lower and upper limit: gains at which a root of the characteristic polynomial is on the unit circle. Without a
        second integrator the upper one is ``2 sin(pi / (4 delay + 2))``, without delay ``2 - second_gain / 2``.

    Examples
    --------
    >>> [round(x, 6) for x in stable_gains(delay=1)]
    [0.0, 1.0]
    """
    second_gain = checks.non_negative("second_gain", second_gain)
    delay = checks.integer("delay", delay, minimum=0)
    if second_gain == 0:
        return 0.0, float(2 * np.sin(np.pi / (4 * delay + 2)))
    if delay > 50:
        raise ValueError(f"`delay` must be at most 50 with a second integrator, got {delay}")

    from scipy.optimize import brentq  # here, since SciPy's optimisers are slow to load

    # z**d (z - 1)**2 + gain (z - 1) + second_gain z = 0 at z = exp(j theta) has a real gain where `imaginary` is 0
    def imaginary(theta: ArrayLike) -> NDArray[np.float64]:
        return 4 * np.sin(theta / 2) ** 2 * np.cos(theta * (delay + 0.5)) - second_gain * np.cos(theta / 2)

    def gain(theta: float) -> float:
        return float(2 * np.sin(theta / 2) * np.sin(theta * (delay + 0.5)) - second_gain / 2)

    grid = np.linspace(1e-6, np.pi, 400 * (delay + 1))
    signs = imaginary(grid[:-1])
    crossings = [brentq(imaginary, grid[i], grid[i + 1]) for i in np.flatnonzero(signs[:-1] * signs[1:] < 0)]
    limits = np.unique(np.clip([0.0, gain(np.pi), *map(gain, crossings)], 0.0, None))
    stable = [
        (float(low), float(high))
        for low, high in pairwise(limits)
        if high - low > 1e-12
        and _is_stable(0.5 * (low + high), second_gain, delay)  # two limits may differ by rounding
    ]
    return stable[0] if stable else (np.nan, np.nan)


def _characteristic(gain: float, second_gain: float, delay: int) -> NDArray[np.float64]:
    """Coefficients of the characteristic polynomial, highest power first."""
    if second_gain == 0:
        return np.polyadd(np.r_[1.0, -1.0, np.zeros(delay)], [gain])
    return np.polyadd(np.r_[1.0, -2.0, 1.0, np.zeros(delay)], [gain + second_gain, -gain])


def _is_stable(gain: float, second_gain: float, delay: int) -> bool:
    return bool((np.abs(np.roots(_characteristic(gain, second_gain, delay))) < 1).all())
