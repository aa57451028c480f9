"""Recordings of the tests as arrays, with the steps at which dwells begin and end."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.imu.tables import IMU_COLUMNS
from fogkit.navigation.increments import time_step, values
from fogkit.stand.turn_tests import TurnTest
from fogkit.units import DEG

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

WINDOW = 0.5
"""Duration, s, over which gyros are summed to see whether the unit moves."""

MOVING = 0.5 * DEG
"""Angle turned in such a window, less its median in the recording's quietest half, that is a turn and no dwell."""


LENGTH_TOLERANCE = 0.75
"""Steps by which a recording may differ from its test in length. A step of 0.01 s that is lost in a turn by 1890 deg in
15 s is 1.3 deg of it. The calibration would share that out among its parameters; no residual shows it."""


@dataclass(frozen=True, eq=False)
class Recording:
    """One test as the method takes it.

    Attributes
    ----------
    test : TurnTest
        What was commanded.
    dt : float
        Sampling step, s.
    gyro, accel : ndarray, shape (n, 3)
        Raw increments, rad and m/s.
    dwells : tuple of tuple of int
        First step, and step after the last, of both dwells. Velocity is reset where the second one begins.
    """

    test: TurnTest
    dt: float
    gyro: Array
    accel: Array
    dwells: tuple[tuple[int, int], tuple[int, int]]

    @property
    def forces(self) -> Array:
        """Mean raw readings of the accelerometers in both dwells, m/s^2, shape (2, 3)."""
        return np.stack([self.accel[slice(*dwell)].mean(axis=0) for dwell in self.dwells]) / self.dt

    @property
    def turned(self) -> Array:
        """Sum of the raw readings of the gyros between the dwells, rad, shape (3,)."""
        return self.gyro[self.dwells[0][1] : self.dwells[1][0]].sum(axis=0)


def recordings_of(
    tables: Sequence["DataFrame"], plan: Sequence[TurnTest], *, settle: float = 0.0, dwells: str = "plan"
) -> tuple[Recording, ...]:
    """Recordings from tables of increments, after the checks that hold for any unit.

    Parameters
    ----------
    tables : sequence of DataFrame
        Raw increments of each test in the order of the plan: index ``time``, s, from 0, equally spaced; columns
        ``gyro_x`` to ``accel_z``, rad and m/s.
    plan : sequence of TurnTest
        The tests.
    settle : float, optional
        What is left out of the second dwell after the turn, s, while shock absorbers ring.
    dwells : {"plan", "detected"}, optional
        Whether the unit rests when the plan says so, or when its gyros do (`find_dwells`).

    Returns
    -------
    tuple of Recording

    Raises
    ------
    TypeError, ValueError
        If there is not one table for each test; if a table has gaps, is not in order, does not begin at 0 or is shorter
        or longer than its test; if no dwell is left.
    """
    plan = checked_plan(plan)
    settle = checks.non_negative("settle", settle, "s")
    checks.option("dwells", dwells, ("plan", "detected"))
    if hasattr(tables, "columns") or not isinstance(tables, Sequence):
        raise TypeError(f"`recordings` must be a sequence of tables, one for each test, got {type(tables).__name__}")
    if len(tables) != len(plan):
        raise ValueError(f"`recordings` must be one for each of the {len(plan)} tests of the plan, got {len(tables)}")
    return tuple(
        _recording(table, test, f"recordings[{i}] (test {test.label})", settle, dwells)
        for i, (table, test) in enumerate(zip(tables, plan, strict=True))
    )


def checked_plan(plan: Sequence[TurnTest]) -> tuple[TurnTest, ...]:
    """Plan as a tuple; ``TypeError`` if something in it is no test, ``ValueError`` if it is empty."""
    plan = (plan,) if isinstance(plan, TurnTest) else tuple(plan)
    if not plan:
        raise ValueError("`plan` must hold at least one test, got none")
    return tuple(checks.instance(f"plan[{i}]", test, TurnTest) for i, test in enumerate(plan))


def find_dwells(gyro: Array, dt: float) -> tuple[tuple[int, int], tuple[int, int]] | None:
    """Rests before and after the motion, from the gyros alone.

    Parameters
    ----------
    gyro : ndarray, shape (n, 3)
        Increments, rad.
    dt : float
        Step, s.

    Returns
    -------
    tuple of tuple of int, or None
        First step, and step after the last, of the first and of the last rest, a window of `WINDOW` clear of motion
        (`MOVING`); None if nothing moves, or no rest is left before or after it.
    """
    moving, steps = _moving(gyro, dt)
    if not moving.any():
        return None
    first, last = int(np.argmax(moving)), int(moving.size - np.argmax(moving[::-1]))
    before, after = (first - 1) * steps, (last + 1) * steps
    return ((0, before), (after, len(gyro))) if before > 0 and after < len(gyro) else None


def motion_in(gyro: Array, dt: float, dwell: tuple[int, int]) -> tuple[float, float]:
    """Largest angle turned in a window of a dwell beyond the mean of the dwell, rad, and when it begins, s."""
    first, last = dwell
    angles, steps = _windows(gyro[first:last], dt)
    size = np.linalg.norm(angles - np.median(angles, axis=0), axis=1)
    worst = int(np.argmax(size))
    return float(size[worst]), (first + worst * steps) * dt


def _windows(gyro: Array, dt: float) -> tuple[Array, int]:
    """Angles turned in windows one after the other, shape (windows, 3), and steps in each."""
    steps = min(max(1, round(WINDOW / dt)), len(gyro))
    count = len(gyro) // steps
    return gyro[: count * steps].reshape(count, steps, 3).sum(axis=1), steps


def _moving(gyro: Array, dt: float) -> tuple[NDArray[np.bool_], int]:
    angles, steps = _windows(gyro, dt)
    size = np.linalg.norm(angles, axis=1)
    still = angles[size <= np.median(size)]
    return np.linalg.norm(angles - np.median(still, axis=0), axis=1) > MOVING, steps


def _recording(table: "DataFrame", test: TurnTest, name: str, settle: float, dwells: str) -> Recording:
    checks.columns(table, IMU_COLUMNS, name=name)
    in_order = tuple(table.columns) == IMU_COLUMNS  # to select columns takes longer than to navigate them
    sums = checks.finite_array(name, table.to_numpy()) if in_order else values(table, name=name)
    begin, dt = time_step(table, name=name)
    if abs(begin) > 0.5 * dt:
        raise ValueError(f"`{name}` must begin at 0 s, got {begin:.6g} s. Subtract the time at which the test begins.")
    gyro, accel = np.ascontiguousarray(sums[:, :3]), np.ascontiguousarray(sums[:, 3:])
    rests = _planned(test, dt, len(sums), name) if dwells == "plan" else find_dwells(gyro, dt)
    if rests is None:
        raise ValueError(
            f"`{name}` must hold a dwell, a turn and a dwell, got one in which the gyros do not show a turn by more "
            f"than {MOVING / DEG:g} deg in {WINDOW:g} s between two rests"
        )
    (first, stop), (begin_again, last) = rests
    begin_again += round(settle / dt)
    if last - begin_again < 10:
        raise ValueError(f"`settle` must leave something of the second dwell of `{name}`, got {settle:g} s")
    return Recording(test, dt, gyro, accel, ((first, stop), (begin_again, last)))


def _planned(test: TurnTest, dt: float, count: int, name: str) -> tuple[tuple[int, int], tuple[int, int]]:
    """Steps of the dwells of the plan; ``ValueError`` if the recording is not as long as its test."""
    if abs(count * dt - test.duration) > max(LENGTH_TOLERANCE * dt, 1e-6 * test.duration):
        (_, first), (second, end) = test.dwells
        missing = "" if count * dt > second + dt else f" The second dwell, from {second:g} to {end:g} s, is missing."
        missing = missing or (f" The second dwell, to {end:g} s, is cut short." if count * dt < end else "")
        raise ValueError(
            f"`{name}` must be as long as its test, {test.duration:g} s, got {count * dt:.6g} s.{missing} A plan with "
            "the durations of the recording may be given, or `dwells='detected'`."
        )
    (first, stop), (begin, end) = ((round(a / dt), min(round(b / dt), count)) for a, b in test.dwells)
    if min(stop - first, end - begin) < 10:
        raise ValueError(f"`{name}` must have at least 10 samples in each dwell, got {min(stop - first, end - begin)}")
    return (first, stop), (begin, end)
