"""A thermal network of a gyro or a unit in a temperature chamber, solved exactly for piecewise linear chamber profiles.

Nodes ``i`` of heat capacity ``C_i`` exchange heat through conductances with one another and with the chamber, whose
temperature is prescribed:

    C_i dT_i/dt = sum_j G_ij (T_j - T_i) + g_i (T_chamber - T_i) + P_i .

Where the chamber's temperature is linear in time, the solution is a line plus decaying exponentials, so no time step
enters: temperatures and their rates are exact at any set of times.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks

CHAMBER = "chamber"
"""Name of the boundary in the conductances of a network."""

_SINE_CORNERS = 48  # per period: the polygon departs from the sine by (pi / 48)**2 / 2 = 0.2 % of the amplitude


@dataclass(frozen=True, kw_only=True)
class Profile:
    """Temperature of the chamber: straight lines between given points, held before the first and after the last.

    Parameters
    ----------
    times : sequence of float
        Times of the points, s, not decreasing. A time given twice is a jump; there the later value holds.
    temperatures : sequence of float
        Temperatures at those times, degC.

    Examples
    --------
    >>> profile = ramp(20.0, 50.0, rate=1 / 60)
    >>> profile.times
    (0.0, 1800.0)
    >>> float(profile.at(900.0))
    35.0
    """

    times: Sequence[float]
    temperatures: Sequence[float]

    def __post_init__(self) -> None:
        times = checks.finite_array("times", self.times, ndim=1)
        temperatures = checks.finite_array("temperatures", self.temperatures, ndim=1)
        if times.size != temperatures.size:
            raise ValueError(f"`temperatures` must be as many as `times`, got {temperatures.size} and {times.size}")
        if (np.diff(times) < 0).any():
            at = int(np.argmax(np.diff(times) < 0)) + 1
            raise ValueError(f"`times` must not decrease, got {times[at]} s after {times[at - 1]} s at index {at}")
        object.__setattr__(self, "times", tuple(times.tolist()))
        object.__setattr__(self, "temperatures", tuple(temperatures.tolist()))

    def at(self, time: ArrayLike) -> NDArray[np.float64]:
        """Temperature at given times, degC; at a jump the value after it."""
        return self.line(time)[0]

    def line(self, time: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Temperature, degC, and its rate just after given times, K/s."""
        time = np.asarray(time, float)
        t, value = np.array(self.times), np.array(self.temperatures)
        after = np.searchsorted(t, time, side="right")  # index of the first point later than the time
        left, right = np.clip(after - 1, 0, None), np.clip(after, None, t.size - 1)
        inside = (after > 0) & (after < t.size)
        span = np.where(inside, t[right] - t[left], 1.0)
        slope = np.where(inside, (value[right] - value[left]) / span, 0.0)
        return value[left] + slope * np.where(inside, time - t[left], 0.0), slope


def soak(temperature: float) -> Profile:
    """Chamber held at one temperature, degC."""
    return Profile(times=(0.0,), temperatures=(temperature,))


def ramp(start: float, end: float, *, rate: float, begin: float = 0.0) -> Profile:
    """Chamber from one temperature to another, degC, at `rate` K/s (its size), beginning at the time `begin`, s."""
    rate = checks.positive("rate", rate, "K/s")
    return Profile(times=(begin, begin + abs(end - start) / rate), temperatures=(start, end))


def steps(temperatures: Sequence[float], *, hold: float, rate: float = np.inf) -> Profile:
    """Soak temperatures one after another, degC, each held for `hold` s, with ramps of `rate` K/s between them.

    An infinite rate, the default, makes jumps.
    """
    temperatures = checks.finite_array("temperatures", temperatures, ndim=1)
    hold = checks.positive("hold", hold, "s")
    if rate != np.inf:
        rate = checks.positive("rate", rate, "K/s")
    times, values, now = [], [], 0.0
    for i, value in enumerate(temperatures):
        now += abs(value - temperatures[i - 1]) / rate if i else 0.0
        times += [now, now + hold]
        values += [value, value]
        now += hold
    return Profile(times=times, temperatures=values)


def sine(mean: float, amplitude: float, *, period: float, duration: float, begin: float = 0.0) -> Profile:
    """Chamber that swings about a mean, degC, from the time `begin` on for `duration` s.

    The programme is a polygon of 48 corners a period, which departs from the sine by 0.2 % of the amplitude.
    """
    period, duration = checks.positive("period", period, "s"), checks.positive("duration", duration, "s")
    corners = int(np.ceil(_SINE_CORNERS * duration / period)) + 1
    time = np.arange(corners) * period / _SINE_CORNERS
    return Profile(times=begin + time, temperatures=mean + amplitude * np.sin(2 * np.pi * time / period))


@dataclass(frozen=True, kw_only=True, eq=False)
class ThermalNetwork:
    """Heat capacities, conductances and self-heating of the nodes of a gyro or unit in a chamber.

    Parameters
    ----------
    capacities : mapping of str to float
        Heat capacity of each node, J/K. The names become the columns ``temperature_<node>``.
    conductances : mapping of (str, str) to float
        Conductance between two nodes, or a node and `CHAMBER`, W/K, each pair once.
    heat : mapping of str to float, optional
        Self-heating of nodes while the power is on, W.

    Raises
    ------
    ValueError
        If a pair names an unknown node or stands twice, or a node has no path to the chamber.

    Examples
    --------
    A body of 100 J/K and 0.5 W/K warms by 4 K under 2 W, with a time constant of 200 s:

    >>> network = ThermalNetwork(capacities={"body": 100}, conductances={("body", "chamber"): 0.5}, heat={"body": 2})
    >>> network.steady_state(20.0), network.time_constants
    (array([24.]), array([200.]))
    """

    capacities: Mapping[str, float]
    conductances: Mapping[tuple[str, str], float]
    heat: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if CHAMBER in self.capacities:
            raise ValueError(f"`capacities` must not name {CHAMBER!r}, whose temperature is prescribed")
        for node, value in self.capacities.items():
            checks.positive(f"capacities[{node!r}]", value, "J/K")
        for node, value in self.heat.items():
            checks.option("heat", node, self.nodes)
            checks.non_negative(f"heat[{node!r}]", value, "W")
        seen = set()
        for pair, value in self.conductances.items():
            for node in pair:
                checks.option(f"conductances[{pair}]", node, (*self.nodes, CHAMBER))
            if frozenset(pair) in seen or len(set(pair)) < 2:
                raise ValueError(f"`conductances` must name each pair of two nodes once, got {pair} again or alone")
            seen.add(frozenset(pair))
            checks.non_negative(f"conductances[{pair}]", value, "W/K")
        lost = set(self.nodes) - self._reached()
        if lost:
            raise ValueError(f"`conductances` must join every node to the chamber, got no path from {sorted(lost)}")

    @property
    def nodes(self) -> tuple[str, ...]:
        """Names of the nodes, in the order of all arrays."""
        return tuple(self.capacities)

    @cached_property
    def conductance_matrix(self) -> NDArray[np.float64]:
        """G of ``C dT/dt = -G T + g T_chamber + P``, W/K, shape (n, n); its row sums are g."""
        G = np.zeros((len(self.nodes),) * 2)
        for pair, value in self.conductances.items():
            at = [self.nodes.index(node) for node in pair if node != CHAMBER]
            G[at, at] += value
            if len(at) == 2:
                G[at, at[::-1]] -= value
        return G

    @property
    def to_chamber(self) -> NDArray[np.float64]:
        """Conductance of each node to the chamber, W/K."""
        pairs = self.conductances
        return np.array([pairs.get((n, CHAMBER), 0.0) + pairs.get((CHAMBER, n), 0.0) for n in self.nodes])

    @property
    def power(self) -> NDArray[np.float64]:
        """Self-heating of each node while the power is on, W."""
        return np.array([float(self.heat.get(node, 0.0)) for node in self.nodes])

    @cached_property
    def _modes(self) -> tuple[NDArray, NDArray, NDArray]:
        """Decay rates, modes, and what takes temperatures to modes: of C^-1/2 G C^-1/2, which is symmetric."""
        root = np.sqrt(np.array(list(self.capacities.values()), float))
        decay, V = np.linalg.eigh(self.conductance_matrix / root / root[:, None])
        return decay, V / root[:, None], V.T * root

    @property
    def time_constants(self) -> NDArray[np.float64]:
        """Time constants of the modes, s, the longest first."""
        return 1 / self._modes[0]

    def steady_state(self, chamber: float, *, powered: bool = True) -> NDArray[np.float64]:
        """Temperatures after a long time in a chamber of constant temperature, degC, shape (n,)."""
        chamber = checks.finite("chamber", chamber, "degC")
        return chamber + np.linalg.solve(self.conductance_matrix, self.power * powered)

    def solve(
        self, time: ArrayLike, profile: Profile, *, switch_on: float = 0.0, start: ArrayLike | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Temperatures and their rates, exact at all times.

        Parameters
        ----------
        time : array_like, shape (m,)
            Times, s, increasing; the first is the start.
        profile : Profile
            Temperature of the chamber.
        switch_on : float, optional
            Time at which the self-heating begins, s.
        start : array_like, shape (n,), optional
            Temperatures at the first time, degC; without it all nodes have the temperature of the chamber.

        Returns
        -------
        temperatures, rates : ndarray, shape (m, n)
            degC and K/s; where the power or the chamber jumps, the rate is the one just after.
        """
        time = checks.finite_array("time", time, ndim=1)
        if (np.diff(time) <= 0).any():
            raise ValueError("`time` must increase, got times that repeat or go back")
        checks.instance("profile", profile, Profile)
        switch_on = checks.finite("switch_on", switch_on, "s")
        state = np.full(len(self.nodes), float(profile.at(time[0])))
        if start is not None:
            state = checks.finite_array("start", start, shape=(len(self.nodes),))
        decay, from_modes, to_modes = self._modes
        capacity = np.array(list(self.capacities.values()), float)
        corners = np.unique([time[0], *(t for t in (*profile.times, switch_on) if time[0] < t < time[-1]), time[-1]])
        temperatures, rates = np.empty((2, time.size, len(self.nodes)))
        for begin, end in zip(corners, [*corners[1:], np.inf], strict=True):
            value, slope = (float(v) for v in profile.line(begin))
            inflow = self.to_chamber * value + self.power * (begin >= switch_on)
            line = np.linalg.solve(self.conductance_matrix, inflow - slope * capacity)
            mode = to_modes @ (state - line)
            here = (time >= begin) & (time < end)
            since = np.append(time[here], min(end, time[-1])) - begin
            decayed = mode * np.exp(-np.outer(since, decay))
            along = line + slope * since[:, None] + decayed @ from_modes.T
            temperatures[here], state = along[:-1], along[-1]
            rates[here] = slope - (decayed * decay)[:-1] @ from_modes.T
        return temperatures, rates

    def heat_from_chamber(self, temperatures: ArrayLike, chamber: ArrayLike) -> NDArray[np.float64]:
        """Heat that flows in from the chamber, W, shape (...,), at temperatures of the nodes, shape (..., n), degC."""
        warmer = np.asarray(chamber, float)[..., None] - np.asarray(temperatures, float)
        return (warmer * self.to_chamber).sum(axis=-1)

    def _reached(self) -> set[str]:
        """Nodes with a path to the chamber."""
        joined = [set(pair) for pair, value in self.conductances.items() if value > 0]
        reached, grown = {CHAMBER}, True
        while grown:
            new = set().union(*(pair for pair in joined if pair & reached)) - reached
            reached, grown = reached | new, bool(new)
        return reached - {CHAMBER}
