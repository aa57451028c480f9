"""The study of the page on clusters, run as it stands there: two workers of a local Dask cluster."""

import importlib
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from pandas.testing import assert_frame_equal

from fogkit.campaign import case_generator, grid, read_campaign, run_campaign
from fogkit.noise import RandomErrors
from fogkit.units import DEG_PER_HOUR_PER_SQRT_HOUR, DEG_PER_SQRT_HOUR

PAGE = Path(__file__).resolve().parents[2] / "book" / "cluster.md"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    files = re.findall(r"```\{code-block\} python\n:caption: (\S+)\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)
    for name, text in files:
        (folder / name).write_text(text, encoding="utf-8")
    assert [name for name, _ in files] == ["study.py", "campaign.py"]
    return folder


@pytest.fixture
def study(folder, monkeypatch):
    monkeypatch.syspath_prepend(folder)
    yield importlib.import_module("study")
    del sys.modules["study"]


def test_two_dask_workers_give_what_two_threads_give(folder, study):
    command = [sys.executable, "-W", "error", "campaign.py"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert "found, deg/h" in done.stdout and "200/200" in done.stderr
    by_dask = read_campaign(folder / "bias-study")

    errors = RandomErrors(
        angle_random_walk=0.003 * DEG_PER_SQRT_HOUR, rate_random_walk=0.01 * DEG_PER_HOUR_PER_SQRT_HOUR
    )
    options = {"common": {"errors": errors}, "seed": 1, "repeats": 40, "progress": False}
    cases = grid({"duration": [300, 600, 1200, 2400, 4800]})
    with ThreadPoolExecutor(2) as pool:
        by_threads = run_campaign(study.bias_from_mean, cases, folder / "threads", executor=pool, **options)
    assert_frame_equal(by_dask.drop(columns="run_time"), by_threads.drop(columns="run_time"), check_exact=True)
    row = by_dask.iloc[17]
    assert study.bias_from_mean(row["duration"], errors, case_generator(row["seed"]))["error"] == row["error"]

    # deviations of 40 draws each, chi-square with 39 degrees of freedom: 3.3 sigma, for five of them
    N, K = errors.angle_random_walk, errors.rate_random_walk
    found = by_dask.groupby("duration")["error"].std()
    law = np.sqrt(N**2 / found.index + K**2 * found.index / 3)
    assert np.allclose(found / law, 1, atol=3.3 / np.sqrt(2 * 39))
