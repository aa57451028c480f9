"""What a filter says of each state, whether one may believe it, and what both filters check before they run."""

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.earth import POLE_MARGIN
from fogkit.estimation.consistency import chi_square_interval
from fogkit.gyrocompass.covariance import Noise
from fogkit.gyrocompass.error_model import STATES
from fogkit.gyrocompass.filters import _kernels
from fogkit.gyrocompass.filters.records import Fixes, Recording
from fogkit.gyrocompass.mechanisation import TRIM_MARGIN
from fogkit.gyrocompass.motions import Motion

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

FALSE_ALARM = 1e-6
"""Probability that a filter which is right is warned about."""

MARGINS = np.array([TRIM_MARGIN, POLE_MARGIN])


@dataclass(frozen=True, kw_only=True)
class FilterRun:
    """Estimates over time, in the quantities of the thesis.

    Attributes
    ----------
    time : ndarray, shape (k,)
        s; after the measurement of that time if there is one.
    estimate : ndarray, shape (k, 15)
        Heading, trim, roll, velocity, position, and the gyros' biases and scale factors: the quantities whose errors
        are `fogkit.gyrocompass.error_model.STATES`.
    covariance : ndarray, shape (k, 15, 15)
        Of their errors.
    fix_time, nis : ndarray, shape (m,)
        Times of the measurements, s, and their normalised innovations squared.
    fix_count : ndarray, shape (m,)
        How many numbers each held: what `nis` is on average.
    """

    time: Array
    estimate: Array
    covariance: Array
    fix_time: Array
    nis: Array
    fix_count: NDArray[np.int64]

    @property
    def std(self) -> Array:
        """Standard deviations, shape (k, 15)."""
        return np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2))

    def of(self, name: str) -> tuple[Array, Array]:
        """Estimate of a quantity and its standard deviation over time, each of shape (k,)."""
        index = STATES.index(checks.option("name", name, STATES))
        return self.estimate[:, index], self.std[:, index]

    def errors(self, motion: Motion, bias: ArrayLike = 0.0, scale_factor: ArrayLike = 0.0) -> Array:
        """Estimate less truth, shape (k, 15): heading, roll and longitude as angles in [-pi, pi)."""
        rows = np.rint(self.time / motion.dt).astype(int)
        truth = np.zeros((len(rows), 15))
        truth[:, :9], truth[:, 9:12], truth[:, 12:] = motion.states[rows], bias, scale_factor
        error = self.estimate - truth
        for k in (0, 2, 7):
            error[:, k] = wrapped(error[:, k])
        return error

    def to_frame(self) -> "DataFrame":
        """Table of estimates and of standard deviations (``heading_std``), index ``time`` in s."""
        import pandas as pd

        columns = [*STATES, *(f"{name}_std" for name in STATES)]
        index = pd.Index(self.time, name="time")
        return pd.DataFrame(np.hstack([self.estimate, self.std]), index=index, columns=columns)


def wrapped(angle: ArrayLike) -> Array:
    """Angle in [-pi, pi), rad."""
    return (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi


def fix_steps(recording: Recording, fixes: Fixes) -> NDArray[np.int64]:
    """Steps before which the measurements are taken, after the check that they lie on them; warn of gaps."""
    checks.instance("recording", recording, Recording)
    checks.instance("fixes", fixes, Fixes)
    steps = np.rint(fixes.time / recording.dt).astype(np.int64)
    off = np.abs(steps * recording.dt - fixes.time)
    if off.max() > 1e-6 * recording.dt * max(len(recording.dtheta), 1):
        worst = fixes.time[np.argmax(off)]
        raise ValueError(
            f"`fixes.time` must lie on the recording's steps of {recording.dt:g} s, got {worst:.9g} s. Interpolate "
            "what the aid says to them"
        )
    if steps[0] < 0 or steps[-1] > len(recording.dtheta):
        outside = fixes.time[0] if steps[0] < 0 else fixes.time[-1]
        raise ValueError(f"`fixes.time` must be in the recording, [0, {recording.duration:g}] s, got {outside:g} s")
    heard = fixes.time[np.isfinite(fixes.values).any(axis=1)]
    gaps = np.diff(np.concatenate([[0.0], heard, [recording.duration]]))
    if len(heard) == 1 and recording.duration > 0:
        warnings.warn(
            f"`fixes` has one measurement, at {heard[0]:g} s of {recording.duration:g} s; errors grow freely",
            UserWarning,
            stacklevel=3,
        )
    elif gaps.max() > 1.5 * fixes.aid.interval:
        at = [0.0, *heard][int(np.argmax(gaps))]
        warnings.warn(
            f"`fixes` has no measurement for {gaps.max():g} s from {at:g} s, where one comes "
            f"every {fixes.aid.interval:g} s; errors grow freely there",
            UserWarning,
            stacklevel=3,
        )
    return steps


def arguments(recording: Recording, noise: Noise, states: int, first_bias: int) -> tuple:
    """Arguments of the compiled loops between the geometry and the measurements."""
    walks = np.zeros(states)
    walks[first_bias : first_bias + 3] = checks.instance("noise", noise, Noise).rate_random_walk ** 2
    return recording.dt, np.square(noise.angle_random_walk), noise.velocity_random_walk**2, walks


def raise_failure(failure: int, step: int, dt: float) -> None:
    """The error that a compiled loop stopped with, if it did."""
    time = step * dt
    if failure == _kernels.NOT_A_COVARIANCE:
        raise ValueError(
            f"`prior` must lead to a covariance throughout, got one that is not positive semi-definite at {time:g} s: "
            "rounding, by an aid too good for a start so poor. Raise its standard deviations or lower the prior's."
        )
    if failure == _kernels.BOW_VERTICAL:
        raise ValueError(
            f"`recording` must keep trim {TRIM_MARGIN:g} rad from the vertical, where heading and roll are not defined "
            f"apart, got there at {time:g} s. `wander.run_wander` has an attitude without that."
        )
    if failure == _kernels.AT_A_POLE:
        raise ValueError(
            f"`recording` must keep {POLE_MARGIN:g} rad from a pole, where heading is not defined, got there at "
            f"{time:g} s"
        )


def warn_of_innovations(nis: Array, counts: NDArray[np.int64]) -> None:
    """Warn if innovations are larger than a filter that is right lets them be."""
    total = int(counts.sum())
    high = chi_square_interval(total, 1, 1 - 2 * FALSE_ALARM)[1]
    if nis.sum() > high:
        warnings.warn(
            f"the aid departs from what the filter expects by {np.sqrt(nis.sum() / total):.3g} standard deviations "
            f"(rms of {total} innovations, at most {np.sqrt(high / total):.4g} if the filter is right): a late or "
            "biased aid, noise larger than stated, or a heading too wrong for the linear model",
            UserWarning,
            stacklevel=3,
        )
