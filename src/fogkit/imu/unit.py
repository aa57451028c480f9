"""A measurement unit as a source of readings: linear part, shape of the scale factors, random errors, range, pulses."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.imu.triads import LinearTriad
from fogkit.noise.processes import RandomErrors, quantize, simulate


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
    """

    triad: LinearTriad = field(default_factory=LinearTriad)
    shape: Shape = field(default_factory=Shape)
    random: RandomErrors = field(default_factory=RandomErrors)
    range: float = np.inf
    pulse: float = 0.0

    def __post_init__(self) -> None:
        for name, kind in (("triad", LinearTriad), ("shape", Shape), ("random", RandomErrors)):
            checks.instance(name, getattr(self, name), kind)
        if not self.range > 0:
            raise ValueError(f"`range` must be > 0, in units of the input, got {self.range}")
        checks.non_negative("pulse", self.pulse)

    def expected(self, inputs: ArrayLike, specific_force: ArrayLike | None = None) -> NDArray[np.float64]:
        """Readings without random errors and steps, shape (..., 3).

        Parameters
        ----------
        inputs : array_like, shape (..., 3)
            Rate, rad/s, or specific force, m/s^2, along the axes of the case.
        specific_force : array_like, shape (..., 3), optional
            What acts on acceleration-sensitive gyros, m/s^2.
        """
        return self._read(inputs, specific_force, noise=0.0)

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
        """
        noise = 0.0
        if self.random != RandomErrors():
            noise = simulate(self.random, len(np.asarray(inputs)), dt, rng, channels=3)
        read = self._read(inputs, specific_force, noise)
        return quantize(read, dt, self.pulse) if self.pulse else read

    def _read(
        self, inputs: ArrayLike, specific_force: ArrayLike | None, noise: NDArray[np.float64] | float
    ) -> NDArray[np.float64]:
        """Readings without steps, with noise in units of the input."""
        triad = self.triad
        along = checks.finite_array("inputs", inputs, shape=(..., 3)) @ triad.cosines.T
        seen = self.shape.apply(along) + noise
        if np.isfinite(self.range):  # noise does not pass the end of the range either
            seen = np.clip(seen, *self.shape.apply(np.array([[-self.range] * 3, [self.range] * 3])))
        return triad.readings(np.zeros(3), specific_force) + triad.equivalents * seen


@dataclass(frozen=True, kw_only=True)
class MeasurementUnit:
    """Three gyros and three accelerometers in one case.

    Parameters
    ----------
    gyros, accelerometers : Sensors, optional
        Ideal ones by default.
    """

    gyros: Sensors = field(default_factory=Sensors)
    accelerometers: Sensors = field(default_factory=Sensors)

    def __post_init__(self) -> None:
        for name in ("gyros", "accelerometers"):
            checks.instance(name, getattr(self, name), Sensors)
