"""Which unit is simulated, and what should its calibration find? Errors at random, of the size of a grade."""

from dataclasses import dataclass

import numpy as np

from fogkit.calibration.multiposition import parameter_names
from fogkit.calibration.navigation_based import Compensation
from fogkit.calibration.triad import PARAMETERS, parameters_of
from fogkit.cli.results import Estimates
from fogkit.imu.errors import GyroTriad
from fogkit.imu.triads import AXES, LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors
from fogkit.noise import RandomErrors
from fogkit.units import ARCMIN, DEG_PER_HOUR, DEG_PER_SQRT_HOUR, MICRO_G, MICRO_G_PER_SQRT_HZ, PPM


@dataclass(frozen=True, kw_only=True)
class Grade:
    """Standard deviations of the errors of a unit before its calibration, and its noise.

    Attributes
    ----------
    gyro_bias : float
        rad/s.
    accel_bias : float
        m/s^2.
    scale_factor : float
        Relative.
    misalignment : float
        rad.
    noise : RandomErrors
        Of the gyros.
    accel_noise : RandomErrors
        Of the accelerometers.
    """

    gyro_bias: float
    accel_bias: float
    scale_factor: float
    misalignment: float
    noise: RandomErrors
    accel_noise: RandomErrors


GRADES = {
    "navigation": Grade(
        gyro_bias=0.005 * DEG_PER_HOUR,
        accel_bias=500 * MICRO_G,
        scale_factor=300 * PPM,
        misalignment=1 * ARCMIN,
        noise=RandomErrors(angle_random_walk=0.0005 * DEG_PER_SQRT_HOUR),
        accel_noise=RandomErrors(angle_random_walk=2 * MICRO_G_PER_SQRT_HZ),
    ),
    "tactical": Grade(
        gyro_bias=1.0 * DEG_PER_HOUR,
        accel_bias=1000 * MICRO_G,
        scale_factor=500 * PPM,
        misalignment=3 * ARCMIN,
        noise=RandomErrors(angle_random_walk=0.01 * DEG_PER_SQRT_HOUR),
        accel_noise=RandomErrors(angle_random_walk=30 * MICRO_G_PER_SQRT_HZ),
    ),
}


def draw_unit(grade: Grade, rng: np.random.Generator) -> MeasurementUnit:
    """A unit of a grade."""

    def sensors(bias: float, noise: RandomErrors) -> Sensors:
        matrix = np.eye(3) + grade.misalignment * rng.standard_normal((3, 3)) * (1 - np.eye(3))
        matrix += np.diag(grade.scale_factor * rng.standard_normal(3))
        return Sensors(triad=LinearTriad(bias=bias * rng.standard_normal(3), matrix=matrix), random=noise)

    return MeasurementUnit(
        gyros=sensors(grade.gyro_bias, grade.noise), accelerometers=sensors(grade.accel_bias, grade.accel_noise)
    )


def draw_gyros(grade: Grade, rng: np.random.Generator) -> GyroTriad:
    """Gyros of a grade on a rate table, with scale factors that differ a little between the two signs."""
    mean = 1 + grade.scale_factor * rng.standard_normal(3)
    half = 0.02 * grade.scale_factor * rng.standard_normal(3)
    return GyroTriad(
        bias=grade.gyro_bias * rng.standard_normal(3),
        scale_positive=mean + half,
        scale_negative=mean - half,
        misalignments=grade.misalignment * rng.standard_normal(6),
        angle_random_walk=grade.noise.angle_random_walk,
    )


def linear_truth(unit: MeasurementUnit) -> Estimates:
    """What `calibrate multiposition` should find."""
    names, units, values = [], [], []
    for sensor, triad, bias_unit in (
        ("accel", unit.accelerometers.triad, "m/s^2"),
        ("gyro", unit.gyros.triad, "rad/s"),
    ):
        for i in range(3):
            names += [f"{sensor}.{name}" for name in parameter_names(i)]
            units += [bias_unit, "1", "1", "1"]
            values += [triad.bias[i], *triad.matrix[i]]
    return Estimates(names=names, units=units, values=values)


def standard_truth(unit: MeasurementUnit) -> Estimates:
    """What `calibrate rate-sequence` should find, apart from terms, which this unit has not."""
    triad, names, units, values = unit.gyros.triad, [], [], []
    for i, axis in enumerate(AXES):
        names += [f"gyro.scale_factor_{axis}", f"gyro.input_bias_{axis}"]
        units += ["1", "rad/s"]
        values += [triad.scale_factor[i], triad.input_bias[i]]
    for i, j in ((i, j) for i in range(3) for j in range(3) if i != j):
        names.append(f"gyro.misalignment_{AXES[i]}{AXES[j]}")
        units.append("rad")
        values.append(triad.misalignment[i][j])
    return Estimates(names=names, units=units, values=values)


def compensation_truth(unit: MeasurementUnit) -> Estimates:
    """What `calibrate navigation` should find, in the axes in which three elements of the accelerometers are zero."""
    exact = Compensation.from_unit(unit).gauged()
    names, units, values = [], [], []
    for letter, kind in (("a", "accelerometer"), ("g", "gyro")):
        matrix, bias = getattr(exact, f"{kind}_matrix"), getattr(exact, f"{kind}_bias")
        for i in range(3):
            for j in range(3):
                names.append(f"M_{letter}_{i + 1}{j + 1}")
                units.append("1")
                values.append(matrix[i, j])
            if letter == "a":
                names.append(f"B_a_{i + 1}")
                units.append("m/s^2")
                values.append(bias[i])
    return Estimates(names=names, units=units, values=values)


def triad_truth(triad: GyroTriad) -> Estimates:
    """What `calibrate three-stage` should find."""
    units = ["rad/s"] * 3 + ["1"] * 6 + ["rad"] * 6
    return Estimates(names=[f"gyro.{name}" for name in PARAMETERS], units=units, values=parameters_of(triad))


def noise_truth(grade: Grade) -> Estimates:
    """What `allan` should find: the white noise."""
    walk = grade.noise.angle_random_walk
    names = [f"gyro_{axis}.angle_random_walk" for axis in AXES]
    return Estimates(names=names, units=["rad/sqrt(s)"] * 3, values=[walk] * 3)
