"""Figures 5 to 11 over 100 seeds: errors of the filters with the gyros of table 4, and those of the smoother.

Inputs that the thesis does not state are as in `fogkit.reproduction.lechang.filtering`, the aid with 1 cm/s, headings
known to 10 degrees. `RUNS` holds the outcome of ``runs(range(100))``, written by
``python -m fogkit.reproduction.lechang.simulation_runs PATH``.

At the end the heading of `wander` scatters 1.15 times as much as it says in these 100 seeds. Of 600 others, 1000 to
1599 of ``filtering.runs_of(seed, 10 * DEG, 0.01, 0.05, ("wander",))``, it does so 1.01 times, with a chance error of
0.03.
"""

import sys
import warnings
from collections.abc import Iterable
from concurrent.futures import Executor
from typing import TYPE_CHECKING

import numpy as np

from fogkit.campaign import map_cases
from fogkit.claims.ledger import claims_folder
from fogkit.gyrocompass.error_model import STATES
from fogkit.gyrocompass.filters.extended import run_extended
from fogkit.gyrocompass.filters.runs import FilterRun
from fogkit.gyrocompass.filters.smoother import smooth_wander
from fogkit.gyrocompass.motions import Motion
from fogkit.reproduction.lechang import filtering, simulation
from fogkit.units import DEG, DEG_PER_HOUR, PERCENT

if TYPE_CHECKING:
    from pandas import DataFrame

RUNS = "lechang_simulation_runs.csv"
TIMES = (100, 200, 300, 400, 425, 450, 500, 550, 600, 700, 800, 900)
"""Times, s, that are kept: four with the mount off, the others 25 to 500 s after it was switched on."""

QUANTITIES = {
    **dict.fromkeys(("heading", "trim", "roll"), DEG),
    **dict.fromkeys(STATES[9:12], DEG_PER_HOUR),
    **dict.fromkeys(STATES[12:], PERCENT),
}
"""What figures 6 to 11 show, and the unit in which it is kept: degrees, degrees an hour, percent."""

COLUMNS = [STATES.index(name) for name in QUANTITIES]
SCALES = np.array(list(QUANTITIES.values()))


def errors_of(run: FilterRun, motion: Motion, bias: np.ndarray, scale: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Errors of a run and its standard deviations, each of shape (901, 9), in the units of `QUANTITIES`."""
    return run.errors(motion, bias, scale)[:, COLUMNS] / SCALES, run.std[:, COLUMNS] / SCALES


def one_seed(
    seed: int, velocity_std: float = 0.01, dt: float = filtering.STEP, heading_std: float = 10 * DEG
) -> dict[str, FilterRun]:
    """The thesis's filter, the one to use, and the smoother on one record with the gyros of table 4.

    Parameters
    ----------
    seed : int
        Of all that is random.
    velocity_std : float, optional
        Of the aid's velocity, once a second, m/s.
    dt : float, optional
        Step, s.
    heading_std : float, optional
        Standard deviation of the heading that the compass starts with, rad.

    Returns
    -------
    dict of FilterRun
        ``extended``, ``wander`` and ``smoothed``.
    """
    recording, fixes, noise, start, known, *_ = filtering.inputs(seed, heading_std, velocity_std, dt, drawn=False)
    with warnings.catch_warnings():  # of the thesis's filter: that it is wrong is what is shown
        warnings.filterwarnings("ignore", message="the aid departs")
        extended = run_extended(recording, fixes, noise, start, known)
    filtered, smoothed = smooth_wander(recording, fixes, noise, start, known)
    return {"extended": extended, "wander": filtered, "smoothed": smoothed}


def true_gyros() -> tuple[np.ndarray, np.ndarray]:
    """Biases, rad/s, and scale factors of table 4."""
    return simulation.paper.SIMULATED_BIASES, simulation.paper.SIMULATED_SCALE_FACTORS


def case(seed: int, velocity_std: float = 0.01, dt: float = filtering.STEP) -> list[dict]:
    """Rows of one seed: errors and standard deviations of each filter at `TIMES`."""
    rows = []
    for name, run in one_seed(seed, velocity_std, dt).items():
        error, std = errors_of(run, filtering.motion(dt), *true_gyros())
        for t in TIMES:
            rows.append({"filter": name, "seed": seed, "time": t})
            rows[-1] |= dict(zip(QUANTITIES, error[t], strict=True))
            rows[-1] |= {f"{q}_std": value for q, value in zip(QUANTITIES, std[t], strict=True)}
    return rows


def runs(seeds: Iterable[int], executor: Executor | None = None, dt: float = filtering.STEP) -> "DataFrame":
    """`case` of many seeds.

    Returns
    -------
    DataFrame
        Columns ``filter``, ``seed``, ``time`` (s), the nine of `QUANTITIES` (errors), and their standard deviations.
    """
    import pandas as pd

    filtering.motion(dt)  # once, before the workers start
    found = map_cases(case, [{"seed": seed, "dt": dt} for seed in seeds], executor=executor)
    return pd.DataFrame([row for rows in found for row in rows])


def stored() -> "DataFrame":
    """Runs that are kept."""
    import pandas as pd

    return pd.read_csv(claims_folder().parent / "derived" / RUNS)


def statistics(table: "DataFrame") -> "DataFrame":
    """Errors over seeds: root mean square, what the filter predicts, shares within one and three deviations.

    Parameters
    ----------
    table : DataFrame
        As from `runs`.

    Returns
    -------
    DataFrame
        Index ``filter``, ``quantity``, ``time``; columns ``rms``, ``predicted`` (root mean square of the standard
        deviations), ``within_1``, ``within_3``.
    """
    import pandas as pd

    names, rows = list(QUANTITIES), {}
    for (name, time), group in table.groupby(["filter", "time"]):
        error, std = group[names].to_numpy(), group[[f"{q}_std" for q in names]].to_numpy()
        ratio = np.abs(error) / std
        for k, quantity in enumerate(names):
            rows[name, quantity, time] = {
                "rms": np.sqrt((error[:, k] ** 2).mean()),
                "predicted": np.sqrt((std[:, k] ** 2).mean()),
                "within_1": (ratio[:, k] < 1).mean(),
                "within_3": (ratio[:, k] < 3).mean(),
            }
    found = pd.DataFrame.from_dict(rows, orient="index")
    found.index = pd.MultiIndex.from_tuples(found.index, names=["filter", "quantity", "time"])
    return found.sort_index()


if __name__ == "__main__":
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor() as pool:
        kept = runs(range(100), executor=pool)
    kept.to_csv(sys.argv[1], index=False, float_format="%.4g")
