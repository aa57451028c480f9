"""Which combinations of its states an aided gyrocompass sees over a motion, and how strongly.

All measurements of a motion are stacked into one matrix that takes the errors at the start into them, without any noise
of the gyros: states in units of their prior standard deviations, measurements in units of their own. A singular value s
of it then says that along its direction the standard deviation falls to ``1/sqrt(1 + s**2)`` of the prior: a direction
with a value far above 1 is seen, one far below 1 is not. The rank is the number of those that are seen.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.gyrocompass import _kernels
from fogkit.gyrocompass.covariance import Aid, Prior, multiple
from fogkit.gyrocompass.error_model import STATES
from fogkit.gyrocompass.mechanisation import EARTH_RADIUS
from fogkit.gyrocompass.motions import Motion

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Observability:
    """What measurements say of some states at the start of a motion, the others being unknown to their priors.

    Attributes
    ----------
    names : tuple of str
        The states.
    singular_values : ndarray, shape (n,)
        Descending: information in units of the prior, its root.
    directions : ndarray, shape (n, n)
        In columns, in units of the prior, in the order of `names`.
    """

    names: tuple[str, ...]
    singular_values: Array
    directions: Array

    @property
    def fractions(self) -> Array:
        """Standard deviations over those of the prior along the directions, ascending: 1 is unseen."""
        return 1 / np.sqrt(1 + self.singular_values**2)

    def rank(self, threshold: float = 1.0) -> int:
        """Number of directions with a singular value above a threshold; 1: known better than by the prior."""
        return int((self.singular_values > checks.positive("threshold", threshold)).sum())

    def to_frame(self) -> "DataFrame":
        """Table with a row for each direction: ``singular_value``, ``fraction``, then its components by state."""
        import pandas as pd

        frame = pd.DataFrame(self.directions.T, columns=list(self.names))
        frame.insert(0, "singular_value", self.singular_values)
        frame.insert(1, "fraction", self.fractions)
        return frame.rename_axis("direction")


def directions_seen(motion: Motion, aid: Aid, prior: Prior, states: Sequence[str] = STATES) -> Observability:
    """Singular values and directions of what an aid says of states at the start of a motion, with perfect gyros.

    Parameters
    ----------
    motion : Motion
        True motion and readings.
    aid : Aid
        What is measured; the first measurement is at time 0.
    prior : Prior
        Units of the states. With a value of 0 a state would be known, which is refused.
    states : sequence of str, optional
        States to judge, all if not given. The others are unknown nuisances with their priors.

    Returns
    -------
    Observability
        `singular_values`, `directions`, `names`.

    Raises
    ------
    ValueError
        If a state has no name of `fogkit.gyrocompass.error_model.STATES`, a prior is zero, or the interval of the aid
        no multiple of the motion's step.
    """
    dt = checks.instance("motion", motion, Motion).dt
    every = multiple("aid.interval", checks.instance("aid", aid, Aid).interval, dt)
    kept = [STATES.index(checks.option("states", name, STATES)) for name in states]
    lat = motion.states[0, 6]
    stds = np.sqrt(np.diag(checks.instance("prior", prior, Prior).covariance(lat, linear=False)))
    if not (stds > 0).all():
        raise ValueError(f"`prior` must be above 0 for every state, got 0 for {STATES[int(np.argmin(stds))]}")
    measured = [STATES.index(name) for name in aid.std]
    weights = 1 / np.array(list(aid.std.values()))
    rows = [weights[:, np.newaxis] * Phi[measured] * stds for Phi in _transitions(motion)[::every]]
    R = np.linalg.qr(np.vstack(rows), mode="r")  # same singular values, 15 rows
    others = [k for k in range(len(STATES)) if k not in kept]
    if others:
        # others with their priors of one: the part of the kept columns that they cannot make
        nuisance = np.vstack([R[:, others], np.eye(len(others))])
        wanted = np.vstack([R[:, kept], np.zeros((len(others), len(kept)))])
        R = wanted - nuisance @ np.linalg.lstsq(nuisance, wanted, rcond=None)[0]
    _, values, Vt = np.linalg.svd(R, full_matrices=False)
    return Observability(names=tuple(states), singular_values=values, directions=Vt.T)


def _transitions(motion: Motion) -> Array:
    """Transition matrices from time 0 to each time, shape (n, 15, 15): to second order in the step, as the runs."""
    dt, out, F = motion.dt, np.empty((len(motion.time), 15, 15)), np.empty((15, 15))
    out[0] = np.eye(15)
    for k in range(len(motion.time) - 1):
        x = 0.5 * (motion.states[k] + motion.states[k + 1])
        radius = EARTH_RADIUS + x[8]
        _kernels.system_matrix(
            x,
            0.5 * (motion.rates[k] + motion.rates[k + 1]),
            0.5 * (motion.specific_force[k] + motion.specific_force[k + 1]),
            0.5 * (motion.mount_angle[k] + motion.mount_angle[k + 1]),
            0.5 * (motion.mount_rate[k] + motion.mount_rate[k + 1]),
            motion.axes,
            radius,
            motion.gravity * (EARTH_RADIUS / radius) ** 2,
            F,
        )
        step = F @ out[k]
        out[k + 1] = out[k] + dt * step + 0.5 * dt**2 * (F @ step)
    return out
