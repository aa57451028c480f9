"""What the angle sensor of the mount says, and what the drive makes of a law.

The thesis names two errors against turning at constant speed: a dynamic error of the angle sensor at the reversals, and
a speed that is not steady within a turn. Both are here as functions of the motion, so that every law has them to the
extent that its motion calls for them.

References
----------
.. [1] Le Van Chang, Gyrocompass with a quasi-harmonic autocompensating mount (in Russian), thesis abstract, LETI,
   St Petersburg, 2015, chapter 2.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.gyrocompass.laws import MountLaw

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class UnsteadyLaw(MountLaw):
    """A law carried out by a gear whose speed is not steady within a turn.

    Parameters
    ----------
    law : MountLaw
        What is commanded.
    fraction : float
        Amplitude of the speed's departure, as a fraction of the speed, in [0, 1).
    order : int, optional
        How often the departure comes in a turn of the mount.
    phase : float, optional
        Its phase at angle zero, rad.

    Raises
    ------
    ValueError
        If the fraction is not in [0, 1) or the order less than 1.

    Notes
    -----
    The angle is ``c + (fraction/order) * (sin(order*c + phase) - sin(phase))`` for a commanded angle ``c``, so that
    the speed is that of the law times ``1 + fraction*cos(order*c + phase)``, whichever way the mount turns.
    """

    law: MountLaw
    fraction: float
    order: int = 1
    phase: float = 0.0

    def __post_init__(self) -> None:
        checks.instance("law", self.law, MountLaw)
        fraction = checks.in_closed_interval("fraction", self.fraction, 0.0, np.nextafter(1.0, 0.0))
        object.__setattr__(self, "fraction", fraction)
        object.__setattr__(self, "order", checks.integer("order", self.order, minimum=1))
        object.__setattr__(self, "phase", checks.finite("phase", self.phase, "rad"))

    @property
    def period(self) -> float:
        """Period of the law, s."""
        return self.law.period

    @property
    def max_rate(self) -> float:
        """Rate that is not exceeded, rad/s: that of the law with the largest departure."""
        return self.law.max_rate * (1 + self.fraction)

    def motion(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """As for every law."""
        angle, rate, acceleration = self.law.motion(t)
        inner = self.order * angle + self.phase
        gain = 1 + self.fraction * np.cos(inner)
        bent = self.fraction / self.order * (np.sin(inner) - np.sin(self.phase))
        return (
            angle + bent,
            rate * gain,
            acceleration * gain - self.fraction * self.order * np.sin(inner) * rate**2,
        )


@dataclass(frozen=True, kw_only=True)
class Encoder:
    """Errors of the angle sensor: what it reads less the angle of the mount.

    Parameters
    ----------
    offset : float, optional
        Error of its zero against the hull, rad; it goes into heading one to one under any law.
    harmonic, order, phase : float, int, float, optional
        Amplitude, rad, number in a turn, and phase of an error that repeats with the angle.
    delay : float, optional
        Age of a reading, s: an error in proportion to the rate.
    compliance : float, optional
        Twist between mount and sensor per acceleration, rad per rad/s^2: the dynamic error at reversals.
    backlash : float, optional
        Play between mount and sensor, rad: half of it is an error with the sign of the rate.
    noise : float, optional
        Standard deviation of the white noise of a reading, rad.

    Raises
    ------
    ValueError
        If an entry is not finite, or delay, backlash or noise negative.
    """

    offset: float = 0.0
    harmonic: float = 0.0
    order: int = 1
    phase: float = 0.0
    delay: float = 0.0
    compliance: float = 0.0
    backlash: float = 0.0
    noise: float = 0.0

    def __post_init__(self) -> None:
        for name, unit in (("offset", "rad"), ("harmonic", "rad"), ("phase", "rad"), ("compliance", "s^2")):
            object.__setattr__(self, name, checks.finite(name, getattr(self, name), unit))
        for name, unit in (("delay", "s"), ("backlash", "rad"), ("noise", "rad")):
            object.__setattr__(self, name, checks.non_negative(name, getattr(self, name), unit))
        object.__setattr__(self, "order", checks.integer("order", self.order, minimum=1))

    def error(self, law: MountLaw, t: ArrayLike) -> Array:
        """Error without the noise at the times `t`, s, of a mount that follows `law`; rad, of the shape of `t`."""
        angle, rate, acceleration = checks.instance("law", law, MountLaw).motion(t)
        return (
            self.offset
            + self.harmonic * np.sin(self.order * angle + self.phase)
            + (law.angle(np.asarray(t, dtype=float) - self.delay) - angle)
            - self.compliance * acceleration
            - 0.5 * self.backlash * np.sign(rate)
        )

    def read(self, law: MountLaw, t: ArrayLike, rng: np.random.Generator | None = None) -> Array:
        """Readings at the times `t`, s, of a mount that follows `law`.

        Parameters
        ----------
        law : MountLaw
            What the mount does.
        t : array_like, shape (n,)
            Times, s.
        rng : numpy.random.Generator, optional
            Source of the noise; needed if there is any.

        Returns
        -------
        ndarray, shape (n,)
            Angles, rad.

        Raises
        ------
        TypeError
            If there is noise and no generator.
        """
        reading = law.angle(t) + self.error(law, t)
        if self.noise > 0:
            reading = reading + self.noise * checks.generator("rng", rng).standard_normal(np.shape(reading))
        return reading
