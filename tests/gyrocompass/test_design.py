"""Design of a gyrocompass: against bounds, brute-force least squares, three gyros, stored runs of the filter."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass import accuracy, design, design_needs, frames, mechanisation
from fogkit.gyrocompass.covariance import Aid
from fogkit.gyrocompass.design_inputs import GyroGrade, MountLimits
from fogkit.gyrocompass.design_laws import best_law, laws_within
from fogkit.gyrocompass.design_noise import level_estimate
from fogkit.gyrocompass.encoder import Encoder
from fogkit.gyrocompass.laws import ConstantSpeedReversal, DwellAndTurn, Fixed, OneWay, QuasiHarmonic
from fogkit.noise import mean_covariance
from fogkit.units import DEG, DEG_PER_HOUR, DEG_PER_HOUR_PER_SQRT_HOUR, DEG_PER_SQRT_HOUR, PPM

LAT, TIME = 60 * DEG, 300.0
WHITE = GyroGrade(angle_random_walk=0.0125 * DEG_PER_SQRT_HOUR)
COLOURED = replace(
    WHITE,
    bias=5 * DEG_PER_HOUR,
    bias_instability=0.3 * DEG_PER_HOUR,
    rate_random_walk=2 * DEG_PER_HOUR_PER_SQRT_HOUR,
)
LAWS = {
    "thesis": QuasiHarmonic(amplitude=np.pi, period=60.0),
    "no whole periods": QuasiHarmonic(amplitude=1.1, period=170.0, centre=0.5, phase=0.3),
    "reversal": ConstantSpeedReversal(amplitude=2.0, period=50.0, reversal_time=5.0),
    "two positions": DwellAndTurn(dwell=20.0, turn_duration=10.0),
}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("fixed", [True, False])
@pytest.mark.parametrize("bias", [np.inf, 5 * DEG_PER_HOUR])
def test_white_noise_against_the_bound(law, fixed, bias):
    gyro = replace(WHITE, bias=bias, scale_factor=0.0)
    bound = accuracy.heading_bound(
        law, TIME, LAT, gyro.angle_random_walk, bias_std=bias, drift_std=0 if fixed else bias
    )
    found = level_estimate(law, TIME, LAT, gyro, fixed)
    # midpoints: 0.02 rad, 2e-5, and 4096 points on a line for a heading that drifts
    assert_allclose(found.std, bound.std, rtol=3e-5)
    assert_allclose(found.mean_direction, bound.mean_direction, atol=2e-5)


def test_mount_off():
    assert level_estimate(Fixed(), TIME, LAT, WHITE, True).std == np.inf
    known = level_estimate(Fixed(), TIME, LAT, replace(WHITE, bias=0.1 * DEG_PER_HOUR), True)
    level = EARTH_RATE * np.cos(LAT)
    assert_allclose(np.sqrt(known.variances["bias"]), 0.1 * DEG_PER_HOUR / level, rtol=1e-9)
    assert_allclose(np.sqrt(known.variances["white noise"]), WHITE.angle_random_walk / level / np.sqrt(TIME), rtol=1e-9)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_coloured_noise_against_brute_force(law):
    # real least squares of 2 x 960 block means with the covariance of `fogkit.noise`, scale factors free
    count, sub = 960, 32
    dt = TIME / count
    edges = dt * np.arange(count + 1)
    P = mean_covariance(COLOURED.random, edges[:-1], edges[1:], TIME / 240)
    t = TIME * (np.arange(count * sub).reshape(count, sub) + 0.5) / (count * sub)
    angle, rate, _ = law.motion(t)
    level = EARTH_RATE * np.cos(LAT)
    h, w = (level * 1j * np.exp(1j * angle)).mean(axis=1), rate.mean(axis=1)
    one = np.ones(count)
    A = np.array([np.concatenate([c.real, c.imag]) for c in (h, one + 0j, 1j * one, w + 0j, 1j * w)])
    root = np.linalg.cholesky(P)
    white = np.hstack([np.linalg.solve(root, half.T).T for half in (A[:, :count], A[:, count:])])
    prior = np.array([np.inf, *[COLOURED.bias] * 2, *[COLOURED.scale_factor / np.sqrt(3)] * 2])
    truth = np.sqrt(np.linalg.inv(white @ white.T + np.diag(prior**-2.0))[0, 0])
    # 240 blocks of the function: 0.35 per cent here, a quarter of it with 480
    assert_allclose(level_estimate(law, TIME, LAT, COLOURED, True).std, truth, rtol=5e-3)


def test_coloured_noise_against_line_spectrum():
    law = QuasiHarmonic(amplitude=2.0, period=30.0)
    gyro = replace(COLOURED, bias=np.inf, scale_factor=0.0)
    spectrum = gyro.random.power_spectral_density
    many = accuracy.steady_heading_std(law, 40 * law.period, LAT, spectrum)
    # 0.4 per cent by the blocks; the ends of 40 periods
    assert_allclose(level_estimate(law, 40 * law.period, LAT, gyro, True).std, many, rtol=0.01)


@pytest.mark.parametrize("law", [LAWS["thesis"], LAWS["reversal"], LAWS["no whole periods"]])
def test_asymmetry_against_least_squares_of_three_gyros(law):
    steps, a = 3000, 20 * PPM
    dt = TIME / steps
    t = dt * (np.arange(steps) + 0.5)

    def readings(x):
        C_h_g = frames.hull_attitude(x[0], 0.0, 0.0)
        hull = C_h_g.T @ mechanisation.geographic_rate(LAT, np.zeros(3))
        return mechanisation.gyro_rates(hull, law.angle(t), law.rate(t)) * (1 + x[4:]) + x[1:4]

    x0 = np.array([0.7, *[0.0] * 6])
    step = np.array([1e-4, *[1e-6] * 3, *[1e-4] * 3])
    A = np.array(
        [((readings(x0 + e) - readings(x0 - e)) / (2 * h)).ravel() for h, e in zip(step, np.diag(step), strict=True)]
    ).T
    true = readings(x0)
    errors = [np.linalg.lstsq(A, (0.5 * a * np.abs(true) * k).ravel(), rcond=None)[0][0] for k in np.eye(3)]
    gyro = replace(WHITE, scale_asymmetry=a, scale_factor=100.0)  # nothing known of scale factors
    found = np.sqrt(level_estimate(law, TIME, LAT, gyro, True).variances["asymmetry"])
    # the Earth's own part of the magnitude of the rates, 1e-3 of them, and sums over 3000 steps
    assert_allclose(found, np.linalg.norm(errors), rtol=0.01)


def test_asymmetry_in_closed_form():
    # over whole periods to and fro: mean of |rate| exp(i angle) is 4 sin(A)/T, that of |rate| 4 A/T
    for amplitude in (2.404825557695773, np.pi, np.pi / 2):
        law = QuasiHarmonic(amplitude=amplitude, period=60.0)
        m = accuracy.mean_direction(law).real
        a = 10 * PPM
        moved = 4 / 60.0 * abs(np.sin(amplitude) - amplitude * m) / (1 - m**2)
        truth = a / 2 / np.sqrt(3) * moved / (EARTH_RATE * np.cos(LAT))
        gyro = replace(WHITE, scale_asymmetry=a, scale_factor=0.0)
        assert_allclose(np.sqrt(level_estimate(law, TIME, LAT, gyro, True).variances["asymmetry"]), truth, rtol=1e-3)
    constant = ConstantSpeedReversal(amplitude=2.0, period=60.0)  # its magnitude is a bias
    assert level_estimate(constant, TIME, LAT, gyro, True).variances["asymmetry"] < 1e-20


@pytest.mark.parametrize("seed", range(6))
def test_laws_keep_the_limits(seed):
    rng = np.random.default_rng(seed)
    mount = MountLimits(travel=rng.uniform(0.5, 8), max_rate=rng.uniform(0.1, 1), max_acceleration=rng.uniform(0.1, 2))
    t = np.linspace(0, TIME, 30001)
    kinds = set()
    for law in laws_within(mount, mount.max_rate, TIME):
        angle, rate, acceleration = law.motion(t)
        kinds.add(type(law))
        assert np.ptp(angle) <= mount.travel * (1 + 1e-9)
        assert np.abs(rate).max() <= mount.max_rate * (1 + 1e-6)
        assert np.abs(acceleration).max() <= mount.max_acceleration * (1 + 1e-6)
        assert_allclose(TIME / law.period, round(TIME / law.period), rtol=1e-9)
    assert OneWay not in kinds and kinds


def test_best_law():
    mount = MountLimits(max_rate=30 * DEG)
    law = best_law(COLOURED, mount, LAT, TIME, heading_fixed=True)
    best = level_estimate(law, TIME, LAT, COLOURED, True)
    assert abs(best.mean_direction) < 1e-3
    rng = np.random.default_rng(3)
    for _ in range(20):  # no law of the mount that is drawn is better by more than the stated hundredth
        amplitude, speed = rng.uniform(0.5, np.pi), rng.uniform(0.1, 30 * DEG)
        other = QuasiHarmonic.from_rate(amplitude, speed)
        if other.period < TIME:
            assert level_estimate(other, TIME, LAT, COLOURED, True).std > best.std / 1.011
    narrow = best_law(WHITE, MountLimits(travel=100 * DEG), LAT, TIME, heading_fixed=True)
    assert isinstance(narrow, DwellAndTurn)
    # no mean direction in an arc is nearer zero than the middle of its ends
    assert abs(accuracy.mean_direction(narrow)) > np.cos(50 * DEG)
    assert isinstance(best_law(WHITE, MountLimits(travel=np.inf), LAT, TIME, heading_fixed=True), OneWay)


def test_budget_adds_up_and_names_the_largest():
    law = LAWS["thesis"]
    encoder = Encoder(offset=1e-3)
    found = design.heading_accuracy(WHITE, law, LAT, TIME, level_std=1e-3, encoder=encoder, heading_fixed=True)
    assert_allclose(found.budget["level"], np.tan(LAT) * 1e-3, rtol=1e-12)
    assert_allclose(found.budget["encoder"], 1e-3, rtol=1e-6)
    assert_allclose(found.std**2, sum(v**2 for v in found.budget.values()), rtol=1e-12)
    assert found.largest == "white noise"
    assert_allclose(found.to_frame().share.iloc[:-1].sum(), 1, rtol=1e-12)


def test_poor_aid_is_named():
    aid, gyro = Aid.satellite(LAT, velocity=0.1), replace(WHITE, bias=20 * DEG_PER_HOUR)
    with pytest.warns(UserWarning, match=r"the aid makes 6\.\d+ deg, all the rest 0\.588 deg.*than 0\.3,"):
        found = design.heading_accuracy(gyro, LAWS["thesis"], LAT, TIME, aid=aid)
    assert found.largest == "aid"
    # with an aid so good that level is known it goes, but for what the start's tilts take
    fine = Aid.satellite(LAT, velocity=1e-5, position=0.1)
    assert design.aid_share(gyro, LAWS["thesis"], LAT, TIME, fine) < 0.15 * found.std
    # zero mean direction makes up for most of a poor aid
    rocking = QuasiHarmonic(amplitude=accuracy.best_harmonic_amplitude(), period=60.0)
    with pytest.warns(UserWarning, match="the aid makes"):
        assert design.heading_accuracy(gyro, rocking, LAT, TIME, aid=aid).std < 0.15 * found.std


def test_inverses():
    law = LAWS["thesis"]
    options = {"level_std": 0.05 * DEG, "heading_fixed": True}
    walk = design_needs.walk_for(0.5 * DEG, COLOURED, law, LAT, TIME, **options)
    again = design.heading_accuracy(replace(COLOURED, angle_random_walk=walk), law, LAT, TIME, **options)
    assert_allclose(again.std, 0.5 * DEG, rtol=2e-3)  # the tolerance of the search
    # the same with nothing but white noise, where all of it may be spent
    swing = ConstantSpeedReversal(amplitude=np.pi, period=60.0)
    alone = design_needs.walk_for(0.5 * DEG, WHITE, swing, LAT, TIME, heading_fixed=True)
    assert_allclose(alone, 0.5 * DEG * EARTH_RATE * np.cos(LAT) * np.sqrt(TIME), rtol=2e-3)
    # white noise alone falls with the root of time: whole periods above that of the equation
    time = design_needs.time_for(0.5 * DEG, WHITE, law, LAT, heading_fixed=True)
    bound = accuracy.heading_bound(law, TIME, LAT, WHITE.angle_random_walk).std
    assert time == 60.0 * np.ceil(TIME / 60.0 * (bound / (0.5 * DEG)) ** 2)
    free = design_needs.time_for(0.5 * DEG, WHITE, MountLimits(), LAT, heading_fixed=True)
    ideal = (WHITE.angle_random_walk / (EARTH_RATE * np.cos(LAT) * 0.5 * DEG)) ** 2
    assert ideal * (1 - 1e-9) <= free < ideal * 1.02


def test_bad_input():
    law = LAWS["thesis"]
    with pytest.raises(ValueError, match="`angle_random_walk` must be finite and > 0"):
        GyroGrade(angle_random_walk=0.0)
    with pytest.raises(ValueError, match="`travel` must be"):
        MountLimits(travel=-1.0)
    with pytest.raises(ValueError, match="Most of it is the part 'level'"):
        design_needs.walk_for(0.1 * DEG, WHITE, law, LAT, TIME, level_std=0.1 * DEG, heading_fixed=True)
    with pytest.raises(ValueError, match="`accuracy` must be within what is reached in 600 s"):
        design_needs.time_for(0.01 * DEG, WHITE, law, LAT, longest=600.0, heading_fixed=True)
    with pytest.raises(ValueError, match="`heading_fixed` must be False with an aid"):
        design.heading_accuracy(WHITE, law, LAT, TIME, aid=Aid.satellite(LAT), heading_fixed=True)
    with pytest.raises(ValueError, match=r"`gyro.bias` must be finite with an aid"):
        design.heading_accuracy(WHITE, law, LAT, TIME, aid=Aid.satellite(LAT))
    with pytest.raises(ValueError, match="`duration` must be long enough for one period"):
        best_law(WHITE, MountLimits(), LAT, 0.5)
    with pytest.raises(ValueError, match="leaves -"):
        MountLimits().rate_with(replace(WHITE, largest_rate=1 * DEG), (5 * DEG, 0, 0))
    with pytest.raises(ValueError, match="at most 100 periods"):
        level_estimate(QuasiHarmonic(amplitude=1.0, period=1.0), TIME, LAT, COLOURED)


@pytest.mark.parametrize(
    ("gyro", "law", "lat", "message"),
    [
        (WHITE, QuasiHarmonic(amplitude=np.pi, period=900.0), LAT, "`duration` of 300 s is 0.33 of a period"),
        (WHITE, LAWS["thesis"], 85 * DEG, "`lat` of 85 deg makes heading 11.5 times"),
        (replace(WHITE, largest_rate=5 * DEG), LAWS["thesis"], LAT, r"up to 10\.88 deg/s, beyond its range of 5 deg/s"),
        (replace(WHITE, angle_random_walk=1 * DEG_PER_SQRT_HOUR), LAWS["thesis"], LAT, "heading is known to 27"),
    ],
)
def test_doubtful_designs_warn(gyro, law, lat, message):
    with pytest.warns(UserWarning, match=message):
        design.heading_accuracy(gyro, law, lat, TIME, heading_fixed=True)
