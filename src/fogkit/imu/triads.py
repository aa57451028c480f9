"""Linear error model of three sensors in one case, for gyros and accelerometers alike, in the forms in use.

The sensors read ``bias + matrix @ input``, in any unit: pulses per second, volts, or the unit of the input. Twelve
numbers a triad, 24 a measurement unit; mechanical gyros have nine more, for the specific force. The same twelve are
called zero term, equivalent and direction cosines by the slides; bias, scale factor and misalignment by the standards.
"""

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks

AXES = ("x", "y", "z")
NO_ROWS = ((0.0,) * 3,) * 3
UNIT_ROWS = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True, kw_only=True)
class LinearTriad:
    """Three sensors that read ``bias + matrix @ input + acceleration_sensitivity @ specific_force``.

    Parameters
    ----------
    bias : array_like, shape (3,), optional
        Readings without input, in units of the reading: the slides' zero terms.
    matrix : array_like, shape (3, 3), optional
        Row j: change of the reading of sensor j with the input along the axes x, y, z of the case, in units of the
        reading per unit of the input: the slides' components of the equivalent.
    acceleration_sensitivity : array_like, shape (3, 3), optional
        Change of the readings of mechanical gyros with the specific force along x, y, z, in units of the reading per
        m/s^2; zero for optical gyros and for accelerometers.

    Raises
    ------
    ValueError
        If a shape is wrong, a number not finite, or a row of the matrix zero.
    """

    bias: ArrayLike = field(default=(0.0, 0.0, 0.0))
    matrix: ArrayLike = field(default=UNIT_ROWS)
    acceleration_sensitivity: ArrayLike = field(default=NO_ROWS)

    def __post_init__(self) -> None:
        bias = checks.finite_array("bias", self.bias, shape=(3,))
        matrix = checks.finite_array("matrix", self.matrix, shape=(3, 3))
        if not matrix.any(axis=1).all():
            raise ValueError(f"`matrix` must have no row of zeros: a sensor without input axis, got {matrix.tolist()}")
        sensitivity = checks.finite_array("acceleration_sensitivity", self.acceleration_sensitivity, shape=(3, 3))
        object.__setattr__(self, "bias", tuple(bias.tolist()))
        object.__setattr__(self, "matrix", tuple(map(tuple, matrix.tolist())))
        object.__setattr__(self, "acceleration_sensitivity", tuple(map(tuple, sensitivity.tolist())))

    @property
    def equivalents(self) -> NDArray[np.float64]:
        """Readings per unit of input along each sensor's own axis, shape (3,): lengths of the rows of the matrix."""
        return np.linalg.norm(self.matrix, axis=1)

    @property
    def cosines(self) -> NDArray[np.float64]:
        """Direction cosines of the input axes in the case, shape (3, 3), one unit row per sensor."""
        return np.array(self.matrix) / self.equivalents[:, None]

    @property
    def scale_factor(self) -> NDArray[np.float64]:
        """Readings per unit of input along the nominal axis, shape (3,): the diagonal of the matrix."""
        return np.diagonal(self.matrix).copy()

    @property
    def misalignment(self) -> NDArray[np.float64]:
        """Input across each nominal axis that reads like a unit along it, shape (3, 3), rad, zeros on the diagonal."""
        return np.array(self.matrix) / self.scale_factor[:, None] - np.eye(3)

    @property
    def input_bias(self) -> NDArray[np.float64]:
        """Bias as an input along the nominal axis, shape (3,), in units of the input."""
        return np.array(self.bias) / self.scale_factor

    def scale_factor_error(self, nominal: ArrayLike) -> NDArray[np.float64]:
        """Relative error of nominal scale factors, shape (3,): ``scale_factor / nominal - 1``."""
        return self.scale_factor / checks.finite_array("nominal", nominal) - 1

    @classmethod
    def from_equivalents(
        cls, zero: ArrayLike, equivalents: ArrayLike, cosines: ArrayLike, acceleration_sensitivity: ArrayLike = NO_ROWS
    ) -> Self:
        """Triad from zero terms (3,), equivalents (3,) and unit rows of direction cosines (3, 3).

        Raises
        ------
        ValueError
            If an equivalent is not positive or a row of cosines is not of length 1 within 1e-6.
        """
        equivalents = checks.finite_array("equivalents", equivalents, shape=(3,))
        cosines = checks.finite_array("cosines", cosines, shape=(3, 3))
        if (equivalents <= 0).any():
            raise ValueError(f"`equivalents` must be > 0, got {equivalents.tolist()}. Turn the cosines instead.")
        if (np.abs(np.linalg.norm(cosines, axis=1) - 1) > 1e-6).any():
            raise ValueError(f"`cosines` must have unit rows, got lengths {np.linalg.norm(cosines, axis=1).tolist()}")
        matrix = equivalents[:, None] * cosines
        return cls(bias=zero, matrix=matrix, acceleration_sensitivity=acceleration_sensitivity)

    @classmethod
    def from_standard(
        cls,
        *,
        scale_factor: ArrayLike,
        input_bias: ArrayLike = (0.0, 0.0, 0.0),
        misalignment: ArrayLike = NO_ROWS,
        acceleration_sensitivity: ArrayLike = NO_ROWS,
    ) -> Self:
        """Triad from scale factors (3,), biases in units of the input (3,) and misalignments (3, 3), rad.

        Raises
        ------
        ValueError
            If a scale factor is zero, or the diagonal of the misalignment is not.
        """
        scale_factor = checks.finite_array("scale_factor", scale_factor, shape=(3,))
        misalignment = checks.finite_array("misalignment", misalignment, shape=(3, 3))
        if np.diagonal(misalignment).any():
            raise ValueError(f"`misalignment` must be 0 on its diagonal, got {np.diagonal(misalignment).tolist()}")
        bias = scale_factor * checks.finite_array("input_bias", input_bias, shape=(3,))
        matrix = scale_factor[:, None] * (np.eye(3) + misalignment)
        return cls(bias=bias, matrix=matrix, acceleration_sensitivity=acceleration_sensitivity)

    def readings(self, inputs: ArrayLike, specific_force: ArrayLike | None = None) -> NDArray[np.float64]:
        """Readings, shape (..., 3).

        Parameters
        ----------
        inputs : array_like, shape (..., 3)
            Rate, rad/s, or specific force, m/s^2, along the axes of the case.
        specific_force : array_like, shape (..., 3), optional
            What acts on acceleration-sensitive gyros, m/s^2; needed if there are any.
        """
        read = np.array(self.bias) + checks.finite_array("inputs", inputs, shape=(..., 3)) @ np.transpose(self.matrix)
        return read + self._by_force(specific_force)

    def correct(self, readings: ArrayLike, specific_force: ArrayLike | None = None) -> NDArray[np.float64]:
        """Inputs along the axes of the case, shape (..., 3), from readings: the inverse of `readings`."""
        read = checks.finite_array("readings", readings, shape=(..., 3))
        return (read - np.array(self.bias) - self._by_force(specific_force)) @ np.linalg.inv(self.matrix).T

    def turned(self, C_b_b2: ArrayLike) -> Self:
        """Same sensors in other axes of the case: ``v_b = C_b_b2 @ v_b2`` holds for the inputs."""
        C = checks.rotation_matrix("C_b_b2", C_b_b2)
        return replace(self, matrix=np.array(self.matrix) @ C, acceleration_sensitivity=self._sensitivity @ C)

    @property
    def _sensitivity(self) -> NDArray[np.float64]:
        return np.array(self.acceleration_sensitivity)

    def _by_force(self, specific_force: ArrayLike | None) -> NDArray[np.float64] | float:
        """Part of the readings that the specific force makes."""
        if not self._sensitivity.any():
            return 0.0
        if specific_force is None:
            raise ValueError("`specific_force` must be given for acceleration-sensitive gyros, got None")
        return checks.finite_array("specific_force", specific_force, shape=(..., 3)) @ self._sensitivity.T
