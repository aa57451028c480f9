"""The accuracy of a scale factor, (20) to (23), in numbers: every reading of (22), its parts, a simulation."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from fogkit import checks
from fogkit.reproduction.volynskii import instruments as paper
from fogkit.units import REVOLUTION

if TYPE_CHECKING:
    import pandas as pd

NOISE_FACTORS = {
    "two-sided, per rad/s, variance the integral of the density": 2 * np.pi,
    "one-sided, per rad/s, variance the integral of the density": np.pi,
    "two-sided, per Hz; or per rad/s with the integral over 2 pi": 1.0,
    "one-sided, per Hz": 0.5,
}
"""Variance of the integral of white noise over the time T, in units of ``C_n**2 * T``, by convention of the density."""

PRINTED_CONVENTION = next(iter(NOISE_FACTORS))
"""The one that makes ``C_n * sqrt(2 pi T)`` a standard deviation, as (22) has it."""


@dataclass(frozen=True, kw_only=True)
class ScaleFactorTest:
    """One measurement of a scale factor: the table turns by a known angle while the reading is integrated.

    Parameters
    ----------
    angle : float
        Angle turned, rad.
    duration : float
        Time, s.
    readout : float
        Standard deviation of one angle reading, rad.
    bias_error : float
        Standard deviation of the bias that is taken off, rad/s.
    noise : float
        C_n of (22), rad/sqrt(s).
    noise_factor : float, optional
        One of `NOISE_FACTORS`.
    """

    angle: float = paper.EXAMPLE_ANGLE
    duration: float = paper.EXAMPLE_DURATION
    readout: float = paper.EXAMPLE_READOUT
    bias_error: float = paper.EXAMPLE_BIAS_ERROR
    noise: float = paper.EXAMPLE_NOISE
    noise_factor: float = NOISE_FACTORS[PRINTED_CONVENTION]

    def __post_init__(self) -> None:
        for name, unit in (("angle", "rad"), ("duration", "s")):
            checks.positive(name, getattr(self, name), unit)
        for name, unit in (("readout", "rad"), ("bias_error", "rad/s"), ("noise", "rad/sqrt(s)"), ("noise_factor", "")):
            checks.non_negative(name, getattr(self, name), unit)

    @property
    def parts(self) -> dict[str, float]:
        """Standard deviations of the angle caused by both readings of the table, by bias and by noise, rad."""
        return {
            "readout": np.sqrt(2) * self.readout,
            "bias": self.bias_error * self.duration,
            "noise": self.noise * np.sqrt(self.noise_factor * self.duration),
        }

    @property
    def deviation(self) -> float:
        """Standard deviation of the scale factor, relative: the corrected (22)."""
        return float(np.hypot.reduce(list(self.parts.values())) / self.angle)

    @property
    def asymmetry_deviation(self) -> float:
        """Standard deviation of the asymmetry from two such tests, one each way, with the same bias error in both.

        Readout and noise are independent in the two and count with sqrt(2); the bias error raises one scale factor and
        lowers the other, and counts twice.
        """
        parts = self.parts
        independent = 2 * (parts["readout"] ** 2 + parts["noise"] ** 2)
        return float(np.sqrt(independent + (2 * parts["bias"]) ** 2) / self.angle)

    @property
    def printed(self) -> float:
        """(22) as printed: a linear sum, with one angle reading."""
        parts = self.parts
        return (self.readout + parts["bias"] + parts["noise"]) / self.angle


def at_rate(rate: float, duration: float = paper.EXAMPLE_DURATION, **errors: float) -> ScaleFactorTest:
    """The paper's example at another rate of the table, rad/s."""
    return ScaleFactorTest(angle=rate * duration, duration=duration, **errors)


def whole_turns() -> ScaleFactorTest:
    """The paper's example with 36 whole turns: 360 s at 36 deg/s, the top of the tested rates."""
    return at_rate(paper.TEST_RATES[1])


def readings_of_eq22() -> pd.DataFrame:
    """Every reading of (22) against the printed 1.36e-7.

    Returns
    -------
    pandas.DataFrame
        One row per choice: ``angle`` (as printed, or 36 turns), ``readings`` (1 or 2 independent angle readings),
        ``sum`` (linear or root of squares), ``density`` (convention), ``scale`` (1 if bias error and noise are rates,
        the scale factor of gyro x in Table 2 if they are in units of the reading); ``result``, and ``ratio`` to the
        print. Nearest to the print first.
    """
    import pandas as pd

    angles = {"4.6e7 arcsec": paper.EXAMPLE_ANGLE, "36 turns": 36 * REVOLUTION}
    rows = []
    scales = (1.0, paper.TABLE_2["x+"]["mean"])
    for (name, angle), readings, how, (density, factor), scale in product(
        angles.items(), (1, 2), ("linear", "root of squares"), NOISE_FACTORS.items(), scales
    ):
        parts = ScaleFactorTest(angle=angle, readout=paper.EXAMPLE_READOUT, noise_factor=factor).parts
        values = [np.sqrt(readings / 2) * parts["readout"], scale * parts["bias"], scale * parts["noise"]]
        result = (sum(values) if how == "linear" else np.hypot.reduce(values)) / angle
        rows.append((name, readings, how, density, scale, result, result / paper.EXAMPLE_RESULT))
    frame = pd.DataFrame(rows, columns=["angle", "readings", "sum", "density", "scale", "result", "ratio"])
    return frame.sort_values("ratio", key=lambda ratio: abs(np.log(ratio)), ignore_index=True)


def simulate(test: ScaleFactorTest, runs: int, rng: np.random.Generator, steps: int = 360) -> np.ndarray:
    """Relative errors of a scale factor and of an asymmetry, from simulated tests in both directions.

    Parameters
    ----------
    test : ScaleFactorTest
        The test.
    runs, steps : int
        Simulated tests; samples of the white noise in each.
    rng : numpy.random.Generator
        Source of randomness.

    Returns
    -------
    ndarray, shape (2, runs)
        Relative error of the scale factor for positive rate; error of the asymmetry.
    """
    step = test.duration / steps
    density = test.noise * np.sqrt(test.noise_factor)  # two-sided, per Hz
    bias = rng.normal(0, test.bias_error, runs)
    relative = []
    for direction in (1, -1):
        rate = direction * test.angle / test.duration
        readings = rate + bias[:, None] + rng.normal(0, density / np.sqrt(step), (runs, steps))
        first, last = rng.normal(0, test.readout, (2, runs))
        # truth: scale factor 1; found: angle read over integral read
        relative.append((direction * test.angle + last - first) / (readings.sum(axis=1) * step) - 1)
    return np.array([relative[0], relative[0] - relative[1]])


def bias_spread(rate: float, scale: float) -> float:
    """Change of a scale factor, in its own unit, that the example's bias error makes at a rate, rad/s."""
    return scale * paper.EXAMPLE_BIAS_ERROR / abs(rate)
