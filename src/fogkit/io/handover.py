"""From a segmented recording to what each calibration takes.

===========================  ============================================================================
calibration                  takes
===========================  ============================================================================
three stages                 `bench_record`: mean readings, and angles of the table's readout
many positions, rates        `placed`: the table with labels of positions, and its schedule
by navigation                `turn_tables`: increments of each test, and its plan
scan, gyrocompass            `dwell_means`: mean readings at each angle
===========================  ============================================================================
"""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.imu.tables import ACCEL_COLUMNS, GYRO_COLUMNS
from fogkit.io.errors import RecordingError
from fogkit.io.recordings import Recording
from fogkit.io.segmentation import FoundSegment, Segmentation
from fogkit.stand.bench import BenchRecord
from fogkit.stand.placements import Schedule
from fogkit.stand.plans import Plan
from fogkit.stand.turn_tests import TurnTest

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]


def placed(recording: Recording, segmentation: Segmentation, schedule: Schedule) -> tuple["DataFrame", Schedule]:
    """Table with labels of positions, for `fogkit.stand.observations`, and the schedule as it was carried out.

    Parameters
    ----------
    recording : Recording
        The recording, or one reduced from it.
    segmentation : Segmentation
        Its segments, named by the schedule.
    schedule : Schedule
        What was planned.

    Returns
    -------
    table : pandas.DataFrame
        Readings with the column ``position``; None between positions. Where a position lasted longer than planned, the
        middle of it is taken.
    schedule : Schedule
        The placements with the durations that they have in the table.

    Raises
    ------
    RecordingError
        If a placement was not found, or accelerometers were not recorded.
    """
    checks.instance("schedule", schedule, Schedule)
    if not recording.has_accelerometers:
        raise RecordingError("a calibration in positions needs accelerometers, got a recording of gyros only")
    labels = np.full(len(recording.table), None, dtype=object)
    done = []
    for placement, segment in zip(schedule.placements, _named(segmentation, schedule.labels), strict=True):
        first, last = _samples(recording, segmentation, segment, placement.duration)
        labels[first:last] = placement.label
        done.append(replace(placement, duration=(last - first) * recording.dt))
    table = recording.table[[*GYRO_COLUMNS, *ACCEL_COLUMNS]].assign(position=labels)
    return table, Schedule(done)


def bench_record(recording: Recording, segmentation: Segmentation, plan: Plan) -> BenchRecord:
    """Mean readings and angles of a plan on a three-axis table, for `fogkit.calibration.three_stage`.

    Parameters
    ----------
    recording : Recording
        With the table's readout as the column ``angle``, whole turns included.
    segmentation : Segmentation
        Its segments, named by the plan.
    plan : Plan
        What was planned.

    Returns
    -------
    BenchRecord
        Of a plan with durations and rates as they were. Readings of turns are cut to whole turns by the readout; angles
        at the ends of samples are interpolated linearly, exact at a constant rate.

    Raises
    ------
    RecordingError
        If a step was not found, no angle or no latitude was recorded, or a turn holds no whole one.
    """
    checks.instance("plan", plan, Plan)
    if "angle" not in recording.table:
        raise RecordingError("a calibration in three stages needs the angle of the table: describe its column")
    if recording.description.latitude is None:
        raise RecordingError("a calibration in three stages needs the latitude: give it in [place]")
    gyro = recording.table[list(GYRO_COLUMNS)].to_numpy()
    angle = recording.table["angle"].to_numpy()
    segments, readings, turned = [], [], []
    for step, found in zip(plan.segments, _named(segmentation, [s.label for s in plan.segments]), strict=True):
        first, last = _samples(recording, segmentation, found, step.duration)
        if step.turning is not None:
            last = _whole_turns(angle, first, last, step.label)
        readings.append(gyro[first:last].mean(axis=0))
        duration = (last - first) * recording.dt
        way = angle[min(last, len(angle) - 1)] - angle[first] if step.turning is not None else 0.0
        turned.append(way)
        rate = way / duration if step.turning is not None else 0.0
        segments.append(replace(step, duration=duration, rate=rate))
    return BenchRecord(
        plan=Plan(plan.construction, segments),
        latitude=recording.description.latitude,
        readings=np.array(readings),
        turned=np.array(turned),
    )


def turn_tables(recording: Recording, segmentation: Segmentation, plan: tuple[TurnTest, ...]) -> list["DataFrame"]:
    """Increments of each test of a plan, time from its beginning, for `fogkit.calibration.navigation_based`.

    Parameters
    ----------
    recording : Recording
        All tests one after the other.
    segmentation : Segmentation
        Its segments, named by the plan.
    plan : tuple of TurnTest
        The tests.

    Returns
    -------
    list of pandas.DataFrame
        One for each test, as long as it: the middle of the turn found is that of the turn planned.

    Raises
    ------
    RecordingError
        If a turn was not found, accelerometers were not recorded, or the recording does not reach from the beginning to
        the end of a test.
    """
    if not recording.has_accelerometers:
        raise RecordingError("a calibration by navigation needs accelerometers, got a recording of gyros only")
    increments = recording.increments()
    time = recording.table.index.to_numpy(dtype=float)
    tables = []
    for test, found in zip(plan, _named(segmentation, [f"{test.label} turn" for test in plan]), strict=True):
        middle = _middle_of_turn(recording, found, test)
        begin = middle - 0.5 * test.turn_duration - test.dwell
        first, count = int(np.searchsorted(time, begin - 0.5 * recording.dt)), round(test.duration / recording.dt)
        if first + count > len(time) + 1 or (first == 0 and time[0] > begin + 2 * recording.dt):
            raise RecordingError(f"test {test.label!r} is not whole in the recording: a dwell is cut short")
        first = min(first, len(time) - count)
        table = increments.iloc[first : first + count].copy()
        table.index = table.index - table.index[0]
        tables.append(table)
    return tables


def dwell_means(recording: Recording, segmentation: Segmentation) -> "DataFrame":
    """Mean readings of each dwell, index ``step``: begin and duration, s, then every column's mean, SI."""
    import pandas as pd

    time = recording.table.index.to_numpy(dtype=float)
    numbers = [c for c in recording.table.columns if c != "position"]
    rows, names = [], []
    for segment in segmentation.segments:
        if segment.kind == "dwell" and (segment.label or not segmentation.steps):
            first, last = _samples(recording, segmentation, segment, segment.duration)
            means = recording.table[numbers].iloc[first:last].mean()
            rows.append({"begin": float(time[first]), "duration": (last - first) * recording.dt, **means})
            names.append(segment.label)
    return pd.DataFrame(rows, index=pd.Index(names, name="step"))


def _named(segmentation: Segmentation, labels: list[str]) -> list[FoundSegment]:
    """Segments of labels; `RecordingError` for one that was not found."""
    checks.instance("segmentation", segmentation, Segmentation)
    found = segmentation.labelled()
    for label in labels:
        if label not in found:
            raise RecordingError(f"step {label!r} of the plan was not found in the recording")
    return [found[label] for label in labels]


def _samples(
    recording: Recording, segmentation: Segmentation, segment: FoundSegment, planned: float
) -> tuple[int, int]:
    """First sample of a segment and the one after the last: its middle, as long as planned if it is that long.

    A window at each end is left out where limits were found and not given: part of it may be motion.
    """
    time, dt = recording.table.index.to_numpy(dtype=float), recording.dt
    spare = max(0.0, segment.duration - planned) / 2
    if not segmentation.exact:
        spare = max(spare, segmentation.windows.duration)
    first = int(np.searchsorted(time, segment.begin + spare - 1e-6 * dt))
    last = int(np.searchsorted(time, segment.end - spare - dt + 1e-6 * dt, side="right"))
    if last - first < 2:
        raise RecordingError(f"step {segment.label!r} has fewer than 2 samples at this rate")
    return first, last


def _whole_turns(angle: Array, first: int, last: int, label: str) -> int:
    """Sample at which the last whole turn from the first sample on is nearest to complete."""
    way = angle[first:last] - angle[first]
    count = int(np.floor(np.abs(way[-1]) / (2 * np.pi) + 0.01))
    if count < 1:
        raise RecordingError(f"step {label!r} has no whole turn by the angle of the table")
    return first + int(np.argmin(np.abs(np.abs(way) - count * 2 * np.pi)))


def _middle_of_turn(recording: Recording, found: FoundSegment, test: TurnTest) -> float:
    """Time at which half of the turn is done, s."""
    time = recording.table.index.to_numpy(dtype=float)
    margin = 0.5 * test.turn_duration
    first, last = np.searchsorted(time, [found.begin - margin, found.end + margin])
    along = recording.table[list(GYRO_COLUMNS)].to_numpy()[first:last] @ test.axis
    along = np.where(np.abs(along) > 0.1 * np.linalg.norm(found.rate), along, 0.0)  # ramps in, drifts out
    done = np.cumsum(along)
    half = int(np.searchsorted(np.abs(done), 0.5 * np.abs(done[-1])))
    share = (0.5 * done[-1] - (done[half] - along[half])) / along[half]  # of the sample in which it is reached
    return float(time[first + half] + share * recording.dt)
