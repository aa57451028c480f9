"""The tour of the README, line by line, in a new folder."""

import re
import shlex
from pathlib import Path

from fogkit.cli.arguments import TOUR
from fogkit.cli.entry import main
from fogkit.cli.results import Result

README = Path(__file__).resolve().parents[2] / "README.md"


def test_the_tour_runs_in_a_new_folder(tmp_path, monkeypatch, capsys):
    lines = re.findall(r"^fogkit .+$", README.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(lines) == 6 and [line.strip() for line in TOUR.splitlines() if line.startswith("  fogkit")] == lines
    monkeypatch.chdir(tmp_path)
    for line in lines:
        assert main(shlex.split(line)[1:]) == 0, capsys.readouterr().err
    assert capsys.readouterr().err == ""
    found = Result.from_json((tmp_path / "found.json").read_text(encoding="utf-8"))
    assert len(found.estimates) == 24 and found.estimates.covariance is not None
    assert (tmp_path / "found.html").stat().st_size > 20_000  # with figures
    assert not list(tmp_path.rglob("*partial*"))
