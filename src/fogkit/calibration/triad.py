"""The result of a triad calibration, whatever the method: 15 parameters with their covariance."""

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit.imu.errors import MISALIGNMENTS, GyroTriad, asymmetry

if TYPE_CHECKING:
    from pandas import DataFrame

PARAMETERS = (
    *(f"bias_{axis}" for axis in "xyz"),
    *(f"scale_positive_{axis}" for axis in "xyz"),
    *(f"scale_negative_{axis}" for axis in "xyz"),
    *MISALIGNMENTS,
)
"""Names of the parameters, in order."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TriadCalibration:
    """Estimated parameters of a gyro triad.

    Attributes
    ----------
    estimate : ndarray, shape (..., 15)
        Parameters in the order of `PARAMETERS`: biases in units of the reading, scale factors in rad/s per unit, angles
        in rad. Leading axes are independent runs.
    covariance : ndarray, shape (15, 15), or None
        Covariance of the estimate of one run; None if no noise was stated.
    """

    estimate: NDArray[np.float64]
    covariance: NDArray[np.float64] | None = None

    @property
    def standard_deviation(self) -> NDArray[np.float64] | None:
        """Standard deviations of the parameters, shape (15,), or None."""
        return None if self.covariance is None else np.sqrt(np.diag(self.covariance))

    @property
    def triad(self) -> GyroTriad:
        """Gyros with the estimated parameters; of a single run."""
        return triad_from_parameters(self.estimate)

    @property
    def asymmetry(self) -> NDArray[np.float64]:
        """Asymmetry of the scale factors, shape (..., 3) (volynskii eq. (1))."""
        return asymmetry(self.estimate[..., 3:6], self.estimate[..., 6:9])

    @property
    def asymmetry_deviation(self) -> NDArray[np.float64] | None:
        """Standard deviation of the asymmetry, shape (3,), from the covariance of both scale factors, or None."""
        if self.covariance is None:
            return None
        estimate = self.estimate.reshape(-1, len(PARAMETERS))[0]
        plus, minus = estimate[3:6], estimate[6:9]
        jacobian = np.zeros((3, len(PARAMETERS)))
        index = np.arange(3)
        jacobian[index, 3 + index] = minus / (0.5 * (plus + minus)) ** 2
        jacobian[index, 6 + index] = -plus / (0.5 * (plus + minus)) ** 2
        return np.sqrt(np.diag(jacobian @ self.covariance @ jacobian.T))

    def to_frame(self) -> "DataFrame":
        """Table of one run: index ``parameter``, columns ``estimate`` and ``standard_deviation``, in SI units."""
        import pandas as pd

        deviation = np.nan if self.covariance is None else self.standard_deviation
        index = pd.Index(PARAMETERS, name="parameter")
        return pd.DataFrame({"estimate": self.estimate, "standard_deviation": deviation}, index=index)

    def to_json(self) -> str:
        """Text that `from_json` turns into an equal result."""
        covariance = None if self.covariance is None else self.covariance.tolist()
        return json.dumps({"parameters": PARAMETERS, "estimate": self.estimate.tolist(), "covariance": covariance})

    @classmethod
    def from_json(cls, text: str) -> "TriadCalibration":
        """Result from the text of `to_json`; ``ValueError`` if its parameters are others."""
        data = json.loads(text)
        if tuple(data["parameters"]) != PARAMETERS:
            raise ValueError(f"`text` must hold the parameters {PARAMETERS}, got {tuple(data['parameters'])}")
        covariance = None if data["covariance"] is None else np.array(data["covariance"])
        return cls(estimate=np.array(data["estimate"]), covariance=covariance)


def parameters_of(triad: GyroTriad) -> NDArray[np.float64]:
    """Parameters of a triad in the order of `PARAMETERS`, shape (15,)."""
    return np.concatenate([triad.bias, triad.scale_positive, triad.scale_negative, triad.misalignments])


def triad_from_parameters(parameters: NDArray[np.float64]) -> GyroTriad:
    """Noise-free triad with parameters in the order of `PARAMETERS`, shape (15,)."""
    bias, plus, minus, angles = np.split(np.asarray(parameters, float), [3, 6, 9])
    return GyroTriad(bias=bias, scale_positive=plus, scale_negative=minus, misalignments=angles)
