"""Tables of a gyrocompass's record and of its aid: one's own data into the filters, and back.

A recording is the package's table of increments (`fogkit.navigation.increments`) with one column more. Index ``time``,
s: the beginning of each step. ``gyro_x, gyro_y, gyro_z``: integrals of what the three gyros of the mount read over the
step, rad. ``accel_x, accel_y, accel_z``: integrals of the specific force in the hull, right, forward, up, m/s.
``mount_angle``: at the beginning of the step, rad, counter-clockwise from above. A last row without increments (NaN)
holds the angle at the end.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.constants import STANDARD_GRAVITY
from fogkit.gyrocompass.covariance import Aid
from fogkit.gyrocompass.error_model import MEASUREMENTS
from fogkit.gyrocompass.filters.records import Fixes, Recording
from fogkit.gyrocompass.frames import TO_PACKAGE, pyramid_axes
from fogkit.imu.tables import IMU_COLUMNS
from fogkit.navigation.increments import time_step

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

MOUNT_COLUMN = "mount_angle"
RECORDING_COLUMNS = (*IMU_COLUMNS, MOUNT_COLUMN)


def recording_from_frame(
    table: "DataFrame", *, gravity: float = STANDARD_GRAVITY, axes: ArrayLike | None = None
) -> Recording:
    """Recording from a table of increments and angles of the mount.

    Parameters
    ----------
    table : DataFrame
        Columns `RECORDING_COLUMNS`, equally spaced, the last row with an angle only. Readings of rates become
        increments by `fogkit.navigation.increments_from_rates`.
    gravity : float, optional
        At the place, m/s^2.
    axes : array_like, shape (3, 3), optional
        ``C_p_m``, the gyros' input axes in the mount (forward, up, starboard); those of the pyramid if not given.

    Returns
    -------
    Recording
        Its time 0 is the first of the index.

    Raises
    ------
    ValueError
        If a column is missing, times are no index or not equally spaced, an entry before the last row is missing, or
        the last row has increments.
    """
    check_index(checks.columns(table, RECORDING_COLUMNS))
    _, dt = time_step(table, "table")
    increments = _numbers(table, IMU_COLUMNS)
    if not np.isnan(increments[-1]).all():
        raise ValueError(
            "`table` must end with a row that holds the angle of the mount at the end and no increments (NaN), got "
            "increments there. Add the angle at the end, or set the increments of the last row to NaN"
        )
    values = checks.finite_array("increments", increments[:-1])
    angle = checks.finite_array(f"table[{MOUNT_COLUMN!r}]", table[MOUNT_COLUMN].to_numpy())
    return Recording(
        dt=dt,
        dtheta=values[:, :3],
        dv=values[:, 3:] @ TO_PACKAGE,
        mount_angle=angle,
        gravity=gravity,
        axes=pyramid_axes() if axes is None else axes,
    )


def recording_to_frame(recording: Recording) -> "DataFrame":
    """Table of a recording, from time 0: what `recording_from_frame` takes. Gravity and axes are not in it."""
    import pandas as pd

    checks.instance("recording", recording, Recording)
    increments = np.hstack([recording.dtheta, recording.dv @ TO_PACKAGE.T])
    values = np.column_stack([np.vstack([increments, np.full(6, np.nan)]), recording.mount_angle])
    index = pd.Index(recording.dt * np.arange(len(values)), name="time")
    return pd.DataFrame(values, index=index, columns=list(RECORDING_COLUMNS))


def fixes_from_frame(table: "DataFrame", aid: Aid, start: float = 0.0) -> Fixes:
    """What an aid measured, from a table.

    Parameters
    ----------
    table : DataFrame
        Index time, s; columns of those that `aid` has a standard deviation of: ``velocity_north``, ``velocity_up``,
        ``velocity_east``, m/s, ``lat``, ``lon``, rad, ``alt``, m; NaN where one was lost.
    aid : Aid
        Standard deviations and interval.
    start : float, optional
        Time at which the recording begins, by the clock of `table`, s.

    Returns
    -------
    Fixes
        Times from the beginning of the recording.

    Raises
    ------
    ValueError
        If a column that `aid` measures is missing, or times are no index.
    """
    measured = [name for name in MEASUREMENTS if name in checks.instance("aid", aid, Aid).std]
    check_index(checks.columns(table, measured))
    values = np.full((len(table), 6), np.nan)
    values[:, [MEASUREMENTS.index(name) for name in measured]] = _numbers(table, measured)
    time = checks.finite_array("table.index", table.index.to_numpy(), ndim=1)
    return Fixes(time=time - checks.finite("start", start, "s"), values=values, aid=aid)


def check_index(table: "DataFrame") -> None:
    """Refuse a table that has its times in a column, as a file that was read without naming its index."""
    if "time" in table.columns and table.index.name != "time":
        raise ValueError(
            "`table` must have its times as the index, got a column 'time'. Use `table.set_index(\"time\")`"
        )


def _numbers(table: "DataFrame", columns: Sequence[str]) -> Array:
    """Columns as numbers, shape (n, columns), after the check that they are; NaN may be among them."""
    for name in columns:
        if table[name].dtype.kind not in "iuf":
            raise TypeError(f"`table[{name!r}]` must hold real numbers, got dtype {table[name].dtype}")
    return table[list(columns)].to_numpy(dtype=float)
