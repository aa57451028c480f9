"""What the rows of the ledger rest on and do not test themselves: each computation by another route."""

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit import claims
from fogkit.calibration.navigation_based import turn_model, turns_needed
from fogkit.constants import EARTH_RATE
from fogkit.earth import earth_rate_n, normal_gravity
from fogkit.navigation import State, integrate_arrays
from fogkit.reproduction import klimkovich
from fogkit.reproduction.klimkovich import (
    conditioning,
    derivation,
    estimates,
    ideas,
    paper,
    plan_search,
    regression,
    tables,
)
from fogkit.rotation import dcm_from_rotvec
from fogkit.stand.turn_tests import TurnTest
from fogkit.units import ARCSEC, DEG, PPM


def increments(test, dt, lat, bias=(0, 0, 0)):
    """Readings of perfect sensors in a steady turn of a perfect table on the turning Earth, by closed forms."""

    def integral(C, angle, duration, vector):
        """Of the body components of a vector of n over a turn of some duration."""
        if angle == 0:
            return C.T @ vector * duration
        return turn_model.turn_integral(test.axis, -angle) / -angle @ C.T @ vector * duration

    rows, C = [], np.asarray(test.C_b_n)
    up, earth = np.array([0, 0, float(normal_gravity(lat))]), earth_rate_n(lat)
    for duration, angle in ((test.dwell, 0.0), (test.turn_duration, test.angle), (test.dwell_after, 0.0)):
        steps = round(duration / dt)
        step = angle / steps
        for _ in range(steps):
            dtheta = test.axis * step + integral(C, step, dt, earth) + np.asarray(bias) * dt
            rows.append(np.concatenate([dtheta, integral(C, step, dt, up)]))
            C = C @ dcm_from_rotvec(test.axis * step)
    return np.array(rows)


def navigated_change(test, lat, start=(0, 0, 0), bias=(0, 0, 0), dt=0.01):
    """Change of slope over gravity by the full mechanisation."""
    rows = increments(test, dt, lat, bias)
    state = State(lat=lat, C_b_n=dcm_from_rotvec(np.asarray(start, dtype=float)) @ test.C_b_n)
    run = integrate_arrays(rows[:, :3], rows[:, 3:], dt, state, position_fixed=True, velocity_reset=[test.dwells[1][0]])
    slopes = []
    for begin, end in test.dwells:
        inside = slice(round(begin / dt), round(end / dt) + 1)
        slopes.append(np.polyfit(run.time[inside], run.v_eb_n[inside, :2], 1)[0])
    return (slopes[1] - slopes[0]) / float(normal_gravity(lat))


# Equations


def test_a_sign_that_is_turned_round_fails():
    for name in ("eq09", "eq14", "eq15", "eq18", "eq26", "eq29", "eq30", "eq31"):
        equation = derivation.equations()[name]
        assert equation.proof.printed
        negated = derivation.Equation(equation.derived, tuple(-side for side in equation.printed))
        assert not negated.proof.printed


def test_general_attitude_is_a_rotation():
    C = derivation.general_attitude("p")
    some = np.array(C.subs(dict(zip(sorted(C.free_symbols, key=str), (0.3, -0.7, 1.1), strict=True))), dtype=float)
    assert_allclose(some @ some.T, np.eye(3), atol=1e-14)
    assert_allclose(np.linalg.det(some), 1)
    # Cayley's parameters are the axis times the tangent of half the angle
    vector = np.array([0.3, -0.7, 1.1])
    size = np.linalg.norm(vector)
    assert_allclose(some, dcm_from_rotvec(vector / size * 2 * np.arctan(size)), atol=1e-14)


def test_half_difference_is_the_bias():
    import sympy as sp

    g = derivation.gravity()
    bias = derivation.errors()[2]
    for axis in (1, 2, 3):
        assert sp.simplify(sp.Abs(derivation.half_difference(axis) * g / bias[axis - 1])) == 1


def test_tilt_in_eq26():
    term = derivation.scale_factor_of_a_tilted_axis()
    (gamma,) = term.free_symbols
    assert_allclose(float(term.subs(gamma, 0.1 * DEG)) / PPM, -1.5, atol=0.05)
    assert_allclose(float(term.subs(gamma, 1 * DEG)) / PPM, np.cos(DEG) * 1e6 - 1e6, rtol=1e-4)


# Straight lines


def test_slope_variances_by_random_numbers():
    rng = np.random.default_rng(5)
    runs, dwell, turn, rate = 4000, 4.0, 6.0, 5.0
    still, steps = 20, 70
    for kind in regression.KINDS:
        velocity = rng.normal(size=(runs, steps))
        if kind != "white velocity":
            velocity = velocity.cumsum(axis=1) / rate
        if kind == "angle random walk":
            velocity = velocity.cumsum(axis=1) / rate
        parts = velocity[:, :still], velocity[:, steps - still :]
        fits = [np.polynomial.polynomial.polyfit(np.arange(still) / rate, part.T, 1, full=True) for part in parts]
        changes = fits[1][0][1] - fits[0][0][1]
        centred = np.arange(still) / rate - (still - 1) / 2 / rate
        reported = sum(fit[1][0].mean() for fit in fits) / (still - 2) / (centred @ centred)
        found = regression.noise_in_slopes(kind, dwell, turn, rate)
        # 4 sigma of a variance from so many runs; the reported one is a mean over runs and scatters less
        assert_allclose(changes.var(), found.variance, rtol=4 * np.sqrt(2 / runs))
        assert_allclose(reported, found.reported, rtol=4 * np.sqrt(2 / runs))


def test_shortfall_of_velocity_random_walk_by_hand():
    # 6/5 N^2 / T against 4/5 N^2 / (k T): 3/2 of the number of samples, for many
    assert_allclose(regression.noise_in_slopes("velocity random walk").shortfall, 150, rtol=0.03)


def test_eq24_against_statsmodels():
    import statsmodels.api as sm

    rng = np.random.default_rng(6)
    tau = np.sort(rng.uniform(0, 10, 30))
    velocity = 0.3 * tau + rng.normal(size=30)
    fit = sm.OLS(velocity, sm.add_constant(tau)).fit()
    S2 = np.sum(fit.resid**2) / (30 - 2)
    assert_allclose(S2 / (30 * (np.mean(tau**2) - tau.mean() ** 2)), fit.bse[1] ** 2)
    derived, printed = regression.slope_variance(3)
    times = dict(zip(sorted(printed.free_symbols, key=str), (0.0, 1.0, 5.0), strict=True))
    assert_allclose([float(derived.subs(times)), float(printed.subs(times))], 1 / 14)  # 4 + 1 + 9 about the mean 2


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("pink",), "`kind`"),
        (("white velocity", 0.2), "`dwell` must hold three samples"),
        (("white velocity", -1.0), "`dwell`"),
        (("white velocity", 10.0, 15.0, 0.0), "`rate`"),
    ],
)
def test_noise_that_cannot_be(arguments, words):
    with pytest.raises(ValueError, match=words):
        regression.noise_in_slopes(*arguments)


# Error estimates


@pytest.mark.parametrize("start", 0.1 * DEG * np.eye(3))
def test_start_error_against_the_mechanisation(start):
    test = estimates.test_of_the_estimate()
    navigated = navigated_change(test, estimates.LATITUDE, start) - navigated_change(test, estimates.LATITUDE)
    # the left-out second order of the start error: 0.1 deg of it, 2e-3, of the effect
    assert_allclose(estimates.slope_error(test, start=start), navigated, atol=0.01 * ARCSEC)


@pytest.mark.parametrize("bias", 2e-7 * np.eye(3))
def test_bias_against_the_mechanisation(bias):
    test = estimates.test_of_the_estimate(10.0)
    navigated = navigated_change(test, estimates.LATITUDE, bias=bias)
    assert_allclose(estimates.slope_error(test, gyro_bias=bias), navigated, atol=0.01 * ARCSEC)


def test_perfect_readings_leave_what_the_steps_cost():
    # the rate starts and stops at once, where the mechanisation is of third order in the step
    test = estimates.test_of_the_estimate()
    coarse, fine = (navigated_change(test, estimates.LATITUDE, dt=dt) / ARCSEC for dt in (0.02, 0.01))
    assert np.abs(fine).max() < 0.003
    assert np.abs(coarse).max() > 6 * np.abs(fine).max()


def test_closed_forms_of_the_two_effects():
    dwell, turn = 10.0, 15.0
    test = TurnTest(label="still", C_b_n=np.eye(3), axis=[1, 0, 0], angle=2 * np.pi, dwell=dwell, turn_duration=turn)
    apart = dwell + turn
    along = estimates.slope_error(test, gyro_bias=[1e-7, 0, 0], earth_rate=False, schuler=False)
    assert_allclose(along, [0, -1e-7 * apart], atol=1e-14)
    start = np.array([1e-3, 2e-3, -1e-3])
    drift = -np.cross(earth_rate_n(0.7), start) * apart
    found = estimates.slope_error(test, lat=0.7, start=start, schuler=False)
    assert_allclose(found, [drift[1], -drift[0]], atol=1e-3 * np.abs(drift).max())  # second order: the Earth's angle


def test_schuler_alone_is_eq34():
    # one long dwell on an Earth that stands still: the tilt follows the cosine
    lat = 0.0
    test = TurnTest(label="long", C_b_n=np.eye(3), axis=[0, 0, 1], angle=1e-9, dwell=400.0, turn_duration=1.0)
    frequency = float(estimates.schuler_frequencies(lat)[1])
    slope = estimates.slope_error(test, lat=lat, start=[0, 1e-4, 0], earth_rate=False)[0]
    t = np.linspace(0, 400, 4001)
    first = np.polyfit(t, np.sin(frequency * t) / frequency, 1)[0]
    second = np.polyfit(t, np.cos(frequency * 401) * np.sin(frequency * t) / frequency, 1)[0]  # starts at rest again
    assert_allclose(slope, 1e-4 * (second - first), rtol=0.02)  # where the tilt stands at the reset: 1 s of 400


def test_earth_term_and_schuler_term_meet():
    t = estimates.longest_test_of_earth_rate(1.24e-3)
    assert_allclose(EARTH_RATE * t, (1.24e-3 * t) ** 2 / 2)


def test_degree_must_be_positive():
    with pytest.raises(ValueError, match="`degree`"):
        estimates.slope_error(estimates.test_of_the_estimate(), degree=0)


# Tables


def test_levels_that_are_put_in_come_out():
    levels = np.array([1e-5, 2e-5, 3e-5, 4e-5])[tables.kinds_of_rows()]
    H = plan_search.measurement_matrix()
    rng = np.random.default_rng(7)
    Z = rng.normal(0, levels, (4000, 18))
    X = Z / levels @ np.linalg.pinv(H / levels[:, None]).T
    assert_allclose(X.std(axis=0), tables.deviations(levels), rtol=4 / np.sqrt(2 * 4000))


def test_kinds_of_rows():
    kinds = tables.kinds_of_rows()
    assert np.bincount(kinds).tolist() == [6, 3, 6, 3]
    # the gyro's scale factor shows across the axis only
    scale = [turn_model.PARAMETERS.index(name) for name in tables.SCALE_FACTORS]
    seen = np.abs(plan_search.measurement_matrix()[:, scale]).max(axis=1) > 1
    assert (seen == (kinds >= 2)).all()


def test_groups_are_alike_for_any_levels():
    rng = np.random.default_rng(8)
    for levels in rng.uniform(1, 3, (5, 4)):
        found = dict(zip(turn_model.PARAMETERS, tables.deviations(levels[tables.kinds_of_rows()]), strict=True))
        for group in tables.GROUPS:
            assert_allclose([found[name] for name in group], found[group[0]], rtol=1e-9)


def test_scale_factors_of_table_1_do_not_fit():
    assert tables.four_levels().largest < 0.008
    assert tables.four_levels(as_printed=True).largest > 0.3
    assert len(tables.table_1()) == 15


def test_table_2():
    found = tables.table_2_statistics()
    errors = list(paper.TABLE_2.values())
    assert_allclose(sum(errors), 2e-5, atol=1e-12)
    assert_allclose(found["deviation"] ** 2 * 7, found["rms"] ** 2 * 8 - 8 * found["mean"] ** 2)
    assert len(set(tables.table_2_remainders())) == 1


# Conditioning


def test_printed_plan_is_among_the_chained_ones():
    assert conditioning.chained_plan((1, 2, 1)) == plan_search.recovered_plan()
    table = conditioning.chained_plans()
    assert len(table) == 64
    assert_allclose(table.loc[(90, 180, 90), "condition"], np.linalg.cond(plan_search.measurement_matrix()))
    covariance = np.linalg.inv(plan_search.measurement_matrix().T @ plan_search.measurement_matrix())
    assert_allclose(table.loc[(90, 180, 90), "sum of variances"], np.trace(covariance))
    assert_allclose(table.loc[(90, 180, 90), "determinant"], np.linalg.det(covariance) ** (1 / 15))


def test_whole_turns_alone_are_blind():
    table = conditioning.chained_plans()
    assert table.loc[(360, 360, 360), "rank"] < 15
    assert np.isinf(table.loc[(360, 360, 360), "condition"])


def test_deviation_of_a_scale_factor_by_hand():
    # rows across of the three tests about an axis add up to 2 pi (3 n + 1): three measurements
    for turns in (1, 5):
        assert_allclose(conditioning.scale_factor_deviation(turns), np.sqrt(3) / (2 * np.pi * (3 * turns + 1)))


def test_table_2_of_the_size_effect():
    assert [ideas.visible_of_size_effect(centres) for centres in (1, 2)] == [9, 15]


# The ledger


@pytest.fixture(scope="module")
def rows():
    return {claim.id.removeprefix("klimkovich-"): claim for claim in claims.load("klimkovich")}


def test_every_equation_and_every_cell_has_a_row(rows):
    assert {f"eq{number:02d}" for number in range(1, 36)} <= set(rows)
    assert {f"h-{entry.row:02d}-{entry.column:02d}" for entry in paper.MATRIX} <= set(rows)
    assert {f"table1-{name.replace('_', '')}" for name in turn_model.PARAMETERS} <= set(rows)
    assert {f"table2-{angle:03d}" for angle in paper.TABLE_2} <= set(rows)


def test_numbers_of_the_ledger_are_those_of_the_transcription(rows):
    for entry in paper.MATRIX:
        claim = rows[f"h-{entry.row:02d}-{entry.column:02d}"]
        if claim.unit:
            assert claims.Printed.parse(claim.printed).low == entry.number
            assert claim.unit == {(0, 0): "1", (0, 1): "g0", (1, 1): "pi g0"}[entry.of_pi, entry.of_gravity]
        else:
            assert str(entry) in claim.printed
    for name, number in (paper.TABLE_1 | paper.TABLE_1_ACCELEROMETER_SCALE).items():
        assert claims.Printed.parse(rows[f"table1-{name.replace('_', '')}"].printed).low == pytest.approx(number)
    for angle, number in paper.TABLE_2.items():
        assert claims.Printed.parse(rows[f"table2-{angle:03d}"].printed).low == number


def test_every_row_that_needs_a_value_has_one(rows):
    computed = {name.removeprefix("klimkovich-") for name in klimkovich.values()}
    assert computed <= set(rows)
    assert {name for name, row in rows.items() if row.status in ("reproduced", "corrected", "refuted")} <= computed


@pytest.mark.parametrize(
    ("row", "text", "value"),
    [
        ("eq20-r", "1500", lambda: 10 * regression.noise_in_slopes("velocity random walk").shortfall),  # 1.5 k
        ("eq22-independent", "0.49", lambda: regression.noise_in_slopes("angle random walk").slope_correlation),
        ("eq28", "9.2", lambda: turns_needed(1.0, conditioning.scale_factor_deviation(5), 1.0, printed=True)),
        ("plan-condition", "74.9", lambda: conditioning.chained_plans().loc[(90, 180, 90), "condition"]),
        ("plan-condition", "70.3", lambda: conditioning.chained_plans()["condition"].min()),
        ("plan-condition", "2.88", lambda: conditioning.chained_plans()["scaled condition"].min()),
        ("plan-condition", "2.92", lambda: conditioning.chained_plans().loc[(90, 180, 90), "scaled condition"]),
        ("model-start", "0.56", lambda: estimates.start_effects()["east"]["both"]),
        ("model-start", "0.39", lambda: estimates.start_effects()["up"]["both"]),
        ("model-start", "0.35", lambda: estimates.angle_of_start() / ARCSEC),
        ("eq34", "0.53", lambda: estimates.start_effects()["north"]["earth"]),
        ("eq34", "0.17", lambda: estimates.start_effects()["north"]["schuler"]),
        ("eq34", "95", lambda: estimates.longest_test_of_earth_rate()),
        ("eq33", "0.93", lambda: estimates.bias_effects(10.0)["x"]),
        ("eq33", "1.11", lambda: estimates.bias_effects(19.0)["x"]),
        ("eq33", "0.19", lambda: estimates.bias_effects(19.0)["y"]),
        ("eq33", "0.27", lambda: estimates.bias_effects(10.0)["y"]),
        ("eq33-value", "1.03", lambda: estimates.bias_effects(15.0)["x"]),
        ("second-degree", "0.62", lambda: estimates.degrees_compared()[2]),
        ("eq35-value", "0.348", lambda: estimates.angle_of_start() / ARCSEC),
        (
            "eq35-value",
            "0.339",
            lambda: (
                estimates.angle_of_start(frequency=estimates.schuler_frequencies(estimates.LATITUDE).mean()) / ARCSEC
            ),
        ),
        ("schuler", "1.238e-3", lambda: estimates.schuler_frequencies([0.0, 0.8, 1.5]).min()),
        ("schuler", "1.242e-3", lambda: estimates.schuler_frequencies([0.0, 0.8, 1.5]).max()),
        ("table1-mg11", "0.454", lambda: tables.fitted("m_g_11")),
        ("table1-pattern", "4.14", lambda: paper_ratio()),
        ("table1-pattern", "2.65", lambda: tables.gyro_angle_ratio()),
        ("table1-pattern", "2.3", lambda: tables.group_spread(as_printed=True)),
        ("table2-deviation", "0.0126", lambda: tables.table_2_statistics()["deviation"]),
        ("subtract", "1.5e-4", ideas.error_after_one_step),
    ],
)
def test_numbers_in_the_notes(rows, row, text, value):
    assert text in rows[row].note
    digits = len(re.sub(r"e.*|^0*\.?0*|\.", "", text)) if text != "1500" else 2
    assert f"{value():.{digits - 1}e}" == f"{float(text):.{digits - 1}e}"


def paper_ratio():
    return tables.gyro_angle_ratio(tables.four_levels().levels[tables.kinds_of_rows()])
