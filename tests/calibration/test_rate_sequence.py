"""Scale factors, biases to the east and installation errors from the single-axis table, against what was planted."""

from dataclasses import replace

import numpy as np
import pytest
from laboratories import EXACT, GYRO_PULSES, GYROS, LABORATORY, NOISY, WHITE, aligned, measured, scattered
from numpy.testing import assert_allclose, assert_array_equal

from fogkit.calibration.rate_sequence import (
    EastBias,
    ScaleFactorFit,
    bias_from_east,
    fit_scale_factor,
    installation,
    installation_accuracy,
    without_earth,
)
from fogkit.constants import EARTH_RATE
from fogkit.estimation.consistency import chi_square_interval, nees, ratio_interval
from fogkit.imu.unit import Sensors, Shape
from fogkit.noise.processes import RandomErrors
from fogkit.stand.laboratory import Laboratory
from fogkit.stand.means import expected_inputs
from fogkit.stand.placements import RATES, Schedule, rate_sequence, six_positions, three_positions_east
from fogkit.units import DEG, DEG_PER_HOUR, DEG_PER_SQRT_HOUR, PPM

SHAPE = Shape(asymmetry=(40 * PPM, -30 * PPM, 20 * PPM), cubic=(3 * PPM, 5 * PPM, -4 * PPM), quadratic=(1e-6, 0, -2e-6))
SEQUENCE = rate_sequence(duration=2.0)
ROUNDING = 1e-11  # of a reading at 200 deg/s: means of 20 samples or more, and the solution
RUNS, SURE = 300, 0.999


def unit_with(triad=GYROS, shape=SHAPE, random=None):
    return replace(EXACT, gyros=Sensors(triad=triad, shape=shape, random=random or RandomErrors()))


def terms_of(shape, axis):
    return {name: getattr(shape, name)[axis] for name in ("asymmetry", "quadratic", "cubic")}


@pytest.mark.parametrize("axis", range(3))
def test_scale_factor_shape_and_bias_without_noise(axis):
    triad = aligned(GYROS)
    observed = measured(unit_with(triad), SEQUENCE)
    fit = fit_scale_factor(observed, SEQUENCE, axis, terms=("asymmetry", "quadratic", "cubic"))
    assert_allclose(fit.scale_factor, triad.scale_factor[axis], rtol=ROUNDING)
    # the Earth turns about the axis of the table too: counted, what is left at rate zero is the bias
    assert_allclose(fit.intercept, triad.input_bias[axis], atol=ROUNDING * 200 * DEG)
    for term, planted in terms_of(SHAPE, axis).items():
        assert_allclose(fit.coefficient(term)[0], planted, atol=10 * ROUNDING)  # terms look alike: condition 10
    assert fit.nonlinearity < ROUNDING
    assert fit.axis == axis
    assert len(fit.rate) == len(fit.reading) == 29


def test_intercept_without_the_earth_is_wrong_by_its_upright_part():
    triad = aligned(GYROS)
    observed = measured(unit_with(triad, Shape()), SEQUENCE)
    blind = fit_scale_factor(without_earth(observed, SEQUENCE), SEQUENCE, 2)
    upright = EARTH_RATE * np.sin(LABORATORY.latitude)
    assert_allclose(blind.intercept, triad.input_bias[2] + upright, atol=ROUNDING * 200 * DEG)
    assert_array_equal(np.sort(np.abs(blind.rate)), np.sort(np.abs(RATES)))


def test_nonlinearity_is_what_was_planted():
    # a cubic term and a line fitted through symmetric rates: the line takes c * sum(u^4) / sum(u^2)
    planted = 50 * PPM
    triad = aligned(GYROS)
    observed = measured(unit_with(triad, Shape(cubic=(planted,) * 3)), SEQUENCE, Laboratory(latitude=0.0))
    fit = fit_scale_factor(observed, SEQUENCE, 0)
    u = np.array(RATES)
    left = planted * (u**3 - u * np.sum(u**4) / np.sum(u**2))
    scale = triad.scale_factor[0] * (1 + planted * np.sum(u**4) / np.sum(u**2))
    assert_allclose(fit.scale_factor, scale, rtol=ROUNDING)
    assert_allclose(fit.residual * fit.scale_factor, triad.scale_factor[0] * left, atol=ROUNDING * GYRO_PULSES * 3.5)
    # residuals are divided by the fitted scale factor, 5e-4 larger
    assert_allclose(fit.nonlinearity, np.abs(left).max() / u.max(), rtol=1e-3)
    table = fit.to_frame()
    assert table.index.name == "rate"
    assert np.isnan(table["relative residual"].iloc[0])  # at rest; on the equator the Earth adds nothing
    assert_allclose(table["relative residual"].iloc[-1], fit.residual[-1] / u[-1], rtol=1e-14)


def test_rates_and_axes_are_chosen():
    # with a cubic term two rates say another scale factor than all
    planted = 50 * PPM
    observed = measured(unit_with(aligned(GYROS), Shape(cubic=(planted,) * 3)), SEQUENCE, Laboratory(latitude=0.0))
    fit = fit_scale_factor(observed, SEQUENCE, 1, rates=[0.0, 100 * DEG, -100 * DEG])
    assert_allclose(fit.rate, np.array([0, 100, -100]) * DEG, atol=1e-18)
    assert_allclose(fit.scale_factor, GYROS.scale_factor[1] * (1 + planted * (100 * DEG) ** 2), rtol=ROUNDING)


def test_intervals_cover_what_was_planted():
    terms = ("asymmetry", "cubic")
    shape = replace(SHAPE, quadratic=(0, 0, 0))
    exact = measured(unit_with(aligned(GYROS), shape), SEQUENCE, random=WHITE)
    rng = np.random.default_rng(8)
    fits = [fit_scale_factor(scattered(exact, rng), SEQUENCE, 0, terms=terms) for _ in range(RUNS)]
    scale = aligned(GYROS).scale_factor[0]
    truth = np.array([scale, aligned(GYROS).bias[0], scale * 40 * PPM, scale * 3 * PPM])
    values = nees([fit.solution.estimate - truth for fit in fits], fits[0].solution.covariance)
    low, high = chi_square_interval(4, RUNS, SURE)
    assert low < values.mean() < high
    low, high = chi_square_interval(25, RUNS, SURE)
    assert low < np.mean([fit.solution.chi_square for fit in fits]) < high
    found = {
        "scale": ([fit.scale_factor for fit in fits], fits[0].scale_factor_deviation, scale),
        "intercept": ([fit.intercept for fit in fits], fits[0].intercept_deviation, GYROS.input_bias[0]),
        "asymmetry": ([fit.coefficient("asymmetry")[0] for fit in fits], fits[0].coefficient("asymmetry")[1], 40 * PPM),
        "cubic": ([fit.coefficient("cubic")[0] for fit in fits], fits[0].coefficient("cubic")[1], 3 * PPM),
    }
    low, high = ratio_interval(RUNS, 1 - (1 - SURE) / 4)
    for name, (values, deviation, planted) in found.items():
        assert low < deviation / np.std(values, ddof=1) < high, name
        assert abs(np.mean(values) - planted) < 3.5 * deviation / np.sqrt(RUNS), name  # 3.5 sigma of a mean
        inside = np.mean(np.abs(np.subtract(values, planted)) < 1.96 * deviation)
        assert abs(inside - 0.95) < 3.5 * np.sqrt(0.95 * 0.05 / RUNS), name  # 3.5 sigma of a share


def test_the_deviation_of_a_ratio_counts_that_of_the_scale_factor():
    # a bias of half the largest rate, so that both parts matter
    triad = replace(aligned(GYROS), bias=(1.5 * GYRO_PULSES,) * 3)
    schedule = rate_sequence([0.0, 3.0], 2.0, axes="x")
    loud = (RandomErrors(angle_random_walk=0.01), WHITE[1])  # still 1e-3 of the readings: first order suffices
    exact = measured(unit_with(triad, Shape()), schedule, random=loud)
    rng = np.random.default_rng(9)
    fits = [fit_scale_factor(scattered(exact, rng), schedule, 0) for _ in range(RUNS)]
    low, high = ratio_interval(RUNS, SURE)
    assert low < fits[0].intercept_deviation / np.std([fit.intercept for fit in fits], ddof=1) < high


def test_errors_of_the_tables_rate_are_weighted():
    error = 20 * PPM
    laboratory = replace(LABORATORY, rate_error=error)
    schedule = rate_sequence(duration=2.0, axes="x")
    exact = measured(unit_with(aligned(GYROS), Shape()), schedule, random=WHITE)
    rng = np.random.default_rng(10)
    rates = np.array([placement.rate for placement in schedule.placements])
    weighted, flat = [], []
    for _ in range(RUNS):
        drawn = scattered(exact, rng)
        readings = drawn.readings.copy()
        readings[:, 0] += GYROS.scale_factor[0] * rates * laboratory.rate_error * rng.standard_normal(29)
        drawn = replace(drawn, readings=readings)
        weighted.append(fit_scale_factor(drawn, schedule, 0, rate_error=error))
        flat.append(fit_scale_factor(drawn, schedule, 0))
    truth = np.array([GYROS.scale_factor[0], GYROS.bias[0]])
    values = nees([f.solution.estimate - truth for f in weighted], [f.solution.covariance for f in weighted])
    low, high = chi_square_interval(2, RUNS, SURE)
    assert low < values.mean() < high
    low, high = chi_square_interval(27, RUNS, SURE)
    assert low < np.mean([f.solution.chi_square for f in weighted]) < high
    assert np.mean([f.solution.chi_square for f in flat]) > 2 * high  # the gyro's noise alone does not explain it
    # small rates then tell the bias undisturbed by the large ones
    assert np.std([f.intercept for f in weighted]) < 0.5 * np.std([f.intercept for f in flat])


def test_a_recording_with_errors_of_the_tables_rate():
    laboratory = replace(LABORATORY, rate_error=20 * PPM)
    schedule = rate_sequence(duration=2.0, axes="z")
    values = []
    for seed in range(20):
        observed = measured(NOISY, schedule, laboratory, seed=seed, random=WHITE)
        values.append(fit_scale_factor(observed, schedule, 2, rate_error=20 * PPM).solution.chi_square)
    low, high = chi_square_interval(27, 20, SURE)
    assert low < np.mean(values) < high


# installation errors


def test_installation_finds_the_matrix():
    schedule = rate_sequence([0.0, 150 * DEG, -150 * DEG, 3 * DEG, -3 * DEG], 2.4)
    observed = measured(EXACT, schedule)
    for rate in (150 * DEG, 3 * DEG):
        found = installation(observed, schedule, rate=rate).triad
        # rounding of readings of 1e6 pulses/s at 150 deg/s, over the rate; of the biases likewise
        assert_allclose(found.misalignment, GYROS.misalignment, atol=ROUNDING)
        assert_allclose(found.scale_factor, GYROS.scale_factor, rtol=ROUNDING)
        assert_allclose(found.bias, GYROS.bias, atol=ROUNDING * GYRO_PULSES * rate)
    assert_array_equal(
        installation(observed, schedule).triad.matrix, installation(observed, schedule, rate=150 * DEG).triad.matrix
    )


def test_noise_of_an_installation_error():
    random = RandomErrors(angle_random_walk=0.003 * DEG_PER_SQRT_HOUR)
    schedule = rate_sequence([10 * DEG, -10 * DEG], 36.0)
    exact = measured(EXACT, schedule, random=WHITE, sample_rate=1.0)
    rng = np.random.default_rng(13)
    runs = [installation(scattered(exact, rng), schedule, rate=10 * DEG) for _ in range(RUNS)]
    predicted = installation_accuracy(10 * DEG, 36.0, random, LABORATORY)
    off = ~np.eye(3, dtype=bool)
    observed = np.std([run.triad.misalignment[off] for run in runs], axis=0, ddof=1)
    low, high = ratio_interval(RUNS, 1 - (1 - SURE) / 6)
    assert (low < predicted.noise / observed).all()
    assert (predicted.noise / observed < high).all()
    assert_allclose(runs[0].misalignment_deviation[off], predicted.noise, rtol=1e-3)  # equivalents nominal to 4e-4
    assert_allclose(predicted.turns, 1, rtol=1e-15)


@pytest.mark.parametrize(("rate", "duration"), [(0.2, 3.0), (0.2, 20.0), (0.02, 50.0), (1.0, 7.3), (3.0, 1.0)])
def test_what_the_earth_does_to_an_installation_error(rate, duration):
    schedule = rate_sequence([rate, -rate], duration)
    # brute force: all headings to a quarter turn, in steps of half a degree; the two level gyros see the rest
    omega, _ = expected_inputs(schedule, LABORATORY)
    worst = 0.0
    for azimuth in np.linspace(-np.pi / 4, np.pi / 4, 181):
        c, s = np.cos(azimuth), np.sin(azimuth)
        turned = omega[0:2, 1:] @ np.array([[c, s], [-s, c]])  # x upright: y and z in the plate's plane
        worst = max(worst, np.abs(turned[0] - turned[1]).max() / 2 / rate)
    predicted = installation_accuracy(rate, duration, RandomErrors(), LABORATORY)
    # a maximum missed by at most a quarter of a degree: (0.25 deg)^2 / 2 = 1e-5 of it
    assert_allclose(predicted.earth, worst, rtol=1e-5)
    # and the whole way: a table without the Earth's rotation makes that error
    observed = without_earth(measured(unit_with(aligned(GYROS), Shape()), schedule), schedule)
    error = installation(observed, schedule, rate=rate).triad.misalignment
    assert 0.7 * predicted.earth < np.abs(error[[1, 2], 0]).max() <= predicted.earth * (1 + 1e-4)


def test_whole_turns_in_two_minutes_at_3_and_150_deg_per_second_only():
    whole = [
        size
        for size in (0.1, 0.2, 0.5, 1, 3, 5, 8, 10, 20, 50, 80, 100, 150, 200)
        if size * 120 % 360 == 0  # in degrees
    ]
    assert whole == [3, 150]
    for rate in sorted({abs(rate) for rate in RATES if rate}):
        earth = installation_accuracy(rate, 120.0, RandomErrors(), LABORATORY).earth * rate
        assert (earth < 1e-15 * EARTH_RATE) == any(np.isclose(rate, size * DEG) for size in whole)  # sine of 50 turns


# biases to the east


def test_bias_to_the_east_without_errors():
    schedule = three_positions_east(20.0)
    observed = measured(unit_with(aligned(GYROS), Shape()), schedule, random=WHITE)
    found = bias_from_east(observed, schedule, GYROS.scale_factor, LABORATORY)
    assert_allclose(found.bias, GYROS.bias, atol=ROUNDING * GYRO_PULSES * EARTH_RATE)
    expected = 0.003 * DEG_PER_SQRT_HOUR / np.sqrt(20.0) * GYRO_PULSES
    assert_allclose(found.deviation, expected, rtol=1e-14)


def test_bias_to_the_east_on_many_plates():
    # plates of which only the deviations of azimuth and level are known
    azimuth, level = 2e-3, 1e-3
    schedule = three_positions_east(4.0)
    triad = aligned(GYROS)
    plain = measured(unit_with(triad, Shape()), schedule, random=WHITE)
    rng = np.random.default_rng(14)
    errors, covariance = [], None
    for _ in range(RUNS):
        plate = replace(
            LABORATORY, azimuth_error=azimuth * rng.standard_normal(), level_north=level * rng.standard_normal()
        )
        omega, _ = expected_inputs(schedule, plate)
        readings = plain.readings.copy()
        readings[:, :3] = triad.readings(omega)
        drawn = scattered(replace(plain, readings=readings), rng)
        found = bias_from_east(
            drawn, schedule, triad.scale_factor, LABORATORY, azimuth_deviation=azimuth, level_deviation=level
        )
        errors.append(found.bias - triad.bias)
        covariance = found.solution.covariance
    low, high = chi_square_interval(3, RUNS, SURE)
    assert low < nees(errors, covariance).mean() < high
    deviations = np.sqrt(np.diagonal(covariance))
    low, high = ratio_interval(RUNS, 1 - (1 - SURE) / 3)
    assert (low < deviations / np.std(errors, axis=0, ddof=1)).all()
    assert (deviations / np.std(errors, axis=0, ddof=1) < high).all()
    # the plate's part is one for all: 2 mrad of the Earth's north part and 1 mrad of its upright one
    plate_part = np.hypot(azimuth * np.cos(40 * DEG), level * np.sin(40 * DEG)) * EARTH_RATE
    assert_allclose(covariance[0, 1], plate_part**2 * np.prod(triad.scale_factor[:2]), rtol=1e-12)
    correlation = np.corrcoef(np.transpose(errors))[0, 1]
    predicted = covariance[0, 1] / (deviations[0] * deviations[1])
    assert abs(np.arctanh(correlation) - np.arctanh(predicted)) < 3.5 / np.sqrt(RUNS - 3)  # Fisher's transform


def test_positions_of_one_axis_are_averaged_and_others_left_out():
    schedule = three_positions_east(4.0) + six_positions(12.0) + rate_sequence([0.1], 4.0)
    triad = aligned(GYROS)
    observed = measured(unit_with(triad, Shape()), schedule, random=WHITE)
    found = bias_from_east(observed, schedule, triad.scale_factor, LABORATORY)
    assert_allclose(found.bias, triad.bias, atol=ROUNDING * GYRO_PULSES * EARTH_RATE)
    # 4 s, and 12 s twice for each axis: y is east with x up and with x down, and so on
    expected = 0.003 * DEG_PER_SQRT_HOUR / np.sqrt(4 + 2 * 12) * GYRO_PULSES
    assert_allclose(found.deviation, expected, rtol=1e-12)


def test_a_known_error_of_the_plate_is_taken_off():
    crooked = replace(LABORATORY, azimuth_error=0.1)
    schedule = three_positions_east(4.0)
    observed = measured(unit_with(aligned(GYROS), Shape()), schedule, crooked, random=WHITE)
    found = bias_from_east(observed, schedule, GYROS.scale_factor, crooked)
    assert_allclose(found.bias, GYROS.bias, atol=ROUNDING * GYRO_PULSES * EARTH_RATE)
    blind = bias_from_east(
        measured(unit_with(aligned(GYROS), Shape()), schedule, crooked, believed=LABORATORY, random=WHITE),
        schedule,
        GYROS.scale_factor,
        LABORATORY,
    )
    # an axis 0.1 rad from east to north reads that sine of the level rotation: 1.15 deg/h
    error = (blind.bias - GYROS.bias) / GYROS.scale_factor
    assert_allclose(error, np.sin(0.1) * np.cos(40 * DEG) * 15.041067 * DEG_PER_HOUR, rtol=1e-7)  # digits typed


def bias_of(schedule, **kwargs):
    observed = measured(EXACT, schedule, random=kwargs.pop("random", WHITE))
    arguments = {"scale_factor": GYROS.scale_factor, "laboratory": LABORATORY} | kwargs
    return bias_from_east(observed, schedule, **arguments)


SHORT = rate_sequence([0.0, 0.1, -0.1], 1.0)
SHORT_OBSERVED = measured(EXACT, SHORT)
ONE_WAY = Schedule(SHORT.placements[:8])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: fit_scale_factor(SHORT_OBSERVED, SHORT, 3), "`axis` must be 0, 1 or 2, got 3"),
        (lambda: fit_scale_factor(SHORT_OBSERVED, SHORT, -1), "`axis`"),
        (lambda: fit_scale_factor(SHORT_OBSERVED, SHORT, 0, terms=["quartic"]), "`terms`"),
        (lambda: fit_scale_factor(SHORT_OBSERVED, SHORT, 0, rate_error=-1e-6), "`rate_error`"),
        (
            lambda: fit_scale_factor(SHORT_OBSERVED, SHORT, 0, rate_error=1e-6),
            "`rate_error` must be 0 where `observed`",
        ),
        (
            lambda: fit_scale_factor(SHORT_OBSERVED, SHORT, 0, terms=["asymmetry", "cubic"]),
            "`schedule` must hold at least 4 rates with x up to fit 4 parameters, got 3",
        ),
        (lambda: fit_scale_factor(SHORT_OBSERVED, SHORT, 1, rates=[0.1]), "at least 2 rates with y up"),
        (lambda: fit_scale_factor(SHORT_OBSERVED, SHORT, 0).coefficient("cubic"), "`term` .*Name it in `terms`"),
        (lambda: installation(SHORT_OBSERVED, SHORT), r"`rate` must be one of the schedule's.*150 deg/s"),
        (lambda: installation(SHORT_OBSERVED, SHORT, rate=-0.1), "`rate`"),
        (lambda: installation(measured(EXACT, ONE_WAY), ONE_WAY, rate=0.1), "both ways .*, got no turn about -z"),
        (lambda: installation_accuracy(0.0, 1.0, RandomErrors(), LABORATORY), "`rate`"),
        (lambda: installation_accuracy(0.1, 0.0, RandomErrors(), LABORATORY), "`duration`"),
        (lambda: bias_of(three_positions_east(2.0).select([0, 2])), "each axis to the east, got none of y"),
        (lambda: bias_of(SHORT.select([1, 2])), "each axis to the east, got none of x, y, z"),
        (lambda: bias_of(three_positions_east(2.0), random=None), "`observed` must have a covariance"),
        (lambda: bias_of(three_positions_east(2.0), scale_factor=1.0), "`scale_factor`"),
        (lambda: bias_of(three_positions_east(2.0), azimuth_deviation=-1), "`azimuth_deviation`"),
        (lambda: bias_of(three_positions_east(2.0), level_deviation=-1), "`level_deviation`"),
    ],
)
def test_errors_name_the_argument(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_results_go_to_text_and_back():
    observed = measured(NOISY, SEQUENCE, random=WHITE)
    fit = fit_scale_factor(observed, SEQUENCE, 1, terms=["cubic"])
    again = ScaleFactorFit.from_json(fit.to_json())
    assert (again.axis, again.terms, again.scale_factor) == (1, ("cubic",), fit.scale_factor)
    assert_array_equal(again.residual, fit.residual)
    assert again.coefficient("cubic") == fit.coefficient("cubic")
    east = three_positions_east(duration=2.0)
    bias = bias_from_east(measured(NOISY, east, random=WHITE), east, GYROS.scale_factor, LABORATORY)
    assert_array_equal(EastBias.from_json(bias.to_json()).deviation, bias.deviation)
    assert_array_equal(bias.to_frame().estimate, bias.bias)
    with pytest.raises(ValueError, match="`text` must be that of a EastBias"):
        EastBias.from_json(fit.to_json())
