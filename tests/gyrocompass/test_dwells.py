"""Scans from raw records: dwells found, means, weights, drift, and what is refused; scale factors from the mount."""

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose

from fogkit.gyrocompass.covariance import Noise
from fogkit.gyrocompass.dwells import find_dwells
from fogkit.gyrocompass.filters.records import record
from fogkit.gyrocompass.laws import QuasiHarmonic
from fogkit.gyrocompass.motions import Vessel
from fogkit.gyrocompass.mount_scale import scale_from_mount
from fogkit.gyrocompass.scan import fit_scan, scan_readings
from fogkit.noise import RandomErrors
from fogkit.reproduction.lechang import paper, scanning
from fogkit.units import DEG, DEG_PER_HOUR

LAT = paper.ASSUMED_LATITUDE
WALK = paper.random_walk_of_the_data_sheet(2)


def raw(seed=0, **kwargs):
    errors = RandomErrors(**kwargs)
    return scanning.recording(np.random.default_rng(seed), errors, dwell=20.0, dt=0.1)


def right(fit):
    return int(np.argmin(np.abs(fit.headings - paper.STAND_HEADING)))


def test_a_clean_record_returns_table_6():
    table = raw()
    dwells = find_dwells(table)
    assert len(dwells.angle) == 12
    assert_allclose(dwells.angle, 30 * np.arange(12) * DEG, atol=1e-12)
    # 20 s and a sample at which the turn has not begun, less 2 s of settling and 1 s of guard
    assert_allclose(dwells.duration, 17.0, atol=0.15)
    assert dwells.unused == pytest.approx(1 - dwells.duration.sum() / (12 * 20 + 11 * scanning.TURN), abs=0.001)
    fit = dwells.fit(LAT)
    assert_allclose(fit.headings[right(fit)], paper.STAND_HEADING, rtol=1e-8)
    assert_allclose(fit.scales, paper.STAND_SCALES, rtol=1e-8)
    assert_allclose(fit.biases[right(fit)], paper.STAND_BIASES, rtol=1e-8)
    # in rad/s and under other names the same, with scale factors without unit
    rates = table / [1.0, *paper.STAND_SCALES]
    rates = rates.rename(columns={f"gyro_{g}": f"rate_{g}" for g in "xyz"})
    assert_allclose(find_dwells(rates, columns=("rate_x", "rate_y", "rate_z")).fit(LAT).scales, 1.0, rtol=1e-8)


def test_turns_are_cut():
    # without a guard the first sample of a turn would be read, 0.7 deg in a dwell of 18 s, in all dwells but the last
    table = raw()
    loose = find_dwells(table, guard=0.0, tolerance=1 * DEG).fit(LAT)
    assert np.abs(loose.biases[1] - paper.STAND_BIASES).max() > 0.01 * DEG
    assert np.abs(find_dwells(table).fit(LAT).biases[1] - paper.STAND_BIASES).max() < 1e-8 * DEG


def test_chi_square_and_drift():
    # white noise of the data sheet: chi-square is that of 36 readings less 7 parameters, 4 sigma either way
    dwells = find_dwells(raw(3, angle_random_walk=WALK))
    fit = dwells.fit(LAT, noise=WALK * np.abs(paper.STAND_SCALES))
    assert fit.solution.degrees_of_freedom == 29
    assert abs(fit.solution.chi_square - 29) < 4 * np.sqrt(2 * 29)
    # scatter of a mean over that of white noise: 170 samples, 4 sigma
    expected = WALK * np.abs(paper.STAND_SCALES) / np.sqrt(dwells.duration)[:, np.newaxis]
    assert_allclose(dwells.scatter / expected, 1.0, atol=4 / np.sqrt(2 * 170))
    # a drift in proportion to time is taken out by a line, and by more; a second degree needs a parabola
    table = raw(3, rate_ramp=0.003 * DEG_PER_HOUR)
    assert np.abs(find_dwells(table).fit(LAT).scales / paper.STAND_SCALES - 1).max() > 0.01
    for degree in (1, 2, 3):
        assert_allclose(find_dwells(table).fit(LAT, drift=degree).scales, paper.STAND_SCALES, rtol=1e-6)
    bent = table.copy()
    bent["gyro_y"] += 1e-9 * (table.index.to_numpy() - 100) ** 2
    assert np.abs(find_dwells(bent).fit(LAT, drift=1).scales / paper.STAND_SCALES - 1).max() > 1e-3
    # within a dwell the parabola's mean is not its value in the middle: by the same for all dwells
    assert_allclose(find_dwells(bent).fit(LAT, drift=2).scales, paper.STAND_SCALES, rtol=1e-6)


def test_weights():
    at, rng = scanning.angles(), np.random.default_rng(5)
    clean = scanning.figure_readings(at)
    std = np.where(np.arange(12) % 2, 1e-6, 3e-5)
    readings = clean + std[:, np.newaxis] * rng.standard_normal(clean.shape)
    given = fit_scan(at, readings, LAT, standard_deviation=std)
    assert_allclose(
        fit_scan(at, readings, LAT, standard_deviation=np.tile(std[:, None], 3)).scales, given.scales, rtol=1e-12
    )
    ratios = fit_scan(at, readings, LAT, standard_deviation=1e3 * std, scale="estimated")
    assert_allclose(ratios.scales, given.scales, rtol=1e-9)
    equal = fit_scan(at, readings, LAT, standard_deviation=1e-5)
    wrong = [np.abs(f.scales / paper.STAND_SCALES - 1).max() for f in (given, equal)]
    assert wrong[0] < 4 * (given.scale_std / np.abs(paper.STAND_SCALES)).max() < wrong[1]
    with pytest.raises(ValueError, match=r"`standard_deviation` must be one number, of shape \(12,\) or of \(12, 3\)"):
        fit_scan(at, readings, LAT, standard_deviation=std[:5])


def test_known_biases_tell_the_headings_apart():
    # biases drawn as stated: the odds are right as often as they say
    rng, spread, said, met = np.random.default_rng(6), 2e-5, [], []
    for _ in range(100):
        heading, biases = rng.uniform(-np.pi, np.pi), spread * rng.standard_normal(3)
        if abs(np.cos(heading)) < 0.1:
            continue
        fit = fit_scan(scanning.angles(), scan_readings(scanning.angles(), heading, LAT, biases=biases), LAT)
        first = 1 / (1 + np.exp(-fit.log_odds(spread)))
        said.append(max(first, 1 - first))
        met.append((first > 0.5) == (np.cos(heading - fit.headings[0]) > np.cos(heading - fit.headings[1])))
    said = np.array(said)
    assert 0.55 < said.mean() < 0.95  # neither sure nor blind, so the next line tests something
    assert abs(np.mean(met) - said.mean()) < 4 * np.sqrt((said * (1 - said)).sum()) / len(said)


def test_bad_records():
    table = raw()
    with pytest.raises(ValueError, match="`table` must hold dwells of 103 s at least"):
        find_dwells(table, shortest=100.0)
    with pytest.raises(ValueError, match="must ascend, got"):
        find_dwells(table.iloc[::-1])
    with pytest.raises(ValueError, match="without 'voltage_x'"):
        find_dwells(table, columns=("voltage_x", "gyro_y", "gyro_z"))
    with pytest.raises(ValueError, match="`noise` must be one number or three"):
        find_dwells(table).fit(LAT, noise=0.0)
    hole = table.drop(index=table.index[100])
    with pytest.warns(UserWarning, match="samples are missing in a dwell, 1 times, first after 9.9 s"):
        assert len(find_dwells(hole).angle) == 13
    frame = find_dwells(table).to_frame()
    assert list(frame.columns[:3]) == ["angle", "duration", "gyro_x"] and isinstance(frame, pd.DataFrame)


def test_scale_factors_from_the_mount():
    motion = Vessel(lat=LAT, heading=2.0).motion(60.0, 0.1, QuasiHarmonic(amplitude=np.pi, period=30.0))
    scale, rng = np.array([0.01, -0.02, 0.005]), np.random.default_rng(1)
    bias = np.array([30.0, -20.0, 10.0]) * DEG_PER_HOUR
    clean = record(motion, Noise(angle_random_walk=0.0), rng, bias=bias, scale_factor=scale)
    # the level Earth rate at the middle of a step: 1e-3 of it, over 20 deg/s
    assert_allclose(scale_from_mount(clean)[0], scale, atol=1e-7)
    z = []
    for _ in range(40):
        noisy = record(motion, Noise(angle_random_walk=WALK), rng, bias=bias, scale_factor=scale)
        error, std = scale_from_mount(noisy, WALK)
        z.append((error - scale) / std)
    assert abs(np.sqrt(np.mean(np.square(z))) - 1) < 4 / np.sqrt(240)  # 4 sigma of 120 numbers
    still = record(Vessel(lat=LAT).motion(5.0, 0.1), Noise(angle_random_walk=0.0), rng)
    with pytest.raises(ValueError, match="`recording` must have a mount that turns by 1 rad"):
        scale_from_mount(still)
