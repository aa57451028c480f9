"""Heading accuracy over amplitude and period of the mount, for aids of any accuracy: what choosing the law is about.

The inputs are those of the thesis's experiment: gyros of the VG951's data sheet, read as two-sided, five minutes at
rest. What it does not state is assumed: the latitude of St Petersburg, a heading known to `HEADING_STD` beforehand, and
velocity as the only aid, once a second. Every period divides the time.

`LAW_MAP` holds the outcome of `law_map`, written by ``python -m fogkit.reproduction.lechang.law_map PATH``.
"""

import sys
from collections.abc import Iterable
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from fogkit import checks
from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass.accuracy import best_harmonic_amplitude, mean_direction
from fogkit.gyrocompass.covariance import Aid, Noise, Prior, run_covariance
from fogkit.gyrocompass.laws import ConstantSpeedReversal, MountLaw, QuasiHarmonic
from fogkit.gyrocompass.motions import Motion, Vessel
from fogkit.gyrocompass.velocity_information import bias_left, heading_from_velocities
from fogkit.reproduction.lechang import paper
from fogkit.units import ARCMIN, DEG, DEG_PER_SECOND, PERCENT

if TYPE_CHECKING:
    from pandas import DataFrame

LAW_MAP = "data/derived/lechang_law_map.csv"

AMPLITUDES = (*(np.arange(20.0, 361.0, 10.0) * DEG).tolist(), best_harmonic_amplitude())
PERIODS = (15.0, 20.0, 25.0, 30.0, 37.5, 50.0, 60.0, 75.0, 100.0, 150.0, 300.0)
VELOCITY_STDS = (0.001, 0.01, 0.1)
"""Standard deviations of the aid's velocity, m/s."""

HEADING_STD = 20 * DEG
REVERSAL_TIME = 1.0
"""Time of a reversal at constant speed, s."""

LAWS = ("harmonic", "constant speed")


def law_of(name: str, amplitude: float, period: float) -> MountLaw:
    """A law of `LAWS` of an amplitude, rad, and a period, s."""
    if checks.option("name", name, LAWS) == "harmonic":
        return QuasiHarmonic(amplitude=amplitude, period=period)
    return ConstantSpeedReversal(amplitude=amplitude, period=period, reversal_time=REVERSAL_TIME)


def prior(bias: float = paper.DATA_SHEET_BIAS) -> Prior:
    """What is known at the start: of the gyros no more than the data sheet says."""
    return Prior(heading=HEADING_STD, bias=bias, scale_factor=1 * PERCENT)


def random_walk() -> float:
    """Angle random walk of the data sheet's noise read as two-sided, rad/sqrt(s)."""
    return paper.random_walk_of_the_data_sheet(2)


def by_covariance(law: MountLaw, velocity_std: float, duration: float = paper.EXPERIMENT_TIME) -> float:
    """Standard deviation of heading at the end, rad, by `fogkit.gyrocompass.covariance.run_covariance`."""
    aid = Aid(std=dict.fromkeys(("velocity_north", "velocity_up", "velocity_east"), velocity_std))
    run = run_covariance(
        _motion(law, duration), Noise(angle_random_walk=random_walk()), aid, prior(), output_interval=duration
    )
    return float(run.std[-1, 0])


@lru_cache(maxsize=1)
def _motion(law: MountLaw, duration: float) -> Motion:
    dt = next(dt for dt in (0.05, 0.02, 0.01, 0.005) if law.max_rate * dt <= 0.06)  # rates are averaged over steps
    return Vessel(lat=paper.ASSUMED_LATITUDE, heading=paper.STAND_HEADING).motion(duration, dt, law)


def by_velocities(
    law: MountLaw, velocity_std: float, known: Prior | None = None, duration: float = paper.EXPERIMENT_TIME
) -> float:
    """The same, rad, by `fogkit.gyrocompass.velocity_information.heading_from_velocities`."""
    return heading_from_velocities(
        law,
        duration,
        paper.ASSUMED_LATITUDE,
        random_walk(),
        velocity_std,
        prior() if known is None else known,
        heading=paper.STAND_HEADING,
        drift_std=paper.DATA_SHEET_BIAS,
    )


def by_formula(law: MountLaw, velocity_std: float) -> float:
    """The same, rad, from the mean direction and what the turning part of velocity leaves of a bias.

    Heading with known level biases is taken from all velocities; what is left of a bias comes on top of it, by the mean
    direction over the level Earth rate.
    """
    known = HEADING_STD**-2
    without = 1 / (by_velocities(law, velocity_std, Prior(heading=HEADING_STD, bias=0.0)) ** -2 - known)
    left = bias_left(law, paper.EXPERIMENT_TIME, random_walk(), velocity_std, paper.DATA_SHEET_BIAS)
    level = EARTH_RATE * np.cos(paper.ASSUMED_LATITUDE)
    return float((1 / (without + (abs(mean_direction(law)) * left / level) ** 2) + known) ** -0.5)


def law_map(
    amplitudes: Iterable[float] = AMPLITUDES,
    periods: Iterable[float] = PERIODS,
    velocity_stds: Iterable[float] = VELOCITY_STDS,
    laws: Iterable[str] = LAWS,
) -> "DataFrame":
    """Standard deviation of heading over laws, amplitudes, periods and aids, by covariance and by all velocities.

    Parameters
    ----------
    amplitudes, periods, velocity_stds : iterable of float
        rad, s, m/s.
    laws : iterable of str
        Of `LAWS`.

    Returns
    -------
    DataFrame
        Columns ``law``, ``amplitude_deg``, ``period``, ``velocity_std``, ``max_rate_deg_s``, ``mean_direction``,
        ``heading_arcmin`` (covariance), ``velocities_arcmin`` (least squares of velocities).
    """
    import pandas as pd

    rows = []
    for name in laws:
        for amplitude in amplitudes:
            for period in periods:
                law = law_of(name, amplitude, period)
                for std in velocity_stds:
                    rows.append(
                        {
                            "law": name,
                            "amplitude_deg": amplitude / DEG,
                            "period": period,
                            "velocity_std": std,
                            "max_rate_deg_s": law.max_rate / DEG_PER_SECOND,
                            "mean_direction": abs(mean_direction(law)),
                            "heading_arcmin": by_covariance(law, std) / ARCMIN,
                            "velocities_arcmin": by_velocities(law, std) / ARCMIN,
                        }
                    )
    return pd.DataFrame(rows)


if __name__ == "__main__":
    law_map().to_csv(sys.argv[1], index=False, float_format="%.5f")
