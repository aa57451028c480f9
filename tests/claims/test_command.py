"""``python -m fogkit.claims``."""

import csv
import subprocess
import sys

import pytest

from fogkit import claims
from fogkit.claims.__main__ import main


def test_counts(write, rows, capsys):
    assert main([], folder=write(rows)) == 0
    head, line = capsys.readouterr().out.splitlines()
    assert head.split() == ["paper", *claims.STATUSES, "total"]
    assert line.split() == ["fake", "1", "2", "1", "1", "1", "6"]


def test_empty_ledger(tmp_path, capsys):
    assert main([], folder=tmp_path) == 0
    assert capsys.readouterr().out == "the ledger is empty\n"


def test_csv_round_trip(write, rows, values, tmp_path):
    target = tmp_path / "out" / "ledger.csv"
    target.parent.mkdir()
    assert main(["--csv", str(target)], folder=write(rows), values={"fake": values}) == 0
    with target.open(encoding="utf-8", newline="") as file:
        written = list(csv.DictReader(file))
    assert [{key: row[key] for key in claims.COLUMNS} for row in written] == rows
    computed = {row["id"]: row["computed"] for row in written}
    assert computed == {
        "fake-number": "3.14159",
        "fake-bound": "0.2",
        "fake-slip": "2.512",
        "fake-sign": "print fails, correction holds",
        "fake-lost": "7.25",
        "fake-convention": "",
    }


def test_check_passes_and_fails(write, rows, values, capsys):
    folder = write(rows)
    assert main(["--check"], folder=folder, values={"fake": values}) == 0
    assert "6 of 6 rows carry their status" in capsys.readouterr().out
    values["fake-number"] = 3.15
    assert main(["--check"], folder=folder, values={"fake": values}) == 1
    captured = capsys.readouterr()
    assert "5 of 6 rows carry their status" in captured.out
    assert captured.err.startswith("fake-number: reproduced, but the print does not hold")
    target = folder / "ledger.txt"
    assert main(["--csv", str(target)], folder=folder, values={"fake": values}) == 1
    assert "1 rows do not carry their status" in capsys.readouterr().err


def test_one_paper(write, rows, capsys):
    folder = write(rows)
    write([rows[0] | {"id": "other-number", "paper": "other"}], "other")
    assert main(["--paper", "other"], folder=folder) == 0
    assert capsys.readouterr().out.split()[7:] == ["other", "1", "0", "0", "0", "0", "1"]
    with pytest.raises(SystemExit):
        main(["--paper", "none"], folder=folder)
    assert "--paper must be one of fake, other, got 'none'" in capsys.readouterr().err


def test_import_is_light():
    """Counting the ledger needs no table library, no figures, no kernels."""
    code = "import sys, fogkit.claims; print({'pandas', 'matplotlib', 'numba', 'scipy', 'IPython'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_module_runs():
    done = subprocess.run([sys.executable, "-m", "fogkit.claims"], capture_output=True, text=True, check=True)
    assert done.stdout.split()[0] == "paper"
    assert "miklyashev" in done.stdout
