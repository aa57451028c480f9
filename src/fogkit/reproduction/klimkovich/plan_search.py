"""The lost figure 1: where the nine tests start and how they turn, found from the matrix of the appendix by search.

Every attitude of a cube, every body axis and every whole number of quarter turns of either sign is tried for each test,
and the two rows of `turn_model.measurement_rows` are compared with the printed ones, zeros included.

**How far the answer is unique.** A test and its `Turn.twin` - the same turn run backwards, with the unit first turned
by half a turn about the vertical - have the same rows, whatever the attitude and the turn: running backwards reverses
the change, and so does turning both level axes round. No matrix can tell them apart, so nine tests leave 512 plans.
One of them has all turns positive, as the text prints the angles; the same one has each test about an axis start where
the one before ended; and its test 1 starts from the unit matrix, as stated.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise, permutations, product
from math import prod
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.calibration.navigation_based import turn_model
from fogkit.reproduction.klimkovich import paper
from fogkit.rotation import dcm_from_rotvec
from fogkit.stand.placements import DIRECTIONS, attitude
from fogkit.units import DEG

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

MOST_QUARTERS = 4 * (paper.TURNS + 1)
"""Quarter turns that are tried, of either sign: up to a whole turn more than the five that the text adds."""

_SAME = 1e-6  # elements are whole or half multiples of 1 and pi


def _letters(C_b_n: Array) -> str:
    """Where x, y and z point, for an attitude of a cube."""
    return "".join(
        next(name for name, vector in DIRECTIONS.items() if np.allclose(column, vector)) for column in C_b_n.T
    )


def _attitudes() -> tuple[str, ...]:
    """The right-handed triads among all triples of directions."""
    triples = map("".join, permutations(DIRECTIONS, 3))
    matrices = ((axes, np.array([DIRECTIONS[letter] for letter in axes]).T) for axes in triples)
    return tuple(axes for axes, matrix in matrices if np.isclose(np.linalg.det(matrix), 1))


ATTITUDES = _attitudes()
"""The 24 attitudes of a cube: where x, y and z point."""


@dataclass(frozen=True)
class Turn:
    """One test: attitude of the first dwell, and the turn.

    Parameters
    ----------
    start : str
        Where x, y and z point, three letters of ``EWNSUD``.
    axis : int
        Body axis of the turn, 0 to 2.
    quarters : int
        Quarter turns, right-handed about the body axis.

    Examples
    --------
    >>> Turn("ENU", 0, 21).end
    'EUS'
    >>> Turn("ENU", 0, 21).twin
    Turn(start='WUN', axis=0, quarters=-21)
    """

    start: str
    axis: int
    quarters: int

    def __post_init__(self) -> None:
        attitude(self.start)  # raises
        if checks.integer("axis", self.axis, minimum=0) > 2:
            raise ValueError(f"`axis` must be 0, 1 or 2, got {self.axis}")
        checks.integer("quarters", self.quarters)

    @property
    def C_b_n(self) -> Array:
        """Attitude in the first dwell, shape (3, 3)."""
        return attitude(self.start)

    @property
    def direction(self) -> Array:
        """Axis of the turn in body axes, shape (3,)."""
        return np.eye(3)[self.axis]

    @property
    def angle(self) -> float:
        """Angle of the turn, rad."""
        return self.quarters * np.pi / 2

    @property
    def end(self) -> str:
        """Where x, y and z point in the second dwell."""
        return _letters(self.C_b_n @ dcm_from_rotvec(self.direction * self.angle))

    @property
    def along(self) -> str:
        """Where the axis of the turn points."""
        return self.start[self.axis]

    @property
    def twin(self) -> "Turn":
        """The test that no measurement matrix tells from this one: backwards, half a turn about the vertical away."""
        opposite = dict(zip("EWNSUD", "WESNUD", strict=True))
        return Turn("".join(opposite[letter] for letter in self.end), self.axis, -self.quarters)

    def rows(self, gravity: float = 1.0) -> Array:
        """Its rows of the measurement matrix, shape (2, 15); see `turn_model.measurement_rows`."""
        return turn_model.measurement_rows(self.C_b_n, self.direction, self.angle, gravity)


Plan = tuple[Turn, ...]
"""Nine tests in their order."""


@dataclass(frozen=True)
class Found:
    """What the search finds for one test.

    Attributes
    ----------
    turns : tuple of Turn
        All candidates that disagree with the print in the fewest elements.
    cells : int
        In how many of the 30 elements of its two rows these disagree.
    next_cells : int
        In how many the next best candidate does.
    """

    turns: tuple[Turn, ...]
    cells: int
    next_cells: int


@cache
def _candidates(most_quarters: int) -> tuple[tuple[Turn, ...], Array]:
    """All candidates, and their rows."""
    counts = [sign * count for count in range(1, most_quarters + 1) for sign in (1, -1)]
    turns = tuple(Turn(*choice) for choice in product(ATTITUDES, range(3), counts))
    rows = turn_model.measurement_rows(
        np.stack([turn.C_b_n for turn in turns]),
        np.stack([turn.direction for turn in turns]),
        np.array([turn.angle for turn in turns]),
    )
    return turns, rows


def search(
    printed: Array | None = None, *, most_quarters: int = MOST_QUARTERS, gyro_sign: int = 1, force_sign: int = 1
) -> tuple[Found, ...]:
    """Find for each test the attitudes and turns whose rows are nearest to the print.

    Parameters
    ----------
    printed : array_like, shape (18, 15), optional
        Matrix in multiples of gravity; the appendix as printed if not given.
    most_quarters : int, optional
        Largest number of quarter turns of either sign.
    gyro_sign : int, optional
        -1 takes the sign of the attitude error from (3) and (4) instead of (15) and (18).
    force_sign : int, optional
        -1 takes accelerometers at rest to read -g upwards.

    Returns
    -------
    tuple of Found
        One for each test.
    """
    printed = checks.finite_array("printed", paper.printed_matrix() if printed is None else printed, shape=(18, 15))
    turns, rows = _candidates(checks.integer("most_quarters", most_quarters, minimum=1))
    signs = np.repeat([force_sign, gyro_sign, 1], [3, 9, 3])
    return tuple(_nearest(turns, np.abs(rows * signs - pair) > _SAME) for pair in printed.reshape(-1, 2, 15))


def _nearest(turns: Sequence[Turn], differs: NDArray[np.bool_]) -> Found:
    cells = differs.sum(axis=(-2, -1))
    fewest = cells.min()
    best = tuple(turns[i] for i in np.flatnonzero(cells == fewest))
    return Found(best, int(fewest), int(cells[cells > fewest].min()))


def count_plans(found: Iterable[Found]) -> int:
    """Number of plans that the search leaves: the product over the tests."""
    return prod(len(test.turns) for test in found)


def is_chained(turns: Sequence[Turn]) -> bool:
    """Whether each of some tests starts in the attitude in which the one before ended."""
    return all(one.end == other.start for one, other in pairwise(turns))


def chained_plans(found: Sequence[Found]) -> list[Plan]:
    """The plans among those found in which the three tests about the same axis are chained (`is_chained`)."""
    blocks = [
        [block for block in product(*(found[test - 1].turns for test in tests)) if is_chained(block)]
        for tests in paper.BLOCKS.values()
    ]
    return [sum(plan, ()) for plan in product(*blocks)]


@cache
def recovered_plan() -> Plan:
    """The nine tests of the lost figure 1: the one plan that fits the appendix and is chained.

    Examples
    --------
    >>> [turn.start for turn in recovered_plan()]
    ['ENU', 'EUS', 'EDN', 'UEN', 'SEU', 'NED', 'EDN', 'DWN', 'UEN']
    """
    (plan,) = chained_plans(search())
    return plan


def measurement_matrix(plan: Iterable[Turn] | None = None, gravity: float = 1.0) -> Array:
    """Measurement matrix of a plan: the appendix without its misprints, if no plan is given.

    Parameters
    ----------
    plan : iterable of Turn, optional
        Tests; `recovered_plan` if not given.
    gravity : float, optional
        m/s^2; with 1 the elements of misalignments and scale factors are multiples of gravity.

    Returns
    -------
    ndarray, shape (2 * tests, 15)
        Two rows for each test, east and north; columns as in `turn_model.PARAMETERS`.
    """
    return np.concatenate([turn.rows(gravity) for turn in (recovered_plan() if plan is None else plan)])


@dataclass(frozen=True)
class Misprint:
    """A printed element that the plan does not give.

    Attributes
    ----------
    printed : Entry
        As printed.
    correct : Entry
        As it must be: another number in the same place, or the same number in another column.
    """

    printed: paper.Entry
    correct: paper.Entry


def misprints(plan: Sequence[Turn] | None = None) -> list[Misprint]:
    """The printed elements that a plan contradicts, each with what stands there or where it belongs.

    Raises
    ------
    ValueError
        If what differs in a row is neither one wrong number nor one number in the wrong column.
    """
    correct = measurement_matrix(plan)
    differs = np.abs(correct - paper.printed_matrix()) > _SAME
    return [_misprint(row, correct[row], np.flatnonzero(differs[row])) for row in np.flatnonzero(differs.any(axis=1))]


def _misprint(row: int, correct: Array, columns: NDArray[np.intp]) -> Misprint:
    entries = [entry for entry in paper.MATRIX if entry.row == row and entry.column in columns]
    if len(entries) == 1 and len(columns) <= 2:
        (entry,) = entries
        (column,) = columns if len(columns) == 1 else columns[columns != entry.column]
        number = correct[column] / (np.pi if entry.of_pi else 1)
        moved = paper.Entry(int(row), int(column), float(np.round(number, 9)), entry.of_pi, entry.of_gravity)
        if len(columns) == 1 or moved.number == entry.number:
            return Misprint(entry, moved)
    raise ValueError(f"row {row} differs from the plan by more than one number or column: columns {columns.tolist()}")


def upended_axes(plan: Sequence[Turn]) -> dict[int, int]:
    """Axis, 1 to 3, to the test in which it is upright in both dwells with opposite signs; (26) needs one for each."""
    return {
        axis + 1: number
        for axis in range(3)
        for number, turn in enumerate(plan, start=1)
        if {turn.start[axis], turn.end[axis]} == {"U", "D"}
    }


def table_angles(turn: Turn) -> tuple[float, float, str]:
    """Angles at which a two-axis table starts a test: an outer axis that points east, an inner one along z of the unit.

    Parameters
    ----------
    turn : Turn
        A test; at zero angles the unit lies with x, y, z east, north, up.

    Returns
    -------
    outer, inner : float
        Rad, in (-pi, pi].
    turning : {'outer', 'inner'}
        The axis that turns.

    Raises
    ------
    ValueError
        If such a table cannot hold the attitude, or cannot turn about that axis.

    Notes
    -----
    A reading of the plan, not a statement of the paper: one such table does all nine tests without remounting.
    """
    z = turn.C_b_n[:, 2]
    outer = np.arctan2(0.0 - z[1], z[2])  # not -z[1]: a negative zero would give -pi
    C_inner = np.round(dcm_from_rotvec([outer, 0.0, 0.0]).T @ turn.C_b_n) + 0.0
    if C_inner[2, 2] != 1 or (turn.axis != 2 and turn.along not in "EW"):
        raise ValueError(f"`turn` needs a table of another kind than one with its outer axis east, got {turn}")
    inner = np.arctan2(C_inner[1, 0], C_inner[0, 0])
    return float(outer), float(inner), "inner" if turn.axis == 2 else "outer"


def plan_table(plan: Sequence[Turn] | None = None) -> "DataFrame":
    """A plan (`recovered_plan` if not given) for the operator: attitudes, turns and table angles in deg by test."""
    import pandas as pd

    rows = []
    for turn in recovered_plan() if plan is None else plan:
        outer, inner, turning = table_angles(turn)
        rows.append(
            {
                "start": turn.start,
                "axis": "xyz"[turn.axis],
                "axis points": turn.along,
                "turn, deg": turn.quarters * 90,
                "end": turn.end,
                "outer, deg": round(outer / DEG),
                "inner, deg": round(inner / DEG),
                "turning": turning,
            }
        )
    return pd.DataFrame(rows, index=pd.RangeIndex(1, len(rows) + 1, name="test"))
