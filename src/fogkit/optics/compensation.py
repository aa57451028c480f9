"""Taking the acceleration drift out with the loop's own signals, and what that costs.

While the case accelerates, the phase moves by ``2 h`` between two bias states and the demodulated phase is off by
``cot(depth) * h * residual`` (`interferometer.demodulate`). Both factors are at hand: the residual is what the loop
demodulates, and the acceleration is how its own estimate of the rate changes. Their product is computed either inside
the loop (`InsideLoop`, an option of `simulate.stream`) or from its recorded signals (`after_loop`).

Detector noise is in both factors. The mean of the product of two noisy numbers is not the product of their means, so
that the remedy has a bias of its own, `noise_bias`, unless the acceleration is taken from samples whose noise has not
reached the residual.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fogkit import checks

if TYPE_CHECKING:
    from fogkit.optics.gyro import ClosedLoopGyro
    from fogkit.optics.simulate import LoopRecord

LAWS = ("quadratic", "full")
ACCELERATIONS = {"central": (-1, 1, 0.5), "ahead": (1, 2, 1.0)}
"""Differences of the rate estimate: earlier and later offset in regulation periods, and factor."""


@dataclass(frozen=True, kw_only=True)
class InsideLoop:
    """Correction of each demodulated phase before the controller sees it.

    Parameters
    ----------
    law : {"quadratic", "full"}, optional
        ``quadratic`` removes the product of acceleration and residual; ``full`` divides by the response at the depth
        that the acceleration makes, and inverts the sine of the interferometer too; a phase beyond what the sine
        returns is left as it is (`drift.full_response_drift`).
    lag : int, optional
        The acceleration is the feedback increment that the controller computed `lag` regulation periods ago; 0 is the
        one that the phase under correction itself asks for.
    depth : float, optional
        Modulation depth that the correction believes, rad, in (0, pi); None is the loop's nominal one.

    Raises
    ------
    ValueError
        If a parameter is out of its range.
    """

    law: str = "quadratic"
    lag: int = 0
    depth: float | None = None

    def __post_init__(self) -> None:
        checks.option("law", self.law, LAWS)
        checks.integer("lag", self.lag, minimum=0)
        if self.depth is not None:
            checks.in_open_interval("depth", self.depth, 0.0, np.pi, "rad")


@dataclass(frozen=True, kw_only=True)
class AfterLoop:
    """Correction of recorded signals, by `after_loop`.

    Parameters
    ----------
    law : {"quadratic", "full"}, optional
        As in `InsideLoop`.
    acceleration : {"central", "ahead"}, optional
        Where the acceleration comes from: the estimates one period before and after (``central``, no lag), or one and
        two periods later (``ahead``, whose noise is independent of the residual's, so that noise makes no bias).
    depth : float, optional
        As in `InsideLoop`.

    Raises
    ------
    ValueError
        If a parameter is out of its range.
    """

    law: str = "quadratic"
    acceleration: str = "central"
    depth: float | None = None

    def __post_init__(self) -> None:
        checks.option("law", self.law, LAWS)
        checks.option("acceleration", self.acceleration, ACCELERATIONS)
        if self.depth is not None:
            checks.in_open_interval("depth", self.depth, 0.0, np.pi, "rad")


def after_loop(record: LoopRecord, remedy: AfterLoop) -> LoopRecord:
    """Correct recorded signals for the drift under angular acceleration.

    The reading becomes feedback plus corrected residual, which follows the rate without the loop's lag.

    Parameters
    ----------
    record : LoopRecord
        Signals of a simulated or real loop, of at least 4 regulation periods.
    remedy : AfterLoop
        What is corrected, and how.

    Returns
    -------
    LoopRecord
        Same record with corrected `rate` and `residual`, without the periods at the ends for which there is no
        difference.

    Raises
    ------
    ValueError
        If the record is too short.
    TypeError
        If `remedy` is another one.
    """
    from fogkit.optics import _kernels  # here, since `numba` is slow to load

    checks.instance("remedy", remedy, AfterLoop)
    warn_if_idle(record.gyro)
    law = _kernels.LAWS[remedy.law]
    early, late, factor = ACCELERATIONS[remedy.acceleration]
    loop, coil = record.gyro.loop, record.gyro.coil
    depth = believed_depth(record.gyro, remedy)
    n = record.rate.size
    if n < 4:
        raise ValueError(f"`record` must hold at least 4 regulation periods, got {n}")
    kept = np.arange(max(0, -early), n - late)
    periods = np.round(record.time / loop.regulation_period - 0.5).astype(int)
    signs = loop.order_signs[periods % loop.order_signs.size]
    feedback, phases = coil.phase(record.rate), coil.phase(record.residual)
    corrected = phases.copy()
    for _ in range(2):  # the second time with the acceleration of the corrected estimates
        estimate = feedback + corrected
        increments = np.zeros(n)
        increments[kept] = factor * (estimate[kept + late] - estimate[kept + early])
        _kernels.linearise(phases, increments, signs, depth, law, loop.half_periods, corrected)
    return replace(
        record,
        time=record.time[kept],
        rate=coil.rate(feedback + corrected)[kept],
        residual=coil.rate(corrected)[kept],
        true_rate=record.true_rate[kept],
    )


def warn_if_idle(gyro: ClosedLoopGyro) -> None:
    """Warn that a remedy has nothing to act on where the order of the bias states has no first moment."""
    if not gyro.loop.order_signs.any():
        warnings.warn(
            f"the order of the bias states {gyro.loop.bias_order!r} has no first moment: the remedy takes nothing out",
            UserWarning,
            stacklevel=4,
        )


def believed_depth(gyro: ClosedLoopGyro, remedy: InsideLoop | AfterLoop) -> float:
    """Modulation depth that a remedy of a gyro believes, rad."""
    return gyro.loop.depth if remedy.depth is None else remedy.depth


def noise_bias(gyro: ClosedLoopGyro, remedy: InsideLoop | AfterLoop) -> float:
    """Shift of the mean reading that detector noise causes through a compensation, with the case at rest.

    Parameters
    ----------
    gyro : ClosedLoopGyro
        The gyro with its noise levels.
    remedy : InsideLoop or AfterLoop
        The correction.

    Returns
    -------
    float
        Shift, rad/s, to second degree in the noise: minus ``cot(depth) / (2 k)`` times the covariance of the noise in
        acceleration and residual. With gain 1 that covariance is +2, -1 and 0 times the noise variance for a `lag` of
        0, 1 and 2, and +1/2 and 0 for ``central`` and ``ahead``.
    """
    checks.instance("remedy", remedy, (InsideLoop, AfterLoop))
    loop = gyro.loop
    residual, increment = _noise_responses(gyro)
    if isinstance(remedy, InsideLoop):
        covariance = residual[remedy.lag :] @ increment[: residual.size - remedy.lag]
    else:
        early, late, factor = ACCELERATIONS[remedy.acceleration]
        # the estimate carries the noise of its own period only; the residual that of its past
        covariance = factor * sum(sign * residual[-at] for sign, at in ((1, late), (-1, early)) if at <= 0)
    scale = loop.order_signs.mean() / np.tan(believed_depth(gyro, remedy)) / (2 * loop.half_periods)
    return float(-scale * covariance * gyro.residual_noise**2 / gyro.coil.sagnac_scale_factor)


def _noise_responses(gyro: ClosedLoopGyro) -> tuple[np.ndarray, np.ndarray]:
    """Impulse responses, detector noise to residual and to feedback increment, long enough to have died away."""
    loop = gyro.loop
    length = 64
    while True:
        residual, increment, second = np.zeros(length), np.zeros(length), 0.0
        feedback, waiting = 0.0, [0.0] * loop.delay
        for i in range(length):
            residual[i] = (i == 0) - feedback
            increment[i] = loop.gain * residual[i] + second + loop.second_gain * residual[i]
            waiting.append(residual[i])
            delayed = waiting.pop(0)
            second += loop.second_gain * delayed
            feedback += loop.gain * delayed + second
        if np.abs(residual[-32:]).max() < 1e-15:
            return residual, increment
        length *= 2
