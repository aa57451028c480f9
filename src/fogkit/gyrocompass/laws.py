"""How the mount turns: angle, rate and acceleration of a law of motion over time.

A law is what the drive does; what the angle sensor says of it is `fogkit.gyrocompass.encoder`. Every law is periodic up
to whole turns, and answers at any time. Angles are counter-clockwise seen from above (`fogkit.gyrocompass.frames`).

References
----------
.. [1] Le Van Chang, Gyrocompass with a quasi-harmonic autocompensating mount (in Russian), thesis abstract, LETI,
   St Petersburg, 2015, chapter 2.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.units import DEG_PER_SECOND

Array = NDArray[np.float64]

COARSEST_STEP = 0.1
"""Angle, rad, that a mount may turn between two samples: averages over a turn are then right to 0.1**2/24 = 4e-4."""

LARGEST_AMPLITUDE = 20 * np.pi
"""Amplitude, rad, above which degrees are suspected: ten turns."""


class MountLaw(ABC):
    """A law of motion: `motion` gives angle, rate and acceleration; `period`, s; `max_rate`, rad/s."""

    period: float

    @property
    @abstractmethod
    def max_rate(self) -> float:
        """Largest rate, either way, rad/s."""

    @abstractmethod
    def motion(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """Angle, rad, rate, rad/s, and acceleration, rad/s^2, at the times `t`, s; each of the shape of `t`."""

    def angle(self, t: ArrayLike) -> Array:
        """Angle at the times `t`, rad."""
        return self.motion(t)[0]

    def rate(self, t: ArrayLike) -> Array:
        """Rate at the times `t`, rad/s."""
        return self.motion(t)[1]

    def sample_times(self, duration: float, dt: float) -> Array:
        """Times from 0 to a duration, after the check that the law is not sampled too coarsely.

        Parameters
        ----------
        duration, dt : float
            Length and step, s.

        Returns
        -------
        ndarray, shape (n,)
            ``0, dt, ...``, s.

        Raises
        ------
        ValueError
            If the mount turns by more than `COARSEST_STEP` in a step, or the duration is shorter than a step.
        """
        duration, dt = checks.positive("duration", duration, "s"), checks.positive("dt", dt, "s")
        step = self.max_rate * dt
        if step > COARSEST_STEP:
            raise ValueError(
                f"`dt` must be at most {COARSEST_STEP / self.max_rate:.3g} s for a mount that turns with up to "
                f"{self.max_rate / DEG_PER_SECOND:.4g} deg/s, got {dt:g} s: {step:.3g} rad in a step. Sample faster."
            )
        if duration < dt:
            raise ValueError(f"`duration` must be at least `dt`, {dt:g} s, got {duration:g}")
        return dt * np.arange(int(duration / dt + 1e-9) + 1)


@dataclass(frozen=True, kw_only=True)
class Fixed(MountLaw):
    """A mount that is switched off, at an angle, rad; any time is a period of it."""

    position: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", checks.finite("position", self.position, "rad"))

    period = 1.0

    @property
    def max_rate(self) -> float:
        """0."""
        return 0.0

    def motion(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """As for every law."""
        t = checks.finite_array("t", t)
        return np.full_like(t, self.position), np.zeros_like(t), np.zeros_like(t)


@dataclass(frozen=True, kw_only=True)
class QuasiHarmonic(MountLaw):
    """Rocking, ``centre + amplitude * sin(2 pi t / period + phase)``: (15) of [1]_.

    Parameters
    ----------
    amplitude : float
        Amplitude, rad, above 0.
    period : float
        Period, s.
    centre, phase : float, optional
        Mean angle and phase at time 0, rad.

    Raises
    ------
    ValueError
        If the period is not positive, or the amplitude not between 0 and 10 turns.

    Examples
    --------
    The experiment of [1]_, 180 degrees in 60 s:

    >>> round(float(np.rad2deg(QuasiHarmonic(amplitude=np.pi, period=60.0).max_rate)), 2)
    18.85
    """

    amplitude: float
    period: float
    centre: float = 0.0
    phase: float = 0.0

    def __post_init__(self) -> None:
        _check_law(self)
        for name in ("centre", "phase"):
            object.__setattr__(self, name, checks.finite(name, getattr(self, name), "rad"))

    @classmethod
    def from_rate(cls, amplitude: float, max_rate: float) -> Self:
        """Law of the shortest period whose rate stays within `max_rate`, rad/s: what follows (16) of [1]_."""
        amplitude = checks.positive("amplitude", amplitude, "rad")
        return cls(amplitude=amplitude, period=2 * np.pi * amplitude / checks.positive("max_rate", max_rate, "rad/s"))

    @property
    def max_rate(self) -> float:
        """Largest rate, ``2 pi amplitude / period``, rad/s."""
        return 2 * np.pi * self.amplitude / self.period

    def motion(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """As for every law."""
        frequency = 2 * np.pi / self.period
        angle = frequency * checks.finite_array("t", t) + self.phase
        swing = self.amplitude * np.sin(angle)
        return self.centre + swing, self.amplitude * frequency * np.cos(angle), -(frequency**2) * swing


@dataclass(frozen=True, kw_only=True)
class ConstantSpeedReversal(MountLaw):
    """Turning at constant speed from one end to the other and back.

    Parameters
    ----------
    amplitude : float
        Half of the way between the ends, rad.
    period : float
        Time there and back, s.
    reversal_time : float, optional
        Time that a reversal takes, at constant acceleration, s; at most half a period.
    centre : float, optional
        Angle between the ends, rad, where the mount is at time 0, turning counter-clockwise.

    Raises
    ------
    ValueError
        If the period is not positive, the amplitude not between 0 and 10 turns, or reversals longer than half-periods.
    """

    amplitude: float
    period: float
    reversal_time: float = 0.0
    centre: float = 0.0

    def __post_init__(self) -> None:
        _check_law(self)
        half = self.period / 2
        value = checks.in_closed_interval(
            "reversal_time", self.reversal_time, 0.0, half, "s", fix="There are two reversals in a period."
        )
        object.__setattr__(self, "reversal_time", value)
        object.__setattr__(self, "centre", checks.finite("centre", self.centre, "rad"))

    @property
    def max_rate(self) -> float:
        """Rate between the reversals, rad/s: half a reversal's way is lost in it."""
        return 2 * self.amplitude / (self.period / 2 - self.reversal_time / 2)

    def motion(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """As for every law; at a reversal without duration the rate is that before it and the acceleration zero."""
        half, speed, turn = self.period / 2, self.max_rate, self.reversal_time / 2
        u = np.mod(checks.finite_array("t", t) + half / 2, self.period)  # 0 at the lower end
        way = np.where(u <= half, 1.0, -1.0)  # up, then down
        v = np.where(u <= half, u, u - half)
        to_end = np.minimum(v, half - v)  # time from the nearer end
        towards = np.where(v <= half / 2, 1.0, -1.0)
        acceleration = speed / turn if turn > 0 else 0.0
        slow = to_end < turn
        from_end = np.where(slow, 0.5 * acceleration * to_end**2, speed * (to_end - turn / 2))
        rate = np.where(slow, acceleration * to_end, speed)
        angle = self.centre + way * towards * (from_end - self.amplitude)
        return angle, way * rate, np.where(slow, way * towards * acceleration, 0.0)


@dataclass(frozen=True, kw_only=True)
class DwellAndTurn(MountLaw):
    """Dwells in positions, one after the other, with smooth turns between them.

    Parameters
    ----------
    positions : array_like, shape (n,), optional
        Angles of the dwells, rad, 2 at least; from the last one the mount turns back to the first. Two opposite ones
        if not given.
    dwell, turn_duration : float
        Time in each position and time of each turn, s. The rate of a turn follows a raised cosine.

    Raises
    ------
    ValueError
        If there are less than two positions, one is more than 10 turns away, or a time is not positive.
    """

    positions: ArrayLike = (0.0, np.pi)
    dwell: float
    turn_duration: float

    def __post_init__(self) -> None:
        positions = checks.finite_array("positions", self.positions, shape=(None,), min_size=2)
        checks.in_closed_interval("positions", np.abs(positions).max(), 0.0, LARGEST_AMPLITUDE, "rad", fix=_DEGREES_FIX)
        object.__setattr__(self, "positions", tuple(positions.tolist()))
        for name in ("dwell", "turn_duration"):
            object.__setattr__(self, name, checks.positive(name, getattr(self, name), "s"))

    @property
    def period(self) -> float:
        """Time until the first dwell begins again, s."""
        return len(self.positions) * (self.dwell + self.turn_duration)

    @property
    def max_rate(self) -> float:
        """Rate in the middle of the longest turn, twice its mean, rad/s."""
        return float(np.abs(self._ways).max()) * 2 / self.turn_duration

    @property
    def _ways(self) -> Array:
        return np.roll(self.positions, -1) - np.array(self.positions)

    def motion(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """As for every law."""
        u = np.mod(checks.finite_array("t", t), self.period)
        stage = np.minimum((u / (self.dwell + self.turn_duration)).astype(int), len(self.positions) - 1)
        s = np.clip((u - stage * (self.dwell + self.turn_duration) - self.dwell) / self.turn_duration, 0.0, 1.0)
        start, way = np.array(self.positions)[stage], self._ways[stage]
        angle = start + way * (s - np.sin(2 * np.pi * s) / (2 * np.pi))
        rate = way * (1 - np.cos(2 * np.pi * s)) / self.turn_duration
        return angle, rate, way * 2 * np.pi * np.sin(2 * np.pi * s) / self.turn_duration**2


@dataclass(frozen=True, kw_only=True)
class OneWay(MountLaw):
    """Turning on and on at constant speed.

    Parameters
    ----------
    period : float
        Time of a turn, s.
    clockwise : bool, optional
        Direction seen from above.
    start : float, optional
        Angle at time 0, rad.
    """

    period: float
    clockwise: bool = False
    start: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "period", checks.positive("period", self.period, "s", fix=_PERIOD_FIX))
        checks.instance("clockwise", self.clockwise, bool)
        object.__setattr__(self, "start", checks.finite("start", self.start, "rad"))

    @property
    def max_rate(self) -> float:
        """Rate, rad/s, without its sign."""
        return 2 * np.pi / self.period

    def motion(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """As for every law."""
        t = checks.finite_array("t", t)
        rate = -self.max_rate if self.clockwise else self.max_rate
        return self.start + rate * t, np.full_like(t, rate), np.zeros_like(t)


_PERIOD_FIX = "The direction of a turn is not in the sign of its period."
_DEGREES_FIX = "Multiply degrees by `fogkit.units.DEG`."


@dataclass(frozen=True, kw_only=True)
class SwitchedOn(MountLaw):
    """A mount that stands until a time and then follows a law.

    Parameters
    ----------
    law : MountLaw
        Law from then on, as it is from its own time 0; the mount waits at the angle that it begins with.
    start : float
        Time of switching on, s. The rate may jump there, as that of a harmonic law does.
    """

    law: MountLaw
    start: float

    def __post_init__(self) -> None:
        checks.instance("law", self.law, MountLaw)
        object.__setattr__(self, "start", checks.non_negative("start", self.start, "s"))

    @property
    def period(self) -> float:
        """Period of the law, s."""
        return self.law.period

    @property
    def max_rate(self) -> float:
        """Largest rate of the law, rad/s."""
        return self.law.max_rate

    def motion(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """As for every law; the rate at the start is that of the law."""
        since = checks.finite_array("t", t) - self.start
        angle, rate, acceleration = self.law.motion(np.maximum(since, 0.0))
        on = since >= 0
        return angle, np.where(on, rate, 0.0), np.where(on, acceleration, 0.0)


def _check_law(law: MountLaw) -> None:
    amplitude = checks.positive("amplitude", law.amplitude, "rad")
    amplitude = checks.in_closed_interval("amplitude", amplitude, 0.0, LARGEST_AMPLITUDE, "rad", fix=_DEGREES_FIX)
    object.__setattr__(law, "amplitude", amplitude)
    object.__setattr__(law, "period", checks.positive("period", law.period, "s", fix=_PERIOD_FIX))
