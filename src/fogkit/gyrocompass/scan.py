"""North from a scan of the Earth's rate at rest: a gyro with a level axis, or three that are tilted round one.

Turning a gyro about a level axis takes its input axis through the plane across that axis, and its reading through a
sine. The mean of it holds the bias beside the Earth rate along the axis, ``cos(heading)``, and cannot be told from it;
amplitude and phase hold the up component and ``sin(heading)``. So the headings ``K`` and ``pi - K`` of the axis give
the same readings with other biases: a scan about one level axis leaves both, unless biases are known
(`ScanFit.log_odds`). `fogkit.gyrocompass.dwells` makes the readings of a scan from a raw record.

References
----------
.. [1] Le Van Chang, Gyrocompass with a quasi-harmonic autocompensating mount (in Russian), thesis abstract, LETI,
   St Petersburg, 2015, chapters 1 and 4.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.constants import EARTH_RATE
from fogkit.earth import POLE_MARGIN, checked_latitude
from fogkit.estimation import leastsquares
from fogkit.estimation.leastsquares import Scale
from fogkit.estimation.solution import Solution
from fogkit.gyrocompass.frames import hull_attitude, pyramid_axes

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]


def level_reading(azimuth: ArrayLike, lat: float, offset: float = 0.0, scale: float = 1.0) -> Array:
    """Reading of a gyro with a level input axis: (1) of [1]_.

    Parameters
    ----------
    azimuth : array_like, shape (...,)
        Angle of the input axis from north, clockwise, rad.
    lat : float
        Latitude, rad.
    offset : float, optional
        Reading without rate, in units of the reading (a laser gyro's split of frequencies, Hz).
    scale : float, optional
        Reading per rate, per rad/s.

    Returns
    -------
    ndarray, shape (...,)
        ``offset + scale * omega_ie * cos(lat) * cos(azimuth)``.
    """
    level = EARTH_RATE * np.cos(_latitude(lat))
    return offset + scale * level * np.cos(checks.finite_array("azimuth", azimuth))


def azimuths(reading: float, lat: float, offset: float = 0.0, scale: float = 1.0) -> tuple[float, float]:
    """Both azimuths that a reading of a level gyro stands for: (2) of [1]_, which gives the first.

    Parameters
    ----------
    reading : float
        Reading, in its units.
    lat, offset, scale : float
        As for `level_reading`; the scale is not 0.

    Returns
    -------
    tuple of float
        Azimuths, rad, the same angle east and west of north.

    Raises
    ------
    ValueError
        If the reading is beyond what the level Earth rate can give: offset or scale are wrong, or noise is large.

    Examples
    --------
    >>> reading = level_reading(np.deg2rad(250), np.deg2rad(60))
    >>> np.rad2deg(azimuths(float(reading), np.deg2rad(60))).round(6) + 0.0
    array([ 110., -110.])
    """
    level = EARTH_RATE * np.cos(_latitude(lat))
    if checks.finite("scale", scale) == 0:
        raise ValueError("`scale` must not be 0: the reading then says nothing of the rate, got 0")
    cosine = (checks.finite("reading", reading) - checks.finite("offset", offset)) / (scale * level)
    if abs(cosine) > 1:
        raise ValueError(
            f"`reading` must be within the level Earth rate of `offset`, got {cosine:.4g} times that. Are `offset` and "
            "`scale` those of the gyro?"
        )
    east = float(np.arccos(cosine))
    return east, -east


@dataclass(frozen=True, kw_only=True)
class ScanFit:
    """What a scan about a level axis says.

    Attributes
    ----------
    headings : ndarray, shape (2,)
        Both headings of the axis that the readings allow, rad: the one ahead of east or west, the one behind.
    heading_std : float
        Standard deviation of either, rad, by first order; infinite at east and west, where the sine turns.
    scales : ndarray, shape (3,)
        Readings per rate, per rad/s, with their signs.
    scale_std : ndarray, shape (3,)
        Their standard deviations.
    biases : ndarray, shape (2, 3)
        Biases of the gyros that go with each heading, rad/s.
    solution : Solution
        Least squares: means, scales, level rate across the axis, and drifts if they were asked for.
    """

    headings: Array
    heading_std: float
    scales: Array
    scale_std: Array
    biases: Array
    solution: Solution

    def log_odds(self, bias_std: float) -> float:
        """Natural logarithm of the odds of the first heading against the second, if biases are known beforehand.

        Parameters
        ----------
        bias_std : float
            Standard deviation of each gyro's bias about zero, rad/s, large beside that of the means of the scan.

        Returns
        -------
        float
            Half the difference of the sums of squared biases in units of it. Below 2 or so either heading may be right.
        """
        bias_std = checks.positive("bias_std", bias_std, "rad/s")
        squares = (self.biases**2).sum(axis=1)
        return float(squares[1] - squares[0]) / (2 * bias_std**2)

    def to_frame(self) -> "DataFrame":
        """Table of scales (readings per rad/s) and biases (rad/s) of the gyros with both headings, index ``gyro``."""
        import pandas as pd

        columns = {
            "scale": self.scales,
            "scale_std": self.scale_std,
            "bias_first": self.biases[0],
            "bias_second": self.biases[1],
        }
        return pd.DataFrame(columns, index=pd.Index(["x", "y", "z"], name="gyro"))


def scan_readings(
    angles: ArrayLike,
    heading: float,
    lat: float,
    scales: ArrayLike = (1.0, 1.0, 1.0),
    biases: ArrayLike = (0.0, 0.0, 0.0),
    axes: ArrayLike | None = None,
) -> Array:
    """Readings of three gyros at rest, turned about a level axis: the first experiment of [1]_.

    Parameters
    ----------
    angles : array_like, shape (n,)
        Angles about the axis, rad, as roll: right-handed about the direction that has the heading.
    heading : float
        Heading of the axis, rad.
    lat : float
        Latitude, rad.
    scales, biases : array_like, shape (3,), optional
        Readings per rate, per rad/s; biases, rad/s.
    axes : array_like, shape (3, 3), optional
        Input axes in columns, forward (along the axis), up, starboard at angle 0; the pyramid's if not given.

    Returns
    -------
    ndarray, shape (n, 3)
        ``scale * (rate + bias)``, in units of the reading.
    """
    lat = _latitude(lat)
    earth = EARTH_RATE * np.array([np.cos(lat), np.sin(lat), 0.0])
    level = hull_attitude(checks.finite("heading", heading, "rad"), 0.0, 0.0).T @ earth
    along, across = _projections(angles, axes)
    rates = level[0] * along + across @ level[1:]
    scales, biases = (checks.finite_array(n, v, shape=(3,)) for n, v in (("scales", scales), ("biases", biases)))
    return scales * (rates + biases)


def fit_scan(
    angles: ArrayLike,
    readings: ArrayLike,
    lat: float,
    *,
    axes: ArrayLike | None = None,
    time: ArrayLike | None = None,
    drift: int = 1,
    standard_deviation: ArrayLike | None = None,
    scale: Scale | None = None,
) -> ScanFit:
    """Heading of the axis, scale factors and biases from a scan, by least squares.

    Parameters
    ----------
    angles : array_like, shape (n,)
        Angles about the axis, rad, of each position; three different ones at least.
    readings : array_like, shape (n, 3)
        Mean readings of the gyros, in volts or any unit.
    lat : float
        Latitude, rad, not at the equator: the up component is what scales are known by.
    axes : array_like, shape (3, 3), optional
        As for `scan_readings`.
    time : array_like, shape (n,), optional
        Times of the readings, s; the mean of each gyro then drifts as a polynomial of it. Without it biases are
        constant.
    drift : int, optional
        Degree of that polynomial: 1 for a drift in proportion to time, 0 for none.
    standard_deviation : array_like, shape (), (n,) or (n, 3), optional
        Of the readings; equal, and taken from the residuals, if not given.
    scale : {"given", "estimated"}, optional
        Whether `standard_deviation` is believed, the default if it is given, or only its ratios are: weights w are
        ``1/sqrt(w)`` with ``"estimated"``.

    Returns
    -------
    ScanFit
        Both headings, scales, biases (the means over the readings, where there is a drift), and the solution.

    Raises
    ------
    ValueError
        If a shape does not fit, a standard deviation is not positive, the positions do not determine the parameters,
        or the rate across the axis comes out larger than the Earth's.
    """
    angles = checks.finite_array("angles", angles, shape=(None,))
    readings = checks.finite_array("readings", readings, shape=(len(angles), 3))
    lat = _latitude(lat)
    up, level = EARTH_RATE * np.sin(lat), EARTH_RATE * np.cos(lat)
    if abs(lat) < POLE_MARGIN:
        raise ValueError(f"`lat` must not be at the equator, where scales are unknown, got {lat:g} rad")
    along, across = _projections(angles, axes)
    powers = _powers(None if time is None else checks.finite_array("time", time, shape=(len(angles),)), drift, angles)
    degree = powers.shape[1]
    if standard_deviation is not None:
        standard_deviation = _deviations(standard_deviation, readings.shape)

    # readings = mean + scale * (up * across_up + level rate across * across_starboard) (+ drift): bilinear
    def model(x):
        rates = across @ np.array([up, x[6] * level])
        return x[:3] + x[3:6] * rates / EARTH_RATE + powers @ x[7:].reshape(degree, 3)

    def jacobian(x):  # of the residuals: shape (n, gyro, parameter), rows of the readings in their order
        J = np.zeros((*readings.shape, len(names)))
        rates = across @ np.array([up, x[6] * level]) / EARTH_RATE
        for g in range(3):
            J[:, g, g], J[:, g, 3 + g] = 1.0, rates[:, g]
            J[:, g, 6] = x[3 + g] * across[:, g, 1] * level / EARTH_RATE
            J[:, g, 7 + g :: 3] = powers
        return -J.reshape(-1, len(names))

    names = [*(f"mean_{g}" for g in "xyz"), *(f"scale_{g}" for g in "xyz"), "sine"]
    names += [f"drift_{g}" if k == 1 else f"drift_{g}_{k}" for k in range(1, degree + 1) for g in "xyz"]
    size = float(np.ptp(readings, axis=0).max()) or 1.0
    solution = leastsquares.nonlinear(
        lambda x: (readings - model(x)).ravel(),
        _start(readings, across, up, powers),
        jacobian=jacobian,
        standard_deviation=standard_deviation,
        scale=scale,
        names=names,
        parameter_scale=[1.0 if name == "sine" else size for name in names],
    )
    solution.raise_if_unobservable("the scan")
    sine = -solution["sine"]
    if not abs(sine) <= 1:
        raise ValueError(
            f"`readings` must come from a turning Earth, got {abs(sine):.4g} times its level rate across the axis: "
            "drift, a wrong `lat` or `axes`, or too much noise"
        )
    headings = np.array([np.arcsin(sine), np.pi - np.arcsin(sine)])
    cosine = np.cos(headings)
    scales = solution.estimate[3:6] / EARTH_RATE
    with np.errstate(divide="ignore"):
        heading_std = float(np.float64(solution.standard_deviation[6]) / abs(cosine[0]))
    return ScanFit(
        headings=headings,
        heading_std=heading_std,
        scales=scales,
        scale_std=solution.standard_deviation[3:6] / EARTH_RATE,
        biases=solution.estimate[:3] / scales - level * cosine[:, np.newaxis] * along,
        solution=solution,
    )


def _projections(angles: ArrayLike, axes: ArrayLike | None) -> tuple[Array, Array]:
    """Parts of the input axes along the axis, shape (3,), and along up and starboard of it, shape (n, 3, 2)."""
    axes = pyramid_axes() if axes is None else checks.finite_array("axes", axes, shape=(3, 3))
    turned = hull_attitude(0.0, 0.0, checks.finite_array("angles", angles, shape=(None,))) @ axes
    return axes[0], np.swapaxes(turned[:, 1:, :], -1, -2)


def _start(readings: Array, across: Array, up: float, powers: Array) -> Array:
    """Start of the fit: a line of its own for each gyro, then the level rate that suits all best."""
    fits = []
    for g in range(3):
        columns = [np.ones(len(readings)), across[:, g, 0], across[:, g, 1], *powers.T]
        fits.append(np.linalg.lstsq(np.column_stack(columns), readings[:, g])[0])
    means, ups, starboards, *trends = np.array(fits).T
    if not ups @ ups > 0:
        raise ValueError(
            "`readings` must change with `angles`, got none that does: nothing is seen of the Earth's rate"
        )
    ratio = ups @ starboards / (ups @ ups)  # level rate across over up rate
    scales = ups / up * EARTH_RATE
    level_over = ratio * up / np.sqrt(EARTH_RATE**2 - up**2)
    return np.array([*means, *scales, level_over, *np.ravel(trends)])


def _powers(time: Array | None, degree: int, angles: Array) -> Array:
    """Powers of time without their means, shape (n, degree): of the time from the middle, in half spans."""
    degree = checks.integer("drift", degree, minimum=0)
    if time is None or degree == 0:
        return np.zeros((len(angles), 0))
    span = np.ptp(time)
    if span == 0:
        raise ValueError("`time` must not be the same for all readings: a drift needs a time to be seen in")
    powers = np.vander(2 * (time - time.mean()) / span, degree + 1, increasing=True)[:, 1:]
    return powers - powers.mean(axis=0)


def _deviations(standard_deviation: ArrayLike, shape: tuple[int, int]) -> Array:
    """Standard deviations in the order of the residuals."""
    deviation = checks.finite_array("standard_deviation", standard_deviation)
    if deviation.shape not in ((), shape[:1], shape):
        raise ValueError(
            f"`standard_deviation` must be one number, of shape {shape[:1]} or of {shape}, got {deviation.shape}"
        )
    full = deviation[:, np.newaxis] if deviation.ndim == 1 else deviation
    return np.broadcast_to(full, shape).ravel()


def _latitude(lat: float) -> float:
    return float(checked_latitude(checks.finite("lat", lat, "rad"), pole_margin=POLE_MARGIN))
