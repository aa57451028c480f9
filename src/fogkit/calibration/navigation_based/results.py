"""What a calibration by navigation gives back."""

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from fogkit.calibration.navigation_based.compensation import Compensation
from fogkit.estimation import Solution
from fogkit.results import FrozenArrays, contents

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class NavigationCalibration(FrozenArrays):
    """Result of `calibrate`.

    Attributes
    ----------
    compensation : Compensation
        Matrices and biases with all corrections, the last one included.
    solution : Solution
        Least squares of the last iteration: its estimates are the last corrections, its covariance (27) that of the
        calibration. Chi-square tests whether the remaining changes of slope are noise.
    scale_factor_deviation : ndarray, shape (3,)
        Standard deviations of the accelerometer scale factors.
    log : DataFrame
        A row for each iteration: ``rms_z``, m/s^2, of the changes of slope (fig. 4 of the paper); ``rms_m_a``,
        ``rms_m_g``, ``rms_b_a`` (m/s^2) of the corrections (fig. 5), and ``rms_scale_factor_a``;
        ``chi_square``; ``condition`` of the measurement matrix with columns of unit length;
        ``largest_correction`` in standard deviations; ``tilt``, rad, by which the full step turns an attitude;
        ``share`` of the step that was taken.
    slopes : DataFrame
        Slopes ``east, north, up``, m/s^2, of both dwells of each test, and variances (24), in the last iteration.
    attitudes : ndarray, shape (tests, 2, 3, 3)
        ``C_b_n`` at the end of the first and the beginning of the second dwell, in the last iteration.
    converged : bool
        Whether the last correction was small.
    """

    compensation: Compensation
    solution: Solution
    scale_factor_deviation: Array
    log: "DataFrame"
    slopes: "DataFrame"
    attitudes: Array
    converged: bool

    def to_frame(self) -> "DataFrame":
        """Table of the calibrated elements with their standard deviations: index ``name``, SI units."""
        import pandas as pd

        deviations = dict(zip(self.solution.names, self.solution.standard_deviation.tolist(), strict=True))
        names = ("m_a_11", "m_a_22", "m_a_33")
        deviations |= dict(zip(names, self.scale_factor_deviation.tolist(), strict=True))
        matrices = {"a": "accelerometer", "g": "gyro"}
        rows = []
        for name, deviation in deviations.items():
            symbol, kind, digits = name.split("_")
            place = tuple(int(digit) - 1 for digit in digits)
            part = getattr(self.compensation, f"{matrices[kind]}_{'matrix' if symbol == 'm' else 'bias'}")
            rows.append((f"{symbol.upper()}_{kind}_{digits}", float(part[place]), deviation))
        table = pd.DataFrame(rows, columns=["name", "value", "standard_deviation"])
        return table.set_index("name")

    def to_json(self) -> str:
        """Text from which `from_json` makes an equal record."""
        parts = {
            "compensation": self.compensation.to_json(),
            "solution": self.solution.to_json(),
            "scale_factor_deviation": self.scale_factor_deviation.tolist(),
            "log": self.log.reset_index().to_dict(orient="list"),
            "slopes": self.slopes.reset_index().to_dict(orient="list"),
            "attitudes": self.attitudes.tolist(),
            "converged": self.converged,
        }
        return json.dumps({"kind": type(self).__name__} | parts)

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Record from the text of `to_json`; ``ValueError`` if that was of another kind."""
        import pandas as pd

        parts = contents(text, cls.__name__)
        parts["compensation"] = Compensation.from_json(parts["compensation"])
        parts["solution"] = Solution.from_json(parts["solution"])
        parts["log"] = pd.DataFrame(parts["log"]).set_index("iteration")
        parts["slopes"] = pd.DataFrame(parts["slopes"]).set_index(["test", "dwell"])
        for name in ("scale_factor_deviation", "attitudes"):
            parts[name] = np.array(parts[name])
        return cls(**parts)
