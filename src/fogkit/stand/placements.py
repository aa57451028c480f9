"""What the operator does with a cube on a plate or on a single-axis rate table, and the plans of the slides.

A unit is laid down so that each of its axes points along one of six directions; on a rate table it may turn about the
vertical meanwhile. Three letters say how it lies: where x, y and z point, E, W, N, S, U (up) or D (down).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.units import DEG, DEG_PER_SECOND, MINUTE

if TYPE_CHECKING:
    from pandas import DataFrame

DIRECTIONS = {"E": (1, 0, 0), "W": (-1, 0, 0), "N": (0, 1, 0), "S": (0, -1, 0), "U": (0, 0, 1), "D": (0, 0, -1)}
"""Unit vectors in east, north, up."""

WORDS = {"E": "east", "W": "west", "N": "north", "S": "south", "U": "up", "D": "down"}

_SIZES = (0.1, 0.2, 0.5, 1, 3, 5, 8, 10, 20, 50, 80, 100, 150, 200)  # deg/s
RATES = (0.0, *(sign * size * DEG_PER_SECOND for size in _SIZES for sign in (1, -1)))
"""Rates of the slides' test, rad/s, in their order: at rest, then each in both directions."""

LARGEST_TURN_RATE = 1000 * DEG_PER_SECOND
"""A commanded rate beyond this is taken for one in deg/s."""


def attitude(axes: str) -> NDArray[np.float64]:
    """Direction cosines ``C_b_n``, shape (3, 3), of a unit that lies as three letters say: where x, y, z point.

    Raises
    ------
    ValueError
        If there are not three letters of ``EWNSUD``, or they make no right-handed triad.

    Examples
    --------
    >>> attitude("UEN") @ [1, 0, 0]
    array([0., 0., 1.])
    """
    if not isinstance(axes, str):
        raise TypeError(f"`axes` must be three letters of 'EWNSUD', got {axes!r}")
    if len(axes) != 3 or set(axes) - set(DIRECTIONS):
        raise ValueError(f"`axes` must be three letters of 'EWNSUD', where x, y and z point, got {axes!r}")
    C_b_n = np.array([DIRECTIONS[letter] for letter in axes], dtype=float).T
    if not np.isclose(np.linalg.det(C_b_n), 1):
        third = np.cross(C_b_n[:, 0], C_b_n[:, 1])
        fix = [letter for letter, vector in DIRECTIONS.items() if np.array_equal(vector, third)]
        hint = f"; with x {WORDS[axes[0]]} and y {WORDS[axes[1]]}, z points {WORDS[fix[0]]}" if fix else ""
        raise ValueError(f"`axes` must make a right-handed triad, got {axes!r}{hint}")
    return C_b_n


def triad_letters(axis: int, along: str, following: str) -> str:
    """Letters of the right-handed triad whose given axis and the next one, in the order x, y, z, x, point as said.

    Parameters
    ----------
    axis : int
        0, 1 or 2.
    along, following : str
        Directions of that axis and of the one after it.

    Examples
    --------
    >>> triad_letters(0, "U", "E")
    'UEN'
    """
    last = np.cross(DIRECTIONS[along], DIRECTIONS[following])
    third = next(letter for letter, vector in DIRECTIONS.items() if np.array_equal(vector, last))
    letters = [""] * 3
    for step, letter in enumerate((along, following, third)):
        letters[(axis + step) % 3] = letter
    return "".join(letters)


@dataclass(frozen=True, kw_only=True)
class Placement:
    """One position held, or one steady turn about the vertical.

    Parameters
    ----------
    label : str
        Name, unique in its schedule.
    axes : str
        Where x, y and z point, three letters; at the start, if the unit turns.
    duration : float
        Duration of the reading, s.
    rate : float, optional
        Rate about the upward normal of the plate or along the axis of the table, rad/s, counter-clockwise positive.

    Raises
    ------
    ValueError
        If the letters make no right-handed triad, the duration is not positive, or the rate is not finite or too large
        to be one in rad/s.
    """

    label: str
    axes: str
    duration: float
    rate: float = 0.0

    def __post_init__(self) -> None:
        if not isinstance(self.label, str) or not self.label:
            raise ValueError(f"`label` must be a non-empty text, got {self.label!r}")
        try:
            attitude(self.axes)
        except ValueError as error:
            raise ValueError(f"position {self.label!r}: {error}") from None
        object.__setattr__(self, "duration", checks.positive("duration", self.duration, "s"))
        limit = LARGEST_TURN_RATE
        fix = "Multiply a rate in deg/s by `fogkit.units.DEG_PER_SECOND`."
        rate = checks.in_closed_interval("rate", self.rate, -limit, limit, "rad/s", fix=fix)
        object.__setattr__(self, "rate", rate)

    @property
    def C_b_n(self) -> NDArray[np.float64]:
        """Nominal direction cosines at the start, shape (3, 3)."""
        return attitude(self.axes)

    @property
    def vertical(self) -> tuple[int, int]:
        """Axis that is upright, 0 to 2, and whether it points up, +1, or down, -1."""
        axis = next(i for i, letter in enumerate(self.axes) if letter in "UD")
        return axis, 1 if self.axes[axis] == "U" else -1

    @property
    def turns(self) -> float:
        """Turns about the vertical, with sign."""
        return self.rate * self.duration / (2 * np.pi)


@dataclass(frozen=True)
class Schedule:
    """Placements in the order in which they are carried out.

    Raises
    ------
    ValueError
        If there is none, or a label stands twice; the message names it.
    """

    placements: Sequence[Placement]

    def __post_init__(self) -> None:
        object.__setattr__(self, "placements", tuple(self.placements))
        if not self.placements:
            raise ValueError("`placements` must hold at least one placement, got none")
        labels = self.labels
        if repeated := sorted({label for label in labels if labels.count(label) > 1}):
            raise ValueError(f"`placements` must have labels that differ, got {', '.join(map(repr, repeated))} twice")

    def __len__(self) -> int:
        return len(self.placements)

    def __add__(self, other: "Schedule") -> "Schedule":
        return Schedule((*self.placements, *other.placements))

    @property
    def labels(self) -> list[str]:
        """Labels, in order."""
        return [placement.label for placement in self.placements]

    @property
    def duration(self) -> float:
        """Time of all readings, s; the time between them is not counted."""
        return sum(placement.duration for placement in self.placements)

    def select(self, indices: Iterable[int]) -> "Schedule":
        """Some of the placements."""
        return Schedule([self.placements[i] for i in indices])

    def to_frame(self) -> "DataFrame":
        """Schedule for the operator: where the axes point, rate in deg/s, turns, duration in s."""
        import pandas as pd

        rows = [
            {
                "position": p.label,
                **{axis: WORDS[letter] for axis, letter in zip("xyz", p.axes, strict=True)},
                "rate, deg/s": p.rate / DEG_PER_SECOND,
                "turns": p.turns,
                "duration, s": p.duration,
            }
            for p in self.placements
        ]
        return pd.DataFrame(rows, index=pd.RangeIndex(1, len(rows) + 1, name="step"))


def twenty_four_points(duration: float = 2 * MINUTE) -> Schedule:
    """Six positions with x, y, z up and down in turn, each at four headings: 24 points.

    Labels are the position and the point, "1.1" to "6.4": position 1 has x up, 2 x down, 3 y up, and so on. At the four
    points of a position the axis that follows the upright one (x, y, z, x) points east, south, west, north, as in the
    slides' tables for x.
    """
    return Schedule(
        [
            Placement(
                label=f"{position + 1}.{point + 1}", axes=triad_letters(position // 2, up, side), duration=duration
            )
            for position, up in enumerate("UDUDUD")
            for point, side in enumerate("ESWN")
        ]
    )


def full_turns(rate: float = 10 * DEG, turns: int = 1) -> Schedule:
    """Turns by +360 and -360 deg about x, y, z upright: what the gyros' equivalents are taken from.

    Parameters
    ----------
    rate : float, optional
        Mean rate of the turn, rad/s.
    turns : int, optional
        Number of whole turns each way.
    """
    duration = 2 * np.pi * checks.integer("turns", turns, minimum=1) / checks.positive("rate", rate, "rad/s")
    return Schedule(
        [
            Placement(
                label=f"{axis} {'+' if sign > 0 else '-'}{360 * turns}",
                axes=triad_letters(i, "U", "E"),
                duration=duration,
                rate=sign * rate,
            )
            for i, axis in enumerate("xyz")
            for sign in (1, -1)
        ]
    )


def six_positions(duration: float = 2 * MINUTE) -> Schedule:
    """Each axis up, then down, the following axis to the east: accelerometers on a cube."""
    return Schedule(
        [
            Placement(label=str(position + 1), axes=triad_letters(position // 2, up, "E"), duration=duration)
            for position, up in enumerate("UDUDUD")
        ]
    )


def three_positions_east(duration: float = 10 * MINUTE) -> Schedule:
    """Each axis to the east in turn, the following one north: biases of gyros on a plate with a north mark."""
    return Schedule(
        [
            Placement(label=f"{axis} east", axes=triad_letters(i, "E", "N"), duration=duration)
            for i, axis in enumerate("xyz")
        ]
    )


def rate_sequence(rates: Iterable[float] = RATES, duration: float = 2 * MINUTE, axes: str = "xyz") -> Schedule:
    """Each axis along the upward axis of a rate table in turn, at each rate.

    Parameters
    ----------
    rates : iterable of float, optional
        Rates, rad/s; by default the 29 of the slides.
    duration : float, optional
        Duration of each, s.
    axes : str, optional
        Axes to turn about, letters of "xyz".

    Raises
    ------
    ValueError
        If a rate is not finite, too large or given twice, or an axis is none of the three.
    """
    rates = [checks.finite("rates", rate, "rad/s") for rate in rates]
    for axis in axes:
        checks.option("axes", axis, "xyz")
    return Schedule(
        [
            Placement(
                label=f"{axis} {rate / DEG_PER_SECOND:+.10g} deg/s",
                axes=triad_letters("xyz".index(axis), "U", "E"),
                duration=duration,
                rate=rate,
            )
            for axis in axes
            for rate in rates
        ]
    )
