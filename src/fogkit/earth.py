"""The Earth as WGS 84 has it: shape, normal gravity, rotation.

Frames: e is Earth-centred, Earth-fixed (x to the equator at Greenwich, z to the north pole); n is local east-north-up.
Latitude is geodetic. Everything is in SI units and radians, and broadcasts over leading axes.

References
----------
.. [1] Department of Defense World Geodetic System 1984, NIMA TR8350.2, third edition, amendment 1 (2000).
.. [2] P. D. Groves, Principles of GNSS, inertial, and multisensor integrated navigation systems, 2nd edition (2013).
.. [3] B. R. Bowring, Transformation from spatial to geographical coordinates, Survey Review 23 (1976), 323-327.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.constants import (
    EARTH_RATE,
    ECCENTRICITY_SQUARED,
    EQUATORIAL_GRAVITY,
    FLATTENING,
    GRAVITY_RATIO,
    SECOND_ECCENTRICITY_SQUARED,
    SEMI_MAJOR_AXIS,
    SEMI_MINOR_AXIS,
    SOMIGLIANA,
)

Array = NDArray[np.float64]

#: Distance from a pole, rad (6.4 km), within which east, north and what is derived from them are refused.
POLE_MARGIN = 1e-3
#: Largest height, m, up or down, for the series of `normal_gravity`; it is wrong by up to 1.7e-5 there.
GRAVITY_HEIGHT_LIMIT = 1e5
#: Distance from the centre, m, below which a position is refused: inside 42.8 km (the evolute of the meridian) it has
#: several latitudes, and the iteration slows down before that.
CENTRE_LIMIT = 1e5
# Each iteration of Bowring's formula takes the error from 3e-3 to 2e-6 to 6e-13 rad at 150 km from the centre; near the
# surface the first one is exact in double precision. Four do everywhere down to CENTRE_LIMIT.
_BOWRING_ITERATIONS = 4


def checked_latitude(lat: ArrayLike, name: str = "lat", pole_margin: float = 0.0) -> Array:
    """Latitude as float64, after the check that it is one; for every function that takes a latitude.

    `name` is the argument's name for the message; `pole_margin` is the distance to keep from the poles, rad:
    `POLE_MARGIN` where heading must be defined. ``ValueError`` if a latitude, rad, is outside what is left.
    """
    limit = np.pi / 2 - pole_margin
    fix = "Multiply degrees by `fogkit.units.DEG`."
    if pole_margin > 0:
        fix = f"East and north are not defined at a pole: keep {pole_margin:g} rad away. {fix}"
    return checks.array_in_closed_interval(name, lat, -limit, limit, "rad", fix=fix)


def radius_meridian(lat: ArrayLike) -> Array:
    """Radius of curvature of the meridian: northward distance on the ellipsoid per unit of latitude.

    Parameters
    ----------
    lat : array_like, shape (...,)
        Geodetic latitude, rad.

    Returns
    -------
    ndarray, shape (...,)
        Radius, m; called R_N in [2]_, eq. (2.105), and M in geodesy. 6335439 m at the equator, 6399594 m at a pole.
    """
    lat = checked_latitude(lat)
    return SEMI_MAJOR_AXIS * (1 - ECCENTRICITY_SQUARED) / _w_squared(lat) ** 1.5


def radius_transverse(lat: ArrayLike) -> Array:
    """Radius of curvature across the meridian (prime vertical): eastward distance per unit of eastward tilt.

    Parameters
    ----------
    lat : array_like, shape (...,)
        Geodetic latitude, rad.

    Returns
    -------
    ndarray, shape (...,)
        Radius, m; called R_E in [2]_, eq. (2.106), and N in geodesy. 6378137 m at the equator, 6399594 m at a pole.
    """
    lat = checked_latitude(lat)
    return SEMI_MAJOR_AXIS / np.sqrt(_w_squared(lat))


def normal_gravity(lat: ArrayLike, alt: ArrayLike = 0.0) -> Array:
    """Magnitude of the normal gravity of WGS 84, the centrifugal part included.

    Parameters
    ----------
    lat : array_like, shape (...,)
        Geodetic latitude, rad.
    alt : array_like, shape (...,)
        Height above the ellipsoid, m, within 100 km.

    Returns
    -------
    ndarray, shape (...,)
        Gravity, m/s^2. Real gravity differs by up to about 1e-3 m/s^2 (100 mGal).

    Raises
    ------
    ValueError
        If `lat` or `alt` is out of range.

    Notes
    -----
    On the ellipsoid Somigliana's formula, [1]_, eq. (4-1), which is exact for this field. Above it the Taylor series
    to second order in height, eq. (4-3)::

        gamma_h = gamma * (1 - 2/a * (1 + f + m - 2*f*sin(lat)**2) * alt + 3/a**2 * alt**2)

    Left out are terms of about ``6*f**2*alt/a``, ``6*f*(alt/a)**2`` and ``4*(alt/a)**3``; against the gradient of the
    normal potential this is at most 1.1e-8 of gravity at 1 km, 7.2e-8 at 10 km and 1.7e-5 at 100 km.

    Examples
    --------
    >>> normal_gravity(np.deg2rad([0, 45, 90])).round(6)
    array([9.780325, 9.806198, 9.832185])
    """
    lat = checked_latitude(lat)
    limit = GRAVITY_HEIGHT_LIMIT
    alt = checks.array_in_closed_interval("alt", alt, -limit, limit, "m", fix="The series in height fails beyond.")
    sin2 = np.sin(lat) ** 2
    on_ellipsoid = EQUATORIAL_GRAVITY * (1 + SOMIGLIANA * sin2) / np.sqrt(_w_squared(lat))
    h = alt / SEMI_MAJOR_AXIS
    return on_ellipsoid * (1 - 2 * (1 + FLATTENING + GRAVITY_RATIO - 2 * FLATTENING * sin2) * h + 3 * h**2)


def gravity_n(lat: ArrayLike, alt: ArrayLike = 0.0) -> Array:
    """Normal gravity as a vector ``g_b_n``, east-north-up.

    Parameters
    ----------
    lat, alt : array_like, shape (...,)
        Geodetic latitude, rad, and height above the ellipsoid, m; as for `normal_gravity`.

    Returns
    -------
    ndarray, shape (..., 3)
        ``(0, 0, -normal_gravity)``, m/s^2: down is negative. A body at rest on the Earth has the specific force
        ``-gravity_n``. The southward component, 8e-9 s^-2 * alt * sin(2*lat) by [2]_, eq. (2.140), is left out: the
        plumb line bends by 0.17 arcsec per kilometre of height at 45 degrees.
    """
    g = normal_gravity(lat, alt)
    return np.stack([np.zeros_like(g), np.zeros_like(g), -g], axis=-1)


def earth_rate_n(lat: ArrayLike) -> Array:
    """Rate of the Earth relative to inertial space, ``omega_ie_n``, east-north-up.

    Parameters
    ----------
    lat : array_like, shape (...,)
        Geodetic latitude, rad.

    Returns
    -------
    ndarray, shape (..., 3)
        ``EARTH_RATE * (0, cos(lat), sin(lat))``, rad/s.
    """
    lat = checked_latitude(lat)
    return EARTH_RATE * np.stack([np.zeros_like(lat), np.cos(lat), np.sin(lat)], axis=-1)


def transport_rate_n(lat: ArrayLike, alt: ArrayLike, v_eb_n: ArrayLike) -> Array:
    """Rate of the local east-north-up frame relative to the Earth, ``omega_en_n``, caused by motion over the Earth.

    Parameters
    ----------
    lat : array_like, shape (...,)
        Geodetic latitude, rad.
    alt : array_like, shape (...,)
        Height above the ellipsoid, m.
    v_eb_n : array_like, shape (..., 3)
        Velocity relative to the Earth, east-north-up, m/s.

    Returns
    -------
    ndarray, shape (..., 3)
        Rate, rad/s. The frame stays aligned with north, so the up component grows as ``tan(lat)``.

    Raises
    ------
    ValueError
        If `lat` is within `POLE_MARGIN` of a pole, where the up component has no limit.

    Notes
    -----
    ``(-v_north / (M + alt), v_east / (N + alt), v_east * tan(lat) / (N + alt))`` with the meridian radius M and the
    transverse radius N: [2]_, eq. (5.44), turned from north-east-down to east-north-up.
    """
    lat = checked_latitude(lat, pole_margin=POLE_MARGIN)
    alt = checks.finite_array("alt", alt)
    v_eb_n = checks.finite_array("v_eb_n", v_eb_n, shape=(..., 3))
    east = v_eb_n[..., 0] / (radius_transverse(lat) + alt)
    south = -v_eb_n[..., 1] / (radius_meridian(lat) + alt)
    return np.stack([south, east, east * np.tan(lat)], axis=-1)


def dcm_e_n(lat: ArrayLike, lon: ArrayLike) -> Array:
    """Matrix ``C_e_n`` that takes Earth-fixed components to east-north-up: ``v_n = C_e_n @ v_e``.

    Parameters
    ----------
    lat, lon : array_like, shape (...,)
        Geodetic latitude and longitude, rad. At a pole the longitude still says which way is north.

    Returns
    -------
    ndarray, shape (..., 3, 3)
        ``C_e_n``; its rows are the east, north and up axes in Earth-fixed components.
    """
    lat, lon = np.broadcast_arrays(checked_latitude(lat), checks.finite_array("lon", lon))
    sin_lat, cos_lat, sin_lon, cos_lon = np.sin(lat), np.cos(lat), np.sin(lon), np.cos(lon)
    east = np.stack([-sin_lon, cos_lon, np.zeros_like(lon)], axis=-1)
    north = np.stack([-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat], axis=-1)
    up = np.stack([cos_lat * cos_lon, cos_lat * sin_lon, sin_lat], axis=-1)
    return np.stack([east, north, up], axis=-2)


def ecef_from_geodetic(lat: ArrayLike, lon: ArrayLike, alt: ArrayLike = 0.0) -> Array:
    """Earth-centred, Earth-fixed position ``r_eb_e`` of a geodetic position.

    Parameters
    ----------
    lat, lon : array_like, shape (...,)
        Geodetic latitude and longitude, rad.
    alt : array_like, shape (...,)
        Height above the ellipsoid, m.

    Returns
    -------
    ndarray, shape (..., 3)
        Position, m: [2]_, eq. (2.112).
    """
    lat, lon, alt = np.broadcast_arrays(
        checked_latitude(lat), checks.finite_array("lon", lon), checks.finite_array("alt", alt)
    )
    radius = radius_transverse(lat)
    from_axis = (radius + alt) * np.cos(lat)
    z = (radius * (1 - ECCENTRICITY_SQUARED) + alt) * np.sin(lat)
    return np.stack([from_axis * np.cos(lon), from_axis * np.sin(lon), z], axis=-1)


def geodetic_from_ecef(r_eb_e: ArrayLike) -> tuple[Array, Array, Array]:
    """Geodetic position of an Earth-centred, Earth-fixed one: the inverse of `ecef_from_geodetic`.

    Parameters
    ----------
    r_eb_e : array_like, shape (..., 3)
        Position, m, at least `CENTRE_LIMIT` from the centre of the Earth.

    Returns
    -------
    lat, lon, alt : ndarray, shape (...,)
        Geodetic latitude, longitude in [-pi, pi], rad, and height above the ellipsoid, m. On the axis longitude is 0.

    Raises
    ------
    ValueError
        If a position is nearer to the centre than `CENTRE_LIMIT`, as a position in km is.

    Notes
    -----
    Bowring's formula [3]_ for the latitude, iterated on the reduced latitude ``beta``.
    """
    r_eb_e = checks.finite_array("r_eb_e", r_eb_e, shape=(..., 3))
    nearest = np.linalg.norm(r_eb_e, axis=-1).min()
    if nearest < CENTRE_LIMIT:
        raise ValueError(
            f"`r_eb_e` must be at least {CENTRE_LIMIT:g} m from the centre of the Earth, got {nearest:.6g} m. "
            "Multiply kilometres by `fogkit.units.KILOMETRE`."
        )
    x, y, z = np.moveaxis(r_eb_e, -1, 0)
    from_axis = np.hypot(x, y)
    lat = np.arctan2(z, from_axis * (1 - ECCENTRICITY_SQUARED))  # exact on the ellipsoid
    for _ in range(_BOWRING_ITERATIONS):
        beta = np.arctan2((1 - FLATTENING) * np.sin(lat), np.cos(lat))
        lat = np.arctan2(
            z + SECOND_ECCENTRICITY_SQUARED * SEMI_MINOR_AXIS * np.sin(beta) ** 3,
            from_axis - ECCENTRICITY_SQUARED * SEMI_MAJOR_AXIS * np.cos(beta) ** 3,
        )
    # Regular at the poles and at the equator, unlike from_axis / cos(lat) - N.
    alt = from_axis * np.cos(lat) + z * np.sin(lat) - SEMI_MAJOR_AXIS * np.sqrt(_w_squared(lat))
    return lat, np.arctan2(y, x), alt


def _w_squared(lat: Array) -> Array:
    """1 - e^2 sin^2(lat), the square of W of geodesy."""
    return 1 - ECCENTRICITY_SQUARED * np.sin(lat) ** 2
