"""Files of every kind give the one table, whole or in pieces; broken ones give one sentence."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from iorecordings import in_laboratory
from numpy.testing import assert_allclose, assert_array_equal

from fogkit import io
from fogkit.io.recordings import blocks


@pytest.fixture(scope="module")
def table():
    table, _ = in_laboratory("six-positions", duration=3.0)
    return table.assign(temperature_coil=20.0 + 0.01 * np.arange(len(table)), angle=np.linspace(0, 1e-3, len(table)))


def joined(path):
    """Table of all blocks of 37 samples."""
    description, folder = io.read_description(path), Path(path).parent
    found = list(blocks(description, folder, rows=37))
    assert [b.first for b in found] == np.cumsum([0, *(len(b.time) for b in found[:-1])]).tolist()
    return np.concatenate([b.values for b in found], axis=1).T, np.concatenate([b.time for b in found])


@pytest.mark.parametrize("name", ["d.csv", "d.tsv", "d.parquet", "d.npz", "d.mat"])
def test_round_trip_is_exact_in_si_whole_and_in_pieces(table, name, tmp_path):
    description = io.describe(table, name, latitude=1.0)
    path = io.write(table, description, tmp_path / "recording.toml")
    recording = io.read(path)
    numbers = [c for c in recording.table.columns if c != "position"]
    assert_array_equal(recording.table[numbers], table[numbers])
    assert_array_equal(recording.table.index, table.index)
    assert recording.table["position"].tolist() == table["position"].astype(str).tolist()
    values, time = joined(path)
    assert_array_equal(values, table[numbers])
    assert_array_equal(time, table.index)
    assert not [p for p in tmp_path.iterdir() if "partial" in p.name]


@pytest.mark.parametrize(
    "file",
    [
        {"path": "d.txt", "delimiter": ";", "decimal": ",", "header": False},
        {"path": "d.dat", "delimiter": "whitespace", "header": False, "skip_rows": 3},
        {"path": "d.csv", "encoding": "utf-16", "header": False},
        {"path": "d.npz", "variable": "data"},
        {"path": "d.mat", "variable": "data"},
    ],
    ids=lambda file: file["path"] + file.get("delimiter", ""),
)
def test_numbered_columns_other_units_axes_and_increments(table, file, tmp_path):
    table = table[list(io.describe(table, "d.csv").names)[:6]]
    description = io.RecordingDescription(
        file=io.FileFormat(**file),
        clock=io.Clock(column=2, unit="ms", sample_rate=20.0),
        gyro=io.Channels(columns=(3, 8, 5), unit="arcsec", quantity="increments", axes=("-y", "z", "x"), scale=0.1),
        accel=io.Channels(columns=(1, 4, 6), unit="mg", axes=("x", "z", "-y")),
    )
    path = io.write(table, description, tmp_path / "recording.toml")
    # a factor there and back: three roundings
    assert_allclose(io.read(path).table, table, rtol=4e-16, atol=0)
    assert_allclose(joined(path)[0], table, rtol=4e-16, atol=0)


def test_what_the_file_holds_is_what_the_description_says(tmp_path):
    # independent of `write`: the file by hand
    (tmp_path / "d.csv").write_text("t ; w1;w2;w3;a1;a2;a3\n0;1;2;3;0;0;1\n10;1;2;;0;0;1\n20;1;2;3;0;0;1\n")
    (tmp_path / "recording.toml").write_text(
        'version = 1\n[file]\npath = "d.csv"\ndelimiter = ";"\n[clock]\ncolumn = "t"\nunit = "ms"\n'
        '[gyro]\ncolumns = ["w1", "w2", "w3"]\nunit = "deg/h"\naxes = ["y", "-x", "z"]\n'
        '[accel]\ncolumns = ["a1", "a2", "a3"]\nunit = "g*s"\nquantity = "increments"\n'
    )
    with pytest.warns(UserWarning, match="holds 1 missing or infinite numbers"):
        recording = io.read(tmp_path / "recording.toml")
    assert recording.dt == pytest.approx(0.01)
    first = recording.table.iloc[0]
    degree_per_hour = np.pi / 180 / 3600
    assert_allclose(first[:3], [-2 * degree_per_hour, 1 * degree_per_hour, 3 * degree_per_hour], rtol=1e-15)
    assert_allclose(first[3:], [0, 0, 9.80665 / 0.01], rtol=1e-15)
    assert_allclose(recording.increments().iloc[0], first * 0.01, rtol=1e-15)
    assert np.isnan(recording.table.iloc[1, 2])


def test_compressed_arrays_are_streamed(table, tmp_path):
    path = io.write(table, io.describe(table, "d.npz"), tmp_path / "recording.toml")
    with np.load(tmp_path / "d.npz") as arrays:
        np.savez_compressed(tmp_path / "d.npz", **dict(arrays))
    assert_array_equal(joined(path)[0], table.drop(columns="position"))


def rewritten(path, change):
    raw = path.read_bytes()
    path.write_bytes(change(raw))


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("d.csv", lambda raw: raw[: len(raw) // 2], "d.csv"),
        ("d.csv", lambda raw: raw.replace(b"\n", b"\nabc", 3), "d.csv cannot be read: .*abc"),
        ("d.csv", lambda raw: raw.replace(b'"gyro_x"', b'"gyro_q"'), "must have the column 'gyro_x', got 'time', "),
        ("d.csv", lambda raw: raw.replace(b'"gyro_y"', b'"gyro_x"'), "has the column 'gyro_x' 2 times"),
        ("d.csv", lambda raw: raw.replace(b",", b";"), "Is `delimiter` right?"),
        ("d.csv", lambda raw: raw[: raw.rindex(b"\n", 0, -1) + 1], "must hold 360 samples by its description, got 359"),
        ("d.csv", lambda raw: b"", "d.csv is empty"),
        ("d.csv", lambda raw: raw.split(b"\n")[0], "d.csv"),
        ("d.npz", lambda raw: raw[:-300], "d.npz cannot be read"),
        ("d.npz", lambda raw: raw.replace(b"gyro_x", b"gyro_q"), "must have the array 'gyro_x'"),
        ("d.parquet", lambda raw: raw[:-10], "d.parquet cannot be read"),
        ("d.mat", lambda raw: raw[: len(raw) // 2], "d.mat"),
        ("d.mat", lambda raw: b"MATLAB 7.3 MAT-file" + raw, "MATLAB 7.3 file .HDF5.: save it in MATLAB with '-v7'"),
    ],
)
def test_broken_files_end_in_one_sentence(table, name, change, words, tmp_path):
    path = io.write(table, io.describe(table, name), tmp_path / "recording.toml")
    rewritten(tmp_path / name, change)
    with pytest.raises(io.RecordingError, match=words) as caught:
        io.read(path)
    assert "\n" not in str(caught.value)


def test_clock_and_rate_must_agree(table, tmp_path):
    description = replace(io.describe(table, "d.csv"), clock=io.Clock(column="time", unit="s", sample_rate=20.0))
    path = io.write(table, description, tmp_path / "recording.toml")
    rewritten(path, lambda raw: raw.replace(b'unit = "s"', b'unit = "ms"'))
    with pytest.raises(io.RecordingError, match=r"0\.001 times those of `sample_rate`"):
        io.read(path)


def test_stamps_rounded_to_milliseconds_give_the_mean_step(tmp_path):
    # at 300 Hz the median step of stamps in ms is 3 ms, 10 % wrong
    time = np.round(np.arange(3000) / 300, 3)
    values = np.random.default_rng(1).standard_normal((3000, 3))
    table = pd.DataFrame(values, index=pd.Index(time, name="time"), columns=["gyro_x", "gyro_y", "gyro_z"])
    recording = io.read(io.write(table, io.describe(table, "d.parquet"), tmp_path / "recording.toml"))
    assert recording.dt == pytest.approx(1 / 300, rel=1e-3 / 10)  # a ms in 10 s


def test_nothing_half_written_is_left(table, tmp_path, monkeypatch):
    path = io.write(table, io.describe(table, "d.csv"), tmp_path / "recording.toml")
    before = (tmp_path / "d.csv").read_bytes()
    monkeypatch.setattr("fogkit.io.writing._text", lambda target, *_: target.write_text("half") / 0)
    with pytest.raises(ZeroDivisionError):
        io.write(table, io.describe(table, "d.csv"), path)
    assert (tmp_path / "d.csv").read_bytes() == before
    assert sorted(p.name for p in tmp_path.iterdir()) == ["d.csv", "recording.toml"]


def test_a_clock_that_would_be_lost_is_not_written(table, tmp_path):
    description = replace(io.describe(table, "d.csv"), clock=io.Clock(sample_rate=19.0))
    with pytest.raises(io.RecordingError, match="give the clock a column"):
        io.write(table, description, tmp_path / "recording.toml")
