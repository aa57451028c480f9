"""May a filter take the velocity to turn with the hull? What it gains in a turn, and what it loses in waves.

A vessel that turns changes its velocity, and how fast the gyros know. With heading hardly known that acceleration is
known in the hull only; a filter that takes the measured force for it has the product of two errors in its model. Taken
to turn with the hull it is known without. But in waves a hull yaws, and its velocity does not.

`COURSE_RUNS` holds the outcome of ``course_runs(range(100))``, written by
``python -m fogkit.reproduction.lechang.course PATH``.
"""

import sys
import warnings
from collections.abc import Iterable
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fogkit import checks
from fogkit.campaign import map_cases
from fogkit.estimation.consistency import chi_square_interval, nees
from fogkit.gyrocompass.covariance import Aid
from fogkit.gyrocompass.filters.records import Recording, draw_start, record, take_fixes
from fogkit.gyrocompass.filters.wander import run_wander
from fogkit.gyrocompass.laws import MountLaw
from fogkit.reproduction.lechang import manoeuvres, paper
from fogkit.rotation import dcm_from_rotvec
from fogkit.units import DEG

if TYPE_CHECKING:
    from pandas import DataFrame

COURSE_RUNS = "data/derived/lechang_course_runs.csv"
SPEED, VELOCITY_STD = 5.0, 0.01
PRIOR = replace(manoeuvres.PRIOR, heading=30 * DEG)
YAW_SWING, YAW_PERIOD = 5 * DEG, 10.0


@dataclass(frozen=True, kw_only=True)
class Way:
    """What the hull does, what the mount does, and by how much, rad, the hull yaws in waves while its course stays."""

    turning: MountLaw | None = None
    mount: MountLaw | None = None
    yaw: float = 0.0


WAYS = {
    "zig-zag by 45 deg": Way(turning=manoeuvres.HULL_LAWS["hull: zig-zag by 45 deg"]),
    "circle in 100 s": Way(turning=manoeuvres.HULL_LAWS["hull: circle in 100 s"]),
    "yawing by 5 deg, mount rocked": Way(mount=manoeuvres.MOUNT_LAWS["mount rocked by 137.8 deg"], yaw=YAW_SWING),
}


def yawing(recording: Recording, swing: float, period: float) -> Recording:
    """The record of a hull that yaws harmonically about its up axis while it moves on as before.

    Gyros turn with the mount against the hull. A hull that has turned by an angle and a mount that has turned back by
    it leave them where they were: their readings stay, the mount's angle is less, and the specific force is that in the
    turned hull.

    Parameters
    ----------
    recording : Recording
        Of a hull that keeps its heading.
    swing, period : float
        rad, s; counter-clockwise first.

    Returns
    -------
    Recording
        At whole periods the hull looks where it did.
    """
    swing, period = checks.finite("swing", swing, "rad"), checks.positive("period", period, "s")
    yaw = swing * np.sin(2 * np.pi * recording.dt * np.arange(len(recording.dtheta) + 1) / period)
    middle = 0.5 * (yaw[1:] + yaw[:-1])
    back = dcm_from_rotvec(np.outer(middle, [0.0, -1.0, 0.0]))
    return replace(recording, mount_angle=recording.mount_angle - yaw, dv=(back @ recording.dv[..., None])[..., 0])


def course_case(name: str, seed: int, follows: bool) -> dict:
    """One run of a way: normalised error of the 17 states, error and standard deviation of heading at the end, deg."""
    way, rng = WAYS[name], np.random.default_rng(seed)
    motion = manoeuvres.vessel(SPEED, way.turning).motion(manoeuvres.DURATION, manoeuvres.STEP, way.mount)
    bias, scale = PRIOR.bias * rng.standard_normal(3), PRIOR.scale_factor * rng.standard_normal(3)
    recording = record(motion, manoeuvres.NOISE, rng, bias=bias, scale_factor=scale)
    fixes = take_fixes(motion, Aid.satellite(paper.ASSUMED_LATITUDE, velocity=VELOCITY_STD), rng)
    start = draw_start(motion, PRIOR, rng)
    if way.yaw:
        recording = yawing(recording, way.yaw, YAW_PERIOD)
    options = {"output_interval": manoeuvres.DURATION, "course_follows_heading": follows}
    with warnings.catch_warnings():  # of turns with heading hardly known, which is what is looked at here
        warnings.filterwarnings("ignore", message="the hull turns|the aid departs")
        run = run_wander(recording, fixes, manoeuvres.NOISE, start, PRIOR, **options)
    return {
        "way": name,
        "follows": follows,
        "seed": seed,
        "nees": float(nees(run.wander_errors(motion, bias, scale)[-1], run.wander_covariance[-1])),
        "heading_error": run.errors(motion, bias, scale)[-1, 0] / DEG,
        "predicted_std": run.std[-1, 0] / DEG,
    }


def course_runs(seeds: Iterable[int], executor: Executor | None = None) -> "DataFrame":
    """All ways with the velocity free (``follows`` False) and with it turning with the hull.

    Returns
    -------
    DataFrame
        Columns ``way``, ``follows``, ``seed``, ``nees`` (of 17), ``heading_error`` and ``predicted_std`` (deg).
    """
    import pandas as pd

    cases = [{"name": name, "seed": seed, "follows": f} for name in WAYS for f in (False, True) for seed in seeds]
    return pd.DataFrame(map_cases(course_case, cases, executor=executor))


def by_way(runs: "DataFrame") -> "DataFrame":
    """Consistency over seeds.

    Returns
    -------
    DataFrame
        Index ``way``, ``follows``; mean ``nees`` and whether it is within its bounds of 99.9 percent, ``consistent``;
        root mean square ``heading_rms`` and mean ``predicted_std`` of heading, deg.
    """
    table = runs.groupby(["way", "follows"], sort=False).agg(
        nees=("nees", "mean"),
        heading_rms=("heading_error", lambda e: np.sqrt((e**2).mean())),
        predicted_std=("predicted_std", "mean"),
    )
    low, high = chi_square_interval(17, runs.seed.nunique(), 0.999)
    table["consistent"] = (low < table.nees) & (table.nees < high)
    return table


if __name__ == "__main__":
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor() as pool:
        found = course_runs(range(100), executor=pool)
    found.to_csv(sys.argv[1], index=False, float_format="%.5f")
