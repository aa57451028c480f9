"""What the ledger's rows do not already hold of the reproduction of Miklyashev (2019)."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.reproduction.miklyashev import derivation, make_gyro, simulation
from fogkit.units import MICROMETRE


def test_figure_1_is_one_period_of_the_squared_acceleration():
    curves = simulation.figure_1()
    time = curves.index.to_numpy()
    assert time[0] >= 0 and time[-1] < 1 / 60 and len(curves) in (208, 209)
    # the second degree follows the square of the acceleration, which is largest where the rate is zero
    shape = np.cos(2 * np.pi * 60 * time) ** 2
    peak = curves.second_degree.min()
    assert_allclose(curves.second_degree, peak * shape, atol=0.04 * abs(peak))  # the loop's lag of 80 us, 0.03 rad
    # the third degree is odd: it raises one half-cycle and lowers the other
    difference = (curves.full - curves.second_degree).to_numpy()
    assert np.sign(difference[5]) == -np.sign(difference[109])


def test_wavelengths_that_print_do_and_others_do_not():
    low, high = simulation.wavelengths_that_round_to_the_print()
    for wavelength, prints in (
        (low * 1.0005, True),
        (high * 0.9995, True),
        (low * 0.9995, False),
        (high * 1.0005, False),
    ):
        size = abs(simulation.mean_drift(make_gyro(wavelength=wavelength * MICROMETRE)))
        assert (simulation.PRINTED_MEAN[0] <= size < simulation.PRINTED_MEAN[1]) == prints


def test_choices_agree_with_the_law_of_the_wavelength():
    choices = simulation.open_choices()
    table = choices[choices.start == "any"].pivot(index="wavelength", columns="half_period", values="drift")
    # drift times wavelength is one number for each half-period, but for the fourth power of the residual, 4e-5
    product = table.mul(table.index, axis=0)
    assert (product.std() / product.mean().abs()).max() < 1e-4
    assert choices.prints.any() and not choices.prints.all()


def test_crossing_is_where_the_table_puts_it():
    crossing = simulation.acceleration_where_models_differ()
    difference = simulation.mean_differences().difference
    assert difference[20000] < 0.1 < difference[30000]
    assert 20000 < crossing < 30000


def test_derivation_knows_wrong_equations():
    with pytest.raises(KeyError):
        derivation.holds("eq99")
    assert derivation.holds("eq05") and not derivation.holds_with_the_other_sign("eq05")
