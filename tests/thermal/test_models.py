"""Models of the slides: their terms, their design, and what they refuse."""

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_array_equal

from fogkit.thermal import TemperatureModel, Term, models

TABLE = pd.DataFrame({"temperature_a": [20.0, 30.0], "rate_a": [0.1, 0.2]}, index=pd.Index([0.0, 1.0], name="time"))


def test_models_have_the_variables_that_the_slides_count():
    assert models.single_point("a").names == ("constant", "temperature_a", "rate_a")
    assert models.start_up_short("a").names == ("constant", "temperature_a")
    assert len(models.start_up_long().terms) == 4
    assert len(models.steady_state().terms) == 6
    assert models.steady_state().points == ("coil_top", "coil_bottom", "electronics")
    assert models.accelerometer_bias("a").names == ("constant", "temperature_a", "temperature_a^2", "temperature_a^3")
    assert models.scale_factor("a").names == ("constant", "temperature_a")
    assert models.constant_only().names == ("constant",)
    assert models.several_points(["a", "b"]).name == "2 points with rates"


def test_design_takes_powers_of_the_temperature_less_the_reference():
    model = TemperatureModel(
        name="m", terms=[Term(point="a"), Term(point="a", power=3), Term(point="a", rate=True)], reference=25
    )
    assert_array_equal(model.design(TABLE), [[1, -5, -125, 0.1], [1, 5, 125, 0.2]])
    assert model.of_point("a") == [1, 2, 3]
    assert model.without("a").names == ("constant",)
    assert TemperatureModel.from_dict(model.to_dict()) == model


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: models.steady_state().design(TABLE, name="runs"), "`runs` must be .* without 'temperature_coil_top'"),
        (lambda: models.single_point("a").design(TABLE.drop(columns="rate_a")), "without 'rate_a'. `thermal.rates"),
        (lambda: models.single_point("a").design(TABLE * np.nan), r"`table\['temperature_a'\]` must be finite"),
        (lambda: Term(point="a", power=0), "`power`"),
        (lambda: Term(point="a", power=2, rate=True), "`power` must be 1 for a rate"),
        (lambda: TemperatureModel(name="m", terms=[Term(point="a")] * 2), "`terms` must be different"),
        (lambda: models.single_point("a").without("b"), "`point` must be one of 'a', got 'b'"),
        (lambda: models.start_up_short("a", degree=0), "`degree`"),
    ],
)
def test_bad_input_is_named(call, words):
    with pytest.raises(ValueError, match=words):
        call()


def test_terms_must_be_terms():
    with pytest.raises(TypeError, match="`terms`"):
        TemperatureModel(name="m", terms=["temperature_a"])
