"""What the paper's fifteen parameters leave out, estimated along: one least squares over the same recordings.

The velocity is not set to zero after the turn, so it carries what happened in it. What is observed are the coefficients
of parabolas through the computed velocity in both dwells, all of which are zero for a unit at rest that is known: slope
and bend before the turn; mean, slope and bend after it. Five numbers east, north and up for each test, against

- both matrices and biases of both triads, in the axes of (1) of [1]_: 21 states;
- the attitude at the start of each test: three states each;
- where the accelerometers y and z sit, from the accelerometer x (size effect of one point): six states;
- delays of the other five sensors, from that of gyro x.

What all accelerometers or all sensors have in common of the last two no velocity at rest can show: it is not a state.
Gauss and Newton's method, with derivatives by central differences of the whole processing.

References
----------
.. [1] B. V. Klimkovich, Precise calibration of strapdown INS using low-accuracy turntables, Gyroscopy and Navigation
   (in Russian), vol. 30, no. 4 (119), 2022, pp. 54-70.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks, earth
from fogkit.calibration import velocity_noise
from fogkit.calibration.navigation_based import plausibility
from fogkit.calibration.navigation_based.compensation import GAUGE, Compensation
from fogkit.calibration.navigation_based.recordings import Recording, checked_plan, recordings_of
from fogkit.calibration.velocity_noise import SensorNoise, Steps
from fogkit.estimation.leastsquares import NUMERIC_RANK_TOLERANCE, linear
from fogkit.estimation.solution import Solution
from fogkit.navigation import State, integrate_arrays
from fogkit.rotation import dcm_from_rotvec, orthonormalise
from fogkit.stand.turn_tests import AXES, TurnTest
from fogkit.units import DEG

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

TRIADS = (
    *(f"m_a_{i + 1}{j + 1}" for i in range(3) for j in range(3) if (i, j) not in GAUGE),
    *(f"m_g_{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)),
    *(f"b_a_{i}" for i in (1, 2, 3)),
    *(f"b_g_{i}" for i in (1, 2, 3)),
)
"""Errors of matrices and biases: what compensated readings have too much, as in (13); 21 states."""

SIZES = tuple(f"centre_{sensor}_{axis}" for sensor in "yz" for axis in AXES)
"""Centres of accelerometers y and z from that of accelerometer x, body axes, m."""

DELAYS = ("delay_gyro_y", "delay_gyro_z", "delay_accel_x", "delay_accel_y", "delay_accel_z")
"""Delays from that of gyro x, s."""

TURNS = ("start_east", "start_north", "start_up")
"""Rotation by which the true attitude at the start of a test is turned from the one that is given, rad."""

PRIOR = {"b_g": 1e-5, "start": 1 * DEG, "centre": 0.2, "delay": 5e-3}
"""Default standard deviations of what is known beforehand, by the beginning of the name, rad/s, rad, m, s."""

_STEP = {"m": 1e-6, "b": 1e-6, "start": 1e-5, "centre": 1e-3, "delay": 1e-5}  # of central differences
_SETTLED = 1e-2  # correction in standard deviations that changes no conclusion


@dataclass(frozen=True, kw_only=True, eq=False)
class BatchCalibration:
    """Result of `estimate`.

    Attributes
    ----------
    compensation : Compensation
        Matrices and biases.
    states : dict of str to float
        All states, in the order of the solution: errors of the compensation at the start `TRIADS`, then the other ones.
    solution : Solution
        Last iteration: its covariance is that of the states, its chi-square tests them all; its estimates are the last
        corrections. `Solution.unobservable` names what rests on priors alone.
    iterations : int
        How many there were.
    """

    compensation: Compensation
    states: dict[str, float]
    solution: Solution
    iterations: int

    def to_frame(self) -> "DataFrame":
        """Table with one row for each state: value and standard deviation, SI."""
        import pandas as pd

        columns = {"value": list(self.states.values()), "standard_deviation": self.solution.standard_deviation}
        return pd.DataFrame(columns, index=pd.Index(self.states, name="state"))


def state_names(plan: Sequence[TurnTest], groups: Sequence[str] = ("start", "centre", "delay")) -> tuple[str, ...]:
    """Names of the states of a plan: `TRIADS`, then those of the groups, starts by label of the test."""
    for group in groups:
        checks.option("groups", group, ("start", "centre", "delay"))
    starts = tuple(f"{turn}[{test.label}]" for test in checked_plan(plan) for turn in TURNS)
    return (
        *TRIADS,
        *(starts if "start" in groups else ()),
        *(SIZES if "centre" in groups else ()),
        *(DELAYS if "delay" in groups else ()),
    )


def estimate(
    recordings: Sequence["DataFrame"],
    plan: Sequence[TurnTest],
    latitude: float,
    noise: SensorNoise,
    *,
    altitude: float = 0.0,
    start: Compensation | None = None,
    initial_attitude: ArrayLike | None = None,
    groups: Sequence[str] = ("start", "centre", "delay"),
    prior: Mapping[str, float] | None = None,
    iterations: int = 10,
) -> BatchCalibration:
    """All states from recordings of dwell, turn, dwell.

    Parameters
    ----------
    recordings : sequence of DataFrame
        Raw increments of each test, as for `fogkit.calibration.navigation_based.calibrate`.
    plan : sequence of TurnTest
        The tests as commanded.
    latitude : float
        Geodetic latitude, rad.
    noise : SensorNoise
        Random errors of the sensors, from which the weights follow; level and vertical velocities need some.
    altitude : float, optional
        Height above the ellipsoid, m. Gravity is the normal one.
    start : Compensation, optional
        Where to begin, as from `calibrate`; unit matrices and no biases by default.
    initial_attitude : array_like, shape (tests, 3, 3), optional
        Attitudes at the start as far as known; the plan's by default.
    groups : sequence of str, optional
        Which of the states beyond the triads take part: any of "start", "centre", "delay". The others are taken as
        zero.
    prior : mapping of str to float, optional
        Standard deviations about 0 of single states, or of groups by the beginning of their names, in place of
        `PRIOR`; those of `TRIADS` are of the errors of `start`.
    iterations : int, optional
        Largest number of iterations.

    Returns
    -------
    BatchCalibration
        States, compensation and covariance.

    Raises
    ------
    ValueError
        If recordings are not those of the plan, as `plausibility` says, a prior belongs to no state, or
        states are open even with priors.
    RuntimeError
        If the iteration does not converge.
    """
    plan = checked_plan(plan)
    checks.instance("noise", noise, SensorNoise)
    latitude = float(earth.checked_latitude(latitude, "latitude", earth.POLE_MARGIN))
    start = Compensation() if start is None else checks.instance("start", start, Compensation)
    names = state_names(plan, groups)
    deviations = _priors(names, prior or {})
    attitudes = np.stack([test.C_b_n for test in plan]) if initial_attitude is None else initial_attitude
    attitudes = orthonormalise(checks.finite_array("initial_attitude", attitudes, shape=(len(plan), 3, 3)))
    place = {"lat": latitude, "alt": checks.finite("altitude", altitude, "m")}
    prepared = recordings_of(recordings, plan)
    plausibility.check(prepared, start, float(earth.normal_gravity(latitude, place["alt"])))
    tests = [
        _Test.of(recording, attitude, start, place, noise)
        for recording, attitude in zip(prepared, attitudes, strict=True)
    ]
    states = np.zeros(len(names))
    for number in range(1, checks.integer("iterations", iterations, minimum=1) + 1):
        solution = _solved(tests, names, states, deviations)
        solution.raise_if_unobservable("the plan", priors_help=True)
        states = states + solution.estimate
        if np.abs(solution.estimate / solution.standard_deviation).max() < _SETTLED:
            found = dict(zip(names, states.tolist(), strict=True))
            compensation = start.corrected({name: found[name] for name in TRIADS})
            return BatchCalibration(compensation=compensation, states=found, solution=solution, iterations=number)
    worst = names[int(np.argmax(np.abs(solution.estimate / solution.standard_deviation)))]
    raise RuntimeError(
        f"no convergence in {iterations} `iterations`: the last correction of `{worst}` was "
        f"{solution[worst]:.3g}. Give a better `start`, as from `calibrate`, or larger priors."
    )


@dataclass(frozen=True, eq=False)
class _Test:
    """One recording, and what is observed of it."""

    label: str
    dt: float
    gyro: Array  # raw increments, and their first and second changes for delays: shape (3, n, 3)
    accel: Array
    attitude: Array
    start: Compensation
    place: dict[str, float]
    weights: Array  # of the velocities, shape (5, n + 1)
    covariance: Array

    @classmethod
    def of(
        cls, recording: Recording, attitude: Array, start: Compensation, place: dict[str, float], noise: SensorNoise
    ) -> "_Test":
        steps = Steps.of(recording.test, recording.dt)
        weights = np.zeros((5, steps.count + 1))
        for rows, kept, (first, last) in (
            (slice(0, 2), slice(1, 3), (1, steps.turn_begin + 1)),
            (slice(2, 5), slice(0, 3), (steps.turn_end + 1, steps.count + 1)),
        ):
            time = (np.arange(first, last) - (first + last - 1) / 2) * recording.dt
            weights[rows, first:last] = np.linalg.pinv(np.vander(time, 3, increasing=True))[kept]
        gravity = float(earth.normal_gravity(place["lat"], place["alt"]))
        covariance = velocity_noise.covariance(weights, steps, noise, gravity)
        return cls(
            recording.test.label,
            recording.dt,
            _with_changes(recording.gyro, recording.dt),
            _with_changes(recording.accel, recording.dt),
            attitude,
            start,
            place,
            weights,
            covariance,
        )

    def observed(self, states: Mapping[str, Array]) -> Array:
        """Coefficients for runs with states of shape (runs,) each: shape (runs, 15)."""
        dtheta, dv = self._compensated(states)
        turned = np.stack([states[f"{turn}[{self.label}]"] for turn in TURNS], axis=-1)
        velocity = integrate_arrays(
            dtheta,
            dv,
            self.dt,
            State(C_b_n=dcm_from_rotvec(turned) @ self.attitude, **self.place),
            position_fixed=True,
            keep_attitude=False,
        ).v_eb_n
        return np.einsum("mk,rki->rmi", self.weights, velocity).reshape(len(velocity), -1)

    def _compensated(self, states: Mapping[str, Array]) -> tuple[Array, Array]:
        """Increments without delays, errors of the triads and size effect, shape (runs, n, 3) each."""

        def advanced(raw: Array, kind: str) -> Array:  # to second order in the delay, which is short beside a ramp
            delay = np.stack([states[f"delay_{kind}_{axis}"] for axis in AXES], axis=-1)[:, None, :]
            return raw[0] + delay * raw[1] + delay**2 / 2 * raw[2]

        def matrix(kind: str, base: Array) -> Array:
            errors = [[states[f"m_{kind}_{i}{j}"] for j in (1, 2, 3)] for i in (1, 2, 3)]
            return base - np.moveaxis(np.array(errors), -1, 0)

        def bias(kind: str, base: Array) -> Array:
            return (base - np.stack([states[f"b_{kind}_{i}"] for i in (1, 2, 3)], axis=-1))[:, None, :] * self.dt

        parts = self.start
        dtheta = advanced(self.gyro, "gyro") @ np.swapaxes(matrix("g", parts.gyro_matrix), -1, -2)
        dtheta += bias("g", parts.gyro_bias)
        M = matrix("a", parts.accelerometer_matrix)
        read = advanced(self.accel, "accel")
        if any(states[name].any() for name in SIZES):
            rows = np.linalg.inv(M)  # what each accelerometer reads of a force
            change = np.gradient(dtheta, axis=1) / self.dt  # of the rate in a step
            square = np.einsum("rki,rki->rk", dtheta, dtheta)
            for sensor, letter in enumerate("yz", start=1):
                centre, row = np.stack([states[f"centre_{letter}_{axis}"] for axis in AXES], axis=-1), rows[:, sensor]
                # row of change x centre + dtheta x (dtheta x centre) / dt, without a cross product in every step
                turning = (change @ np.cross(centre, row)[..., None])[..., 0]
                along = dtheta @ np.stack([row, centre], axis=-1)
                inwards = along[..., 0] * along[..., 1] - square * (row * centre).sum(axis=-1)[:, None]
                read[..., sensor] -= turning + inwards / self.dt
        dv = read @ np.swapaxes(M, -1, -2)
        dv += bias("a", parts.accelerometer_bias)
        return dtheta, dv


def _solved(tests: Sequence[_Test], names: tuple[str, ...], states: Array, deviations: Array) -> Solution:
    """Correction of the states by one step of Gauss and Newton's method."""
    from scipy.linalg import block_diag  # loaded where used

    steps = np.array([_by_kind(_STEP, name) for name in names])
    values, rows = [], []
    for test in tests:
        own = [i for i, name in enumerate(names) if "[" not in name or name.endswith(f"[{test.label}]")]
        runs = np.repeat(states[None], 2 * len(own) + 1, axis=0)
        runs[np.arange(len(own)), own] += steps[own]
        runs[len(own) + np.arange(len(own)), own] -= steps[own]
        columns = {name: np.zeros(len(runs)) for name in _all_states(test)} | dict(zip(names, runs.T, strict=True))
        observed = test.observed(columns)
        jacobian = np.zeros((observed.shape[1], len(names)))
        more, less, (now,) = np.split(observed, [len(own), 2 * len(own)])
        jacobian[:, own] = ((more - less) / (2 * steps[own])[:, None]).T
        values.append(now)
        rows.append(jacobian)
    return linear(
        np.concatenate(rows),
        -np.concatenate(values),
        covariance=block_diag(*(test.covariance for test in tests)),
        prior_mean=np.where(np.isfinite(deviations), -states, 0.0),
        prior_standard_deviation=deviations,
        names=names,
        rank_tolerance=NUMERIC_RANK_TOLERANCE,
    )


def _all_states(test: _Test) -> tuple[str, ...]:
    """All names that the processing of a test looks up, states or not."""
    matrices = [f"m_{kind}_{i}{j}" for kind in "ag" for i in (1, 2, 3) for j in (1, 2, 3)]
    turns = [f"{turn}[{test.label}]" for turn in TURNS]
    return (*matrices, *TRIADS, *turns, *SIZES, "delay_gyro_x", *DELAYS)


def _with_changes(raw: Array, dt: float) -> Array:
    """Increments with their first and second derivatives by central differences, shape (3, n, 3)."""
    first = np.gradient(raw, dt, axis=0)
    second = np.zeros_like(raw)
    second[1:-1] = (raw[2:] - 2 * raw[1:-1] + raw[:-2]) / dt**2
    return np.stack([raw, first, second])


def _priors(names: tuple[str, ...], given: Mapping[str, float]) -> Array:
    """Standard deviations of what is known of each state, infinite where nothing is."""
    known = dict(PRIOR)
    for key, value in given.items():
        if not any(name == key or name.startswith(key) for name in names):
            raise ValueError(f"`prior` must be of states or groups of them, got {key!r}; states are {', '.join(names)}")
        known[key] = value if value == np.inf else checks.positive(f"prior[{key!r}]", value)
    return np.array([_by_kind(known, name, np.inf) for name in names])


def _by_kind(table: Mapping[str, float], name: str, default: float = np.nan) -> float:
    """Entry of the longest key with which a name begins."""
    keys = [key for key in table if name.startswith(key)]
    return table[max(keys, key=len)] if keys else default
