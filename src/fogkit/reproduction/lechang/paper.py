"""What the thesis states in numbers: gyros, motions, mounts, requirements, tables."""

import numpy as np

from fogkit.units import DEG, DEG_PER_HOUR, DEG_PER_SECOND, DEG_PER_SQRT_HOUR, MINUTE, PERCENT

PYRAMID_ANGLES_DEG = (180.0, 54.7, 45.0)
"""Euler angles of the pyramid of gyros, as printed."""

# ---- choice of the law, chapter 2

HEADING_RATE = 5 * DEG_PER_SECOND
TRIM_AMPLITUDE, TRIM_PERIOD = 10 * DEG, 5.0
ROLL_AMPLITUDE, ROLL_PERIOD = 10 * DEG, 10.0
"""The vessel of the example; the factors 2 pi/5 and 2 pi/10 are restored from the printed 12.6 and 6.3 deg/s."""

GYRO_RANGE = 80 * DEG_PER_SECOND
RATE_LIMIT = GYRO_RANGE / 2
PRINTED_MOUNT_RATE = 0.647
"""rad/s, printed beside 37 deg/s."""
PRINTED_PERIOD = 15.0
LEAST_AMPLITUDE = np.pi / 2

SCALE_FACTOR_LIMIT = 1.1 * PERCENT
SCALE_FACTOR_ERROR = {0.5: 1.5 * PERCENT, 1.0: 3.0 * PERCENT}
"""Largest error of the VG951's scale factor, at fractions of its range: what the thesis quotes of the data sheet."""

# ---- requirements, chapter 3

HEADING_ACCURACY = 0.3 * DEG
LEVEL_ACCURACY = 0.1 * DEG
LARGEST_TILT = 10 * DEG
GYRO_ERROR_LIMIT = 0.3 * DEG_PER_HOUR
REQUIRED_BIAS = 0.2 * DEG_PER_HOUR
REQUIRED_SCALE_FACTOR = 1.1 * PERCENT
REQUIRED_RANDOM_WALK = 3.3e-4 * DEG_PER_SQRT_HOUR

# ---- simulation, chapter 3

HEADING, TRIM = 50 * DEG, 2 * DEG
ROLL_MEAN, ROLL_SWING, ROLL_SWING_PERIOD = 1 * DEG, 5 * DEG, 60.0
MOUNT_AMPLITUDE, MOUNT_PERIOD = np.pi, 96.0
SIMULATED_BIASES = np.array([4.0, -4.0, 6.0]) * DEG_PER_HOUR
SIMULATED_SCALE_FACTORS = np.array([0.5, 0.4, 0.3]) * PERCENT
SIMULATED_RANDOM_WALK = 0.03 * DEG_PER_SQRT_HOUR
SETTLING_TIME = 200.0

# ---- experiments, chapter 4: the VG951 and the stand

DATA_SHEET_BIAS = 0.006 * DEG_PER_SECOND
DATA_SHEET_SCALE = 34e-3 / DEG_PER_SECOND
"""V/(rad/s)."""
DATA_SHEET_NOISE = 0.01e-3
"""V/sqrt(Hz); whether of a one- or a two-sided spectrum is not said."""

STAND_HEADING = 121.5 * DEG
STAND_SCALES = np.array([34.2, 18.3, -38.8]) * 1e-3 / DEG_PER_SECOND
STAND_BIASES = np.array([-0.054, 0.021, -0.050]) * DEG_PER_SECOND
EXPERIMENT_AMPLITUDE, EXPERIMENT_PERIOD = np.pi, 60.0
EXPERIMENT_TIME = 5 * MINUTE
EXPERIMENT_ACCURACY = 0.5 * DEG

ASSUMED_LATITUDE = 59.97 * DEG
"""Latitude of the university in St Petersburg: the thesis states none, neither of the simulation nor of the stand."""


def random_walk_of_the_data_sheet(sides: int) -> float:
    """Angle random walk of the VG951 from its printed noise, rad/sqrt(s), read as one- or as two-sided.

    Examples
    --------
    >>> [round(random_walk_of_the_data_sheet(sides) / DEG_PER_SQRT_HOUR, 4) for sides in (1, 2)]
    [0.0125, 0.0176]
    """
    if sides not in (1, 2):
        raise ValueError(f"`sides` must be 1 or 2, got {sides!r}")
    density = DATA_SHEET_NOISE / DATA_SHEET_SCALE
    return density / float(np.sqrt(2)) if sides == 1 else density
