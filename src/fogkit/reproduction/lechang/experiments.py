"""The thesis's second experiment: a VG951 unit rocked by 180 degrees in 60 s for five minutes, simulated many times.

Not stated are the latitude of the stand (taken as that of St Petersburg), the aid (here: velocity and position are
known not to change, to a standard deviation that is varied), accelerometers (taken as perfect) and what the filter
knows at the start. `PRIORS` are guesses of that; heading is known to 10 degrees and level to 0.1 degrees in all.

`RUNS` holds the outcome of ``accuracy_runs(range(100))``, written by
``python -m fogkit.reproduction.lechang.experiments PATH``.
"""

import sys
import warnings
from collections.abc import Iterable
from concurrent.futures import Executor
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit.campaign import map_cases
from fogkit.gyrocompass.accuracy import best_harmonic_amplitude
from fogkit.gyrocompass.covariance import Aid, Noise, Prior, run_covariance
from fogkit.gyrocompass.filters.records import draw_start, record, take_fixes
from fogkit.gyrocompass.filters.wander import run_wander
from fogkit.gyrocompass.filters.wander_estimates import WanderRun
from fogkit.gyrocompass.laws import ConstantSpeedReversal, MountLaw, QuasiHarmonic
from fogkit.gyrocompass.motions import Motion, Vessel
from fogkit.gyrocompass.mount_scale import scale_from_mount
from fogkit.reproduction.lechang import paper, scanning
from fogkit.units import ARCMIN, DEG, DEG_PER_HOUR, PERCENT

if TYPE_CHECKING:
    from pandas import DataFrame

RUNS = "data/derived/lechang_experiment_runs.csv"
STEP = 0.05
"""Step, s: the mount turns by less than a degree in it, and heading differs by 0.001 arcmin from that with 0.01 s."""

LAWS: dict[str, MountLaw] = {
    "harmonic 180": QuasiHarmonic(amplitude=paper.EXPERIMENT_AMPLITUDE, period=paper.EXPERIMENT_PERIOD),
    "harmonic 137.8": QuasiHarmonic(amplitude=best_harmonic_amplitude(), period=paper.EXPERIMENT_PERIOD),
    "reversal 180": ConstantSpeedReversal(amplitude=np.pi, period=paper.EXPERIMENT_PERIOD),
}
"""The law of the experiment, rocking that leaves no mean direction, and turning to and fro at constant speed."""

VELOCITY_STDS = (0.001, 0.01, 0.1)
"""Standard deviations of the aid's velocity, m/s, once a second: a unit bolted down, and two poorer ones."""

PRIORS = {
    "data sheet": (paper.DATA_SHEET_BIAS, paper.SCALE_FACTOR_ERROR[0.5], False),
    "data sheet, mount": (paper.DATA_SHEET_BIAS, paper.SCALE_FACTOR_ERROR[0.5], True),
    "table 6": (1.0 * DEG_PER_HOUR, 0.5 * PERCENT, False),
    "scan": (0.1 * DEG_PER_HOUR, 0.5 * PERCENT, False),
}
"""What is known at the start: standard deviations of the biases, rad/s, and of the scale factors, and whether the
latter are first corrected by the mount's own turns (`fogkit.gyrocompass.mount_scale`). The data sheet's; table 6,
whose last digit of 0.001 deg/s is uncertain by ``3.6/sqrt(12)`` deg/h; a scan of 12 minutes without drift."""

SCALE_BY_MOUNT = 1e-4
"""Standard deviation that the filter takes for scale factors corrected by the mount: above what is left of them."""

CELLS = (
    *(("harmonic 180", known) for known in PRIORS),
    *(("harmonic 137.8", known) for known in list(PRIORS)[1:]),
    *(("reversal 180", known) for known in list(PRIORS)[1:3]),
)
"""Laws and priors of the stored runs: the thesis's law with all, the better laws without the case that fails."""


@cache
def motion(law: str, dt: float = STEP) -> Motion:
    """The unit on the stand at rest, with the mount's law of that name, for five minutes."""
    stand = Vessel(lat=paper.ASSUMED_LATITUDE, heading=paper.STAND_HEADING)
    return stand.motion(paper.EXPERIMENT_TIME, dt, LAWS[law])


def prior(name: str) -> Prior:
    """What is known at the start."""
    bias, scale, _ = PRIORS[name]
    return Prior(
        heading=10 * DEG, level=0.1 * DEG, velocity=0.01, position=1.0, height=1.0, bias=bias, scale_factor=scale
    )


def aid(velocity_std: float) -> Aid:
    """Velocity and position that do not change."""
    return Aid.satellite(paper.ASSUMED_LATITUDE, velocity=velocity_std, position=1.0)


def noise(sides: int) -> Noise:
    """White noise of the data sheet, read as of a one- or a two-sided spectrum."""
    return Noise(angle_random_walk=paper.random_walk_of_the_data_sheet(sides))


def run_of(
    seed: int,
    law: str = "harmonic 180",
    sides: int = 2,
    velocity_std: float = 0.001,
    known: str = "scan",
    *,
    wrong_bias: ArrayLike | None = None,
    dt: float = STEP,
) -> tuple[WanderRun, NDArray[np.float64]]:
    """One run of the experiment.

    Parameters
    ----------
    seed : int
        Of all that is random.
    law : str, optional
        One of `LAWS`.
    sides : int, optional
        Reading of the data sheet's noise: 1 or 2.
    velocity_std : float, optional
        Of the aid, m/s.
    known : str, optional
        One of `PRIORS`.
    wrong_bias : array_like, shape (3,), optional
        True biases, rad/s, instead of ones drawn from the prior.
    dt : float, optional
        Step, s.

    Returns
    -------
    tuple
        The filter's run, and errors of its estimates over time, shape (301, 15).
    """
    rng, start, true = np.random.default_rng(seed), prior(known), motion(law, dt)
    bias, scale = start.bias * rng.standard_normal(3), start.scale_factor * rng.standard_normal(3)
    if wrong_bias is not None:
        bias = np.asarray(wrong_bias, dtype=float)
    recording = record(true, noise(sides), rng, bias=bias, scale_factor=scale)
    fixes = take_fixes(true, aid(velocity_std), rng)
    first, left = draw_start(true, start, rng), scale
    if PRIORS[known][2]:
        found, _ = scale_from_mount(recording)
        recording, left = replace(recording, dtheta=recording.dtheta / (1 + found)), (scale - found) / (1 + found)
        start = replace(start, scale_factor=SCALE_BY_MOUNT)
    with warnings.catch_warnings():  # where the filter is wrong its innovations say so, and are returned
        warnings.filterwarnings("ignore", message="the aid departs")
        run = run_wander(recording, fixes, noise(sides), first, start)
    return run, run.errors(true, bias, left)


def accuracy_case(seed: int, law: str, sides: int, velocity_std: float, known: str, dt: float = STEP) -> dict:
    """Error of heading after five minutes in one run, arcmin, its standard deviation by the filter, and the root mean
    square of the normalised innovations, 1 if the filter is right."""
    run, errors = run_of(seed, law, sides, velocity_std, known, dt=dt)
    return {
        "law": law,
        "sides": sides,
        "velocity_std": velocity_std,
        "prior": known,
        "seed": seed,
        "error_arcmin": errors[-1, 0] / ARCMIN,
        "std_arcmin": run.std[-1, 0] / ARCMIN,
        "innovations": np.sqrt(run.nis.sum() / run.fix_count.sum()),
    }


def accuracy_runs(seeds: Iterable[int], executor: Executor | None = None) -> "DataFrame":
    """`accuracy_case` for all readings of the noise, aids and seeds; for laws and priors those of `CELLS`."""
    import pandas as pd

    for law in LAWS:
        motion(law)  # once, before the workers start
    cases = [
        {"seed": seed, "law": law, "sides": sides, "velocity_std": velocity, "known": known}
        for law, known in CELLS
        for sides in (1, 2)
        for velocity in VELOCITY_STDS
        for seed in seeds
    ]
    return pd.DataFrame(map_cases(accuracy_case, cases, executor=executor))


def predicted_std(law: str, sides: int, velocity_std: float, known: str) -> float:
    """Standard deviation of heading after five minutes by the covariance alone, rad."""
    start = prior(known)
    if PRIORS[known][2]:
        start = replace(start, scale_factor=SCALE_BY_MOUNT)
    run = run_covariance(motion(law), noise(sides), aid(velocity_std), start)
    return float(run.of("heading")[-1])


def known_scale_std(law: str = "harmonic 180") -> NDArray[np.float64]:
    """Standard deviations of the scale factors after five minutes, with nothing but the data sheet before, (3,)."""
    run = run_covariance(motion(law), noise(2), aid(0.001), prior("data sheet"))
    return run.std[-1, 12:]


def branch_runs(seeds: Iterable[int], law: str = "harmonic 180") -> NDArray[np.float64]:
    """Error of heading, rad, where biases are those that go with the other heading of the scan: shape (seeds,).

    The filter holds the biases of a scan read as 58.5 degrees for known to 0.1 deg/h, the stand has 121.5 degrees.
    """
    fit = scanning.other_heading()
    right = int(np.argmin(np.abs(fit.headings - paper.STAND_HEADING)))
    wrong = fit.biases[right] - fit.biases[1 - right]
    return np.array([run_of(seed, law, known="scan", wrong_bias=wrong)[1][-1, 0] for seed in seeds])


def within(runs: "DataFrame", limit: float = paper.EXPERIMENT_ACCURACY) -> "DataFrame":
    """How often heading is within a limit (rad), by law, prior, aid and reading of the noise.

    Parameters
    ----------
    runs : DataFrame
        From `accuracy_runs`.
    limit : float, optional
        Rad; that of the thesis, 30 arcmin.

    Returns
    -------
    DataFrame
        Index ``law``, ``prior``, ``velocity_std``, ``sides``; share of the runs, its 95 percent interval (Clopper and
        Pearson) ``low`` and ``high``, root mean square error and mean predicted deviation, arcmin, and the share that
        a normal error of that deviation would have.
    """
    import pandas as pd
    from scipy.stats import beta, norm

    limit = limit / ARCMIN
    groups = runs.groupby(["law", "prior", "velocity_std", "sides"])
    met = groups.error_arcmin.apply(lambda e: (e.abs() <= limit).sum())
    count, std = groups.size(), groups.std_arcmin.mean()
    return pd.DataFrame(
        {
            "share": met / count,
            "low": np.where(met > 0, beta.ppf(0.025, np.maximum(met, 0.5), count - met + 1), 0.0),
            "high": np.where(met < count, beta.ppf(0.975, met + 1, np.maximum(count - met, 0.5)), 1.0),
            "rms_arcmin": np.sqrt(groups.error_arcmin.apply(lambda e: (e**2).mean())),
            "std_arcmin": std,
            "normal": 2 * norm.cdf(limit / std) - 1,
        }
    )


if __name__ == "__main__":
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor() as pool:
        table = accuracy_runs(range(100), executor=pool)
    table.to_csv(sys.argv[1], index=False, float_format="%.4f")
