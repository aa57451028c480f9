"""How well heading can be known at best: bounds for a gyrocompass that stands still, under any law of its mount.

In axes of the mount the level Earth rate turns by the angle ``beta`` of the mount, and a bias does not. Written as one
complex number the two level gyro signals are ``omega_ie cos(lat) exp(i (beta - heading)) + bias + white noise``, for
any three orthogonal gyros of equal noise, however they stand on the mount: the up component, with the rate of the mount
and its errors, is left to the third direction. Least squares for heading and two unknown biases has the information ::

    (omega_ie cos(lat) / N)**2 * T * (1 - |m|**2)

with m the mean of ``exp(i beta)`` over the time T, so a law is judged by ``m`` alone: 0 is best, and nothing is left at
1, where the mount stands. Rocking by a harmonic
law has ``m = J0(amplitude)``, turning to and fro at constant speed ``sin(amplitude)/amplitude``; whole turns, two
opposite positions, and reversals at 180 degrees have 0. The period enters only where noise is not white
(`steady_heading_std`).

What the bounds leave out: level is known, by accelerometers whose constant errors turn with the hull, not with the
mount, and pass into heading under any law (`accelerometer_share`); the angle of the mount is known, and its constant
error goes into heading one to one.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.constants import EARTH_RATE
from fogkit.earth import POLE_MARGIN, checked_latitude
from fogkit.gyrocompass.encoder import Encoder
from fogkit.gyrocompass.laws import MountLaw

Array = NDArray[np.float64]

_STEP = 2e-3  # angle, rad, between points of a mean: the midpoint rule is then wrong by less than 2e-3**2/24 = 2e-7
_POINTS = 4096  # fewest points of a mean


@dataclass(frozen=True, kw_only=True)
class HeadingBound:
    """Smallest standard deviation of heading that any unbiased estimate can have.

    Attributes
    ----------
    std : float
        Standard deviation, rad; infinite if heading cannot be told from a bias.
    efficiency : float
        Information over that of gyros without bias, 0 to 1.
    mean_direction : complex
        Mean of ``exp(i beta)`` over the time.
    """

    std: float
    efficiency: float
    mean_direction: complex


def mean_direction(law: MountLaw, duration: float | None = None) -> complex:
    """Mean of ``exp(i beta)`` under a law.

    Parameters
    ----------
    law : MountLaw
        Law of the mount.
    duration : float, optional
        Time from 0, s; a period if not given.

    Returns
    -------
    complex
        Its square is the share of the information on heading that goes to unknown biases.

    Examples
    --------
    >>> from fogkit.gyrocompass.laws import ConstantSpeedReversal, QuasiHarmonic
    >>> for law in (QuasiHarmonic, ConstantSpeedReversal):
    ...     print([round(abs(mean_direction(law(amplitude=a, period=60.0))), 3) for a in (np.pi / 2, np.pi)])
    [0.472, 0.304]
    [0.637, 0.0]
    """
    return complex(np.exp(1j * law.angle(_times(law, duration))).mean())


def heading_bound(
    law: MountLaw,
    duration: float,
    lat: float,
    angle_random_walk: float,
    *,
    bias_std: float = np.inf,
    drift_std: float = 0.0,
) -> HeadingBound:
    """Smallest standard deviation of heading of a level gyrocompass at rest, at the end of its measurement.

    Parameters
    ----------
    law : MountLaw
        Law of the mount.
    duration : float
        Time of the measurement, s.
    lat : float
        Latitude, rad.
    angle_random_walk : float
        Of each of three orthogonal gyros, rad/sqrt(s).
    bias_std : float, optional
        What is known of the level gyros' biases beforehand: standard deviation, rad/s; nothing if not given.
    drift_std : float, optional
        Standard deviation of the bias about the mount's axis, rad/s, where the hull is not known to keep its heading
        (an aid gives velocity and position only). 0, the default: it is known not to turn; infinite: nothing is known.

    Returns
    -------
    HeadingBound
        `std`, `efficiency`, `mean_direction`.

    Raises
    ------
    ValueError
        If `lat` is within `fogkit.earth.POLE_MARGIN` of a pole, or another argument out of range.

    Notes
    -----
    Left out are the angle random walk of the up gyro, ``N sqrt(T)`` in heading, of relative weight
    ``(omega_ie cos(lat) T)**2``, 5e-4 after five minutes at the equator, and the Earth's turn of the tilts.

    Examples
    --------
    Gyros of 0.0176 deg/sqrt(h) rocked by 180 degrees for five minutes at 60 degrees of latitude, in arcmin:

    >>> from fogkit.gyrocompass.laws import QuasiHarmonic
    >>> from fogkit.units import ARCMIN, DEG, DEG_PER_SQRT_HOUR
    >>> law = QuasiHarmonic(amplitude=np.pi, period=60.0)
    >>> bound = heading_bound(law, 300.0, 60 * DEG, 0.0176 * DEG_PER_SQRT_HOUR)
    >>> round(bound.std / ARCMIN, 1)
    29.3
    """
    checks.instance("law", law, MountLaw)
    duration = checks.positive("duration", duration, "s")
    noise = checks.positive("angle_random_walk", angle_random_walk, "rad/sqrt(s)")
    level = EARTH_RATE * np.cos(_latitude(lat))
    bias_prior, drift_prior = _prior("bias_std", bias_std), _prior("drift_std", drift_std)

    t = _times(law, duration)
    signal = np.exp(1j * law.angle(t))
    m = complex(signal.mean())
    late = (t - duration) / duration  # heading was this much of the drift over the time away from that at the end
    rows = np.stack([signal, signal * late, np.full_like(signal, 1j), np.ones_like(signal)])
    information = (rows.conj() @ rows.T).real / len(t)  # per (level/noise)**2 T; biases in units of the level rate
    unit = (noise / level) ** 2 / duration
    kept = [0]
    if np.isfinite(drift_prior):
        information[1, 1] += unit * drift_prior / duration**2
        kept += [1]
    if np.isfinite(bias_prior):
        information[2:, 2:] += unit * level**2 * bias_prior * np.eye(2)
        kept += [2, 3]
    efficiency = _schur(information[np.ix_(kept, kept)])
    std = float(np.sqrt(unit / efficiency)) if efficiency > 0 else np.inf
    return HeadingBound(std=std, efficiency=efficiency, mean_direction=m)


def steady_heading_std(
    law: MountLaw, duration: float, lat: float, spectrum: Callable[[Array], ArrayLike], harmonics: int = 1000
) -> float:
    """Standard deviation of heading with gyro noise of any spectrum, over many periods of the law.

    Parameters
    ----------
    law : MountLaw
        Law of the mount.
    duration : float
        Time of the measurement, s; at least five periods.
    lat : float
        Latitude, rad.
    spectrum : callable
        Two-sided power spectral density of each gyro's rate noise, (rad/s)**2/Hz, at an array of frequencies above 0,
        Hz. Frequency zero is taken to be lost to the bias.
    harmonics : int, optional
        Highest multiple of the law's frequency that is taken.

    Returns
    -------
    float
        Rad; infinite if all of the level Earth rate is lost to the bias.

    Raises
    ------
    ValueError
        If there are less than five periods, or the spectrum is not above zero.

    Notes
    -----
    The level Earth rate in the mount is a line spectrum with powers ``|c_k|**2`` at multiples ``k/period``, for rocking
    the Bessel functions ``J_k(amplitude)**2``, and each line is weighed with the noise there::

        1/std**2 = (omega_ie cos(lat))**2 * duration * sum over k != 0 of |c_k|**2 / spectrum(|k|/period)

    """
    checks.instance("law", law, MountLaw)
    duration = checks.positive("duration", duration, "s")
    harmonics = checks.integer("harmonics", harmonics, minimum=1)
    if not callable(spectrum):
        raise TypeError(f"`spectrum` must be a function of frequency, got {type(spectrum).__name__}")
    if duration < 5 * law.period:
        raise ValueError(f"`duration` must be at least five periods, {5 * law.period:g} s, got {duration:g}")
    points = max(4 * harmonics, len(_times(law, None)))
    u = law.period * np.arange(points) / points
    lines = np.abs(np.fft.fft(np.exp(1j * law.angle(u))) / points) ** 2
    power = lines[1 : harmonics + 1] + lines[: -harmonics - 1 : -1]
    density = checks.finite_array("spectrum", spectrum(np.arange(1, harmonics + 1) / law.period), shape=(harmonics,))
    if not (density > 0).all():
        raise ValueError(f"`spectrum` must be above 0 at all frequencies, got {density.min():.3g}")
    information = (EARTH_RATE * np.cos(_latitude(lat))) ** 2 * duration * float((power / density).sum())
    return float(1 / np.sqrt(information)) if information > 0 else np.inf


def accelerometer_share(lat: float, level_std: float) -> float:
    """Standard deviation of heading, rad, from tilts known to `level_std`, rad: ``tan(lat) * level_std`` under any law.

    A tilt about north takes ``omega_ie sin(lat)`` into the east, where heading is read off. Accelerometers on the hull
    leave a tilt of their bias over gravity, which the mount does not turn.
    """
    return float(abs(np.tan(_latitude(lat))) * checks.non_negative("level_std", level_std, "rad"))


def encoder_share(law: MountLaw, encoder: Encoder, duration: float) -> float:
    """Error of heading from a wrong angle of the mount, for a level gyrocompass at rest with unknown biases.

    Parameters
    ----------
    law : MountLaw
        What the mount does.
    encoder : Encoder
        Errors of its angle sensor; the noise is left out.
    duration : float
        Time of the measurement, s.

    Returns
    -------
    float
        Error of the least-squares heading to first order in the sensor's, rad.

    Raises
    ------
    ValueError
        If the law leaves no information on heading beside the biases.

    Notes
    -----
    With the error ``e`` and means over the time, ``(mean(e) - Re(conj(m) * mean(e exp(i beta)))) / (1 - |m|**2)``. A
    constant error passes whole. Errors that are odd in rate or acceleration (delay, backlash, twist at the reversals)
    have no mean over whole periods of a law that is the same to and fro, whether its reversals are gentle or hard.
    """
    t = _times(checks.instance("law", law, MountLaw), duration)
    error = checks.instance("encoder", encoder, Encoder).error(law, t)
    signal = np.exp(1j * law.angle(t))
    m = signal.mean()
    efficiency = 1 - abs(m) ** 2
    if efficiency < 1e-9:
        raise ValueError(f"`law` must turn the mount, got an efficiency of {efficiency:.3g}: heading is lost in biases")
    return float((error.mean() - (m.conjugate() * (error * signal).mean()).real) / efficiency)


def best_harmonic_amplitude() -> float:
    """Smallest amplitude, rad, at which a harmonic law costs nothing: the first zero of the Bessel function J0.

    Examples
    --------
    >>> round(float(np.rad2deg(best_harmonic_amplitude())), 2)
    137.79
    """
    from scipy.special import jn_zeros

    return float(jn_zeros(0, 1)[0])


def _latitude(lat: float) -> float:
    return float(checked_latitude(checks.finite("lat", lat, "rad"), pole_margin=POLE_MARGIN))


def _prior(name: str, std: float) -> float:
    """Information of a prior: infinite for a known value, 0 for an unknown one."""
    if not (isinstance(std, float | int) and std == np.inf):
        std = checks.non_negative(name, std, "rad/s")
    with np.errstate(divide="ignore"):
        return float(np.float64(1.0) / np.float64(std) ** 2)


def _times(law: MountLaw, duration: float | None) -> Array:
    """Midpoints of equal steps over a time, close enough for a mean."""
    checks.instance("law", law, MountLaw)
    duration = law.period if duration is None else checks.positive("duration", duration, "s")
    points = max(_POINTS, int(np.ceil(law.max_rate * duration / _STEP)))
    return duration * (np.arange(points) + 0.5) / points


def _schur(information: Array) -> float:
    """Information on the first parameter when the others are unknown, 0 if they can take its place."""
    nuisance, cross = information[1:, 1:], information[0, 1:]
    if not cross.size:
        return float(information[0, 0])
    rest = float(information[0, 0] - cross @ np.linalg.lstsq(nuisance, cross, rcond=1e-12)[0])
    return rest if rest > 1e-12 else 0.0  # rounding of the sums
