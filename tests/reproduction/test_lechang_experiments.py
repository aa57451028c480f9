"""The thesis's experiments: scatter of scans, drifts that table 6 would need, stored runs of the second."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose

from fogkit import claims
from fogkit.constants import EARTH_RATE
from fogkit.estimation.consistency import ratio_interval
from fogkit.gyrocompass.design import heading_accuracy
from fogkit.gyrocompass.design_inputs import GyroGrade
from fogkit.gyrocompass.scan import fit_scan, scan_readings
from fogkit.noise import RandomErrors
from fogkit.reproduction.lechang import experiment_verdicts, experiments, paper, scanning
from fogkit.units import ARCMIN, DEG, DEG_PER_HOUR, DEG_PER_HOUR_PER_SQRT_HOUR, PPM

ROOT = Path(__file__).parents[2]
LAT = paper.ASSUMED_LATITUDE
WALK = RandomErrors(angle_random_walk=paper.random_walk_of_the_data_sheet(2))


@pytest.fixture(scope="module")
def stored():
    return pd.read_csv(ROOT / experiments.RUNS)


def test_derivatives_of_a_scan():
    # readings are bilinear: a step of any size in one parameter gives the derivative but for rounding
    at, scales, sine = scanning.angles(), scanning.DATA_SHEET_SCALES, np.sin(paper.STAND_HEADING)
    D = scanning.design(scales, sine)
    clean = scan_readings(at, paper.STAND_HEADING, LAT, scales)
    for g in range(3):
        more = scales.copy()
        more[g] += 1.0
        mean = np.zeros((12, 3))
        mean[:, g] = (scan_readings(at, paper.STAND_HEADING, LAT, more) - clean)[:, g].mean()
        step = (scan_readings(at, paper.STAND_HEADING, LAT, more) - clean - mean).ravel()
        assert_allclose(D[:, 3 + g], step, atol=1e-18)
    other = np.pi - 0.3  # a heading with another sine; what changes with the cosine is a mean
    step = scan_readings(at, other, LAT, scales) - clean
    step -= step.mean(axis=0)
    assert_allclose(D[:, 6] * (np.sin(other) - sine), step.ravel(), atol=1e-17)


def test_scatter_of_a_scan():
    # against the fit's own covariance for white noise, and against simulated scans for a wandering bias
    sigma = WALK.angle_random_walk / np.sqrt(60) * paper.DATA_SHEET_SCALE
    readings = scan_readings(scanning.angles(), paper.STAND_HEADING, LAT, scanning.DATA_SHEET_SCALES)
    fit = fit_scan(scanning.angles(), readings, LAT, standard_deviation=sigma)
    white = scanning.scatter(WALK)
    assert_allclose(white["heading"], fit.heading_std, rtol=1e-8)
    assert_allclose(white["scale"], fit.scale_std / paper.DATA_SHEET_SCALE, rtol=1e-8)
    # 120 numbers of three scale factors, 4 sigma; small, so that the fit is linear
    walk = RandomErrors(rate_random_walk=0.3 * DEG_PER_HOUR_PER_SQRT_HOUR)
    z = (scanning.scans(range(40), walk)[["scale_x", "scale_y", "scale_z"]] - 1) / scanning.scatter(walk)["scale"]
    assert abs(np.sqrt(np.mean(np.square(z.to_numpy()))) - 1) < 4 / np.sqrt(2 * 120)


@pytest.mark.parametrize("positions", [12, 24])
def test_ramps_that_table_6_would_need(positions):
    sine, drift, residual = scanning.ramps_needed(positions)
    assert abs(sine) > 1  # no heading has it
    at, ours = scanning.angles(positions), scanning.DATA_SHEET_SCALES
    still = (scan_readings(at, np.pi / 2, LAT) + scan_readings(at, -np.pi / 2, LAT)) / 2
    east = (scan_readings(at, np.pi / 2, LAT) - scan_readings(at, -np.pi / 2, LAT)) / 2
    ramp = np.linspace(-0.5, 0.5, positions)[:, np.newaxis] * drift
    readings = ours * (still + sine * east + ramp)

    def squares(scales, heading):
        left = readings - scan_readings(at, heading, LAT, scales)
        return ((left - left.mean(axis=0)) ** 2).sum()

    least = squares(paper.STAND_SCALES, paper.STAND_HEADING)
    amplitude = scanning.amplitudes().max()
    assert_allclose(np.sqrt(least / (3 * positions)) / amplitude, residual, rtol=1e-6)
    # the slope by differences, against the curvature's
    steps = [(row, 0.0) for row in 0.01 * np.diag(paper.STAND_SCALES)] + [(np.zeros(3), 1e-4)]
    for scale, turn in steps:
        sides = [squares(paper.STAND_SCALES + k * scale, paper.STAND_HEADING + k * turn) for k in (-1, 1)]
        assert abs(sides[1] - sides[0]) < 1e-3 * max(abs(side - least) for side in sides) + 1e-9 * least


def test_digitiser():
    # brute force: means of many rounded samples over all places in a step
    bits, rng = 14, np.random.default_rng(2)
    step = 2 * paper.GYRO_RANGE * paper.DATA_SHEET_SCALE / 2**bits
    deviation = paper.DATA_SHEET_NOISE * 10
    places = step * np.linspace(0, 1, 40, endpoint=False)
    samples = places + deviation * rng.standard_normal((20000, 40))
    errors = (step * np.rint(samples / step)).mean(axis=0) - places
    # scatter of a mean of 20000 samples, four sigma; the second harmonic is exp(-6 x) of the first, 0.4 %
    assert_allclose(np.abs(errors).max(), scanning.digitiser_error(bits), atol=4 * step / np.sqrt(20000))


def test_stored_runs_are_those_of_the_function(stored):
    for law, known, sides, velocity, seed in (
        ("harmonic 180", "scan", 2, 0.001, 7),
        ("harmonic 180", "data sheet, mount", 1, 0.1, 41),
        ("harmonic 137.8", "table 6", 2, 0.01, 99),
        ("reversal 180", "data sheet, mount", 1, 0.001, 0),
    ):
        again = experiments.accuracy_case(seed, law, sides, velocity, known)
        row = stored[
            (stored.law == law)
            & (stored.prior == known)
            & (stored.sides == sides)
            & (stored.velocity_std == velocity)
            & (stored.seed == seed)
        ]
        assert len(row) == 1
        for name in ("error_arcmin", "std_arcmin", "innovations"):  # other processors round another way
            assert_allclose(row[name].item(), again[name], rtol=1e-3, atol=1e-3)


def test_filter_is_right_where_the_chapter_says_so(stored):
    table = experiments.within(stored)
    assert (stored.groupby(["law", "prior", "velocity_std", "sides"]).size() == 100).all()
    sure = table.drop(index="data sheet", level="prior")
    ratio = sure.rms_arcmin / sure.std_arcmin
    # 42 cells that share their seeds: an interval that one cell leaves once in 10 000
    low, high = ratio_interval(100, 0.9999, mean_known=True)
    assert low < ratio.min() and ratio.max() < high
    failed = table.loc["harmonic 180", "data sheet", 0.001]
    assert (failed.rms_arcmin > 2 * failed.std_arcmin).all()  # 1.5 % of scale factor are too many for the model


def test_predicted_deviation_is_that_of_the_runs(stored):
    table = experiments.within(stored)
    for velocity, sides in ((0.001, 1), (0.1, 2)):
        predicted = experiments.predicted_std("harmonic 180", sides, velocity, "table 6") / ARCMIN
        # the filter's own standard deviations scatter by some per cent with heading and noise
        assert_allclose(table.std_arcmin["harmonic 180", "table 6", velocity, sides], predicted, rtol=0.05)


def test_share_and_interval(stored):
    # Clopper and Pearson for 8 of 10, from the binomial distribution itself
    from scipy.stats import binom

    runs = pd.DataFrame(
        {
            "law": "a",
            "prior": "b",
            "velocity_std": 1.0,
            "sides": 2,
            "error_arcmin": [1.0] * 4 + [-29.9] * 4 + [30.1, -50.0],
            "std_arcmin": 30.0,
        }
    )
    row = experiments.within(runs).iloc[0]
    assert row.share == 0.8 and row.normal == pytest.approx(0.6827, abs=1e-4)
    assert binom.sf(7, 10, row.low) == pytest.approx(0.025)
    assert binom.cdf(8, 10, row.high) == pytest.approx(0.025)


def test_wrong_heading_of_the_scan_shows_in_the_experiment():
    errors = experiments.branch_runs(range(2))
    # what the mean direction m leaves of the biases' change: |m| times 2 cos(heading) of the level Earth rate, and the
    # angle walks of 30 arcmin besides; exact only for a small angle
    assert np.abs(errors).min() > 5 * DEG
    best = experiments.branch_runs(range(2), "harmonic 137.8")
    assert np.abs(best).max() < 4 * 30 * ARCMIN


def test_table_6_would_have_shown():
    assert experiments.known_scale_std().max() < 0.005
    assert scanning.drift_of_scale(1) == pytest.approx(3.9 * DEG_PER_HOUR, rel=0.05)  # by hand from 8.4 deg/h


def test_verdicts():
    assert not experiment_verdicts.scan_tells_heading()
    assert not experiment_verdicts.agreement_shows_accuracy()
    assert not experiment_verdicts.biases_confirmed()
    assert experiment_verdicts.scale_of_y_would_show()
    assert experiment_verdicts.accuracy_follows_noise()
    assert all(experiment_verdicts.readings_are_harmonic(gyro) for gyro in range(3))
    # 18.85 deg/s over sqrt(3) and over 80
    assert experiment_verdicts.peak_rate() == pytest.approx(np.pi * 2 * np.pi / 60 / np.sqrt(3) / (80 * DEG))
    # scatter of white noise at the time that it gives
    dwell = experiment_verdicts.dwell_for()
    assert scanning.scatter(WALK, dwell)["heading"] == pytest.approx(paper.HEADING_ACCURACY)
    level = experiment_verdicts.bias_stds()[[0, 2]]
    assert level.max() < 0.2 * DEG_PER_HOUR  # both level ones are found


def test_means_of_the_scan_that_the_ledger_states():
    # bias and the part of the Earth's rate along the level axis: a gyro of the pyramid has (-1, 2, -1)/sqrt(6) of it
    level = EARTH_RATE * np.cos(LAT) * np.cos(paper.STAND_HEADING)
    means = paper.STAND_SCALES * (paper.STAND_BIASES + np.array([-1, 2, -1]) / np.sqrt(6) * level)
    assert_allclose(scanning.figure_readings(scanning.angles()).mean(axis=0), means, rtol=1e-12)
    notes = {claim.id: claim.note for claim in claims.load("lechang")}
    for row, mean in zip(("fig14", "fig15", "fig16"), means, strict=True):
        assert f"mean of {mean / 1e-3:.2f} and" in notes[f"lechang-{row}"]


def test_asymmetry_that_the_experiment_may_have():
    # least squares of all three gyros' readings for heading, biases and scale factors, without the mount's axis, along
    # which its rate is unknown; each gyro's asymmetry for itself, 16 ppm as the ledger has it
    law, heading = experiments.LAWS["harmonic 180"], 0.9
    t = paper.EXPERIMENT_TIME * (np.arange(6000) + 0.5) / 6000
    angle, rate, _ = law.motion(t)
    axes = np.array([[-1, np.sqrt(2), np.sqrt(3)], [2, np.sqrt(2), 0], [-1, np.sqrt(2), -np.sqrt(3)]]) / np.sqrt(6)
    level, up = EARTH_RATE * np.cos(LAT), EARTH_RATE * np.sin(LAT)
    turned = angle - heading
    readings = axes @ np.array([level * np.cos(turned), up + rate, level * np.sin(turned)])
    slope = axes @ np.array([level * np.sin(turned), 0 * rate, -level * np.cos(turned)])
    across = np.eye(3) - np.full((3, 3), 1 / 3)

    def column(gyro, signal):
        return (across[:, [gyro]] * signal).ravel()

    columns = [(across @ slope).ravel()]
    for gyro in range(3):
        columns += [column(gyro, np.ones(6000)), column(gyro, readings[gyro])]
    A = np.array(columns).T
    scale = np.linalg.norm(A, axis=0)
    wrong = np.array([column(gyro, 0.5 * np.abs(readings[gyro])) for gyro in range(3)]).T
    heading_errors = np.linalg.lstsq(A / scale, wrong, rcond=1e-9)[0][0] / scale[0]
    allowed = paper.EXPERIMENT_ACCURACY / np.linalg.norm(heading_errors)
    notes = {claim.id: claim.note for claim in claims.load("lechang")}
    assert f" {allowed / PPM:.0f} ppm alone" in notes["lechang-exp2-accuracy"]
    gyro = GyroGrade(angle_random_walk=WALK.angle_random_walk, scale_asymmetry=allowed)
    found = heading_accuracy(gyro, law, LAT, paper.EXPERIMENT_TIME, heading_fixed=True)
    # the design leaves the Earth's rate out of what a gyro's asymmetry sees: 1e-3 of the mount's rate
    assert found.budget["asymmetry"] == pytest.approx(paper.EXPERIMENT_ACCURACY, rel=1e-3)


def test_shares_that_the_ledger_states(stored):
    share = 100 * experiments.within(stored).share["harmonic 180"]
    best = [share["scan", 0.001, sides] for sides in (2, 1)]
    sheet = [share["data sheet, mount", std, 2] for std in (0.001, 0.01, 0.1)]
    note = {claim.id: claim.note for claim in claims.load("lechang")}["lechang-exp2-accuracy"]
    assert (
        "are {:.0f} % of 100 runs ({:.0f} % one-sided), then {:.0f}, {:.0f} and {:.0f} %".format(*best, *sheet) in note
    )
