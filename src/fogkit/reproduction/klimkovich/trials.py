"""Simulated calibrations: a unit with errors, a rough table, the nine tests, the paper's method on the recordings.

The paper gives neither the errors of its unit nor those of its table. Taken here: errors of both matrices of 3e-4 (1
arcmin, 300 ppm), accelerometer biases of 5e-3 m/s^2, all standard deviations drawn from the seed; a table by
`RoughTable.typical`, its roughness 1 being a few tenths of a degree with wobble and shock absorbers; dwells of 10 s and
turns of 15 s; Minsk.
"""

import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.calibration.navigation_based import Compensation, NavigationCalibration, calibrate, differences
from fogkit.earth import normal_gravity
from fogkit.imu.size_effect import SizeEffect
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors
from fogkit.noise.processes import RandomErrors
from fogkit.reproduction.klimkovich import paper
from fogkit.reproduction.klimkovich.estimates import LATITUDE
from fogkit.stand.rough_table import RoughTable
from fogkit.stand.turn_motion import TurnMotion
from fogkit.stand.turn_recordings import record
from fogkit.stand.turn_tests import TurnTest, nine_tests
from fogkit.units import ARCSEC, DEG_PER_SQRT_HOUR, MICRO_G_PER_SQRT_HZ, PPM

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

GRAVITY = float(normal_gravity(LATITUDE))

ANGLE_RANDOM_WALK = 0.002 * DEG_PER_SQRT_HOUR
VELOCITY_RANDOM_WALK = 20 * MICRO_G_PER_SQRT_HZ
"""Random errors of a noisy trial, rad/sqrt(s) and m/s/sqrt(s): a navigation-grade unit."""

MATRICES = ("actual", "model", "printed")
"""Measurement matrices that are compared: of the actual rotations; of the plan; of the appendix with its misprints."""

ATTITUDES = ("model", "true", "levelled", "carried")
"""Attitudes at the start: the plan's, the true ones, levelled by the first dwell, the heading carried on besides."""

QUANTITIES = {
    "gyro_angle_arcsec": ("m_g", False, ARCSEC),
    "gyro_scale_ppm": ("m_g", True, PPM),
    "accelerometer_angle_arcsec": ("m_a", False, ARCSEC),
    "accelerometer_scale_ppm": ("m_a", True, PPM),
}
"""What `largest` gives, with the bias of the accelerometers, ``accelerometer_bias_um_s2``, besides."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Trial:
    """One simulated calibration, up to the recordings.

    Parameters
    ----------
    seed : int, optional
        Of the unit's errors, of the table's and of the noise, which are drawn apart.
    roughness : float, optional
        Of the table, `RoughTable.typical`.
    error : float, optional
        Standard deviation of each element of both matrices.
    accelerometer_bias : float, optional
        Standard deviation of the biases, m/s^2.
    gyro_bias : array_like, shape (3,), optional
        Biases of the gyros, rad/s.
    noisy : bool, optional
        Whether the sensors have angle and velocity random walk.
    size_effect : SizeEffect, optional
        Centres of the accelerometers.
    gyro_delay, accelerometer_delay : array_like, shape (3,), optional
        Delays, s.
    table : mapping, optional
        Arguments of `RoughTable` to be set otherwise.
    rate : float, optional
        Samples per second.
    plan : sequence of TurnTest, optional
        Tests; the paper's nine by default.
    """

    seed: int = 1
    roughness: float = 1.0
    error: float = 3e-4
    accelerometer_bias: float = 5e-3
    gyro_bias: ArrayLike = (0.0, 0.0, 0.0)
    noisy: bool = False
    size_effect: SizeEffect = field(default_factory=SizeEffect)
    gyro_delay: ArrayLike = (0.0, 0.0, 0.0)
    accelerometer_delay: ArrayLike = (0.0, 0.0, 0.0)
    table: Mapping[str, Any] = field(default_factory=dict)
    rate: float = 100.0
    plan: tuple[TurnTest, ...] = field(default_factory=nine_tests)

    @cached_property
    def unit(self) -> MeasurementUnit:
        """The unit with its errors."""
        rng = np.random.default_rng([self.seed, 1])
        gyros, accelerometers = np.eye(3) + self.error * rng.standard_normal((2, 3, 3))
        bias = self.accelerometer_bias * rng.standard_normal(3)
        walks = (ANGLE_RANDOM_WALK, VELOCITY_RANDOM_WALK) if self.noisy else (0.0, 0.0)
        return MeasurementUnit(
            gyros=Sensors(
                triad=LinearTriad(matrix=gyros, bias=self.gyro_bias),
                random=RandomErrors(angle_random_walk=walks[0]),
                delay=self.gyro_delay,
            ),
            accelerometers=Sensors(
                triad=LinearTriad(matrix=accelerometers, bias=bias),
                random=RandomErrors(angle_random_walk=walks[1]),
                delay=self.accelerometer_delay,
            ),
            size_effect=self.size_effect,
        )

    @cached_property
    def motions(self) -> tuple[TurnMotion, ...]:
        """What the table does."""
        table = RoughTable.typical(LATITUDE, self.roughness, **self.table)
        return table.motions(self.plan, np.random.default_rng([self.seed, 2]))

    @cached_property
    def recordings(self) -> "list[DataFrame]":
        """What the unit reads."""
        return record(self.unit, self.motions, self.rate, rng=np.random.default_rng([self.seed, 3]))

    @cached_property
    def truth(self) -> Compensation:
        """The compensation that would be perfect."""
        return Compensation.from_unit(self.unit)

    @cached_property
    def C_case_b(self) -> Array:
        """From the axes in which the unit was made to those that the calibration names by its three zeros."""
        return self.truth.gauged().gyro_matrix @ np.linalg.inv(self.truth.gyro_matrix)

    @cached_property
    def starts(self) -> Array:
        """True attitudes of these axes at the start of the tests, shape (tests, 3, 3)."""
        return np.stack([motion.C_b_n(0.0) for motion in self.motions]) @ self.C_case_b.T

    def calibrated(
        self, matrix: str = "actual", *, attitude: str = "model", iterations: int = paper.ITERATIONS, **options
    ) -> NavigationCalibration:
        """Calibrate by the recordings.

        Parameters
        ----------
        matrix : str, optional
            One of `MATRICES`.
        attitude : {"model", "true", "levelled", "carried"}, optional
            That at the start of each test.
        iterations : int, optional
            Number of iterations.
        **options
            Of `fogkit.calibration.navigation_based.calibrate`. Steps are not shortened unless `step_control` is set.
            Without noise all measurements weigh alike: the weights (24) would be ratios of what rings after a turn.

        Raises
        ------
        RuntimeError
            If the iteration diverges.
        """
        checks.option("matrix", matrix, MATRICES)
        checks.option("attitude", attitude, ATTITUDES)
        usual = {"step_control": False, "noise": None if self.noisy else np.eye(2 * len(self.plan))}
        with _expected_warnings():
            return calibrate(
                self.recordings,
                self.plan,
                LATITUDE,
                matrix=paper.printed_matrix(GRAVITY) if matrix == "printed" else matrix,
                initial_attitude=self.starts if attitude == "true" else attitude,
                iterations=iterations,
                **usual | options,
            )

    def errors(self, compensation: Compensation) -> dict[str, float]:
        """Largest true errors of a compensation, without a common rotation: see `largest`."""
        return largest(differences(compensation, self.truth))


@contextmanager
def _expected_warnings() -> Iterator[None]:
    """No word of what a trial looks into on purpose: an iteration cut short, a unit that still rings."""
    with warnings.catch_warnings():
        for words in ("the last of", ".*(at rest|rings|moves)"):
            warnings.filterwarnings("ignore", words, UserWarning)
        yield


def largest(errors: Mapping[str, float]) -> dict[str, float]:
    """Largest errors of each kind, arcsec, ppm and um/s^2.

    Parameters
    ----------
    errors : mapping
        As `fogkit.calibration.navigation_based.differences` returns them.

    Returns
    -------
    dict
        Keys of `QUANTITIES`, and ``accelerometer_bias_um_s2``.
    """
    found = {}
    for quantity, (prefix, diagonal, unit) in QUANTITIES.items():
        sizes = [abs(v) for n, v in errors.items() if n[:3] == prefix and (n[-1] == n[-2]) == diagonal]
        found[quantity] = max(sizes) / unit
    found["accelerometer_bias_um_s2"] = max(abs(errors[f"b_a_{i}"]) for i in (1, 2, 3)) / 1e-6
    return found
