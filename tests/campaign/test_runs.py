import inspect
import json
import math
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import partial

import campaign_cases
import numpy as np
import pandas as pd
import pytest
from campaign_cases import Gyro, dies, flaky, given, held_back, inverse, noisy_mean, odd, scaled, slow_campaign
from hypothesis import given as examples
from hypothesis import settings
from hypothesis import strategies as st
from pandas.testing import assert_frame_equal

from fogkit.campaign import (
    CampaignMismatchError,
    attempts,
    case_generator,
    grid,
    read_campaign,
    run_campaign,
    runs,
    store,
)
from fogkit.campaign.identity import case_identity, seed_text

CASES = grid({"bias": [0.0, 1.0], "count": [3, 4, 5]})


def run(*arguments, workers=1, **options):
    with ThreadPoolExecutor(workers) as pool:
        return run_campaign(*arguments, executor=pool, progress=False, **options)


def same(first, second):
    """Equal to the last bit, but for the times that they took."""
    assert_frame_equal(first.drop(columns="run_time"), second.drop(columns="run_time"), check_exact=True)


@pytest.fixture(scope="module")
def noisy(tmp_path_factory):
    return run(noisy_mean, CASES, tmp_path_factory.mktemp("noisy"), seed=7, repeats=2)


def test_a_result_is_that_of_the_function_on_the_stream_of_the_case(noisy):
    assert list(noisy.columns[:5]) == ["bias", "count", "deviation", "mean", "repeat"]
    assert noisy[["bias", "count", "repeat"]].values.tolist() == [
        [bias, count, repeat] for bias in (0, 1) for count in (3, 4, 5) for repeat in (0, 1)
    ]
    for _, row in noisy.iterrows():
        assert noisy_mean(row["bias"], row["count"], case_generator(row["seed"]))["mean"] == row["mean"]
    assert (noisy.run_time > 0).all() and (noisy.attempts == 1).all() and noisy.exception.isna().all()


def test_streams_are_spawned_and_differ(noisy):
    first = json.loads(noisy.seed[1])
    parent = np.random.SeedSequence(7, spawn_key=tuple(first["spawn_key"][:-1]))
    spawned = np.random.default_rng(parent.spawn(2)[1])
    assert noisy_mean(0.0, 3, spawned)["mean"] == noisy["mean"][1]
    assert noisy.seed.nunique() == 12 and noisy["deviation"].nunique() == 12


@pytest.mark.parametrize("workers", [2, 5])
def test_results_are_the_same_on_any_number_of_workers(noisy, workers, tmp_path):
    same(run(noisy_mean, CASES, tmp_path, seed=7, repeats=2, workers=workers, window=3), noisy)


def test_results_are_the_same_in_processes(noisy, tmp_path):
    with ProcessPoolExecutor(2) as pool:
        found = run_campaign(noisy_mean, CASES, tmp_path, seed=7, repeats=2, executor=pool, progress=False)
    same(found, noisy)


def test_cases_and_repeats_can_be_added_anywhere_in_a_table_or_a_list(noisy, tmp_path):
    few = [{"count": 4, "bias": 1}, {"count": np.int64(3), "bias": np.float64(0)}]
    begun = run(noisy_mean, few, tmp_path, seed=7)
    assert len(begun) == 2
    files = set(store.parts(tmp_path))
    same(run(noisy_mean, CASES, tmp_path, seed=7, repeats=2), noisy)
    assert files < set(store.parts(tmp_path))
    assert len(store.stored(tmp_path)) == 12 == sum(len(pd.read_parquet(p)) for p in store.parts(tmp_path))


@settings(max_examples=8)
@examples(st.data())
def test_results_are_the_same_after_any_restarts_in_any_order(tmp_path_factory, data):
    # each session knows some more of the cases, in an order of its own
    order = data.draw(st.permutations(range(6)))
    ends = [*sorted(data.draw(st.lists(st.integers(1, 6), max_size=2))), 6]
    folder = tmp_path_factory.mktemp("restarts")
    for end in ends:
        table = run(noisy_mean, CASES.iloc[order[:end]], folder, seed=7, workers=data.draw(st.integers(1, 2)))
    expected = [noisy_mean(**case, rng=case_generator(_seed(case)))["mean"] for case in CASES.to_dict("records")]
    assert table["mean"].tolist() == [expected[i] for i in order]


def _seed(case):
    return seed_text(7, case_identity(case), 0)


def test_a_killed_campaign_goes_on_where_it_stopped(tmp_path):
    code = f"import sys; sys.path[:0] = {sys.path!r}; import campaign_cases as c; c.slow_campaign(sys.argv[1], None)"
    killed = subprocess.Popen([sys.executable, "-c", code, str(tmp_path)], stdout=subprocess.PIPE)
    try:
        deadline = time.monotonic() + 60
        while len(store.parts(tmp_path)) < 8:
            assert killed.poll() is None and time.monotonic() < deadline
            time.sleep(0.002)
    finally:
        killed.kill()
        killed.communicate(timeout=30)  # the pipe ends when the last of its workers does
    before = {path: path.read_bytes() for path in store.parts(tmp_path)}
    begun = read_campaign(tmp_path)
    assert 8 <= len(begun) < 40
    with ThreadPoolExecutor(2) as pool:
        stored = _counted(lambda: slow_campaign(tmp_path, pool))
        whole = slow_campaign(tmp_path / "whole", pool)
    assert stored == 40 - len(begun)  # none that was stored is run again
    assert all(path.read_bytes() == content for path, content in before.items())
    same(read_campaign(tmp_path), whole)


def _counted(action):
    """Number of results that an action stores."""
    number, append = [], store.append
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(store, "append", lambda folder, rows: (number.append(len(rows)), append(folder, rows)))
        action()
    return sum(number)


def test_a_write_that_is_cut_short_spoils_nothing(noisy, tmp_path, monkeypatch):
    run(noisy_mean, CASES[:3], tmp_path, seed=7, repeats=2)
    before = store.stored(tmp_path)

    def cut(table, file):
        file.write(b"PAR1 and then the disk is full")
        raise OSError("No space left on device")

    with monkeypatch.context() as patch, pytest.raises(OSError, match="No space"):
        patch.setattr("pyarrow.parquet.write_table", cut)
        run(noisy_mean, CASES, tmp_path, seed=7, repeats=2)
    assert store.stored(tmp_path) == before
    same(run(noisy_mean, CASES, tmp_path, seed=7, repeats=2), noisy)


def test_results_wait_no_longer_than_the_interval(tmp_path):
    # a silence after a result: it must be on the disk before the next one comes
    arguments = (held_back, [{"value": 0}, {"value": 1}], tmp_path)
    thread = threading.Thread(target=run, args=arguments, kwargs={"interval": 0.05})
    thread.start()
    try:
        deadline = time.monotonic() + 20
        while not store.parts(tmp_path):
            assert time.monotonic() < deadline
            time.sleep(0.01)
        assert len(read_campaign(tmp_path)) == 1
    finally:
        campaign_cases.LET_GO.set()
        thread.join()
    assert len(read_campaign(tmp_path)) == 2


def test_no_more_than_the_window_is_submitted(tmp_path):
    class Counting(ThreadPoolExecutor):
        most = 0

        def submit(self, *arguments, **keywords):
            future = super().submit(*arguments, **keywords)
            self.most = max(self.most, self._work_queue.qsize())
            return future

    with Counting(1) as pool:
        run_campaign(scaled, grid({"value": range(300)}), tmp_path, executor=pool, window=4, progress=False)
    assert 1 < pool.most <= 4


def test_a_failure_is_kept_with_its_inputs(tmp_path):
    with pytest.warns(
        UserWarning, match="2 of 4 runs failed, the first with ZeroDivisionError: float division by zero"
    ):
        table = run(inverse, grid({"value": [2.0, 0.0, "x", 4.0]}), tmp_path, seed=None)
    assert table["result"][[0, 3]].tolist() == [0.5, 0.25] and table["result"][[1, 2]].isna().all()
    assert table["value"].tolist() == [2.0, 0.0, "x", 4.0]
    assert table["exception"][[1, 2]].tolist() == ["ZeroDivisionError", "TypeError"]
    assert "return 1 / value" in table["traceback"][1]
    assert table["attempts"].tolist() == [1, 1, 1, 1]


def test_failures_are_tried_again_if_asked(tmp_path):
    cases = [{"path": str(tmp_path / "calls"), "times": 2}]
    folder = tmp_path / "campaign"
    with pytest.warns(UserWarning, match="1 of 1 runs failed"):
        assert run(flaky, cases, folder).exception[0] == "OSError"
    with pytest.warns(UserWarning, match="1 of 1 runs failed"):
        run(flaky, cases, folder)
    assert (tmp_path / "calls").stat().st_size == 1  # a failure is kept unless it is asked for again
    table = run(flaky, cases, folder, again=True, retries=3)
    assert table["result"].tolist() == [3] and table["attempts"].tolist() == [2] and table.exception.isna().all()


def test_a_retry_has_the_same_random_numbers():
    drawn = []

    def draws(rng):
        drawn.append(rng.random())
        raise OSError

    assert attempts.attempt(draws, {}, seed_text(1, "0" * 32, 0), 2)["attempts"] == 3
    assert len(drawn) == 3 and len(set(drawn)) == 1


def test_results_of_all_kinds_come_back_exactly(tmp_path):
    kinds = ["array", "record", "large", "none", "flag", "text", "nan", "complex", "entries", "keys"]
    with pytest.warns(UserWarning, match="2 of 10 runs failed"):
        table = run(odd, grid({"kind": kinds}), tmp_path).set_index("kind")
    single = table["result"]
    assert single["array"] == [0, 1, 2] and single["large"] == 2**60 + 1 and single["flag"] is True
    assert single["text"] == "µ \ud800" and math.isnan(single["nan"]) and pd.isna(single["none"])
    assert (table["noise"]["record"], table["axes"]["record"]) == (0.5, ["x", "y"])
    assert (table["a"]["entries"], table["b"]["entries"]) == (1, [1, 2])
    assert "it is a complex" in table["message"]["complex"] and "names of its entries" in table["message"]["keys"]


floats = st.floats() | st.integers(-(2**70), 2**70) | st.booleans() | st.text(max_size=5) | st.none()


@settings(max_examples=12)
@examples(st.lists(floats | st.lists(floats, max_size=2), min_size=1, max_size=6))
def test_what_goes_in_comes_out(tmp_path_factory, values):
    folder = tmp_path_factory.mktemp("values")
    (folder / "results").mkdir()
    rows = [
        {"identity": f"{i:032}", "place": i, "repeat": 0, "input": {"value": value}, "output": {"result": value}}
        | dict.fromkeys(store.BOOKKEEPING)
        for i, value in enumerate(values)
    ]
    store.append(folder, rows)
    gathered = store.gathered(folder)
    table = store.ordered(gathered, gathered["place"], ["value"])
    for column in ("value", "result"):
        for value, found in zip(values, table[column], strict=True):
            if value is None or value != value:
                assert pd.isna(found)
            elif isinstance(value, list):
                assert repr(found) == repr(value)  # in text NaN is NaN
            else:
                assert found == value and isinstance(found, str) == isinstance(value, str)


def test_a_run_that_is_stored_twice_is_read_once(tmp_path):
    table = run(scaled, grid({"value": [1, 2]}), tmp_path)
    for path in store.parts(tmp_path):
        path.with_name(path.name.replace("part-", "part-9")).write_bytes(path.read_bytes())
    same(read_campaign(tmp_path), table)


def test_names_that_meet_keep_their_side(tmp_path):
    table = run(given, [{"values": {"values": 2, "seed": 3, "x": 4}}], tmp_path)
    assert (table["output.values"][0], table["output.seed"][0], table["x"][0]) == (2, 3, 4)
    assert table["values"][0] == {"values": 2, "seed": 3, "x": 4}


def test_the_loss_of_a_worker_ends_the_run_and_keeps_what_came(tmp_path):
    cases = grid({"value": range(6)})
    with ProcessPoolExecutor(1) as pool, pytest.raises(BrokenProcessPool):
        run_campaign(dies, cases, tmp_path, executor=pool, progress=False, window=1)
    assert read_campaign(tmp_path)["result"].tolist() == [0, 1, 2]


def test_a_process_pool_is_made_where_none_is_given(tmp_path, monkeypatch):
    # Python 3.12 and later warn where a process with threads is forked, as one of the tests is: threads stand in
    monkeypatch.setattr(runs, "process_pool", ThreadPoolExecutor)
    assert run_campaign(scaled, [{"value": 2}], tmp_path, progress=False)["result"].tolist() == [2]


BEFORE = {"cases": [{"value": 1}], "common": {"gyro": Gyro(noise=0.1)}, "seed": None}


@pytest.mark.parametrize(
    ("function", "changed", "words"),
    [
        (
            given,
            {"cases": [{"values": 1}], "common": {}},
            "function was 'campaign_cases.scaled' and is 'campaign_cases.g",
        ),
        (scaled, {"cases": [{"gyro": None}], "common": {"value": 1}}, "the parameters were .'value'. and are .'gyro'."),
        (scaled, {"common": {"gyro": Gyro(noise=0.2)}}, "`common` differs in `gyro`.*0.1.*0.2"),
        (scaled, {"common": {}}, "`common` differs in `gyro`.*absent"),
        (scaled, {"cases": [{"value": 2}]}, "results of 1 cases that are not among `cases`, such as value=1"),
    ],
)
def test_another_campaign_is_refused(function, changed, words, tmp_path):
    run(scaled, folder=tmp_path, **BEFORE)
    with pytest.raises(CampaignMismatchError, match=words):
        run(function, folder=tmp_path, **(BEFORE | changed))
    assert len(run(scaled, folder=tmp_path, **BEFORE)) == 1


def test_another_seed_and_fewer_repeats_are_refused(tmp_path):
    options = {"seed": 1, "repeats": 2}
    run(noisy_mean, CASES[:1], tmp_path, **options)
    with pytest.raises(CampaignMismatchError, match="seed was 1 and is 2"):
        run(noisy_mean, CASES[:1], tmp_path, **options | {"seed": 2})
    with pytest.raises(CampaignMismatchError, match="up to 2 repeats"):
        run(noisy_mean, CASES[:1], tmp_path, **options | {"repeats": 1})


def test_another_version_or_text_is_warned_of(tmp_path, monkeypatch):
    run(scaled, [{"value": 1}], tmp_path)
    with monkeypatch.context() as patch, pytest.warns(UserWarning, match="begun with fogkit .* goes on with 99"):
        patch.setattr(runs, "__version__", "99")
        run(scaled, [{"value": 1}], tmp_path)
    with monkeypatch.context() as patch, pytest.warns(UserWarning, match="text of campaign_cases.scaled has changed"):
        patch.setattr(inspect, "getsource", lambda function: "def scaled(): return 0")
        run(scaled, [{"value": 1}], tmp_path)


@pytest.mark.parametrize(
    ("function", "cases", "options", "error", "words"),
    [
        (scaled, [{"value": 1}, {"value": 1.0}], {}, ValueError, "case 2 is case 1 again: value=1.0.*`repeats`"),
        (scaled, [{"value": 1}, {"gyro": 1}], {}, ValueError, "the same arguments, got .'gyro'. in case 2"),
        (scaled, [{"value": object()}], {}, TypeError, "argument `value` of case 1 cannot be stored: it is a object"),
        (scaled, [{"value": {1, 2}}], {}, TypeError, "it is a set"),
        (scaled, [{"value": [1, 1j]}], {}, TypeError, r"`value` of case 1\[1\] cannot be stored"),
        (scaled, [{"value": lambda: 1}], {}, TypeError, "can be imported by its name"),
        (scaled, [{"value": 1}, 3], {}, TypeError, "mappings of argument names to values, got 3 as case 2"),
        (scaled, {"value": [1]}, {}, TypeError, "got 'value' as case 1"),
        (scaled, pd.DataFrame({0: [1]}), {}, TypeError, "names of arguments for columns"),
        (scaled, [], {}, ValueError, "at least one case"),
        (scaled, [{"wrong": 1}], {}, TypeError, "cannot be called with the arguments .'wrong'."),
        (scaled, [{"value": 1}], {"seed": 1}, TypeError, "'rng'"),
        (scaled, [{"value": 1}], {"common": {"value": 2}}, ValueError, "both give .'value'"),
        (scaled, [{"value": 1}], {"common": {"gyro": object()}}, TypeError, r"`common\['gyro'\]` cannot be stored"),
        (noisy_mean, [{"bias": 0, "count": 1, "rng": 2}], {"seed": 1}, ValueError, "its own `rng`"),
        (lambda value: value, [{"value": 1}], {}, TypeError, "imported by its name, got <function"),
        (partial(scaled, gyro=None), [{"value": 1}], {}, TypeError, "`common`"),
        (scaled, [{"value": 1}], {"repeats": 0}, ValueError, "`repeats`"),
        (scaled, [{"value": 1}], {"seed": -1}, ValueError, "`seed`"),
    ],
)
def test_wrong_input_is_told_before_anything_runs(function, cases, options, error, words, tmp_path):
    with pytest.raises(error, match=words):
        run(function, cases, tmp_path / "new", **options)
    assert not (tmp_path / "new").exists()


def test_folders_that_are_no_campaign_are_told(tmp_path):
    with pytest.raises(ValueError, match="does not exist"):
        read_campaign(tmp_path)
    run(scaled, [{"value": 1}], tmp_path)
    (part,) = store.parts(tmp_path)
    part.write_bytes(part.read_bytes()[:-9])
    with pytest.raises(ValueError, match=f"{part.name} is damaged.*Delete it"):
        run(scaled, [{"value": 1}], tmp_path)
    part.unlink()
    assert len(run(scaled, [{"value": 1}], tmp_path)) == 1
    (tmp_path / "campaign.json").write_text('{"format": 99}')
    with pytest.raises(CampaignMismatchError, match="format 1"):
        read_campaign(tmp_path)
    (tmp_path / "campaign.json").write_text("{")
    with pytest.raises(ValueError, match="not the description of a campaign"):
        read_campaign(tmp_path)
    (tmp_path / "campaign.json").unlink()
    with pytest.raises(CampaignMismatchError, match=r"no campaign\.json"):
        run(scaled, [{"value": 1}], tmp_path)


def test_a_campaign_without_results_is_an_empty_table(tmp_path):
    store.describe(tmp_path, {"parameters": ["value"]})
    assert list(read_campaign(tmp_path).columns)[:2] == ["value", "repeat"]


def test_a_progress_bar_counts_what_was_done_before(tmp_path, capsys):
    run(scaled, grid({"value": [1, 2]}), tmp_path)
    with ThreadPoolExecutor(1) as pool:
        run_campaign(scaled, grid({"value": [1, 2, 3]}), tmp_path, executor=pool, progress="study")
    assert "study" in (shown := capsys.readouterr().err) and "2/3" in shown and "3/3" in shown
