"""Temperature tests in simulation: what sensors and thermometers read while the chamber does its programme.

Two places for one gyro: alone in the chamber, where air and holder warm it evenly, and in a unit, where the electronics
stand on one side of it and other instruments warm the housing. All numbers of the networks are of typical size, chosen
here, and taken from no paper.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.optics.coil import Coil
from fogkit.thermal.network import CHAMBER, Profile, ThermalNetwork, ramp, sine, soak, steps
from fogkit.thermal.rates import RATE, TEMPERATURE, reduce
from fogkit.units import DEG_PER_HOUR, DEG_PER_SQRT_HOUR, HOUR, MICRO_G, MINUTE, PPM

if TYPE_CHECKING:
    from pandas import DataFrame

_GYRO_CAPACITIES = {"source": 15.0, "coil_top": 25.0, "coil_bottom": 25.0, "coil_core": 70.0, "electronics": 100.0}
_COIL_CONDUCTANCES = {("coil_top", "coil_core"): 0.08, ("coil_bottom", "coil_core"): 0.08}
_GYRO_HEAT = {"source": 0.6, "electronics": 5.0}

WINDOW = 120.0
"""Window of the rates of a campaign, s: a tenth of the time constants of the coil, and 12 samples."""

POINTS = ("source", "coil_top", "coil_bottom", "electronics", "accelerometer", "housing")
"""Measuring points in the unit of `in_unit`; core of the coil, air and base have none."""


@cache
def alone(asymmetry: float = 0.0) -> ThermalNetwork:
    """Network of a gyro tested alone: both faces of the coil feel the chamber alike, the electronics stand apart.

    Parameters
    ----------
    asymmetry : float, optional
        Difference of the conductances between the two faces and the chamber, over their mean.
    """
    half = checks.in_open_interval("asymmetry", asymmetry, -2, 2) / 2
    return ThermalNetwork(
        capacities=_GYRO_CAPACITIES,
        conductances=_COIL_CONDUCTANCES
        | {("coil_top", CHAMBER): 0.1 * (1 + half), ("coil_bottom", CHAMBER): 0.1 * (1 - half)}
        | {("source", CHAMBER): 0.05, ("electronics", CHAMBER): 0.4},
        heat=_GYRO_HEAT,
    )


@cache
def in_unit() -> ThermalNetwork:
    """Network of the same gyro in a unit: coil between housing and a heavy base, electronics beside its lower face."""
    return ThermalNetwork(
        capacities=_GYRO_CAPACITIES | {"accelerometer": 80.0, "housing": 500.0, "base": 1500.0, "air": 30.0},
        conductances=_COIL_CONDUCTANCES
        | {("coil_top", "housing"): 0.08, ("coil_bottom", "base"): 0.06, ("coil_bottom", "electronics"): 0.04}
        | {("source", "housing"): 0.05, ("electronics", "base"): 0.3, ("accelerometer", "base"): 0.08}
        | {("coil_top", "air"): 0.02, ("source", "air"): 0.02, ("electronics", "air"): 0.1}
        | {("accelerometer", "air"): 0.04, ("housing", "air"): 0.3, ("housing", "base"): 0.4}
        | {("housing", CHAMBER): 0.8, ("base", CHAMBER): 0.5},
        heat=_GYRO_HEAT | {"accelerometer": 0.8, "base": 2.0},
    )


def shupe_coefficient(
    coil: Coil, *, share: float = 1.0, thermo_optic: float = 1.0e-5, expansion: float = 5.5e-7
) -> float:
    """Rate that the gyro reads per difference of the warming rates of the two ends of its coil, rad/s per K/s.

    Parameters
    ----------
    coil : Coil
        Length, diameter and index of the fibre.
    share : float, optional
        What the winding leaves of the effect: 1 if either half of the fibre lies at one face of the coil (no
        compensation), of the order of 1e-3 for a quadrupolar winding.
    thermo_optic : float, optional
        dn/dT of the fibre, 1/K.
    expansion : float, optional
        Coefficient of thermal expansion of the fibre, 1/K.

    Returns
    -------
    float
        ``share * n L / (4 D) * (dn/dT + n alpha)``: the effect of `share` on the rate of one end; the other end has
        its negative.

    Notes
    -----
    The integral ``Omega = n / (D L) (dn/dT + n alpha) int_0^L (L - 2 l) dT/dt(l) dl`` [1]_ weighs a place in the fibre
    by its distance from the middle. If the temperature is ``w(l) T_top + (1 - w(l)) T_bottom``, the coefficients of
    the two rates are opposite for any w, because the integral of ``L - 2 l`` is zero: a coil that warms evenly reads
    nothing.

    References
    ----------
    .. [1] D. M. Shupe, "Thermally induced nonreciprocity in the fiber-optic interferometer", Appl. Opt. 19, 654 (1980).
    """
    checks.instance("coil", coil, Coil)
    share = checks.finite("share", share)
    warming = checks.finite("thermo_optic", thermo_optic, "1/K") + coil.index * checks.finite("expansion", expansion)
    return share * coil.index * coil.length / (4 * coil.diameter) * warming


@dataclass(frozen=True, kw_only=True)
class CoilBias:
    """Bias of a gyro as a linear function of temperatures and rates of temperature, with what no temperature explains.

    Parameters
    ----------
    constant : float, optional
        Bias with all points at the reference temperature, rad/s.
    temperature : mapping of str to float, optional
        Coefficient of the temperature of each point, rad/s per K.
    rate : mapping of str to float, optional
        Coefficient of the rate of each point, rad/s per K/s.
    reference : float, optional
        Reference temperature, degC.
    angle_random_walk : float, optional
        White noise, rad/sqrt(s).
    bias_repeatability : float, optional
        Standard deviation of the bias from run to run, rad/s.
    """

    constant: float = 0.0
    temperature: Mapping[str, float] = field(default_factory=dict)
    rate: Mapping[str, float] = field(default_factory=dict)
    reference: float = 25.0
    angle_random_walk: float = 0.0
    bias_repeatability: float = 0.0

    def __post_init__(self) -> None:
        checks.finite("constant", self.constant, "rad/s")
        checks.finite("reference", self.reference, "degC")
        for name in ("temperature", "rate"):
            for point, value in getattr(self, name).items():
                checks.finite(f"{name}[{point!r}]", value)
        checks.non_negative("angle_random_walk", self.angle_random_walk, "rad/sqrt(s)")
        checks.non_negative("bias_repeatability", self.bias_repeatability, "rad/s")

    def truth(self, nodes: Sequence[str], temperatures: ArrayLike, rates: ArrayLike) -> NDArray[np.float64]:
        """Bias without noise, rad/s, shape (...,), from temperatures and rates of the nodes, shape (..., n)."""
        for point in (*self.temperature, *self.rate):
            checks.option("nodes", point, nodes, fix="The bias depends on a point that the network does not have")
        a = np.array([self.temperature.get(node, 0.0) for node in nodes])
        b = np.array([self.rate.get(node, 0.0) for node in nodes])
        return self.constant + (np.asarray(temperatures) - self.reference) @ a + np.asarray(rates) @ b

    def noise(self, size: int, interval: float, rng: np.random.Generator) -> NDArray[np.float64]:
        """Noise of one run, rad/s, shape (size,): an offset, and white of ``angle_random_walk / sqrt(interval)``."""
        white = self.angle_random_walk / np.sqrt(interval) * rng.standard_normal(size)
        return self.bias_repeatability * rng.standard_normal() + white


COIL = Coil(length=1000.0, diameter=0.1, wavelength=1.55e-6)
"""A coil of 1 km and 10 cm."""


def example_gyro(
    *, angle_random_walk: float = 0.001 * DEG_PER_SQRT_HOUR, bias_repeatability: float = 0.002 * DEG_PER_HOUR
) -> CoilBias:
    """A gyro whose bias depends on the two faces of its coil and on its electronics: the truth of tests and book.

    The faces act equally by temperature (the mean of the coil) and, by the winding's share of 0.4 % of Shupe's effect,
    oppositely by rate; the electronics by temperature, and by rate through their drift while they warm.
    """
    shupe = shupe_coefficient(COIL, share=0.004)
    per_kelvin = 0.01 * DEG_PER_HOUR
    return CoilBias(
        constant=0.3 * DEG_PER_HOUR,
        temperature={"coil_top": per_kelvin, "coil_bottom": per_kelvin, "electronics": -per_kelvin},
        rate={"coil_top": shupe, "coil_bottom": -shupe, "electronics": 10 * per_kelvin * MINUTE},
        angle_random_walk=angle_random_walk,
        bias_repeatability=bias_repeatability,
    )


@dataclass(frozen=True, kw_only=True)
class PolynomialEffect:
    """A quantity that is a polynomial of one temperature: bias of an accelerometer, scale factor of a gyro.

    Parameters
    ----------
    point : str
        The node whose temperature counts.
    coefficients : sequence of float
        Of the powers 0, 1, 2, ... of the temperature less the reference, in the quantity's unit per K**power.
    reference : float, optional
        Reference temperature, degC.
    noise : float, optional
        Standard deviation of the white noise of one sample, in the quantity's unit.
    """

    point: str
    coefficients: Sequence[float]
    reference: float = 25.0
    noise: float = 0.0

    def __post_init__(self) -> None:
        checks.instance("point", self.point, str)
        checks.finite_array("coefficients", self.coefficients, ndim=1)
        checks.finite("reference", self.reference, "degC")
        checks.non_negative("noise", self.noise)

    def truth(self, nodes: Sequence[str], temperatures: ArrayLike, rates: ArrayLike) -> NDArray[np.float64]:
        """The quantity without noise, shape (...,); rates do not count."""
        checks.option("point", self.point, nodes)
        warmth = np.asarray(temperatures)[..., list(nodes).index(self.point)] - self.reference
        return np.polynomial.polynomial.polyval(warmth, np.asarray(self.coefficients, float))

    def noise_of(self, size: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Noise of one run, shape (size,)."""
        return self.noise * rng.standard_normal(size)


def example_accelerometer() -> PolynomialEffect:
    """Bias of an accelerometer, m/s^2, that is a cubic of its temperature."""
    coefficients = np.array([500.0, 25.0, -0.15, 0.004]) * MICRO_G
    return PolynomialEffect(point="accelerometer", coefficients=tuple(coefficients.tolist()), noise=20 * MICRO_G)


def example_scale_factor() -> PolynomialEffect:
    """Scale factor of a gyro, reading over rate, that is linear in the temperature of its source."""
    return PolynomialEffect(point="source", coefficients=(1.0, 8 * PPM), noise=20 * PPM)


@dataclass(frozen=True, kw_only=True)
class Thermometer:
    """What is between a temperature and its reading.

    Parameters
    ----------
    noise : float, optional
        Standard deviation of the white noise of a sample, K.
    resolution : float, optional
        Step of the reading, K; 0 for none.
    """

    noise: float = 0.01
    resolution: float = 0.005

    def __post_init__(self) -> None:
        checks.non_negative("noise", self.noise, "K")
        checks.non_negative("resolution", self.resolution, "K")

    @property
    def deviation(self) -> float:
        """Standard deviation of the error of a sample, K: noise, and the rounding of the reading."""
        return float(np.hypot(self.noise, self.resolution / np.sqrt(12)))

    def read(self, temperatures: NDArray, rng: np.random.Generator) -> NDArray[np.float64]:
        """Readings, degC."""
        noisy = temperatures + self.noise * rng.standard_normal(temperatures.shape)
        return np.round(noisy / self.resolution) * self.resolution if self.resolution else noisy


def simulate(
    network: ThermalNetwork,
    profile: Profile,
    duration: float,
    *,
    effects: Mapping[str, CoilBias | PolynomialEffect] | None = None,
    powered: bool = False,
    interval: float = 10.0,
    thermometer: Thermometer | None = None,
    rng: np.random.Generator | None = None,
    truth: bool = False,
) -> DataFrame:
    """One run of a temperature test.

    Parameters
    ----------
    network : ThermalNetwork
        What is in the chamber.
    profile : Profile
        What the chamber does; the run begins at time 0.
    duration : float
        Duration of the run, s.
    effects : mapping, optional
        What is read besides temperatures, by column; without it ``{"bias": example_gyro()}``.
    powered : bool, optional
        Whether the power was on long before, so that the run begins in the steady state. Otherwise it begins with all
        parts at the temperature of the chamber, and the power comes on at time 0.
    interval : float, optional
        Sampling interval, s.
    thermometer : Thermometer, optional
        The thermometers; all alike.
    rng : numpy.random.Generator, optional
        Source of the noise. Without it nothing has noise or steps, and temperatures are true.
    truth : bool, optional
        Whether to add columns ``true_*`` with temperatures, rates and effects as they are.

    Returns
    -------
    pandas.DataFrame
        Index ``time``, s; ``temperature_<node>`` and ``temperature_chamber``, degC, and the effects.
    """
    import pandas as pd

    checks.instance("network", network, ThermalNetwork)
    interval = checks.positive("interval", interval, "s")
    effects = {"bias": example_gyro()} if effects is None else effects
    checks.instance("profile", profile, Profile)
    time = np.arange(int(checks.positive("duration", duration, "s") / interval + 1e-9) + 1) * interval
    true, rates = _solved(network, profile, time.size, interval, powered)
    read, true_effects = true, {name: e.truth(network.nodes, true, rates) for name, e in effects.items()}
    noise = dict.fromkeys(effects, 0.0)
    if rng is not None:
        rng = checks.generator("rng", rng)
        read = (thermometer or Thermometer()).read(true, rng)
        noise = {name: _noise(effect, time.size, interval, rng) for name, effect in effects.items()}
    columns = {TEMPERATURE + node: read[:, i] for i, node in enumerate(network.nodes)}
    columns[TEMPERATURE + CHAMBER] = profile.at(time)
    columns |= {name: value + noise[name] for name, value in true_effects.items()}
    if truth:
        columns |= {f"true_{TEMPERATURE}{node}": true[:, i] for i, node in enumerate(network.nodes)}
        columns |= {f"true_{RATE}{node}": rates[:, i] for i, node in enumerate(network.nodes)}
        columns |= {f"true_{name}": value for name, value in true_effects.items()}
    return pd.DataFrame(columns, index=pd.Index(time, name="time"))


@dataclass(frozen=True, kw_only=True)
class Run:
    """One run of a schedule: what the chamber does, for how long, and whether the power has been on since long before.

    Parameters
    ----------
    name : str
        What the operator calls it.
    profile : Profile
        Temperature of the chamber.
    duration : float
        Duration, s.
    powered : bool
        False: all parts have the temperature of the chamber when the power comes on at time 0.
    """

    name: str
    profile: Profile
    duration: float
    powered: bool

    def __post_init__(self) -> None:
        checks.instance("profile", self.profile, Profile)
        checks.positive("duration", self.duration, "s")


def start_ups(temperatures: Sequence[float] = (-40, -20, 0, 20, 40, 60), duration: float = 2 * HOUR) -> list[Run]:
    """Schedule of starts in a chamber held at each of the temperatures, degC."""
    return [
        Run(name=f"start at {value:g} degC", profile=soak(value), duration=duration, powered=False)
        for value in temperatures
    ]


def warm_runs(duration: float = 5 * HOUR) -> list[Run]:
    """Schedule of four runs after the warm-up: soak temperatures with fast ramps, a swing, and a slow ramp each way."""
    profiles = {
        "soaks with 3 K/min between": steps([20, 60, -40, 20], hold=1.5 * HOUR, rate=3 / MINUTE),
        "swing of 20 K in an hour": sine(20, 20, period=HOUR, duration=duration),
        "ramp up, 1 K/min": ramp(-40, 60, rate=1 / MINUTE, begin=1200),
        "ramp down, 1 K/min": ramp(60, -40, rate=1 / MINUTE, begin=1200),
    }
    return [Run(name=name, profile=p, duration=duration, powered=True) for name, p in profiles.items()]


def schedule_table(runs: Iterable[Run]) -> DataFrame:
    """Schedule as the operator gets it: chamber at the start, its range, its fastest ramp, power, duration."""
    import pandas as pd

    rows = {}
    for run in runs:
        t, value = np.array(run.profile.times), np.array(run.profile.temperatures)
        t, value = t[t <= run.duration], value[t <= run.duration]
        gaps = np.diff(t) > 0
        rates = np.abs(np.diff(value)[gaps] / np.diff(t)[gaps])
        rows[run.name] = {
            "chamber at start, degC": float(run.profile.at(0.0)),
            "lowest, degC": float(value.min()),
            "highest, degC": float(value.max()),
            "fastest ramp, K/min": float(rates.max(initial=0.0)) * MINUTE,
            "power": "on before" if run.powered else "on at the start",
            "duration, h": run.duration / HOUR,
        }
    return pd.DataFrame(rows).T.infer_objects().rename_axis("run")


def campaign(
    network: ThermalNetwork, runs: Iterable[Run], *, window: float | None = WINDOW, **options: object
) -> list[DataFrame]:
    """Tables of all runs of a schedule.

    Parameters
    ----------
    network : ThermalNetwork
        What is in the chamber.
    runs : iterable of Run
        The schedule.
    window : float, optional
        Window of `fogkit.thermal.rates.reduce`, s; None for the samples as they come.
    **options
        Of `simulate`: `effects`, `interval`, `thermometer`, `rng`, `truth`.

    Returns
    -------
    list of pandas.DataFrame
        One table per run.
    """
    tables = [simulate(network, run.profile, run.duration, powered=run.powered, **options) for run in runs]
    return tables if window is None else [reduce(table, window) for table in tables]


@lru_cache(maxsize=64)
def _solved(network: ThermalNetwork, profile: Profile, size: int, interval: float, powered: bool) -> tuple:
    """Temperatures and rates of a run; kept, since many runs differ in their noise only."""
    start = network.steady_state(float(profile.at(0.0))) if powered else None
    solution = network.solve(np.arange(size) * interval, profile, start=start)
    for array in solution:
        array.setflags(write=False)
    return solution


def _noise(effect: CoilBias | PolynomialEffect, size: int, interval: float, rng: np.random.Generator) -> NDArray:
    """Noise of one run."""
    if isinstance(effect, CoilBias):
        return effect.noise(size, interval, rng)
    return effect.noise_of(size, rng)
