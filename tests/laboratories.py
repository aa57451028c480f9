"""Units and places of several calibration tests, and what they do with them."""

from dataclasses import replace

import numpy as np

from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors
from fogkit.noise.processes import RandomErrors
from fogkit.stand.laboratory import Laboratory
from fogkit.stand.means import observations
from fogkit.units import ARCMIN, ARCSEC, DEG, DEG_PER_HOUR, DEG_PER_SQRT_HOUR, MICRO_G, MILLI_G

GYRO_PULSES = 1 / (0.5 * ARCSEC)  # per rad
ACCEL_PULSES = 1e4  # per m/s
WHITE = (
    RandomErrors(angle_random_walk=0.003 * DEG_PER_SQRT_HOUR),
    RandomErrors(angle_random_walk=30 * MICRO_G),  # per sqrt(Hz), which is m/s/sqrt(s)
)
GYROS = LinearTriad.from_standard(
    scale_factor=GYRO_PULSES * np.array([1.0003, 0.9996, 1.0001]),
    input_bias=np.array([0.12, -0.07, 0.2]) * DEG_PER_HOUR,
    misalignment=np.array([[0, 3, -2], [4, 0, 1], [-5, 2, 0]]) * ARCMIN,
)
ACCELEROMETERS = LinearTriad.from_standard(
    scale_factor=ACCEL_PULSES * np.array([0.9991, 1.0012, 1.0004]),
    input_bias=np.array([1.5, -2.0, 0.7]) * MILLI_G,
    misalignment=np.array([[0, -6, 2], [1, 0, 3], [4, -3, 0]]) * ARCMIN,
)
EXACT = MeasurementUnit(gyros=Sensors(triad=GYROS), accelerometers=Sensors(triad=ACCELEROMETERS))
NOISY = MeasurementUnit(
    gyros=Sensors(triad=GYROS, random=WHITE[0]), accelerometers=Sensors(triad=ACCELEROMETERS, random=WHITE[1])
)
EQUIVALENTS = (GYRO_PULSES,) * 3 + (ACCEL_PULSES,) * 3
LABORATORY = Laboratory(latitude=40 * DEG)
CROOKED = Laboratory(
    latitude=40 * DEG,
    level_east=2e-3,
    level_north=-3e-3,
    azimuth_error=0.3,
    faces=np.arange(-9, 9).reshape(6, 3) * 1e-4,
    mounting=(1e-3, -2e-3, 1.5e-3),
)


def aligned(triad):
    """The same sensors without misalignment."""
    return LinearTriad.from_standard(scale_factor=triad.scale_factor, input_bias=triad.input_bias)


def measured(unit, schedule, laboratory=LABORATORY, *, believed=None, seed=0, random=None, sample_rate=10.0):
    """Mean readings of a recording, with the inputs that are believed."""
    recording = laboratory.record(unit, schedule, np.random.default_rng(seed), sample_rate=sample_rate)
    return observations(recording, schedule, believed or laboratory, random=random, equivalents=EQUIVALENTS)


def scattered(observed, rng):
    """The same observations with other errors, drawn from their covariance."""
    roots = np.linalg.cholesky(observed.covariance)
    errors = np.einsum("cij,cj->ic", roots, rng.standard_normal(roots.shape[:2]))
    return replace(observed, readings=observed.readings + errors)


def random_triad(rng, size, relative_bias, sensitivity=0.0):
    """Sensors with scale factors of some size, either sign, misaligned by up to 0.1 rad."""
    scale = size * rng.choice([-1, 1], 3) * rng.uniform(0.5, 2, 3)
    misalignment = rng.uniform(-0.1, 0.1, (3, 3)) * (1 - np.eye(3))
    return LinearTriad.from_standard(
        scale_factor=scale,
        input_bias=relative_bias * rng.uniform(-1, 1, 3),
        misalignment=misalignment,
        acceleration_sensitivity=sensitivity * size * rng.uniform(-1, 1, (3, 3)),
    )
