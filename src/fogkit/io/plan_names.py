"""Plans by name, as a description of a recording gives them, and what each makes the unit feel step by step.

=====================  =======================================================================================
kind                   parameters beside it
=====================  =======================================================================================
three-stage            ``construction``, ``bias_duration``, ``rates`` and ``rate_unit``, ``count``
six-positions          ``duration``
twenty-four-points     ``duration``
three-positions-east   ``duration``
full-turns             ``rate`` and ``rate_unit``, ``turns``
rate-sequence          ``duration``, ``rates`` and ``rate_unit``, ``axes``
placements             ``placements``: rows of label, letters, duration in s, rate; ``rate_unit``
nine-tests             ``turns``, ``dwell``, ``turn_duration``, ``dwell_after``
bias-test              ``dwell``, ``turn_duration``
gyrocompass            ``start`` and ``axis``, ``angles`` and ``angle_unit``, ``dwell``, ``turn_duration``
=====================  =======================================================================================

Times are in s. What is left out is as in `fogkit.stand.plans`, `fogkit.stand.placements` and
`fogkit.stand.turn_tests`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Any, Self

import numpy as np

from fogkit import checks
from fogkit.imu.constructions import Construction
from fogkit.io.unit_names import si_factor
from fogkit.rotation import dcm_from_rotvec
from fogkit.stand import placements, plans
from fogkit.stand.placements import Placement, Schedule
from fogkit.stand.plans import Plan
from fogkit.stand.table import RateTable
from fogkit.stand.turn_tests import TurnTest, bias_test, nine_tests

PARAMETERS: dict[str, tuple[str, ...]] = {
    "three-stage": ("construction", "bias_duration", "rates", "rate_unit", "count"),
    "six-positions": ("duration",),
    "twenty-four-points": ("duration",),
    "three-positions-east": ("duration",),
    "full-turns": ("rate", "rate_unit", "turns"),
    "rate-sequence": ("duration", "rates", "rate_unit", "axes"),
    "placements": ("placements", "rate_unit"),
    "nine-tests": ("turns", "dwell", "turn_duration", "dwell_after"),
    "bias-test": ("dwell", "turn_duration"),
    "gyrocompass": ("start", "axis", "angles", "angle_unit", "dwell", "turn_duration"),
}

MOST_STEPS = 5000
"""Steps of a plan beyond which it is taken for a mistake."""

Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class MountScan:
    """Dwells of a unit at angles of a mount, one after the other: north from a scan, or from two positions.

    Parameters
    ----------
    start : str
        Where x, y and z point at angle 0, three letters of ``EWNSUD``; the heading need not be known.
    axis : {"x", "y", "z"}
        Body axis of the mount.
    angles : sequence of float
        Angles of the dwells, rad, two at least.
    dwell, turn_duration : float
        Time at each angle and of each turn between two, s.
    """

    start: str
    axis: str
    angles: tuple[float, ...]
    dwell: float
    turn_duration: float

    def __post_init__(self) -> None:
        placements.attitude(self.start)
        checks.option("axis", self.axis, "xyz")
        angles = checks.finite_array("angles", self.angles, shape=(None,), min_size=2)
        checks.array_in_closed_interval("angles", angles, -200 * np.pi, 200 * np.pi, "rad")
        if (np.diff(angles) == 0).any():
            raise ValueError("`angles` must differ from one dwell to the next, got two equal ones")
        object.__setattr__(self, "angles", tuple(angles.tolist()))
        for name in ("dwell", "turn_duration"):
            object.__setattr__(self, name, checks.positive(name, getattr(self, name), "s"))


AnyPlan = Plan | Schedule | tuple[TurnTest, ...] | MountScan


@dataclass(frozen=True, kw_only=True)
class Step:
    """What a unit feels while one step of a plan lasts.

    Attributes
    ----------
    label : str
        Name.
    duration : float
        Duration, s.
    rate : tuple of float
        Mean rate in axes of the unit, rad/s, without the Earth's; 0 for a dwell.
    up : tuple of float, or None
        Direction of up in axes of the unit at the beginning; None where the plan does not say.
    C_b_n : tuple, or None
        Attitude at the beginning, nine direction cosines row by row; None where the plan does not say.
    north : bool
        Whether that attitude holds the heading, and not only from one step to the next.
    part : int
        Which test or placement of the plan it belongs to, from 0.
    """

    label: str
    duration: float
    rate: Vector
    up: Vector | None
    part: int
    C_b_n: tuple[float, ...] | None = None
    north: bool = True

    @property
    def turns(self) -> bool:
        """Whether the unit turns."""
        return any(self.rate)


@dataclass(frozen=True, kw_only=True)
class PlanReference:
    """A plan by its name and parameters; it is built, and so checked, at once.

    Parameters
    ----------
    kind : str
        Name: a key of `PARAMETERS`.
    parameters : dict, optional
        What differs from the plan's defaults, in the units that it says.

    Raises
    ------
    ValueError, TypeError
        If the name or a parameter is not known, or the plan cannot be built.

    Examples
    --------
    >>> plan = PlanReference(kind="six-positions", parameters={"duration": 60.0})
    >>> plan.build().duration
    360.0
    """

    kind: str
    parameters: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if isinstance(self.kind, str) and self.kind not in PARAMETERS:
            near = get_close_matches(self.kind, PARAMETERS, n=1)
            fix = f"Did you mean {near[0]!r}?" if near else ""
            checks.option("kind", self.kind[:40], PARAMETERS, fix=fix)
        known = PARAMETERS[checks.option("kind", self.kind, PARAMETERS)]
        checks.instance("parameters", self.parameters, dict)
        object.__setattr__(self, "parameters", dict(self.parameters))
        for key in self.parameters:
            if key not in known:
                raise ValueError(f"`{key[:40]}` is not a parameter of {self.kind!r}. Known are {', '.join(known)}.")
        if len(steps(self.build())) > MOST_STEPS:
            raise ValueError(f"a plan must have at most {MOST_STEPS} steps")

    @classmethod
    def from_table(cls, table: dict[str, Any]) -> Self:
        """Reference from a table with ``kind`` and the parameters."""
        if "kind" not in table:
            raise ValueError("`kind` must be given")
        return cls(kind=table["kind"], parameters={key: value for key, value in table.items() if key != "kind"})

    def build(self) -> AnyPlan:
        """The plan itself."""
        values = dict(self.parameters)
        for name, kind in (("rate", "angular rate"), ("angle", "angle")):
            unit = values.pop(f"{name}_unit", None)
            used = [key for key in (name, f"{name}s") if key in values]
            rows = name == "rate" and "placements" in values
            if unit is None and (used or (rows and any(_row(row)[3] for row in _list("placements", values)))):
                raise ValueError(f"`{name}_unit` must be given with {f'`{used[0]}`' if used else 'rates'}")
            factor = 1.0 if unit is None else si_factor(kind, unit)
            for key in used:
                values[key] = _scaled(key, values[key], factor)
            if rows:
                values["placements"] = [
                    (a, b, c, _scaled("rate", d, factor)) for a, b, c, d in map(_row, values["placements"])
                ]
        for key in ("duration", "bias_duration", "dwell", "turn_duration", "dwell_after"):
            if key in values:
                values[key] = checks.in_closed_interval(key, values[key], 1e-3, 1e7, "s")
        for key in ("turns", "count"):
            if key in values:
                values[key] = int(checks.in_closed_interval(key, checks.integer(key, values[key]), 0, 10_000))
        return _BUILDERS[self.kind](values)


def steps(plan: AnyPlan) -> tuple[Step, ...]:
    """What a unit feels in each step of a plan, one dwell after the other in one attitude being one.

    Parameters
    ----------
    plan : Plan, Schedule, sequence of TurnTest, or MountScan
        The plan.

    Returns
    -------
    tuple of Step
        In order. Of a `Plan` for a gyro block, rates are those of the gyros, and up is not said: accelerometers may
        stand in the case.
    """
    if isinstance(plan, Plan):
        return _of_plan(plan)
    if isinstance(plan, Schedule):
        return tuple(
            Step(
                label=p.label,
                duration=p.duration,
                rate=_vector(p.rate * p.C_b_n[2]),
                up=_vector(p.C_b_n[2]),
                part=i,
                C_b_n=_cosines(p.C_b_n),
            )
            for i, p in enumerate(plan.placements)
        )
    if isinstance(plan, MountScan):
        return _of_scan(plan)
    return _of_tests(tuple(checks.instance("plan", test, TurnTest) for test in plan))


def _of_plan(plan: Plan) -> tuple[Step, ...]:
    table = RateTable(latitude=0.0)  # free of errors: only its geometry is used
    found = []
    for i, (s, C_0_g1) in enumerate(zip(plan.segments, plan.C_0_g1, strict=True)):
        C_0_n = table.C_0_n(s.outer, s.middle, s.inner)
        axis = table.axis_in_case(s.turning or "outer", s.middle, s.inner)
        up = _vector(C_0_n[2]) if plan.construction.name == "plain" else None
        found.append(Step(label=s.label, duration=s.duration, rate=_vector(s.rate * (C_0_g1 @ axis)), up=up, part=i))
    return tuple(found)


def _of_tests(tests: Sequence[TurnTest]) -> tuple[Step, ...]:
    found: list[Step] = []
    before = None
    for i, test in enumerate(tests):
        up, end = _vector(test.C_b_n[2]), _vector(test.C_b_n_end[2])
        begin = {"up": up, "part": i, "C_b_n": _cosines(test.C_b_n)}
        first = Step(label=f"{test.label} before", duration=test.dwell, rate=(0.0,) * 3, **begin)
        if before is not None and np.allclose(before, test.C_b_n):
            last = found.pop()
            label = f"{last.label}, {first.label}"
            first = Step(label=label, duration=last.duration + first.duration, rate=(0.0,) * 3, **begin)
        rate = _vector(test.axis * (test.angle / test.turn_duration))
        found += [
            first,
            Step(label=f"{test.label} turn", duration=test.turn_duration, rate=rate, up=up, part=i),
            Step(
                label=f"{test.label} after",
                duration=float(test.dwell_after),
                rate=(0.0,) * 3,
                up=end,
                part=i,
                C_b_n=_cosines(test.C_b_n_end),
            ),
        ]
        before = test.C_b_n_end
    return tuple(found)


def _of_scan(scan: MountScan) -> tuple[Step, ...]:
    axis = np.eye(3)["xyz".index(scan.axis)]
    C_b_n = placements.attitude(scan.start)
    found: list[Step] = []
    for i, angle in enumerate(scan.angles):
        if i:
            rate = _vector(axis * (angle - scan.angles[i - 1]) / scan.turn_duration)
            up = found[-1].up
            found.append(Step(label=f"turn {i}", duration=scan.turn_duration, rate=rate, up=up, part=i))
        C = C_b_n @ dcm_from_rotvec(axis * angle)
        attitude = {"up": _vector(C[2]), "C_b_n": _cosines(C), "north": False}
        found.append(Step(label=f"dwell {i + 1}", duration=scan.dwell, rate=(0.0, 0.0, 0.0), part=i, **attitude))
    return tuple(found)


def _vector(values: Any) -> Vector:
    """Three floats, rounding of a right angle removed."""
    values = np.asarray(values, dtype=float)
    size = np.abs(values).max()
    x, y, z = np.where(np.abs(values) < 1e-12 * size, 0.0, values).tolist()
    return x, y, z


def _cosines(C: Any) -> tuple[float, ...]:
    """Nine direction cosines, row by row."""
    return tuple(np.asarray(C, dtype=float).ravel().tolist())


def _list(key: str, values: dict[str, Any]) -> list:
    """A list of at most `MOST_STEPS` entries."""
    value = values[key]
    if not isinstance(value, list | tuple):
        raise TypeError(f"`{key}` must be a list, got {type(value).__name__}")
    if len(value) > MOST_STEPS:
        raise ValueError(f"`{key}` must be at most {MOST_STEPS}, got {len(value)}")
    return list(value)


def _row(row: Any) -> tuple:
    """Label, letters, duration and rate of a placement."""
    if not isinstance(row, list | tuple) or len(row) not in (3, 4):
        raise ValueError("`placements` must be rows of label, letters, duration and, if it turns, rate")
    return (*row, 0.0)[:4]


def _scaled(key: str, value: Any, factor: float) -> Any:
    if isinstance(value, list | tuple):
        return [checks.finite(key, entry) * factor for entry in _list(key, {key: value})]
    return checks.finite(key, value) * factor


def _three_stage(values: dict[str, Any]) -> Plan:
    return plans.three_stage(Construction(name=values.pop("construction", "plain")), **values)


def _placed(values: dict[str, Any]) -> Schedule:
    if "placements" not in values:
        raise ValueError("`placements` must be given")
    return Schedule([Placement(label=a, axes=b, duration=c, rate=d) for a, b, c, d in values["placements"]])


def _scan(values: dict[str, Any]) -> MountScan:
    for key in ("start", "axis", "angles", "dwell", "turn_duration"):
        if key not in values:
            raise ValueError(f"`{key}` must be given")
    return MountScan(**values)


def _rate_sequence(values: dict[str, Any]) -> Schedule:
    if "axes" in values and (not isinstance(values["axes"], str) or not values["axes"]):
        raise TypeError("`axes` must be letters of 'xyz'")
    return placements.rate_sequence(**values)


_BUILDERS = {
    "three-stage": _three_stage,
    "six-positions": lambda values: placements.six_positions(**values),
    "twenty-four-points": lambda values: placements.twenty_four_points(**values),
    "three-positions-east": lambda values: placements.three_positions_east(**values),
    "full-turns": lambda values: placements.full_turns(**values),
    "rate-sequence": _rate_sequence,
    "placements": _placed,
    "nine-tests": lambda values: nine_tests(**values),
    "bias-test": lambda values: (bias_test(**values),),
    "gyrocompass": _scan,
}
