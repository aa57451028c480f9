"""Each defect that is planted is found and named; a sound recording is called good."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from iorecordings import LATITUDE, in_laboratory

from fogkit import io
from fogkit.io.recordings import Recording
from fogkit.units import DEG, DEG_PER_HOUR


@pytest.fixture(scope="module")
def sound():
    table, plan = in_laboratory("six-positions", duration=20.0)
    return table.drop(columns="position"), plan


def recording(table, plan=None, **more):
    description = io.describe(table, "d.csv", latitude=LATITUDE, plan=plan, **more)
    steps = np.diff(table.index)
    return Recording(table=table, description=description, dt=float(np.median(steps)))


def verdict(sound, change=None, **more):
    table, plan = sound
    table = table.copy()
    return io.check(recording(table if change is None else change(table), plan, **more))


def test_a_sound_recording_is_good(sound):
    found = verdict(sound)
    assert found.severity == "good" and found.to_frame()["severity"].eq("good").all()
    assert repr(found).startswith("good: ")
    found.require_usable()


def spoiled(column, rows, value):
    def change(table):
        table.iloc[rows, table.columns.get_loc(column)] = value
        return table

    return change


def clipped(table):
    edge = table["gyro_z"].quantile(0.9)
    return table.assign(gyro_z=table["gyro_z"].clip(upper=edge))


def stepped(table):
    level = np.where(table.index > 50, 50 * DEG_PER_HOUR, 0.0)  # in the middle of a dwell
    return table.assign(gyro_x=table["gyro_x"] + level)


def stuttering(table):
    rows = np.sort(np.append(np.arange(len(table)), np.arange(0, len(table), 10)))
    out = table.iloc[rows]
    out.index = pd.Index(np.arange(len(out)) * 0.05, name="time")
    return out


def at(index):
    return lambda table: table.set_axis(pd.Index(index(table.index.to_numpy()), name="time"))


JITTERED = np.random.default_rng(5).uniform(-0.015, 0.015, 2400)


@pytest.mark.parametrize(
    ("change", "check", "channel", "severity", "words"),
    [
        (lambda t: t.drop(t.index[500:510]), "gaps", "", "bad", "1 gaps with some 10 samples lost"),
        (at(lambda t: np.where(np.arange(len(t)) == 100, t[99], t)), "time", "", "bad", "do not advance"),
        (at(lambda t: t + JITTERED), "jitter", "", "doubtful", "scatter by"),
        (at(lambda t: t + 1e14), "time", "", "doubtful", "resolve only"),
        (spoiled("accel_y", [7, 9], np.nan), "missing", "accel_y", "bad", "2 numbers are missing or infinite"),
        (spoiled("accel_y", [7], 1e30), "range", "accel_y", "bad", "beyond any sensor"),
        (spoiled("gyro_x", [700], 1.0), "spikes", "gyro_x", "doubtful", "1 samples leap"),
        (spoiled("gyro_x", [0], 1.0), "spikes", "gyro_x", "doubtful", "1 samples leap"),
        (spoiled("gyro_x", [2399], 1.0), "spikes", "gyro_x", "doubtful", "its last sample leaps"),
        (spoiled("gyro_y", slice(600, 640), 1e-5), "frozen", "gyro_y", "bad", "stands still for 2 s"),
        (spoiled("gyro_y", slice(None), 1e-5), "frozen", "gyro_y", "bad", "in all 2400 samples"),
        (clipped, "clipped", "gyro_z", "bad", "240 samples stand"),
        (stepped, "steps", "gyro_x", "doubtful", "its level changes by 0.00024"),
        (stuttering, "repeats", "", "doubtful", "9.1% of the rows repeat"),
    ],
)
def test_a_planted_defect_is_named(sound, change, check, channel, severity, words):
    found = verdict(sound, change).of(check)
    assert any(f.channel == channel and f.severity == severity and words in f.text for f in found), found


def test_a_bad_recording_may_not_be_used(sound):
    with pytest.raises(io.RecordingError, match="not usable, missing of gyro_x: 1 numbers"):
        verdict(sound, spoiled("gyro_x", [5], np.inf)).require_usable()


@pytest.mark.parametrize("drift", [0.0, 2e-5, 5e-4])
def test_drift_against_a_second_clock(sound, drift):
    found = verdict(sound, lambda t: t.assign(clock=100 + t.index * (1 + drift))).of("clock drift")
    against = next(f for f in found if "second clock" in f.text)
    assert against.factor == pytest.approx(1 + drift, abs=1e-9)
    assert against.severity == ("doubtful" if drift > 1e-4 else "good")


def test_drift_against_the_plan(sound):
    slow = verdict(sound, at(lambda t: t * 1.02)).of("clock drift")
    assert any(f.severity == "doubtful" and f.factor == pytest.approx(1.02, abs=5e-3) for f in slow)


def test_counts_in_pulses_are_neither_frozen_nor_clipped(sound):
    # 2 levels or 3 in each dwell: equal readings follow one another all the time
    def counted(table):
        pulse = np.array([2e-5] * 3 + [0.01] * 3)
        return (table / pulse).round() * pulse

    found = verdict(sound, counted)
    assert not [f for f in (*found.of("frozen"), *found.of("clipped"), *found.of("spikes")) if f.severity == "bad"]


@pytest.mark.parametrize("rows", [1, 37, 1000])
def test_the_verdict_does_not_depend_on_the_blocks(sound, rows, tmp_path, monkeypatch):
    monkeypatch.setattr("fogkit.io.recordings.FIRST", 600)
    table, plan = sound
    table = spoiled("gyro_y", slice(600, 640), 1e-5)(table.copy())
    path = io.write(table, io.describe(table, "d.npz", latitude=LATITUDE, plan=plan), tmp_path / "recording.toml")
    whole, pieces = io.check(io.read(path)), io.survey(path, rows=rows).verdict
    assert [(f.check, f.severity, f.channel, f.count) for f in whole.findings] == [
        (f.check, f.severity, f.channel, f.count) for f in pieces.findings
    ]


def wrong_units(sound, gyro=("rad/s", "rates"), accel=("m/s^2", "rates")):
    """Verdict on the units where the file holds SI rates and the description says something else."""
    table, _ = sound
    source = recording(table)
    description = replace(
        source.description,
        gyro=io.Channels(columns=("gyro_x", "gyro_y", "gyro_z"), unit=gyro[0], quantity=gyro[1]),
        accel=io.Channels(columns=("accel_x", "accel_y", "accel_z"), unit=accel[0], quantity=accel[1]),
    )
    values = table.copy()
    for name, (_, factor, _) in description.sources(source.dt).items():
        values[name] = table[name] * factor
    return io.check_units(Recording(table=values, description=description, dt=source.dt))


@pytest.mark.parametrize(
    ("kind", "said", "factor", "words"),
    [
        ("accel", ("g", "rates"), 9.80665, "m/s^2 taken for g, a factor of 9.807"),
        ("accel", ("mg", "rates"), 9.80665e-3, "m/s^2 taken for mg"),
        ("accel", ("m/s", "increments"), 20.0, "rates (m/s^2) taken for increments (m/s) at 20 Hz, a factor of 20"),
        ("gyro", ("deg/s", "rates"), DEG, "rad/s taken for deg/s, a factor of 0.01745"),
        ("gyro", ("rev/s", "rates"), 2 * np.pi, "rad/s taken for rev/s, a factor of 6.283"),
        ("gyro", ("rad", "increments"), 20.0, "rates (rad/s) taken for increments (rad) at 20 Hz, a factor of 20"),
    ],
)
def test_a_wrong_unit_is_named_with_its_factor(sound, kind, said, factor, words):
    found = wrong_units(sound, **{kind: said})
    (finding,) = [f for f in found.of("units") if f.channel == kind]
    assert finding.severity != "good" and words in finding.text
    # biases of 2 deg/h beside 15 deg/h of Earth rate, and of 3 mg beside gravity
    assert finding.factor == pytest.approx(factor, rel=0.15 if kind == "gyro" else 5e-3)


def test_right_units_are_good(sound):
    assert wrong_units(sound).severity == "good"


def test_a_large_drift_is_told_from_a_unit(sound):
    table, _ = sound
    found = io.check_units(recording(table.assign(gyro_x=table["gyro_x"] + 400 * DEG_PER_HOUR)))
    (finding,) = [f for f in found.of("units") if f.channel == "gyro"]
    assert finding.severity == "doubtful" and "a drift of 40" in finding.text


def test_axes_that_the_earth_contradicts(sound):
    table, plan = sound
    swapped = table.rename(columns={"gyro_x": "gyro_y", "gyro_y": "gyro_x"})[list(table.columns)]
    found = io.check(recording(swapped, plan)).of("axes")
    assert any("x, y, z are recorded as y, x, z" in f.text for f in found)
