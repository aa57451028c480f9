"""The thesis's simulation with a filter, over many seeds: what converges when, and which filter may be believed.

What is not stated is as in `simulation`: latitude of St Petersburg, mount switched on after 400 s, an aid of any
accuracy, a start from the errors of table 4. Level angles and velocity are taken as known to 0.1 degrees and 0.1 m/s.

`NEES_RUNS` holds the outcome of ``consistency_runs(range(100), (0.01,))``, written by
``python -m fogkit.reproduction.lechang.filtering PATH``.
"""

import sys
import warnings
from collections.abc import Iterable
from concurrent.futures import Executor
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from fogkit.campaign import map_cases
from fogkit.estimation.consistency import nees
from fogkit.gyrocompass.covariance import Aid, Noise, Prior
from fogkit.gyrocompass.filters.extended import run_extended
from fogkit.gyrocompass.filters.records import draw_start, record, take_fixes
from fogkit.gyrocompass.filters.runs import FilterRun
from fogkit.gyrocompass.filters.wander import run_wander
from fogkit.gyrocompass.laws import SwitchedOn
from fogkit.gyrocompass.motions import Motion
from fogkit.reproduction.lechang import paper, simulation
from fogkit.units import DEG, DEG_PER_HOUR, PERCENT

if TYPE_CHECKING:
    from pandas import DataFrame

NEES_RUNS = "data/derived/lechang_nees_runs.csv"
STEP = 0.01
HEADING_STDS = (10 * DEG, 30 * DEG)
TIMES = (100, 400, 450, 500, 600, 700, 900)
"""Times, s, at which consistency is looked at: two with the mount off, and 50 to 500 s after it was switched on."""

FILTERS = {"extended": run_extended, "wander": run_wander}


@cache
def motion(dt: float = STEP) -> Motion:
    """The vessel's motion of 900 s, the mount off, then on."""
    law = SwitchedOn(law=simulation.mount(), start=simulation.ASSUMED_SWITCH_ON)
    return simulation.vessel().motion(simulation.ASSUMED_DURATION, dt, law)


def prior(heading_std: float) -> Prior:
    """What is known at the start: gyros as the largest errors of table 4."""
    return Prior(
        heading=heading_std,
        level=0.1 * DEG,
        velocity=0.1,
        bias=np.abs(paper.SIMULATED_BIASES).max(),
        scale_factor=paper.SIMULATED_SCALE_FACTORS.max(),
    )


def inputs(seed: int, heading_std: float, velocity_std: float, dt: float = STEP, drawn: bool = True) -> tuple:
    """Record, measurements, noise, start and prior that a filter takes, true biases, scale factors: see `runs_of`."""
    rng, known, true = np.random.default_rng(seed), prior(heading_std), motion(dt)
    bias, scale = paper.SIMULATED_BIASES, paper.SIMULATED_SCALE_FACTORS
    if drawn:
        bias, scale = known.bias * rng.standard_normal(3), known.scale_factor * rng.standard_normal(3)
    noise = Noise(angle_random_walk=paper.SIMULATED_RANDOM_WALK)
    recording = record(true, noise, rng, bias=bias, scale_factor=scale)
    fixes = take_fixes(true, Aid.satellite(paper.ASSUMED_LATITUDE, velocity=velocity_std), rng)
    return recording, fixes, noise, draw_start(true, known, rng), known, bias, scale


def runs_of(
    seed: int,
    heading_std: float,
    velocity_std: float,
    dt: float = STEP,
    names: Iterable[str] = tuple(FILTERS),
    drawn=True,
) -> tuple[dict[str, FilterRun], np.ndarray, np.ndarray]:
    """Runs of the filters on one record, and the true biases and scale factors.

    Parameters
    ----------
    seed : int
        Of all that is random.
    heading_std : float
        Standard deviation of the heading that the compass starts with, rad.
    velocity_std : float
        Of the aid's velocity, once a second, m/s.
    dt : float, optional
        Step, s.
    names : iterable of str, optional
        Which of `FILTERS`.
    drawn : bool, optional
        True: biases and scale factors are drawn from the prior, as consistency asks. False: those of table 4.
    """
    recording, fixes, noise, start, known, bias, scale = inputs(seed, heading_std, velocity_std, dt, drawn)
    with warnings.catch_warnings():  # a filter that is wrong is what is looked for here
        warnings.filterwarnings("ignore", message="the aid departs")
        runs = {name: FILTERS[name](recording, fixes, noise, start, known) for name in names}
    return runs, bias, scale


def consistency_case(seed: int, heading_std: float, velocity_std: float, dt: float = STEP) -> list[dict]:
    """Normalised errors of both filters at `TIMES` of one run."""
    runs, bias, scale = runs_of(seed, heading_std, velocity_std, dt)
    true, rows = motion(dt), []
    for name, run in runs.items():
        heading = run.errors(true, bias, scale)[:, 0]
        if name == "wander":
            errors, P = run.wander_errors(true, bias, scale), run.wander_covariance
        else:
            errors, P = run.errors(true, bias, scale), run.covariance
        rows += [
            {
                "filter": name,
                "heading_std": round(heading_std / DEG, 6),
                "velocity_std": velocity_std,
                "seed": seed,
                "time": t,
                "nees": nees(errors[t], P[t]),
                "heading_error": heading[t] / DEG,
                "predicted_std": run.std[t, 0] / DEG,
            }
            for t in TIMES
        ]
    return rows


def consistency_runs(
    seeds: Iterable[int], velocity_stds: Iterable[float] = (0.01,), executor: Executor | None = None, dt: float = STEP
) -> "DataFrame":
    """Both filters from headings known to 10 and 30 degrees.

    Returns
    -------
    DataFrame
        Columns ``filter``, ``heading_std`` (deg), ``velocity_std`` (m/s), ``seed``, ``time`` (s), ``nees``,
        ``heading_error`` and ``predicted_std`` (deg): the former is of 15 errors for the thesis's filter and of 17 for
        the other.
    """
    import pandas as pd

    cases = [
        {"seed": seed, "heading_std": heading, "velocity_std": velocity, "dt": dt}
        for velocity in velocity_stds
        for heading in HEADING_STDS
        for seed in seeds
    ]
    found = map_cases(consistency_case, cases, executor=executor)
    return pd.DataFrame([row for rows in found for row in rows])


def headings_that_move(seeds: Iterable[int], heading_std: float = 10 * DEG, dt: float = 0.1) -> "DataFrame":
    """How far the computed heading of the thesis's filter moves with the mount off, and what it then claims.

    Parameters
    ----------
    seeds : iterable of int
        Of the runs.
    heading_std : float, optional
        Standard deviation of the heading at the start, rad.
    dt : float, optional
        Step, s.

    Returns
    -------
    DataFrame
        Index ``seed``; ``moved`` (highest less lowest computed heading) and ``claimed`` (standard deviation when the
        mount is switched on), deg. Along a heading that does not move nothing is learnt of it.
    """
    import pandas as pd

    end, rows = round(simulation.ASSUMED_SWITCH_ON), {}
    for seed in seeds:
        run = runs_of(seed, heading_std, 0.01, dt, names=("extended",))[0]["extended"]
        heading = np.unwrap(run.estimate[: end + 1, 0])
        rows[seed] = {"moved": np.ptp(heading) / DEG, "claimed": run.std[end, 0] / DEG}
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("seed")


def thesis_case(seed: int, velocity_std: float, heading_std: float = 10 * DEG, dt: float = STEP) -> np.ndarray:
    """Errors and standard deviations, shape (2, 901, 15), of the recommended filter with the gyros of table 4."""
    runs, bias, scale = runs_of(seed, heading_std, velocity_std, dt, names=("wander",), drawn=False)
    run = runs["wander"]
    return np.stack([run.errors(motion(dt), bias, scale), run.std])


def thesis_runs(
    seeds: Iterable[int], velocity_std: float, heading_std: float = 10 * DEG, executor: Executor | None = None, dt=STEP
) -> np.ndarray:
    """`thesis_case` of many seeds, shape (seeds, 2, 901, 15)."""
    motion(dt)  # once, before the workers start
    cases = [{"seed": s, "velocity_std": velocity_std, "heading_std": heading_std, "dt": dt} for s in seeds]
    return np.array(map_cases(thesis_case, cases, executor=executor))


def convergence(runs: np.ndarray) -> "DataFrame":
    """What figures 6 to 8 show, over seeds: errors and bounds with the mount off and after it was switched on.

    Parameters
    ----------
    runs : ndarray, shape (n, 2, 901, 15)
        From `thesis_runs`.

    Returns
    -------
    DataFrame
        Index ``time`` (s); root mean square errors of heading (deg), of the biases (deg/h) and the scale factors
        (percent), the largest of three, the same as predicted, and the shares of all errors of heading, biases and
        scale factors within one and three of their standard deviations.
    """
    import pandas as pd

    kept, rows = [0, *range(9, 15)], []
    for t in TIMES:
        errors, std = runs[:, 0, t], runs[:, 1, t]
        rms, predicted = (np.sqrt((values**2).mean(axis=0)) for values in (errors, std))
        ratio = np.abs(errors[:, kept]) / std[:, kept]
        rows.append(
            {
                "time": t,
                "heading_deg": rms[0] / DEG,
                "heading_predicted_deg": predicted[0] / DEG,
                "bias_dph": rms[9:12].max() / DEG_PER_HOUR,
                "bias_predicted_dph": predicted[9:12].max() / DEG_PER_HOUR,
                "scale_percent": rms[12:].max() / PERCENT,
                "scale_predicted_percent": predicted[12:].max() / PERCENT,
                "within_1": (ratio < 1).mean(),
                "within_3": (ratio < 3).mean(),
            }
        )
    return pd.DataFrame(rows).set_index("time")


if __name__ == "__main__":
    from concurrent.futures import ThreadPoolExecutor

    motion()
    with ThreadPoolExecutor() as pool:
        table = consistency_runs(range(100), executor=pool)
    table.to_csv(sys.argv[1], index=False, float_format="%.5f")
