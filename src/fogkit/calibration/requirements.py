"""How well must a gyro be calibrated, and how good must the table be? Drift to requirement, and back.

Each pair of functions is one relation read in both directions: ``drift_from_x`` gives the drift that an error causes,
``x_from_drift`` the error that causes a given drift. A drift has the sign of reading less truth. Everything broadcasts.

References
----------
.. [1] D. V. Volynskii, E. V. Dranitsyna, A. A. Odintsov, A. A. Untilov, Calibration of fibre-optic gyros within
   strapdown inertial measurement units (2011), sections on requirements. Row ids ``volynskii-...`` of the ledger.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.constants import EARTH_RATE
from fogkit.earth import POLE_MARGIN, checked_latitude, earth_rate_n
from fogkit.imu.errors import asymmetry as asymmetry

Array = NDArray[np.float64]


def rocking_rate_amplitude(angle: ArrayLike, period: ArrayLike) -> Array:
    """Amplitude of the rate of harmonic rocking.

    Parameters
    ----------
    angle : array_like, shape (...,)
        Amplitude of the angle, rad, zero or above.
    period : array_like, shape (...,)
        Period, s.

    Returns
    -------
    ndarray, shape (...,)
        ``2 pi angle / period``, rad/s.
    """
    return 2 * np.pi * _non_negative("angle", angle, "rad") / _positive("period", period, "s")


def drift_from_asymmetry(asymmetry: ArrayLike, rate_amplitude: ArrayLike) -> Array:
    """Mean drift under harmonic rocking of a gyro whose scale factor depends on the sign of the rate.

    Parameters
    ----------
    asymmetry : array_like, shape (...,)
        Asymmetry as `asymmetry` defines it, of scale factors in reading per rate. Scale factors in rate per reading,
        as the paper has them, give the opposite sign (to first order, which is all that matters here).
    rate_amplitude : array_like, shape (...,)
        Amplitude of the rate, rad/s, above zero.

    Returns
    -------
    ndarray, shape (...,)
        Mean of reading less truth over whole periods, rad/s, the reading being scaled by the mean scale factor.

    Notes
    -----
    Each scale factor is half the asymmetry away from the mean one and the mean of ``|A sin|`` is ``2 A / pi``, so the
    drift is ``asymmetry * A / pi``, without further approximation. Eq. (2) of [1]_ prints twice that.

    Examples
    --------
    >>> from fogkit.units import DEG_PER_HOUR, DEG_PER_SECOND
    >>> round(float(drift_from_asymmetry(1e-6, 30 * DEG_PER_SECOND)) / DEG_PER_HOUR, 4)
    0.0344
    """
    return checks.finite_array("asymmetry", asymmetry) * _positive("rate_amplitude", rate_amplitude, "rad/s") / np.pi


def asymmetry_from_drift(drift: ArrayLike, rate_amplitude: ArrayLike) -> Array:
    """Asymmetry that causes a given mean drift under harmonic rocking: the inverse of `drift_from_asymmetry`.

    Parameters
    ----------
    drift : array_like, shape (...,)
        Mean drift, rad/s.
    rate_amplitude : array_like, shape (...,)
        Amplitude of the rate, rad/s, above zero.

    Returns
    -------
    ndarray, shape (...,)
        Asymmetry, pure number.

    Examples
    --------
    >>> from fogkit.units import DEG_PER_HOUR, DEG_PER_SECOND
    >>> print(f"{asymmetry_from_drift(0.01 * DEG_PER_HOUR, 30 * DEG_PER_SECOND):.2g}")
    2.9e-07
    """
    return np.pi * checks.finite_array("drift", drift) / _positive("rate_amplitude", rate_amplitude, "rad/s")


def drift_from_scale_error(scale_error: ArrayLike, rate: ArrayLike) -> Array:
    """Drift in a steady turn, caused by a relative error of the scale factor; it lasts as long as the turn.

    Parameters
    ----------
    scale_error : array_like, shape (...,)
        Relative error of the scale factor, pure number.
    rate : array_like, shape (...,)
        Rate of the turn along the gyro's axis, rad/s, not zero; its sign counts.

    Returns
    -------
    ndarray, shape (...,)
        ``scale_error * rate``, rad/s: [1]_, text on the scale factor.
    """
    return checks.finite_array("scale_error", scale_error) * _not_zero("rate", rate, "rad/s")


def scale_error_from_drift(drift: ArrayLike, rate: ArrayLike) -> Array:
    """Relative scale factor error that causes a given drift in a steady turn: the inverse of `drift_from_scale_error`.

    Parameters
    ----------
    drift, rate : array_like, shape (...,)
        Drift, and rate of the turn along the gyro's axis, not zero, rad/s.

    Returns
    -------
    ndarray, shape (...,)
        Relative error, pure number.
    """
    return checks.finite_array("drift", drift) / _not_zero("rate", rate, "rad/s")


def drift_from_misalignment(misalignment: ArrayLike, cross_rate: ArrayLike) -> Array:
    """Drift in a steady turn about an axis across the gyro's own, caused by an error of its known direction.

    Parameters
    ----------
    misalignment : array_like, shape (...,)
        Angle by which the input axis leans towards the axis of the turn, rad, within a right angle.
    cross_rate : array_like, shape (...,)
        Rate of the turn, rad/s, not zero; its sign counts.

    Returns
    -------
    ndarray, shape (...,)
        ``sin(misalignment) * cross_rate``, rad/s: [1]_, text on the misalignment angles.

    Examples
    --------
    One arcsecond in a turn at 3 deg/s:

    >>> from fogkit.units import ARCSEC, DEG_PER_HOUR, DEG_PER_SECOND
    >>> round(float(drift_from_misalignment(ARCSEC, 3 * DEG_PER_SECOND)) / DEG_PER_HOUR, 3)
    0.052
    """
    fix = "Multiply arcseconds by `fogkit.units.ARCSEC`."
    right = np.pi / 2
    angle = checks.array_in_closed_interval("misalignment", misalignment, -right, right, "rad", fix=fix)
    return np.sin(angle) * _not_zero("cross_rate", cross_rate, "rad/s")


def misalignment_from_drift(drift: ArrayLike, cross_rate: ArrayLike) -> Array:
    """Misalignment that causes a given drift in a turn about a cross axis: the inverse of `drift_from_misalignment`.

    Parameters
    ----------
    drift, cross_rate : array_like, shape (...,)
        Drift, and rate of the turn, not zero, rad/s; ``|drift| <= |cross_rate|``.

    Returns
    -------
    ndarray, shape (...,)
        Angle, rad.

    Raises
    ------
    ValueError
        If a drift exceeds the rate of the turn: no angle causes that.
    """
    ratio = checks.finite_array("drift", drift) / _not_zero("cross_rate", cross_rate, "rad/s")
    if (np.abs(ratio) > 1).any():
        raise ValueError(f"`drift` must not exceed `cross_rate`, got up to {np.abs(ratio).max():.6g} times that rate")
    return np.arcsin(ratio)


def earth_rate_error(misorientation: ArrayLike, lat: ArrayLike) -> Array:
    """Error of the Earth rate that a misoriented table takes as reference, by axis of the table.

    Parameters
    ----------
    misorientation : array_like, shape (..., 3)
        Small rotation of the table from its nominal attitude, along east-north-up, rad: the first two components are
        the levelling errors (tilt about east, about north), the third the azimuth error (anticlockwise).
    lat : array_like, shape (...,)
        Geodetic latitude, rad.

    Returns
    -------
    ndarray, shape (..., 3)
        Nominal less true Earth rate along the table's axes (nominally east, north, up), rad/s, to first order.

    Notes
    -----
    ``misorientation x omega_ie_n``. The azimuth error alone makes ``EARTH_RATE * cos(lat)`` times itself along east
    ([1]_, text on the table); a tilt about east makes ``EARTH_RATE`` times itself, at any latitude.
    """
    fix = "Multiply arcseconds by `fogkit.units.ARCSEC`."
    psi = checks.finite_array("misorientation", misorientation, shape=(..., 3), fix=fix)
    if np.abs(psi).max() > _SMALL_ANGLE:
        raise ValueError(f"`misorientation` must be within {_SMALL_ANGLE} rad, got {np.abs(psi).max():.6g} rad. {fix}")
    return np.cross(psi, earth_rate_n(lat))


def azimuth_from_rate_error(rate_error: ArrayLike, lat: ArrayLike) -> Array:
    """Azimuth error of the table that makes a given error of the Earth rate: an inverse of `earth_rate_error`.

    Parameters
    ----------
    rate_error : array_like, shape (...,)
        Error of the Earth rate, rad/s.
    lat : array_like, shape (...,)
        Geodetic latitude, rad, at least `fogkit.earth.POLE_MARGIN` from a pole.

    Returns
    -------
    ndarray, shape (...,)
        ``rate_error / (EARTH_RATE * cos(lat))``, rad.

    Examples
    --------
    >>> from fogkit.units import ARCSEC, DEG, DEG_PER_HOUR
    >>> (azimuth_from_rate_error(0.002 * DEG_PER_HOUR, [0, 60 * DEG]) / ARCSEC).round(1)
    array([27.4, 54.9])
    """
    lat = checked_latitude(lat, pole_margin=POLE_MARGIN)
    return checks.finite_array("rate_error", rate_error) / (EARTH_RATE * np.cos(lat))


def levelling_from_rate_error(rate_error: ArrayLike) -> Array:
    """Levelling error of the table, about its worst axis, that makes a given error of the Earth rate.

    Parameters
    ----------
    rate_error : array_like, shape (...,)
        Length of the error of the Earth rate, rad/s.

    Returns
    -------
    ndarray, shape (...,)
        ``rate_error / EARTH_RATE``, rad. The worst tilt is about east, square to the Earth rate at every latitude.
    """
    return checks.finite_array("rate_error", rate_error) / EARTH_RATE


def table_stability_from_drift(drift: ArrayLike, rate: ArrayLike, margin: float = 5.0) -> Array:
    """Relative accuracy that a table's rate must have, if that rate itself is to be the reference.

    Parameters
    ----------
    drift : array_like, shape (...,)
        Unmodelled drift of the gyros, rad/s, zero or above.
    rate : array_like, shape (...,)
        Rate of the table, rad/s, not zero.
    margin : float, optional
        How many times better than the gyros the table shall be; [1]_ asks for 3 to 5.

    Returns
    -------
    ndarray, shape (...,)
        ``drift / (margin * |rate|)``, pure number.
    """
    margin = checks.positive("margin", margin)
    return _non_negative("drift", drift, "rad/s") / (margin * np.abs(_not_zero("rate", rate, "rad/s")))


def drift_from_table_stability(stability: ArrayLike, rate: ArrayLike, margin: float = 5.0) -> Array:
    """Drift of the best gyros that a table's rate can serve as reference for: inverts `table_stability_from_drift`.

    Parameters
    ----------
    stability : array_like, shape (...,)
        Relative accuracy of the table's rate, zero or above.
    rate : array_like, shape (...,)
        Rate of the table, rad/s, not zero.
    margin : float, optional
        How many times better than the gyros the table shall be; 1 gives the error of the table's rate itself.

    Returns
    -------
    ndarray, shape (...,)
        Drift, rad/s.
    """
    margin = checks.positive("margin", margin)
    return _non_negative("stability", stability) * margin * np.abs(_not_zero("rate", rate, "rad/s"))


def scale_error_from_readout(readout: ArrayLike, angle: ArrayLike) -> Array:
    """Standard deviation of a scale factor, relative, caused by the two angle readings that it is referred to.

    Parameters
    ----------
    readout : array_like, shape (...,)
        Standard deviation of one angle reading, rad, zero or above; first and last reading are independent.
    angle : array_like, shape (...,)
        Angle turned between the readings, rad, not zero: 2 pi times the turns.

    Returns
    -------
    ndarray, shape (...,)
        ``sqrt(2) * readout / |angle|``, pure number: [1]_, first term of eq. (21).
    """
    return np.sqrt(2) * _non_negative("readout", readout, "rad") / np.abs(_not_zero("angle", angle, "rad"))


def readout_from_scale_error(scale_error: ArrayLike, angle: ArrayLike) -> Array:
    """Standard deviation of an angle reading that a scale factor allows: the inverse of `scale_error_from_readout`.

    Parameters
    ----------
    scale_error : array_like, shape (...,)
        Standard deviation of the scale factor, relative, zero or above.
    angle : array_like, shape (...,)
        Angle turned between the readings, rad, not zero.

    Returns
    -------
    ndarray, shape (...,)
        Standard deviation of one angle reading, rad.
    """
    return _non_negative("scale_error", scale_error) * np.abs(_not_zero("angle", angle, "rad")) / np.sqrt(2)


def angle_from_scale_error(scale_error: ArrayLike, readout: ArrayLike) -> Array:
    """Angle that must be turned for a scale factor: `scale_error_from_readout` solved for the angle.

    Parameters
    ----------
    scale_error : array_like, shape (...,)
        Standard deviation of the scale factor, relative, above zero.
    readout : array_like, shape (...,)
        Standard deviation of one angle reading, rad, zero or above.

    Returns
    -------
    ndarray, shape (...,)
        Angle, rad; over 2 pi and rounded up it is the number of whole turns.
    """
    return np.sqrt(2) * _non_negative("readout", readout, "rad") / _positive("scale_error", scale_error)


_SMALL_ANGLE = 0.1  # rad; beyond it the first-order error of the Earth rate is itself wrong by 5 %


def _positive(name: str, value: ArrayLike, unit: str = "") -> Array:
    return _all(name, value, "> 0", np.greater, unit)


def _non_negative(name: str, value: ArrayLike, unit: str = "") -> Array:
    return _all(name, value, ">= 0", np.greater_equal, unit)


def _not_zero(name: str, value: ArrayLike, unit: str = "") -> Array:
    return _all(name, value, "other than 0", np.not_equal, unit)


def _all(name: str, value: ArrayLike, needed: str, relation: np.ufunc, unit: str) -> Array:
    """Finite array whose every entry has a relation to zero."""
    array = checks.finite_array(name, value)
    if not (allowed := relation(array, 0)).all():
        raise ValueError(f"`{name}` must be {needed} {unit}".rstrip() + f", got {array[~allowed].flat[0]}")
    return array
