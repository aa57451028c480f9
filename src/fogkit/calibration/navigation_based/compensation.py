"""Matrices and biases that take raw readings to true ones: what the calibration finds, and how far it is from truth."""

import json
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.imu.tables import ACCEL_COLUMNS, GYRO_COLUMNS, IMU_COLUMNS
from fogkit.imu.unit import MeasurementUnit
from fogkit.navigation.increments import time_step, values
from fogkit.results import FrozenArrays, contents
from fogkit.rotation import dcm_from_rotvec, skew

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

GAUGE = ((0, 1), (1, 2), (2, 0))
"""Elements of the accelerometer matrix, from 0, that the paper holds at zero: they say which axes are meant."""

_GAUGE_STEPS = 20  # Newton's method squares the error: from 0.1 rad five steps reach rounding


@dataclass(frozen=True, kw_only=True, eq=False)
class Compensation(FrozenArrays):
    """Rates and specific force from raw readings, eqs. (1) and (2) of [1]_: ``bias + matrix @ raw``.

    Parameters
    ----------
    gyro_matrix, accelerometer_matrix : array_like, shape (3, 3), optional
        Scale factors on the diagonal; element i, j is the misalignment of sensor i with axis j, rad.
    gyro_bias : array_like, shape (3,), optional
        What is added to the rate, rad/s: the negative of a gyro's own bias, but for the matrix.
    accelerometer_bias : array_like, shape (3,), optional
        What is added to the specific force, m/s^2.

    Raises
    ------
    ValueError
        If a shape is wrong, a number not finite, or a matrix singular.

    References
    ----------
    .. [1] B. V. Klimkovich, Precise calibration of strapdown INS using low-accuracy turntables, Gyroscopy and
       Navigation (in Russian), vol. 30, no. 4 (119), 2022, pp. 54-70.
    """

    gyro_matrix: ArrayLike = field(default_factory=lambda: np.eye(3))
    gyro_bias: ArrayLike = field(default_factory=lambda: np.zeros(3))
    accelerometer_matrix: ArrayLike = field(default_factory=lambda: np.eye(3))
    accelerometer_bias: ArrayLike = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        for kind in ("gyro", "accelerometer"):
            matrix = checks.finite_array(f"{kind}_matrix", getattr(self, f"{kind}_matrix"), shape=(3, 3))
            if np.linalg.matrix_rank(matrix) < 3:
                raise ValueError(f"`{kind}_matrix` must be invertible, got {matrix.tolist()}")
            object.__setattr__(self, f"{kind}_matrix", matrix)
            bias = checks.finite_array(f"{kind}_bias", getattr(self, f"{kind}_bias"), shape=(3,))
            object.__setattr__(self, f"{kind}_bias", bias)
        super().__post_init__()

    @classmethod
    def from_unit(cls, unit: MeasurementUnit) -> Self:
        """Exact compensation of the linear part of a unit that reads ``bias + matrix @ input``: the truth."""
        checks.instance("unit", unit, MeasurementUnit)
        parts = {}
        for kind, sensors in (("gyro", unit.gyros), ("accelerometer", unit.accelerometers)):
            matrix = np.linalg.inv(sensors.triad.matrix)
            parts[f"{kind}_matrix"] = matrix
            parts[f"{kind}_bias"] = -matrix @ np.array(sensors.triad.bias)
        return cls(**parts)

    def apply(self, increments: "DataFrame") -> "DataFrame":
        """Table of compensated increments, rad and m/s, from one of raw ones with equal steps."""
        import pandas as pd

        _, dt = time_step(increments)
        raw = values(increments)
        gyro = raw[:, :3] @ self.gyro_matrix.T + self.gyro_bias * dt
        accel = raw[:, 3:] @ self.accelerometer_matrix.T + self.accelerometer_bias * dt
        return pd.DataFrame(np.hstack([gyro, accel]), index=increments.index, columns=list(IMU_COLUMNS))

    def corrected(self, errors: dict[str, float]) -> Self:
        """Compensation less errors that were found in it, element by element as the paper has it.

        Parameters
        ----------
        errors : mapping of str to float
            What the compensated readings have too much, by names such as ``m_g_12``, ``b_a_3``: pure numbers, m/s^2
            for ``b_a``, rad/s for ``b_g``. The first index is the sensor.

        Raises
        ------
        ValueError
            If a name is none of these.
        """
        parts = self._parts()
        for name, value in errors.items():
            place, index = _place(name)
            parts[place][index] -= value
        return type(self)(**parts)

    def with_errors(self, errors: dict[str, float]) -> Self:
        """Compensation after which true readings x come out as ``(I + m) x + b``, with errors named as in `corrected`.

        `corrected` undoes it to first order: what it takes from an element of a matrix near the unit matrix
        differs from the error by the product of both departures.
        """
        parts, found = self._parts(), Compensation()._parts()
        for name, value in errors.items():
            place, index = _place(name)
            found[place][index] += value
        for kind in ("gyro", "accelerometer"):
            matrix = found[f"{kind}_matrix"]
            parts[f"{kind}_bias"] = matrix @ parts[f"{kind}_bias"] + found[f"{kind}_bias"]
            parts[f"{kind}_matrix"] = matrix @ parts[f"{kind}_matrix"]
        return type(self)(**parts)

    def turned(self, C_b_b2: ArrayLike) -> Self:
        """The same readings in other axes of the unit: all outputs are multiplied by `C_b_b2`, shape (3, 3)."""
        C = checks.rotation_matrix("C_b_b2", C_b_b2)
        return type(self)(**{name: C @ part for name, part in self._parts().items()})

    def gauged(self) -> Self:
        """The same readings in the axes of the paper, in which the elements `GAUGE` of the accelerometers are zero.

        Raises
        ------
        ValueError
            If no rotation near the present axes does that: the matrix is far from diagonal.
        """
        matrix, C = np.array(self.accelerometer_matrix), np.eye(3)
        rows, columns = np.transpose(GAUGE)
        for _ in range(_GAUGE_STEPS):
            turned = C @ matrix
            if np.abs(turned[rows, columns]).max() <= 1e-16 * np.abs(turned).max():
                break
            # derivatives of the three elements with respect to a further small rotation about the three axes
            slopes = np.stack([(skew(axis) @ turned)[rows, columns] for axis in np.eye(3)], axis=-1)
            step = -np.linalg.lstsq(slopes, turned[rows, columns])[0]
            C = dcm_from_rotvec(step) @ C
        turned = C @ matrix
        largest = np.abs(turned).max()
        if np.abs(turned[rows, columns]).max() > 1e-12 * largest or np.diagonal(turned).min() < 0.5 * largest:
            raise ValueError(f"`accelerometer_matrix` must be near a diagonal one, got {matrix.tolist()}")
        parts = {name: C @ part for name, part in self._parts().items()}
        parts["accelerometer_matrix"][rows, columns] = 0.0  # rounding
        return type(self)(**parts)

    def to_frame(self) -> "DataFrame":
        """Table: rows ``gyro_x`` to ``accel_z``, columns ``x, y, z`` of the matrices and ``bias``, rad/s or m/s^2."""
        import pandas as pd

        rows = [
            np.column_stack([self.gyro_matrix, self.gyro_bias]),
            np.column_stack([self.accelerometer_matrix, self.accelerometer_bias]),
        ]
        index = pd.Index(GYRO_COLUMNS + ACCEL_COLUMNS, name="sensor")
        return pd.DataFrame(np.vstack(rows), index=index, columns=["x", "y", "z", "bias"])

    def to_json(self) -> str:
        """Text from which `from_json` makes an equal record, to the last bit."""
        parts = {name: part.tolist() for name, part in self._parts().items()}
        return json.dumps({"kind": type(self).__name__} | parts)

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Record from the text of `to_json`; ``ValueError`` if that was of another kind."""
        return cls(**contents(text, cls.__name__))

    def _parts(self) -> dict[str, Array]:
        names = ("gyro_matrix", "gyro_bias", "accelerometer_matrix", "accelerometer_bias")
        return {name: np.array(getattr(self, name)) for name in names}


def differences(estimate: Compensation, truth: Compensation) -> dict[str, float]:
    """True errors of a calibration, after a rotation common to both triads was removed.

    Parameters
    ----------
    estimate, truth : Compensation
        What was found, and `Compensation.from_unit` of the unit.

    Returns
    -------
    dict of str to float
        What readings compensated by `estimate` have too much, in the axes in which the errors `GAUGE` are zero:
        ``m_a_ij`` and ``m_g_ij``, pure numbers and rad, ``b_a_i``, m/s^2, ``b_g_i``, rad/s.

    Raises
    ------
    TypeError
        If one of them is no `Compensation`.
    ValueError
        If they differ by more than small errors.

    Notes
    -----
    Readings come out as ``E x + b`` of the true quantity x. No method that only looks at rotations and gravity can tell
    E from C E of both triads, with C a rotation: it is the freedom to name the axes.
    """
    fix = "That of a unit is `Compensation.from_unit(unit)`, that of a calibration its `.compensation`."
    checks.instance("estimate", estimate, Compensation, fix=fix)
    checks.instance("truth", truth, Compensation, fix=fix)
    parts = {}
    for kind in ("gyro", "accelerometer"):
        ours, true = getattr(estimate, f"{kind}_matrix"), getattr(truth, f"{kind}_matrix")
        E = ours @ np.linalg.inv(true)
        parts[f"{kind}_matrix"] = E
        parts[f"{kind}_bias"] = getattr(estimate, f"{kind}_bias") - E @ getattr(truth, f"{kind}_bias")
    both = Compensation(**parts).gauged()
    found = {}
    for letter, kind in (("a", "accelerometer"), ("g", "gyro")):
        m = getattr(both, f"{kind}_matrix") - np.eye(3)
        found |= {f"m_{letter}_{i + 1}{j + 1}": float(m[i, j]) for i in range(3) for j in range(3)}
        found |= {f"b_{letter}_{i + 1}": float(b) for i, b in enumerate(getattr(both, f"{kind}_bias"))}
    return found


def _place(name: str) -> tuple[str, tuple[int, ...]]:
    """Field and index of a parameter; ``ValueError`` if there is none of that name."""
    kinds = {"a": "accelerometer", "g": "gyro"}
    symbol, kind, digits = (*name.split("_"), "", "", "")[:3] if isinstance(name, str) else ("", "", "")
    index = tuple(int(digit) - 1 for digit in digits if digit in "123")
    if kind not in kinds or {"m": 2, "b": 1}.get(symbol) != len(index) or len(index) != len(digits):
        raise ValueError(f"`errors` must have names such as 'm_g_12' or 'b_a_3', got {name!r}")
    return f"{kinds[kind]}_{'matrix' if symbol == 'm' else 'bias'}", index
