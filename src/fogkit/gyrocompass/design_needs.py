"""Design the other way round: which gyros, or how much time, does a heading take?

`fogkit.gyrocompass.design.heading_accuracy`, solved for the angle random walk or for the time.
"""

import warnings
from bisect import bisect_left
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from fogkit import checks
from fogkit.gyrocompass.design import HeadingAccuracy, heading_accuracy
from fogkit.gyrocompass.design_inputs import GyroGrade, MountLimits
from fogkit.gyrocompass.laws import MountLaw
from fogkit.units import DEG, HOUR


def walk_for(
    accuracy: float, gyro: GyroGrade, mount: MountLimits | MountLaw, lat: float, duration: float, **options
) -> float:
    """Largest angle random walk of the gyros, rad/sqrt(s), with which heading is as accurate as wanted.

    Parameters
    ----------
    accuracy : float
        Standard deviation of heading that is wanted, rad.
    gyro : GyroGrade
        All but the angle random walk counts.
    mount, lat, duration, **options
        As for `fogkit.gyrocompass.design.heading_accuracy`.

    Returns
    -------
    float
        rad/sqrt(s).

    Raises
    ------
    ValueError
        If the other errors alone are larger; the message names the largest.
    """
    accuracy = checks.positive("accuracy", accuracy, "rad")
    checks.instance("gyro", gyro, GyroGrade)

    def found(log_walk: float) -> HeadingAccuracy:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # on the way; the last call below warns
            return heading_accuracy(
                replace(gyro, angle_random_walk=float(np.exp(log_walk))), mount, lat, duration, **options
            )

    unit = found(np.log(gyro.angle_random_walk))
    most = np.log(gyro.angle_random_walk * accuracy / unit.budget["white noise"])  # by white noise alone
    least, most = most - np.log(1e3), most + 1e-3  # a little more, where there is nothing but white noise
    best = found(least)
    if best.std >= accuracy:
        raise ValueError(
            f"`accuracy` must be above what remains without white noise, {best.std / DEG:.4g} deg, got "
            f"{accuracy / DEG:.4g} deg. Most of it is the part {best.largest!r}"
        )
    walk = float(np.exp(brentq(lambda x: np.log(found(x).std / accuracy), least, most, xtol=1e-3)))
    heading_accuracy(replace(gyro, angle_random_walk=walk), mount, lat, duration, **options)
    return walk


def time_for(
    accuracy: float,
    gyro: GyroGrade,
    mount: MountLimits | MountLaw,
    lat: float,
    *,
    longest: float = HOUR,
    **options,
) -> float:
    """Time, s, after which heading is as accurate as wanted, with the best law for it.

    Parameters
    ----------
    accuracy : float
        Standard deviation of heading that is wanted, rad.
    gyro, mount, lat, **options
        As for `fogkit.gyrocompass.design.heading_accuracy`; a law is judged after whole periods.
    longest : float, optional
        Longest time that is tried, s.

    Returns
    -------
    float
        Time, to 1 per cent, or the least number of whole periods of a given law.

    Raises
    ------
    ValueError
        If it is not reached within `longest`, the message naming the largest part then, or `longest` is less than a
        period of the law.
    """
    accuracy = checks.positive("accuracy", accuracy, "rad")
    longest = checks.positive("longest", longest, "s")

    def found(duration: float) -> HeadingAccuracy:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return heading_accuracy(gyro, mount, lat, duration, **options)

    def enough(duration: float) -> bool:
        try:
            return found(duration).std <= accuracy
        except ValueError:  # too short for any law: `found(longest)` has shown that nothing else is wrong
            return False

    if isinstance(mount, MountLaw):
        if longest < mount.period:
            raise ValueError(f"`longest` must be a period of the law at least, {mount.period:g} s, got {longest:g} s")
        longest = mount.period * int(longest / mount.period)
    end = found(longest)
    if end.std > accuracy:
        raise ValueError(
            f"`accuracy` must be within what is reached in {longest:g} s, {end.std / DEG:.4g} deg, got "
            f"{accuracy / DEG:.4g} deg. Most of it is the part {end.largest!r}"
        )
    if isinstance(mount, MountLaw):
        counts = np.arange(1, int(longest / mount.period) + 1)
        return mount.period * int(counts[bisect_left(counts, True, key=lambda n: enough(n * mount.period))])
    low, high = longest * (end.budget["white noise"] / accuracy) ** 2, longest  # no sooner than by white noise alone
    while high / low > 1.01:
        middle = float(np.sqrt(low * high))
        low, high = (low, middle) if enough(middle) else (middle, high)
    return high
