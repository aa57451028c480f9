"""What the thesis's equations and budgets come to, against the package's gyrocompass and by hand."""

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass import error_model, frames, mechanisation
from fogkit.gyrocompass.gyro_range import gyro_peaks
from fogkit.gyrocompass.mechanisation import EARTH_RADIUS, CompassState, Reading
from fogkit.reproduction.lechang import derivation, paper, pyramid, rates, requirements
from fogkit.units import DEG, DEG_PER_HOUR, DEG_PER_SECOND


@pytest.mark.parametrize("name", derivation.equations())
def test_restored_equations_follow(name):
    assert derivation.equations()[name].holds
    assert derivation.holds(name)


def test_a_wrong_sign_is_seen():
    for name in ("eq06-heading", "eq08-lat", "eq13", "eq17-gyro-z"):
        right = derivation.equations()[name]
        assert not derivation.Equation(right.derived, -right.printed).holds
    term = derivation.equations()["eq17-gyro-z"]
    cosine = sympy.cos(sympy.Symbol("theta", real=True))
    flipped = term.printed.subs(cosine, -cosine)
    assert not derivation.Equation(term.derived, flipped).holds
    with pytest.raises(KeyError):
        derivation.holds("eq99")
    assert set(derivation.UNREADABLE) <= set(derivation.equations())


def test_symbols_and_code_agree():
    # the coefficients by symbols, in the row of heading of the error model by numbers
    rng = np.random.default_rng(5)
    K, th, g, b = rng.uniform(-1.2, 1.2, 4)
    v, lat = rng.uniform(-30, 30, 3), 0.8
    rate = rng.uniform(-0.3, 0.3, 3)
    state = CompassState(heading=K, trim=th, roll=g, velocity=v, lat=lat, alt=100.0)
    gyros = mechanisation.gyro_rates(rate, b, 0.2)
    F = error_model.system_matrix(state, Reading(rates=gyros, mount_angle=b, mount_rate=0.2))
    values = dict(K=K, theta=th, gamma=g, beta=b, phi=lat, U=EARTH_RATE, R=EARTH_RADIUS + 100, V_N=v[0], V_E=v[2])
    values |= dict(zip(("w_x", "w_y", "w_z"), rate, strict=True))
    names = ["heading", "trim", "roll", "velocity-north", None, "velocity-east", "lat", None, "alt"]
    names += ["gyro-x", "gyro-y", "gyro-z"]
    for column, name in enumerate(names):
        if name:
            expression = derivation.equations()[f"eq08-{name}"].derived
            symbols = sorted(expression.free_symbols, key=str)
            value = sympy.lambdify(symbols, expression, "math")(*(values[str(symbol)] for symbol in symbols))
            assert_allclose(F[0, column], value, rtol=1e-9)  # terms of the latitude and height columns cancel to 1e-3


def test_requirement_equation_by_numbers():
    # (17) by symbols against differences of the arc tangent
    K, th, g, lat = 0.7, 0.15, -0.1, 60 * DEG
    numbers = requirements.heading_sensitivity(K, th, g, lat)
    C = frames.hull_attitude(K, th, g)
    gyros = mechanisation.gyro_rates(C.T @ mechanisation.geographic_rate(lat, np.zeros(3)), 0.0, 0.0)
    level = EARTH_RATE * np.cos(lat)
    values = dict(theta=th, gamma=g, omega_NK=level * np.cos(K), omega_EK=-level * np.sin(K))
    values |= dict(zip(("w_xb", "w_yb", "w_zb"), gyros, strict=True))
    for number, name in zip(numbers, ("gyro-x", "gyro-y", "gyro-z", "trim", "roll"), strict=True):
        expression = derivation.equations()[f"eq17-{name}"].printed
        symbols = sorted(expression.free_symbols, key=str)
        value = sympy.lambdify(symbols, expression, "math")(*(values[str(symbol)] for symbol in symbols))
        assert_allclose(number, np.cos(K) ** 2 * value, rtol=1e-6)  # rounding of the differences


def test_heading_takes_the_east_part_whatever_the_attitude():
    rng = np.random.default_rng(2)
    lat = 60 * DEG
    for _ in range(10):
        K, th, g = rng.uniform(-3, 3), *rng.uniform(-0.17, 0.17, 2)
        numbers = requirements.heading_sensitivity(K, th, g, lat)
        east = (frames.hull_attitude(K, th, g) @ frames.pyramid_axes())[2]  # east parts of the three gyros
        assert_allclose(numbers[:3], -east / (EARTH_RATE * np.cos(lat)), rtol=1e-6, atol=1e-6)
        assert_allclose(np.linalg.norm(numbers[:3]) * EARTH_RATE * np.cos(lat), 1, rtol=1e-6)
        # of tilts it takes the part about north, by the up component of the Earth rate
        assert np.abs(numbers[3:]).max() <= np.tan(lat) * 1.03  # a trim or roll of 10 deg projects by 1/cos at most


def test_pyramid_sequence_is_the_only_one():
    table = pyramid.sequences()
    assert len(table) == 48
    found = table[table.upward & table.equation_13]
    assert found[["sequence", "signs"]].to_numpy().tolist() == [["YZY", "+++"]]
    assert not table[table.sequence == "YZX"].even.any()  # the axes of heading, trim and roll do not do it
    assert_allclose(np.array(paper.PYRAMID_ANGLES_DEG) * DEG, frames.PYRAMID_ANGLES, atol=0.05 * DEG)


def test_rate_budget():
    heading, trim, roll = np.array(rates.hull_rates()) / DEG_PER_SECOND
    assert_allclose([heading, trim, roll], [5, 12.6, 6.3], atol=0.05)
    budgets = rates.budgets()
    assert_allclose(budgets["squares"].mount_rate, paper.PRINTED_MOUNT_RATE, atol=1e-3)
    assert_allclose(budgets["squares"].period, paper.PRINTED_PERIOD, atol=0.5)
    assert_allclose(budgets["sum"].mount_rate / DEG_PER_SECOND, 40 - 5 - 12.566 - 6.283, atol=1e-3)
    # a gyro of the pyramid at its limit
    law = rates.QuasiHarmonic.from_rate(np.pi, budgets["one gyro"].mount_rate)
    assert_allclose(gyro_peaks(law, (roll * DEG, heading * DEG, trim * DEG)), paper.RATE_LIMIT, rtol=1e-12)
    assert rates.to_frame().loc["sum", "period_180_s"] > 60  # neither experiment nor rule keeps within the plain sum


def test_requirements():
    # an error of the printed size gives several times the printed accuracy, at any latitude
    for lat in (0.0, 45 * DEG, 60 * DEG, 80 * DEG):
        assert requirements.heading_error(paper.GYRO_ERROR_LIMIT, lat) > 3.5 * paper.HEADING_ACCURACY
        allowed = requirements.gyro_error_for(paper.HEADING_ACCURACY, lat)
        assert_allclose(requirements.heading_error(allowed, lat), paper.HEADING_ACCURACY, rtol=1e-12)
    assert_allclose(requirements.gyro_error_for(0.3 * DEG, 0.0) / DEG_PER_HOUR, 15.041 * np.tan(0.3 * DEG), rtol=1e-5)
    with pytest.raises(ValueError, match="`gyro_error` must be below the level Earth rate"):
        requirements.heading_error(16 * DEG_PER_HOUR, 0.0)
    parts = requirements.terms_of_table_3(60 * DEG, 60.0)
    assert sum(parts.values()) < 0.5 * DEG_PER_HOUR
    assert parts["noise"] < 0.003 * DEG_PER_HOUR


def test_noise_of_the_data_sheet():
    two, one = (paper.random_walk_of_the_data_sheet(sides) for sides in (2, 1))
    assert_allclose(two / DEG * 60, 0.01 / 34 * 60, rtol=1e-12)  # 0.01 mV/sqrt(Hz) over 34 mV/(deg/s)
    assert_allclose(two / one, np.sqrt(2), rtol=1e-15)
    with pytest.raises(ValueError, match="`sides` must be 1 or 2"):
        paper.random_walk_of_the_data_sheet(3)
