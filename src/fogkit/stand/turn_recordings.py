"""What a unit records while a turntable carries out a plan of dwells and turns: tables of raw increments.

The part without noise is exact for the motion and costs most; `exact_inputs` computes it once, and `ExactInputs.record`
adds new random errors as often as wanted.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.imu.tables import IMU_COLUMNS
from fogkit.imu.unit import MeasurementUnit, Sensors
from fogkit.noise.processes import RandomErrors
from fogkit.stand.turn_motion import TurnMotion

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ExactInputs:
    """What acts on the sensors of a unit in each step of its tests, free of noise.

    Attributes
    ----------
    unit : MeasurementUnit
        The unit.
    dt : float
        Duration of a step, s.
    gyros, accelerometers : tuple of ndarray, shape (n, 3)
        Of each test: mean over the step of the rate, rad/s, and of the specific force, m/s^2, along the axis of each
        sensor, after its delay and with the size effect.
    gyros_without_input : tuple of ndarray, shape (n, 3), or (3,)
        Of each test: what the gyros read without rate, their biases and what the specific force makes.
    """

    unit: MeasurementUnit
    dt: float
    gyros: tuple[Array, ...]
    accelerometers: tuple[Array, ...]
    gyros_without_input: tuple[Array, ...]

    def arrays(self, rng: np.random.Generator | None) -> list[Array]:
        """Increments of each test with new random errors, arrays of shape (n, 6), columns `IMU_COLUMNS`.

        Parameters
        ----------
        rng : numpy.random.Generator or None
            Source of the random errors, which begin anew in each test; None only if the unit has none.
        """
        _require_source(self.unit, rng)
        recorded = []
        for rates, forces, zero in zip(self.gyros, self.accelerometers, self.gyros_without_input, strict=True):
            sums = np.empty((len(rates), 6), order="F")  # column by column, as pandas stores it
            sums[:, :3] = self.unit.gyros.readings_along(rates, self.dt, rng, zero)
            sums[:, 3:] = self.unit.accelerometers.readings_along(forces, self.dt, rng)
            sums *= self.dt
            recorded.append(sums)
        return recorded

    def record(self, rng: np.random.Generator | None) -> "list[DataFrame]":
        """The same as tables: index ``time``, s from the beginning of the test, columns `IMU_COLUMNS`."""
        import pandas as pd

        tables = []
        for sums in self.arrays(rng):
            time = pd.Index(np.arange(len(sums)) * self.dt, name="time")
            tables.append(pd.DataFrame(sums, index=time, columns=list(IMU_COLUMNS), copy=False))
        return tables


def exact_inputs(unit: MeasurementUnit, motions: Sequence[TurnMotion], rate: float = 100.0) -> ExactInputs:
    """What acts on the sensors of a unit in each step of its tests.

    Parameters
    ----------
    unit : MeasurementUnit
        The unit, delays and size effect included.
    motions : sequence of TurnMotion
        Motions of the tests, in the order of the plan.
    rate : float, optional
        Steps per second.

    Returns
    -------
    ExactInputs
        From which `ExactInputs.record` makes recordings.

    Raises
    ------
    ValueError
        If there is no motion, or a test does not hold a whole number of steps.

    Notes
    -----
    Asymmetry, nonlinearity and range act on the mean over a step, as pulses and noise do. A delay shifts the limits of
    a step's integral, so sensors of different delay read different intervals of the same motion.
    """
    checks.instance("unit", unit, MeasurementUnit)
    if isinstance(motions, TurnMotion) or not len(motions):
        raise ValueError("`motions` must be at least one motion of a test, in a sequence")
    for motion in motions:
        checks.instance("motions", motion, TurnMotion)
    dt = 1 / checks.positive("rate", rate, "Hz")
    parts = [_inputs(unit, motion, rate) for motion in motions]
    return ExactInputs(unit, dt, *(tuple(part) for part in zip(*parts, strict=True)))


def record(
    unit: MeasurementUnit,
    motions: Sequence[TurnMotion],
    rate: float = 100.0,
    *,
    rng: np.random.Generator | None = None,
) -> "list[DataFrame]":
    """Raw increments of a unit in each test of a plan.

    Parameters
    ----------
    unit, motions, rate
        As for `exact_inputs`.
    rng : numpy.random.Generator, optional
        Source of the random errors, which begin anew in each test; may be left out if the unit has none.

    Returns
    -------
    list of DataFrame
        One table for each test: index ``time``, s, the beginning of each step, from 0; columns ``gyro_x`` to
        ``accel_z``: the readings times the step, in units of the reading times s (rad and m/s for scale factors of 1).

    Raises
    ------
    ValueError
        As `exact_inputs`, or if a unit with random errors gets no `rng`.
    """
    _require_source(unit, rng)
    return exact_inputs(unit, motions, rate).record(rng)


def _require_source(unit: MeasurementUnit, rng: np.random.Generator | None) -> None:
    """``ValueError`` if there is nothing to draw the unit's random errors from."""
    if rng is not None:
        checks.generator("rng", rng)
    elif checks.instance("unit", unit, MeasurementUnit).gyros.random != RandomErrors() or (
        unit.accelerometers.random != RandomErrors()
    ):
        raise ValueError(
            "`rng` must be given for a unit with random errors. Make one with `np.random.default_rng(seed)`."
        )


def _inputs(unit: MeasurementUnit, motion: TurnMotion, rate: float) -> tuple[Array, Array, Array]:
    """Of one test: inputs along gyros and along accelerometers, and readings of the gyros without rate."""
    size, triad = unit.size_effect, unit.gyros.triad
    products = not size.is_zero
    by_delay = {
        delay: motion.increments(rate, delay, products=products) * rate
        for delay in {*unit.gyros.delay, *unit.accelerometers.delay}
    }
    gyros = _along(unit.gyros, [by_delay[delay][:, :3] for delay in unit.gyros.delay])
    forces = [by_delay[delay][:, 3:6] for delay in unit.accelerometers.delay]
    if products:
        forces = [
            force + _added(size, by_delay[delay], i)
            for i, (force, delay) in enumerate(zip(forces, unit.accelerometers.delay, strict=True))
        ]
    without = np.array(triad.bias)
    if np.any(triad.acceleration_sensitivity):
        felt = [by_delay[delay][:, 3:6] for delay in unit.gyros.delay]
        without = without + np.stack(
            [force @ row for force, row in zip(felt, np.array(triad.acceleration_sensitivity), strict=True)], axis=-1
        )
    return gyros, _along(unit.accelerometers, forces), without


def _along(sensors: Sensors, vectors: list[Array]) -> Array:
    """Component of each sensor's own input vectors along its axis, shape (n, 3)."""
    return np.stack([vector @ axis for vector, axis in zip(vectors, sensors.triad.cosines, strict=True)], axis=-1)


def _added(size, means: Array, sensor: int) -> Array:
    """What an accelerometer feels more than the reference point, shape (n, 3), from means over the steps."""
    xx, yy, zz, xy, xz, yz = means[:, 6:12].T
    matrices = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=-1).reshape(-1, 3, 3)
    return size.added_force(means[:, 12:], matrices)[:, sensor]
