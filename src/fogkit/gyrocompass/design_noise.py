"""How well the level gyro signals give heading under a law, with noise of any colour: weighted least squares.

In axes of the mount the two level signals are, as one complex number (`fogkit.gyrocompass.accuracy`), the Earth's level
rate times ``i exp(i beta)`` for each radian of heading. Beside it stand what the gyros add: biases (1), scale factors
and misalignments (the mount's rate), and, where the hull is not known to keep its heading, what the up gyro adds of the
same kinds, integrated. All of these are unknowns with a prior; white noise, flicker and random walk of the rate are
weighed by their covariance. Asymmetry of the scale factors (the magnitude of the rate) is no state of the filters here:
what it makes of their estimate is added.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.constants import EARTH_RATE
from fogkit.earth import POLE_MARGIN, checked_latitude
from fogkit.gyrocompass.design_inputs import GyroGrade
from fogkit.gyrocompass.laws import MountLaw

Array = NDArray[np.float64]

PARTS = ("white noise", "separation", "bias", "scale factor", "asymmetry", "bias instability", "rate random walk")
"""Parts of the variance: white noise if all else is known; what it costs that biases and the like are estimated too;
then what is left of each of them with what is known of it beforehand, what asymmetry does, and the coloured noise."""

MOST_PERIODS = 100
BLOCKS_PER_PERIOD = 24
FEWEST_BLOCKS = 240
_STEP = 0.02  # angle, rad, between points of a mean: wrong by 0.02**2/24 = 2e-5 of it
_POINTS = 4096  # fewest points


@dataclass(frozen=True, kw_only=True)
class LevelEstimate:
    """Heading from level gyros.

    Attributes
    ----------
    variances : dict of str to float
        By `PARTS`, rad^2; their sum is the variance of heading, infinite if heading cannot be told from a bias.
    mean_direction : complex
        Mean of ``exp(i beta)`` over the time.
    """

    variances: dict[str, float]
    mean_direction: complex

    @property
    def std(self) -> float:
        """Standard deviation of heading, rad."""
        return float(np.sqrt(sum(self.variances.values())))


def level_estimate(
    law: MountLaw, duration: float, lat: float, gyro: GyroGrade, heading_fixed: bool = False
) -> LevelEstimate:
    """Best linear estimate of heading at the end of a time, level and at rest.

    Parameters
    ----------
    law : MountLaw
        Law of the mount.
    duration : float
        s.
    lat : float
        rad.
    gyro : GyroGrade
        Of all three gyros.
    heading_fixed : bool, optional
        Whether the hull is known to keep its heading; if not, the up gyro says how it turns.

    Returns
    -------
    LevelEstimate
        Parts of the variance.

    Raises
    ------
    ValueError
        If there is coloured noise over more than `MOST_PERIODS` periods of the law, or latitude is that of a pole.

    Notes
    -----
    The time is cut into blocks. Their means are weighed with the full covariance of the noise; what the signals do
    within a block is weighed with the density of the noise at one over its length, so with white noise the result does
    not depend on the blocks; with coloured noise as large as the white it is some per mille too small.
    Left out is the random noise of the up gyro (`accuracy.heading_bound`). Coloured noise starts from a mean of zero
    over the first block: the prior of the bias is that of this mean.
    """
    duration = checks.positive("duration", duration, "s")
    checks.instance("gyro", checks.instance("law", law, MountLaw) and gyro, GyroGrade)
    level = EARTH_RATE * np.cos(float(checked_latitude(checks.finite("lat", lat, "rad"), pole_margin=POLE_MARGIN)))
    count = _blocks(law, duration, gyro)
    columns, priors, kinds = _signals(law, duration, level, gyro, heading_fixed, count)
    means = columns.mean(axis=2)  # (unknowns, blocks)
    within = columns - means[:, :, np.newaxis]
    dt, N2 = duration / count, gyro.angle_random_walk**2
    density = float(gyro.random.power_spectral_density(1 / dt))
    inner = np.einsum("abk,cbk->ac", within.conj(), within, optimize=True).real * dt / columns.shape[2] / density
    white, flicker, walk = _covariances(gyro, count, dt)
    if gyro.bias_instability or gyro.rate_random_walk:
        weighed = np.linalg.solve(white + flicker + walk, means.T).T
    else:
        weighed = means * dt / N2
    information = inner + (weighed.conj() @ means.T).real
    with np.errstate(divide="ignore"):
        prior = 1 / np.square(priors)
    known = np.isinf(prior)  # a standard deviation of zero
    ignored = np.array([kind == "asymmetry" for kind in kinds])
    free = np.flatnonzero(~known & ~ignored)
    row = _first_row(information[np.ix_(free, free)] + np.diag(prior[free]))
    mean = complex(np.exp(1j * law.angle(_times(law, duration, count))).mean())
    if row is None:
        return LevelEstimate(variances=dict.fromkeys(PARTS, 0.0) | {"separation": np.inf}, mean_direction=mean)
    weights = row @ weighed[free]
    variances = dict.fromkeys(PARTS, 0.0)
    variances["white noise"] = N2 / (level**2 * duration)
    total = _form(weights, white) + float(row @ inner[np.ix_(free, free)] @ row)
    variances["separation"] = max(total - variances["white noise"], 0.0)  # rounding, where nothing is lost
    variances["bias instability"], variances["rate random walk"] = _form(weights, flicker), _form(weights, walk)
    for k, value in zip(free, row, strict=True):
        if k:
            variances[kinds[k]] += float(value**2 * prior[k])
    for k in np.flatnonzero(ignored):
        variances["asymmetry"] += float((row @ information[free, k]) ** 2 * priors[k] ** 2)
    return LevelEstimate(variances=variances, mean_direction=mean)


def _signals(
    law: MountLaw, duration: float, level: float, gyro: GyroGrade, heading_fixed: bool, count: int
) -> tuple[Array, Array, list[str]]:
    """What heading and each unknown make of the level rate, (unknowns, blocks, points); their priors; their parts."""
    t = _times(law, duration, count)
    angle, rate, _ = law.motion(t)
    heading = 1j * level * np.exp(1j * angle)
    # three gyros see 1/sqrt(3) of the mount's rate, with independent errors: level errors of 1/sqrt(3) each way
    scale, asymmetry = gyro.scale_factor / np.sqrt(3), 0.5 * gyro.scale_asymmetry / np.sqrt(3)
    one, fast = np.ones_like(rate), np.abs(rate)
    columns = [heading, one, 1j * one, rate, 1j * rate, fast, 1j * fast]
    priors = [np.inf, *[gyro.bias] * 2, *[scale] * 2, *[asymmetry] * 2]
    kinds = ["", *["bias"] * 2, *["scale factor"] * 2, *["asymmetry"] * 2]
    if not heading_fixed:
        covered = np.cumsum(fast.ravel()).reshape(fast.shape) * (duration / fast.size)
        turned = angle - law.angle(duration)
        columns += [heading * (t - duration), heading * turned, heading * (covered - covered[-1, -1])]
        priors += [gyro.bias, scale, asymmetry]
        kinds += ["bias", "scale factor", "asymmetry"]
    return np.array(columns), np.array(priors), kinds


def _blocks(law: MountLaw, duration: float, gyro: GyroGrade) -> int:
    periods = duration / law.period if law.max_rate > 0 else 1.0
    if not (gyro.bias_instability or gyro.rate_random_walk):
        return 1
    if periods > MOST_PERIODS:
        raise ValueError(
            f"`duration` must be at most {MOST_PERIODS} periods of the law with coloured noise, got {periods:.4g}: "
            "beyond, scale a result by the root of time, or use `accuracy.steady_heading_std`"
        )
    return max(FEWEST_BLOCKS, int(np.ceil(BLOCKS_PER_PERIOD * periods)))


def _times(law: MountLaw, duration: float, count: int) -> Array:
    """Midpoints of equal steps, shape (blocks, points)."""
    points = max(_POINTS, int(np.ceil(law.max_rate * duration / _STEP)))
    points = int(np.ceil(points / count))
    return duration * (np.arange(count * points).reshape(count, points) + 0.5) / (count * points)


def _covariances(gyro: GyroGrade, count: int, dt: float) -> tuple[Array, Array, Array]:
    """Covariances of block means of white noise, flicker and random walk, less the first mean for the latter two.

    They follow from the generalised covariances of the angle at a lag, as in `fogkit.noise.covariance`.
    """
    lag = dt * np.arange(count + 1)
    flicker = gyro.bias_instability**2 * lag**2 * np.log(np.where(lag > 0, lag, 1.0) / dt) / (2 * np.pi)
    walk = gyro.rate_random_walk**2 * lag**3 / 12
    made = []
    for f in (flicker, walk):
        below = np.concatenate([f[1:2], f[:-1]])  # at the lags less one step; even in the lag
        mean = (2 * f[:-1] - below[:-1] - f[1:]) / dt**2
        at = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
        made.append(mean[at] - mean[:, np.newaxis] - mean + mean[0])
    return gyro.angle_random_walk**2 / dt * np.eye(count), made[0], made[1]


def _form(weights: Array, covariance: Array) -> float:
    return float((weights.conj() @ covariance @ weights).real)


def _first_row(information: Array) -> Array | None:
    """First row of the covariance, None if the first unknown cannot be told from the others."""
    scale = np.sqrt(np.diag(information))
    scale[scale == 0] = 1.0
    normed = information / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(normed)
    lost = values < 1e-11  # rounding of the sums
    if (np.abs(vectors[0, lost]) > 1e-3).any():
        return None
    kept = vectors[:, ~lost]
    return (kept[0] / values[~lost]) @ kept.T / scale / scale[0]
