"""What a calibration leaves of each error, once the unit works elsewhere than where it was calibrated.

Compensated readings are ``(I + E) u + b`` of the true input u. The common rotation of all axes, which is a mark on the
case and no error of the sensors, is taken out of E of both triads and kept apart as the boresight.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.instrument.description import Conditions, Instrument
from fogkit.instrument.methods import Calibrated
from fogkit.instrument.temperature import modelled_bias
from fogkit.results import FrozenArrays
from fogkit.rotation import orthonormalise
from fogkit.thermal.experiment import CoilBias

Array = NDArray[np.float64]

BIASES = ("calibration", "vibration", "temperature", "repeatability")
PARTS = (*BIASES, "scale factor", "asymmetry", "misalignment", "accelerometers")
"""Bias that the method got wrong; bias that vibration and temperature make here and did not make there; bias that is
another one after switching on again; what is left of the gyros' scale factors, asymmetries and directions; and of all
of the accelerometers."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ErrorsLeft(FrozenArrays):
    """Errors of compensated readings.

    Attributes
    ----------
    biases : mapping of str to ndarray, shape (3,)
        Of the gyros, by `BIASES`, rad/s.
    bias_slope : ndarray, shape (3,)
        Change of the part "temperature" with time, rad/s^2; `biases` hold the mean over the measurement.
    matrix : ndarray, shape (3, 3)
        E of the gyros, symmetric.
    asymmetry : ndarray, shape (3,)
        Of the gyros' scale factors.
    accelerometer_matrix : ndarray, shape (3, 3)
        E of the accelerometers.
    accelerometer_bias : ndarray, shape (3,)
        m/s^2.
    boresight : ndarray, shape (3,)
        Rotation vector from the axes of the case to those in which the compensated gyros read, rad.
    """

    biases: Mapping[str, Array]
    bias_slope: Array
    matrix: Array
    asymmetry: Array
    accelerometer_matrix: Array
    accelerometer_bias: Array
    boresight: Array

    @property
    def bias(self) -> Array:
        """Sum of the parts, rad/s, shape (3,)."""
        return np.sum(list(self.biases.values()), axis=0)

    def only(self, part: str) -> Self:
        """The same with one of `PARTS` alone."""
        checks.option("part", part, PARTS)
        still, own = np.zeros((3, 3)), np.diag(np.diag(self.matrix))
        accelerometers = part == "accelerometers"
        return replace(
            self,
            biases={name: value * (name == part) for name, value in self.biases.items()},
            bias_slope=self.bias_slope * (part == "temperature"),
            matrix={"scale factor": own, "misalignment": self.matrix - own}.get(part, still),
            asymmetry=self.asymmetry * (part == "asymmetry"),
            accelerometer_matrix=self.accelerometer_matrix * accelerometers,
            accelerometer_bias=self.accelerometer_bias * accelerometers,
        )

    def rates(self, omega: ArrayLike, time: ArrayLike = 0.0) -> Array:
        """Compensated readings of the gyros, shape (..., 3), for rates of that shape, rad/s, and times from the middle
        of the measurement, s, of shape (...,)."""
        omega = checks.finite_array("omega", omega, shape=(..., 3))
        drift = np.asarray(time, dtype=float)[..., np.newaxis] * self.bias_slope
        return omega + omega @ self.matrix.T + 0.5 * self.asymmetry * np.abs(omega) + self.bias + drift

    def forces(self, force: ArrayLike) -> Array:
        """Compensated readings of the accelerometers, shape (..., 3), m/s^2."""
        force = checks.finite_array("force", force, shape=(..., 3))
        return force + force @ self.accelerometer_matrix.T + self.accelerometer_bias


def errors_left(
    instrument: Instrument,
    calibrated: Calibrated,
    there: Conditions,
    here: Conditions,
    *,
    duration: float = 300.0,
    repeatability: ArrayLike = (0.0, 0.0, 0.0),
    thermal_models: Sequence[CoilBias] | None = None,
    simulated: bool = True,
) -> ErrorsLeft:
    """Errors of a unit that was calibrated under some conditions and works under others.

    Parameters
    ----------
    instrument : Instrument
        The truth.
    calibrated : Calibrated
        What a method found under the conditions `there`; of an instrument without calibration all that the conditions
        make here counts as left, but for temperature, which counts from there.
    there, here : Conditions
        Of calibration and of work.
    duration : float, optional
        Of the measurement, s, which begins at the time ``here.powered`` after switching on.
    repeatability : array_like, shape (3,), optional
        Change of the biases from one switching on to the next, rad/s.
    thermal_models : sequence of CoilBias, optional
        What a temperature test says of the three gyros (`fogkit.instrument.temperature`); it is subtracted in both
        places.
    simulated : bool, optional
        As for `Instrument.vibration_bias`.

    Returns
    -------
    ErrorsLeft
        Their sum is exact to first order in what is left.
    """
    duration = checks.positive("duration", duration, "s")
    found, triads = calibrated.compensation, (instrument.unit.gyros.triad, instrument.unit.accelerometers.triad)
    seen = instrument.vibration_bias(there, simulated=simulated) * (calibrated.method != "none")
    settled, times = instrument.thermal_bias(there), duration * np.array([0.0, 0.25, 0.5, 0.75, 1.0])
    course = instrument.thermal_bias(here, times) - settled
    if thermal_models is not None:
        modelled = modelled_bias(instrument, thermal_models, here, times)
        course = course - modelled + modelled_bias(instrument, thermal_models, there)
    E_g, E_a = (
        matrix @ np.array(triad.matrix)
        for matrix, triad in zip((found.gyro_matrix, found.accelerometer_matrix), triads, strict=True)
    )
    turned = orthonormalise(E_g)
    to_case = turned.T @ found.gyro_matrix
    added = {
        "vibration": instrument.vibration_bias(here, simulated=simulated) - seen,
        "temperature": np.array([1, 4, 2, 4, 1]) / 12 @ course,  # Simpson's rule
        "repeatability": checks.finite_array("repeatability", repeatability, shape=(3,)),
    }
    calibration = to_case @ (np.array(triads[0].bias) + seen + settled) + turned.T @ found.gyro_bias
    force_bias = turned.T @ (found.accelerometer_matrix @ np.array(triads[1].bias) + found.accelerometer_bias)
    return ErrorsLeft(
        biases={"calibration": calibration} | {name: to_case @ value for name, value in added.items()},
        bias_slope=to_case @ (course[-1] - course[0]) / duration,
        matrix=turned.T @ E_g - np.eye(3),
        asymmetry=np.array(instrument.unit.gyros.shape.asymmetry) - calibrated.asymmetry,
        accelerometer_matrix=turned.T @ E_a - np.eye(3),
        accelerometer_bias=force_bias,
        boresight=np.array([turned[2, 1] - turned[1, 2], turned[0, 2] - turned[2, 0], turned[1, 0] - turned[0, 1]]) / 2,
    )
