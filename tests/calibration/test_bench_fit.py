"""The fit of all data against the truth that was put in, the staged method, and the statistics of many runs."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.calibration import bench_fit, three_stage
from fogkit.calibration.triad import PARAMETERS, parameters_of
from fogkit.estimation.consistency import chi_square_interval, nees, ratio_interval
from fogkit.imu import MISALIGNMENTS, Construction, GyroTriad
from fogkit.stand import BenchRecord, Plan, RateTable, bench, plans
from fogkit.stand.table import GEOMETRY
from fogkit.units import ARCMIN, ARCSEC, DEG, DEG_PER_HOUR

PLAIN = Construction(name="plain")
RATE = 36 * DEG
TRIAD = GyroTriad(
    bias=np.array([0.15, -0.009, -0.06]) * DEG_PER_HOUR,
    scale_positive=(1.746892, 1.664746, 1.730345),
    scale_negative=(1.746890, 1.664747, 1.730357),
    misalignments=np.array([-2.9, 1.8, 2.3, 1.3, 2.4, 2.7]) * ARCMIN,
    angle_random_walk=0.1 * ARCSEC,
    bias_instability=0.002 * DEG_PER_HOUR,
)
TABLE = RateTable(latitude=60 * DEG, readout_noise=2 * ARCSEC, rate_stability=5e-6)
# what the engineer knows beforehand: nominal scale factors and the noise
BELIEVED = GyroTriad(
    scale_positive=(1.75, 1.66, 1.73),
    scale_negative=(1.75, 1.66, 1.73),
    angle_random_walk=TRIAD.angle_random_walk,
    bias_instability=TRIAD.bias_instability,
)
STAGED = plans.three_stage(PLAIN)
# nothing whole, nothing equal: the staged method could not use it
RAGGED = Plan(
    PLAIN,
    plans.four_positions(PLAIN, 600.0, heading=0.4)[:3]
    + plans.turns(PLAIN, (RATE, -RATE, 5 * DEG), 100.3)
    + plans.turns(PLAIN, (-20 * DEG,), 47.1),
)


def single(record, run):
    return BenchRecord(
        plan=record.plan, latitude=record.latitude, readings=record.readings[run], turned=record.turned[run]
    )


@pytest.mark.parametrize("unit", [1.0, ARCSEC])
@pytest.mark.parametrize("name", ["plain", "block", "trihedral"])
def test_truth_comes_back_from_noise_free_readings_of_parts_of_turns(name, unit):
    construction = Construction(name=name)
    segments = plans.four_positions(construction, 60.0)[:3] + plans.turns(construction, (RATE, -RATE), 23.4)
    scaled = {name: np.array(getattr(TRIAD, name)) * unit for name in ("scale_positive", "scale_negative")}
    triad = GyroTriad(bias=np.array(TRIAD.bias) / unit, misalignments=TRIAD.misalignments, **scaled)
    believed = GyroTriad(
        scale_positive=np.array(BELIEVED.scale_positive) * unit,
        scale_negative=np.array(BELIEVED.scale_negative) * unit,
        angle_random_walk=TRIAD.angle_random_walk,
    )
    record = bench.run(Plan(construction, segments), triad, TABLE)
    solution = bench_fit.fit(record, (believed, TABLE))
    found, truth = solution.estimate, parameters_of(triad)
    # rounding of readings of 0.4 rad/s is 1e-16, times the condition of the plan
    assert_allclose(found[:3] * unit, truth[:3] * unit, atol=1e-13)
    assert_allclose(found[3:9], truth[3:9], rtol=1e-12)
    assert_allclose(found[9:], truth[9:], atol=1e-12)
    assert solution.names == PARAMETERS
    assert solution.condition < 100
    assert bench_fit.calibration_of(solution).triad.scale_positive == tuple(found[3:6])


def test_plain_plan_gives_what_the_stages_give():
    record = bench.run(STAGED, TRIAD, TABLE, rng=np.random.default_rng(7))
    staged = three_stage.calibrate(record, noise=(TRIAD, TABLE))
    fitted = bench_fit.calibration_of(bench_fit.fit(record, (TRIAD, TABLE)))  # the same noise, to the last digit
    # the fit has more equations: in the biases what the turns say of them. Gauss and Markov: never a larger deviation
    assert (fitted.standard_deviation < 1.01 * staged.standard_deviation).all()
    # and the difference of an efficient estimate from another has the difference of their variances
    variance = np.diag(staged.covariance)  # predicted to the Earth's rate over the table's, 1e-4: what is added
    gap = np.sqrt(np.maximum(variance - np.diag(fitted.covariance), 0) + 1e-4 * variance)
    assert (np.abs(fitted.estimate - staged.estimate) < 4 * gap).all()


@pytest.fixture(scope="module")
def campaign():
    """Solutions of 60 runs of a plan with parts of turns."""
    record = bench.run(RAGGED, TRIAD, TABLE, rng=np.random.default_rng(12), runs=60)
    return [bench_fit.fit(single(record, run), (BELIEVED, TABLE)) for run in range(60)]


@pytest.mark.slow
def test_chi_square_is_distributed_as_it_says(campaign):
    free = campaign[0].degrees_of_freedom
    assert free == 3 * len(RAGGED.segments) - len(PARAMETERS)
    low, high = chi_square_interval(free, len(campaign), 0.99)
    assert low < np.mean([s.chi_square for s in campaign]) < high
    # probabilities are uniform: Kolmogorov's bound at 1 %
    p = np.sort([s.p_value for s in campaign])
    steps = np.arange(len(p)) / len(p)
    assert max((p - steps).max(), (steps + 1 / len(p) - p).max()) < 1.63 / np.sqrt(len(p))


@pytest.mark.slow
def test_covariance_is_true(campaign):
    errors = np.array([s.estimate for s in campaign]) - parameters_of(TRIAD)
    mean = np.mean([nees(e, s.covariance) for e, s in zip(errors, campaign, strict=True)])
    low, high = chi_square_interval(len(PARAMETERS), len(campaign), 0.99)
    assert low < mean < high
    ratio = campaign[0].standard_deviation / errors.std(axis=0, ddof=1)
    low, high = ratio_interval(len(campaign), 1 - 0.01 / ratio.size)  # 1 % for any of the 15
    assert ((low < ratio) & (ratio < high)).all(), dict(zip(PARAMETERS, ratio, strict=True))


def test_readout_noise_of_a_turn_is_shared_by_the_gyros():
    covariance = bench_fit.data_covariance(bench.run(STAGED, TRIAD, TABLE), (TRIAD, TABLE))
    # against drawn records: readings less the model at the angles that were read
    record = bench.run(STAGED, TRIAD, TABLE, rng=np.random.default_rng(3), runs=3000)
    model = bench.expected_readings(STAGED, TRIAD, TABLE, record.turned)
    drawn = np.cov((record.readings - model).reshape(3000, -1).T)
    deviation = np.sqrt(np.diag(covariance))
    # an entry of a correlation matrix from n runs: 1 / sqrt(n), on the diagonal sqrt(2 / n); 465 entries, 5 sigma
    assert_allclose((drawn - covariance) / np.outer(deviation, deviation), 0, atol=5 * np.sqrt(2 / 3000))
    turn = covariance[12:15, 12:15]
    assert turn[0, 0] > 2 * turn[1, 1]  # the readout matters, for the gyro that turns
    assert turn[0, 1] != 0


def test_without_turns_about_z_only_the_earth_is_left_for_its_gyro():
    def deviations(segments):
        record = bench.run(Plan(PLAIN, segments), TRIAD, TABLE)
        return bench_fit.fit(record, (BELIEVED, TABLE)).standard_deviation

    ratio = deviations(STAGED.segments[:8]) / deviations(STAGED.segments)
    # the Earth turns 1e4 times slower than the table
    poor = {name for name, r in zip(PARAMETERS, ratio, strict=True) if r > 100}
    assert poor == {"scale_positive_z", "scale_negative_z", "alpha_yx", "beta_xy"}


@pytest.mark.parametrize(
    ("segments", "names"),
    [
        # four readings for five parameters of each gyro
        (STAGED.segments[:4], [n for n in PARAMETERS if n.startswith("scale")] + ["bias_z"]),
        (STAGED.segments[4:5] * 3, [n for n in PARAMETERS if n not in ("gamma_xz", "beta_xy")]),
        # one direction of turn about z, and nothing else for the z gyro's own axis
        (STAGED.segments[8:9], ("bias_z", "scale_positive_z")),
    ],
)
def test_plans_that_leave_parameters_open_name_them(segments, names):
    record = bench.run(Plan(PLAIN, segments), TRIAD, TABLE, rng=np.random.default_rng(1))
    with pytest.raises(ValueError, match="the plan does not determine") as caught:
        bench_fit.fit(record, (BELIEVED, TABLE))
    message = str(caught.value).split(":")[0]
    for name in names:
        assert f"`{name}`" in message


def test_priors_of_the_table_widen_the_parameters_that_they_reach():
    prior = 3 * ARCSEC
    record = bench.run(STAGED, TRIAD, TABLE)
    plain = bench_fit.fit(record, (BELIEVED, TABLE))
    wide = bench_fit.fit(record, (BELIEVED, TABLE), geometry=dict.fromkeys(GEOMETRY, prior))
    assert wide.names == (*PARAMETERS, *GEOMETRY)
    assert (wide.standard_deviation[:15] > 0.999 * plain.standard_deviation).all()
    reach = dict(zip(MISALIGNMENTS, wide.standard_deviation[9:15] / prior, strict=True))
    # roots of the number of errors that reach each angle: mounting in all; the leaning of the inner axis; of the middle
    expected = {"alpha_yx": 1, "alpha_zx": 2, "beta_xy": 3, "beta_zy": 2, "gamma_xz": 1, "gamma_yz": 1}
    for name, count in expected.items():
        # level errors are seen by the Earth's rate, which takes a few per cent off the prior of the others
        assert_allclose(reach[name], np.sqrt(count), rtol=0.05, err_msg=name)
    # mounting rests on its prior: no reading tells it from the angles
    assert_allclose([wide.standard_deviation[wide.index(f"mounting_{axis}")] for axis in "xyz"], prior, rtol=1e-3)
    assert_allclose(wide.correlation[wide.index("mounting_z"), wide.index("gamma_xz")], -1, atol=1e-2)
    assert len(wide.unobservable) == 3
    assert not wide.undetermined
    assert_allclose(wide.estimate[:15], plain.estimate, atol=1e-9)


def test_an_error_of_the_table_is_found_if_the_readings_show_it():
    table = RateTable(latitude=60 * DEG, readout_noise=2 * ARCSEC, azimuth_error=200 * ARCSEC)
    record = bench.run(STAGED, TRIAD, table)
    solution = bench_fit.fit(record, (BELIEVED, TABLE), geometry={"azimuth_error": np.inf})
    assert_allclose(solution["azimuth_error"], 200 * ARCSEC, rtol=1e-6)
    assert_allclose(solution.estimate[:15], parameters_of(TRIAD), atol=1e-10)
    # believed to be there, it need not be found
    known = bench_fit.fit(record, (BELIEVED, table))
    assert_allclose(known.estimate, parameters_of(TRIAD), atol=1e-10)
    # neither: the chi-square of noise-free data shows it
    assert bench_fit.fit(record, (BELIEVED, TABLE)).chi_square > 10


@pytest.mark.parametrize("axis", ["x", "z"])
def test_mounting_without_a_prior_is_not_told_from_the_angles(axis):
    record = bench.run(STAGED, TRIAD, TABLE)
    pair = {"x": ("alpha_yx", "alpha_zx"), "z": ("gamma_xz", "gamma_yz")}[axis]
    with pytest.raises(ValueError, match="the plan does not determine") as caught:
        bench_fit.fit(record, (BELIEVED, TABLE), geometry={f"mounting_{axis}": np.inf})
    for name in (*pair, f"mounting_{axis}"):
        assert f"`{name}`" in str(caught.value)


@pytest.mark.parametrize(
    ("geometry", "message"),
    [
        ({"level": ARCSEC}, r"`geometry` .*'level_east'.*got \['level'\]"),
        ({"level_east": 0.0}, "`geometry` .* 'level_east'"),
        ({"level_east": np.nan}, "`geometry` .* 'level_east'"),
        ({"level_east": -ARCSEC}, "`geometry` .* 'level_east'"),
    ],
)
def test_impossible_geometry_is_refused_by_name(geometry, message):
    with pytest.raises(ValueError, match=message):
        bench_fit.fit(bench.run(STAGED, TRIAD, TABLE), (BELIEVED, TABLE), geometry=geometry)


def test_many_runs_at_once_are_refused():
    with pytest.raises(ValueError, match="`record` must hold a single run"):
        bench_fit.fit(bench.run(STAGED, TRIAD, TABLE, runs=2), (BELIEVED, TABLE))
