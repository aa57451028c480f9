"""Bad input of the gyrocompass: each public entry says what was wrong, in numbers."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from fogkit.gyrocompass.accuracy import heading_bound, mean_direction, steady_heading_std
from fogkit.gyrocompass.covariance import Aid, Noise, Prior, run_covariance
from fogkit.gyrocompass.design import heading_accuracy
from fogkit.gyrocompass.design_inputs import GyroGrade, MountLimits
from fogkit.gyrocompass.design_laws import best_law
from fogkit.gyrocompass.design_needs import time_for, walk_for
from fogkit.gyrocompass.dwells import find_dwells
from fogkit.gyrocompass.filters.extended import run_extended
from fogkit.gyrocompass.filters.records import Fixes, Recording, draw_start, record, take_fixes
from fogkit.gyrocompass.filters.smoother import smooth_wander
from fogkit.gyrocompass.filters.wander import run_wander
from fogkit.gyrocompass.gyro_range import check_gyro_range
from fogkit.gyrocompass.laws import ConstantSpeedReversal, DwellAndTurn, Fixed, OneWay, QuasiHarmonic
from fogkit.gyrocompass.mechanisation import CompassState, angle_rates, geographic_rate
from fogkit.gyrocompass.motions import Vessel
from fogkit.gyrocompass.scan import fit_scan
from fogkit.gyrocompass.tables import recording_from_frame, recording_to_frame
from fogkit.units import DEG, DEG_PER_SECOND

LAT, POLE, VERTICAL = 60 * DEG, 90 * DEG, 90 * DEG
VESSEL, NOISE = Vessel(lat=LAT), Noise(angle_random_walk=1e-6)
ROCKING = QuasiHarmonic(amplitude=np.pi, period=20.0)
MOTION, AID = VESSEL.motion(20.0, 0.05, ROCKING), Aid.satellite(LAT)


def rng():
    return np.random.default_rng(1)


RECORDING, FIXES = record(MOTION, NOISE, rng()), take_fixes(MOTION, AID, rng())
START = draw_start(MOTION, Prior(), rng())
TABLE, GYRO = recording_to_frame(RECORDING), GyroGrade(angle_random_walk=1e-6)
SCAN = pd.DataFrame(
    dict.fromkeys(("angle", "gyro_x", "gyro_y", "gyro_z"), np.repeat([0.0, 90 * DEG], 20)),
    index=pd.Index(np.arange(40.0), name="time"),
)


def by_hand(column, value):
    """A motion that was not made by a vessel."""
    return replace(MOTION, states=np.where(np.arange(9) == column, value, MOTION.states))


def filled(value):
    return np.full((15, 15), value)


INDEFINITE = np.eye(15)
INDEFINITE[0, 1] = INDEFINITE[1, 0] = 2.0

ERRORS = {
    # trim near 90 degrees
    "vessel, bow up": (lambda: Vessel(lat=LAT, trim=VERTICAL), r"`trim` must be in .*got 1\.57"),
    "state, bow up": (lambda: CompassState(heading=0.0, lat=LAT, trim=VERTICAL), r"`trim` must be in .*got 1\.57"),
    "rates, bow up": (lambda: angle_rates(np.zeros(3), VERTICAL, 0.0), r"`trim` must be in .*got 1\.57"),
    "covariance, bow up": (lambda: run_covariance(by_hand(1, VERTICAL), NOISE, AID), r"`trim` must be in .*got 1\.57"),
    # a pole, or degrees
    "vessel, pole": (lambda: Vessel(lat=POLE), r"`lat` must be in .*got 1\.57.*keep 0\.001 rad away"),
    "vessel, degrees": (lambda: Vessel(lat=60.0), r"`lat` must be in .*got 60"),
    "state, pole": (lambda: CompassState(heading=0.0, lat=-POLE), r"`lat` must be in .*got -1\.57"),
    "aid, pole": (lambda: Aid.satellite(POLE), r"`lat` must be in .*got 1\.57"),
    "aid, degrees": (lambda: Aid.satellite(60.0), r"`lat` must be in .*got 60"),
    "prior, pole": (lambda: Prior().covariance(POLE), r"`lat` must be in .*got 1\.57"),
    "rate, pole": (lambda: geographic_rate(POLE, np.ones(3)), r"`lat` must be in .*got 1\.57"),
    "bound, pole": (lambda: heading_bound(Fixed(), 9.0, POLE, 1e-6), r"`lat` must be in .*got 1\.57"),
    "covariance, pole": (lambda: run_covariance(by_hand(6, POLE), NOISE, AID), r"`lat` must be in .*got 1\.57"),
    "vessel reaches a pole": (
        lambda: Vessel(lat=POLE - 1.0001e-3, speed=10.0, turning=ROCKING).motion(20.0, 0.05),
        r"`lat` must be in",
    ),
    # unaided
    "aid of nothing": (lambda: Aid(), "unaided filter observes nothing"),
    "fixes of nothing": (
        lambda: Fixes(time=FIXES.time, values=np.full_like(FIXES.values, np.nan), aid=AID),
        "unaided filter observes nothing",
    ),
    "all lost": (lambda: take_fixes(MOTION, AID, rng(), lost=((0.0, 20.0),)), r"got \(\(0\.0, 20\.0\),\): an unaided"),
    "lost backwards": (lambda: take_fixes(MOTION, AID, rng(), lost=((9.0, 3.0),)), r"got \(9, 3\) s"),
    # negative period, law sampled too coarsely
    "harmonic": (lambda: QuasiHarmonic(amplitude=1.0, period=-60.0), r"`period` must be .*> 0 s, got -60"),
    "reversal": (lambda: ConstantSpeedReversal(amplitude=1.0, period=-60.0), r"`period` must be .*got -60"),
    "one way": (lambda: OneWay(period=-60.0), r"got -60.*not in the sign"),
    "dwell": (lambda: DwellAndTurn(dwell=-60.0, turn_duration=1.0), r"`dwell` must be .*got -60"),
    "rolling": (lambda: Vessel(lat=LAT, roll_period=-6.0), r"`roll_period` must be .*got -6"),
    "mount, coarse": (lambda: VESSEL.motion(20.0, 0.2, ROCKING), r"at most 0\.101 s .*got 0\.2 s: 0\.197 rad"),
    "hull, coarse": (
        lambda: replace(VESSEL, turning=ROCKING).motion(20.0, 0.2),
        r"at most 0\.101 s .*got 0\.2 s: 0\.197 rad",
    ),
    "rolling, coarse": (
        lambda: replace(VESSEL, roll_swing=0.1, roll_period=1.0).motion(20.0, 0.2),
        r"`dt` must be at most 0\.1 s .*`roll_period` of 1 s, got 0\.2 s",
    ),
    "mount of a record, coarse": (
        lambda: Recording(dt=1.0, dtheta=np.zeros((1, 3)), dv=np.zeros((1, 3)), mount_angle=[0.0, 4.0]),
        "more than pi in a step, got 4 rad",
    ),
    # gyro range: rocking asks 56.5/sqrt(3) = 32.7 deg/s
    "law beyond the range": (
        lambda: check_gyro_range(ROCKING, 30 * DEG_PER_SECOND),
        r"gyro [xyz] within `gyro_range`, 30 deg/s, got up to 32\.6.*QuasiHarmonic",
    ),
    "record beyond the range": (
        lambda: record(MOTION, NOISE, rng(), gyro_range=30 * DEG_PER_SECOND),
        r"gyro [xyz] within `gyro_range`, 30 deg/s, got 32\.6.* deg/s at .* s",
    ),
    "range of nothing": (lambda: record(MOTION, NOISE, rng(), gyro_range=0.0), "`gyro_range` must be .*> 0 .*got 0"),
    # covariances
    "prior not finite": (lambda: run_covariance(MOTION, NOISE, AID, filled(np.nan)), "`prior` must be finite"),
    "prior not symmetric": (
        lambda: run_covariance(MOTION, NOISE, AID, np.triu(filled(1.0))),
        "`prior` must be symmetric, got 1",
    ),
    "prior indefinite": (
        lambda: run_covariance(MOTION, NOISE, AID, INDEFINITE),
        "`prior` must be positive semi-definite, got an eigenvalue of -1",
    ),
    "prior of the extended filter": (
        lambda: run_extended(RECORDING, FIXES, NOISE, START, INDEFINITE),
        "`prior` must be positive semi-definite, got an eigenvalue of -1",
    ),
    "negative prior": (lambda: Prior(bias=-1.0), "`bias` must be .*got -1"),
    "negative noise": (lambda: Noise(angle_random_walk=-1.0), "`angle_random_walk` must be .*got -1"),
    "negative aid": (lambda: Aid(std={"lat": -1.0}), r"`std\['lat'\]` must be .*got -1"),
    "aid's velocity": (lambda: Aid.satellite(LAT, velocity=0.0), "`velocity` must be .*got 0"),
}

SLIPS = {
    # degrees for radians: an amplitude of 180 rad would be 29 turns
    "amplitude in degrees": (lambda: QuasiHarmonic(amplitude=180.0, period=60.0), ValueError, "`amplitude` .*DEG"),
    "positions in degrees": (
        lambda: DwellAndTurn(positions=(0.0, 180.0), dwell=9.0, turn_duration=1.0),
        ValueError,
        "`positions` .*got 180.*DEG",
    ),
    "travel in degrees": (lambda: MountLimits(travel=360.0), ValueError, "`travel` .*got 360.*DEG"),
    "scan in degrees": (lambda: find_dwells(SCAN.assign(angle=SCAN.angle / DEG)), ValueError, "angle.*got 90.*DEG"),
    # things of another kind
    "class for a law": (lambda: mean_direction(QuasiHarmonic), TypeError, "`law` .*got the class QuasiHarmonic"),
    "number for a gyro": (lambda: walk_for(0.01, 1e-6, MountLimits(), LAT, 300.0), TypeError, "`gyro` .*got float"),
    "number for a gyro, law": (lambda: best_law(1e-6, MountLimits(), LAT, 300.0), TypeError, "`gyro` .*got float"),
    "law for a mount": (lambda: best_law(GYRO, ROCKING, LAT, 300.0), TypeError, "`mount` .*got QuasiHarmonic"),
    "text for a choice": (
        lambda: heading_accuracy(GYRO, ROCKING, LAT, 300.0, heading_fixed="no"),
        TypeError,
        "`heading_fixed` .*got str",
    ),
    "text for a choice of the filter": (
        lambda: run_wander(RECORDING, FIXES, NOISE, START, heading_known="no"),
        TypeError,
        "`heading_known` .*got str",
    ),
    "list for an aid": (lambda: Aid(std=[0.1]), TypeError, "`std` must be a Mapping, got list"),
    "number for a spectrum": (
        lambda: steady_heading_std(ROCKING, 300.0, LAT, 1e-6),
        TypeError,
        "`spectrum` must be a function .*got float",
    ),
    "array for a prior": (lambda: draw_start(MOTION, np.eye(15), rng()), TypeError, "`prior` .*got ndarray"),
    "one gap": (lambda: take_fixes(MOTION, AID, rng(), lost=(10, 20)), ValueError, "`lost` .*got 10"),
    "letters in an aid": (lambda: Fixes(time=[0], values=[["a"] * 6], aid=AID), TypeError, "`values` must hold real"),
    # numbers out of range, also where an option leaves them unused
    "tilt below zero": (
        lambda: heading_accuracy(GYRO, ROCKING, LAT, 300.0, level_std=-0.1),
        ValueError,
        "`level_std` .*got -0.1",
    ),
    "walk below zero, no aid": (
        lambda: heading_accuracy(GYRO, ROCKING, LAT, 300.0, velocity_random_walk=-1.0),
        ValueError,
        "`velocity_random_walk` .*got -1",
    ),
    "longest below a period": (
        lambda: time_for(0.01, GYRO, ROCKING, LAT, longest=10.0),
        ValueError,
        "`longest` must be a period .*20 s, got 10 s",
    ),
    # tables
    "times in a column": (lambda: recording_from_frame(TABLE.reset_index()), ValueError, "as the index.*set_index"),
    "times of a scan in a column": (lambda: find_dwells(SCAN.reset_index()), ValueError, "as the index.*set_index"),
    "letters in a table": (
        lambda: recording_from_frame(TABLE.assign(gyro_x="a")),
        TypeError,
        "'gyro_x'.* real numbers",
    ),
    "a scan of nothing": (
        lambda: fit_scan(np.arange(6.0), np.zeros((6, 3)), LAT),
        ValueError,
        "`readings` must change with `angles`",
    ),
}

FILTERS = {"extended": run_extended, "wander": run_wander, "smoother": smooth_wander}


@pytest.mark.parametrize(("call", "message"), ERRORS.values(), ids=ERRORS.keys())
def test_error(call, message):
    with pytest.raises(ValueError, match=message):
        call()


@pytest.mark.parametrize(("call", "kind", "message"), SLIPS.values(), ids=SLIPS.keys())
def test_slip(call, kind, message):
    with pytest.raises(kind, match=message):
        call()


@pytest.mark.parametrize("run", FILTERS.values(), ids=FILTERS.keys())
def test_filters_without_aid_or_with_one_measurement(run):
    with pytest.raises(TypeError, match="`fixes` must be a Fixes, got NoneType"):
        run(RECORDING, None, NOISE, START)
    alone = replace(FIXES, time=FIXES.time[:1], values=FIXES.values[:1])
    with pytest.warns(UserWarning, match=r"`fixes` has one measurement, at 0 s of 20 s; errors grow freely"):
        run(RECORDING, alone, NOISE, START)
    late = replace(FIXES, time=FIXES.time[7:], values=FIXES.values[7:])
    with pytest.warns(UserWarning, match=r"no measurement for 7 s from 0 s, where one comes every 1 s"):
        run(RECORDING, late, NOISE, START)


def test_covariance_with_one_measurement():
    with pytest.warns(UserWarning, match=r"`aid` measures every 30 s, once in a motion of 20 s: errors grow freely"):
        run_covariance(MOTION, NOISE, Aid.satellite(LAT, interval=30.0))


def test_linear_filters_with_heading_hardly_known():
    poor = Prior(heading=60 * DEG)
    with pytest.warns(UserWarning, match=r"`heading` of 60 deg is beyond 30 deg.*filters.wander"):
        run_covariance(MOTION, NOISE, AID, poor)
    with pytest.warns(UserWarning, match=r"`heading` of 60 deg is beyond 30 deg.*filters.wander"):
        run_extended(RECORDING, FIXES, NOISE, START, poor)
    with pytest.raises(TypeError, match="`prior` must be a Prior, got ndarray"):
        run_wander(RECORDING, FIXES, NOISE, START, np.eye(15))


def test_mount_of_a_record_turning_fast():
    with pytest.warns(UserWarning, match=r"`mount_angle` changes by up to 0\.5 rad in a step of 1 s; beyond 0\.1 rad"):
        Recording(dt=1.0, dtheta=np.zeros((1, 3)), dv=np.zeros((1, 3)), mount_angle=[0.0, 0.5])


def test_what_is_within_the_range_passes():
    assert record(MOTION, NOISE, rng(), gyro_range=33 * DEG_PER_SECOND).duration == MOTION.time[-1]
    assert VESSEL.motion(20.0, 0.1, ROCKING).dt == pytest.approx(0.1)
