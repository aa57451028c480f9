"""From a gyro's error to heading with the mount switched off: what (17) says in numbers, and tables 2 and 3 against it.

With the mount off a constant error of the gyros of ``d`` in the direction of east turns heading by
``d / (omega_ie cos(lat))``, whatever heading, trim and roll are. Errors of the tilts come on top, by ``tan(lat)``.
"""

import numpy as np

from fogkit.constants import EARTH_RATE
from fogkit.earth import POLE_MARGIN, checked_latitude
from fogkit.gyrocompass.frames import hull_attitude, mount_attitude, pyramid_axes
from fogkit.gyrocompass.mechanisation import geographic_rate, gyro_rates
from fogkit.reproduction.lechang import paper


def heading_sensitivity(heading: float, trim: float, roll: float, lat: float) -> np.ndarray:
    """Change of heading per error of the three gyros, then of trim and of roll, with the mount off: (17), by numbers.

    Parameters
    ----------
    heading, trim, roll : float
        Attitude of the hull, rad.
    lat : float
        Latitude, rad.

    Returns
    -------
    ndarray, shape (5,)
        s for the gyros, 1 for the angles; by central differences of ``tan K = -omega_EK/omega_NK``.
    """
    C_h_g = hull_attitude(heading, trim, roll)
    rates = gyro_rates(C_h_g.T @ geographic_rate(lat, np.zeros(3)), 0.0, 0.0)

    def computed(x):
        turned = hull_attitude(0.0, trim + x[3], roll + x[4])  # into the axes turned by heading
        level = turned @ mount_attitude(0.0) @ pyramid_axes() @ (rates + x[:3])
        return np.arctan2(-level[2], level[0])

    steps = np.array([*[1e-5 * EARTH_RATE] * 3, 1e-5, 1e-5])
    change = [computed(h * e) - computed(-h * e) for h, e in zip(steps, np.eye(5), strict=True)]
    return ((np.array(change) + np.pi) % (2 * np.pi) - np.pi) / (2 * steps)


def heading_error(gyro_error: float, lat: float) -> float:
    """Heading error, rad, of a total gyro error towards east, rad/s: without the approximation of small angles.

    ``ValueError`` if the error is as large as the level Earth rate: the Earth can then not be found at all.
    """
    lat = float(checked_latitude(lat, pole_margin=POLE_MARGIN))
    ratio = abs(gyro_error) / (EARTH_RATE * np.cos(lat))
    if not ratio < 1:
        raise ValueError(f"`gyro_error` must be below the level Earth rate, got {ratio:.3g} of it")
    return float(np.arctan(ratio))


def gyro_error_for(heading_accuracy: float, lat: float) -> float:
    """Total gyro error towards east, rad/s, that gives a heading error, rad, at a latitude, rad."""
    lat = float(checked_latitude(lat, pole_margin=POLE_MARGIN))
    return float(EARTH_RATE * np.cos(lat) * np.tan(heading_accuracy))


def terms_of_table_3(lat: float, time: float) -> dict[str, float]:
    """Parts of the gyro error that table 3 allows, rad/s: bias, scale factor on the Earth's rate, noise averaged."""
    seen = EARTH_RATE * 3**-0.5 * (np.abs(np.sin(lat)) + np.sqrt(2) * np.cos(lat))  # most that a gyro sees at rest
    return {
        "bias": paper.REQUIRED_BIAS,
        "scale factor": float(paper.REQUIRED_SCALE_FACTOR * seen),
        "noise": float(paper.REQUIRED_RANDOM_WALK / np.sqrt(time)),
    }
