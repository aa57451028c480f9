"""Increments: what gyros and accelerometers sum up in each sampling step.

A table of increments has the index ``time``, s, the *beginning* of each step, as recordings of `fogkit.stand` have it,
and the columns of readings: ``gyro_x, gyro_y, gyro_z`` hold the integrals of the rate of the body over the step, rad,
and ``accel_x, accel_y, accel_z`` those of the specific force, m/s, both in body axes, which turn meanwhile.
They are sums, not rotations: coning and sculling are corrected where they are used (`fogkit.navigation.strapdown`).
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.imu.tables import IMU_COLUMNS

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

#: Departure of one time step from their mean, relative to it, that still counts as jitter of the stamps.
JITTER = 0.01


def time_step(table: "DataFrame", name: str = "increments") -> tuple[float, float]:
    """First time and time step of a table with equal steps.

    Parameters
    ----------
    table : DataFrame
        Table of at least 2 rows with the index ``time``, s.
    name : str, optional
        Name of the argument for the messages.

    Returns
    -------
    first, step : float
        First time and mean step, s. Stamps may jitter by `JITTER` of a step: the sensors' clock is the better one.

    Raises
    ------
    ValueError
        If times are not finite, not ascending, or not equally spaced, as in a recording with gaps.
    """
    checks.columns(table, (), name=name)
    times = checks.finite_array(f"{name}.index", table.index, ndim=1, min_size=2)
    steps = np.diff(times)
    if not (steps > 0).all():
        row = int(np.argmin(steps > 0))
        raise ValueError(
            f"`{name}.index` must be times in ascending order, got {times[row + 1]:.9g} s after {times[row]:.9g} s. "
            "Sort the table and drop what it holds twice."
        )
    step = float(np.median(steps))
    wrong = np.abs(steps - step) > JITTER * step
    if wrong.any():
        row = int(np.argmax(wrong))
        raise ValueError(
            f"`{name}.index` must be equally spaced to {JITTER:.0%}, got a step of {steps[row]:.6g} s at "
            f"{times[row]:.9g} s, one of {wrong.sum()} such steps, where the median is {step:.6g} s. "
            "Navigate the pieces between gaps, each from its own start."
        )
    return float(times[0]), float((times[-1] - times[0]) / steps.size)


def values(table: "DataFrame", name: str = "increments") -> Array:
    """Columns of a table in the order of `IMU_COLUMNS`, shape (n, 6), after the check that all are there and finite."""
    columns = list(IMU_COLUMNS)
    checks.columns(table, columns, name=name)
    return checks.finite_array(f"{name}[{columns[0]!r} to {columns[-1]!r}]", table[columns].to_numpy())


def increments_from_rates(readings: "DataFrame", kind: str = "mean") -> "DataFrame":
    """Increments from readings in rad/s and m/s^2.

    Parameters
    ----------
    readings : DataFrame
        Index ``time``, s, equally spaced; columns ``gyro_x`` to ``accel_z``, rad/s and m/s^2.
    kind : {"mean", "instant"}, optional
        What a reading is: the mean over the step that begins at its time, as of a sensor that counts or integrates; or
        the value at that time, as of one that is sampled without a filter.

    Returns
    -------
    DataFrame
        Increments, rad and m/s, with the same columns. There are as many as readings of the kind ``"mean"``, which are
        multiplied by the step, and one less of the kind ``"instant"``.

    Raises
    ------
    ValueError
        If a column is missing, a reading is not finite, or times are not equally spaced.

    Notes
    -----
    Instantaneous readings are interpolated by a cubic through the nearest four, and that is integrated::

        increment = step / 24 * (-before + 13 * first + 13 * last - after)

    wrong by ``11/720 * step**5`` times the fourth derivative. In the first and last step it is a parabola through
    three, one order less. What such readings alias is lost in any case.

    Examples
    --------
    >>> import pandas as pd
    >>> readings = pd.DataFrame(0.5, index=pd.Index([0.0, 0.01, 0.02], name="time"), columns=list(IMU_COLUMNS))
    >>> float(increments_from_rates(readings).gyro_x.sum().round(12))
    0.015
    """
    import pandas as pd

    checks.option("kind", kind, ("mean", "instant"))
    rates = values(readings, name="readings")
    _, step = time_step(readings, name="readings")
    if kind == "mean":
        return pd.DataFrame(rates * step, index=readings.index, columns=list(IMU_COLUMNS))
    if len(rates) < 4:
        raise ValueError(f"`readings` must be at least 4 for a cubic through them, got {len(rates)}")
    sums = np.empty((len(rates) - 1, 6))
    sums[1:-1] = (13 * (rates[1:-2] + rates[2:-1]) - rates[:-3] - rates[3:]) / 24
    sums[0] = (5 * rates[0] + 8 * rates[1] - rates[2]) / 12
    sums[-1] = (5 * rates[-1] + 8 * rates[-2] - rates[-3]) / 12
    return pd.DataFrame(sums * step, index=readings.index[:-1], columns=list(IMU_COLUMNS))


def increments_from_motion(
    omega_ib_b: Callable[[Array], ArrayLike],
    f_ib_b: Callable[[Array], ArrayLike],
    duration: float,
    step: float,
    nodes: int = 8,
) -> "DataFrame":
    """Increments of a motion that is known as functions of time, without error of sampling.

    Parameters
    ----------
    omega_ib_b, f_ib_b : callable
        Rate of the body against inertial space, rad/s, and specific force, m/s^2, both in body axes: functions of times
        in s, shape (n,), that return shape (n, 3).
    duration : float
        End of the motion, s, which begins at 0; a whole number of steps.
    step : float
        Sampling step, s.
    nodes : int, optional
        Nodes of the Gauss-Legendre quadrature over each step, which integrates polynomials of degree ``2 * nodes - 1``
        exactly. Eight integrate a sinusoid with one period per step to 1e-10 of its amplitude times the step.

    Returns
    -------
    DataFrame
        Increments, rad and m/s.

    Raises
    ------
    ValueError
        If a number is out of range, or a function returns another shape or what is not finite.

    Examples
    --------
    >>> steady = increments_from_motion(lambda t: np.full((len(t), 3), 0.1), lambda t: np.zeros((len(t), 3)), 1.0, 0.25)
    >>> steady.gyro_z.round(12).tolist()
    [0.025, 0.025, 0.025, 0.025]
    """
    import pandas as pd

    step = checks.positive("step", step, "s")
    count = checks.positive("duration", duration, "s") / step
    if abs(count - round(count)) > 1e-6 or round(count) < 1:
        raise ValueError(f"`duration` must be a whole number of steps of {step:g} s, got {count:.9g} of them")
    points, weights = np.polynomial.legendre.leggauss(checks.integer("nodes", nodes, minimum=1))
    first = step * np.arange(round(count))
    times = (first[:, None] + 0.5 * step * (1 + points)).ravel()
    sums = []
    for name, function in (("omega_ib_b", omega_ib_b), ("f_ib_b", f_ib_b)):
        sampled = checks.finite_array(f"{name}(t)", function(times), shape=(times.size, 3))
        sums.append(0.5 * step * np.einsum("g,ngi->ni", weights, sampled.reshape(first.size, -1, 3)))
    return pd.DataFrame(np.hstack(sums), index=pd.Index(first, name="time"), columns=list(IMU_COLUMNS))
