"""What the thesis says of the errors that a heading accuracy allows, put to numbers: (17), tables 2 and 3."""

import numpy as np

from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass.accuracy import accelerometer_share
from fogkit.gyrocompass.frames import hull_attitude, pyramid_axes
from fogkit.gyrocompass.mechanisation import geographic_rate
from fogkit.reproduction.lechang import derivation, paper, requirements
from fogkit.units import DEG, DEG_PER_HOUR

LATITUDES = np.arange(0.0, 86.0, 5.0) * DEG


def level_rates_give_heading() -> bool:
    """Whether ``tan K = -omega_EK/omega_NK`` of the Earth rate in level axes turned by heading, at random headings."""
    heading = np.random.default_rng(17).uniform(-3, 3, 20)
    ahead, _, starboard = (hull_attitude(heading, 0.0, 0.0).swapaxes(-1, -2) @ geographic_rate(1.0, np.zeros(3))).T
    return bool(np.allclose(np.tan(heading), -starboard / ahead, rtol=1e-12))


def headings_of_eq17() -> bool:
    """Whether (17) fails towards east and west, and multiplied out gives heading there.

    Both sides of (17) are over ``cos(heading)**2``: at 89.9 degrees the coefficient of gyro y is beyond 10^5 times one
    over the level Earth rate. Multiplied out it is minus the east part of the errors over the level Earth rate, tried
    against differences of the arc tangent at the same heading and at random attitudes.
    """
    lat, near_east = paper.ASSUMED_LATITUDE, (89.9 * DEG, 0.05, -0.1)
    level = EARTH_RATE * np.cos(lat)
    at = {"theta": near_east[1], "gamma": near_east[2]}
    at |= {"omega_NK": level * np.cos(near_east[0]), "omega_EK": -level * np.sin(near_east[0])}
    term = derivation.equations()["eq17-gyro-y"].printed
    coefficient = abs(float(term.subs({symbol: at[str(symbol)] for symbol in term.free_symbols})))

    def right(heading: float, trim: float, roll: float) -> bool:
        east = (hull_attitude(heading, trim, roll) @ pyramid_axes())[2]
        numbers = requirements.heading_sensitivity(heading, trim, roll, lat)[:3]
        return bool(np.allclose(numbers, -east / level, rtol=1e-6, atol=1e-3))

    attitudes = np.random.default_rng(17).uniform([-3, -0.17, -0.17], [3, 0.17, 0.17], (20, 3))
    return coefficient > 1e5 / level and right(*near_east) and all(right(*a) for a in attitudes)


def gyro_error_allowed(lat: float = 0.0) -> float:
    """Total error of the gyros towards east, deg/h, that gives the heading accuracy of table 2; most at the equator."""
    return requirements.gyro_error_for(paper.HEADING_ACCURACY, lat) / DEG_PER_HOUR


def tilts_leave_room() -> bool:
    """Whether tilts of table 2 alone keep heading within table 2 up to a latitude of ``arctan 3``, and not beyond."""
    accuracy, tilt = paper.HEADING_ACCURACY, paper.LEVEL_ACCURACY
    edge = np.arctan(accuracy / tilt)
    share = np.array([accelerometer_share(lat, tilt) for lat in LATITUDES])
    return bool(np.array_equal(share < accuracy, LATITUDES < edge) and abs(edge - np.arctan(3)) < 1e-12)


def sensors_follow_from_heading() -> bool:
    """Whether the total error asked of the gyros gives the heading of table 2, at any latitude."""
    return any(requirements.heading_error(paper.GYRO_ERROR_LIMIT, lat) <= paper.HEADING_ACCURACY for lat in LATITUDES)


def alone(term: str, lat: float = paper.ASSUMED_LATITUDE, time: float = paper.EXPERIMENT_TIME) -> float:
    """What one of `requirements.terms_of_table_3` may be if it alone makes the heading of table 2.

    Parameters
    ----------
    term : {"bias", "scale factor", "noise"}
        Which.
    lat : float, optional
        Latitude, rad.
    time : float, optional
        Time over which noise is averaged, s.

    Returns
    -------
    float
        As a multiple of the cell of table 3.
    """
    return requirements.gyro_error_for(paper.HEADING_ACCURACY, lat) / requirements.terms_of_table_3(lat, time)[term]
