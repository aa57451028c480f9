"""Recordings and descriptions, broken in all the ways that happen to files, and what comes of them.

``python tests/iofuzz.py 10000`` runs that many, from a second number on if there is one; the seed of a case is its
number, so that each can be run again by ``python tests/iofuzz.py --case 1234``.
"""

import re
import shutil
import sys
import tempfile
import warnings
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
from iorecordings import LATITUDE, in_laboratory, on_mount

from fogkit import io

JUNK = (
    "",
    "abc",
    "1e400",
    "-1e308",
    "0x10",
    "NaN",
    "--5",
    "1,5",
    "999999999999",
    "inf",
    "1e30",
    "é",
    "\0",
    '"',
    "5 5",
    "''",
)
VALUES = (
    "true",
    '"abc"',
    "-1",
    "0",
    "1e400",
    "nan",
    "[1, 2]",
    "{}",
    "10000000000000000000000000000000",
    "[]",
    "1.5",
    "'x'",
)
UNITS = (
    "rad/s",
    "deg/s",
    "deg/h",
    "rad",
    "deg",
    "arcsec",
    "m/s^2",
    "g",
    "mg",
    "m/s",
    "g*s",
    "s",
    "ms",
    "us",
    "min",
    "h",
    "K",
)
UNITS = (*UNITS, "degC", "furlong", "Deg/s", "")


@cache
def sound():
    """Sound recordings: descriptions and tables, one of each plan and each kind of file."""
    laboratory = {
        "six.csv": ("six-positions", {"duration": 10.0}),
        "points.npz": ("twenty-four-points", {"duration": 4.0}),
        "turns.parquet": ("full-turns", {"rate": 40.0, "rate_unit": "deg/s"}),
        "rates.mat": ("rate-sequence", {"duration": 5.0, "rates": [5.0, -5.0, 20.0, -20.0], "rate_unit": "deg/s"}),
        "numbers.txt": ("six-positions", {"duration": 8.0}),
    }
    made = []
    for seed, (name, (kind, parameters)) in enumerate(laboratory.items()):
        table, plan = in_laboratory(kind, seed=seed, sample_rate=20.0, **parameters)
        if name != "points.npz":
            table = table.drop(columns="position")
        description = io.describe(table, name, latitude=LATITUDE, plan=plan)
        if name == "numbers.txt":  # increments, numbered columns, decimal commas, no clock
            description = replace(
                description,
                file=io.FileFormat(path=name, kind="csv", delimiter=";", decimal=",", header=False),
                clock=io.Clock(sample_rate=20.0),
                gyro=io.Channels(columns=(1, 2, 3), unit="arcsec", quantity="increments", axes=("z", "-x", "y")),
                accel=io.Channels(columns=(6, 5, 4), unit="g*s", quantity="increments", axes=("x", "-y", "z")),
            )
        made.append((description, table))
    angles = {"start": "ENU", "axis": "x", "angles": [0, 90, 180, 270], "angle_unit": "deg"}
    plan = io.PlanReference(kind="gyrocompass", parameters={**angles, "dwell": 10.0, "turn_duration": 5.0})
    table = on_mount(plan.build(), 0.05, np.random.default_rng(9))
    table["temperature_coil"] = 20 + 1e-3 * table.index
    made.append((io.describe(table, "mount.csv", latitude=LATITUDE, plan=plan), table))
    return made


@cache
def sound_folder():
    """Folder with all sound recordings on disk, and what each gives."""
    folder = Path(tempfile.mkdtemp())
    found = []
    for number, (description, table) in enumerate(sound()):
        path = io.write(table, description, folder / str(number) / "recording.toml")
        outcome, values, _ = evaluate(path)
        if outcome != "good":
            raise AssertionError(f"{description.file.path} must be good, got {outcome}: {values}")
        found.append((path.parent, description.file.path, values))
    return found


def evaluate(path):
    """What a recording ends in: "good", "doubtful" or "error"; numbers or the message; and the recording."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            recording = io.read(path)
            verdict = io.check(recording)
            surveyed = io.survey(path, reduced_rate=2.0, rows=137)
            segmentation = io.segment(recording)
            means = io.dwell_means(recording, segmentation) if segmentation.segments else None
        except io.RecordingError as error:
            message = str(error)
            if not message or "\n" in message or len(message) > 600 or "Traceback" in message:
                raise AssertionError(f"not one sentence: {message!r}") from error
            return "error", message, None
    if surveyed.verdict.severity != verdict.severity:
        raise AssertionError(f"the verdict depends on the size of the blocks: {verdict!r}, {surveyed.verdict!r}")
    doubts = [str(w.message) for w in told if not issubclass(w.category, UserWarning)]
    if doubts:
        raise AssertionError(f"a warning of another library: {doubts[0]}")
    if verdict.severity != "good" or told:
        return "doubtful", repr(verdict), recording
    return "good", means, recording


def same(values, recording, path):
    """Whether a recording that is called good gives the numbers of the sound one, within its own noise."""
    table = path  # the sound table
    got = recording.table
    if len(got) != len(table):
        return f"{len(got)} samples of {len(table)}"
    names = [c for c in table.columns if c != "position"]
    if missing := [c for c in names if c not in got and not c.startswith("temperature")]:
        return None if set(missing) <= {"accel_x", "accel_y", "accel_z"} else f"without {missing}"
    names = [c for c in names if c in got and not c.startswith("temperature")]  # nothing says what is right
    ours, theirs = table[names].to_numpy(), got[names].to_numpy()
    noise = np.median(np.abs(np.diff(ours, axis=0)), axis=0) + 1e-12
    blocks = len(ours) // 80
    shift = (theirs - ours)[: blocks * 80].reshape(blocks, 80, -1).mean(axis=1)
    worst = np.abs(shift) / noise
    if (worst > 3).any():
        return f"{names[int(np.argmax(worst.max(axis=0)))]} is off by {worst.max():.3g} of its noise"
    step = (got.index[-1] - got.index[0]) / (table.index[-1] - table.index[0])
    return None if abs(step - 1) < 0.05 else f"time is {step:.3g} times as long"


def mutate(folder, data, rng):
    """Break a recording in one way; what was done, in words."""
    text, description = folder / data, folder / "recording.toml"
    kinds = [_toml_line, _toml_unit, _toml_value, _toml_letter, _toml_axes, _toml_bytes, _bytes]
    kinds += [_lines] * 5 if data.endswith((".csv", ".txt")) else [_bytes] * 3
    return rng.choice(kinds)(text, description, rng)


def _toml_line(_, path, rng):
    lines = path.read_text(encoding="utf-8").splitlines()
    i, way = int(rng.integers(len(lines))), rng.choice(["drop", "twice", "cut", "swap", "end"])
    if way == "drop":
        del lines[i]
    elif way == "twice":
        lines.insert(i, lines[i])
    elif way == "cut":
        lines[i] = lines[i][: int(rng.integers(len(lines[i]) + 1))]
    elif way == "swap":
        j = int(rng.integers(len(lines)))
        lines[i], lines[j] = lines[j], lines[i]
    else:
        lines = lines[:i]
    path.write_text("\n".join(lines), encoding="utf-8")
    return f"line {i + 1} of the description: {way}"


def _toml_unit(_, path, rng):
    text = path.read_text(encoding="utf-8")
    at = [m for m in re.finditer(r'unit = "([^"]*)"', text)]
    chosen, unit = at[int(rng.integers(len(at)))], str(rng.choice(UNITS))
    path.write_text(text[: chosen.start(1)] + unit + text[chosen.end(1) :], encoding="utf-8")
    return f"{chosen.group()} becomes {unit!r}"


def _toml_value(_, path, rng):
    lines = path.read_text(encoding="utf-8").splitlines()
    keys = [i for i, line in enumerate(lines) if " = " in line]
    i, value = int(rng.choice(keys)), str(rng.choice(VALUES))
    before = lines[i]
    lines[i] = lines[i].split(" = ")[0] + " = " + value
    path.write_text("\n".join(lines), encoding="utf-8")
    return f"{before} becomes {value}"


def _toml_letter(_, path, rng):
    text = path.read_text(encoding="utf-8")
    i, letter = int(rng.integers(len(text))), str(rng.choice(list('azZ09 ".=[]{}#é\n\0-')))
    path.write_text(text[:i] + letter + text[i + int(rng.integers(2)) :], encoding="utf-8")
    return f"letter {i} of the description becomes {letter!r}"


def _toml_axes(_, path, rng):
    text = path.read_text(encoding="utf-8")
    sensor = str(rng.choice(["gyro", "accel"]))
    head, found, tail = text.partition(f"[{sensor}]\n")
    tail = re.sub(r"^axes = .*\n", "", tail.split("\n[", 1)[0] + "\n", flags=re.M) + (
        "\n[" + tail.split("\n[", 1)[1] if "\n[" in tail else ""
    )
    axes = [str(rng.choice(["", "-"])) + axis for axis in rng.permutation(list("xyz"))]
    path.write_text(head + found + f"axes = {axes}\n" + tail, encoding="utf-8")
    return f"axes of {sensor} become {axes}"


def _toml_bytes(_, path, rng):
    raw = path.read_bytes()
    way = rng.choice(["utf-16", "latin-1", "bytes", "bom"])
    if way == "utf-16":
        raw = raw.decode().encode("utf-16")
    elif way == "latin-1":
        raw = raw + "# Gyroskop für".encode("latin-1")
    elif way == "bom":
        raw = b"\xef\xbb\xbf" + raw
    else:
        i = int(rng.integers(len(raw)))
        raw = raw[:i] + rng.bytes(3) + raw[i:]
    path.write_bytes(raw)
    return f"bytes of the description: {way}"


def _bytes(path, _, rng):
    raw = bytearray(path.read_bytes())
    way = rng.choice(["flip", "cut", "append", "zero", "empty", "gone", "prefix"])
    i = int(rng.integers(len(raw)))
    if way == "flip":
        for j in rng.integers(len(raw), size=int(rng.integers(1, 6))):
            raw[j] ^= 1 << int(rng.integers(8))
    elif way == "cut":
        del raw[i:]
    elif way == "append":
        raw += rng.bytes(40)
    elif way == "zero":
        raw[i : i + 64] = bytes(len(raw[i : i + 64]))
    elif way == "empty":
        raw = bytearray()
    elif way == "prefix":
        raw[:0] = rng.bytes(5)
    path.write_bytes(raw)
    if way == "gone":
        path.unlink()
    return f"bytes of the data: {way} at {i}"


def _lines(path, _, rng):
    """Break the rows of a text file."""
    decimal = path.suffix == ".txt"
    delimiter = ";" if decimal else ","
    lines = path.read_text(encoding="utf-8").splitlines()
    first = 0 if decimal else 1
    i = int(rng.integers(first, len(lines)))
    n = int(rng.integers(1, 60))
    ways = ["junk", "cut", "drop", "twice", "swap", "header", "scale", "frozen", "clip", "delimiter", "end", "shuffle"]
    way = str(rng.choice([*ways, "encoding", "blank", "step", "column"]))
    rows = [line.split(delimiter) for line in lines]
    columns = range(len(rows[-1]))
    c = int(rng.integers(0 if decimal else 1, len(columns)))
    if way == "junk":
        rows[i][c] = str(rng.choice(JUNK))
    elif way == "cut":
        rows[i] = rows[i][: int(rng.integers(len(rows[i])))]
    elif way == "drop":
        del rows[i : i + n]
    elif way == "twice":
        rows[i:i] = rows[i : i + n]
    elif way == "swap":
        d = int(rng.integers(0 if decimal else 1, len(columns)))
        for row in rows[first:]:
            row[c], row[d] = row[d], row[c]
        way = f"swap {c}, {d}"
    elif way == "header":
        d = int(rng.integers(len(columns)))
        rows[0][c] = rows[0][d]
    elif way in ("scale", "step", "clip"):
        factor = float(rng.choice([180 / np.pi, np.pi / 180, 1 / 9.80665, 9.80665, 20.0, 0.05, -1.0, 1e3, 1e-3]))
        values = np.array([float(row[c].replace(",", ".")) for row in rows[first:]])
        span = np.quantile(values, 0.8)
        level = 50 * np.median(np.abs(np.diff(values)))
        group = [c]
        if way == "scale":  # of all three sensors, as a unit is wrong for
            offset = 0 if decimal else 1
            group = [k for k in columns if k >= offset and (k - offset) // 3 == (c - offset) // 3]
            way = f"scale {group} by {factor:.4g}"
        for k in group:
            for r, row in enumerate(rows[first:]):
                value = float(row[k].replace(",", "."))
                value = (
                    value * factor
                    if way.startswith("scale")
                    else value + level * (r > i)
                    if way == "step"
                    else min(value, span)
                )
                row[k] = repr(value).replace(".", "," if decimal else ".")
    elif way == "frozen":
        for row in rows[i : i + n + 60]:
            row[c] = rows[i][c]
    elif way == "delimiter":
        delimiter = str(rng.choice(["\t", "|", " ", ",", ";"]))
    elif way == "end":
        rows = rows[:i]
    elif way == "shuffle":
        rows[i : i + n] = [rows[i : i + n][k] for k in rng.permutation(len(rows[i : i + n]))]
    elif way == "blank":
        rows[i:i] = [[""]]
    elif way == "column":
        for row in rows:
            del row[c]
    text = "\n".join(delimiter.join(row) for row in rows) + "\n" * int(rng.integers(2))
    encoding = "utf-8"
    if way == "encoding":
        encoding = str(rng.choice(["utf-16", "utf-8-sig", "utf-32", "cp037"]))
        way = encoding
    path.write_bytes(text.encode(encoding))
    return f"row {i}, column {c} of the data: {way}"


def run_case(number, folder):
    """One mutated recording: outcome, what was done, and, if it is called good but is not, why."""
    rng = np.random.default_rng(number)
    source, data, _ = sound_folder()[number % len(sound_folder())]
    target = folder / "case"
    shutil.rmtree(target, ignore_errors=True)
    shutil.copytree(source, target)
    done = [mutate(target, data, rng)]
    if rng.random() < 0.15:
        try:
            done.append(mutate(target, data, rng))
        except (ValueError, IndexError, OSError):  # too little is left to break
            done.append("and no more")
    try:
        outcome, message, recording = evaluate(target / "recording.toml")
    except Exception as error:
        return "crash", f"{data}: {'; '.join(done)}", f"{type(error).__name__}: {error}"
    wrong = None
    if outcome == "good":
        wrong = same(message, recording, sound()[number % len(sound())][1])
        if wrong and len(done) > 1 and recording.description.plan is None:
            return "unplanned", f"{data}: {'; '.join(done)}", wrong  # broken twice, the plan that would tell being gone
    return outcome, f"{data}: {'; '.join(done)}", wrong if outcome == "good" else message


def main(arguments):
    """Run cases and print what comes of them."""
    if arguments[:1] == ["--case"]:
        numbers = range(int(arguments[1]), int(arguments[1]) + 1)
    else:
        count, first = int((*arguments, "300")[0]), int(arguments[1]) if len(arguments) > 1 else 0
        numbers = range(first, first + count)
    counts, shown = {}, 0
    with tempfile.TemporaryDirectory() as name:
        for number in numbers:
            outcome, done, message = run_case(number, Path(name))
            kind = "silent" if outcome == "good" and message else outcome
            counts[kind] = counts.get(kind, 0) + 1
            if kind in ("crash", "silent") or len(numbers) == 1:
                shown += 1
                if shown <= 200:
                    print(f"{number}: {kind}: {done}\n    {message}", flush=True)
    print(counts)
    return bool(counts.get("crash") or counts.get("silent"))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
