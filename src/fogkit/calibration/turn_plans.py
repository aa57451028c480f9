"""Which tests of dwell, turn, dwell are worth their time? Optimal plans under the limits of a table.

A test adds its information, ``H^T inv(R) H`` with the covariance R of `fogkit.calibration.uncertainty`, to that of the
others, whatever their order. `candidates` lists the tests that a table can make, `optimise` exchanges one for another
until no exchange makes the plan better, `continuous_bound` says how good any plan of that many tests could be, and
`compare` puts plans side by side, as they are and at equal time.

**Criteria.** "A" is the mean variance of the fifteen errors, each in units of a size that would be tolerated; without
sizes, biases count in units of gravity, so that all are angles. "D" is the volume of their confidence ellipsoid, for
which sizes do not matter; "condition" the condition number of the measurement matrix of [1]_ with gravity 1, of which
the paper speaks.

**Equivalence.** With equal sensors a plan keeps its worth if a test is turned about the vertical. All candidates
therefore have their turn's axis east, or north for z, as a table with a level outer axis and z along the inner one can
reach them.

References
----------
.. [1] B. V. Klimkovich, Precise calibration of strapdown INS using low-accuracy turntables, Gyroscopy and Navigation
   (in Russian), vol. 30, no. 4 (119), 2022, p. 58.
.. [2] V. V. Fedorov, Theory of optimal experiments, Academic Press, 1972: exchange, and the equivalence theorem of
   Kiefer and Wolfowitz.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.calibration import uncertainty
from fogkit.calibration.navigation_based.turn_model import PARAMETERS
from fogkit.calibration.velocity_noise import SensorNoise
from fogkit.constants import STANDARD_GRAVITY
from fogkit.estimation.solution import Solution
from fogkit.stand.turn_tests import AXES, TurnTest
from fogkit.units import DEG, DEG_PER_SECOND

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

CRITERIA = ("A", "D", "condition")

_GROUPS = {
    "accelerometer_misalignment": [i for i, name in enumerate(PARAMETERS) if name.startswith("m_a")],
    "gyro_misalignment": [i for i, n in enumerate(PARAMETERS) if n.startswith("m_g") and n[-1] != n[-2]],
    "gyro_scale_factor": [i for i, n in enumerate(PARAMETERS) if n.startswith("m_g") and n[-1] == n[-2]],
    "accelerometer_bias": [i for i, name in enumerate(PARAMETERS) if name.startswith("b_a")],
}
_BETTER = 1e-9  # relative gain below which an exchange is rounding
_SAME = 1e-9  # relative difference below which two tests tell the same


@dataclass(frozen=True, kw_only=True)
class TableLimits:
    """What a table and an operator allow.

    Parameters
    ----------
    rate : float, optional
        Largest rate, rad/s.
    acceleration : float, optional
        Angular acceleration of the ramps at both ends of a turn, rad/s^2; infinite by default.
    turns : int, optional
        Most whole turns of a test.
    overhead : float, optional
        Time between two tests, s, for bringing the unit to its next start.
    dwell : float, optional
        Duration of each dwell, s.
    dt : float, optional
        Duration of a step, s, to whole numbers of which turns are rounded up.
    """

    rate: float = 126 * DEG_PER_SECOND
    acceleration: float = np.inf
    turns: int = 5
    overhead: float = 0.0
    dwell: float = 10.0
    dt: float = 0.01

    def __post_init__(self) -> None:
        fix = "Multiply degrees by `fogkit.units.DEG`."
        checks.in_open_interval("rate", self.rate, 0, 100, "rad/s", fix=fix)
        if not self.acceleration > 0:
            raise ValueError(f"`acceleration` must be > 0 rad/s^2, got {self.acceleration}")
        object.__setattr__(self, "turns", checks.integer("turns", self.turns, minimum=0))
        checks.non_negative("overhead", self.overhead, "s")
        checks.positive("dwell", self.dwell, "s")
        checks.positive("dt", self.dt, "s")

    def turn_duration(self, angle: float) -> float:
        """Shortest duration of a turn, s, rounded up to whole steps: by a trapezoid of rates, or a triangle."""
        angle = abs(angle)
        ramp = self.rate / self.acceleration
        time = angle / self.rate + ramp if angle >= self.rate * ramp else 2 * np.sqrt(angle / self.acceleration)
        return float(np.ceil(time / self.dt - 1e-6) * self.dt)

    def duration(self, plan: Sequence[TurnTest]) -> float:
        """Time of a plan with what passes between its tests, s."""
        return sum(test.duration for test in plan) + self.overhead * len(plan)


@dataclass(frozen=True, kw_only=True, eq=False)
class OptimalPlan:
    """Plan that no exchange of one test improves.

    Attributes
    ----------
    plan : tuple of TurnTest
        Tests, labelled from ``"1"``.
    criterion : str
        What was made best.
    values : dict
        All criteria of the plan, as `criteria` gives them.
    prediction : Solution
        Standard deviations and covariance that the plan will give.
    duration : float
        Time, s, with what passes between tests.
    starts, agreeing : int
        Random plans from which the exchange set out, and how many of them led to this value.
    """

    plan: tuple[TurnTest, ...]
    criterion: str
    values: dict[str, float]
    prediction: Solution
    duration: float
    starts: int
    agreeing: int

    def to_frame(self) -> "DataFrame":
        """Table with one row for each error: its predicted standard deviation, SI."""
        import pandas as pd

        index = pd.Index(self.prediction.names, name="parameter")
        return pd.DataFrame({"standard_deviation": self.prediction.standard_deviation}, index=index)


def candidates(
    limits: TableLimits, *, quarters: Sequence[int] | None = None, reverse: bool = True, oblique: bool = False
) -> tuple[TurnTest, ...]:
    """Tests that a table can make: each body axis level, each other axis up or down at first, all angles.

    Parameters
    ----------
    limits : TableLimits
        Rate, ramps, whole turns, dwell.
    quarters : sequence of int, optional
        Angles in quarter turns; by default all from 1 to ``4 * limits.turns + 3``.
    reverse : bool, optional
        Whether turns go both ways.
    oblique : bool, optional
        Whether also tests are listed for which a unit has to be mounted askew: turns about the diagonals between two
        axes, and starts with such a diagonal upright. In them the scale factors of accelerometers enter the level
        slopes; here they count as known. `fogkit.calibration.uncertainty.predict` can estimate them along.

    Returns
    -------
    tuple of TurnTest
        Labelled by axis, upright direction and angle.
    """
    checks.instance("limits", limits, TableLimits)
    quarters = range(1, 4 * limits.turns + 4) if quarters is None else quarters
    quarters = [checks.integer("quarters", quarter, minimum=1) for quarter in quarters]
    directions = _directions(oblique)
    found = []
    for axis_name, axis in directions.items():
        if axis_name.startswith("-"):
            continue  # the same as the other sense about the axis
        for up_name, up in directions.items():
            if abs(axis @ up) > 1e-9:
                continue
            for quarter in quarters:
                for sign in (1, -1) if reverse else (1,):
                    angle = sign * quarter * 90 * DEG
                    found.append(_level_turn(f"{axis_name} {up_name} {angle / DEG:g}", axis, up, angle, limits))
    return tuple(found)


def criteria(
    plan: Sequence[TurnTest], noise: SensorNoise, *, dt: float = 0.01, sizes: ArrayLike | None = None
) -> dict[str, float]:
    """All criteria of a plan; infinite for one that leaves an error open.

    Parameters
    ----------
    plan : sequence of TurnTest
        Tests.
    noise : SensorNoise
        Random errors of the sensors.
    dt : float, optional
        Duration of a step, s.
    sizes : array_like, shape (15,), optional
        What each error is counted in, rad and m/s^2, such as the tolerated ones; 1 rad and gravity by default.

    Returns
    -------
    dict
        ``A``: root mean square of the fifteen standard deviations over their sizes. ``D``: fifteenth root of the
        product of the half-axes of their 1-sigma ellipsoid. ``condition``: of the matrix (14)-(19) with gravity 1.
    """
    information = _informations(plan, noise, dt, sizes).sum(axis=0)
    values = {name: float(_cost(information[None], name)[0]) for name in ("A", "D")}
    matrix = np.concatenate([uncertainty.design(test, gravity=1.0) for test in plan])
    return values | {"condition": float(_condition(matrix.T @ matrix))}


def optimise(
    tests: Sequence[TurnTest],
    count: int,
    noise: SensorNoise,
    *,
    criterion: str = "A",
    sizes: ArrayLike | None = None,
    rng: np.random.Generator,
    starts: int = 10,
    time: float | None = None,
    limits: TableLimits | None = None,
) -> OptimalPlan:
    """Best plan of a number of tests from a list, by exchanges [2]_ from random plans.

    Parameters
    ----------
    tests : sequence of TurnTest
        What may be chosen, each as often as wanted.
    count : int
        Tests of the plan, at least 8: each gives two equations for fifteen errors. With every axis level or upright
        it takes 9.
    noise : SensorNoise
        Random errors of the sensors.
    criterion : {"A", "D", "condition"}, optional
        What is made smallest.
    sizes : array_like, shape (15,), optional
        As in `criteria`.
    rng : numpy.random.Generator
        Source of the plans to begin with.
    starts : int, optional
        How many of them.
    time : float, optional
        Longest duration of the plan, s, by `TableLimits.duration`.
    limits : TableLimits, optional
        For the time between tests and the step `dt`.

    Returns
    -------
    OptimalPlan
        The best plan found. That it is the best of all is not proven; `continuous_bound` tells how much is left.

    Raises
    ------
    ValueError
        If there are too few tests, no plan keeps within `time`, or none determines all errors.
    """
    limits = limits or TableLimits()
    criterion = checks.option("criterion", criterion, CRITERIA)
    count = checks.integer("count", count, minimum=8, fix="Eight tests give 16 equations for 15 errors.")
    rng = checks.generator("rng", rng)
    starts = checks.integer("starts", starts, minimum=1)
    tests, informations = _distinct(tests, noise, limits.dt, criterion, sizes)
    costs = np.array([limits.duration([test]) for test in tests])
    allowed = np.inf if time is None else checks.positive("time", time, "s")
    if costs.min() * count > allowed * (1 + 1e-9):
        raise ValueError(f"`time` must be at least {costs.min() * count:.6g} s for {count} tests, got {allowed:.6g}")
    found = [_exchanged(informations, costs, count, allowed, criterion, rng) for _ in range(starts)]
    value, chosen = min(found, key=lambda pair: pair[0])
    if not np.isfinite(value):
        raise ValueError(f"`tests` must hold {count} that determine all fifteen errors, got none in {starts} starts")
    plan = tuple(replace(tests[i], label=str(n)) for n, i in enumerate(sorted(chosen), start=1))
    return OptimalPlan(
        plan=plan,
        criterion=criterion,
        values=criteria(plan, noise, dt=limits.dt, sizes=sizes),
        prediction=uncertainty.predict(plan, noise, dt=limits.dt),
        duration=limits.duration(plan),
        starts=starts,
        agreeing=sum(other <= value * (1 + 1e-6) for other, _ in found),
    )


def continuous_bound(
    tests: Sequence[TurnTest], noise: SensorNoise, *, dt: float = 0.01, tolerance: float = 1e-4
) -> float:
    """Smallest D that a plan could have per test, were each test's share any fraction and not a whole number.

    Parameters
    ----------
    tests : sequence of TurnTest
        What may be chosen.
    noise : SensorNoise
        Random errors of the sensors.
    dt : float, optional
        Duration of a step, s.
    tolerance : float, optional
        How far above p = 15 the largest variance function may stay, relative.

    Returns
    -------
    float
        A lower bound of ``D * sqrt(n)`` of every plan of n of the tests.

    Raises
    ------
    ValueError
        If the tests together leave an error open.
    RuntimeError
        If the shares do not converge.

    Notes
    -----
    Shares w are multiplied by ``d_i / p``, where ``d_i = trace(inv(M) M_i)``, until no d_i exceeds p; by the
    equivalence theorem [2]_ the optimum has ``max d_i = p``, and for any shares ``log det M`` is at most
    ``max d_i - p`` below it, which is taken off here: the bound holds whatever the tolerance.
    """
    _, informations = _distinct(tests, noise, dt, "D")
    if not np.isfinite(_cost(informations.sum(axis=0)[None], "D")[0]):
        raise ValueError("`tests` must determine all fifteen errors together")
    size = len(PARAMETERS)
    shares = np.full(len(informations), 1 / len(informations))
    for _ in range(20000):
        total = np.einsum("i,ijk->jk", shares, informations)
        variance = np.einsum("jk,ikj->i", np.linalg.inv(total), informations)
        if variance.max() <= size * (1 + tolerance):
            return float(_cost(total[None], "D")[0] * np.exp(-(variance.max() - size) / (2 * size)))
        shares = shares * variance / size
    raise RuntimeError(f"no convergence: `tolerance` {tolerance} against {variance.max() / size - 1:.3g}")


def compare(
    plans: Mapping[str, Sequence[TurnTest]],
    noise: SensorNoise,
    *,
    limits: TableLimits | None = None,
    sizes: ArrayLike | None = None,
) -> "DataFrame":
    """Plans side by side, as they are and at equal time.

    Parameters
    ----------
    plans : mapping of str to sequence of TurnTest
        Plans by name.
    noise : SensorNoise
        Random errors of the sensors.
    limits : TableLimits, optional
        For the time between tests and the step `dt`.
    sizes : array_like, shape (15,), optional
        As in `criteria`.

    Returns
    -------
    DataFrame
        One row for each plan: number of tests, duration, s; criteria; root mean squares of the standard deviations of
        four groups, rad and m/s^2; and ``A_per_sqrt_hour``, which is A after an hour of repeating the plan.
    """
    import pandas as pd

    limits = limits or TableLimits()
    rows = {}
    for name, plan in plans.items():
        deviations = uncertainty.predict(plan, noise, dt=limits.dt).standard_deviation
        duration = limits.duration(plan)
        values = criteria(plan, noise, dt=limits.dt, sizes=sizes)
        groups = {group: float(np.sqrt(np.mean(deviations[places] ** 2))) for group, places in _GROUPS.items()}
        hourly = values["A"] * np.sqrt(duration / 3600)
        rows[name] = {"tests": len(plan), "duration": duration} | values | groups | {"A_per_sqrt_hour": hourly}
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("plan")


def difference_variance(noise: SensorNoise, dwell: ArrayLike, turn_duration: float, *, dt: float = 0.01) -> Array:
    """Variance of the measurements (6), (7) of [1]_ in closed form, for equal sensors with white noise.

    Parameters
    ----------
    noise : SensorNoise
        Angle random walk of gyros; velocity random walk and quantization of accelerometers.
    dwell : array_like, shape (...,)
        Duration of each dwell, s, long beside `dt`.
    turn_duration : float
        Duration of the turn, s.
    dt : float, optional
        Duration of a step, s.

    Returns
    -------
    ndarray, shape (...,)
        (m/s^2)^2: ``g^2 N^2 (26/35 T + U) + 12/5 M^2 / T + 24 s^2 dt / T^3``, as in
        `fogkit.calibration.uncertainty.slope_covariance`.

    Raises
    ------
    ValueError
        If sensors differ, or have other noise.
    """
    gyro, accelerometer = (set(checks.instance("noise", noise, SensorNoise).gyros), set(noise.accelerometers))
    if len(gyro) != 1 or len(accelerometer) != 1:
        raise ValueError("`noise` must be that of three equal gyros and three equal accelerometers")
    (N, *other_gyro), (M, *other_accelerometer, s) = gyro.pop().squares, accelerometer.pop().squares
    if any(other_gyro) or any(other_accelerometer):
        raise ValueError("`noise` must be angle and velocity random walk and quantization of accelerometers alone")
    T = checks.finite_array("dwell", dwell)
    if not (T > 0).all():
        raise ValueError(f"`dwell` must be > 0 s, got {T.min()}")
    walk = STANDARD_GRAVITY**2 * N * (26 / 35 * T + checks.positive("turn_duration", turn_duration, "s"))
    return walk + 12 / 5 * M / T + 24 * s * checks.positive("dt", dt, "s") / T**3


def best_dwell(noise: SensorNoise, turn_duration: float, *, overhead: float | None = None, dt: float = 0.01) -> float:
    """Duration of a dwell, s, with which a test of a given turn is the most precise.

    Parameters
    ----------
    noise, turn_duration, dt
        As in `difference_variance`.
    overhead : float, optional
        Time between tests, s. If given, time is what counts: the plan is repeated as often as it fits. Without it the
        number of tests counts.

    Returns
    -------
    float
        From 0.1 s to 1000 s. With angle random walk N and velocity random walk M alone, and the number of tests
        counting, ``sqrt(42 / 13) M / (g N)``.
    """
    from scipy.optimize import minimize_scalar  # loaded where used

    if overhead is not None:
        checks.non_negative("overhead", overhead, "s")

    def cost(logarithm: float) -> float:
        dwell = np.exp(logarithm)
        price = 1.0 if overhead is None else 2 * dwell + turn_duration + overhead
        return float(np.log(difference_variance(noise, dwell, turn_duration, dt=dt) * price))

    found = minimize_scalar(cost, bounds=(np.log(0.1), np.log(1000.0)), method="bounded", options={"xatol": 1e-8})
    return float(np.exp(found.x))


def _directions(oblique: bool) -> dict[str, Array]:
    """Axes of the unit with both signs, and the diagonals between two of them if wanted."""
    unit = dict(zip(AXES, np.eye(3), strict=True))
    found = dict(unit)
    if oblique:
        for first, second in (("x", "y"), ("y", "z"), ("z", "x")):
            for sign, text in ((1, "+"), (-1, "-")):
                found[f"{first}{text}{second}"] = (unit[first] + sign * unit[second]) / np.sqrt(2)
    return found | {f"-({name})" if len(name) > 1 else f"-{name}": -vector for name, vector in found.items()}


def _level_turn(label: str, axis: Array, up: Array, angle: float, limits: TableLimits) -> TurnTest:
    """Test about an axis that points east, or north if it is z, with another direction up."""
    across = np.cross(up, axis)
    east, north = (-across, axis) if axis[2] == 1 else (axis, across)
    return TurnTest(
        label=label,
        C_b_n=np.stack([east, north, up]),
        axis=axis,
        angle=angle,
        dwell=limits.dwell,
        turn_duration=limits.turn_duration(angle),
    )


def _informations(tests: Sequence[TurnTest], noise: SensorNoise, dt: float, sizes: ArrayLike | None = None) -> Array:
    """Information of each test, shape (n, 15, 15), in units of the sizes."""
    unit = np.where([name.startswith("b_a") for name in PARAMETERS], STANDARD_GRAVITY, 1.0)
    if sizes is not None:
        unit = checks.finite_array("sizes", sizes, shape=(len(PARAMETERS),))
        if not (unit > 0).all():
            raise ValueError(f"`sizes` must be > 0 rad and m/s^2, got {unit.min()}")
    found = np.empty((len(tests), len(PARAMETERS), len(PARAMETERS)))
    known: dict[tuple, Array] = {}
    equal = len(set(noise.gyros)) == len(set(noise.accelerometers)) == 1
    white = equal and not any(noise.gyros[0].squares[[1, 2, 4]]) and not any(noise.accelerometers[0].squares[[1, 2]])
    for place, test in enumerate(tests):
        key = test.dwells if white else place  # the same for all attitudes
        if key not in known:
            known[key] = uncertainty.plan_covariance([test], dt, noise)
        rows = uncertainty.design(test) * unit
        found[place] = rows.T @ np.linalg.solve(known[key], rows)
    return found


def _distinct(
    tests: Sequence[TurnTest], noise: SensorNoise, dt: float, criterion: str, sizes: ArrayLike | None = None
) -> tuple[list[TurnTest], Array]:
    """Tests that tell different things, the first of each kind, and what they add."""
    if criterion == "condition":
        rows = np.stack([uncertainty.design(test, gravity=1.0) for test in tests])
        informations = np.einsum("nij,nik->njk", rows, rows)
    else:
        informations = _informations(tests, noise, dt, sizes)
    scale = np.abs(informations).max()
    times = np.array([test.duration for test in tests])
    kept: dict[tuple, int] = {}
    for place, matrix in enumerate(informations):
        key = (np.rint(matrix / (scale * _SAME)).astype(np.int64).tobytes(), round(times[place] / dt))
        kept.setdefault(key, place)
    places = list(kept.values())
    return [tests[i] for i in places], informations[places]


def _exchanged(
    informations: Array, costs: Array, count: int, allowed: float, criterion: str, rng: np.random.Generator
) -> tuple[float, list[int]]:
    """Value and places of a plan that no exchange of one test improves."""
    chosen = list(rng.integers(len(costs), size=count))
    while costs[chosen].sum() > allowed * (1 + 1e-9):  # replace the longest by the shortest until it fits
        chosen[int(np.argmax(costs[chosen]))] = int(np.argmin(costs))
    value, better = np.inf, True
    # a plan that leaves directions open is improved by what is small beside any information
    floor = 1e-10 * np.abs(informations).max() * np.eye(informations.shape[-1])
    while better:
        better = False
        for place in rng.permutation(count):
            rest = [i for n, i in enumerate(chosen) if n != place]
            total = informations[rest].sum(axis=0) + floor
            trial = _cost(total + informations, criterion)
            trial[costs[rest].sum() + costs > allowed * (1 + 1e-9)] = np.inf
            best = int(np.argmin(trial))
            if trial[best] < value * (1 - _BETTER):
                value, chosen[place], better = float(trial[best]), best, True
    return float(_cost(informations[chosen].sum(axis=0)[None], criterion)[0]), chosen


def _cost(informations: Array, criterion: str) -> Array:
    """Criterion of information matrices, shape (n, 15, 15); infinite for a singular one."""
    values, vectors = np.linalg.eigh(_balanced(informations))
    cost = np.full(len(informations), np.inf)
    regular = values[:, 0] > 1e-13 * values[:, -1]
    if criterion == "condition":
        return np.where(regular, _condition(informations), np.inf)
    lengths = np.sqrt(np.diagonal(informations, axis1=-2, axis2=-1))[regular]
    if criterion == "D":
        logarithm = np.log(values[regular]).sum(axis=-1) + 2 * np.log(lengths).sum(axis=-1)
        cost[regular] = np.exp(-logarithm / (2 * informations.shape[-1]))
    else:
        variances = np.sum(vectors[regular] ** 2 / values[regular][:, None, :], axis=-1) / lengths**2
        cost[regular] = np.sqrt(variances.mean(axis=-1))
    return cost


def _balanced(informations: Array) -> Array:
    """Information matrices with ones on the diagonal, as far as there is any."""
    lengths = np.sqrt(np.diagonal(informations, axis1=-2, axis2=-1))
    lengths = np.where(lengths > 0, lengths, 1.0)
    return informations / lengths[:, :, None] / lengths[:, None, :]


def _condition(informations: Array) -> Array:
    """Condition number of a matrix from its product with itself."""
    values = np.linalg.eigvalsh(informations)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.sqrt(values[..., -1] / np.maximum(values[..., 0], 0))
