"""What the thesis says of its simulation, put to the rerun: each function says whether it holds, or the number.

Words such as "observable" and "many times" are given a meaning with each. The runs are those of
`fogkit.reproduction.lechang.simulation_runs`, covariances those of `fogkit.reproduction.lechang.simulation`.
"""

import warnings
from functools import cache

import numpy as np

from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass.covariance import Aid, CovarianceRun, Noise, run_covariance
from fogkit.reproduction.lechang import paper, simulation, simulation_runs
from fogkit.units import ARCSEC, DEG, DEG_PER_HOUR, PERCENT

AIDS = simulation.VELOCITY_STD
"""Accuracies of the aid for which a statement must hold, m/s."""

UNSEEN = 0.95
"""Share of the prior standard deviation that is left of what counts as not observed."""

_BIASES, _SCALES = slice(9, 12), slice(12, 15)


@cache
def phases(velocity_std: float) -> tuple[CovarianceRun, CovarianceRun]:
    """`simulation.off_then_on` for an aid, kept."""
    return simulation.off_then_on(velocity_std)


@cache
def _statistics():
    return simulation_runs.statistics(simulation_runs.stored())


def left_with_mount_off(velocity_std: float) -> dict[str, float]:
    """Shares of the prior standard deviations after 400 s with the mount off: heading, best-known bias and scale."""
    std, prior = phases(velocity_std)[0].std[-1], simulation.ASSUMED_PRIOR
    return {
        "heading": float(std[0] / prior.heading),
        "bias": float(std[_BIASES].min() / prior.bias),
        "scale factor": float(std[_SCALES].min() / prior.scale_factor),
    }


def heading_is_hidden_while_off() -> bool:
    """Whether with the mount off more than 95 % of the prior standard deviation of heading is left for every aid."""
    return all(left_with_mount_off(aid)["heading"] > UNSEEN for aid in AIDS)


def biases_are_hidden_while_off() -> bool:
    """Whether with any of the aids all biases keep 95 % of their prior standard deviation with the mount off."""
    return any(left_with_mount_off(aid)["bias"] > UNSEEN for aid in AIDS)


def scale_factors_are_hidden_while_off() -> bool:
    """Whether with any of the aids all scale factors keep 95 % of theirs."""
    return any(left_with_mount_off(aid)["scale factor"] > UNSEEN for aid in AIDS)


def errors_at_the_end(name: str = "wander", time: int = 900) -> dict[str, float]:
    """Root mean square errors over 100 seeds: heading (deg), level, largest of biases (deg/h), scale factors (%).

    ``level`` is the larger of trim and roll, arcsec.
    """
    rms = _statistics().rms.xs(time, level="time")[name]
    return {
        "heading": float(rms["heading"]),
        "level": float(rms[["trim", "roll"]].max() * DEG / ARCSEC),
        "bias": float(rms[rms.index.str.startswith("bias")].max()),
        "scale factor": float(rms[rms.index.str.startswith("scale")].max()),
    }


def angle_errors_go_to_zero() -> bool:
    """Whether heading, trim and roll all end within a tenth of what table 2 asks of them, 500 s after switching on."""
    end = errors_at_the_end()
    level = end["level"] * ARCSEC
    return bool(end["heading"] * DEG < 0.1 * paper.HEADING_ACCURACY and level < 0.1 * paper.LEVEL_ACCURACY)


def heading_noise_floor(time: float = simulation.ASSUMED_DURATION) -> float:
    """Standard deviation of heading, deg, that white gyro noise alone leaves: biases known, at rest.

    ``N / (omega_ie cos(lat) sqrt(T))``: no filter and no law of the mount does better.
    """
    level = EARTH_RATE * np.cos(paper.ASSUMED_LATITUDE)
    return float(paper.SIMULATED_RANDOM_WALK / (level * np.sqrt(time)) / DEG)


def time_to(velocity_std: float, share: float = 0.1) -> dict[str, float]:
    """Seconds after switching on until standard deviations are a share of those of the start.

    Parameters
    ----------
    velocity_std : float
        Of the aid, m/s.
    share : float, optional
        Of the prior standard deviation.

    Returns
    -------
    dict of float
        ``heading``, ``bias`` and ``scale factor`` (the last of three); infinite if not within 500 s.
    """
    on, prior = phases(velocity_std)[1], simulation.ASSUMED_PRIOR
    worst = {
        "heading": on.std[:, 0] / prior.heading,
        "bias": on.std[:, _BIASES].max(axis=1) / prior.bias,
        "scale factor": on.std[:, _SCALES].max(axis=1) / prior.scale_factor,
    }
    reached = {name: np.flatnonzero(values < share) for name, values in worst.items()}
    return {name: float(on.time[at[0]]) if len(at) else np.inf for name, at in reached.items()}


def settling_time() -> float:
    """Seconds until heading and scale factors are a tenth of what they were, for the poorest of the aids."""
    found = time_to(max(AIDS))
    return max(found["heading"], found["scale factor"])


def all_is_settled_after_200_s() -> bool:
    """Whether 200 s after switching on no standard deviation falls by a tenth any more in the 300 s that follow."""
    ratios = [on.std[500, [0, *range(9, 15)]] / on.std[200, [0, *range(9, 15)]] for _, on in map(phases, AIDS)]
    return bool(np.min(ratios) > 0.9)


def all_is_observed_after_200_s() -> bool:
    """Whether then heading, biases and scale factors are all known to a third of their prior, for every aid."""
    return all(max(time_to(aid, 1 / 3).values()) <= paper.SETTLING_TIME for aid in AIDS)


def errors_over_rest(name: str = "wander") -> float:
    """Least ratio of an error of table 4 to the root mean square error of its estimate at the end, for a filter."""
    rms = _statistics().rms.xs(900, level="time")[name][list(simulation_runs.QUANTITIES)]
    biases, scales = paper.SIMULATED_BIASES / DEG_PER_HOUR, paper.SIMULATED_SCALE_FACTORS / PERCENT
    values = [*np.abs(biases), *scales]
    return float(min(value / rms[quantity] for value, quantity in zip(values, rms.index[3:], strict=True)))


def estimates_are_many_times_better(name: str = "wander") -> bool:
    """Whether each is at least three times as small."""
    return errors_over_rest(name) > 3


def scale_factors_within(limit: float = 0.03 * PERCENT, velocity_std: float = 0.01) -> float:
    """Seconds after switching on until three standard deviations of all scale factors stay below a limit.

    0.03 % is marked in figure 7, which is lost.
    """
    on = phases(velocity_std)[1]
    outside = np.flatnonzero(3 * on.std[:, _SCALES].max(axis=1) >= limit)
    last = outside[-1] if len(outside) else -1
    return np.inf if last == len(on.time) - 1 else float(on.time[last + 1])


def filter_may_be_believed(name: str, time: int = 900) -> bool:
    """Whether heading is within three of its standard deviations in at least 95 of 100 seeds at a time.

    Of Gaussian errors 99.7 are; fewer than 95 by chance less than once in a million.
    """
    return bool(_statistics().within_3[name, "heading", time] >= 0.95)


def algorithm_works() -> bool:
    """Whether the thesis's own filter makes every error of table 4 three times, and heading ten times, as small."""
    before, after = (errors_at_the_end("extended", time)["heading"] for time in (400, 900))
    return estimates_are_many_times_better("extended") and after < before / 10


@cache
def unaided_growth() -> dict[str, float]:
    """How many times larger errors are after 400 s without an aid than with one of 1 cm/s: height, velocity, level."""
    ship = simulation.vessel().motion(simulation.ASSUMED_SWITCH_ON, simulation.STEP)
    noise, lat = Noise(angle_random_walk=paper.SIMULATED_RANDOM_WALK), paper.ASSUMED_LATITUDE
    aid = Aid.satellite(lat, velocity=0.01, interval=2 * simulation.ASSUMED_SWITCH_ON)  # once, at the start
    with warnings.catch_warnings(action="ignore"):  # that errors then grow freely is what is asked
        alone = run_covariance(ship, noise, aid, simulation.ASSUMED_PRIOR).std[-1]
    aided = phases(0.01)[0].std[-1]
    return {
        "height": float(alone[8] / aided[8]),
        "velocity": float(alone[[3, 5]].max() / aided[[3, 5]].max()),
        "level": float(alone[1:3].max() / aided[1:3].max()),
    }


def aid_bounds_errors() -> bool:
    """Whether an aid keeps height, velocity and level at least ten times as small."""
    return min(unaided_growth().values()) > 10


def pyramid_shows_all() -> bool:
    """Whether heading, biases and scale factors are all seen with the mount on, at rest and rolling."""
    law = simulation.mount()
    return all(simulation.unseen(law, rolling=rolling)[0].max() < 0.05 for rolling in (False, True))


def cube_hides_level_gyros() -> bool:
    """Whether biases of the two level gyros of a cube stay at 95 % of their prior with the mount on: compass Omega."""
    fractions, directions = simulation.unseen(simulation.mount(), rolling=False, axes=simulation.CUBE)
    left = np.sqrt(np.diag(directions @ np.diag(fractions**2) @ directions.T))
    return bool(left[[1, 3]].min() > UNSEEN)


def scale_factor_bound(velocity_std: float = 0.01) -> float:
    """Three standard deviations of the least known scale factor 200 s after switching on, percent."""
    return float(3 * phases(velocity_std)[1].std[round(paper.SETTLING_TIME), _SCALES].max() / PERCENT)
