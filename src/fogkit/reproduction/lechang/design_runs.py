"""Designs put to the test: runs of the filter on simulated records against what the design function says beforehand.

`DESIGN_RUNS` holds the outcome of ``design_runs(range(100))``, written by
``python -m fogkit.reproduction.lechang.design_runs PATH``.
"""

import sys
import warnings
from collections.abc import Iterable
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from fogkit.campaign import map_cases
from fogkit.gyrocompass.accuracy import best_harmonic_amplitude
from fogkit.gyrocompass.covariance import Aid, Noise, Prior
from fogkit.gyrocompass.design import HeadingAccuracy, heading_accuracy
from fogkit.gyrocompass.design_inputs import GyroGrade
from fogkit.gyrocompass.filters.records import draw_start, record, take_fixes
from fogkit.gyrocompass.filters.wander import run_wander
from fogkit.gyrocompass.laws import ConstantSpeedReversal, MountLaw, QuasiHarmonic
from fogkit.gyrocompass.motions import Motion, Vessel
from fogkit.units import DEG, DEG_PER_HOUR, DEG_PER_HOUR_PER_SQRT_HOUR, DEG_PER_SQRT_HOUR, PPM

if TYPE_CHECKING:
    from pandas import DataFrame

DESIGN_RUNS = "data/derived/lechang_design_runs.csv"
STEP = 0.05
HEADING = 40 * DEG

LOW_COST = GyroGrade(angle_random_walk=0.0125 * DEG_PER_SQRT_HOUR, bias=20 * DEG_PER_HOUR)
"""As an open-loop gyro's data sheet has it, such as the VG951 of the thesis."""

MIDDLE = GyroGrade(
    angle_random_walk=0.003 * DEG_PER_SQRT_HOUR,
    bias=0.5 * DEG_PER_HOUR,
    rate_random_walk=0.2 * DEG_PER_HOUR_PER_SQRT_HOUR,
    scale_factor=300 * PPM,
)
"""A closed-loop gyro of a ship's compass."""

THESIS = QuasiHarmonic(amplitude=np.pi, period=60.0)
ROCKING = QuasiHarmonic(amplitude=best_harmonic_amplitude(), period=60.0)
REVERSAL = ConstantSpeedReversal(amplitude=np.pi, period=60.0)


@dataclass(frozen=True, kw_only=True)
class DesignCase:
    """Gyros, law, latitude, time and accuracy of the aid's velocity, m/s, once a second."""

    gyro: GyroGrade
    law: MountLaw
    lat: float
    velocity_std: float
    duration: float = 300.0

    @property
    def aid(self) -> Aid:
        """Velocity and position."""
        return Aid.satellite(self.lat, velocity=self.velocity_std)

    def predicted(self) -> HeadingAccuracy:
        """What the design function says, without its warnings."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return heading_accuracy(self.gyro, self.law, self.lat, self.duration, aid=self.aid)

    def motion(self) -> Motion:
        """The hull at rest."""
        return Vessel(lat=self.lat, heading=HEADING).motion(self.duration, STEP, self.law)


CASES = {
    "at rest, known": DesignCase(gyro=LOW_COST, law=REVERSAL, lat=60 * DEG, velocity_std=0.001),
    "good gyros": DesignCase(gyro=MIDDLE, law=ROCKING, lat=45 * DEG, velocity_std=0.01),
    "poor aid, 180 deg": DesignCase(gyro=LOW_COST, law=THESIS, lat=60 * DEG, velocity_std=0.1),
    "poor aid, zero mean": DesignCase(gyro=LOW_COST, law=ROCKING, lat=60 * DEG, velocity_std=0.1),
    "asymmetry, rocking": DesignCase(
        gyro=replace(LOW_COST, scale_asymmetry=20 * PPM), law=ROCKING, lat=60 * DEG, velocity_std=0.001
    ),
    "asymmetry, reversal": DesignCase(
        gyro=replace(LOW_COST, scale_asymmetry=20 * PPM), law=REVERSAL, lat=60 * DEG, velocity_std=0.001
    ),
}
"""Two where the bound for white noise is nearly reached, and four where it says too little or could.

:meta hide-value:
"""


@cache
def _motion(name: str) -> Motion:
    return CASES[name].motion()


def design_case(name: str, seed: int) -> dict:
    """Error of heading at the end of one run, and the standard deviation that the filter states, degrees.

    The filter knows nothing of heading at the start, and nothing of asymmetry at all.
    """
    case, rng = CASES[name], np.random.default_rng(seed)
    gyro, motion = case.gyro, _motion(name)
    prior = Prior(heading=30 * DEG, level=0.1 * DEG, velocity=0.1, bias=gyro.bias, scale_factor=gyro.scale_factor)
    noise = Noise(angle_random_walk=gyro.angle_random_walk, rate_random_walk=gyro.rate_random_walk)
    bias, scale = gyro.bias * rng.standard_normal(3), gyro.scale_factor * rng.standard_normal(3)
    asymmetry = gyro.scale_asymmetry * rng.standard_normal(3)
    clean = record(motion, noise, rng, bias=bias, scale_factor=scale)
    recording = replace(clean, dtheta=clean.dtheta + 0.5 * asymmetry * np.abs(clean.dtheta))
    fixes, start = take_fixes(motion, case.aid, rng), draw_start(motion, prior, rng)
    with warnings.catch_warnings():  # a filter that does not know asymmetry may notice it
        warnings.filterwarnings("ignore", message="the aid departs")
        run = run_wander(recording, fixes, noise, start, prior, heading_known=False)
    return {
        "case": name,
        "seed": seed,
        "heading_error": run.errors(motion, bias, scale)[-1, 0] / DEG,
        "filter_std": run.std[-1, 0] / DEG,
    }


def design_runs(seeds: Iterable[int], executor: Executor | None = None) -> "DataFrame":
    """`design_case` of all `CASES` and seeds: a table with the columns ``case``, ``seed`` and, in degrees,
    ``heading_error`` and ``filter_std``."""
    import pandas as pd

    cases = [{"name": name, "seed": seed} for name in CASES for seed in seeds]
    return pd.DataFrame(map_cases(design_case, cases, executor=executor))


def summary(runs: "DataFrame") -> "DataFrame":
    """Runs against predictions, degrees: index ``case``; root mean square error, what the filter states, what the
    design function says with and without what it adds for the aid and for asymmetry."""
    import pandas as pd

    rows = {}
    for name, group in runs.groupby("case", sort=False):
        predicted = CASES[name].predicted()
        kept = [v for part, v in predicted.budget.items() if part not in ("aid", "asymmetry")]
        rows[name] = {
            "rms": np.sqrt((group.heading_error**2).mean()),
            "filter": np.sqrt((group.filter_std**2).mean()),
            "design": predicted.std / DEG,
            "bound": float(np.sqrt(np.sum(np.square(kept)))) / DEG,
            "largest part": predicted.largest,
        }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("case")


if __name__ == "__main__":
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor() as pool:
        table = design_runs(range(100), executor=pool)
    table.to_csv(sys.argv[1], index=False, float_format="%.5f")
