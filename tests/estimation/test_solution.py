import dataclasses
import json

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from fogkit.estimation import Solution, linear

LINE = linear([[1, 0], [1, 1], [1, 2]], [1.0, 3.0, 5.3], standard_deviation=0.1, names=["bias", "slope"])
OPEN = linear([[1, 0, 1], [2, 0, 2]], [1, 2], standard_deviation=1, names=["k", "gamma_xz", "level"])


@given(seed=st.integers(0, 2**32 - 1), scale=st.sampled_from(["given", "estimated"]))
def test_json_round_trip_is_exact(seed, scale):
    rng = np.random.default_rng(seed)
    solution = linear(rng.standard_normal((7, 3)), rng.standard_normal(7), standard_deviation=0.3, scale=scale)
    assert_equal(Solution.from_json(solution.to_json()), solution)


def test_json_holds_what_is_open():
    assert_equal(Solution.from_json(OPEN.to_json()), OPEN)
    json.loads(OPEN.to_json(), parse_constant=pytest.fail)  # Infinity and NaN are no JSON
    assert Solution.from_json(OPEN.to_json()).condition == np.inf


def assert_equal(one, other):
    for field in dataclasses.fields(Solution):
        value, expected = getattr(one, field.name), getattr(other, field.name)
        assert type(value) is type(expected), field.name
        if isinstance(value, np.ndarray):
            assert value.dtype == expected.dtype
            assert_array_equal(value, expected, strict=True)
        else:
            assert value == expected or value != value, field.name


def test_json_of_another_record():
    with pytest.raises(ValueError, match=r"`text` must hold the fields `names`, .*got \['estimate'\]"):
        Solution.from_json('{"estimate": []}')


def test_values_by_name():
    assert LINE["slope"] == LINE.estimate[1]
    with pytest.raises(KeyError, match=r"`slop` is no parameter of this solution; they are `bias`, `slope`"):
        LINE["slop"]


def test_table():
    table = LINE.to_frame()
    assert table.index.name == "name"
    expected = {"estimate": LINE.estimate, "standard_deviation": LINE.standard_deviation}
    pd.testing.assert_frame_equal(table, pd.DataFrame(expected, index=pd.Index(["bias", "slope"], name="name")))


def test_correlation_of_a_line():
    # sums over 0, 1, 2: -3 / sqrt(3 * 5)
    np.testing.assert_allclose(LINE.correlation, [[1, -3 / np.sqrt(15)], [-3 / np.sqrt(15), 1]], rtol=1e-14)  # rounding
    assert_array_equal(np.isnan(OPEN.correlation), ~np.eye(3, dtype=bool))
    assert_array_equal(np.diag(OPEN.correlation), 1)  # exact, also where the variance is infinite


def test_record_cannot_be_edited():
    with pytest.raises(ValueError, match="read-only"):
        LINE.covariance[0, 0] = 0
    with pytest.raises(dataclasses.FrozenInstanceError):
        LINE.rank = 1


def test_open_directions_in_words():
    words = (
        "the plan does not determine `k`, `gamma_xz`, `level`: "
        "no observation changes along `k` -1 `level`; no observation depends on `gamma_xz`"
    )
    with pytest.raises(ValueError, match=words):
        OPEN.raise_if_unobservable("the plan")
    LINE.raise_if_unobservable()


def test_import_is_light():
    import subprocess
    import sys

    code = "import sys, fogkit.estimation; print(*{'pandas', 'scipy'} & set(sys.modules))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == ""
