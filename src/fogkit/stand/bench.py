"""A plan carried out: mean readings of the gyros and angles read off the table, with the errors of both."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.imu.errors import GyroTriad
from fogkit.imu.readings import mean_readings
from fogkit.stand.plans import Plan
from fogkit.stand.table import AXES, RateTable
from fogkit.units import DEG

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, kw_only=True, eq=False)
class BenchRecord:
    """What is written down while a plan is carried out, once or many times.

    Attributes
    ----------
    plan : Plan
        The plan.
    latitude : float
        Latitude of the bench, rad.
    readings : ndarray, shape (..., n, 3)
        Mean reading of each gyro in each segment, in units of the reading.
    turned : ndarray, shape (..., n)
        Angle by which the turning axis was read to have turned, rad; 0 for positions.

    Raises
    ------
    ValueError
        If a shape does not fit the plan or a number is not finite; the message names the segment.
    """

    plan: Plan
    latitude: float
    readings: NDArray[np.float64]
    turned: NDArray[np.float64]

    def __post_init__(self) -> None:
        n = len(self.plan.segments)
        for name, shape in (("readings", (..., n, 3)), ("turned", (..., n))):
            values = np.asarray(getattr(self, name), dtype=float)
            bad = np.argwhere(~np.isfinite(values))
            if bad.size and values.ndim >= len(shape) - 1:
                segment = bad[0][values.ndim - len(shape) + 1]
                label = self.plan.segments[segment].label if segment < n else "?"
                raise ValueError(
                    f"`{name}` must be finite, got {values[tuple(bad[0])]} in segment {segment + 1} ({label})"
                )
            object.__setattr__(self, name, checks.finite_array(name, values, shape=shape))
        if self.readings.shape[:-1] != self.turned.shape:
            raise ValueError(
                "`readings` and `turned` must be of the same runs, "
                f"got shapes {self.readings.shape} and {self.turned.shape}"
            )
        commanded = np.array([s.rate * s.duration for s in self.plan.segments])
        moved = np.argwhere((commanded == 0) & (self.turned != 0))
        if moved.size:
            i = int(moved[0][-1])
            raise ValueError(
                f"`turned` must be 0 where a position is held, got {self.turned[tuple(moved[0])]:.6g} rad in segment "
                f"{i + 1} ({self.plan.segments[i].label})"
            )
        off = np.abs(self.turned - commanded) > np.pi
        if off.any():
            i = int(np.argwhere(off)[0][-1])  # the segment of the first angle that is off
            came = self.turned[off][0]
            in_degrees = commanded[i] != 0 and abs(came / commanded[i] * DEG - 1) < 0.01
            fix = "It looks like degrees: multiply by `fogkit.units.DEG`" if in_degrees else "Add the whole turns"
            raise ValueError(
                f"`turned` must be the whole angle in rad, not one that wraps: segment {i + 1} "
                f"({self.plan.segments[i].label}) was commanded {commanded[i]:.6g} rad and reads {came:.6g} rad. {fix}"
            )

    def to_frame(self) -> "DataFrame":
        """Schedule with the readings of a single run: columns of `Plan.to_frame`, then readings and angle, rad."""
        import pandas as pd

        if self.readings.ndim != 2:
            raise ValueError(f"`readings` must be those of one run for a table, got shape {self.readings.shape}")
        frame = self.plan.to_frame()
        columns = {f"gyro_{axis}": self.readings[:, j] for j, axis in enumerate("xyz")}
        return pd.concat([frame, pd.DataFrame(columns | {"turned, rad": self.turned}, index=frame.index)], axis=1)


def run(
    plan: Plan,
    triad: GyroTriad,
    table: RateTable,
    *,
    rng: np.random.Generator | None = None,
    runs: int | None = None,
) -> BenchRecord:
    """Carry out a plan in simulation.

    Parameters
    ----------
    plan : Plan
        The plan, with the unit's construction.
    triad : GyroTriad
        The gyros.
    table : RateTable
        The table; its geometry is the same in all runs.
    rng : numpy.random.Generator, optional
        Source of all noise: of the gyros, of the angle readout, of the latch time and of the rate. None leaves it out.
    runs : int, optional
        Number of independent runs; None is one without a leading axis.

    Returns
    -------
    BenchRecord
        Arrays with a leading axis of length `runs` if that is given.
    """
    n, lead = len(plan.segments), () if runs is None else (checks.integer("runs", runs, minimum=1),)
    if rng is not None:
        checks.generator("rng", rng)
    duration = np.array([s.duration for s in plan.segments])
    start = np.cumsum(duration) - duration
    rate = np.broadcast_to([s.rate for s in plan.segments], (*lead, n))
    if rng is not None and table.rate_stability:
        rate = rate * (1 + table.rate_stability * rng.standard_normal((*lead, n)))
    C_0_g1, axis, omega = _geometry(plan, table)
    readings = mean_readings(triad, C_0_g1, axis, rate, omega, duration)
    scale = 0.5 * (np.array(triad.scale_positive) + np.array(triad.scale_negative))
    error = np.array(triad.bias_drift) * (start + 0.5 * duration)[:, None]
    turned = rate * duration
    if rng is not None:
        error = error + triad.angle_random_walk / np.sqrt(duration)[:, None] * rng.standard_normal((*lead, n, 3))
        error = error + triad.bias_instability * rng.standard_normal((*lead, n, 3))
        ends = table.readout_noise * rng.standard_normal((2, *lead, n))
        ends = ends + rate * table.latch_time_error * rng.standard_normal((2, *lead, n))
        turned = turned + np.where(rate == 0, 0.0, ends[1] - ends[0])
    return BenchRecord(plan=plan, latitude=table.latitude, readings=readings + error / scale, turned=np.array(turned))


def expected_readings(
    plan: Plan, triad: GyroTriad, table: RateTable, turned: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Noise-free readings of a plan whose axes turned by given angles: the model of a least-squares fit.

    Parameters
    ----------
    plan, triad, table
        As in `run`.
    turned : ndarray, shape (..., n)
        Angle of each turn, rad.

    Returns
    -------
    ndarray, shape (..., n, 3)
        Mean readings.
    """
    duration = np.array([s.duration for s in plan.segments])
    C_0_g1, axis, omega = _geometry(plan, table)
    return mean_readings(triad, C_0_g1, axis, np.asarray(turned) / duration, omega, duration)


def _geometry(plan: Plan, table: RateTable):
    """For each segment: nominal gyro axes in the case, turning axis and Earth rotation in the case at the start."""
    outer, middle, inner = (np.array([getattr(s, name) for s in plan.segments]) for name in AXES)
    turning = np.array([s.turning or "outer" for s in plan.segments])
    axis = np.empty((turning.size, 3))
    for name in AXES:
        chosen = turning == name
        axis[chosen] = table.axis_in_case(name, middle[chosen], inner[chosen])
    return plan.C_0_g1, axis, np.einsum("nji,j->ni", table.C_0_n(outer, middle, inner), table.omega_ie_n)
