"""The thesis's equations against finite differences: that the differences are right, and that a wrong sign shows."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.reproduction.lechang import derivation, differences


@pytest.fixture(scope="module")
def table():
    return differences.comparison(points=2)


def test_derivative_is_of_the_fourth_order():
    errors = [abs(differences.derivative(np.exp, 0.3, h) - np.exp(0.3)) for h in (0.2, 0.1)]
    assert_allclose(np.log2(errors[0] / errors[1]), 4, atol=0.05)  # the next term is h**2/20 of it
    assert_allclose(differences.derivative(lambda x: x**4, 0.7, 0.5), 4 * 0.7**3, rtol=1e-13)


def test_print_as_restored_is_what_the_model_does(table):
    assert set(table.index) == set(derivation.equations())
    # height's column is the worst: V/R**2 times a step of 30 km beside a rate of 0.1 rad/s in double precision
    assert (table.numbers < 1e-7).all()
    assert (table.symbols < 1e-20).all()
    assert table.unreadable["eq17-gyro-x"] == "nearly all" and table.unreadable["eq06-trim"] == ""


@pytest.mark.parametrize("name", ["eq06-heading", "eq08-velocity-east", "eq08-gyro-y", "eq14-rate", "eq17-trim"])
def test_a_wrong_sign_shows_in_numbers(name, monkeypatch):
    right = derivation.equations()[name]
    wrong = {**derivation.equations(), name: derivation.Equation(right.derived, -right.printed)}
    monkeypatch.setattr(derivation, "equations", lambda: wrong)
    values = differences.point(0)
    assert_allclose(differences.by_differences(name, values), -differences.by_print(name, values), rtol=1e-6)


def test_points_are_random_and_consistent():
    one, other = differences.point(1), differences.point(2)
    assert one != other and one == differences.point(1)
    assert abs(one["theta"]) < 0.6 and abs(one["V_E"]) < 300
