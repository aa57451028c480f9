"""The command line: what it says, what it gives back, and that its calibrations find what was planted."""

import csv
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from fogkit import io
from fogkit.cli import arguments
from fogkit.cli.entry import main
from fogkit.cli.results import Result
from fogkit.cli.turned_calibrations import heading_covariance
from fogkit.io.plan_names import PARAMETERS
from fogkit.stand import nine_tests
from fogkit.units import DEG


def run(*argv):
    return main([str(a) for a in argv])


def loaded(path):
    return Result.from_json(path.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Folder with a recording of positions and turns, and its calibration."""
    folder = tmp_path_factory.mktemp("made")
    assert run("simulate", "multiposition", folder, "--duration", 20, "--seed", 4, "-q") == 0
    assert run("calibrate", "multiposition", folder / "recording.toml", "-o", folder / "found.json", "-q") == 0
    return folder


def all_parsers():
    """Every parser under the root, by its words."""
    found, left = {}, [((), arguments.parser())]
    while left:
        words, parser = left.pop()
        found[words] = parser
        for action in parser._actions:
            if isinstance(action, arguments._SubParsersAction):
                left += [((*words, name), sub) for name, sub in action.choices.items()]
    return found


def test_every_command_teaches():
    for words, parser in all_parsers().items():
        text = parser.format_help()
        if words:
            assert "example:\n  fogkit" in text and "next:\n" in text, words
            example = parser.epilog.split("\n")[1].split()
            assert arguments.parser().parse_args(example[1:]), words  # the example is one
        assert max(map(len, parser.epilog.splitlines())) < 130


def test_names_stand_for_what_the_package_has():
    assert set(arguments.PLANS) == set(PARAMETERS)
    for words, parser in all_parsers().items():
        if name := parser.get_default("run"):
            from fogkit.cli.entry import _function

            assert callable(_function(name)), words


def test_help_loads_nothing_heavy():
    code = "import sys; from fogkit.cli.entry import main; main(['--help']); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"numpy", "scipy", "pandas", "numba", "matplotlib", "pyarrow"} & set(done.stdout.split())


METHODS = {  # what is simulated, and how it is calibrated
    "rate-sequence": (
        ["--duration", 5, "-p", "duration=5", "-p", "rates=[0, 10, -10, 150, -150]", "-p", "rate_unit=deg/s"],
        [],
    ),
    "three-stage": (["-p", "bias_duration=60", "-p", "count=2"], ["--readout-noise", 1]),
    "navigation": (["-p", "turns=1", "-p", "dwell=5", "-p", "turn_duration=6", "--format", "npz"], []),
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("seed", [1])
def test_a_calibration_finds_what_was_planted(method, seed, tmp_path, capsys):
    simulated, options = METHODS[method]
    assert run("simulate", method, tmp_path / "d", "--seed", seed, *simulated, "-q") == 0
    recording, found = tmp_path / "d" / "recording.toml", tmp_path / "found.json"
    assert run("calibrate", method, recording, *options, "-o", found, "-q") == 0
    # verify fails at one chance in 10 000, for the largest departure and for all together: a fixed seed passes or not
    assert run("verify", found, tmp_path / "d" / "truth.json", "-q") == 0, capsys.readouterr().err
    # ... and errors of a thousandth of what was planted would be seen
    ours, truth = loaded(found).estimates, loaded(tmp_path / "d" / "truth.json").estimates
    names = [n for n in ours.names if n in truth.names and ("matrix" in n or "scale" in n or "M_" in n or "alpha" in n)]
    planted = np.array([truth.of(n) for n in names]) - [round(truth.of(n)) for n in names]
    missed = np.array([ours.of(n) - truth.of(n) for n in names])
    assert np.abs(missed).max() < 0.1 * np.abs(planted).max()
    assert run("apply", found, recording, tmp_path / "c", "-q") == 0
    assert (
        run("calibrate", method, tmp_path / "c" / "recording.toml", *options, "-o", tmp_path / "again.json", "-q") == 0
    )
    again = loaded(tmp_path / "again.json").estimates
    ideal = np.array(
        [1.0 if u == "1" and abs(v - 1) < 0.5 else 0.0 for u, v in zip(ours.units, again.values, strict=True)]
    )
    # the same noise with the errors taken out: what is left is far below its own deviation
    assert (np.abs(again.values - ideal) < 0.2 * again.standard_deviation).all()


def test_a_wrong_truth_is_found_out(made, tmp_path, capsys):
    truth = loaded(made / "truth.json")
    text = truth.to_json()
    name = "accel.matrix_zz"
    before = repr(truth.estimates.of(name))
    deviation = loaded(made / "found.json").estimates
    step = 8 * deviation.standard_deviation[deviation.names.index(name)]
    (tmp_path / "wrong.json").write_text(text.replace(before, repr(float(truth.estimates.of(name) + step))))
    assert run("verify", made / "found.json", made / "truth.json", "-q") == 0
    assert run("verify", made / "found.json", tmp_path / "wrong.json", "-q", "-o", tmp_path / "v.json") == 1
    assert "standard deviations" in loaded(tmp_path / "v.json").findings[1].text
    assert capsys.readouterr().err.count("\n") == 1


def test_north_is_found_about_both_axes(tmp_path):
    level = ["-p", "start=NWU", "-p", "axis=x", "-p", "angles=[0, 90, 180, 270]", "-p", "angle_unit=deg"]
    level += ["-p", "dwell=60.0", "-p", "turn_duration=10.0"]
    for name, options in {"upright": ["--duration", 60], "level": level}.items():
        assert run("simulate", "north", tmp_path / name, "--heading", 40, *options, "-q") == 0
        assert run("north", tmp_path / name / "recording.toml", "-o", tmp_path / f"{name}.json", "-q") == 0
        e = loaded(tmp_path / f"{name}.json").estimates
        # misalignments of the raw unit, 1 arcmin of 15 deg/h, stand beside the noise
        assert abs(e.of("heading") - 40 * DEG) < 4 * e.standard_deviation[0] + 2e-4, name
        assert e.standard_deviation[0] < 0.1 * DEG


def test_temperatures_are_taken_out(tmp_path):
    assert run("simulate", "thermal", tmp_path / "d", "-q") == 0
    found = tmp_path / "t.json"
    assert run("thermal", tmp_path / "d" / "recording.toml", "-o", found, "-q") == 0
    assert run("verify", found, tmp_path / "d" / "truth.json", "-q") == 0
    assert run("apply", found, tmp_path / "d" / "recording.toml", tmp_path / "c", "-q") == 0
    before, after = (io.read(tmp_path / n / "recording.toml").table["gyro_x"].to_numpy() for n in "dc")
    noise = 0.001 * DEG / 60 / np.sqrt(10)  # planted, per sample of 10 s
    assert (
        before.std() > 5 * noise and after.std() < 1.1 * noise
    )  # a tenth covers the ends and the scatter of a scatter


def test_allan_drift_and_plan(tmp_path, capsys):
    assert run("simulate", "allan", tmp_path, "--duration", 300, "-q") == 0
    assert (
        run("allan", tmp_path / "recording.toml", "-o", tmp_path / "a.json", "--report", tmp_path / "a.html", "-q") == 0
    )
    assert run("verify", tmp_path / "a.json", tmp_path / "truth.json", "-q") == 0
    assert run("drift", "--acceleration", 5000, "-o", tmp_path / "d.json", "-q") == 0
    assert loaded(tmp_path / "d.json").tables["drift"]["oscillation_dph"][0] == pytest.approx(
        -0.2123, abs=5e-5
    )  # README
    for kind in arguments.PLANS:
        assert run("plan", kind, "--csv", tmp_path / "s.csv", "-o", tmp_path / "p.json") == 0, kind
        printed = capsys.readouterr().out
        section = io.description.tomllib.loads(loaded(tmp_path / "p.json").parameters["toml"])["plan"]
        assert io.PlanReference.from_table(section).kind == kind and f'kind = "{kind}"' in printed
        assert len(list(csv.reader((tmp_path / "s.csv").read_text().splitlines()))) > 1


BAD = {
    "no file": (1, ["check", "nowhere.toml"], "nowhere.toml cannot be read"),
    "no result": (1, ["apply", "recording.toml", "recording.toml", "out"], "is not valid JSON"),
    "nothing to apply": (1, ["apply", "truth.json", "recording.toml", "out"], "corrects nothing"),
    "wrong plan": (1, ["calibrate", "navigation", "recording.toml"], "needs a recording of the plan nine-tests"),
    "no temperatures": (1, ["thermal", "recording.toml"], "needs some"),
    "nowhere to write": (1, ["check", "recording.toml", "-o", "truth.json/x.json"], "cannot be written"),
    "its own folder": (2, ["apply", "found.json", "recording.toml", "."], "the raw one is not overwritten"),
    "there already": (2, ["simulate", "multiposition", "."], "is there already"),
    "plan of another method": (
        2,
        ["simulate", "navigation", "out", "--plan", "six-positions"],
        "takes a plan nine-tests",
    ),
    "unknown parameter": (2, ["plan", "six-positions", "-p", "durtion=3"], "is not a parameter"),
    "no number": (2, ["simulate", "allan", "out", "--duration", "long"], "must be a number"),
    "unknown command": (2, ["calibrat"], "invalid choice"),
    "nothing": (2, [], "required"),
}


@pytest.mark.parametrize("case", BAD.values(), ids=BAD)
def test_what_is_wrong_is_said_and_coded(case, made, monkeypatch, capsys):
    code, argv, text = case
    monkeypatch.chdir(made)
    before = sorted(p.name for p in made.iterdir())
    assert main(argv) == code
    said = capsys.readouterr().err
    assert text in said and "Traceback" not in said
    assert code == 2 or said.count("\n") == 1  # argparse shows its usage too
    assert sorted(p.name for p in made.iterdir()) == before


def test_bad_data_is_reported_and_written_down(made, tmp_path, capsys):
    recording = io.read(made / "recording.toml")
    table = recording.table.copy()
    table.iloc[50:60, 0] = np.nan
    io.write(table, recording.description, tmp_path / "recording.toml")
    assert run("check", tmp_path / "recording.toml", "-o", tmp_path / "c.json", "-q") == 1
    assert "missing" in capsys.readouterr().err
    assert loaded(tmp_path / "c.json").severity == "bad"
    assert run("calibrate", "multiposition", tmp_path / "recording.toml", "-o", tmp_path / "f.json", "-q") == 1
    assert not (tmp_path / "f.json").exists() and capsys.readouterr().err.count("\n") == 1


def test_a_result_says_which_file_it_is_of(made):
    import hashlib

    found = loaded(made / "found.json")
    for entry in found.inputs:
        data = (made / entry["name"]).read_bytes()
        assert entry["sha256"] == hashlib.sha256(data).hexdigest() and entry["bytes"] == len(data)
    assert {"fogkit", "numpy", "python"} <= set(found.versions)


def test_an_interrupt_leaves_nothing_half_written(tmp_path):
    """A real process that is told to stop while it writes: first without a recording there, then with one."""
    code = (
        "import sys, time; from fogkit.cli import entry, simulation\n"
        "def slow(*a, **k):\n    print('writing', flush=True); (a[2].parent / 'recording.csv').write_text('1,2')\n"
        "    time.sleep(30)\n"
        "simulation.write = slow\n"
        "sys.exit(entry.main(['simulate', 'multiposition', sys.argv[1], '--duration', '2', '-q', '--overwrite']))"
    )
    (tmp_path / "recording.toml").write_text("as it was")
    process = subprocess.Popen(
        [sys.executable, "-c", code, str(tmp_path)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "writing\n"
    time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=20)
    assert process.returncode == 130 and "interrupted" in err and "Traceback" not in err
    assert [p.name for p in tmp_path.iterdir()] == ["recording.toml"]
    assert (tmp_path / "recording.toml").read_text() == "as it was" and not out


def test_the_heading_covariance_is_that_of_the_navigation_equations():
    """One gyro-free integration: what a wrong heading does to the slope north, by integrating the tilt itself."""
    plan, lat, wrong = nine_tests(), 0.9, 1e-3
    g, omega = 9.81, 7.292115e-5 * np.cos(lat)
    dt = 0.01
    t = np.arange(0, plan[0].duration, dt) + dt / 2
    tilt = np.cumsum(np.full_like(t, omega * np.sin(wrong))) * dt  # the level rate is resolved about a wrong axis
    velocity = np.cumsum(g * np.sin(tilt)) * dt
    dwell = plan[0].dwell
    first, last = t < dwell, t > plan[0].duration - dwell
    change = np.polyfit(t[last], velocity[last], 1)[0] - np.polyfit(t[first], velocity[first], 1)[0]
    R = heading_covariance(plan, lat, 0.0, wrong)
    assert np.sqrt(R[1, 1]) == pytest.approx(change, rel=2e-3)  # gravity of the place is 9.81 to a thousandth
    both = heading_covariance(plan, lat, wrong, 0.0)
    assert both[1, 3] == pytest.approx(R[1, 1]) and R[1, 3] == 0 and R[0, 0] == 0


def test_the_entry_point_runs(tmp_path):
    environment = {**os.environ, "COLUMNS": "120"}
    done = subprocess.run(
        [sys.executable, "-m", "fogkit", "--version"], capture_output=True, text=True, check=True, env=environment
    )
    assert done.stdout.startswith("fogkit ")
