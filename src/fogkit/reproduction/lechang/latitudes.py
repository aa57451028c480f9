"""The filter from the equator to near a pole, at rest and under way: is it consistent, and what does heading cost?

Heading is found from the level part of the Earth's rate, which falls with ``cos(lat)``: a gyro that gives degrees at 60
degrees north gives nothing at 89.9. So there is a second grade of gyros, 100 times better. The law is the thesis's,
180 degrees in 60 s, for 300 s; the aid measures velocity to 1 cm/s and position to 3 m once a second. Biases, scale
factors, start and noise are drawn from what the filter is told.

`LATITUDE_RUNS` holds the outcome of ``latitude_runs(range(20))``, written by
``python -m fogkit.reproduction.lechang.latitudes PATH``.
"""

import sys
from collections.abc import Iterable
from concurrent.futures import Executor
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from fogkit.campaign import map_cases
from fogkit.estimation.consistency import chi_square_interval, nees
from fogkit.gyrocompass.accuracy import heading_bound
from fogkit.gyrocompass.covariance import Aid, Noise, Prior
from fogkit.gyrocompass.filters.records import draw_start, record, take_fixes
from fogkit.gyrocompass.filters.wander import run_wander
from fogkit.gyrocompass.laws import QuasiHarmonic
from fogkit.gyrocompass.motions import Motion, Vessel
from fogkit.reproduction.lechang import paper
from fogkit.units import DEG, DEG_PER_HOUR, PERCENT

if TYPE_CHECKING:
    from pandas import DataFrame

LATITUDE_RUNS = "data/derived/lechang_latitudes.csv"
LATITUDES = (0.0, 30.0, 60.0, 80.0, 89.0, 89.9)
"""deg."""
HEADING_STDS = (10.0, 30.0)
"""deg."""
SPEEDS = (0.0, 5.0)
"""m/s."""
GRADES = (1.0, 0.01)
"""Random walk, biases and scale factors of the gyros, of those of the VG951 by its data sheet."""

DURATION, STEP = 300.0, 0.05
VELOCITY_STD = 0.01
LAW = QuasiHarmonic(amplitude=paper.EXPERIMENT_AMPLITUDE, period=paper.EXPERIMENT_PERIOD)


@cache
def motion(lat_deg: float, speed: float) -> Motion:
    """A vessel that rolls by 3 degrees and steers 80 degrees, so that its latitude stays."""
    vessel = Vessel(lat=lat_deg * DEG, heading=80 * DEG, trim=1 * DEG, roll_swing=3 * DEG, speed=speed)
    return vessel.motion(DURATION, STEP, LAW)


def prior(heading_std_deg: float, grade: float) -> Prior:
    """What is known at the start. Level to 0.01 degrees: products of tilts would swamp the best gyros' azimuth."""
    return Prior(
        heading=heading_std_deg * DEG,
        level=0.01 * DEG,
        velocity=0.1,
        bias=6 * DEG_PER_HOUR * grade,
        scale_factor=0.5 * PERCENT * grade,
    )


def noise(grade: float) -> Noise:
    """White noise of the gyros, by the two-sided reading of the data sheet."""
    return Noise(angle_random_walk=paper.random_walk_of_the_data_sheet(2) * grade)


def latitude_case(seed: int, lat_deg: float, heading_std_deg: float, speed: float, grade: float) -> dict:
    """One run: normalised error of the 17 states, error and standard deviation of heading at the end, deg."""
    rng, known, true = np.random.default_rng(seed), prior(heading_std_deg, grade), motion(lat_deg, speed)
    bias, scale = known.bias * rng.standard_normal(3), known.scale_factor * rng.standard_normal(3)
    recording = record(true, noise(grade), rng, bias=bias, scale_factor=scale)
    fixes = take_fixes(true, Aid.satellite(lat_deg * DEG, velocity=VELOCITY_STD), rng)
    start = draw_start(true, known, rng)
    run = run_wander(recording, fixes, noise(grade), start, known, output_interval=DURATION)
    errors = run.wander_errors(true, bias, scale)[-1]
    return {
        "lat": lat_deg,
        "heading_std": heading_std_deg,
        "speed": speed,
        "grade": grade,
        "seed": seed,
        "nees": float(nees(errors, run.wander_covariance[-1])),
        "heading_error": run.errors(true, bias, scale)[-1, 0] / DEG,
        "predicted_std": run.std[-1, 0] / DEG,
    }


def latitude_runs(
    seeds: Iterable[int], latitudes: Iterable[float] = LATITUDES, executor: Executor | None = None
) -> "DataFrame":
    """All latitudes, known headings, speeds and grades of gyro.

    Returns
    -------
    DataFrame
        Columns ``lat``, ``heading_std`` (deg), ``speed`` (m/s), ``grade``, ``seed``, ``nees`` (of 17),
        ``heading_error`` and ``predicted_std`` (deg).
    """
    import pandas as pd

    cases = [
        {"seed": seed, "lat_deg": lat, "heading_std_deg": heading, "speed": speed, "grade": grade}
        for lat in latitudes
        for heading in HEADING_STDS
        for speed in SPEEDS
        for grade in GRADES
        for seed in seeds
    ]
    return pd.DataFrame(map_cases(latitude_case, cases, executor=executor))


def bound(lat_deg: float, grade: float) -> float:
    """Smallest standard deviation of heading at rest, deg, with an aid without errors."""
    drift = prior(10.0, grade).bias
    walk = noise(grade).angle_random_walk[0]
    return heading_bound(LAW, DURATION, lat_deg * DEG, walk, bias_std=drift, drift_std=drift).std / DEG


def by_latitude(runs: "DataFrame") -> "DataFrame":
    """Consistency and accuracy over seeds.

    Returns
    -------
    DataFrame
        Index ``grade``, ``lat``, ``heading_std``, ``speed``; mean ``nees`` and whether it is within its bounds of 99.9
        percent, ``consistent``; root mean square ``heading_rms``, mean ``predicted_std`` and `bound`, deg.
    """
    groups = runs.groupby(["grade", "lat", "heading_std", "speed"])
    table = groups.agg(
        nees=("nees", "mean"),
        heading_rms=("heading_error", lambda e: np.sqrt((e**2).mean())),
        predicted_std=("predicted_std", "mean"),
        seeds=("seed", "nunique"),
    )
    limits = np.array([chi_square_interval(17, n, 0.999) for n in table.seeds])
    table["consistent"] = (limits[:, 0] < table.nees) & (table.nees < limits[:, 1])
    table["bound"] = [bound(lat, grade) for grade, lat, *_ in table.index]
    return table


if __name__ == "__main__":
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor() as pool:
        found = latitude_runs(range(20), executor=pool)
    found.to_csv(sys.argv[1], index=False, float_format="%.5f")
