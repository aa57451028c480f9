"""The record of a calibration: round trip, table, and the deviation of the asymmetry."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.calibration.triad import PARAMETERS, TriadCalibration, parameters_of, triad_from_parameters
from fogkit.estimation.consistency import ratio_interval
from fogkit.imu import GyroTriad

RNG = np.random.default_rng(8)
ESTIMATE = np.concatenate([1e-7 * RNG.standard_normal(3), 1.7 + 1e-3 * RNG.random(6), 1e-3 * RNG.standard_normal(6)])
ROOT = 1e-6 * RNG.standard_normal((15, 15))
CALIBRATION = TriadCalibration(estimate=ESTIMATE, covariance=ROOT @ ROOT.T)


@pytest.mark.parametrize("covariance", [CALIBRATION.covariance, None])
def test_text_gives_back_every_bit(covariance):
    back = TriadCalibration.from_json(TriadCalibration(estimate=ESTIMATE, covariance=covariance).to_json())
    assert (back.estimate == ESTIMATE).all()
    assert (back.covariance is None) if covariance is None else (back.covariance == covariance).all()


def test_text_of_other_parameters_is_refused():
    data = json.loads(CALIBRATION.to_json())
    data["parameters"] = data["parameters"][::-1]
    with pytest.raises(ValueError, match=r"`text` must hold the parameters .*bias_x"):
        TriadCalibration.from_json(json.dumps(data))


def test_parameters_and_triad_are_one_thing_in_two_forms():
    triad = triad_from_parameters(ESTIMATE)
    assert (parameters_of(triad) == ESTIMATE).all()
    assert triad == CALIBRATION.triad
    named = dict(
        zip(PARAMETERS, parameters_of(GyroTriad(bias=(1, 2, 3), misalignments=np.arange(6) / 10)), strict=True)
    )
    assert [named[name] for name in ("bias_z", "scale_negative_x", "alpha_zx", "gamma_yz")] == [3, 1, 0.1, 0.5]


def test_table():
    frame = CALIBRATION.to_frame()
    assert list(frame.index) == list(PARAMETERS)
    assert frame.index.name == "parameter"
    assert frame.loc["scale_negative_y", "estimate"] == ESTIMATE[7]
    assert_allclose(frame.loc["bias_y", "standard_deviation"] ** 2, CALIBRATION.covariance[1, 1], rtol=1e-14)
    assert TriadCalibration(estimate=ESTIMATE).to_frame()["standard_deviation"].isna().all()


def test_asymmetry_and_its_deviation_are_those_of_drawn_scale_factors():
    runs = 20_000
    drawn = ESTIMATE + np.random.default_rng(9).standard_normal((runs, 15)) @ ROOT.T
    many = TriadCalibration(estimate=drawn, covariance=CALIBRATION.covariance)
    plus, minus = ESTIMATE[3:6], ESTIMATE[6:9]
    assert_allclose(CALIBRATION.asymmetry, 2 * (plus - minus) / (plus + minus), rtol=1e-12)
    ratio = CALIBRATION.asymmetry_deviation / many.asymmetry.std(axis=0, ddof=1)
    low, high = ratio_interval(runs, 1 - 0.01 / 3)
    assert ((low < ratio) & (ratio < high)).all()
    # correlated scale factors: the deviation is not that of two independent ones
    independent = np.hypot(CALIBRATION.standard_deviation[3:6] / plus, CALIBRATION.standard_deviation[6:9] / minus)
    assert (np.abs(CALIBRATION.asymmetry_deviation / independent - 1) > 0.02).any()
    assert TriadCalibration(estimate=ESTIMATE).asymmetry_deviation is None


def test_no_covariance_no_deviation():
    assert TriadCalibration(estimate=ESTIMATE).standard_deviation is None
