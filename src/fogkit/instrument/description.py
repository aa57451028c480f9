"""A measurement unit of fibre-optic gyros in one record, and what vibration and temperature make of it.

Optics, loop and detector noise are those of `fogkit.optics`, the temperatures those of `fogkit.thermal`, the linear
errors, asymmetries and accelerometers those of `fogkit.imu`. Nothing is said twice: the white noise of the gyros comes
from the detector, their drift under vibration from the loop.
"""

from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.imu.errors import GyroTriad, misalignments_from_matrix
from fogkit.imu.unit import MeasurementUnit
from fogkit.optics.drift import vibration_drift
from fogkit.optics.gyro import ClosedLoopGyro
from fogkit.optics.measure import simulated_drift, windowed_mean
from fogkit.optics.motion import AngularOscillation
from fogkit.optics.simulate import run
from fogkit.thermal.experiment import CoilBias
from fogkit.thermal.network import ThermalNetwork, soak

Array = NDArray[np.float64]

FLOOR = float(np.sqrt(2 * np.log(2) / np.pi))
"""Floor of an Allan deviation over the coefficient of bias instability."""


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """Where a unit works: vibration of its case, and the air about it.

    Parameters
    ----------
    acceleration : array_like, shape (3,), optional
        Amplitude of a harmonic angular acceleration about each gyro's axis, rad/s^2.
    frequency : float, optional
        Its frequency, Hz.
    chamber : float, optional
        Temperature of the air, degC.
    powered : float, optional
        Time since the unit was switched on at that temperature, s; infinite, the default, once it has settled.

    Raises
    ------
    ValueError
        If a number is not finite (but for `powered`), the frequency not positive or the time negative.
    """

    acceleration: ArrayLike = field(default=(0.0, 0.0, 0.0))
    frequency: float = 60.0
    chamber: float = 25.0
    powered: float = np.inf

    def __post_init__(self) -> None:
        values = checks.finite_array("acceleration", self.acceleration, shape=(3,))
        object.__setattr__(self, "acceleration", tuple(values.tolist()))
        checks.positive("frequency", self.frequency, "Hz")
        checks.finite("chamber", self.chamber, "degC")
        if self.powered != np.inf:
            checks.non_negative("powered", self.powered, "s")


@dataclass(frozen=True, kw_only=True)
class Instrument:
    """Three gyros of one kind and three accelerometers.

    Parameters
    ----------
    gyro : ClosedLoopGyro
        Coil, loop and detector noise of each gyro.
    network : ThermalNetwork
        What warms what in the unit.
    thermal : CoilBias
        What temperatures and their rates do to the bias of a gyro; only its coefficients and reference count.
    thermal_share : array_like, shape (3,), optional
        Size of that effect in each gyro, over that of `thermal`.
    unit : MeasurementUnit, optional
        Linear errors, asymmetries, coloured noise of the gyros, and the accelerometers, all at rest, without vibration
        and without the effect of temperature. Gyro readings are in rad/s, about those of ideal gyros.

    Raises
    ------
    ValueError
        If the gyros of `unit` have white noise of their own, which is that of the detector here.
    """

    gyro: ClosedLoopGyro
    network: ThermalNetwork
    thermal: CoilBias
    thermal_share: ArrayLike = field(default=(1.0, 1.0, 1.0))
    unit: MeasurementUnit = field(default_factory=MeasurementUnit)

    def __post_init__(self) -> None:
        kinds = (
            ("gyro", ClosedLoopGyro),
            ("network", ThermalNetwork),
            ("thermal", CoilBias),
            ("unit", MeasurementUnit),
        )
        for name, kind in kinds:
            checks.instance(name, getattr(self, name), kind)
        share = checks.finite_array("thermal_share", self.thermal_share, shape=(3,))
        object.__setattr__(self, "thermal_share", tuple(share.tolist()))
        walk = self.unit.gyros.random.angle_random_walk
        if walk:
            raise ValueError(
                f"`unit.gyros.random.angle_random_walk` must be 0, got {walk:.4g} rad/sqrt(s): the white noise is that "
                "of the detector. Use `ClosedLoopGyro.with_angle_random_walk`"
            )

    @property
    def angle_random_walk(self) -> float:
        """Of each gyro, from its detector noise, rad/sqrt(s)."""
        return self.gyro.angle_random_walk

    def vibration_bias(self, conditions: Conditions, *, simulated: bool = True) -> Array:
        """What vibration adds to the mean readings of the gyros.

        Parameters
        ----------
        conditions : Conditions
            The vibration counts.
        simulated : bool, optional
            Whether the loop is simulated half-period by half-period, without detector noise, or the law of
            `fogkit.optics.drift.vibration_drift` taken.

        Returns
        -------
        ndarray, shape (3,)
            rad/s.
        """
        law = _simulated_drift if simulated else vibration_drift
        sizes = np.abs(conditions.acceleration).tolist()
        return np.array([float(law(self.gyro, size, conditions.frequency)) if size else 0.0 for size in sizes])

    def thermal_bias(self, conditions: Conditions, after: ArrayLike = 0.0) -> Array:
        """What temperatures and their rates add to the biases.

        Parameters
        ----------
        conditions : Conditions
            The air, and the time since switching on.
        after : array_like, shape (...,), optional
            Times after that, s.

        Returns
        -------
        ndarray, shape (..., 3)
            rad/s.
        """
        after = np.asarray(after, dtype=float)
        if conditions.powered == np.inf:
            temperatures = np.broadcast_to(
                self.network.steady_state(conditions.chamber), (*after.shape, len(self.network.nodes))
            )
            rates = np.zeros_like(temperatures)
        else:
            times, places = np.unique(conditions.powered + after.ravel(), return_inverse=True)
            solved = self.network.solve([-1.0, *times], soak(conditions.chamber), switch_on=0.0)
            temperatures, rates = (values[1:][places].reshape(*after.shape, -1) for values in solved)
        effect = self.thermal.truth(self.network.nodes, temperatures, rates) - self.thermal.constant
        return effect[..., np.newaxis] * np.array(self.thermal_share)

    def at(self, conditions: Conditions, *, simulated: bool = True) -> MeasurementUnit:
        """The unit under conditions: biases of vibration and temperature, and the white noise of the detector.

        Parameters are those of `vibration_bias`.
        """
        gyros = self.unit.gyros
        added = self.vibration_bias(conditions, simulated=simulated) + self.thermal_bias(conditions)
        triad = replace(gyros.triad, bias=np.array(gyros.triad.bias) + added)
        random = replace(gyros.random, angle_random_walk=self.angle_random_walk)
        return replace(self.unit, gyros=replace(gyros, triad=triad, random=random))


def loop_reading(
    gyro: ClosedLoopGyro,
    rate: float,
    conditions: Conditions,
    axis: int = 0,
    *,
    cycles: int = 24,
    rng: np.random.Generator | None = None,
) -> float:
    """Mean reading of a loop that turns steadily and is shaken meanwhile, simulated from the detector on.

    Parameters
    ----------
    gyro : ClosedLoopGyro
        The gyro, noise included.
    rate : float
        Steady rate along its axis, rad/s.
    conditions : Conditions
        Vibration.
    axis : int, optional
        Which of the three accelerations acts on it.
    cycles : int, optional
        Cycles of the vibration, at least 20.
    rng : numpy.random.Generator, optional
        Source of the detector's noise, needed if there is any.

    Returns
    -------
    float
        rad/s; mean under the window of `fogkit.optics.measure.windowed_mean`.
    """
    rate, size = checks.finite("rate", rate, "rad/s"), conditions.acceleration[axis]
    omega = 2 * np.pi * conditions.frequency
    cycles = checks.integer("cycles", cycles, minimum=20)
    record = run(gyro, lambda t: rate + size / omega * np.sin(omega * t), cycles / conditions.frequency, rng=rng)
    return windowed_mean(record.rate)


@lru_cache(maxsize=256)
def _simulated_drift(gyro: ClosedLoopGyro, size: float, frequency: float) -> float:
    """Drift by simulation without detector noise, rad/s; kept, since equal gyros are often shaken alike."""
    silent = replace(gyro, detector_noise=0.0, shot_noise=0.0, intensity_noise=0.0)
    return simulated_drift(silent, AngularOscillation(acceleration=size, frequency=frequency)).drift


def bench_triad(unit: MeasurementUnit) -> GyroTriad:
    """The gyros of a unit in the words of the three-axis bench.

    Parameters
    ----------
    unit : MeasurementUnit
        Its gyros count.

    Returns
    -------
    GyroTriad
        With scale factors in rad/s per unit of the reading, for either sign. Of bias instability each reading has the
        floor of the Allan deviation, drawn anew; random walk and ramp of the rate are left out.
    """
    gyros = unit.gyros
    equivalents, half = gyros.triad.equivalents, np.array(gyros.shape.asymmetry) / 2
    return GyroTriad(
        bias=gyros.triad.bias,
        scale_positive=1 / (equivalents * (1 + half)),
        scale_negative=1 / (equivalents * (1 - half)),
        misalignments=misalignments_from_matrix(gyros.triad.cosines),
        angle_random_walk=gyros.random.angle_random_walk,
        bias_instability=FLOOR * gyros.random.bias_instability,
    )
