"""Design of a gyrocompass: how well do gyros, mount, latitude and time give heading, and what is the weakest part?

For a hull at rest. Heading comes from the level gyro signals (`fogkit.gyrocompass.design_noise`); to it are added what
tilts, the angle sensor and a poor aid do. Parts are added by squares.
"""

import warnings
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.gyrocompass.accuracy import accelerometer_share, encoder_share
from fogkit.gyrocompass.covariance import Aid, Noise, Prior, run_covariance
from fogkit.gyrocompass.design_inputs import GyroGrade, MountLimits
from fogkit.gyrocompass.design_laws import best_law
from fogkit.gyrocompass.design_noise import PARTS, level_estimate
from fogkit.gyrocompass.encoder import Encoder
from fogkit.gyrocompass.gyro_range import gyro_peaks
from fogkit.gyrocompass.laws import COARSEST_STEP, MountLaw
from fogkit.gyrocompass.motions import Vessel
from fogkit.units import DEG, DEG_PER_SECOND

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

HIGH_LATITUDE = 80 * DEG
"""Latitude, rad, beyond which a warning says what the pole costs."""

LARGEST_STD = 10 * DEG
"""Standard deviation of heading, rad, beyond which parts of a linear model say little."""

_START = 3.0  # standard deviation of heading, rad, that the covariance with an aid starts from: nothing is known


@dataclass(frozen=True, kw_only=True)
class HeadingAccuracy:
    """Accuracy of heading and where it comes from.

    Attributes
    ----------
    std : float
        Standard deviation of heading, rad.
    budget : dict of str to float
        Its parts, rad, of which the squares add up: those of `design_noise.PARTS`, ``"level"``, ``"encoder"`` and
        ``"aid"``.
    law : MountLaw
        The law that was given or chosen.
    mean_direction : complex
        Of the law over the time: 0 is best.
    """

    std: float
    budget: dict[str, float]
    law: MountLaw
    mean_direction: complex

    @property
    def largest(self) -> str:
        """Name of the largest part."""
        return max(self.budget, key=self.budget.get)

    def to_frame(self) -> "DataFrame":
        """Table with the index ``part`` and the columns ``std``, rad, and ``share`` of the variance."""
        import pandas as pd

        table = pd.DataFrame({"std": {**self.budget, "all": self.std}}).rename_axis("part")
        return table.assign(share=(table["std"] / self.std) ** 2)


def heading_accuracy(
    gyro: GyroGrade,
    mount: MountLimits | MountLaw,
    lat: float,
    duration: float,
    *,
    aid: Aid | None = None,
    level_std: float = 0.0,
    encoder: Encoder | None = None,
    heading_fixed: bool = False,
    velocity_random_walk: float = 0.0,
    hull_rates: ArrayLike = (0.0, 0.0, 0.0),
) -> HeadingAccuracy:
    """Standard deviation of heading that gyros on a mount reach in a time, and its budget.

    Parameters
    ----------
    gyro : GyroGrade
        Of the three gyros.
    mount : MountLimits or MountLaw
        What the mount can do, and the best law within it is taken; or the law.
    lat : float
        Latitude, rad.
    duration : float
        Time of the measurement, s.
    aid : Aid, optional
        Velocity or position that tells tilts from turning. None: level angles are known but for `level_std`.
    level_std : float, optional
        Standard deviation of a constant error of the tilts, rad: accelerometer bias over gravity.
    encoder : Encoder, optional
        Errors of the mount's angle sensor, each taken as a standard deviation; the noise is left out.
    heading_fixed : bool, optional
        True if the hull is known not to turn; no aid of velocity and position knows that.
    velocity_random_walk : float, optional
        Of each accelerometer, m/s/sqrt(s); counts with an aid only.
    hull_rates : array_like, shape (3,), optional
        Largest rates of the hull, rad/s, for the range of the gyros only (`gyro_range.gyro_peaks`).

    Returns
    -------
    HeadingAccuracy
        Standard deviation, budget, law.

    Raises
    ------
    ValueError
        If latitude is that of a pole, no law is possible in the time, an aid comes with a heading that is known to be
        fixed or with a bias of which nothing is known.

    Warns
    -----
    UserWarning
        If the law covers less than a period in the time, a gyro leaves its range, latitude is beyond `HIGH_LATITUDE`,
        the aid makes the largest part, or heading is worse than `LARGEST_STD`.

    Notes
    -----
    The part of the aid is what `run_covariance` has above the estimate without aid, for the same white noise, random
    walk and priors. It comes about where velocities are too noisy to tell a bias, which turns with the mount, from a
    tilt.

    Examples
    --------
    Gyros of 0.01 deg/sqrt(h) at 60 degrees of latitude, five minutes, a mount with cables; in degrees:

    >>> from fogkit.units import DEG_PER_SQRT_HOUR
    >>> gyro = GyroGrade(angle_random_walk=0.01 * DEG_PER_SQRT_HOUR)
    >>> found = heading_accuracy(gyro, MountLimits(), 60 * DEG, 300.0, heading_fixed=True)
    >>> print(f"{found.std / DEG:.3f}, {type(found.law).__name__}")
    0.264, ConstantSpeedReversal
    """
    checks.instance("gyro", gyro, GyroGrade)
    checks.instance("mount", mount, (MountLimits, MountLaw))
    duration = checks.positive("duration", duration, "s")
    level_std = checks.non_negative("level_std", level_std, "rad")
    heading_fixed = checks.instance("heading_fixed", heading_fixed, bool)
    walk = checks.non_negative("velocity_random_walk", velocity_random_walk, "m/s/sqrt(s)")
    if aid is not None:
        checks.instance("aid", aid, Aid)
        if heading_fixed:
            raise ValueError("`heading_fixed` must be False with an aid: velocity and position do not know it")
        if gyro.bias == np.inf:
            raise ValueError("`gyro.bias` must be finite with an aid, got inf: a covariance has to start somewhere")
    law = mount
    if isinstance(mount, MountLimits):
        rate = mount.rate_with(gyro, hull_rates)
        law = best_law(gyro, mount, lat, duration, heading_fixed=heading_fixed, max_rate=rate)
    found = level_estimate(law, duration, lat, gyro, heading_fixed)
    budget = {name: float(np.sqrt(found.variances[name])) for name in PARTS}
    budget["level"] = accelerometer_share(lat, level_std)
    budget["encoder"] = 0.0 if encoder is None else abs(encoder_share(law, encoder, duration))
    budget["aid"] = 0.0 if aid is None else aid_share(gyro, law, lat, duration, aid, walk)
    std = float(np.sqrt(np.sum(np.square(list(budget.values())))))
    result = HeadingAccuracy(std=std, budget=budget, law=law, mean_direction=found.mean_direction)
    _warn(result, gyro, lat, duration, hull_rates)
    return result


def aid_share(
    gyro: GyroGrade, law: MountLaw, lat: float, duration: float, aid: Aid, velocity_random_walk: float = 0.0
) -> float:
    """Part of a heading's standard deviation, rad, that an aid makes: by squares, above that with level angles known.

    Parameters are those of `heading_accuracy`. Bias instability and asymmetry are left out of both.
    """
    plain = replace(gyro, bias_instability=0.0, scale_asymmetry=0.0)
    with_aid = aided_std(plain, law, lat, duration, aid, velocity_random_walk)
    return float(np.sqrt(max(with_aid**2 - level_estimate(law, duration, lat, plain).std ** 2, 0.0)))


def aided_std(
    gyro: GyroGrade, law: MountLaw, lat: float, duration: float, aid: Aid, velocity_random_walk: float = 0.0
) -> float:
    """Standard deviation of heading, rad, that `run_covariance` has at the end.

    Nothing is known of heading at the start. Parameters are those of `heading_accuracy`. Bias instability and asymmetry
    are no part of that covariance.
    """
    step = min(aid.interval, COARSEST_STEP / 2 / law.max_rate if law.max_rate > 0 else np.inf, 0.1)
    dt = aid.interval / np.ceil(aid.interval / step)
    motion = Vessel(lat=lat).motion(duration, dt, law)
    noise = Noise(
        angle_random_walk=gyro.angle_random_walk,
        velocity_random_walk=velocity_random_walk,
        rate_random_walk=gyro.rate_random_walk,
    )
    prior = Prior(heading=_START, bias=gyro.bias, scale_factor=gyro.scale_factor).covariance(lat, linear=False)
    run = run_covariance(motion, noise, aid, prior, output_interval=aid.interval)
    return float(np.sqrt(run.covariance[0, 0]))


def _warn(result: HeadingAccuracy, gyro: GyroGrade, lat: float, duration: float, hull_rates: ArrayLike) -> None:
    periods = duration / result.law.period if result.law.max_rate > 0 else np.inf
    if periods < 1 - 1e-9:
        _say(f"`duration` of {duration:g} s is {periods:.2g} of a period of the law, which never comes round")
    peak = float(gyro_peaks(result.law, hull_rates).max())
    if peak > gyro.largest_rate * (1 + 1e-9):
        _say(
            f"a gyro sees up to {peak / DEG_PER_SECOND:.4g} deg/s, beyond its range of "
            f"{gyro.largest_rate / DEG_PER_SECOND:.4g} deg/s"
        )
    if abs(lat) > HIGH_LATITUDE:
        _say(f"`lat` of {lat / DEG:.4g} deg makes heading {1 / np.cos(lat):.3g} times as uncertain as at the equator")
    if result.budget["aid"] > 0 and result.largest == "aid":
        rest = np.sqrt(result.std**2 - result.budget["aid"] ** 2)
        _say(
            f"the aid makes {result.budget['aid'] / DEG:.3g} deg, all the rest {rest / DEG:.3g} deg: a better aid, or "
            f"a mean direction of the law nearer zero than {abs(result.mean_direction):.2g}, helps more than gyros"
        )
    if result.std > LARGEST_STD:
        _say(f"heading is known to {result.std / DEG:.3g} deg only, where a linear budget says little")


def _say(text: str) -> None:
    warnings.warn(text, UserWarning, stacklevel=4)
