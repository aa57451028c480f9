"""What the operator does: positions and turns as data, and the plans of the calibration methods."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.imu.constructions import TRIHEDRAL_ALPHA, Construction
from fogkit.units import DEG, DEG_PER_SECOND, MINUTE

if TYPE_CHECKING:
    from pandas import DataFrame

WHOLE_TURN_TOLERANCE = 1e-9
"""Distance from a whole number of turns that counts as rounding."""


@dataclass(frozen=True, kw_only=True)
class Segment:
    """One position held, or one steady turn of one axis of the table.

    Parameters
    ----------
    label : str
        What it is for.
    duration : float
        Duration of the reading, s.
    outer, middle, inner : float, optional
        Angles of the table's axes at the start, rad.
    block_angle : float, optional
        Angle of the gyro block in the case, rad.
    turning : {"outer", "middle", "inner"}, optional
        Axis that turns; None holds the position.
    rate : float, optional
        Rate of the turn, rad/s.
    gyro_axis : int, optional
        Gyro whose nominal axis lies along the turning axis, 0 to 2.

    Raises
    ------
    ValueError
        If the duration is not positive, an angle not finite, a turn has no rate or a position has one.
    """

    label: str
    duration: float
    outer: float = 0.0
    middle: float = 0.0
    inner: float = 0.0
    block_angle: float = 0.0
    turning: str | None = None
    rate: float = 0.0
    gyro_axis: int | None = None

    def __post_init__(self) -> None:
        checks.positive("duration", self.duration, "s")
        for name in ("outer", "middle", "inner", "block_angle", "rate"):
            checks.in_closed_interval(name, getattr(self, name), -np.inf, np.inf)
        if self.turning is None and self.rate != 0:
            raise ValueError(f"`rate` must be 0 where no axis turns, got {self.rate} for {self.label!r}")
        if self.turning is not None:
            checks.option("turning", self.turning, ("outer", "middle", "inner"))
            if self.gyro_axis is not None:
                _require_gyro_axis(self.gyro_axis)
            if self.rate == 0:
                raise ValueError(f"`rate` must not be 0 where an axis turns: turn of zero length in {self.label!r}")

    @property
    def turns(self) -> float:
        """Turns of the axis, with sign."""
        return self.rate * self.duration / (2 * np.pi)

    @property
    def is_whole(self) -> bool:
        """Whether the axis turns a whole number of times (a position does)."""
        return abs(self.turns - round(self.turns)) < WHOLE_TURN_TOLERANCE * max(1.0, abs(self.turns))


@dataclass(frozen=True)
class Plan:
    """Segments in the order in which they are carried out.

    Parameters
    ----------
    construction : Construction
        The unit that the plan is for.
    segments : sequence of Segment
        At least one.

    Raises
    ------
    ValueError
        If there is no segment, or a block is turned that the construction does not have.
    """

    construction: Construction
    segments: Sequence[Segment]

    def __post_init__(self) -> None:
        object.__setattr__(self, "segments", tuple(self.segments))
        if not self.segments:
            raise ValueError("`segments` must hold at least one segment, got none")
        _ = self.C_0_g1  # refuses a block angle that the construction does not have

    @property
    def duration(self) -> float:
        """Time of all readings, s; the time between them is not counted."""
        return sum(segment.duration for segment in self.segments)

    @cached_property
    def C_0_g1(self) -> NDArray[np.float64]:
        """Nominal gyro axes in the case in each segment, shape (n, 3, 3)."""
        return np.stack([self.construction.C_0_g1(segment.block_angle) for segment in self.segments])

    @property
    def positions(self) -> list[int]:
        """Indices of the segments that hold a position."""
        return [i for i, segment in enumerate(self.segments) if segment.turning is None]

    def turns_about(self, gyro_axis: int, sign: int) -> list[int]:
        """Indices of the turns about the nominal axis of a gyro, 0 to 2, in the direction of `sign`."""
        return [
            i
            for i, segment in enumerate(self.segments)
            if segment.turning is not None and segment.gyro_axis == gyro_axis and np.sign(segment.rate) == sign
        ]

    def to_frame(self) -> "DataFrame":
        """Schedule for the operator: angles in deg, rates in deg/s, durations in s; one row per segment."""
        import pandas as pd

        rows = [
            {
                "what": s.label,
                "outer, deg": s.outer / DEG,
                "middle, deg": s.middle / DEG,
                "inner, deg": s.inner / DEG,
                "block, deg": s.block_angle / DEG,
                "turning axis": s.turning or "",
                "rate, deg/s": s.rate / DEG_PER_SECOND,
                "turns": s.turns,
                "duration, s": s.duration,
            }
            for s in self.segments
        ]
        return pd.DataFrame(rows, index=pd.RangeIndex(1, len(rows) + 1, name="step"))


def placement(construction: Construction, gyro_axis: int, block_angle: float = 0.0) -> dict[str, float | str]:
    """How the nominal axis of a gyro is brought onto a turning axis of the table.

    Parameters
    ----------
    construction : Construction
        The unit.
    gyro_axis : int
        0, 1 or 2.
    block_angle : float, optional
        Angle of the block of the second construction, rad; the inner axis of the table turns it back.

    Returns
    -------
    dict
        Fields of `Segment`: the axis that turns, and angles of table and block. A plain unit or a fixed block turns
        about its x and y axes lying east, by the middle axis, and about z upright, by the outer one. A trihedral is
        tilted by the middle axis until the nominal y gyro stands upright, and its block brings the others there.
    """
    gyro_axis = _require_gyro_axis(gyro_axis)
    if construction.name == "trihedral":
        block = (120 * DEG, 0.0, 240 * DEG)[gyro_axis]
        if block_angle:
            raise ValueError("`block_angle` must be 0 for a trihedral, whose block brings the gyros into place")
        return {"turning": "outer", "middle": np.pi / 2 - TRIHEDRAL_ALPHA, "block_angle": block}
    turning, inner = (("middle", 0.0), ("middle", -np.pi / 2), ("outer", 0.0))[gyro_axis]
    return {"turning": turning, "inner": inner - block_angle, "block_angle": block_angle}


def _require_gyro_axis(value: int) -> int:
    """Number of a gyro, checked."""
    number = checks.integer("gyro_axis", value, minimum=0)
    if number > 2:
        raise ValueError(f"`gyro_axis` must be 0, 1 or 2, got {number}")
    return number


def four_positions(construction: Construction, duration: float, *, heading: float = 0.0) -> list[Segment]:
    """Positions whose mean is free of the Earth's rotation: half turns about the vertical, a level axis, the vertical.

    Parameters
    ----------
    construction : Construction
        The unit.
    duration : float
        Duration of each reading, s.
    heading : float, optional
        Angle of the inner axis, rad: any.

    Returns
    -------
    list of Segment
        Four positions (volynskii, before eq. (7)).
    """
    tilt = placement(construction, 1).get("middle", 0.0)
    angles = ((0.0, tilt), (np.pi, tilt), (np.pi, tilt + np.pi), (0.0, tilt + np.pi))
    return [
        Segment(label=f"bias, position {i}", duration=duration, outer=outer, middle=middle, inner=heading)
        for i, (outer, middle) in enumerate(angles, start=1)
    ]


def two_positions(construction: Construction, duration: float) -> list[Segment]:
    """Positions half a turn of the middle axis apart, which is level and points east, where the Earth does not turn.

    Parameters
    ----------
    construction, duration
        As in `four_positions`.

    Returns
    -------
    list of Segment
        Two positions (volynskii, before eq. (9)). An azimuth error of the table leaves its sine of the level Earth
        rate.
    """
    return four_positions(construction, duration)[:1] + four_positions(construction, duration)[3:]


def turns(
    construction: Construction,
    rates: Iterable[float],
    duration: float | None = None,
    *,
    count: int | None = None,
    block_angle: float = 0.0,
) -> list[Segment]:
    """Steady turns about the nominal axis of each gyro.

    Parameters
    ----------
    construction : Construction
        The unit.
    rates : iterable of float
        Rates, rad/s, of either sign.
    duration : float, optional
        Duration of each, s; turns need not be whole.
    count : int, optional
        Whole turns of each, instead of a duration.
    block_angle : float, optional
        As in `placement`.

    Returns
    -------
    list of Segment
        For each gyro, each rate.

    Raises
    ------
    ValueError
        If neither or both of `duration` and `count` are given, or a rate is 0.
    """
    if (duration is None) == (count is None):
        raise ValueError("exactly one of `duration` and `count` must be given")
    if count is not None:
        count = checks.integer("count", count, minimum=1)
    rates = tuple(rates)
    if 0 in rates:
        raise ValueError(f"`rates` must not hold 0, the rate of a turn of zero length, got {rates}")
    segments = []
    for gyro_axis in range(3):
        for rate in rates:
            length = duration if count is None else count * 2 * np.pi / abs(rate)
            segments.append(
                Segment(
                    label=f"turn about {'xyz'[gyro_axis]}, {rate / DEG_PER_SECOND:+g} deg/s",
                    duration=length,
                    rate=rate,
                    gyro_axis=gyro_axis,
                    **placement(construction, gyro_axis, block_angle),
                )
            )
    return segments


def three_stage(
    construction: Construction,
    *,
    bias_duration: float = 60 * MINUTE,
    rates: Iterable[float] = (36 * DEG_PER_SECOND, -36 * DEG_PER_SECOND),
    count: int = 36,
    block_angle: float = 0.0,
) -> Plan:
    """Plan of the three-stage calibration: four positions, then whole turns about each gyro in both directions.

    Parameters
    ----------
    construction : Construction
        The unit; the same plan serves all three.
    bias_duration : float, optional
        Duration of each bias position, s.
    rates : iterable of float, optional
        Rates, rad/s, of both signs.
    count : int, optional
        Whole turns at each rate.
    block_angle : float, optional
        As in `placement`; a second calibration at half a turn shows a tilt of the block's axis
        (`fogkit.calibration.three_stage.block_tilt`).
    """
    segments = four_positions(construction, bias_duration)
    return Plan(construction, segments + turns(construction, rates, count=count, block_angle=block_angle))
