"""What the simulated temperature tests of the slides have in common."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit.thermal import experiment, rates

if TYPE_CHECKING:
    from pandas import DataFrame


TRUE_POINTS = ("coil_top", "coil_bottom", "electronics")
"""Points that the bias of the simulated gyro depends on, which are those that the slides keep."""


def root_mean_square(values: Sequence[NDArray]) -> float:
    """Root mean square of several series together."""
    return float(np.sqrt(np.mean(np.concatenate(values) ** 2)))


def left_over(result, tables: list[DataFrame]) -> float:
    """What a fit leaves of the bias of some runs."""
    return root_mean_square([table["bias"].to_numpy() - result.predict(table) for table in tables])


def plan() -> list[experiment.Run]:
    """Starts and warm runs."""
    return experiment.start_ups() + experiment.warm_runs()


def row_noise(thermometer: experiment.Thermometer, interval: float = 10.0) -> tuple[float, float]:
    """Errors of the rows of a campaign."""
    return rates.row_noise(thermometer.deviation, interval, experiment.WINDOW)
