"""What a law of the mount asks of the range of the gyros, together with the motion of the hull."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.gyrocompass.frames import pyramid_axes
from fogkit.gyrocompass.laws import MountLaw
from fogkit.units import DEG_PER_SECOND

Array = NDArray[np.float64]


def gyro_peaks(law: MountLaw, hull_rates: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Largest rates that the gyros of the pyramid can see of mount and hull together.

    Parameters
    ----------
    law : MountLaw
        Law of the mount.
    hull_rates : array_like, shape (3,), optional
        Largest rates of the hull about its forward, up and starboard axes, either way, rad/s.

    Returns
    -------
    ndarray, shape (3,)
        Rad/s, when all peaks come at once and at the worst angle of the mount. The largest rates about forward and
        starboard are taken at once too; of a mount's rate a gyro sees ``1/sqrt(3)``.
    """
    checks.instance("law", law, MountLaw)
    forward, up, starboard = np.abs(checks.finite_array("hull_rates", hull_rates, shape=(3,)))
    axes = pyramid_axes()
    level = np.hypot(axes[0], axes[2])
    return np.abs(axes[1]) * (law.max_rate + up) + level * np.hypot(forward, starboard)


def check_gyro_range(law: MountLaw, gyro_range: float, hull_rates: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """The rates of `gyro_peaks`, after the check that none is beyond the range of the gyros.

    Parameters
    ----------
    law : MountLaw
        Law of the mount.
    gyro_range : float
        Largest rate that a gyro can read, rad/s.
    hull_rates : array_like, shape (3,), optional
        As for `gyro_peaks`, rad/s.

    Returns
    -------
    ndarray, shape (3,)
        Rad/s.

    Raises
    ------
    ValueError
        If a gyro would have to read more; the message names it and the law.
    """
    gyro_range = checks.positive("gyro_range", gyro_range, "rad/s")
    peaks = gyro_peaks(law, hull_rates)
    worst = int(np.argmax(peaks))
    # all three see the mount alike: equal peaks but for rounding must not exceed a range that is theirs
    if peaks[worst] > gyro_range * (1 + 1e-12):
        raise ValueError(
            f"`law` must keep gyro {'xyz'[worst]} within `gyro_range`, {gyro_range / DEG_PER_SECOND:.4g} deg/s, got up "
            f"to {peaks[worst] / DEG_PER_SECOND:.4g} deg/s with {law!r}. Take a longer period or a smaller amplitude."
        )
    return peaks
