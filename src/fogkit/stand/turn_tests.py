"""Dwell, turn, dwell: what the operator of a turntable does for a calibration by changes of the computed velocity.

Each test starts at rest in a commanded attitude, turns the unit about an axis that is fixed in it, and ends at rest.
What the table really does is another matter (`fogkit.stand.rough_table`): of the plan the method needs only roughly
where a test starts, and when the unit rests.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.rotation import dcm_from_rotvec
from fogkit.stand.placements import DIRECTIONS, attitude
from fogkit.units import DEG, MINUTE

if TYPE_CHECKING:
    from pandas import DataFrame

AXES = ("x", "y", "z")
DWELL = 10.0
TURN_DURATION = 15.0
"""Durations, s, of a dwell and of a turn in the nine tests: 35 s in all as in the paper, which does not divide them."""

_NINE = (  # start: where x, y and z point; body axis; angle besides the whole turns, deg
    *(("ENU", "x", 90), ("EUS", "x", 180), ("EDN", "x", 90)),
    *(("UEN", "y", 90), ("SEU", "y", 180), ("NED", "y", 90)),
    *(("EDN", "z", 90), ("DWN", "z", 180), ("UEN", "z", 90)),
)


@dataclass(frozen=True, kw_only=True)
class TurnTest:
    """One test: a dwell, a turn about an axis of the unit, a dwell.

    Parameters
    ----------
    label : str
        Name, unique in its plan.
    C_b_n : array_like, shape (3, 3)
        Commanded attitude in the first dwell.
    axis : array_like, shape (3,)
        Axis of the turn in body axes; of any length.
    angle : float
        Angle of the turn, rad, right-handed.
    dwell, dwell_after : float, optional
        Durations of the first and of the last dwell, s; the last one is as long as the first if not given.
    turn_duration : float, optional
        Duration of the turn with its ramps, s.

    Raises
    ------
    ValueError
        If the attitude is no rotation, the axis zero, the angle zero or larger than 100 turns, or a time not positive.
    """

    label: str
    C_b_n: ArrayLike
    axis: ArrayLike
    angle: float
    dwell: float = DWELL
    turn_duration: float = TURN_DURATION
    dwell_after: float | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.label, str) or not self.label:
            raise ValueError(f"`label` must be a non-empty text, got {self.label!r}")
        axis = checks.finite_array("axis", self.axis, shape=(3,))
        length = float(np.linalg.norm(axis))
        if not length > 0:
            raise ValueError(f"`axis` must have a direction, got {axis.tolist()}")
        fix = "Multiply degrees by `fogkit.units.DEG`."
        angle = checks.in_closed_interval("angle", self.angle, -200 * np.pi, 200 * np.pi, "rad", fix=fix)
        if angle == 0:
            raise ValueError("`angle` must not be 0: without a turn there is nothing to compare, got 0")
        after = self.dwell if self.dwell_after is None else self.dwell_after
        object.__setattr__(self, "C_b_n", _frozen(checks.rotation_matrix("C_b_n", self.C_b_n)))
        object.__setattr__(self, "axis", _frozen(axis / length))
        object.__setattr__(self, "angle", angle)
        object.__setattr__(self, "dwell", checks.positive("dwell", self.dwell, "s"))
        object.__setattr__(self, "dwell_after", checks.positive("dwell_after", after, "s"))
        object.__setattr__(self, "turn_duration", checks.positive("turn_duration", self.turn_duration, "s"))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, TurnTest) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    @classmethod
    def from_letters(cls, start: str, axis: str, angle: float, *, label: str = "", **durations: float) -> Self:
        """Test between attitudes of a cube.

        Parameters
        ----------
        start : str
            Where x, y and z point, three letters of ``EWNSUD``.
        axis : {"x", "y", "z"}
            Body axis of the turn.
        angle : float
            Angle, rad.
        label : str, optional
            Name; by default start, axis and degrees: ``"ENU x 1890"``.
        **durations : float
            `dwell`, `turn_duration`, `dwell_after`.

        Examples
        --------
        >>> test = TurnTest.from_letters("ENU", "x", 1890 * DEG)
        >>> test.label, test.letters
        ('ENU x 1890', ('ENU', 'EUS'))
        """
        direction = np.eye(3)[AXES.index(checks.option("axis", axis, AXES))]
        label = label or f"{start} {axis} {angle / DEG:g}"
        return cls(label=label, C_b_n=attitude(start), axis=direction, angle=angle, **durations)

    @property
    def C_b_n_end(self) -> NDArray[np.float64]:
        """Commanded attitude in the last dwell, shape (3, 3)."""
        return self.C_b_n @ dcm_from_rotvec(self.axis * self.angle)

    @property
    def letters(self) -> tuple[str, str]:
        """Where x, y and z point before and after, a point standing for a direction that is none of a cube."""
        return _letters(self.C_b_n), _letters(self.C_b_n_end)

    @property
    def duration(self) -> float:
        """Duration of the test, s."""
        return self.dwell + self.turn_duration + self.dwell_after

    @property
    def dwells(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Beginning and end of both dwells, s from the beginning of the test."""
        return (0.0, self.dwell), (self.dwell + self.turn_duration, self.duration)

    def _key(self) -> tuple:
        arrays = tuple(np.asarray(value).tobytes() for value in (self.C_b_n, self.axis))
        return self.label, *arrays, self.angle, self.dwell, self.turn_duration, self.dwell_after


def nine_tests(turns: int = 5, **durations: float) -> tuple[TurnTest, ...]:
    """The nine tests of [1]_: three about each body axis, by a quarter, a half and a quarter turn besides whole turns.

    Parameters
    ----------
    turns : int, optional
        Whole turns n that are added to each: scale factors of gyros are known the better, the more there are.
    **durations : float
        `dwell`, `turn_duration`, `dwell_after` of each test, s.

    Returns
    -------
    tuple of TurnTest
        Tests labelled ``"1"`` to ``"9"``; those about one axis each start where the one before ended. All axes lie
        level. The paper's figure of them is lost; `fogkit.reproduction.klimkovich.plan_search` recovers them.

    Raises
    ------
    ValueError
        If there are less than 0 turns, or a duration is not positive.

    References
    ----------
    .. [1] B. V. Klimkovich, Precise calibration of strapdown INS using low-accuracy turntables, Gyroscopy and
       Navigation (in Russian), vol. 30, no. 4 (119), 2022, fig. 1.

    Examples
    --------
    >>> [test.letters for test in nine_tests()][:2]
    [('ENU', 'EUS'), ('EUS', 'EDN')]
    """
    turns = checks.integer("turns", turns, minimum=0)
    return tuple(
        TurnTest.from_letters(start, axis, (angle + 360 * turns) * DEG, label=str(number), **durations)
        for number, (start, axis, angle) in enumerate(_NINE, start=1)
    )


def bias_test(dwell: float = 3 * MINUTE, turn_duration: float = 5.0) -> TurnTest:
    """The test for gyro biases: a long dwell, half a turn about the vertical, and the same dwell again."""
    return TurnTest.from_letters("ENU", "z", np.pi, label="bias", dwell=dwell, turn_duration=turn_duration)


def to_frame(plan: Sequence[TurnTest]) -> "DataFrame":
    """What the operator has in hand: one row for each test, times in s and angles in deg."""
    import pandas as pd

    rows = [
        {
            "test": test.label,
            "start": test.letters[0],
            "end": test.letters[1],
            "axis": _axis_name(test.axis),
            "angle_deg": test.angle / DEG,
            "rate_deg_s": test.angle / DEG / test.turn_duration,
            "dwell_s": test.dwell,
            "turn_s": test.turn_duration,
            "dwell_after_s": test.dwell_after,
        }
        for test in plan
    ]
    return pd.DataFrame(rows).set_index("test")


def _axis_name(axis: NDArray[np.float64]) -> str:
    for name, direction in zip(AXES, np.eye(3), strict=True):
        for sign, prefix in ((1, ""), (-1, "-")):
            if np.allclose(axis, sign * direction):
                return prefix + name
    return "({:.3g}, {:.3g}, {:.3g})".format(*axis)


def _letters(C_b_n: NDArray[np.float64]) -> str:
    """Letters of the directions that the columns have, and points for others."""
    return "".join(
        next((name for name, vector in DIRECTIONS.items() if np.allclose(column, vector)), ".") for column in C_b_n.T
    )


def _frozen(values: NDArray[np.float64]) -> NDArray[np.float64]:
    kept = np.array(values)
    kept.setflags(write=False)
    return kept
