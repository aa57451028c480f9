"""When did the unit rest, when did it turn, and which step of the plan was that?

A segment is a run of windows in which rate, and for a dwell specific force, stay the same. Found ones are matched with
the steps of a plan in order, as two texts are compared: a pause that the plan does not have is passed over, a step that
was left out is reported, and one that was done about another axis is matched and reported too.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, permutations, product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.io.errors import RecordingError
from fogkit.io.plan_names import AnyPlan, PlanReference, Step, steps
from fogkit.io.recordings import Block, Recording
from fogkit.io.verdicts import Finding, Verdict, summary
from fogkit.io.windows import WindowMeans, Windows
from fogkit.units import DEG_PER_SECOND

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

LabelRun = tuple[str, int, int]

STEADY = 0.02 * DEG_PER_SECOND
"""Change of a rate between windows, rad/s, below which it is the same; more if noise or the plan say so."""

NOISE = 8.0
"""Standard deviations of a window's mean by which two means of one rate may differ."""

RELATIVE = 0.02
"""Change of a rate, of itself, below which it is the same: tables wobble."""

ATTITUDE = 0.05
"""Change of the specific force, of itself, that is another attitude."""

WINDOW = 0.5
"""Duration of a window, s."""

DISTURBANCE = 3
"""Windows of unrest within a dwell, or a turn, that do not end it."""

MOST_SEGMENTS = 20_000
"""Segments beyond which a recording is nothing but unrest."""

PASS_FOUND, PASS_STEP = 0.6, 1.2
"""Costs of passing over a found segment, and over a step of the plan."""

LONGEST = 5.0
"""How many times longer than planned a step may last before the clock is in doubt."""

CLOCK_DRIFT = 1e-3
"""Relative drift of the clock against the plan that is doubtful: tables are not timed better."""

AGREES = 0.7
"""Cosine between the direction found and that of the plan from which the axis is the right one."""

SIGNED_PERMUTATIONS = [
    np.eye(3)[list(order)] * np.array(signs)[:, None]
    for order in permutations(range(3))
    for signs in product((1, -1), repeat=3)
]


@dataclass(frozen=True, kw_only=True, eq=False)
class FoundSegment:
    """One dwell or one steady turn in a recording.

    Attributes
    ----------
    kind : {"dwell", "turn"}
        Whether the unit rests.
    begin, end : float
        Times, s.
    first, last : int
        First sample, and the one after the last.
    rate : ndarray, shape (3,)
        Mean reading of the gyros, rad/s, less that at rest for a turn.
    force : ndarray, shape (3,), or None
        Mean reading of the accelerometers, m/s^2.
    label : str
        Step of the plan that it is; empty if none.
    """

    kind: str
    begin: float
    end: float
    first: int
    last: int
    rate: Array
    force: Array | None
    label: str = ""

    @property
    def duration(self) -> float:
        """Duration, s."""
        return self.end - self.begin


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Segmentation:
    """Dwells and turns of a recording.

    Attributes
    ----------
    segments : tuple of FoundSegment
        In order.
    verdict : Verdict
        Whether the plan was carried out: missing steps, wrong axes, durations, clock.
    windows : Windows
        Means of which the segments consist.
    steps : tuple of Step
        Those of the plan; empty without one.
    exact : bool
        Whether the limits are those of the recording's own labels; else they are good to a window.
    """

    segments: tuple[FoundSegment, ...]
    verdict: Verdict
    windows: Windows
    steps: tuple[Step, ...]
    exact: bool = False

    def __repr__(self) -> str:
        dwells = sum(s.kind == "dwell" for s in self.segments)
        named = sum(bool(s.label) for s in self.segments)
        of = f", {named} of {len(self.steps)} steps of the plan" if self.steps else ""
        return f"<Segmentation: {dwells} dwells, {len(self.segments) - dwells} turns{of}; {self.verdict.severity}>"

    def labelled(self) -> dict[str, FoundSegment]:
        """Segments that are steps of the plan, by label."""
        return {s.label: s for s in self.segments if s.label}

    def to_frame(self) -> "DataFrame":
        """One row for each segment: times in s, rates in deg/s, specific forces in m/s^2."""
        import pandas as pd

        rows = [
            {
                "step": s.label,
                "kind": s.kind,
                "begin, s": s.begin,
                "duration, s": s.duration,
                **{f"rate {a}, deg/s": r / DEG_PER_SECOND for a, r in zip("xyz", s.rate, strict=True)},
                **{
                    f"force {a}, m/s^2": f
                    for a, f in zip("xyz", [np.nan] * 3 if s.force is None else s.force, strict=True)
                },
            }
            for s in self.segments
        ]
        return pd.DataFrame(rows, index=pd.RangeIndex(1, len(rows) + 1, name="segment"))

    def draw(self, ax: Any) -> Any:
        """Rates of all windows over time, with dwells and turns shaded and named, into axes of matplotlib.

        Parameters
        ----------
        ax : matplotlib.axes.Axes
            Where to draw.

        Returns
        -------
        matplotlib.axes.Axes
            The axes, in deg/s against s.
        """
        for i, axis in enumerate("xyz"):
            ax.plot(self.windows.time, self.windows.means[:, i] / DEG_PER_SECOND, lw=1, label=f"gyro {axis}")
        top = float(np.nanmax(np.abs(self.windows.means[:, :3]), initial=1e-9)) / DEG_PER_SECOND
        for s in self.segments:
            colour = "0.85" if s.kind == "dwell" else "C1"
            ax.axvspan(s.begin, s.end, color=colour, alpha=0.5 if s.label else 0.2, lw=0)
            if s.label:
                ax.text((s.begin + s.end) / 2, 1.08 * top, s.label, rotation=90, ha="center", va="bottom", fontsize=7)
        ax.set(xlabel="time, s", ylabel="rate, deg/s", ylim=(-1.1 * top, 1.6 * top))
        return ax


def label_runs(block: Block, before: Sequence[LabelRun] = ()) -> list[LabelRun] | None:
    """Positions that a recording names, in order, with those of the blocks before; None if it has no labels."""
    if block.labels is None:
        return None
    runs, labels = list(before), block.labels
    edges = [0, *(np.flatnonzero(labels[1:] != labels[:-1]) + 1).tolist(), len(labels)]
    for start, stop in pairwise(edges):
        label = labels[start]
        if label is None:
            continue
        if start == 0 and runs and runs[-1][0] == label and runs[-1][2] == block.first:
            runs[-1] = (label, runs[-1][1], block.first + stop)
        else:
            runs.append((label, block.first + start, block.first + stop))
    return runs


def segment(recording: Recording, plan: AnyPlan | PlanReference | None = None) -> Segmentation:
    """Dwells and turns of a recording, named by its plan.

    Parameters
    ----------
    recording : Recording
        The recording.
    plan : Plan, Schedule, sequence of TurnTest, MountScan or PlanReference, optional
        What was done; that of the recording's description if not given. Without any, segments have no names.

    Returns
    -------
    Segmentation

    Raises
    ------
    RecordingError
        If the recording is too short, or holds numbers that are missing, infinite or beyond any sensor.
    """
    checks.instance("recording", recording, Recording)
    collector = WindowMeans(max(1, round(WINDOW / recording.dt)), recording.dt)
    block = recording.block()
    collector.update(block)
    plan = plan if plan is not None else recording.description.plan
    return segment_windows(collector.result(), plan, recording.has_accelerometers, label_runs(block))


def segment_windows(
    windows: Windows,
    plan: AnyPlan | PlanReference | None = None,
    has_accelerometers: bool = True,
    labels: Sequence[LabelRun] | None = None,
) -> Segmentation:
    """The same from means over windows, as a recording larger than memory leaves them.

    Parameters
    ----------
    windows : Windows
        Means of gyros, and accelerometers if there are, then anything.
    plan
        As for `segment`.
    has_accelerometers : bool, optional
        Whether channels 3 to 5 are accelerometers.
    labels : sequence of tuple, optional
        Label, first sample, and the one after the last, of each position that the recording itself names: they are the
        segments then.
    """
    expected = steps(plan.build() if isinstance(plan, PlanReference) else plan) if plan is not None else ()
    channels = windows.means[:, : 6 if has_accelerometers else 3]
    if len(channels) < 2:
        raise RecordingError(f"the recording must hold at least 2 windows of {windows.duration:g} s to find dwells in")
    if not (np.abs(channels) < 1e6).all():
        bad = int(np.argmin((np.abs(channels) < 1e6).all(axis=1)))
        raise RecordingError(f"the recording holds numbers that no sensor reads at {windows.time[bad]:.6g} s")
    gyro, force = channels[:, :3], channels[:, 3:] if has_accelerometers else None
    tolerance = _tolerance(gyro, expected)
    if labels is not None:
        return _by_labels(windows, gyro, force, labels, expected, tolerance)
    runs = _merged(_runs(windows, gyro, force, tolerance), gyro, force, tolerance)
    if len(runs) > MOST_SEGMENTS:
        raise RecordingError(f"the recording holds {len(runs)} dwells and turns: it never rests")
    rest = _rest(gyro, runs, tolerance)
    found = [_segment(windows, gyro, force, run, rest, tolerance) for run in runs]
    if not expected:
        text = f"{len(found)} dwells and turns; no plan to compare them with"
        return Segmentation(
            segments=tuple(found),
            verdict=Verdict((Finding(check="plan", severity="good", text=text),)),
            windows=windows,
            steps=(),
        )
    pairs = _match(found, expected)
    for i, j in pairs:
        found[i] = replace(found[i], label=expected[j].label)
    verdict = Verdict(_against_plan(found, expected, pairs))
    return Segmentation(segments=tuple(found), verdict=verdict, windows=windows, steps=tuple(expected))


def _by_labels(
    windows: Windows,
    gyro: Array,
    force: Array | None,
    labels: Sequence[LabelRun],
    expected: Sequence[Step],
    tolerance: float,
) -> Segmentation:
    """Segments that the recording itself names."""
    if not labels:
        raise RecordingError("the recording names no position in its column of labels")
    if len(labels) > MOST_SEGMENTS:
        raise RecordingError(f"the recording names {len(labels)} positions")
    ends = windows.first + windows.size
    runs = []
    for label, first, last in labels:
        run = int(np.searchsorted(windows.first, first)), int(np.searchsorted(ends, last, side="right"))
        if run[1] <= run[0]:
            raise RecordingError(f"position {label!r} is shorter than two windows of {windows.duration:g} s")
        runs.append(run)
    rest = _rest(gyro, runs, tolerance)
    planned = {e.label: e for e in expected}
    found = []
    for (label, first, last), run in zip(labels, runs, strict=True):
        segment = _segment(windows, gyro, force, run, rest, tolerance)
        if label in planned and planned[label].turns != (segment.kind == "turn"):
            turns = planned[label].turns
            rate = gyro[slice(*run)].mean(axis=0)
            segment = replace(segment, kind="turn" if turns else "dwell", rate=rate - rest if turns else rate)
        begin = segment.begin - (segment.first - first) * windows.dt
        end = segment.end + (last - segment.last) * windows.dt
        found.append(replace(segment, label=label, begin=begin, end=end, first=first, last=last))
    names = [label for label, *_ in labels]
    findings = []
    if repeated := sorted({name for name in names if names.count(name) > 1}):
        text = f"{len(repeated)} positions come twice, {repeated[0]!r} for one"
        findings.append(Finding(check="plan", severity="bad", text=text, count=len(repeated)))
    order = {e.label: j for j, e in enumerate(expected)}
    if expected and (unknown := [name for name in names if name not in order]):
        text = f"{len(unknown)} positions are not in the plan, {unknown[0]!r} for one"
        findings.append(Finding(check="plan", severity="bad", text=text, count=len(unknown)))
    pairs = [(i, order[name]) for i, name in enumerate(names) if name in order]
    if expected:
        findings += [f for f in _against_plan(found, expected, pairs) if f.severity != "good" or not findings]
    else:
        findings = findings or [Finding(check="plan", severity="good", text=f"{len(found)} positions by their labels")]
    return Segmentation(
        segments=tuple(found), verdict=Verdict(findings), windows=windows, steps=tuple(expected), exact=True
    )


def _tolerance(gyro: Array, expected: Sequence[Step]) -> float:
    """Change of a rate between windows that is none, rad/s."""
    slowest = min((float(np.linalg.norm(s.rate)) for s in expected if s.turns), default=np.inf)
    noise = np.median(np.abs(np.diff(gyro, axis=0)), axis=0) / 0.6745 / np.sqrt(2)
    return max(min(STEADY, slowest / 4), NOISE * float(noise.max()), 1e-9)


def _runs(windows: Windows, gyro: Array, force: Array | None, tolerance: float) -> list[tuple[int, int]]:
    """First window, and the one after the last, of each run in which nothing changes."""
    size = np.abs(gyro).max(axis=1)
    allowed = tolerance + RELATIVE * np.minimum(size[1:], size[:-1])
    broken = np.abs(np.diff(gyro, axis=0)).max(axis=1) > allowed
    broken |= np.diff(windows.time) > 1.5 * windows.duration
    if force is not None:
        weight = max(float(np.median(np.linalg.norm(force, axis=1))), 1e-12)
        slow = np.maximum(size[1:], size[:-1]) < 0.5 * DEG_PER_SECOND + tolerance
        broken |= slow & (np.linalg.norm(np.diff(force, axis=0), axis=1) > ATTITUDE * weight)
    edges = np.flatnonzero(broken) + 1
    starts, stops = np.append(0, edges), np.append(edges, len(gyro))
    long = stops - starts >= 2
    found = []
    for start, stop in zip(starts[long].tolist(), stops[long].tolist(), strict=True):
        middle = np.median(gyro[start:stop], axis=0)
        if np.abs(gyro[start:stop] - middle).max() <= 2 * (tolerance + RELATIVE * np.abs(middle).max()):
            found.append((start, stop))
    return found


def _merged(runs: list, gyro: Array, force: Array | None, tolerance: float) -> list[tuple[int, int]]:
    """Runs, those put together that a short disturbance parts."""
    merged: list[tuple[int, int]] = []
    for start, stop in runs:
        if merged and 0 < start - merged[-1][1] <= DISTURBANCE:
            before, now = slice(*merged[-1]), slice(start, stop)
            rate = np.median(gyro[now], axis=0)
            same = np.abs(np.median(gyro[before], axis=0) - rate).max() <= tolerance + RELATIVE * np.abs(rate).max()
            if same and force is not None:
                a, b = np.median(force[before], axis=0), np.median(force[now], axis=0)
                same = np.linalg.norm(a - b) <= ATTITUDE * np.linalg.norm(b) or np.abs(rate).max() > DEG_PER_SECOND
            if same:
                merged[-1] = (merged[-1][0], stop)
                continue
        merged.append((start, stop))
    return merged


def _rest(gyro: Array, runs: list, tolerance: float) -> Array:
    """Reading of the gyros at rest: median of the steady windows' slower half, where that is slow."""
    if not runs:
        return np.zeros(3)
    steady = np.concatenate([gyro[start:stop] for start, stop in runs])
    size = np.linalg.norm(steady, axis=1)
    rest = np.median(steady[size <= np.median(size)], axis=0)
    return rest if np.linalg.norm(rest) < max(DEG_PER_SECOND, 2 * tolerance) else np.zeros(3)


def _segment(windows: Windows, gyro, force, run: tuple[int, int], rest: Array, tolerance: float) -> FoundSegment:
    start, stop = run
    rate = gyro[start:stop].mean(axis=0)
    turns = np.linalg.norm(rate - rest) > 1.5 * tolerance
    return FoundSegment(
        kind="turn" if turns else "dwell",
        begin=float(windows.time[start]),
        end=float(windows.time[stop - 1] + windows.duration),
        first=int(windows.first[start]),
        last=int(windows.first[stop - 1] + windows.size),
        rate=rate - rest if turns else rate,
        force=None if force is None else force[start:stop].mean(axis=0),
    )


def _match(found: Sequence[FoundSegment], expected: Sequence[Step]) -> list[tuple[int, int]]:
    """Pairs of found segments and steps, both in order, of least cost."""
    n, m = len(found), len(expected)
    if n == 0:
        return []
    cost = np.array([[_cost(f, e) for e in expected] for f in found]) if n * m <= 40_000 else _costs(found, expected)
    best = np.empty((n + 1, m + 1))
    best[0] = PASS_STEP * np.arange(m + 1)
    for i in range(1, n + 1):
        row, above, c = [best[i - 1, 0] + PASS_FOUND], best[i - 1].tolist(), cost[i - 1].tolist()
        for j in range(1, m + 1):
            row.append(min(above[j] + PASS_FOUND, above[j - 1] + c[j - 1], row[-1] + PASS_STEP))
        best[i] = row
    pairs, i, j = [], n, m
    while i and j:
        if best[i, j] == best[i - 1, j - 1] + cost[i - 1, j - 1]:
            i, j = i - 1, j - 1
            pairs.append((i, j))
        elif best[i, j] == best[i - 1, j] + PASS_FOUND:
            i -= 1
        else:
            j -= 1
    return pairs[::-1]


def _costs(found: Sequence[FoundSegment], expected: Sequence[Step]) -> Array:
    """Costs where there are many: of the longest found segments only, the rest being passed over."""
    keep = np.argsort([-f.duration for f in found])[: max(40_000 // len(expected), len(expected))]
    cost = np.full((len(found), len(expected)), np.inf)
    for i in keep:
        cost[i] = [_cost(found[i], e) for e in expected]
    return cost


def _cost(found: FoundSegment, step: Step) -> float:
    """Cost of taking a found segment for a step; more than passing over both if only one is a dwell."""
    if step.turns != (found.kind == "turn"):
        return 5.0
    ratio = abs(np.log(max(found.duration, 1e-6) / step.duration))
    cost = min(0.5, 0.4 * ratio)
    if step.turns:
        size, wanted = np.linalg.norm(found.rate), np.linalg.norm(step.rate)
        cosine = float(found.rate @ np.array(step.rate)) / max(size * wanted, 1e-300)
        cost += 0.45 * (1 - cosine) + min(0.6, 2 * abs(float(np.log(max(size, 1e-12) / wanted))))
    elif step.up is not None and found.force is not None:
        cost += 0.45 * (1 - _cosine(found.force, step.up))
    return cost


def _cosine(a: Any, b: Any) -> float:
    size = np.linalg.norm(a) * np.linalg.norm(b)
    return float(np.dot(a, b) / size) if size > 0 else 0.0


def _against_plan(found: Sequence[FoundSegment], expected: Sequence[Step], pairs: list) -> list[Finding]:
    """What was not done as planned."""
    done = {j for _, j in pairs}
    missing = [step.label for j, step in enumerate(expected) if j not in done]
    findings = []
    if missing:
        named = ", ".join(map(repr, missing[:5])) + (", ..." if len(missing) > 5 else "")
        text = f"{len(missing)} of {len(expected)} steps of the plan were not found: {named}"
        findings.append(Finding(check="plan", severity="bad", text=text, count=len(missing)))
    for i, j in pairs:
        f, e = found[i], expected[j]
        if f.duration < 0.9 * e.duration - 2 * WINDOW:
            text = f"step {e.label!r} lasts {f.duration:.6g} s, planned were {e.duration:.6g} s"
            findings.append(Finding(check="plan", severity="doubtful", text=text, time=f.begin))
        if f.duration > LONGEST * e.duration + 2 * WINDOW:
            text = f"step {e.label!r} lasts {f.duration:.6g} s, planned were {e.duration:.6g} s: is its clock right?"
            findings.append(Finding(check="plan", severity="doubtful", text=text, time=f.begin))
    findings = summary("plan", findings, f"all {len(expected)} steps of the plan were found")
    return [
        *findings,
        *_axes(found, expected, pairs),
        *_rates(found, expected, pairs),
        *_clock(found, expected, pairs),
    ]


def _axes(found: Sequence[FoundSegment], expected: Sequence[Step], pairs: list) -> list[Finding]:
    """Whether axes are those of the plan: for all steps together, then one by one."""
    sensors: dict[str, list[tuple[Array, Array, str, float]]] = {"gyro": [], "accel": []}
    for i, j in pairs:
        f, e = found[i], expected[j]
        if e.turns:
            sensors["gyro"].append((f.rate / np.linalg.norm(f.rate), _unit(e.rate), e.label, f.begin))
        upright = not e.turns or (e.up is not None and abs(_cosine(e.rate, e.up)) > 0.99)
        if upright and e.up is not None and f.force is not None and np.any(f.force):
            sensors["accel"].append((f.force / np.linalg.norm(f.force), _unit(e.up), e.label, f.begin))
    findings = []
    for sensor, rows in sensors.items():
        if not rows:
            continue
        seen, planned = np.array([r[0] for r in rows]), np.array([r[1] for r in rows])
        cosines = (seen * planned).sum(axis=1)
        if (cosines >= AGREES).all():
            continue
        scores = [float(((seen @ P.T) * planned).sum(axis=1).min()) for P in SIGNED_PERMUTATIONS]
        best = int(np.argmax(scores))
        if scores[best] >= AGREES and np.count_nonzero(cosines < AGREES) > 1:
            P = SIGNED_PERMUTATIONS[best]
            names = [("-" if row.sum() < 0 else "") + "xyz"[int(np.argmax(np.abs(row)))] for row in P]
            text = f"axes do not fit the plan: what the plan calls x, y, z is recorded as {', '.join(names)}"
            findings.append(Finding(check="axes", severity="bad", text=text, channel=sensor, count=len(rows)))
            continue
        for cosine, (vector, wanted, label, begin) in zip(cosines, rows, strict=True):
            if cosine < AGREES:
                word = "turns about" if sensor == "gyro" else "has up along"
                text = f"step {label!r} {word} {_axis(vector)}, planned was {_axis(wanted)}"
                findings.append(Finding(check="axes", severity="bad", text=text, channel=sensor, time=begin, count=1))
    return summary("axes", findings, "axes are those of the plan")


def _rates(found: Sequence[FoundSegment], expected: Sequence[Step], pairs: list) -> list[Finding]:
    """Whether planned rates are read, and the times between turns are those of the plan."""
    rows = [(found[i], expected[j]) for i, j in pairs if expected[j].turns]
    if not rows:
        return []
    ratios = np.array([np.linalg.norm(f.rate) / np.linalg.norm(e.rate) for f, e in rows])
    ratio = float(np.median(ratios))
    text = f"turns read {ratio:.5g} times the planned rate"
    if 0.9 < ratio < 1.1:
        return [Finding(check="rates", severity="good", text=text, factor=ratio)]
    text += ": a unit, a scale factor or the clock is wrong"
    return [Finding(check="rates", severity="bad", text=text, factor=ratio)]


def _clock(found: Sequence[FoundSegment], expected: Sequence[Step], pairs: list) -> list[Finding]:
    """Drift of the clock against the plan, where steps followed one another without pauses."""
    if len(pairs) < max(4, len(expected)):
        return []
    order = [found[i] for i, _ in pairs]
    if max(b.begin - a.end for a, b in pairwise(order)) > 3 * WINDOW:
        return []  # there were pauses: the plan says nothing of the clock
    ends = np.cumsum([e.duration for e in expected])
    planned = ends - 0.5 * np.array([e.duration for e in expected])
    seen = np.array([0.5 * (found[i].begin + found[i].end) for i, _ in pairs])
    x, y = planned - planned.mean(), seen - seen.mean()
    slope = float(x @ y / (x @ x))
    scatter = float(np.sqrt(np.sum((y - slope * x) ** 2) / (len(x) - 2)))
    if scatter > WINDOW or abs(slope - 1) > 0.1:
        return []
    deviation = max(scatter, WINDOW / np.sqrt(12)) / float(np.sqrt(x @ x))
    text = f"the clock runs {slope:.6f} times as fast as the plan, standard deviation {deviation:.1g}"
    severity = "doubtful" if abs(slope - 1) > max(CLOCK_DRIFT, 4 * deviation) else "good"
    return [Finding(check="clock drift", severity=severity, text=text, factor=slope)]


def _unit(vector: Any) -> Array:
    return np.array(vector, dtype=float) / np.linalg.norm(vector)


def _axis(vector: Array) -> str:
    """Nearest axis by name, or the direction."""
    i = int(np.argmax(np.abs(vector)))
    if abs(vector[i]) > 0.9 * np.linalg.norm(vector):
        return ("-" if vector[i] < 0 else "") + "xyz"[i]
    return "({:.2f}, {:.2f}, {:.2f})".format(*vector)
