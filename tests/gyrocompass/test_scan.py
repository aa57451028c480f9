"""Scans of the Earth rate: synthetic data give back what made them, and what they leave open; scatter."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass import frames, mechanisation, scan
from fogkit.reproduction.lechang import paper
from fogkit.units import DEG

LAT = paper.ASSUMED_LATITUDE
ANGLES = np.arange(0, 360, 30) * DEG
TABLE_6 = (paper.STAND_HEADING, LAT, paper.STAND_SCALES, paper.STAND_BIASES)


def test_level_gyro():
    assert_allclose(
        scan.level_reading([0, np.pi / 2, np.pi], LAT), EARTH_RATE * np.cos(LAT) * np.array([1, 0, -1]), atol=1e-20
    )
    for azimuth in (0.4, -2.5):
        found = scan.azimuths(float(scan.level_reading(azimuth, LAT, 7.0, -300.0)), LAT, 7.0, -300.0)
        assert min(abs(a - azimuth) for a in found) < 1e-9  # rounding of the offset against 0.01
        assert found[0] == -found[1]
    with pytest.raises(ValueError, match="`reading` must be within the level Earth rate of `offset`, got 2"):
        scan.azimuths(2 * EARTH_RATE * np.cos(LAT), LAT)
    with pytest.raises(ValueError, match="`scale` must not be 0"):
        scan.azimuths(0.0, LAT, scale=0.0)


def test_readings_are_those_of_the_mechanisation():
    C = frames.hull_attitude(paper.STAND_HEADING, 0.0, ANGLES)
    rates = mechanisation.gyro_rates(C.swapaxes(-1, -2) @ mechanisation.geographic_rate(LAT, np.zeros(3)), 0.0, 0.0)
    expected = paper.STAND_SCALES * (rates + paper.STAND_BIASES)
    assert_allclose(scan.scan_readings(ANGLES, *TABLE_6), expected, rtol=1e-13)


def test_table_6_comes_back_twice():
    readings = scan.scan_readings(ANGLES, *TABLE_6)
    fit = scan.fit_scan(ANGLES, readings, LAT, standard_deviation=1e-6)
    # means are 400 times the amplitudes: rounding of 1e-16 becomes 1e-13, a Gauss-Newton step to 1e-9
    assert_allclose(fit.scales, paper.STAND_SCALES, rtol=1e-8)
    assert_allclose(np.sort(fit.headings), np.array([58.5, 121.5]) * DEG, rtol=1e-8)
    right = int(np.argmin(np.abs(fit.headings - paper.STAND_HEADING)))
    assert_allclose(fit.biases[right], paper.STAND_BIASES, rtol=1e-8)
    # the other heading explains the same readings as well, with biases that differ by the level Earth rate
    other = scan.scan_readings(ANGLES, float(fit.headings[1 - right]), LAT, fit.scales, fit.biases[1 - right])
    assert_allclose(other, readings, rtol=1e-9)
    step = 2 * EARTH_RATE * np.cos(LAT) * abs(np.cos(paper.STAND_HEADING)) * np.abs(frames.pyramid_axes()[0])
    assert_allclose(np.abs(fit.biases[0] - fit.biases[1]), step, rtol=1e-6)


def test_scatter_is_as_predicted():
    rng = np.random.default_rng(4)
    sigma = 1e-6  # V: a hundredth of the Earth rate's amplitude
    clean = scan.scan_readings(ANGLES, *TABLE_6)
    fits = [
        scan.fit_scan(ANGLES, clean + sigma * rng.standard_normal(clean.shape), LAT, standard_deviation=sigma)
        for _ in range(200)
    ]
    headings = np.array([fit.headings.max() for fit in fits])
    # 4 sigma of a deviation from 200 samples, 0.2; the second order of the sine adds a few per cent
    assert_allclose(headings.std(), fits[0].heading_std, rtol=4 / np.sqrt(400))
    assert abs(headings.mean() - paper.STAND_HEADING) < 4 * fits[0].heading_std / np.sqrt(200)
    scales = np.array([fit.scales for fit in fits])
    assert_allclose(scales.std(axis=0), fits[0].scale_std, rtol=4 / np.sqrt(400))


def test_drift():
    time = 60.0 * np.arange(12)
    drift = np.array([2e-8, -1e-8, 3e-8])  # V/s: 20 uV over the scan, a fifth of the Earth rate's amplitude
    readings = scan.scan_readings(ANGLES, *TABLE_6) + time[:, np.newaxis] * drift
    blind, seeing = (scan.fit_scan(ANGLES, readings, LAT, time=t, standard_deviation=1e-6) for t in (None, time))
    assert_allclose(seeing.scales, paper.STAND_SCALES, rtol=1e-7)
    assert_allclose(seeing.headings.max(), paper.STAND_HEADING, rtol=1e-7)
    assert np.abs(blind.scales / paper.STAND_SCALES - 1).max() > 0.03
    assert blind.solution.p_value < 1e-6  # what it does to the residuals is seen, if their size is known


def test_bad_scans():
    readings = scan.scan_readings(ANGLES, *TABLE_6)
    with pytest.raises(ValueError, match="the scan"):
        scan.fit_scan(ANGLES[[0, 6, 0, 6]], readings[[0, 6, 0, 6]], LAT, standard_deviation=1e-6)
    with pytest.raises(ValueError, match="`lat` must not be at the equator"):
        scan.fit_scan(ANGLES, readings, 0.0)
    with pytest.raises(ValueError, match="times its level rate across the axis"):
        scan.fit_scan(ANGLES, scan.scan_readings(ANGLES, np.pi / 2, 45 * DEG), 75 * DEG, standard_deviation=1e-6)
    with pytest.raises(ValueError, match="`time` must not be the same"):
        scan.fit_scan(ANGLES, readings, LAT, time=np.zeros(12))
