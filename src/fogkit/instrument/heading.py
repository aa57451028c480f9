"""What errors that were left do to heading: found from the mean rate of a unit at rest, or by a filter on a mount.

At rest the unit lies level and heading comes from its mean readings (`fogkit.calibration.navigation_based.azimuth`).
With the mount the three gyros stand on it as the pyramid of `fogkit.gyrocompass.frames` and turn, while the
accelerometers stay in the hull; heading comes from the filter of `fogkit.gyrocompass.filters.wander`.
"""

import warnings
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.calibration.navigation_based.azimuth import gyrocompass_azimuth
from fogkit.calibration.navigation_based.compensation import Compensation
from fogkit.constants import EARTH_RATE
from fogkit.earth import earth_rate_n, gravity_n
from fogkit.gyrocompass.covariance import Aid, Noise, Prior
from fogkit.gyrocompass.design import HeadingAccuracy, heading_accuracy
from fogkit.gyrocompass.design_inputs import GyroGrade
from fogkit.gyrocompass.filters.records import Fixes, Recording, draw_start, record, take_fixes
from fogkit.gyrocompass.filters.runs import wrapped
from fogkit.gyrocompass.filters.wander import run_wander
from fogkit.gyrocompass.frames import TO_PACKAGE
from fogkit.gyrocompass.laws import Fixed, MountLaw
from fogkit.gyrocompass.mechanisation import CompassState
from fogkit.gyrocompass.motions import Motion, Vessel
from fogkit.imu.tables import IMU_COLUMNS
from fogkit.instrument.errors_left import ErrorsLeft
from fogkit.noise.processes import RandomErrors, simulate
from fogkit.rotation import dcm_from_heading_pitch_roll

Array = NDArray[np.float64]

STEP = 0.1
SAMPLES = 300
"""Step of the record on the mount, s, and samples of the one at rest: means are all that counts there."""


@dataclass(frozen=True, kw_only=True)
class Task:
    """What is asked: where, how long, with which law of the mount and which aid.

    Parameters
    ----------
    lat : float
        Latitude, rad.
    law : MountLaw
        Of the mount, where it is rocked.
    duration : float, optional
        s.
    heading : float, optional
        True heading, rad.
    velocity_std : float, optional
        Of the aid's velocity, m/s, once a second.
    """

    lat: float
    law: MountLaw
    duration: float = 300.0
    heading: float = 0.7
    velocity_std: float = 0.001

    @cached_property
    def motion(self) -> Motion:
        """The hull at rest, on the mount."""
        return Vessel(lat=self.lat, heading=self.heading).motion(self.duration, STEP, self.law)

    @property
    def aid(self) -> Aid:
        """Velocity and position."""
        return Aid.satellite(self.lat, velocity=self.velocity_std)

    @property
    def level_rate(self) -> float:
        """Level rotation of the Earth, rad/s: heading error times this is the error of the east gyro."""
        return EARTH_RATE * float(np.cos(self.lat))


@dataclass(frozen=True, kw_only=True)
class Knowledge:
    """What the user of a calibrated unit knows of its errors: standard deviations.

    Parameters
    ----------
    bias : float
        rad/s.
    scale_factor : float
        1.
    """

    bias: float
    scale_factor: float


def at_rest(left: ErrorsLeft, task: Task, random: RandomErrors | None = None, rng=None) -> float:
    """Error of heading from mean readings at rest.

    Parameters
    ----------
    left : ErrorsLeft
        Errors of the compensated readings.
    task : Task
        The law of the mount does not count.
    random : RandomErrors, optional
        Of the gyros; none by default.
    rng : numpy.random.Generator, optional
        Their source.

    Returns
    -------
    float
        Found less true heading, rad; NaN if the readings do not show the rotation of the Earth to a half, so that no
        heading is given.
    """
    import pandas as pd

    C_b_n = dcm_from_heading_pitch_roll(task.heading, 0.0, 0.0)
    dt = task.duration / SAMPLES
    time = dt * (np.arange(SAMPLES) + 0.5)
    rates = left.rates(np.tile(C_b_n.T @ earth_rate_n(task.lat), (SAMPLES, 1)), time - task.duration / 2)
    if random is not None:
        rates = rates + simulate(random, SAMPLES, dt, checks.generator("rng", rng), channels=3)
    forces = np.tile(left.forces(-C_b_n.T @ gravity_n(task.lat)), (SAMPLES, 1))
    index = pd.Index(time - time[0], name="time")
    table = pd.DataFrame(np.hstack([rates, forces]) * dt, index=index, columns=list(IMU_COLUMNS))
    try:
        with warnings.catch_warnings():  # a drift during the measurement is one of the errors in question
            warnings.filterwarnings("ignore", message=".* drift")
            found = gyrocompass_azimuth(table, Compensation(), task.lat, angle_random_walk=0.0)
    except ValueError as error:
        if "must show the Earth's" in str(error):
            return np.nan
        raise
    return float(wrapped(found.heading - task.heading))


def with_errors(clean: Recording, left: ErrorsLeft) -> Recording:
    """A record with what a calibration left: in gyros x, y, z of the mount, and in the accelerometers of the hull."""
    time = clean.dt * (np.arange(len(clean.dtheta)) + 0.5) - clean.duration / 2
    gyros = left.rates(clean.dtheta / clean.dt, time) * clean.dt
    forces = left.forces(clean.dv @ TO_PACKAGE.T / clean.dt) @ TO_PACKAGE * clean.dt
    return replace(clean, dtheta=gyros, dv=forces)


def on_mount(
    left: ErrorsLeft, task: Task, walk: float, known: Knowledge, random: RandomErrors | None = None, rng=None
) -> float:
    """Error of heading at the end of the measurement, by the filter on a rocked mount.

    Parameters
    ----------
    left : ErrorsLeft
        Errors of the compensated readings.
    task : Task
        Its law and aid count.
    walk : float
        Angle random walk that the filter believes in, rad/sqrt(s).
    known : Knowledge
        Of biases and scale factors, for the filter.
    random : RandomErrors, optional
        Of the gyros; by default neither gyros nor aid nor start err by chance.
    rng : numpy.random.Generator, optional
        Their source.

    Returns
    -------
    float
        Found less true heading, rad.
    """
    prior = Prior(
        heading=0.5,
        level=2e-3,
        velocity=0.01,
        position=3.0,
        height=3.0,
        bias=known.bias,
        scale_factor=known.scale_factor,
    )
    noise, motion = Noise(angle_random_walk=walk), task.motion
    if random is None:
        clean = record(motion, Noise(angle_random_walk=0.0), np.random.default_rng(0))
        fixes, start = _exact_fixes(task), _exact_start(motion)
    else:
        clean = record(motion, Noise(angle_random_walk=random.angle_random_walk), checks.generator("rng", rng))
        coloured = replace(random, angle_random_walk=0.0)
        more = simulate(coloured, len(clean.dtheta), clean.dt, rng, channels=3) * clean.dt
        clean = replace(clean, dtheta=clean.dtheta + more)
        fixes, start = take_fixes(motion, task.aid, rng), draw_start(motion, prior, rng)
    with warnings.catch_warnings():  # what the filter has no state for is the question here
        warnings.filterwarnings("ignore", message="the aid departs")
        run = run_wander(
            with_errors(clean, left), fixes, noise, start, prior, heading_known=False, output_interval=10.0
        )
    return float(run.errors(motion)[-1, 0])


def predicted(
    gyro: GyroGrade, task: Task, level_std: float = 0.0, *, rocked: bool, heading_fixed: bool = False
) -> HeadingAccuracy:
    """What the design function says: standard deviation of heading and its budget.

    Parameters
    ----------
    gyro : GyroGrade
        Standard deviations of what is left, and noise.
    task : Task
        The task.
    level_std : float, optional
        Of the tilts, rad.
    rocked : bool
        By the law, or with the mount at rest; at rest the hull is known to keep its heading.
    heading_fixed : bool, optional
        As for `fogkit.gyrocompass.design.heading_accuracy`, with the mount.
    """
    law = task.law if rocked else Fixed()
    fixed = heading_fixed or not rocked
    return heading_accuracy(gyro, law, task.lat, task.duration, level_std=level_std, heading_fixed=fixed)


def _exact_fixes(task: Task) -> Fixes:
    aid, motion = task.aid, task.motion
    time = aid.interval * np.arange(int(motion.time[-1] / aid.interval + 1e-9) + 1)
    rows = np.rint(time / motion.dt).astype(int)
    return Fixes(time=time, values=motion.states[rows, 3:9], aid=aid)


def _exact_start(motion: Motion) -> CompassState:
    state = motion.states[0]
    angles = dict(zip(("heading", "trim", "roll"), state[:3].tolist(), strict=True))
    return CompassState(**angles, velocity=state[3:6], lat=state[6], lon=state[7], alt=state[8])
