"""How the bias drifts after the power on and in a warm unit: statements of section 3.4 of the slides.

The slides have no data. Each function puts one statement to a simulated test and returns numbers, rates in rad/s. They
hold for these networks and this gyro; that a real gyro's bias is linear in temperatures and rates is assumed, not
tested.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit.results import Record
from fogkit.thermal import experiment
from fogkit.thermal.network import ThermalNetwork, soak
from fogkit.units import DEG_PER_HOUR, HOUR

if TYPE_CHECKING:
    pass


@dataclass(frozen=True, kw_only=True)
class CoilField(Record):
    """Difference of temperature between the faces of the coil half an hour after the power on, K.

    Attributes
    ----------
    alone, in_unit : float
        In the test of the gyro alone and in the unit.
    """

    alone: float
    in_unit: float


def field_in_unit() -> CoilField:
    """Temperature field at the coil with and without neighbours that heat, in a steady chamber, exact.

    Alone the difference is zero because the network is symmetric; what a real chamber leaves is not known.

    "In a system other instruments and circuits heat too, and the field is very different."
    """

    def difference(network: ThermalNetwork) -> float:
        temperatures, _ = network.solve(np.array([0.0, 0.5 * HOUR]), soak(20.0))
        top, bottom = (network.nodes.index(point) for point in ("coil_top", "coil_bottom"))
        return float(abs(temperatures[-1, top] - temperatures[-1, bottom]))

    return CoilField(alone=difference(experiment.alone()), in_unit=difference(experiment.in_unit()))


@dataclass(frozen=True, kw_only=True)
class SteadyStateDrift(Record):
    """Drift of a warm unit in a chamber that moves, rad/s.

    Attributes
    ----------
    deviation : float
        Smallest standard deviation of the bias in a run, without noise.
    noise : float
        Of one row of the regression.
    repeatability : float
        From run to run.
    """

    deviation: float
    noise: float
    repeatability: float


def steady_state_drift() -> SteadyStateDrift:
    """Bias of a warm unit while the ambient temperature moves: "the ambient temperature still disturbs it"."""
    gyro = experiment.example_gyro()
    tables = experiment.campaign(experiment.in_unit(), experiment.warm_runs())
    return SteadyStateDrift(
        deviation=float(min(table["bias"].std() for table in tables)),
        noise=float(gyro.angle_random_walk / np.sqrt(experiment.WINDOW)),
        repeatability=gyro.bias_repeatability,
    )


@dataclass(frozen=True, kw_only=True)
class ShortRunLimit(Record):
    """How long the change of the bias after the power on may be neglected.

    Attributes
    ----------
    noise_time : float
        Time at which the neglected part passes the white noise of a mean over that time, s.
    repeatability_time : float
        Time at which it passes the repeatability of the bias, s.
    hundredth_time : float
        Time at which it passes 0.01 deg/h, s.
    after_minute, after_ten_minutes, after_hour : float
        Neglected part of runs of these lengths, rad/s.
    spread : float
        By how much the neglected part after ten minutes differs between starts from -40 and from 60 degC, rad/s.
    """

    noise_time: float
    repeatability_time: float
    hundredth_time: float
    after_minute: float
    after_ten_minutes: float
    after_hour: float
    spread: float


def short_run_limit() -> ShortRunLimit:
    """Time for which only the temperature at the power on matters: exact, without noise.

    "In short operation the change of temperature within the run can be neglected." What is neglected in a run of
    length t is the mean of the bias over the run less the bias at its start. The network is linear, so it is the same
    at any start temperature.
    """
    gyro, network = experiment.example_gyro(), experiment.in_unit()
    time = np.append(0.0, np.geomspace(0.01, 2 * HOUR, 4000))
    neglected = np.array([_mean_change(gyro, network, time, start) for start in (-40.0, 60.0)])
    worst = np.abs(neglected).max(axis=0)
    noise = gyro.angle_random_walk / np.sqrt(np.maximum(time, 1e-9))

    def first(limit: NDArray | float) -> float:
        return float(time[np.argmax(worst > limit)])

    after = {t: float(np.interp(t, time, worst)) for t in (60, 600, HOUR)}
    at_ten = int(np.searchsorted(time, 600))
    return ShortRunLimit(
        noise_time=first(noise),
        repeatability_time=first(gyro.bias_repeatability),
        hundredth_time=first(0.01 * DEG_PER_HOUR),
        after_minute=after[60],
        after_ten_minutes=after[600],
        after_hour=after[HOUR],
        spread=float(np.abs(np.diff(neglected[:, at_ten]))[0]),
    )


def _mean_change(gyro: experiment.CoilBias, network: ThermalNetwork, time: NDArray, start: float) -> NDArray:
    """Mean of the bias from the power on to each time, less the bias at the power on."""
    from scipy.integrate import cumulative_simpson

    bias = gyro.truth(network.nodes, *network.solve(time, soak(start)))
    change = cumulative_simpson(bias - bias[0], x=time, initial=0.0)
    return change / np.where(time > 0, time, 1.0)
