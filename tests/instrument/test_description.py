"""Bookkeeping of the instrument: what is left adds up, descriptions agree with one another, bad input is refused."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose

from fogkit.gyrocompass.design_inputs import GyroGrade
from fogkit.imu.unit import MeasurementUnit, Sensors
from fogkit.instrument import GRADES, PARTS, STANDS, Conditions, Instrument, Stand, calibrate, errors_left, study
from fogkit.instrument.description import bench_triad
from fogkit.instrument.heading import Knowledge, predicted
from fogkit.instrument.temperature import modelled_bias, temperature_test
from fogkit.noise.processes import RandomErrors
from fogkit.optics.drift import vibration_drift
from fogkit.rotation import dcm_from_rotvec
from fogkit.units import DEG, DEG_PER_HOUR, PPM

ROOT = Path(__file__).resolve().parents[2]
LATITUDE = 60 * DEG


@pytest.fixture(scope="module")
def unit():
    return GRADES["middle"].draw(np.random.default_rng(3))


def test_what_is_left_is_what_compensated_readings_have_too_much(unit):
    rng = np.random.default_rng(4)
    there, here = Conditions(acceleration=(2000 * DEG,) * 3), Conditions(acceleration=(0, 500 * DEG, 0), chamber=10.0)
    found = calibrate("positions", unit.at(there), STANDS["rough"], LATITUDE, rng)
    left = errors_left(unit, found, there, here)
    at_sea = unit.at(here)
    rates, forces = rng.uniform(-0.5, 0.5, (20, 3)), rng.uniform(-10, 10, (20, 3))
    gyros = at_sea.gyros.expected(rates) @ found.compensation.gyro_matrix.T + found.compensation.gyro_bias
    accel = at_sea.accelerometers.expected(forces) @ found.compensation.accelerometer_matrix.T
    accel = accel + found.compensation.accelerometer_bias
    to_axes = dcm_from_rotvec(left.boresight)
    # first order: asymmetries of 1e-5 and misalignments of 1e-3, products of both times 0.5 rad/s
    assert_allclose(gyros, left.rates(rates) @ to_axes.T, atol=1e-8)
    # the boresight is a rotation vector up to its third power, (5e-3)**3
    assert_allclose(accel, left.forces(forces) @ to_axes.T, atol=10 * 1e-6)
    parts = [left.only(part) for part in PARTS]
    assert_allclose(sum(p.rates(rates) - rates for p in parts), left.rates(rates) - rates, atol=1e-15)
    assert_allclose(sum(p.forces(forces) - forces for p in parts), left.forces(forces) - forces, atol=1e-12)


def test_the_bench_reads_what_the_unit_reads(unit):
    from fogkit.imu.readings import mean_readings

    sensors = unit.at(Conditions(), simulated=False)
    triad, rng = bench_triad(sensors), np.random.default_rng(5)
    for _ in range(6):
        axis, rate = np.linalg.qr(rng.standard_normal((3, 3)))[0][0], 0.3
        read = mean_readings(triad, np.eye(3), axis, rate, np.zeros(3), 10.0)
        assert_allclose(read, sensors.gyros.expected(rate * axis), atol=1e-15)


def test_vibration_by_simulation_and_by_law(unit):
    shaken = Conditions(acceleration=(5000 * DEG, -5000 * DEG, 1000 * DEG))
    simulated, law = unit.vibration_bias(shaken), unit.vibration_bias(shaken, simulated=False)
    # the loop has the fourth degree too: (residual phase)**2 of 1e-3
    assert_allclose(simulated, law, rtol=2e-3)
    assert law[0] == law[1] == vibration_drift(unit.gyro, 5000 * DEG, 60.0)
    # the drift goes with length cubed times diameter: the best gyro drifts most
    drifts = [vibration_drift(GRADES[g].gyro, 1000 * DEG, 60.0) for g in ("low", "middle", "high")]
    assert_allclose(drifts[2] / drifts[0], (1000 / 200) ** 3 * 0.1 / 0.05, rtol=1e-3)


def test_temperatures_follow_the_network_and_settle(unit):
    after = np.array([0.0, 600.0, 1e6])
    course = unit.thermal_bias(Conditions(chamber=5.0, powered=0.0), after)
    assert_allclose(course[-1], unit.thermal_bias(Conditions(chamber=5.0)), rtol=1e-9)
    # just after switching on all parts have the temperature of the air; the electronics warm by 5 W at 100 J/K
    effect, share = unit.thermal, np.array(unit.thermal_share)
    cold = -20 * sum(effect.temperature.values()) + effect.rate["electronics"] * 5.0 / 100.0
    source = 0.6 / 15.0  # has no effect on the bias
    assert "source" not in effect.rate and source
    assert_allclose(course[0], cold * share, rtol=1e-9)


def test_a_temperature_test_finds_what_is_there(unit):
    models = temperature_test(replace(unit, gyro=unit.gyro.with_angle_random_walk(1e-12)), np.random.default_rng(6))
    here, there = Conditions(chamber=5.0, powered=1800.0), Conditions()
    true = unit.thermal_bias(here) - unit.thermal_bias(there)
    seen = modelled_bias(unit, models, here) - modelled_bias(unit, models, there)
    assert np.abs(true).max() > 0.2 * DEG_PER_HOUR
    # thermometers of 0.01 K in windows of 12, rates of 1e-4 K/s: 0.01 deg/h at 0.02 deg/h per K
    assert_allclose(seen, true, atol=0.02 * DEG_PER_HOUR)


def test_the_rate_of_the_drifts_of_grades_is_drawn_as_stated():
    drawn = [GRADES["low"].draw(np.random.default_rng(s)) for s in range(60)]
    bias = [u.unit.gyros.triad.input_bias for u in drawn]
    asymmetry = [u.unit.gyros.shape.asymmetry for u in drawn]
    rtol = 3 / np.sqrt(2 * 180)  # 3 sigma of a deviation from 180
    assert_allclose(np.std(bias), 5 * DEG_PER_HOUR, rtol=rtol)
    assert_allclose(np.std(asymmetry), 50 * PPM, rtol=rtol)


def test_stands_err_as_stated_and_an_ideal_one_does_not():
    rough, rng = STANDS["rough"], np.random.default_rng(7)
    levels = [rough.laboratory(LATITUDE, rng).level_east for _ in range(150)]
    assert_allclose(np.std(levels), 0.1 * DEG, rtol=3 / np.sqrt(2 * 150))
    ideal = STANDS["ideal"]
    assert_allclose(ideal.rate_table(LATITUDE, rng).geometry, 0)
    assert ideal.rough_table(LATITUDE).start_error == 0 and not np.any(ideal.laboratory(LATITUDE, rng).faces)


def test_the_design_function_takes_the_task():
    task, gyro = study.TASKS["reversal"], GyroGrade(angle_random_walk=1e-9, bias=0.1 * DEG_PER_HOUR, scale_factor=0.0)
    at_rest = predicted(gyro, task, rocked=False)
    assert_allclose(at_rest.std, 0.1 * DEG_PER_HOUR / task.level_rate, rtol=1e-3)  # and white noise of 1e-9
    assert predicted(gyro, task, rocked=True, heading_fixed=True).std < 0.05 * at_rest.std


def test_bad_input_is_refused(unit):
    noisy = MeasurementUnit(gyros=Sensors(random=RandomErrors(angle_random_walk=1e-6)))
    with pytest.raises(ValueError, match="detector"):
        Instrument(gyro=unit.gyro, network=unit.network, thermal=unit.thermal, unit=noisy)
    with pytest.raises(ValueError, match="`acceleration`"):
        Conditions(acceleration=(1.0, 2.0))
    with pytest.raises(ValueError, match="`powered`"):
        Conditions(powered=-1.0)
    with pytest.raises(ValueError, match="`angles`"):
        Stand(name="wrong", angles=-1.0)
    with pytest.raises(ValueError, match="`method`"):
        calibrate("magic", unit.at(Conditions()), Stand(name="ideal"), LATITUDE, np.random.default_rng(0))
    with pytest.raises(TypeError, match="`gyro`"):
        Instrument(gyro=None, network=unit.network, thermal=unit.thermal)


@pytest.fixture(scope="module")
def stored():
    return pd.read_csv(ROOT / study.RUNS)


def test_stored_runs_are_those_of_the_study(stored):
    assert set(zip(stored.grade, stored.stand, stored.method, strict=True)) == set(study.cases())
    assert stored.seed.nunique() == study.SEEDS and list(stored.part.unique()) == list(study.ROWS)
    for names in (("high", "rough", "positions"), ("low", "fine", "three-stage")):
        of_case = stored[(stored.grade == names[0]) & (stored.stand == names[1]) & (stored.method == names[2])]
        first = of_case.iloc[0]
        known = Knowledge(bias=first.known_bias * DEG_PER_HOUR, scale_factor=first.known_scale * PPM)
        again = pd.DataFrame(study.unit_rows(*names, 3, known)).set_index("part")
        kept = of_case[of_case.seed == 3].set_index("part")
        for column in ("size", "rest", "rocking", "reversal"):
            # six digits are stored; the filter adds rounding of its own, 1e-7 deg
            assert_allclose(again[column], kept[column], rtol=2e-5, atol=1e-6)
