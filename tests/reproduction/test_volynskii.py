"""What the rows of the ledger rest on and do not test themselves: the error budget, and that the proofs can fail."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.calibration import requirements
from fogkit.reproduction.volynskii import budget, derivation, instruments, simulation
from fogkit.units import ARCMIN, DEG_PER_SECOND

RUNS = 20_000


@pytest.mark.parametrize("factor", budget.NOISE_FACTORS.values(), ids=budget.NOISE_FACTORS)
def test_deviations_are_those_of_simulated_tests(factor):
    test = budget.ScaleFactorTest(noise_factor=factor)
    errors = budget.simulate(test, RUNS, np.random.default_rng(5), steps=60)
    # 4 sigma of a standard deviation from this many runs
    tolerance = 4 / np.sqrt(2 * RUNS)
    assert_allclose(errors.std(axis=1), [test.deviation, test.asymmetry_deviation], rtol=tolerance)


def test_noise_has_the_variance_of_its_convention():
    # band-limited white noise of two-sided density C^2 per rad/s: its variance is the density times the bandwidth
    noise, duration, step = 0.3, 50.0, 0.5
    variance = noise**2 * 2 * np.pi / step  # from -pi/step to pi/step
    integrals = np.random.default_rng(8).normal(0, np.sqrt(variance), (RUNS, round(duration / step))).sum(axis=1) * step
    part = budget.ScaleFactorTest(duration=duration, noise=noise).parts["noise"]
    assert_allclose(integrals.std(), part, rtol=4 / np.sqrt(2 * RUNS))


def test_linear_print_of_eq22_exceeds_the_combination_of_independent_parts():
    test = budget.ScaleFactorTest()
    assert_allclose(test.printed, 2.25e-7, rtol=1e-3)  # (2 + 3.6 + 4.756) arcsec over 4.6e7 arcsec, by hand
    assert test.printed > 1.5 * test.deviation


def test_readings_of_eq22():
    table = budget.readings_of_eq22()
    assert len(table) == 2 * 2 * 2 * 4 * 2
    best = table.iloc[0]
    assert (best.readings, best["sum"], best.density) == (1, "root of squares", budget.PRINTED_CONVENTION)
    assert best.angle == "4.6e7 arcsec" and best.scale == 1
    # the print is this with its digits cut, and no reading rounds to it
    assert np.floor(best.result * 1e9) == 136
    assert not (np.round(table.result * 1e9) == 136).any()


def test_bias_error_changes_a_simulated_scale_factor_between_rates_as_table_2_does():
    # 1 deg/s for 360 s with the bias error of the example held at one sigma and nothing else wrong
    rate, scale = 1 * DEG_PER_SECOND, 1.664746
    reading = rate / scale + instruments.EXAMPLE_BIAS_ERROR / scale
    assert_allclose(scale - rate / reading, budget.bias_spread(rate, scale), rtol=1e-5)
    largest = max(cell["spread"] for cell in instruments.TABLE_2.values())
    assert 0.9 < budget.bias_spread(rate, scale) / largest < 1.1


def test_drifts_of_table_2_by_simulation_and_by_formula():
    amplitude = simulation.rocking_amplitude()
    formula = [abs(requirements.drift_from_asymmetry(a, amplitude)) for a in simulation.asymmetries().values()]
    # scale factors in rate per reading differ from those in reading per rate in the second order of the asymmetry
    assert_allclose(list(simulation.rocking_drifts_of_table_2().values()), formula, rtol=1e-5)
    assert min(formula) > 2 * instruments.GYRO_DRIFT


def test_second_approximation_is_of_fourth_order():
    errors = [simulation.second_approximation_error(angle * ARCMIN) for angle in (60, 30)]
    (first, second), (first_half, second_half) = errors
    assert_allclose(first / first_half, 4, rtol=1e-3)
    assert_allclose(second / second_half, 16, rtol=1e-3)


def test_the_trihedral_needs_its_turns_in_the_printed_order():
    tilt = np.pi / 2 - simulation.TRIHEDRAL_ALPHA
    for axis, turn in (("x", 240), ("z", 120), ("y", 120)):
        up = simulation.trihedral_directions(np.deg2rad(turn), tilt)["xyz".index(axis), 2]
        assert up < 0.1  # another axis is upright, this one level


def test_proofs_tell_a_wrong_sign_and_a_wrong_factor():
    eq07, eq02 = derivation.equations()["eq07"], derivation.equations()["eq02"]
    swapped = (*eq07.printed[2:], *eq07.printed[:2])
    assert not derivation.Equation(eq07.derived, swapped).proof.printed
    assert not derivation.Equation(eq02.derived, eq02.printed, tuple(-part for part in eq02.corrected)).proof.corrected


@pytest.mark.parametrize(("name", "value"), [("angle", 0.0), ("duration", -1.0), ("readout", np.nan), ("noise", -1e-9)])
def test_bad_budgets_are_named(name, value):
    with pytest.raises(ValueError, match=f"`{name}`"):
        budget.ScaleFactorTest(**{name: value})
