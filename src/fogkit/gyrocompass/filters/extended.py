"""The thesis's filter: an indirect Kalman filter of 15 errors with feedback, about the computed state.

Its model is linear in an error of heading. Where heading is wrong by 10 degrees and more that is not so: the Earth's
rate ahead changes by ``1 - cos`` of the error, which the filter takes for a gyro bias, and says that it is sure of it.
`fogkit.gyrocompass.filters.wander` has a state that makes the model linear again.

References
----------
.. [1] Le Van Chang, Gyrocompass with a quasi-harmonic autocompensating mount (in Russian), thesis abstract, LETI,
   St Petersburg, 2015, chapter 2, equations (3) to (12).
"""

import numpy as np
from numpy.typing import ArrayLike

from fogkit import checks
from fogkit.gyrocompass.covariance import Noise, Prior, checked_covariance, multiple
from fogkit.gyrocompass.filters import _extended_kernels
from fogkit.gyrocompass.filters.records import Fixes, Recording
from fogkit.gyrocompass.filters.runs import (
    MARGINS,
    FilterRun,
    arguments,
    fix_steps,
    raise_failure,
    warn_of_innovations,
)
from fogkit.gyrocompass.frames import hull_attitude
from fogkit.gyrocompass.mechanisation import EARTH_RADIUS, CompassState


def run_extended(
    recording: Recording,
    fixes: Fixes,
    noise: Noise,
    start: CompassState,
    prior: Prior | ArrayLike | None = None,
    *,
    output_interval: float = 1.0,
) -> FilterRun:
    """Heading and the rest from a record and an aid, by the filter of [1]_.

    Parameters
    ----------
    recording : Recording
        Increments and angles of the mount.
    fixes : Fixes
        What the aid measured.
    noise : Noise
        What the filter is to think of the sensors.
    start : CompassState
        State at the start.
    prior : Prior or array_like, shape (15, 15), optional
        Standard deviations, or covariance, of its errors, of the biases and scale factors.
    output_interval : float, optional
        Time between rows of the result, s.

    Returns
    -------
    FilterRun
        Estimates and covariances. They are believable while the standard deviation of heading is a few degrees.

    Raises
    ------
    ValueError
        If a time is no multiple of the step, there is no aid, trim comes near the vertical or latitude near a pole, or
        the covariance is or becomes none.

    Warns
    -----
    UserWarning
        If the aid is lost for a time, if innovations are larger than they may be, or if heading is known too badly.

    Notes
    -----
    Covariance and mechanisation are predicted in every step, the transition to second order; measurements are taken one
    component after the other in Joseph's form, and fed back at once.
    """
    steps = fix_steps(recording, fixes)
    keep = multiple("output_interval", checks.positive("output_interval", output_interval, "s"), recording.dt)
    prior = Prior() if prior is None else prior
    lat = checks.instance("start", start, CompassState).lat
    P = prior.covariance(lat) if isinstance(prior, Prior) else checked_covariance("prior", prior)
    rows = len(recording.dtheta) // keep + 1
    states, covariances, nis = np.empty((rows, 15)), np.empty((rows, 15, 15)), np.zeros(len(steps))
    C = hull_attitude(start.heading, start.trim, start.roll)
    s = np.array([*start.velocity, lat, start.lon, start.alt, *np.zeros(6)])
    dt, *densities = arguments(recording, noise, 15, 9)
    failure, step = _extended_kernels.extended_run(
        *(P, C, s, recording.dtheta, recording.dv, recording.mount_angle, recording.axes),
        *(EARTH_RADIUS, recording.gravity, dt, *densities),
        *(steps, fixes.values, fixes.variances, MARGINS, keep, states, covariances, nis),
    )
    raise_failure(failure, step, dt)
    counts = np.isfinite(fixes.values).sum(axis=1)
    warn_of_innovations(nis, counts)
    return FilterRun(
        time=dt * keep * np.arange(rows),
        estimate=states,
        covariance=covariances,
        fix_time=fixes.time,
        nis=nis,
        fix_count=counts,
    )
