import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kstest, norm

from fogkit.campaign import grid, spread


@given(st.lists(st.lists(st.integers(), min_size=1, max_size=3, unique=True), min_size=1, max_size=4))
def test_a_grid_holds_every_combination_once(levels):
    table = grid({f"x{i}": values for i, values in enumerate(levels)})
    assert len(table) == np.prod([len(values) for values in levels]) == len(table.drop_duplicates())
    assert all(table[f"x{i}"].isin(values).all() for i, values in enumerate(levels))


def test_a_grid_keeps_the_kinds_of_its_values():
    table = grid({"name": ("a", "b"), "number": np.array([1, 2]), "pair": [(1, 2)]})
    assert table.number.dtype.kind == "i" and table.pair[0] == (1, 2)
    assert table.to_dict("records")[1] == {"name": "a", "number": 2, "pair": (1, 2)}


@pytest.mark.parametrize("method", ["sobol", "halton", "latin hypercube", "random"])
def test_points_are_spread_over_ranges_and_distributions(method):
    points = spread(256, {"gain": (1, 3), "bias": norm(5, 2)}, seed=3, method=method)
    assert points.gain.between(1, 3).all()
    # independent draws pass at 0.1 %; low discrepancy lies far closer to the distribution than these
    p = kstest(points.bias, norm(5, 2).cdf).pvalue, kstest(points.gain, lambda x: (x - 1) / 2).pvalue
    assert min(p) > (0.001 if method == "random" else 0.999)
    pd.testing.assert_frame_equal(points, spread(256, {"gain": (1, 3), "bias": norm(5, 2)}, seed=3, method=method))
    assert not points.equals(spread(256, {"gain": (1, 3), "bias": norm(5, 2)}, seed=4, method=method))


@pytest.mark.parametrize("method", ["sobol", "halton", "random"])
def test_more_points_begin_with_the_same(method):
    few, many = (spread(n, {"x": (0, 1), "y": (0, 1)}, seed=1, method=method) for n in (16, 64))
    assert few.equals(many[:16])


def test_what_is_wrong_with_a_design_is_told():
    with pytest.raises(TypeError, match=r"`levels` must hold a list of values for `x`, got 3.*\[3\]"):
        grid({"x": 3})
    with pytest.raises(ValueError, match="at least one value for `x`"):
        grid({"x": []})
    with pytest.raises(ValueError, match="at least one argument"):
        grid({})
    with pytest.raises(TypeError, match="`levels` must be a Mapping"):
        grid([1])
    with pytest.raises(ValueError, match="low < high"):
        spread(4, {"x": (1, 1)}, seed=1)
    with pytest.raises(ValueError, match=r"`ranges\['x'\]` must be of shape \(2\)|shape"):
        spread(4, {"x": (1, 2, 3)}, seed=1)
    with pytest.raises(ValueError, match="`method` must be one of"):
        spread(4, {"x": (1, 2)}, seed=1, method="grid")
    with pytest.warns(UserWarning, match="power of 2"):
        spread(5, {"x": (1, 2)}, seed=1)
