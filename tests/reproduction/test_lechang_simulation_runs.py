"""Figures 5 to 11 over 100 seeds, what is stored of them, and the inputs that the thesis does not state."""

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose

from fogkit.estimation.consistency import chi_square_interval
from fogkit.reproduction.lechang import paper, simulation, simulation_runs
from fogkit.units import DEG


@pytest.fixture(scope="module")
def stored():
    return simulation_runs.stored()


def test_stored_runs_are_those_of_the_function(stored):
    again = pd.DataFrame(simulation_runs.case(7))
    same = stored[stored.seed == 7].sort_values(["filter", "time"], ignore_index=True)
    again = again.sort_values(["filter", "time"], ignore_index=True)
    assert list(again.columns) == list(stored.columns)
    for name in simulation_runs.QUANTITIES:
        # four digits are stored; what other processors round otherwise is far below an error's standard deviation
        assert_allclose(same[name], again[name], rtol=1e-3, atol=5e-3 * again[f"{name}_std"].min())
        assert_allclose(same[f"{name}_std"], again[f"{name}_std"], rtol=1e-3)


def test_stored_runs_are_complete(stored):
    assert len(stored) == 3 * 100 * len(simulation_runs.TIMES)
    assert sorted(stored["filter"].unique()) == ["extended", "smoothed", "wander"]
    end = stored[stored.time == 900].set_index(["filter", "seed"])
    for name in simulation_runs.QUANTITIES:  # at the end a smoother knows no more than the filter: two runs of one
        assert_allclose(end.loc["smoothed", name], end.loc["wander", name], rtol=1e-3, atol=1e-6)


def test_filter_to_use_errs_as_it_says(stored):
    last = stored[(stored["filter"] == "wander") & (stored.time == 900)]
    low, high = chi_square_interval(1, 100, 1 - 0.01 / 9)  # nine quantities, each may leave it once in a thousand
    for name in simulation_runs.QUANTITIES:
        mean_square = ((last[name] / last[f"{name}_std"]) ** 2).mean()
        assert low < mean_square < high, name


def test_statistics_by_hand():
    rows = []
    for seed, error in enumerate((0.5, -2.0, 4.0)):
        values = {q: error for q in simulation_runs.QUANTITIES} | {f"{q}_std": 1.0 for q in simulation_runs.QUANTITIES}
        rows.append({"filter": "wander", "seed": seed, "time": 100, **values})
    found = simulation_runs.statistics(pd.DataFrame(rows)).loc["wander", "roll", 100]
    assert_allclose(found, [np.sqrt((0.25 + 4 + 16) / 3), 1.0, 1 / 3, 2 / 3])


def test_smoother_gives_the_heading_of_the_end_to_the_start(stored):
    rms = simulation_runs.statistics(stored).rms
    heading = rms.xs("heading", level="quantity")
    # gyros carry the heading of the end back; their bias about up, known to 0.9 deg/h at the end, adds what it turns
    rms_of_bias = rms["smoothed", "bias_x", 900]
    assert heading["smoothed", 100] < heading["wander", 900] + rms_of_bias * 800 / 3600
    assert heading["smoothed", 100] < 0.1 * heading["wander", 100]


def test_varied_inputs(monkeypatch):
    names = [("as assumed", next(v for k, v in simulation.VARIED if k == "as assumed")), ("latitude", "0°")]
    names += [("scale factors at the start", "5 %"), ("sampling", "10 Hz"), ("mount on after", "0 s")]
    monkeypatch.setattr(simulation, "VARIED", {key: simulation.VARIED[key] for key in names})
    table = simulation.varied_inputs()
    base, equator, scale, slow, on = (table.loc[key] for key in names)
    # the level Earth rate is what heading is found from; the walk about up adds 0.01 deg, and is the same everywhere
    assert_allclose(equator.heading_500 / base.heading_500, np.cos(paper.ASSUMED_LATITUDE), rtol=0.04)
    assert_allclose(scale.filter(like="_500"), base.filter(like="_500"), rtol=1e-3)
    assert_allclose(slow, base, rtol=2e-3)
    assert on.heading_0 == pytest.approx(simulation.ASSUMED_PRIOR.heading / DEG)
    assert on.heading_500 > base.heading_500  # what the gyros said of the Earth before counts as well


def test_inputs_are_what_off_then_on_takes():
    one = simulation.off_then_on(0.01)[1].std
    assert_allclose(one, simulation.off_then_on(inputs=simulation.Inputs())[1].std, rtol=1e-12)
