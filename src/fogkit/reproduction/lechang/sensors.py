"""Tables 2 and 3 by the design function: what the required gyros give with the mount off and on, and what would do."""

from dataclasses import replace
from typing import TYPE_CHECKING

from fogkit.gyrocompass.design import HeadingAccuracy, heading_accuracy
from fogkit.gyrocompass.design_inputs import GyroGrade
from fogkit.gyrocompass.design_needs import time_for, walk_for
from fogkit.gyrocompass.laws import Fixed, MountLaw, QuasiHarmonic
from fogkit.reproduction.lechang import paper
from fogkit.units import DEG, DEG_PER_HOUR, DEG_PER_SQRT_HOUR, MINUTE

if TYPE_CHECKING:
    from pandas import DataFrame

REQUIRED = GyroGrade(
    angle_random_walk=paper.REQUIRED_RANDOM_WALK,
    bias=paper.REQUIRED_BIAS,
    scale_factor=paper.REQUIRED_SCALE_FACTOR,
    largest_rate=paper.GYRO_RANGE,
)
"""The gyro of table 3; its bias is read as a standard deviation."""

EXPERIMENT = QuasiHarmonic(amplitude=paper.EXPERIMENT_AMPLITUDE, period=paper.EXPERIMENT_PERIOD)
LATITUDES = (0.0, 45 * DEG, 60 * DEG, 75 * DEG)


def reached(lat: float, mount_on: bool, duration: float = 5 * MINUTE, level_std: float = 0.0) -> HeadingAccuracy:
    """Heading of the gyro of table 3, with the mount at rest or with the law of the experiment.

    Parameters
    ----------
    lat : float
        rad.
    mount_on : bool
        Whether the mount rocks; with the mount off the hull is taken not to turn, which is to the advantage of that.
    duration : float, optional
        s; the thesis states no time.
    level_std : float, optional
        Of the tilts, rad; table 2 allows `paper.LEVEL_ACCURACY`.
    """
    law: MountLaw = EXPERIMENT if mount_on else Fixed()
    return heading_accuracy(REQUIRED, law, lat, duration, level_std=level_std, heading_fixed=not mount_on)


def bias_for(lat: float, accuracy: float = paper.HEADING_ACCURACY) -> float:
    """Bias, rad/s, that gives a heading accuracy with the mount off and no other error."""
    unit = 1e-3 * DEG_PER_HOUR
    found = heading_accuracy(replace(REQUIRED, bias=unit), Fixed(), lat, 5 * MINUTE, heading_fixed=True)
    return accuracy / found.budget["bias"] * unit


def walk_with_mount(lat: float, duration: float = 5 * MINUTE, level_std: float = 0.0) -> float:
    """Angle random walk, rad/sqrt(s), that gives the heading of table 2 with the mount on and the bias of table 3."""
    return walk_for(paper.HEADING_ACCURACY, REQUIRED, EXPERIMENT, lat, duration, level_std=level_std)


def time_with_mount(lat: float, level_std: float = 0.0) -> float:
    """Time, s, in whole periods, after which the gyro of table 3 gives the heading of table 2, with the mount on."""
    return time_for(paper.HEADING_ACCURACY, REQUIRED, EXPERIMENT, lat, level_std=level_std)


def to_frame() -> "DataFrame":
    """Gyro of table 3 over latitude, in data-sheet units.

    Returns
    -------
    DataFrame
        Index ``lat_deg``; heading in degrees with the mount off, on, and on with the tilts of table 2; the bias, deg/h,
        that table 2 asks for with the mount off; and the angle random walk, deg/sqrt(h), that it asks for with the
        mount on in five minutes, tilts known.
    """
    import pandas as pd

    rows = [
        {
            "lat_deg": round(lat / DEG, 9),
            "off_deg": reached(lat, mount_on=False).std / DEG,
            "on_deg": reached(lat, mount_on=True).std / DEG,
            "on_tilted_deg": reached(lat, mount_on=True, level_std=paper.LEVEL_ACCURACY).std / DEG,
            "bias_off_dph": bias_for(lat) / DEG_PER_HOUR,
            "walk_on_deg_sqrt_h": walk_with_mount(lat) / DEG_PER_SQRT_HOUR,
        }
        for lat in LATITUDES
    ]
    return pd.DataFrame(rows).set_index("lat_deg")
