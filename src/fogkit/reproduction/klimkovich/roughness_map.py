"""How rough may the table be? Convergence of the three matrices over roughness and seeds, stored in the repository.

The map takes minutes, so it stands in the repository, ``data/derived/klimkovich_roughness.csv``, as `compute` made it;
a test computes some of its rows again.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from fogkit.reproduction.klimkovich.convergence import LONG, compare_matrices
from fogkit.reproduction.klimkovich.trials import Trial

if TYPE_CHECKING:
    from pandas import DataFrame

ROUGHNESSES = (0.0, 0.3, 1.0, 2.0, 3.0, 5.0, 10.0)
SEEDS = tuple(range(1, 9))
RATE = 50.0
"""Samples per second: the motion is smooth and the noise the same per second."""

NAME = "klimkovich_roughness.csv"
"""Of the file, in ``data/derived``."""


def compute(
    roughnesses: Sequence[float] = ROUGHNESSES, seeds: Sequence[int] = SEEDS, attitude: str = "true"
) -> "DataFrame":
    """Compare the matrices on tables of each roughness, with and without noise.

    Parameters
    ----------
    roughnesses, seeds : sequence, optional
        Of the trials.
    attitude : str, optional
        At the start of the tests. The true one shows the matrices alone; the plan's adds an error that they share.

    Returns
    -------
    DataFrame
        A row for each roughness, seed, noise and matrix: columns of `convergence.compare_matrices`. Iterations are
        missing where the iteration diverges, and all of a trial whose recordings the method refuses as those of another
        plan: then "refused" is True.
    """
    import pandas as pd

    parts = []
    for roughness in roughnesses:
        for seed in seeds:
            for noisy in (False, True):
                trial = Trial(roughness=roughness, seed=seed, noisy=noisy, rate=RATE)
                key = {"roughness": roughness, "seed": seed, "noisy": noisy}
                try:
                    found = compare_matrices(trial, attitude=attitude, iterations=LONG).reset_index()
                except ValueError:  # a turn that departs from the plan by more than the method lets pass
                    parts.append(pd.DataFrame([key | {"refused": True}]))
                    continue
                parts.append(found.assign(**key, refused=False))
    table = pd.concat(parts, ignore_index=True)
    return table[["roughness", "seed", "noisy", "matrix", "refused", *_measures(table)]]


def _measures(table: "DataFrame") -> list[str]:
    return [name for name in table.columns if name not in ("roughness", "seed", "noisy", "matrix", "refused")]


def summary(table: "DataFrame") -> "DataFrame":
    """Medians over the seeds whose iteration did not diverge, and how many these are, by noise, roughness and matrix.

    With iterations that go on, ``LONG`` of them do not mean convergence: "iterations" is then near `LONG`.
    """
    ran = table[~table["refused"].astype(bool)]
    groups = ran.groupby(["noisy", "roughness", "matrix"])
    result = groups[["iterations", "rms_z", "gyro_angle_arcsec", "gyro_scale_ppm"]].median()
    return result.assign(finished=groups["iterations"].count(), tried=groups.size())
