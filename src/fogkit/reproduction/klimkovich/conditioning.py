"""How well plans of the paper's kind are conditioned: three chained turns about each axis, by any quarter turns.

The paper chooses turns by 90, 180 and 90 deg, besides whole turns, for the best conditioning, and does not say by which
measure. `chained_plans` are all plans that differ from the recovered one in these three angles only.
"""

from functools import cache
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.calibration.navigation_based import turn_model
from fogkit.reproduction.klimkovich import paper, plan_search
from fogkit.rotation import dcm_from_rotvec

if TYPE_CHECKING:
    from pandas import DataFrame

MEASURES = ("condition", "scaled condition", "sum of variances", "determinant")
"""What `chained_plans` compares; the smaller, the better."""

PRINTED = (90, 180, 90)
"""Angles of the paper's plan besides whole turns, deg."""

_TIE = 1e-9  # relative; plans with the same rows in another order differ by rounding


def chained_plan(quarters: tuple[int, int, int], turns: int = paper.TURNS) -> plan_search.Plan:
    """Nine tests with these quarter turns about each axis in the starts of the recovered plan, each block chained.

    Parameters
    ----------
    quarters : tuple of int
        Quarter turns of the first, second and third test of each block.
    turns : int, optional
        Whole turns added to each.
    """
    whole = 4 * checks.integer("turns", turns, minimum=0)
    plan = []
    for tests in paper.BLOCKS.values():
        first = plan_search.recovered_plan()[tests[0] - 1]
        start = first.start
        for count in quarters:
            plan.append(plan_search.Turn(start, first.axis, whole + count))
            start = _end(plan[-1])
    return tuple(plan)


@cache
def _rows(turn: plan_search.Turn) -> NDArray[np.float64]:
    return turn.rows()


@cache
def _end(turn: plan_search.Turn) -> str:
    return turn.end


@cache
def chained_plans(turns: int = paper.TURNS) -> "DataFrame":
    """Measures of all 64 plans with turns by 90 to 360 deg besides whole turns.

    Returns
    -------
    DataFrame
        Index: the three angles, deg. Columns: "rank", then `MEASURES`: condition of the matrix in multiples of gravity;
        the same with columns of unit length; sum of the variances; and the fifteenth root of the determinant of the
        covariance. Infinite where a parameter is lost.
    """
    import pandas as pd

    rows = {}
    for quarters in product((1, 2, 3, 4), repeat=3):
        H = np.concatenate([_rows(turn) for turn in chained_plan(quarters, turns)])
        rank = np.linalg.matrix_rank(H, tol=1e-9)
        values = (np.inf,) * len(MEASURES)
        if rank == H.shape[1]:
            singular = np.linalg.svd(H, compute_uv=False)
            scaled = np.linalg.cond(H / np.linalg.norm(H, axis=0))
            values = (singular[0] / singular[-1], scaled, np.sum(singular**-2), np.prod(singular) ** (-2 / 15))
        rows[tuple(90 * count for count in quarters)] = (rank, *values)
    index = pd.MultiIndex.from_tuples(rows, names=["first", "second", "third"])
    return pd.DataFrame(list(rows.values()), index=index, columns=["rank", *MEASURES])


def ranks_of_the_printed_plan() -> dict[str, int]:
    """By each measure the number of plans that are better than the paper's."""
    table = chained_plans()
    return {measure: int((table[measure] < table.loc[PRINTED, measure] * (1 - _TIE)).sum()) for measure in MEASURES}


def scale_factor_deviation(turns: int) -> float:
    """Standard deviation of a gyro scale factor by the covariance of the plan with n whole turns.

    All measurements have the variance g^2. `fogkit.calibration.navigation_based.turns` has it in closed form.
    """
    H = plan_search.measurement_matrix(chained_plan((1, 2, 1), turns))
    column = turn_model.PARAMETERS.index("m_g_11")
    return float(np.sqrt(np.linalg.inv(H.T @ H)[column, column]))


def sight_of_scale_factor(elevation: float) -> float:
    """Length of the column of gyro x for a turn about x, whose axis rises above the level by `elevation`, rad."""
    row = turn_model.measurement_rows(dcm_from_rotvec([0, -elevation, 0]), [1.0, 0, 0], 2 * np.pi)
    return float(np.linalg.norm(row[:, turn_model.PARAMETERS.index("m_g_11")]))
