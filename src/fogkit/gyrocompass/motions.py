"""What a vessel does and what its gyrocompass then reads: the motion along which errors are followed.

References
----------
.. [1] Le Van Chang, Gyrocompass with a quasi-harmonic autocompensating mount (in Russian), thesis abstract, LETI,
   St Petersburg, 2015, chapter 3.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.constants import STANDARD_GRAVITY
from fogkit.earth import POLE_MARGIN, checked_latitude
from fogkit.gyrocompass.frames import hull_attitude, pyramid_axes
from fogkit.gyrocompass.laws import Fixed, MountLaw
from fogkit.gyrocompass.mechanisation import EARTH_RADIUS, checked_trim, geographic_rate, gyro_rates

Array = NDArray[np.float64]

COARSEST_PHASE = 2 * np.pi / 10
"""Phase of rolling, rad, from one sample to the next at most."""


@dataclass(frozen=True, kw_only=True)
class Motion:
    """True motion and true readings at equally spaced times.

    Attributes
    ----------
    time : ndarray, shape (n,)
        s, from 0.
    states : ndarray, shape (n, 9)
        In the order of `fogkit.gyrocompass.mechanisation.CompassState.to_vector`.
    rates : ndarray, shape (n, 3)
        Rates of the gyros x, y, z of the pyramid, rad/s.
    specific_force : ndarray, shape (n, 3)
        In the hull, forward, up, starboard, m/s^2.
    mount_angle, mount_rate : ndarray, shape (n,)
        rad, rad/s.
    gravity : float
        Gravity on the sphere, m/s^2.
    axes : ndarray, shape (3, 3)
        ``C_p_m``, the gyros' input axes in the mount; those of the pyramid, unless gyros stand otherwise.
    """

    time: Array
    states: Array
    rates: Array
    specific_force: Array
    mount_angle: Array
    mount_rate: Array
    gravity: float = STANDARD_GRAVITY
    axes: Array = field(default_factory=pyramid_axes)

    @property
    def dt(self) -> float:
        """Step, s."""
        return float(self.time[1] - self.time[0])


@dataclass(frozen=True, kw_only=True)
class Vessel:
    """A vessel that keeps its trim and speed and rolls harmonically: the motion of [1]_, and manoeuvres.

    Parameters
    ----------
    lat : float
        Latitude, rad.
    heading, trim : float, optional
        Angles, rad.
    roll, roll_swing : float, optional
        Mean roll and amplitude of rolling, rad.
    roll_period : float, optional
        Period of rolling, s.
    speed : float, optional
        Speed ahead over the ground, m/s, level; the vessel then follows its heading, along a rhumb line if it keeps it.
    turning : MountLaw, optional
        Law by which the hull itself turns: what its heading is more than `heading`, **clockwise**. A circle is a
        `OneWay` (clockwise False: to starboard), a zig-zag a harmonic or a reversal, two headings a `DwellAndTurn`.

    Raises
    ------
    ValueError
        If an argument is out of range: `lat` at a pole, `trim` vertical, `roll_period` not positive.

    Notes
    -----
    The vessel moves where it looks, so that a turn at speed costs the centripetal force; it does not heel in it. A
    rate that jumps, as that of a harmonic law at its start, is one of a hull without inertia.
    """

    lat: float
    heading: float = 0.0
    trim: float = 0.0
    roll: float = 0.0
    roll_swing: float = 0.0
    roll_period: float = 60.0
    speed: float = 0.0
    turning: MountLaw | None = None

    def __post_init__(self) -> None:
        lat = checked_latitude(checks.finite("lat", self.lat, "rad"), pole_margin=POLE_MARGIN)
        object.__setattr__(self, "lat", float(lat))
        object.__setattr__(self, "trim", float(checked_trim(checks.finite("trim", self.trim, "rad"))))
        for name, unit in (("heading", "rad"), ("roll", "rad"), ("roll_swing", "rad"), ("speed", "m/s")):
            object.__setattr__(self, name, checks.finite(name, getattr(self, name), unit))
        object.__setattr__(self, "roll_period", checks.positive("roll_period", self.roll_period, "s"))
        if self.turning is not None:
            checks.instance("turning", self.turning, MountLaw)

    def motion(
        self,
        duration: float,
        dt: float,
        law: MountLaw | None = None,
        *,
        gravity: float = STANDARD_GRAVITY,
        axes: ArrayLike | None = None,
    ) -> Motion:
        """Motion with a law of the mount, from time 0.

        Parameters
        ----------
        duration, dt : float
            Length and step, s.
        law : MountLaw, optional
            Law of the mount; switched off at angle 0 if not given.
        gravity : float, optional
            m/s^2.
        axes : array_like, shape (3, 3), optional
            ``C_p_m`` of gyros that stand on the mount in another way than the pyramid's, each in a column.

        Returns
        -------
        Motion
            True motion and readings.

        Raises
        ------
        ValueError
            If a law is sampled too coarsely (`MountLaw.sample_times`), rolling by less than 10 samples in a period, a
            pole is reached, or `axes` is no rotation.
        """
        axes = pyramid_axes() if axes is None else checks.rotation_matrix("axes", axes)
        law = Fixed() if law is None else checks.instance("law", law, MountLaw)
        gravity = checks.positive("gravity", gravity, "m/s^2")
        t = law.sample_times(duration, dt)
        heading, yaw = self._heading(t, dt)
        frequency = 2 * np.pi / self.roll_period
        if self.roll_swing != 0 and frequency * dt > COARSEST_PHASE:
            raise ValueError(
                f"`dt` must be at most {COARSEST_PHASE / frequency:.3g} s for rolling with a `roll_period` of "
                f"{self.roll_period:g} s, got {dt:g} s. Sample faster."
            )
        roll = self.roll + self.roll_swing * np.sin(frequency * t)
        C_h_g = hull_attitude(heading, self.trim, roll)
        sine, cosine, zero = np.sin(heading), np.cos(heading), np.zeros_like(t)
        velocity = self.speed * np.stack([cosine, zero, sine], axis=-1)
        acceleration = self.speed * yaw[:, np.newaxis] * np.stack([-sine, zero, cosine], axis=-1)
        lat, lon = self._rhumb_line(t) if self.turning is None else self._track(velocity, acceleration, dt)
        omega_ig_g = geographic_rate(lat, velocity)
        earth = omega_ig_g + geographic_rate(lat, np.zeros(3))
        force_g = acceleration + np.array([0.0, gravity, 0.0]) + np.cross(earth, velocity)
        omega_ih_g = omega_ig_g - yaw[:, np.newaxis] * np.array([0.0, 1.0, 0.0])  # clockwise
        to_hull = C_h_g.swapaxes(-1, -2)
        hull = (to_hull @ omega_ih_g[..., np.newaxis])[..., 0]
        hull[:, 0] += self.roll_swing * frequency * np.cos(frequency * t)  # rolling is about the hull's forward axis
        states = np.zeros((len(t), 9))
        states[:, 0], states[:, 1], states[:, 2] = heading, self.trim, roll
        states[:, 3:6], states[:, 6], states[:, 7] = velocity, lat, lon
        angle, rate, _ = law.motion(t)
        return Motion(
            time=t,
            states=states,
            rates=gyro_rates(hull, angle, rate) @ pyramid_axes().T @ axes,
            specific_force=(to_hull @ force_g[..., np.newaxis])[..., 0],
            mount_angle=angle,
            mount_rate=rate,
            gravity=gravity,
            axes=axes,
        )

    def _heading(self, t: Array, dt: float) -> tuple[Array, Array]:
        """Heading and its rate at times, after the check that the hull's turning is sampled finely enough."""
        if self.turning is None:
            return np.full_like(t, self.heading), np.zeros_like(t)
        self.turning.sample_times(max(t[-1], dt), dt)
        angle, rate, _ = self.turning.motion(t)
        return self.heading + angle, rate

    def _track(self, velocity: Array, acceleration: Array, dt: float) -> tuple[Array, Array]:
        """Latitude and longitude, rad, of a vessel that turns."""
        lat = self.lat + _integral(velocity[:, 0], acceleration[:, 0], dt) / EARTH_RADIUS
        checked_latitude(lat, pole_margin=POLE_MARGIN)
        east = velocity[:, 2] / np.cos(lat)
        its_rate = (acceleration[:, 2] + east * np.sin(lat) * velocity[:, 0] / EARTH_RADIUS) / np.cos(lat)
        return lat, _integral(east, its_rate, dt) / EARTH_RADIUS

    def _rhumb_line(self, t: Array) -> tuple[Array, Array]:
        """Latitude and longitude, rad, at times, s: longitude by the difference of isometric latitudes."""
        north, east = self.speed / EARTH_RADIUS * np.array([np.cos(self.heading), np.sin(self.heading)])
        lat = self.lat + north * t
        if abs(north) * t[-1] < 1e-6:  # along a parallel: the difference below would be lost in rounding
            return lat, east * t / np.cos(0.5 * (lat + self.lat))
        isometric = np.arctanh(np.sin(lat)) - np.arctanh(np.sin(self.lat))
        return lat, np.tan(self.heading) * isometric


def _integral(values: Array, rates: Array, dt: float) -> Array:
    """Integral from the start, by the trapezoidal rule with its first correction, by the rates at the ends."""
    sums = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]))]) * dt
    return sums - dt**2 / 12 * (rates - rates[0])
