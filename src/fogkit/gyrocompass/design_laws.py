"""Which law of the mount is best within what the mount can do."""

from collections.abc import Iterator

import numpy as np
from scipy.optimize import brentq

from fogkit import checks
from fogkit.gyrocompass.accuracy import best_harmonic_amplitude
from fogkit.gyrocompass.design_inputs import GyroGrade, MountLimits
from fogkit.gyrocompass.design_noise import level_estimate
from fogkit.gyrocompass.laws import ConstantSpeedReversal, DwellAndTurn, MountLaw, OneWay, QuasiHarmonic
from fogkit.units import DEG

PERIODS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32)
"""Whole periods in the time that are tried."""

ENOUGH = 1.01
"""A slower law, or one further up in the list of `laws_within`, is taken if its heading is worse by this at most."""


_PLACES = (
    np.arange(1000) + 0.5
) / 1000  # in a period, for the mean direction: a law is as good within 1e-3 of its zero


def laws_within(mount: MountLimits, max_rate: float, duration: float) -> Iterator[MountLaw]:
    """Laws that a mount can do, with whole periods in a time, each with the mean direction as near zero as it gets.

    Parameters
    ----------
    mount : MountLimits
        Travel and acceleration count.
    max_rate : float
        Largest rate, rad/s.
    duration : float
        Time of the measurement, s.

    Yields
    ------
    MountLaw
        One-way turning (with slip rings), reversal at constant speed, rocking, dwells at two ends; for each the slowest
        first.
    """
    duration, max_rate = checks.positive("duration", duration, "s"), checks.positive("max_rate", max_rate, "rad/s")
    makers = (_reversal, _rocking, _dwells)
    if mount.travel == np.inf:
        makers = (_one_way, *makers)
    for make in makers:
        for count in PERIODS:
            law = make(mount, max_rate, duration / count)
            if law is not None:
                yield law


def best_law(
    gyro: GyroGrade,
    mount: MountLimits,
    lat: float,
    duration: float,
    *,
    heading_fixed: bool = False,
    max_rate: float | None = None,
) -> MountLaw:
    """Law with the best heading within what mount and gyros can do.

    Parameters
    ----------
    gyro, mount, lat, duration, heading_fixed
        As for `fogkit.gyrocompass.design.heading_accuracy`.
    max_rate : float, optional
        Largest rate, rad/s; `MountLimits.rate_with` the gyro and a hull at rest if not given.

    Returns
    -------
    MountLaw
        Of `laws_within`: the first whose standard deviation is within `ENOUGH` of the least.

    Raises
    ------
    ValueError
        If the mount is too slow for any law to be done once in the time.
    TypeError
        If `gyro` is no `GyroGrade` or `mount` no `MountLimits`.
    """
    checks.instance("gyro", gyro, GyroGrade)
    checks.instance("mount", mount, MountLimits)
    rate = mount.rate_with(gyro) if max_rate is None else max_rate
    laws = list(laws_within(mount, rate, duration))
    if not laws:
        raise ValueError(
            f"`duration` must be long enough for one period of some law within `mount`, got {duration:g} s at up to "
            f"{rate / DEG:.3g} deg/s and {mount.max_acceleration / DEG:.3g} deg/s^2"
        )
    std = np.array([level_estimate(law, duration, lat, gyro, heading_fixed).std for law in laws])
    return laws[int(np.argmax(std <= ENOUGH * std.min()))]


def _one_way(mount: MountLimits, max_rate: float, period: float) -> MountLaw | None:
    law = OneWay(period=period)
    return law if law.max_rate <= max_rate * (1 + 1e-12) else None


def _reversal(mount: MountLimits, max_rate: float, period: float) -> MountLaw | None:
    """Reversal at the mount's acceleration, with a mean direction of zero if there is the travel."""

    def made(amplitude: float) -> ConstantSpeedReversal | None:
        a = mount.max_acceleration
        root = period**2 / 4 - 8 * amplitude / a
        if root < 0:
            return None
        speed = a / 2 * (period / 2 - np.sqrt(root))  # of speed (period/2 - speed/a) = 2 amplitude
        law = ConstantSpeedReversal(amplitude=amplitude, period=period, reversal_time=2 * speed / a)
        return law if law.max_rate <= max_rate * (1 + 1e-9) else None

    return _at_zero_mean(made, mount.travel / 2, np.pi / 2, np.pi)


def _rocking(mount: MountLimits, max_rate: float, period: float) -> MountLaw | None:
    law = QuasiHarmonic(amplitude=min(mount.travel / 2, best_harmonic_amplitude()), period=period)
    frequency = 2 * np.pi / period
    within = law.max_rate <= max_rate and law.amplitude * frequency**2 <= mount.max_acceleration
    return law if within else None


def _dwells(mount: MountLimits, max_rate: float, period: float) -> MountLaw | None:
    """Dwells at two ends as far apart as the mean direction asks or the travel allows, with the quickest turns."""

    def made(amplitude: float) -> DwellAndTurn | None:
        turn = max(4 * amplitude / max_rate, np.sqrt(4 * np.pi * amplitude / mount.max_acceleration))
        if turn >= period / 2:
            return None
        return DwellAndTurn(positions=(-amplitude, amplitude), dwell=period / 2 - turn, turn_duration=turn)

    return _at_zero_mean(made, mount.travel / 2, np.pi / 2, 3 * np.pi / 4)


def _at_zero_mean(made, most: float, low: float, high: float) -> MountLaw | None:
    """The law at the amplitude in [low, high] with mean direction zero, at the largest allowed if that is less."""

    def mean(amplitude: float) -> float:
        law = made(amplitude)  # none: as if beyond the zero
        return -1.0 if law is None else float(np.cos(law.angle(law.period * _PLACES)).mean())

    if most <= low or mean(low) <= 0:
        return made(min(most, low))
    if mean(high := min(most, high)) > 0:
        return made(high)
    if made(high) is not None:
        return made(brentq(mean, low, high, xtol=1e-6))
    for _ in range(40):  # too wide for the mount: the zero, or the widest that it can do
        middle = (low + high) / 2
        low, high = (middle, high) if mean(middle) > 0 else (low, middle)
    return made(low)
