"""Plans compared before anything is measured: against the fit, closed forms, and direct simulation."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose

from fogkit.calibration import bench_fit, plan_design, requirements, three_stage
from fogkit.calibration.triad import PARAMETERS, parameters_of, triad_from_parameters
from fogkit.imu import Construction, GyroTriad
from fogkit.reproduction.volynskii import instruments as paper
from fogkit.stand import Plan, RateTable, bench, plans
from fogkit.stand.table import GEOMETRY
from fogkit.units import ARCMIN, ARCSEC, DEG, DEG_PER_HOUR, DEG_PER_SECOND, HOUR

PLAIN = Construction(name="plain")
TRIAD = GyroTriad(
    bias=np.array([0.1, -0.2, 0.3]) * DEG_PER_HOUR,
    scale_positive=(1.7, 1.6, 1.8),
    scale_negative=(1.700002, 1.599998, 1.800003),
    misalignments=np.array([3, -2, 4, 1, -5, 2]) * ARCMIN,
    angle_random_walk=0.1 * ARCSEC,
)
TABLE = RateTable(latitude=60 * DEG, readout_noise=2 * ARCSEC)
FAST = 36 * DEG_PER_SECOND
RUNS = Path(__file__).parents[2] / "data" / "derived" / "bench_fit_runs.csv"


@pytest.mark.parametrize("name", ["plain", "block", "trihedral"])
def test_prediction_is_the_covariance_of_a_fit(name):
    plan = plan_design.split_plan(Construction(name=name), 600, bias_share=0.3, rate=FAST)
    record = bench.run(plan, TRIAD, TABLE, rng=np.random.default_rng(1))
    fit = bench_fit.fit(record, (TRIAD, TABLE))
    predicted = plan_design.predict(plan, (TRIAD, TABLE))
    # the two are linearised at the truth and at an estimate 1e-6 away
    assert_allclose(predicted.standard_deviation, fit.standard_deviation, rtol=1e-4)
    assert_allclose(predicted.correlation, fit.correlation, atol=1e-4)


def test_bias_without_turns_has_the_closed_form():
    # a plan of positions alone says nothing of scale factors; with them known, N / sqrt(T) is left
    plan = plan_design.split_plan(PLAIN, HOUR, bias_share=0.9, rate=FAST)
    staged = three_stage.calibrate(bench.run(plan, TRIAD, TABLE), noise=(TRIAD, TABLE)).standard_deviation[:3]
    held = sum(plan.segments[i].duration for i in plan.positions)
    expected = TRIAD.angle_random_walk / np.sqrt(held) / np.array(TRIAD.scale_positive)
    assert_allclose(staged, expected, rtol=1e-5)  # the asymmetry of the scale factors
    fitted = plan_design.predict(plan, (TRIAD, TABLE)).standard_deviation[:3]
    assert (fitted < staged).all()


def test_mounting_cannot_be_told_from_the_angles_of_a_plain_unit():
    plan = plan_design.split_plan(PLAIN, HOUR, bias_share=0.2, rate=FAST)
    for axis in "xyz":
        result = plan_design.predict(plan, (TRIAD, TABLE), geometry={f"mounting_{axis}": np.inf})
        assert f"mounting_{axis}" in result.unobservable_parameters()
        assert np.isinf(result.standard_deviation[-1])


def test_a_prior_on_the_mounting_is_the_deviation_of_the_angles():
    plan = plan_design.split_plan(PLAIN, HOUR, bias_share=0.2, rate=FAST)
    rig = {f"mounting_{axis}": 3 * ARCSEC for axis in "xyz"}
    angles = plan_design.predict(plan, (TRIAD, TABLE), geometry=rig).standard_deviation[9:15]
    assert_allclose(angles, 3 * ARCSEC, rtol=1e-4)  # beside it the readings' own 0.005 arcsec and tan(5 arcmin) ** 2


def test_missing_positive_turns_leave_the_scale_factor_to_the_earth_rate():
    plan = plan_design.split_plan(PLAIN, HOUR, bias_share=0.2, rate=FAST)
    kept = [s for i, s in enumerate(plan.segments) if i not in plan.turns_about(2, 1)]
    full, poor = (plan_design.predict(p, (TRIAD, TABLE)) for p in (plan, Plan(PLAIN, kept)))
    ratio = poor.standard_deviation / full.standard_deviation
    assert PARAMETERS[int(ratio.argmax())] == "scale_positive_z"
    assert ratio.max() > 1000


def test_plan_of_turns_alone_determines_all_parameters():
    plan = plan_design.split_plan(PLAIN, HOUR, bias_share=0.0, rate=FAST)
    assert not plan.positions
    assert plan_design.predict(plan, (TRIAD, TABLE)).unobservable == ()


def test_unknown_rig_error_is_named():
    plan = plan_design.split_plan(PLAIN, 600, bias_share=0.2, rate=FAST)
    with pytest.raises(ValueError, match="geometry"):
        plan_design.predict(plan, (TRIAD, TABLE), geometry={"wobble": 1.0})


def test_corrected_rate_inverts_the_readings():
    omega = np.array([[0.3, -0.2, 0.5], [-0.3, 0.1, -0.6]])
    along = omega @ TRIAD.A_g.T
    readings = np.array(TRIAD.bias) + along / np.where(along > 0, TRIAD.scale_positive, TRIAD.scale_negative)
    assert_allclose(plan_design.corrected_rate(TRIAD, readings), omega, rtol=1e-13)


def one_error(name, size):
    covariance = np.zeros((15, 15))
    covariance[PARAMETERS.index(name), PARAMETERS.index(name)] = size**2
    return covariance


def test_drift_in_a_turn_is_that_of_the_requirements():
    straight = replace(TRIAD, misalignments=np.zeros(6))
    motion = np.array([[0, 0, 6 * DEG_PER_SECOND]])
    scale = plan_design.drift_at_sea(one_error("scale_positive_z", 1.8e-6), straight, PLAIN, motion)
    assert_allclose(scale, [0, 0, requirements.drift_from_scale_error(1e-6, motion[0, 2])], rtol=1e-5, atol=1e-16)
    angle = plan_design.drift_at_sea(one_error("alpha_yx", ARCSEC), straight, PLAIN, motion)
    assert_allclose(angle, [0, requirements.drift_from_misalignment(ARCSEC, motion[0, 2]), 0], rtol=1e-6, atol=1e-16)


def test_drift_under_rocking_is_that_of_the_requirements():
    amplitude = 30 * DEG_PER_SECOND
    even = replace(TRIAD, misalignments=np.zeros(6), scale_negative=TRIAD.scale_positive, bias=np.zeros(3))
    motion = amplitude * np.sin(2 * np.pi * (np.arange(1000) + 0.5) / 1000)[:, None] * [1, 0, 0]
    # errors of both scale factors in opposite senses are an error of the asymmetry
    plus, minus = PARAMETERS.index("scale_positive_x"), PARAMETERS.index("scale_negative_x")
    covariance = np.zeros((15, 15))
    direction = np.zeros(15)
    direction[plus], direction[minus] = 0.5e-6 * 1.7, -0.5e-6 * 1.7
    covariance += np.outer(direction, direction)
    drift = plan_design.drift_at_sea(covariance, even, PLAIN, motion)
    expected = requirements.drift_from_asymmetry(1e-6, amplitude)
    assert_allclose(drift, [expected, 0, 0], rtol=1e-5, atol=1e-16)  # 1000 samples: the mean of |sin| to 4e-7


@pytest.mark.parametrize("name", ["plain", "trihedral"])
def test_drift_agrees_with_calibrations_that_are_wrong(name):
    construction = Construction(name=name)
    rng = np.random.default_rng(3)
    plan = plan_design.split_plan(construction, 600, bias_share=0.3, rate=FAST)
    covariance = three_stage.calibrate(bench.run(plan, TRIAD, TABLE), noise=(TRIAD, TABLE)).covariance
    motion = 30 * DEG_PER_SECOND * np.sin(2 * np.pi * (np.arange(40) + 0.5) / 40)[:, None] * [0.6, 0, 0.8]
    predicted = plan_design.drift_at_sea(covariance, TRIAD, construction, motion)
    along = motion @ construction.C_0_g1().T @ TRIAD.A_g.T
    readings = np.array(TRIAD.bias) + along / np.where(along > 0, TRIAD.scale_positive, TRIAD.scale_negative)
    runs = 2000
    wrong = rng.multivariate_normal(parameters_of(TRIAD), covariance, size=runs, method="cholesky")
    rates = [plan_design.corrected_rate(triad_from_parameters(x), readings).mean(axis=0) for x in wrong]
    scatter = (np.array(rates) @ construction.C_0_g1()).std(axis=0)
    assert_allclose(scatter, predicted, rtol=4 / np.sqrt(2 * runs))  # 4 standard errors of a scatter


def test_fresh_bias_leaves_no_drift_at_rest():
    covariance = one_error("bias_x", 1e-7)
    still = np.full((1, 3), 1e-4)
    assert (plan_design.drift_at_sea(covariance, TRIAD, PLAIN, still, fresh_bias=True) == 0).all()
    with_bias = plan_design.drift_at_sea(covariance, TRIAD, PLAIN, still)
    assert_allclose(with_bias[0], 1.7e-7, rtol=1e-5)


@pytest.mark.parametrize(("share", "repeats"), [(0.0, 1), (0.27, 1), (0.27, 3)])
def test_split_plan_fills_the_time_with_whole_turns(share, repeats):
    plan = plan_design.split_plan(PLAIN, HOUR, bias_share=share, rate=FAST, repeats=repeats)
    turning = [s for s in plan.segments if s.turning]
    assert len(turning) == 6 * repeats
    assert all(s.is_whole for s in turning)
    assert len(plan.positions) == (4 if share else 0)
    assert HOUR - 6 * repeats * 10 < plan.duration <= HOUR * (1 + 1e-12)
    if share:
        assert_allclose(plan.duration, HOUR, rtol=1e-12)


def test_split_plan_without_time_for_a_turn():
    with pytest.raises(ValueError, match="bias_share"):
        plan_design.split_plan(PLAIN, 60, bias_share=0.5, rate=FAST)


def chapter_bench():
    """Gyros, table, plan and priors of the Monte Carlo of the chapter `all_data`."""
    plus, minus = (np.array([paper.TABLE_2[axis + sign]["mean"] for axis in "xyz"]) for sign in "+-")
    bias = np.array([paper.TABLE_1[axis]["mean"] for axis in "xyz"]) * DEG_PER_HOUR
    angles = np.array([paper.TABLE_3[key]["mean"] for key in paper.TABLE_3])
    triad = GyroTriad(
        bias=bias / (0.5 * (plus + minus)),
        scale_positive=plus,
        scale_negative=minus,
        misalignments=angles * np.array([60, 60, 60, 60, 1, 60]) * ARCSEC,
        angle_random_walk=paper.EXAMPLE_NOISE,
    )
    table = RateTable(latitude=60 * DEG, readout_noise=paper.EXAMPLE_READOUT)
    rates = np.array([36, -36, 10, -10]) * DEG_PER_SECOND
    plan = Plan(PLAIN, plans.four_positions(PLAIN, 300.0) + plans.turns(PLAIN, rates.tolist(), 100.7))
    priors = dict.fromkeys(["level_east", "level_north"], 3 * ARCSEC) | {"azimuth_error": 30 * ARCSEC}
    return plan, (triad, table), priors | {f"mounting_{axis}": 3 * ARCSEC for axis in "xyz"}


@pytest.mark.parametrize("seed", [0, 777])
def test_stored_runs_are_those_of_the_code(seed):
    plan, noise, priors = chapter_bench()
    stored = pd.read_csv(RUNS, index_col="seed")
    run = plan_design.simulated_fit(plan, noise, seed, priors)
    expected = stored.loc[seed]
    # the search ends within 1e-3 standard deviations of the minimum (`leastsquares.OFFSET_TOLERANCE`)
    assert_allclose([run[name] for name in stored.columns], expected, atol=2e-3)


def test_stored_runs_scatter_as_predicted():
    stored = pd.read_csv(RUNS, index_col="seed")
    assert set(stored.columns) - set(PARAMETERS) - set(GEOMETRY) == {"chi_square", "degrees_of_freedom"}
    ratios = stored.drop(columns=["chi_square", "degrees_of_freedom"])
    n = len(stored)
    # 21 parameters, partly dependent: 3.5 standard errors leave 1 % by chance
    assert (np.abs(ratios.std() - 1) < 3.5 / np.sqrt(2 * n)).all()
    assert (np.abs(ratios.mean()) < 3.5 / np.sqrt(n)).all()
    free = stored.degrees_of_freedom.iloc[0]
    assert abs(stored.chi_square.mean() - free) < 3.5 * np.sqrt(2 * free / n)
