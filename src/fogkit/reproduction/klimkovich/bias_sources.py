"""What biases the result: each source alone, by calibrations of the same unit with and without it, free of noise."""

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from fogkit.imu.size_effect import SizeEffect
from fogkit.reproduction.klimkovich import paper
from fogkit.reproduction.klimkovich.convergence import disagreement
from fogkit.reproduction.klimkovich.trials import Trial

if TYPE_CHECKING:
    from pandas import DataFrame

ITERATIONS = 8


def _centres(distance: float) -> np.ndarray:
    """Centres of the accelerometers, m: a draw about the reference point."""
    return np.random.default_rng(5).normal(0, distance, (3, 3))


_APART = np.array([[0.0, 0.01, 0.0], [0.0, 0.0, 0.01], [0.01, 0.0, 0.0]])  # 1 cm along a pendulum across each axis


@dataclass(frozen=True)
class Source:
    """One source of error.

    Attributes
    ----------
    words : str
        What it is, with its size.
    changes : dict
        Arguments of `Trial` that make it.
    attitude : str
        Attitude at the start with it; without it the true one is taken.
    """

    words: str
    changes: dict[str, Any]
    attitude: str = "true"


SOURCES = {
    "size effect, one point": Source(
        "accelerometers 2 cm from the reference point", {"size_effect": SizeEffect.one_point(_centres(0.02))}
    ),
    "size effect, two points": Source(
        "the same, their two centres 1 cm apart",
        {"size_effect": SizeEffect(acceleration_centres=_centres(0.02), velocity_centres=_centres(0.02) + _APART)},
    ),
    "gyro delay, common": Source("all gyros late by 1 ms", {"gyro_delay": (1e-3,) * 3}),
    "gyro delays, unequal": Source("gyros late by 0.1, -0.1 and 0.2 ms", {"gyro_delay": (1e-4, -1e-4, 2e-4)}),
    "accelerometer delays, unequal": Source(
        "accelerometers late by 1, -0.5 and 2 ms", {"accelerometer_delay": (1e-3, -5e-4, 2e-3)}
    ),
    "gyro bias x": Source("bias of gyro x of 2e-7 rad/s", {"gyro_bias": (paper.GYRO_BIAS_LEFT, 0.0, 0.0)}),
    "gyro bias, all": Source("bias of all gyros of 2e-7 rad/s", {"gyro_bias": (paper.GYRO_BIAS_LEFT,) * 3}),
    "start of the model": Source("the plan's attitude at the start", {}, "model"),
    "start levelled": Source("levelled, heading of the plan", {}, "levelled"),
    "start carried": Source("levelled, heading of the test before", {}, "carried"),
}
"""Sources that `effect` knows."""


@cache
def reference(roughness: float, seed: int = 1):
    """Calibration without any of the sources: the true start, no noise."""
    return Trial(roughness=roughness, seed=seed).calibrated(attitude="true", iterations=ITERATIONS)


@cache
def effect(source: str, roughness: float = 1.0, *, seed: int = 1, degree: int = 1) -> dict[str, float]:
    """Largest changes of the result by one source.

    Parameters
    ----------
    source : str
        Key of `SOURCES`.
    roughness : float, optional
        Of the table.
    seed : int, optional
        Of the trial.
    degree : {1, 2}, optional
        Of the polynomials through the velocity.

    Returns
    -------
    dict
        As `fogkit.reproduction.klimkovich.trials.largest`.
    """
    chosen = SOURCES[source]
    trial = Trial(roughness=roughness, seed=seed, **chosen.changes)
    found = trial.calibrated(attitude=chosen.attitude, iterations=ITERATIONS, degree=degree)
    return disagreement(found, reference(roughness, seed))


def table(roughness: float = 1.0, seed: int = 1) -> "DataFrame":
    """All sources: index source, columns of `effect`."""
    import pandas as pd

    return pd.DataFrame.from_dict(
        {source: effect(source, roughness, seed=seed) for source in SOURCES}, orient="index"
    ).rename_axis("source")
