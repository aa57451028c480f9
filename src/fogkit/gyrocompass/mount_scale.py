"""Scale factors from the turns of the mount itself: at rest its angle sensor says what the gyros had to read.

A scale factor error of 1 % makes a filter that is linear in errors wrong: rocked by 180 degrees it turns the computed
attitude by 1.8 degrees. The mount's angle tells the scale factor to a few millionths in a minute, before any filter.
"""

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.estimation import leastsquares
from fogkit.gyrocompass.filters.records import Recording

Array = NDArray[np.float64]

SMALLEST_TURN = 1.0
"""Least range of the mount's angle, rad: over less the Earth rate looks like a bias and a scale factor."""


def scale_from_mount(recording: Recording, angle_random_walk: float | None = None) -> tuple[Array, Array]:
    """Scale factor errors of the gyros of a unit at rest, from the angle of its mount.

    Parameters
    ----------
    recording : Recording
        Increments and angles of a hull that does not turn.
    angle_random_walk : float, optional
        Of each gyro, rad/sqrt(s); taken from the residuals if not given.

    Returns
    -------
    error, std : ndarray, shape (3,)
        Scale factor errors, and their standard deviations. Errors of the angle sensor that grow with the angle are
        not in them, nor is an error of the gyros' directions, which looks the same.

    Raises
    ------
    ValueError
        If the mount turns by less than `SMALLEST_TURN`, or an input axis lies across its axis.

    Notes
    -----
    Least squares of each gyro's increments with the increments of the angle, a bias, and the level Earth rate in the
    mount, cosine and sine of the angle, as unknowns.
    """
    angle = checks.instance("recording", recording, Recording).mount_angle
    if np.ptp(angle) < SMALLEST_TURN:
        raise ValueError(f"`recording` must have a mount that turns by {SMALLEST_TURN:g} rad, got {np.ptp(angle):.3g}")
    along = recording.axes[1]
    if np.abs(along).min() < 1e-3:
        raise ValueError(
            f"`recording.axes` must have no gyro across the axis of the mount, got one with {np.abs(along).min():.2g} "
            "of it: the mount says nothing of its scale factor"
        )
    turn, middle, dt = np.diff(angle), (angle[1:] + angle[:-1]) / 2, recording.dt
    design = np.column_stack([turn, np.full_like(turn, dt), np.cos(middle) * dt, np.sin(middle) * dt])
    std = None
    if angle_random_walk is not None:
        std = checks.positive("angle_random_walk", angle_random_walk, "rad/sqrt(s)") * np.sqrt(dt)
    fits = [
        leastsquares.linear(
            design, increments, standard_deviation=std, names=["scale", "bias", "earth_cosine", "earth_sine"]
        )
        for increments in recording.dtheta.T
    ]
    for fit in fits:
        fit.raise_if_unobservable("the turning of the mount")
    slopes = np.array([[fit["scale"], fit.standard_deviation[0]] for fit in fits]).T
    return slopes[0] / along - 1, slopes[1] / np.abs(along)
