"""The thesis's simulation by covariance: what the mount, off and then on, lets be known, for aids of any accuracy.

Latitude, aid and what is known at the start are not stated. The latitude is taken as that of St Petersburg, the start
from the errors of table 4; the aid is varied.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit.gyrocompass.covariance import Aid, CovarianceRun, Noise, Prior, run_covariance
from fogkit.gyrocompass.laws import MountLaw, QuasiHarmonic
from fogkit.gyrocompass.motions import Vessel
from fogkit.reproduction.lechang import paper
from fogkit.units import DEG, DEG_PER_HOUR, PERCENT

if TYPE_CHECKING:
    from pandas import DataFrame

ASSUMED_SWITCH_ON = 400.0
"""Time at which the mount is switched on, s: between the marks I and II of figure 5, which is lost."""

ASSUMED_DURATION = 900.0
ASSUMED_PRIOR = Prior(heading=10 * DEG, bias=6 * DEG_PER_HOUR, scale_factor=0.5 * PERCENT)
"""Heading so that the thesis's own model is linear enough; gyros as the largest of table 4."""

STEP = 0.05
VELOCITY_STD = (0.001, 0.01, 0.1)
"""Standard deviations of the aid's velocity, m/s, once a second: a zero that is known, and receivers good and fair."""

SEEN = ("heading", "bias_x", "bias_y", "bias_z", "scale_factor_x", "scale_factor_y", "scale_factor_z")

CUBE = np.eye(3)
"""Gyros along the axes of the mount, one along that of its turning: the arrangement of the compass Omega."""


def vessel(lat: float = paper.ASSUMED_LATITUDE, rolling: bool = True) -> Vessel:
    """The vessel of the simulation, with its rolling or without."""
    return Vessel(
        lat=lat,
        heading=paper.HEADING,
        trim=paper.TRIM,
        roll=paper.ROLL_MEAN,
        roll_swing=paper.ROLL_SWING if rolling else 0.0,
        roll_period=paper.ROLL_SWING_PERIOD,
    )


def mount() -> MountLaw:
    """The law of the mount once it is on."""
    return QuasiHarmonic(amplitude=paper.MOUNT_AMPLITUDE, period=paper.MOUNT_PERIOD)


def off_then_on(velocity_std: float, lat: float = paper.ASSUMED_LATITUDE) -> tuple[CovarianceRun, CovarianceRun]:
    """Covariance with the mount off, from the start, and with it on, from where that ended.

    Parameters
    ----------
    velocity_std : float
        Standard deviation of the aid's velocity, m/s, once a second; position 3 m.
    lat : float, optional
        Latitude, rad.

    Returns
    -------
    tuple of CovarianceRun
        Times of the second count from the switching on.
    """
    noise, aid = Noise(angle_random_walk=paper.SIMULATED_RANDOM_WALK), Aid.satellite(lat, velocity=velocity_std)
    off = run_covariance(vessel(lat).motion(ASSUMED_SWITCH_ON, STEP), noise, aid, ASSUMED_PRIOR)
    rest = ASSUMED_DURATION - ASSUMED_SWITCH_ON
    return off, run_covariance(vessel(lat).motion(rest, STEP, mount()), noise, aid, off.covariance)


def settling(velocity_stds: tuple[float, ...] = VELOCITY_STD) -> "DataFrame":
    """Standard deviations when the mount is switched on, 200 s later and at the end, for several aids.

    Returns
    -------
    DataFrame
        Index ``velocity_std``, ``time_on`` (s); columns ``heading_deg``, ``bias_dph`` and ``scale_percent``, the last
        two the largest of the three gyros.
    """
    import pandas as pd

    rows = []
    for std in velocity_stds:
        off, on = off_then_on(std)
        for time, values in ((0.0, off.std[-1]), *((t, on.std[round(t)]) for t in (paper.SETTLING_TIME, on.time[-1]))):
            rows.append(
                {
                    "velocity_std": std,
                    "time_on": float(time),
                    "heading_deg": values[0] / DEG,
                    "bias_dph": values[9:12].max() / DEG_PER_HOUR,
                    "scale_percent": values[12:].max() / PERCENT,
                }
            )
    return pd.DataFrame(rows).set_index(["velocity_std", "time_on"])


def unseen(law: MountLaw | None, rolling: bool, axes: NDArray[np.float64] | None = None) -> tuple[NDArray, NDArray]:
    """What almost perfect gyros and aid leave unknown of heading, biases and scale factors in 400 s.

    Parameters
    ----------
    law : MountLaw or None
        Law of the mount; None: off.
    rolling : bool
        Whether the vessel rolls.
    axes : ndarray, shape (3, 3), optional
        Input axes of the gyros in the mount; the pyramid's if not given.

    Returns
    -------
    fractions : ndarray, shape (7,)
        Standard deviations over those of the prior along the directions of `directions`, ascending: 1 is unseen.
    directions : ndarray, shape (7, 7)
        In columns, in units of the prior, in the order of `SEEN`.
    """
    prior = Prior(heading=10 * DEG, bias=10 * DEG_PER_HOUR, scale_factor=1 * PERCENT, position=1.0, height=1.0)
    motion = vessel(rolling=rolling).motion(400.0, STEP, law, axes=axes)
    aid = Aid.satellite(paper.ASSUMED_LATITUDE, velocity=1e-3, position=0.1)
    run = run_covariance(motion, Noise(angle_random_walk=1e-9), aid, prior)
    kept = [0, *range(9, 15)]
    std = np.sqrt(np.diag(prior.covariance(paper.ASSUMED_LATITUDE)))[kept]
    values, directions = np.linalg.eigh(run.covariance[np.ix_(kept, kept)] / np.outer(std, std))
    return np.sqrt(np.maximum(values, 0.0)), directions
