"""Tables 1 and 2 of the paper, as far as the print lets them be judged.

The recordings are not given, so no cell can be recomputed. What can be asked of table 1 is whether standard deviations
by (27), with the matrix of the plan and some diagonal R, have its pattern. Rows of the matrix come in four kinds: the
velocity along or across the axis of the turn, after a quarter or a half turn. With one noise level for each kind the
twelve cells that are no gyro scale factor follow to less than a percent; the scale factors of x and y do not, with any
diagonal R.
"""

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit.calibration.navigation_based.turn_model import PARAMETERS
from fogkit.earth import earth_rate_n, normal_gravity
from fogkit.reproduction.klimkovich import paper, plan_search
from fogkit.reproduction.klimkovich.estimates import LATITUDE
from fogkit.units import ARCSEC, DEG, PPM

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

GRAVITY = float(normal_gravity(LATITUDE))
SCALE_FACTORS = ("m_g_11", "m_g_22", "m_g_33")
KINDS = ("along, quarter", "along, half", "across, quarter", "across, half")
"""Kinds of rows: velocity along or across the axis of the turn, quarter or half turn besides whole ones."""
GROUPS = (
    ("m_g_12", "m_g_23", "m_g_31"),
    ("m_g_13", "m_g_21", "m_g_32"),
    SCALE_FACTORS,
    ("b_a_1", "b_a_2", "b_a_3"),
    ("m_a_13", "m_a_21", "m_a_32"),
)
"""Parameters that the plan treats alike: a permutation of the axes takes one into the other."""


def unit(name: str) -> float:
    """Unit of a cell of table 1 in SI; gravity is 1 for biases, so that all are pure numbers."""
    if name in SCALE_FACTORS:
        return PPM
    return 1 / GRAVITY if name.startswith("b") else ARCSEC


def printed() -> Array:
    """Table 1 in the order of the state, pure numbers, shape (15,)."""
    return np.array([paper.TABLE_1[name] * unit(name) for name in PARAMETERS])


def deviations(levels: Array, matrix: Array | None = None) -> Array:
    """Standard deviations of the state by (27), shape (15,).

    Parameters
    ----------
    levels : ndarray, shape (18,)
        Standard deviations of the measurements over gravity.
    matrix : ndarray, shape (18, 15), optional
        In multiples of gravity; that of the recovered plan if not given.
    """
    H = plan_search.measurement_matrix() if matrix is None else matrix
    weighted = H / levels[:, np.newaxis]
    return np.sqrt(np.diag(np.linalg.inv(weighted.T @ weighted)))


def kinds_of_rows() -> NDArray[np.intp]:
    """Kind of each row of the matrix: an index of `KINDS`, shape (18,)."""
    kinds = []
    for turn in plan_search.recovered_plan():
        for level in ("EW", "NS"):
            across, half = turn.along not in level, turn.quarters % 4 == 2
            kinds.append(2 * across + half)
    return np.array(kinds)


@dataclass(frozen=True)
class Fit:
    """Noise levels fitted to table 1.

    Attributes
    ----------
    levels : ndarray, shape (k,)
        Standard deviations of the measurements, m/s^2.
    ratios : dict
        Parameter to the fitted over the printed cell.
    """

    levels: Array
    ratios: dict[str, float]

    @property
    def largest(self) -> float:
        """Largest relative departure among the cells that are no gyro scale factor."""
        return max(abs(ratio - 1) for name, ratio in self.ratios.items() if name not in SCALE_FACTORS)


@cache
def four_levels(as_printed: bool = False) -> Fit:
    """Fit one noise level for each kind of row to the twelve cells that are no gyro scale factor.

    Parameters
    ----------
    as_printed : bool, optional
        Whether to take the matrix with its misprints.

    Returns
    -------
    Fit
        Least squares of the logarithms.
    """
    from scipy.optimize import least_squares

    matrix, kinds = _matrix(as_printed), kinds_of_rows()
    used = np.array([name not in SCALE_FACTORS for name in PARAMETERS])

    def misfit(logs):
        return np.log(deviations(np.exp(logs)[kinds], matrix) / printed())[used]

    found = least_squares(misfit, np.full(len(KINDS), np.log(2e-5)))
    levels = np.exp(found.x)
    return Fit(levels * GRAVITY, _ratios(levels[kinds], matrix))


def _matrix(as_printed: bool) -> Array:
    return paper.printed_matrix() if as_printed else plan_search.measurement_matrix()


def _ratios(levels: Array, matrix: Array) -> dict[str, float]:
    return dict(zip(PARAMETERS, (deviations(levels, matrix) / printed()).tolist(), strict=True))


def fitted(name: str) -> float:
    """A cell of table 1 by `four_levels`, in the printed unit."""
    return four_levels().ratios[name] * paper.TABLE_1[name]


def implied_levels() -> dict[str, float]:
    """Noise level, m/s^2, that each cell of table 1 needs if all measurements are equally good."""
    unit_deviations = deviations(np.ones(18))
    return dict(zip(PARAMETERS, (printed() / unit_deviations * GRAVITY).tolist(), strict=True))


def group_spread(as_printed: bool) -> float:
    """Largest ratio of two standard deviations in one of `GROUPS`, one noise level for each kind of row.

    1 for a matrix that treats the axes alike, whatever the four levels are; here those of `four_levels`.
    """
    found = dict(
        zip(
            PARAMETERS,
            deviations(four_levels().levels[kinds_of_rows()] / GRAVITY, _matrix(as_printed)),
            strict=True,
        )
    )
    return max(max(found[n] for n in group) / min(found[n] for n in group) for group in GROUPS)


def printed_group_spread() -> float:
    """The same of the cells of table 1, the scale factors left out."""
    cells = paper.TABLE_1
    groups = [group for group in GROUPS if group != SCALE_FACTORS]
    return max(max(cells[n] for n in group) / min(cells[n] for n in group) for group in groups)


def gyro_angle_ratio(levels: Array | None = None) -> float:
    """Standard deviation of the angle m^g_12 over that of m^g_13; with one level for all rows if none are given."""
    found = dict(zip(PARAMETERS, deviations(np.ones(18) if levels is None else levels), strict=True))
    return float(found["m_g_12"] / found["m_g_13"])


def table_1() -> "DataFrame":
    """Table 1 beside the model: printed and fitted cells in the printed units, and the level that each needs alone."""
    import pandas as pd

    names = [name for group in GROUPS for name in group]
    level = implied_levels()
    rows = [(paper.TABLE_1[name], fitted(name), four_levels().ratios[name], level[name]) for name in names]
    columns = ["printed", "fitted", "ratio", "level_m_s2"]
    return pd.DataFrame(rows, index=pd.Index(names, name="parameter"), columns=columns)


# Table 2


def table_2_statistics() -> dict[str, float]:
    """Mean, root mean square and standard deviation (seven degrees of freedom) of table 2, deg."""
    errors = np.array(list(paper.TABLE_2.values()))
    return {
        "mean": float(errors.mean()),
        "rms": float(np.sqrt(np.mean(errors**2))),
        "deviation": float(errors.std(ddof=1)),
    }


def table_2_harmonic() -> dict[str, float]:
    """What a constant bias of the level gyros would make of table 2: one period over the azimuths, by least squares.

    Returns
    -------
    dict
        "amplitude", deg; "share" of the sum of squares, 2/7 on average if there is noise alone; and "walk",
        rad/sqrt(s), the angle random walk that makes the printed scatter in five minutes at `LATITUDE`.
    """
    angles = np.array(list(paper.TABLE_2)) * DEG
    errors = np.array(list(paper.TABLE_2.values()))
    cosine, sine = (2 / len(errors) * (errors @ wave(angles)) for wave in (np.cos, np.sin))
    amplitude = float(np.hypot(cosine, sine))
    scatter = table_2_statistics()["deviation"] * DEG * float(earth_rate_n(LATITUDE)[1])
    return {
        "amplitude": amplitude,
        "share": float(len(errors) / 2 * amplitude**2 / (errors @ errors)),
        "walk": scatter * float(np.sqrt(paper.GYROCOMPASSING_TIME)),
    }


def table_2_remainders() -> Array:
    """The last digit of each cell of table 2 counted from below, in units of 1e-5 deg: what is left modulo 1e-4 deg.

    Equal remainders mean that one number, not a multiple of 1e-4 deg, was subtracted from eight readings to 1e-4 deg.
    """
    return np.round(np.array(list(paper.TABLE_2.values())) * 1e5) % 10
