"""A measurement unit as a source of readings: linear part, shape of the scale factors, random errors, range, pulses.

Delays and the size effect are properties of the unit too, but only a motion shows them:
`fogkit.stand.turn_recordings`.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.imu.size_effect import SizeEffect
from fogkit.imu.triads import LinearTriad
from fogkit.noise.processes import RandomErrors, quantize, simulate

LONGEST_DELAY = 1.0
"""Longest delay of a sensor, s, of either sign: more is likely to be in ms."""


@dataclass(frozen=True, kw_only=True)
class Shape:
    """Scale factors that are not constant: input u along a sensor's axis acts as ``u + a |u| / 2 + q u^2 + c u^3``.

    Parameters
    ----------
    asymmetry : array_like, shape (3,), optional
        Difference of the scale factors for positive and negative input along the sensor's own axis, over their mean.
    quadratic : array_like, shape (3,), optional
        Second-order coefficient, per unit of input (IEEE 1293: K_2).
    cubic : array_like, shape (3,), optional
        Third-order coefficient, per squared unit of input.
    """

    asymmetry: ArrayLike = field(default=(0.0, 0.0, 0.0))
    quadratic: ArrayLike = field(default=(0.0, 0.0, 0.0))
    cubic: ArrayLike = field(default=(0.0, 0.0, 0.0))

    def __post_init__(self) -> None:
        for name in ("asymmetry", "quadratic", "cubic"):
            values = checks.finite_array(name, getattr(self, name), shape=(3,))
            object.__setattr__(self, name, tuple(values.tolist()))

    def apply(self, along: NDArray[np.float64]) -> NDArray[np.float64]:
        """Effective input, shape (..., 3), of inputs along the sensors' axes, shape (..., 3)."""
        half, second, third = np.array(self.asymmetry) / 2, np.array(self.quadratic), np.array(self.cubic)
        return along + half * np.abs(along) + along**2 * (second + third * along)


@dataclass(frozen=True, kw_only=True)
class Sensors:
    """Three sensors of one kind.

    Parameters
    ----------
    triad : LinearTriad, optional
        Bias, scale factors and directions of the input axes.
    shape : Shape, optional
        Departure of the scale factors from constants.
    random : RandomErrors, optional
        Random errors of each, in units of the input: rad for gyros, m/s for accelerometers, in place of the angle.
    range : float, optional
        Largest input along a sensor's axis, of either sign; beyond it the reading stays.
    pulse : float, optional
        What the reading's integral is counted in, in units of the reading times s: 1 for pulses per second. 0 for a
        reading without steps.
    delay : array_like, shape (3,), optional
        Of each sensor, s: its reading at a time is that of the input so much earlier. Only a recording of a motion
        takes it (`fogkit.stand.turn_recordings`).
    """

    triad: LinearTriad = field(default_factory=LinearTriad)
    shape: Shape = field(default_factory=Shape)
    random: RandomErrors = field(default_factory=RandomErrors)
    range: float = np.inf
    pulse: float = 0.0
    delay: ArrayLike = field(default=(0.0, 0.0, 0.0))

    def __post_init__(self) -> None:
        for name, kind in (("triad", LinearTriad), ("shape", Shape), ("random", RandomErrors)):
            checks.instance(name, getattr(self, name), kind)
        if not self.range > 0:
            raise ValueError(f"`range` must be > 0, in units of the input, got {self.range}")
        checks.non_negative("pulse", self.pulse)
        delay = checks.finite_array("delay", self.delay, shape=(3,))
        fix = "Multiply milliseconds by 1e-3."
        checks.array_in_closed_interval("delay", delay, -LONGEST_DELAY, LONGEST_DELAY, "s", fix=fix)
        object.__setattr__(self, "delay", tuple(delay.tolist()))

    def expected(self, inputs: ArrayLike, specific_force: ArrayLike | None = None) -> NDArray[np.float64]:
        """Readings without random errors and steps, shape (..., 3).

        Parameters
        ----------
        inputs : array_like, shape (..., 3)
            Rate, rad/s, or specific force, m/s^2, along the axes of the case.
        specific_force : array_like, shape (..., 3), optional
            What acts on acceleration-sensitive gyros, m/s^2.

        Raises
        ------
        ValueError
            If the sensors have delays: inputs at one time do not say what came earlier.
        """
        return self._read(self._along(inputs), self._without_input(specific_force), noise=0.0)

    def readings(
        self,
        inputs: ArrayLike,
        dt: float,
        rng: np.random.Generator,
        specific_force: ArrayLike | None = None,
    ) -> NDArray[np.float64]:
        """Mean readings over samples, shape (n, 3), with random errors and steps.

        Parameters
        ----------
        inputs : array_like, shape (n, 3)
            Means of the input over each sample.
        dt : float
            Sample time, s.
        rng : numpy.random.Generator
            Source of the random errors.
        specific_force : array_like, shape (n, 3), optional
            As in `expected`.

        Raises
        ------
        ValueError
            As `expected`.
        """
        return self.readings_along(self._along(inputs), dt, rng, self._without_input(specific_force))

    def readings_along(
        self,
        along: NDArray[np.float64],
        dt: float,
        rng: np.random.Generator | None,
        without_input: ArrayLike | None = None,
    ) -> NDArray[np.float64]:
        """Mean readings over samples from what acts along each sensor's own axis, after its delay.

        Parameters
        ----------
        along : ndarray, shape (n, 3)
            Means over each sample of the input along the axis of each sensor.
        dt : float
            Sample time, s.
        rng : numpy.random.Generator or None
            Source of the random errors; None only if there are none.
        without_input : array_like, shape (n, 3) or (3,), optional
            What is read without input: the biases, and what the specific force makes in acceleration-sensitive gyros.
            The biases alone by default.
        """
        noise = 0.0
        if self.random != RandomErrors():
            noise = simulate(self.random, len(along), dt, rng, channels=3)
        read = self._read(along, self.triad.bias if without_input is None else without_input, noise)
        return quantize(read, dt, self.pulse) if self.pulse else read

    def _along(self, inputs: ArrayLike) -> NDArray[np.float64]:
        """Inputs along the sensors' axes, at the same time as the readings."""
        if any(self.delay):
            raise ValueError(
                f"`delay` must be 0 for readings of given inputs, as on a plate, got {self.delay} s. "
                "`fogkit.stand.turn_recordings` records a motion with delays."
            )
        return checks.finite_array("inputs", inputs, shape=(..., 3)) @ self.triad.cosines.T

    def _without_input(self, specific_force: ArrayLike | None) -> NDArray[np.float64]:
        """Biases, and what the specific force makes."""
        return self.triad.readings(np.zeros(3), specific_force)

    def _read(
        self, along: NDArray[np.float64], without_input: ArrayLike, noise: NDArray[np.float64] | float
    ) -> NDArray[np.float64]:
        """Readings without steps, with noise in units of the input."""
        seen = self.shape.apply(along) + noise
        if np.isfinite(self.range):  # noise does not pass the end of the range either
            seen = np.clip(seen, *self.shape.apply(np.array([[-self.range] * 3, [self.range] * 3])))
        return np.asarray(without_input) + self.triad.equivalents * seen


@dataclass(frozen=True, kw_only=True)
class MeasurementUnit:
    """Three gyros and three accelerometers in one case.

    Parameters
    ----------
    gyros, accelerometers : Sensors, optional
        Ideal ones by default.
    size_effect : SizeEffect, optional
        Centres of the accelerometers; by default all in one point.
    """

    gyros: Sensors = field(default_factory=Sensors)
    accelerometers: Sensors = field(default_factory=Sensors)
    size_effect: SizeEffect = field(default_factory=SizeEffect)

    def __post_init__(self) -> None:
        for name in ("gyros", "accelerometers"):
            checks.instance(name, getattr(self, name), Sensors)
        checks.instance("size_effect", self.size_effect, SizeEffect)

    def require_point(self, where: str) -> None:
        """``ValueError`` if the unit has delays or a size effect, which a recording of means, named, cannot show."""
        delays = {name: getattr(self, name).delay for name in ("gyros", "accelerometers")}
        if not self.size_effect.is_zero or any(map(any, delays.values())):
            raise ValueError(
                f"`unit` must have no delay and no size effect for {where}, got delays {delays} s and "
                f"{self.size_effect}. `fogkit.stand.turn_recordings` records a motion with both."
            )
