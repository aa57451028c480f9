"""The thesis's simulation by covariance: what the mount, off and then on, lets be known, for aids of any accuracy.

Latitude, aid and what is known at the start are not stated. The latitude is taken as that of St Petersburg, the start
from the errors of table 4; the aid is varied. `Inputs` has all that is not stated, `varied_inputs` what each does.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit.gyrocompass.covariance import Aid, CovarianceRun, Noise, Prior, run_covariance
from fogkit.gyrocompass.laws import MountLaw, QuasiHarmonic
from fogkit.gyrocompass.motions import Vessel
from fogkit.reproduction.lechang import paper
from fogkit.units import DEG, DEG_PER_HOUR, MINUTE, PERCENT

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


@dataclass(frozen=True, kw_only=True)
class Inputs:
    """What the thesis does not state of its simulation, with what is assumed here.

    Parameters
    ----------
    lat : float, optional
        Latitude, rad.
    velocity_std, position_std, interval : float, optional
        Standard deviations of the aid, m/s and m per component, and the time between its measurements, s.
    heading_std, bias_std, scale_factor_std, level_std : float, optional
        Of what is known at the start, rad, rad/s, 1, rad.
    angle_random_walk : float, optional
        Of the gyros, rad/sqrt(s): table 4, read as two-sided.
    velocity_random_walk : float, optional
        Of the accelerometers, m/s/sqrt(s).
    switch_on : float, optional
        Time at which the mount is switched on, s.
    step : float, optional
        Time between samples, s.
    """

    lat: float = paper.ASSUMED_LATITUDE
    velocity_std: float = 0.01
    position_std: float = 3.0
    interval: float = 1.0
    heading_std: float = ASSUMED_PRIOR.heading
    bias_std: float = ASSUMED_PRIOR.bias
    scale_factor_std: float = ASSUMED_PRIOR.scale_factor
    level_std: float = ASSUMED_PRIOR.level
    angle_random_walk: float = paper.SIMULATED_RANDOM_WALK
    velocity_random_walk: float = 0.0
    switch_on: float = ASSUMED_SWITCH_ON
    step: float = STEP

    @property
    def prior(self) -> Prior:
        """What is known at the start."""
        return Prior(
            heading=self.heading_std, level=self.level_std, bias=self.bias_std, scale_factor=self.scale_factor_std
        )


VARIED = {
    ("as assumed", "see above"): Inputs(),
    ("latitude", "0°"): Inputs(lat=0.0),
    ("latitude", "75°"): Inputs(lat=75 * DEG),
    ("aid, velocity", "1 mm/s"): Inputs(velocity_std=0.001),
    ("aid, velocity", "10 cm/s"): Inputs(velocity_std=0.1),
    ("aid, velocity", "1 m/s"): Inputs(velocity_std=1.0),
    ("aid, position", "0.1 m"): Inputs(position_std=0.1),
    ("aid, interval", "0.1 s"): Inputs(interval=0.1),
    ("aid, interval", "10 s"): Inputs(interval=10.0),
    ("heading at the start", "1°"): Inputs(heading_std=1 * DEG),
    ("heading at the start", "30°"): Inputs(heading_std=30 * DEG),
    ("biases at the start", "60°/h"): Inputs(bias_std=60 * DEG_PER_HOUR),
    ("scale factors at the start", "5 %"): Inputs(scale_factor_std=5 * PERCENT),
    ("level at the start", "0.1°"): Inputs(level_std=0.1 * DEG),
    ("gyro noise", "one-sided"): Inputs(angle_random_walk=paper.SIMULATED_RANDOM_WALK / 2**0.5),
    ("accelerometer noise", "0.1 m/s/√h"): Inputs(velocity_random_walk=0.1 / (60 * MINUTE) ** 0.5),
    ("mount on after", "0 s"): Inputs(switch_on=0.0),
    ("mount on after", "200 s"): Inputs(switch_on=200.0),
    ("sampling", "10 Hz"): Inputs(step=0.1),
    ("sampling", "100 Hz"): Inputs(step=0.01),
}
"""One input at a time, each to a value that a reader may think as likely as that assumed."""


def off_then_on(
    velocity_std: float | None = None,
    lat: float = paper.ASSUMED_LATITUDE,
    *,
    inputs: Inputs | None = None,
    duration_on: float = ASSUMED_DURATION - ASSUMED_SWITCH_ON,
) -> tuple[CovarianceRun | None, CovarianceRun]:
    """Covariance with the mount off, from the start, and with it on, from where that ended.

    Parameters
    ----------
    velocity_std : float, optional
        Standard deviation of the aid's velocity, m/s, once a second; position 3 m.
    lat : float, optional
        Latitude, rad.
    inputs : Inputs, optional
        All that is not stated, in place of the two.
    duration_on : float, optional
        How long the mount is on, s.

    Returns
    -------
    tuple of CovarianceRun
        Times of the second count from the switching on; the first is None if the mount is on from the start.
    """
    if inputs is None:
        inputs = Inputs(lat=lat) if velocity_std is None else Inputs(lat=lat, velocity_std=velocity_std)
    noise = Noise(angle_random_walk=inputs.angle_random_walk, velocity_random_walk=inputs.velocity_random_walk)
    aid = Aid.satellite(inputs.lat, inputs.velocity_std, inputs.position_std, inputs.interval)
    off, start, ship = None, inputs.prior, vessel(inputs.lat)
    if inputs.switch_on:
        off = run_covariance(ship.motion(inputs.switch_on, inputs.step), noise, aid, start)
        start = off.covariance
    return off, run_covariance(ship.motion(duration_on, inputs.step, mount()), noise, aid, start)


def varied_inputs() -> "DataFrame":
    """What each unstated input does: one varied at a time, `VARIED`.

    Returns
    -------
    DataFrame
        Index ``input``, ``value``; standard deviations ``heading_0``, ``bias_0``, ``scale_0`` when the mount is
        switched on, ``..._200`` and ``..._500`` so many seconds later: deg, deg/h and percent, of biases and scale
        factors the largest of the three gyros.
    """
    import pandas as pd

    rows = {}
    for key, inputs in VARIED.items():
        _, on = off_then_on(inputs=inputs)
        rows[key] = {}
        for t in (0, 200, 500):
            std = on.std[t]
            rows[key] |= {
                f"heading_{t}": std[0] / DEG,
                f"bias_{t}": std[9:12].max() / DEG_PER_HOUR,
                f"scale_{t}": std[12:].max() / PERCENT,
            }
    table = pd.DataFrame.from_dict(rows, orient="index")
    table.index = pd.MultiIndex.from_tuples(table.index, names=["input", "value"])
    return table[sorted(table.columns, key=lambda name: (name.split("_")[0] != "heading", name))]


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
