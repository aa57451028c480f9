"""Azimuth of a unit at rest, from the Earth's rotation that its calibrated gyros read."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit import checks, earth
from fogkit.calibration.navigation_based.compensation import Compensation
from fogkit.calibration.navigation_based.plausibility import GRAVITY_TOLERANCE, warn_of_drift
from fogkit.constants import EARTH_RATE
from fogkit.imu.tables import ACCEL_COLUMNS, GYRO_COLUMNS
from fogkit.navigation.increments import time_step
from fogkit.results import Record

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

BLOCK = 1.0
"""Duration, s, of the blocks whose scatter gives the standard deviation of a mean rate."""


@dataclass(frozen=True, kw_only=True)
class Azimuth(Record):
    """Azimuth by gyrocompassing.

    Attributes
    ----------
    heading : float
        Angle from north to the level projection of the body axis y, clockwise, rad, in [0, 2 pi).
    standard_deviation : float
        Of the heading, rad, by the noise of the gyros alone: their biases are not in it.
    level_rate, vertical_rate : float
        Mean rate across and along the vertical, rad/s: at rest ``Omega cos(latitude)`` and
        ``Omega sin(latitude)`` of the Earth.
    """

    heading: float
    standard_deviation: float
    level_rate: float
    vertical_rate: float


def gyrocompass_azimuth(
    recording: "DataFrame",
    compensation: Compensation,
    latitude: float,
    *,
    angle_random_walk: float | None = None,
) -> Azimuth:
    """Heading of a unit at rest from mean rates, levelled by mean specific force.

    Parameters
    ----------
    recording : DataFrame
        Raw increments at rest, rad and m/s; table 2 of the paper has 5 min.
    compensation : Compensation
        Calibrated, gyro biases included.
    latitude : float
        Geodetic latitude, rad.
    angle_random_walk : float, optional
        Of the gyros, rad/sqrt(s), for the standard deviation; by default the scatter of the recording says it.

    Returns
    -------
    Azimuth

    Raises
    ------
    ValueError
        If the axis y stands upright, so that it has no heading; near a pole; or if the level rate is not that of the
        Earth to a half: the unit moves, or its gyros are not calibrated; or if the recording is shorter than 8 steps,
        does not feel gravity, or turns about the vertical.

    Warns
    -----
    UserWarning
        If the mean rates in the halves of the recording differ by more than noise.

    Notes
    -----
    The level part of the mean rate points north. An east bias b turns it by ``b / (Omega cos(latitude))``, as does
    noise.
    """
    latitude = float(earth.checked_latitude(latitude, "latitude", earth.POLE_MARGIN))
    fix = "A result of `calibrate` has it as `.compensation`."
    table = checks.instance("compensation", compensation, Compensation, fix=fix).apply(recording)
    _, dt = time_step(recording)
    rates = table[list(GYRO_COLUMNS)].to_numpy() / dt
    force = table[list(ACCEL_COLUMNS)].to_numpy().mean(axis=0) / dt
    _require_rest(rates, force, latitude, dt)
    up, rate = force / np.linalg.norm(force), rates.mean(axis=0)
    if abs(up[1]) > 0.99:
        raise ValueError("`recording` must be of a unit whose axis y does not stand upright: it has no heading else")
    level = rate - (rate @ up) * up
    size, expected = float(np.linalg.norm(level)), EARTH_RATE * np.cos(latitude)
    if not 0.5 < size / expected < 1.5:
        raise ValueError(
            f"`recording` must show the Earth's level rate, {expected:.3g} rad/s, got {size:.3g} rad/s. Is the unit at "
            "rest, and are its gyro biases calibrated?"
        )
    north = level / size
    east = np.cross(north, up)
    if angle_random_walk is None:
        steps = min(max(1, round(BLOCK / dt)), len(rates) // 4)
        count = len(rates) // steps
        blocks = rates[: count * steps].reshape(count, steps, 3).mean(axis=1) @ east
        deviation = blocks.std(ddof=1) / np.sqrt(count)
    else:
        walk = checks.non_negative("angle_random_walk", angle_random_walk, "rad/sqrt(s)")
        deviation = walk / np.sqrt(len(rates) * dt)
    return Azimuth(
        heading=float(np.arctan2(east[1], north[1]) % (2 * np.pi)),
        standard_deviation=float(deviation / size),
        level_rate=size,
        vertical_rate=float(rate @ up),
    )


def _require_rest(rates: Array, force: Array, latitude: float, dt: float) -> None:
    """``ValueError`` if means are not those of a unit that rests on the Earth; a warning if halves of them differ."""
    if len(rates) < 8:
        raise ValueError(f"`recording` must hold at least 8 steps, got {len(rates)}")
    felt, gravity = float(np.linalg.norm(force)), float(earth.normal_gravity(latitude))
    if abs(felt / gravity - 1) > GRAVITY_TOLERANCE:
        raise ValueError(
            f"`recording` must feel gravity, {gravity:.4g} m/s^2, got {felt:.4g} m/s^2. Increments are in m/s."
        )
    vertical, expected = float(rates.mean(axis=0) @ force) / felt, EARTH_RATE * np.sin(latitude)
    if abs(vertical - expected) > 0.5 * EARTH_RATE:
        raise ValueError(
            f"`recording` must show the Earth's rate about the vertical, {expected:.3g} rad/s, got {vertical:.3g} "
            "rad/s. Is the unit at rest, are its gyro biases calibrated, and do accelerometers at rest read upwards?"
        )
    warn_of_drift(rates, dt, "`recording`")
