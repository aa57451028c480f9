import math
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import pytest

from fogkit.campaign import map_cases
from fogkit.optics.measure import simulated_drift
from fogkit.optics.motion import AngularOscillation
from fogkit.optics.simulate import FringeLockError
from fogkit.reproduction.miklyashev import SIMULATED

CASES = [
    {"gyro": SIMULATED, "oscillation": AngularOscillation(acceleration=a, frequency=60.0), "duration": 0.4}
    for a in (10.0, 50.0, 90.0)
]


def slow_then_fast(wait, value):
    time.sleep(wait)
    return value


@pytest.mark.parametrize("workers", [1, 3])
def test_results_are_the_same_on_any_number_of_workers(workers):
    with ThreadPoolExecutor(workers) as pool:
        assert map_cases(simulated_drift, CASES, executor=pool) == [simulated_drift(**case) for case in CASES]


def test_a_process_pool_is_made_where_none_is_given():
    # Python 3.12 and later warn where a process with threads is forked; a pool that is fresh for the test has none
    assert map_cases(math.pow, []) == []
    with ProcessPoolExecutor(2) as pool:
        assert map_cases(slow_then_fast, [{"wait": 0.0, "value": 1}], executor=pool) == [1]


def test_results_come_in_the_order_of_the_cases():
    cases = [{"wait": 0.2, "value": 1}, {"wait": 0.0, "value": 2}]
    with ThreadPoolExecutor(2) as pool:
        assert map_cases(slow_then_fast, cases, executor=pool) == [1, 2]


def test_a_failure_is_raised_and_what_has_not_begun_is_cancelled():
    begun = []

    def work(value):
        begun.append(value)
        time.sleep(0.01)
        return 1 / value

    with ThreadPoolExecutor(1) as pool, pytest.raises(ZeroDivisionError):
        map_cases(work, [{"value": v} for v in (1, 0, *range(2, 200))], executor=pool)
    assert len(begun) < 100


def test_a_progress_bar_counts_the_cases(capsys):
    with ThreadPoolExecutor(1) as pool:
        map_cases(slow_then_fast, [{"wait": 0, "value": 1}] * 3, executor=pool, progress="sweep")
    shown = capsys.readouterr().err
    assert "sweep" in shown and "3/3" in shown


def test_cases_must_be_mappings():
    with ThreadPoolExecutor(1) as pool, pytest.raises(TypeError, match=r"`cases`.*case 2"):
        map_cases(slow_then_fast, [{"wait": 0, "value": 1}, 3], executor=pool)


def test_a_lost_fringe_comes_back_from_a_process_pool():
    lost = {"gyro": SIMULATED, "oscillation": AngularOscillation(acceleration=2e4, frequency=60.0), "duration": 0.4}
    with ProcessPoolExecutor(1) as pool, pytest.raises(FringeLockError, match="fringe lock lost"):
        map_cases(simulated_drift, [lost], executor=pool)
