"""Three grades of units as examples, and one unit of a grade as it comes out.

The numbers are of the size that data sheets of such units have; they are chosen here and taken from no paper.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from fogkit import checks
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors, Shape
from fogkit.instrument.description import Instrument
from fogkit.noise.processes import RandomErrors
from fogkit.optics.coil import Coil
from fogkit.optics.gyro import ClosedLoopGyro
from fogkit.optics.loop import Loop
from fogkit.thermal.experiment import CoilBias, in_unit, shupe_coefficient
from fogkit.thermal.network import ThermalNetwork
from fogkit.units import DEG_PER_HOUR, DEG_PER_SQRT_HOUR, MICRO_G, MICRO_G_PER_SQRT_HZ, MINUTE, PPM

HALF_PERIODS = 16
DEPTH = 3 * np.pi / 4


@dataclass(frozen=True, kw_only=True)
class Grade:
    """What a data sheet says: standard deviations of what is constant in a unit and differs from one to the next.

    Parameters
    ----------
    name : str
        Of the grade.
    gyro : ClosedLoopGyro
        Coil, loop, detector noise.
    bias, repeatability : float
        Of a gyro, rad/s: as built, and from one switching on to the next.
    bias_instability : float
        Coefficient of flicker noise, rad/s.
    scale_factor, asymmetry : float
        Of a gyro, 1.
    misalignment : float
        Of each sensor towards each other axis, rad.
    thermal : CoilBias
        Effect of temperature on a gyro of mean size; the size differs by `thermal_spread`.
    accelerometer_bias, accelerometer_scale : float
        m/s^2 and 1.
    velocity_random_walk : float
        m/s/sqrt(s).
    thermal_spread : float, optional
        1.
    network : ThermalNetwork, optional
        Of the unit.
    """

    name: str
    gyro: ClosedLoopGyro
    bias: float
    repeatability: float
    bias_instability: float
    scale_factor: float
    asymmetry: float
    misalignment: float
    thermal: CoilBias
    accelerometer_bias: float
    accelerometer_scale: float
    velocity_random_walk: float
    thermal_spread: float = 0.3
    network: ThermalNetwork = field(default_factory=in_unit)

    def draw(self, rng: np.random.Generator) -> Instrument:
        """One unit of the grade."""
        checks.generator("rng", rng)
        normal = rng.standard_normal
        gyros = Sensors(
            triad=self._triad(self.scale_factor * normal(3), self.bias * normal(3), normal((3, 3))),
            shape=Shape(asymmetry=self.asymmetry * normal(3)),
            random=RandomErrors(bias_instability=self.bias_instability),
        )
        accelerometers = Sensors(
            triad=self._triad(
                self.accelerometer_scale * normal(3), self.accelerometer_bias * normal(3), normal((3, 3))
            ),
            random=RandomErrors(angle_random_walk=self.velocity_random_walk),
        )
        return Instrument(
            gyro=self.gyro,
            network=self.network,
            thermal=self.thermal,
            thermal_share=1 + self.thermal_spread * normal(3),
            unit=MeasurementUnit(gyros=gyros, accelerometers=accelerometers),
        )

    def _triad(self, scale, bias, across) -> LinearTriad:
        """Sensors with given scale factor errors, biases as inputs, and directions drawn, shape (3, 3)."""
        misalignment = self.misalignment * across * (1 - np.eye(3))
        return LinearTriad.from_standard(scale_factor=1 + scale, input_bias=bias, misalignment=misalignment)


def loop_gyro(length: float, diameter: float, angle_random_walk: float) -> ClosedLoopGyro:
    """Gyro modulated at its proper frequency with 16 half-periods to a regulation period, the paper's bias order.

    Parameters
    ----------
    length, diameter : float
        Of the coil, m.
    angle_random_walk : float
        That its detector noise makes, rad/sqrt(s).
    """
    coil = Coil(length=length, diameter=diameter)
    loop = Loop(depth=DEPTH, half_period=coil.transit_time, half_periods=HALF_PERIODS)
    return ClosedLoopGyro(coil=coil, loop=loop).with_angle_random_walk(angle_random_walk)


def coil_bias(coil: Coil, share: float, per_kelvin: float) -> CoilBias:
    """Effect of temperature on a gyro: by rate what a winding leaves of Shupe's effect, by temperature as said.

    Parameters
    ----------
    coil : Coil
        The coil.
    share : float
        What the winding leaves of Shupe's effect.
    per_kelvin : float
        Bias per K of the coil, rad/s, and of the electronics, with the other sign.
    """
    shupe = shupe_coefficient(coil, share=share)
    return CoilBias(
        temperature={"coil_top": per_kelvin, "coil_bottom": per_kelvin, "electronics": -per_kelvin},
        rate={"coil_top": shupe, "coil_bottom": -shupe, "electronics": 10 * per_kelvin * MINUTE},
    )


def _low() -> Grade:
    gyro = loop_gyro(200.0, 0.05, 0.05 * DEG_PER_SQRT_HOUR)
    return Grade(
        name="low",
        gyro=gyro,
        bias=5 * DEG_PER_HOUR,
        repeatability=0.5 * DEG_PER_HOUR,
        bias_instability=0.3 * DEG_PER_HOUR,
        scale_factor=1000 * PPM,
        asymmetry=50 * PPM,
        misalignment=1e-3,
        thermal=coil_bias(gyro.coil, 0.01, 0.1 * DEG_PER_HOUR),
        accelerometer_bias=2000 * MICRO_G,
        accelerometer_scale=1000 * PPM,
        velocity_random_walk=100 * MICRO_G_PER_SQRT_HZ,
    )


def _middle() -> Grade:
    gyro = loop_gyro(500.0, 0.08, 0.008 * DEG_PER_SQRT_HOUR)
    return Grade(
        name="middle",
        gyro=gyro,
        bias=1 * DEG_PER_HOUR,
        repeatability=0.03 * DEG_PER_HOUR,
        bias_instability=0.03 * DEG_PER_HOUR,
        scale_factor=300 * PPM,
        asymmetry=10 * PPM,
        misalignment=5e-4,
        thermal=coil_bias(gyro.coil, 0.004, 0.02 * DEG_PER_HOUR),
        accelerometer_bias=500 * MICRO_G,
        accelerometer_scale=300 * PPM,
        velocity_random_walk=30 * MICRO_G_PER_SQRT_HZ,
    )


def _high() -> Grade:
    gyro = loop_gyro(1000.0, 0.1, 0.001 * DEG_PER_SQRT_HOUR)
    return replace(
        _middle(),
        name="high",
        gyro=gyro,
        bias=0.3 * DEG_PER_HOUR,
        repeatability=0.003 * DEG_PER_HOUR,
        bias_instability=0.003 * DEG_PER_HOUR,
        scale_factor=100 * PPM,
        asymmetry=3 * PPM,
        misalignment=2e-4,
        thermal=coil_bias(gyro.coil, 0.002, 0.004 * DEG_PER_HOUR),
        accelerometer_bias=100 * MICRO_G,
        accelerometer_scale=100 * PPM,
        velocity_random_walk=10 * MICRO_G_PER_SQRT_HZ,
    )


GRADES = {grade.name: grade for grade in (_low(), _middle(), _high())}
"""The examples."""
