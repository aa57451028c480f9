"""One pass over a long recording gives what the whole of it in memory gives, in less memory."""

import tracemalloc

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fogkit import io
from fogkit.imu.tables import IMU_COLUMNS
from fogkit.io.streams import SHORT, STRIDE
from fogkit.noise import RandomErrors, allan_deviation, simulate
from fogkit.units import DEG_PER_HOUR


@pytest.fixture(scope="module")
def long(tmp_path_factory):
    """Recording of 200 000 samples with a white and a wandering part."""
    rng = np.random.default_rng(1)
    errors = RandomErrors(angle_random_walk=1e-6, rate_random_walk=1e-8)
    values = np.column_stack([simulate(errors, 200_000, 0.01, rng) for _ in range(6)])
    values += [3e-5, 2e-5, 6e-5, 0.0, 0.0, 9.81]
    table = pd.DataFrame(values, index=pd.Index(np.arange(len(values)) * 0.01, name="time"), columns=list(IMU_COLUMNS))
    path = tmp_path_factory.mktemp("long") / "recording.toml"
    return io.write(table, io.describe(table, "d.parquet", latitude=1.0), path), table


def test_reduction_is_the_sum_of_increments_over_their_time(long):
    path, table = long
    seen = io.survey(path, reduced_rate=4.0, rows=777)
    sums = (table * 0.01).to_numpy().reshape(-1, 25, 6).sum(axis=1)
    assert_allclose(seen.reduced.table.to_numpy() * 0.25, sums, rtol=1e-12, atol=1e-18)
    assert_allclose(seen.reduced.table.index, np.arange(8000) * 0.25, atol=1e-9)
    whole = io.reduce(io.read(path), 4.0)
    assert_array_equal(whole.table, seen.reduced.table)
    assert seen.count == 200_000 and seen.dt == pytest.approx(0.01)


@pytest.mark.parametrize("rows", [1000, 65_537])
def test_allan_deviation_of_pieces(long, rows):
    path, table = long
    ours = io.survey(path, allan=True, rows=rows).allan
    theirs = allan_deviation(table.iloc[:, :3])
    assert_array_equal(ours.factors, theirs.factors)
    short = ours.factors <= SHORT
    # every second difference is there: rounding of a running angle
    assert_allclose(ours.deviation[short], theirs.deviation[short], rtol=1e-9)
    # beyond, one in STRIDE: the difference is a small part of the deviation's own scatter
    scatter = 1 / np.sqrt(2 * theirs.degrees_of_freedom()[~short])
    assert (np.abs(ours.deviation[~short] / theirs.deviation[~short] - 1) < 0.5 * scatter).all()
    assert (~short).sum() >= 5 and STRIDE < SHORT


def test_memory_stays_that_of_a_block(long, monkeypatch, tmp_path):
    path, table = long
    monkeypatch.setattr("fogkit.io.recordings.FIRST", 5000)
    monkeypatch.setattr("fogkit.io.writing.ROWS", 5000)  # a group of rows is read whole
    path = io.write(table, io.read_description(path), tmp_path / "recording.toml")
    io.survey(path, rows=5000)  # compiled and imported
    tracemalloc.start()
    io.survey(path, rows=5000, allan=True)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    # a block of 5000 rows is 0.3 MB, the tails of the Allan sums 0.05 MB, windows 0.3 MB; all rows are 11 MB
    assert peak < 0.4 * table.memory_usage().sum()


def test_an_allan_deviation_needs_a_whole_recording(long, tmp_path):
    _, table = long
    for name, change, words in (
        ("gap", lambda t: t.drop(t.index[3000:3005]), "has 1 gaps"),
        (
            "missing",
            lambda t: t.assign(gyro_x=t["gyro_x"].where(t.index != t.index[7])),
            "missing, infinite or impossible",
        ),
        ("frozen", lambda t: t.assign(gyro_y=DEG_PER_HOUR), "frozen gyro_y"),
    ):
        spoiled = change(table.iloc[:10_000].copy())
        path = io.write(spoiled, io.describe(spoiled, "d.parquet"), tmp_path / name / "recording.toml")
        with pytest.raises(io.RecordingError, match=words):
            io.survey(path, allan=True)


def test_what_a_gap_costs_is_said(long, tmp_path):
    _, table = long
    spoiled = table.iloc[:10_000].drop(table.index[3030:3040])
    path = io.write(spoiled, io.describe(spoiled, "d.parquet"), tmp_path / "recording.toml")
    # 30 samples before the gap and 60 at the end fill no mean of 100
    with pytest.warns(UserWarning, match=r"90 samples of d\.parquet before 1 gaps and at the end"):
        seen = io.survey(path, reduced_rate=1.0)
    assert len(seen.reduced.table) == 99
    assert_allclose(seen.reduced.table.iloc[30], table.iloc[3040:3140].mean(), rtol=1e-9)
    assert seen.verdict.of("gaps")[0].severity == "bad"


def test_progress_is_shown(long, capsys):
    io.survey(long[0], progress="reading")
    assert "reading" in capsys.readouterr().err
