"""The thesis's budget of rates, from the range of a gyro to the period of the mount, under each reading of a sum."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fogkit.gyrocompass.frames import pyramid_axes
from fogkit.gyrocompass.laws import QuasiHarmonic
from fogkit.reproduction.lechang import paper
from fogkit.units import DEG_PER_SECOND

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, kw_only=True)
class Budget:
    """What is left for the mount.

    Attributes
    ----------
    mount_rate : float
        Largest rate of the mount, rad/s.
    period : float
        Shortest period of a harmonic law of the thesis's amplitude, s.
    """

    mount_rate: float
    period: float


def hull_rates() -> tuple[float, float, float]:
    """Largest rates of heading, trim and roll of the example, rad/s: ``amplitude * 2 pi / period`` for the last two."""
    trim = paper.TRIM_AMPLITUDE * 2 * np.pi / paper.TRIM_PERIOD
    return paper.HEADING_RATE, trim, paper.ROLL_AMPLITUDE * 2 * np.pi / paper.ROLL_PERIOD


def budgets(amplitude: float = paper.LEAST_AMPLITUDE, limit: float = paper.RATE_LIMIT) -> dict[str, Budget]:
    """Budgets by how rates are taken to add.

    Parameters
    ----------
    amplitude : float, optional
        Amplitude of the mount, rad.
    limit : float, optional
        Rate that a gyro may read, rad/s.

    Returns
    -------
    dict of Budget
        ``"squares"``: squares of all four add up to the square of the limit, as printed; ``"sum"``: the four rates add
        up to it; ``"one gyro"``: what a gyro of the pyramid sees of them, all at their largest at once and the mount
        at its worst angle; ``"no hull"``: the mount alone, on a gyro of the pyramid.
    """
    heading, trim, roll = hull_rates()
    axes = pyramid_axes()
    up, level = float(axes[1, 0]), float(np.hypot(axes[0, 0], axes[2, 0]))
    left = {
        "squares": np.sqrt(limit**2 - heading**2 - trim**2 - roll**2),
        "sum": limit - heading - trim - roll,
        "one gyro": (limit - level * np.hypot(trim, roll)) / up - heading,
        "no hull": limit / up,
    }
    return {
        name: Budget(mount_rate=float(rate), period=QuasiHarmonic.from_rate(amplitude, float(rate)).period)
        for name, rate in left.items()
    }


def to_frame() -> "DataFrame":
    """`budgets` at the thesis's amplitude, and at the 180 degrees that it then takes: deg/s and s."""
    import pandas as pd

    rows = [
        {
            "reading": name,
            "mount_rate_deg_s": budget.mount_rate / DEG_PER_SECOND,
            "period_90_s": budget.period,
            "period_180_s": budgets(np.pi)[name].period,
        }
        for name, budget in budgets().items()
    ]
    return pd.DataFrame(rows).set_index("reading")
