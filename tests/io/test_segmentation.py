"""Dwells and turns of every plan, and what was not done as planned; then what calibrations take of it."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pytest
from iorecordings import ACCELEROMETERS, LATITUDE, UNIT, in_laboratory, moved, on_mount, on_rate_table, table_of
from numpy.testing import assert_allclose

from fogkit import io
from fogkit.calibration import multiposition, three_stage
from fogkit.constants import EARTH_RATE
from fogkit.io.recordings import Recording
from fogkit.stand import Laboratory, RoughTable, nine_tests, observations, turn_recordings
from fogkit.units import DEG_PER_HOUR


def recording(table, plan=None):
    description = io.describe(table, "d.csv", latitude=LATITUDE, plan=plan)
    return Recording(table=table, description=description, dt=float(table.index[1] - table.index[0]))


SCHEDULES = {
    "six-positions": {"duration": 10.0},
    "full-turns": {"rate": 20.0, "rate_unit": "deg/s"},
    "rate-sequence": {"duration": 10.0, "rates": [0.0, 0.1, -0.1, 30.0, -30.0], "rate_unit": "deg/s"},
}


@pytest.mark.parametrize("kind", SCHEDULES)
def test_schedules_without_labels(kind):
    table, plan = in_laboratory(kind, **SCHEDULES[kind])
    found = io.segment(recording(table.drop(columns="position"), plan))
    placements = plan.build().placements
    assert [s.label for s in found.segments] == [p.label for p in placements]
    assert found.verdict.severity == "good"
    begin = np.cumsum([0, *(p.duration for p in placements[:-1])])
    assert_allclose([s.begin for s in found.segments], begin, atol=0.5)  # one window
    for s, p in zip(found.segments, placements, strict=True):
        assert np.linalg.norm(s.rate) == pytest.approx(abs(p.rate), abs=2 * EARTH_RATE)


def test_labels_are_taken_where_there_are_some():
    table, plan = in_laboratory("twenty-four-points", duration=4.0)
    found = io.segment(recording(table, plan))
    assert found.exact and found.verdict.severity == "good"
    assert [s.label for s in found.segments] == plan.build().labels
    assert_allclose([s.duration for s in found.segments], 4.0, rtol=1e-12)


def with_pauses(table, durations, rng):
    """Placements with half a minute of handling between two."""
    parts, first = [], 0
    for duration in durations:
        count = round(duration * 20)
        parts.append(table.iloc[first : first + count, :6].to_numpy())
        handled, _ = moved(np.eye(3), [0.2, 0.3, 0.1], 3.0, 0.05, rng)
        handled[:, :3] *= np.sin(np.linspace(0, np.pi, len(handled)))[:, None]
        rest, _ = moved(np.eye(3), [0.0, 0.0, 0.0], 4.0, 0.05, rng)
        parts += [handled, rest, handled]
        first += count
    return table_of(parts, 0.05)


def test_pauses_that_the_plan_does_not_have_are_passed_over():
    rng = np.random.default_rng(2)
    table, plan = in_laboratory("six-positions", duration=20.0)
    found = io.segment(recording(with_pauses(table, [20.0] * 6, rng), plan))
    assert [s.label for s in found.segments if s.label] == list("123456")
    assert found.verdict.severity == "good"


def test_a_step_left_out_is_named():
    table, plan = in_laboratory("six-positions", duration=10.0)
    table = table[table["position"] != "4"].drop(columns="position")
    found = io.segment(recording(table_of([table.to_numpy()], 0.05), plan))
    assert found.verdict.severity == "bad"
    assert "1 of 6 steps of the plan were not found: '4'" in found.verdict.of("plan")[0].text


def test_a_position_with_another_axis_up_is_named():
    table, plan = in_laboratory("six-positions", duration=10.0)
    swapped = table.drop(columns="position").copy()
    rows = (table["position"] == "3").to_numpy()
    swapped.loc[rows, ["accel_x", "accel_y"]] = table.loc[rows, ["accel_y", "accel_x"]].to_numpy()
    (finding,) = [f for f in io.segment(recording(swapped, plan)).verdict.of("axes") if f.severity == "bad"]
    assert finding.text == "step '3' has up along x, planned was y"


@pytest.mark.parametrize("kind", ["six-positions", "full-turns"])
def test_axes_swapped_throughout_are_named(kind):
    table, plan = in_laboratory(kind, **SCHEDULES[kind])
    sensor = "accel" if kind == "six-positions" else "gyro"
    swapped = table.drop(columns="position")
    x, y = swapped[f"{sensor}_x"].copy(), swapped[f"{sensor}_y"].copy()
    swapped = swapped.assign(**{f"{sensor}_x": -y, f"{sensor}_y": x})
    (finding,) = [f for f in io.segment(recording(swapped, plan)).verdict.of("axes") if f.channel == sensor]
    assert finding.severity == "bad" and "what the plan calls x, y, z is recorded as y, -x, z" in finding.text


def test_rates_that_are_not_those_of_the_plan():
    table, plan = in_laboratory("full-turns", **SCHEDULES["full-turns"])
    table = table.drop(columns="position")
    table[["gyro_x", "gyro_y", "gyro_z"]] *= 1.5
    (finding,) = io.segment(recording(table, plan)).verdict.of("rates")
    assert finding.severity == "bad" and finding.factor == pytest.approx(1.5, rel=1e-3)


def test_three_stages_from_the_table_to_the_calibration():
    rng = np.random.default_rng(3)
    parameters = {"bias_duration": 30.0, "rates": [36.0, -36.0], "rate_unit": "deg/s", "count": 3}
    plan = io.PlanReference(kind="three-stage", parameters=parameters)
    source = recording(on_rate_table(plan.build(), 0.02, rng), plan)
    found = io.segment(source)
    assert found.verdict.severity == "good", found.verdict
    record = io.bench_record(source, found, plan.build())
    assert_allclose(np.abs(record.turned[4:]), 4 * np.pi, atol=0.02 * 0.63)  # two whole turns are left, to a sample
    result = three_stage.calibrate(record)
    bias = np.array([1.0, -2.0, 0.5]) * DEG_PER_HOUR
    assert_allclose(result.estimate[:3], bias, atol=5 * 1e-6 / np.sqrt(4 * 29 * 50))  # 5 deviations of the mean
    assert_allclose(result.estimate[3:9], 1, atol=1e-6)  # Earth rate across the axis in half a sample


def test_nine_tests_are_cut_out_to_the_sample():
    rng = np.random.default_rng(4)
    plan = io.PlanReference(kind="nine-tests", parameters={"turns": 1, "dwell": 5.0, "turn_duration": 6.0})
    tables = turn_recordings.record(UNIT, RoughTable.typical(LATITUDE).motions(plan.build(), rng), rng=rng)
    parts = []
    for i, table in enumerate(tables):
        parts.append(table.to_numpy() / 0.01)
        if i in (2, 5):  # the unit is set up anew
            handled, _ = moved(np.eye(3), [0.0, 0.5, 0.1], 3.0, 0.01, rng)
            handled[:, :3] *= np.sin(np.linspace(0, np.pi, len(handled)))[:, None]
            parts.append(handled)
    source = recording(table_of(parts, 0.01), plan)
    found = io.segment(source)
    assert found.verdict.severity == "good" and sum(s.label.endswith("turn") for s in found.segments) == 9
    cut = io.turn_tables(source, found, plan.build())
    for ours, theirs in zip(cut, tables, strict=True):
        assert len(ours) == len(theirs) and ours.index[0] == 0
        assert_allclose(ours, theirs, rtol=1e-12, atol=1e-15)


def test_a_scan_gives_the_earth_rate_at_its_angles():
    parameters = {"start": "ENU", "axis": "z", "angles": [0, 90, 180, 270], "angle_unit": "deg"}
    plan = io.PlanReference(kind="gyrocompass", parameters={**parameters, "dwell": 30.0, "turn_duration": 4.0})
    source = recording(on_mount(plan.build(), 0.02, np.random.default_rng(5)), plan)
    found = io.segment(source)
    assert found.verdict.severity == "good"
    means = io.dwell_means(source, found)
    assert means.index.tolist() == ["dwell 1", "dwell 2", "dwell 3", "dwell 4"]
    level = EARTH_RATE * np.cos(LATITUDE)
    difference = (means["gyro_y"].iloc[0] - means["gyro_y"].iloc[2]) / 2
    assert difference == pytest.approx(level, abs=5 * 1e-6 / np.sqrt(29 * 50))


def test_positions_from_the_file_to_the_calibration(tmp_path):
    table, plan = in_laboratory("six-positions", duration=60.0)
    description = io.describe(table.drop(columns="position"), "d.parquet", latitude=LATITUDE, plan=plan)
    path = io.write(table, description, tmp_path / "recording.toml")
    seen = io.survey(path, reduced_rate=2.0)
    observed = observations(*io.placed(seen.reduced, seen.segmentation, plan.build()), Laboratory(latitude=LATITUDE))
    result = multiposition.calibrate_accelerometers(observed)
    direct = multiposition.calibrate_accelerometers(observations(table, plan.build(), Laboratory(latitude=LATITUDE)))
    # the same samples but one window at each end of each position: noise of 1e-4 / sqrt(1 s) in each
    assert_allclose(result.triad.bias, direct.triad.bias, atol=5 * 1e-4 / 60)
    assert_allclose(direct.triad.bias, ACCELEROMETERS.bias, atol=5 * 1e-4 / np.sqrt(120))


def test_the_drawing_shows_every_step():
    table, plan = in_laboratory("full-turns", **SCHEDULES["full-turns"])
    found = io.segment(recording(table.drop(columns="position"), plan))
    figure, ax = plt.subplots()
    assert found.draw(ax) is ax
    assert [t.get_text() for t in ax.texts] == plan.build().labels
    plt.close(figure)
    assert found.to_frame().shape == (6, 10)
    assert repr(found) == "<Segmentation: 0 dwells, 6 turns, 6 of 6 steps of the plan; good>"


def test_what_is_missing_is_said():
    table, plan = in_laboratory("six-positions", duration=10.0)
    table = table.drop(columns="position")
    source = recording(table, plan)
    found = io.segment(source)
    with pytest.raises(io.RecordingError, match=r"step '1\.1' of the plan was not found"):
        io.placed(source, found, io.PlanReference(kind="twenty-four-points").build())
    with pytest.raises(io.RecordingError, match="needs the angle of the table"):
        io.bench_record(source, found, io.PlanReference(kind="three-stage").build())
    gyros = recording(table[["gyro_x", "gyro_y", "gyro_z"]])
    with pytest.raises(io.RecordingError, match="needs accelerometers"):
        io.turn_tables(gyros, io.segment(gyros), nine_tests())
