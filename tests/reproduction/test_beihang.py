"""The proofs for the slides against slower, independent calculations, and the numbers in the notes of the ledger."""

import re
from math import comb

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from fogkit import claims
from fogkit.calibration.rate_sequence import installation_accuracy
from fogkit.constants import EARTH_RATE, STANDARD_GRAVITY
from fogkit.earth import earth_rate_n
from fogkit.noise import RandomErrors
from fogkit.reproduction.beihang import derivation, effects, formulas, points, rates, redundancy, slides
from fogkit.stand.laboratory import Laboratory
from fogkit.units import ARCMIN, ARCSEC, DEG, DEG_PER_HOUR, DEG_PER_SECOND, HOUR, MINUTE

LAT = slides.ASSUMED_LATITUDE
LEVEL_RATE, UP_RATE = EARTH_RATE * np.cos(LAT), EARTH_RATE * np.sin(LAT)
UP = {"U": 1, "D": -1}
NODES, WEIGHTS = np.polynomial.legendre.leggauss(60)


def earth_in_installation(rate):
    return installation_accuracy(rate, slides.RATE_DURATION, RandomErrors(), Laboratory(latitude=LAT)).earth


@pytest.fixture(scope="module")
def notes():
    return {claim.id.removeprefix("beihang-"): claim.note for claim in claims.load("beihang")}


# 24 points, simulated


def mean_readings(tilt=(0, 0, 0), azimuth=0.0, lean=(0, 0, 0), angle_errors=(0, 0, 0, 0)):
    """Mean specific force and Earth rate in body axes in the six positions, each (6, 3), by rotations.

    The cube leans by the small rotation `lean` against its face; the plate is turned by `azimuth` and tilted by `tilt`.
    """
    plate = Rotation.from_rotvec(tilt) * Rotation.from_euler("z", azimuth)
    quarter = [Rotation.from_euler("z", -k * np.pi / 2 - error) for k, error in enumerate(angle_errors)]
    means = []
    for labels in points.positions().values():
        start = Rotation.from_matrix(np.array(points.attitude(labels[0]), dtype=float))
        bodies = [plate * turn * start * Rotation.from_rotvec(lean) for turn in quarter]
        means.append(
            [
                np.mean([body.inv().apply(v) for body in bodies], axis=0)
                for v in (np.array([0, 0, STANDARD_GRAVITY]), earth_rate_n(LAT))
            ]
        )
    return np.swapaxes(np.array(means), 0, 1)


def fitted(readings, gravity=STANDARD_GRAVITY):
    """Zero term and components of one sensor by least squares from six readings."""
    inputs = np.array(
        [UP[next(letter for letter in labels[0] if letter in UP)] for labels in points.positions().values()]
    )
    design = np.column_stack([np.ones(6), gravity * inputs[:, np.newaxis] * np.repeat(np.eye(3), 2, axis=0)])
    return np.linalg.lstsq(design, readings, rcond=None)[0]


ZERO, COMPONENTS = 0.3, np.array([1.7, -0.02, 0.04])
DRIFT, G_TERMS, COSINES = 2e-7, np.array([3e-8, -1e-8, 2e-8]), np.array([0.9999, 0.01, -0.008])


def accelerometer(force):
    return ZERO + force @ COMPONENTS


def gyro_fit(force, rate):
    nominal = np.repeat(np.eye(3), 2, axis=0) * np.tile([1, -1], 3)[:, np.newaxis]
    return fitted(DRIFT + rate @ COSINES + force @ G_TERMS - UP_RATE * nominal @ COSINES)


@pytest.mark.parametrize("azimuth", [0.0, 1.0, 4.0])
def test_level_plate_gives_all_coefficients_at_any_azimuth(azimuth):
    force, rate = mean_readings(azimuth=azimuth)
    assert_allclose(fitted(accelerometer(force)), [ZERO, *COMPONENTS], rtol=1e-12)
    assert_allclose(gyro_fit(force, rate), [DRIFT, *G_TERMS], rtol=1e-8)  # drift of 1e-7 beside Earth rate of 5e-5


def test_tilt_disturbs_what_the_symbols_say():
    errors = []
    for angle in (20 * ARCMIN, 10 * ARCMIN):
        force, rate = mean_readings(tilt=np.array([-angle, 0, 0]), azimuth=1.0)  # about west: normal leans north
        found = fitted(accelerometer(force))
        zero, *g_terms = gyro_fit(force, rate)
        length = np.linalg.norm(found[1:])
        assert_allclose(found[0], ZERO, rtol=1e-12)
        assert_allclose(found[1:] / length, COMPONENTS / np.linalg.norm(COMPONENTS), atol=1e-14)
        assert_allclose(zero, DRIFT, rtol=1e-8)
        errors.append([1 - length / np.linalg.norm(COMPONENTS), g_terms[0] - G_TERMS[0]])
        expected = LEVEL_RATE * angle * COSINES[0] / STANDARD_GRAVITY
        assert_allclose(errors[-1], [angle**2 / 2, expected], rtol=0.01)  # next order: a hundredth at 20 arcmin
    orders = np.log2(np.array(errors[0]) / errors[1])
    assert_allclose(orders, [2, 1], atol=0.01)


def test_tilts_that_differ_disturb_the_zero_term_of_a_gyro():
    angle = 1 * ARCMIN
    level, tilted = mean_readings(), mean_readings(tilt=np.array([-angle, 0, 0]))
    force, rate = (np.vstack([one[:1], other[1:]]) for one, other in zip(tilted, level, strict=True))  # x up tilted
    error = effects.gyro_zero_error_by_unequal_tilts()
    (delta,) = (s for s in error.free_symbols if s.name == "delta_1")
    values = {"delta_1": angle, "c_x": COSINES[0], "Omega": EARTH_RATE, "varphi": LAT}
    alone = error.subs({s: 0 for s in error.free_symbols if s.name[:5] == "delta" and s != delta})
    alone = alone.subs({s: 0 for s in error.free_symbols if s.name in ("c_y", "c_z")})
    expected = float(alone.subs({s: values[s.name] for s in alone.free_symbols}))
    assert_allclose(gyro_fit(force, rate)[0] - DRIFT, expected, rtol=1e-3)
    assert_allclose(expected, COSINES[0] * LEVEL_RATE * angle / 6, rtol=1e-12)


def test_lean_of_the_cube_turns_the_frame():
    lean = np.array([2.0, -1.0, 3.0]) * ARCMIN
    force, _ = mean_readings(lean=lean)
    zero, *components = fitted(accelerometer(force))
    assert_allclose(zero, ZERO, rtol=1e-12)
    # second order of 3 arcmin is 8e-7
    assert_allclose(components, Rotation.from_rotvec(lean).apply(COMPONENTS), atol=1e-12)
    assert_allclose(np.linalg.norm(components), np.linalg.norm(COMPONENTS), rtol=1e-12)


@pytest.mark.parametrize(("name", "pattern"), [("one", [0, 1, 0, 0]), ("proportional", [0, 1, 2, 3])])
def test_errors_of_the_quarter_turns(name, pattern):
    angle = 1 * ARCMIN
    _, rate = mean_readings(angle_errors=angle * np.array(pattern))
    expected = LEVEL_RATE * angle * float(derivation.horizontal_left_by_angle_errors()[name])
    assert_allclose(np.linalg.norm(rate[0][1:]), expected, rtol=1e-2)


def test_turns_by_quadrature():
    forward, back, azimuth = 40.0, 39.0, 0.6
    omega, force = np.array([2e-5, 5e-5, 4.7e-5]), np.array([0.02, -0.03, 9.8])
    start = np.array(points.attitude("UEN"), dtype=float)

    def pulses(duration, sign):
        moments = duration * (NODES + 1) / 2
        angles = azimuth + sign * 2 * np.pi * moments / duration
        spin = np.array([0, 0, sign * 2 * np.pi / duration])
        body = Rotation.from_euler("z", angles[:, np.newaxis]).as_matrix() @ start
        rates_b = np.einsum("nji,j->ni", body, omega + spin)
        forces_b = np.einsum("nji,j->ni", body, force)
        return duration / 2 * (WEIGHTS @ (DRIFT + rates_b @ COSINES + forces_b @ G_TERMS))

    component = (pulses(forward, 1) - pulses(back, -1)) / (4 * np.pi)
    constant = DRIFT + COSINES[0] * omega[2] + G_TERMS[0] * force[2]
    assert_allclose(component - COSINES[0], constant * (forward - back) / (4 * np.pi), rtol=1e-8)


# rates


def mean_over_arc(rate, start, duration, direction):
    """Mean of the cosine of azimuth while a table turns from the azimuth `start`, by quadrature turn by turn."""
    edges = np.linspace(0, duration, int(np.ceil(rate * duration / (2 * np.pi))) + 1)
    t = edges[:-1, np.newaxis] + np.diff(edges)[:, np.newaxis] * (NODES + 1) / 2
    return (np.cos(start + direction * rate * t) @ WEIGHTS / 2).mean()


@pytest.mark.parametrize("rate", rates.magnitudes()[1:] / DEG_PER_SECOND)
def test_mean_over_the_arc(rate):
    rate, duration = rate * DEG_PER_SECOND, slides.RATE_DURATION
    starts = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    means = [mean_over_arc(rate, start, duration, 1) for start in starts]
    # the largest of 48 azimuths is within 1 - cos(pi/48) of the largest
    assert_allclose(np.max(np.abs(means)), rates.horizontal_left(rate), rtol=3e-3, atol=1e-13)
    both = [m - mean_over_arc(rate, start, duration, -1) for m, start in zip(means, starts, strict=True)]
    angle = LEVEL_RATE * np.max(np.abs(both)) / 2 / rate
    bound = earth_in_installation(rate)
    assert_allclose(angle, bound, rtol=3e-3, atol=1e-16)


@pytest.mark.parametrize("rate", [8, 20, 200])
def test_back_over_the_same_arc_nothing_is_left(rate):
    rate, duration = rate * DEG_PER_SECOND, slides.RATE_DURATION
    end = 0.4 + rate * duration
    there, back = (mean_over_arc(rate, start, duration, sign) for start, sign in ((0.4, 1), (end, -1)))
    assert abs(there) > 1e-4
    assert_allclose(there, back, atol=1e-12)


def test_only_two_rates_close_whole_turns():
    closed = rates.magnitudes()[rates.closes_whole_turns(rates.magnitudes())] / DEG_PER_SECOND
    assert_allclose(closed, [3, 150])
    assert len(slides.RATES) == 29


def test_scale_deviations_by_simulation():
    noise, runs, rng = slides.ASSUMED_ANGLE_RANDOM_WALK, 20_000, np.random.default_rng(7)
    means = slides.RATES + rng.normal(0, noise / np.sqrt(slides.RATE_DURATION), (runs, len(slides.RATES)))
    slopes = np.polyfit(slides.RATES, means.T, 1)[0]
    tolerance = 4 / np.sqrt(2 * runs)  # 4 sigma of a standard deviation
    assert_allclose(slopes.std(), rates.scale_deviation_of_list(noise), rtol=tolerance)
    duration = slides.TURN / slides.RATE_RANGE
    pulses = slides.TURN + rng.normal(0, noise * np.sqrt(duration), (runs, 2))
    found = pulses.sum(axis=1) / (2 * slides.TURN)
    assert_allclose(found.std(), rates.scale_deviation_of_turns(noise, slides.RATE_RANGE), rtol=tolerance)


# redundancy


@pytest.mark.parametrize("name", ["orthogonal", "skew", "cone", "dodecahedron"])
def test_redundant_variances_and_lives(name):
    axes = np.array(redundancy.configurations()[name], dtype=float)
    assert_allclose(np.linalg.norm(axes, axis=1), 1)
    assert_allclose((np.linalg.pinv(axes) ** 2).sum(axis=1), [float(v) for v in redundancy.variances(name)], rtol=1e-12)
    count = len(axes)
    t = np.linspace(0, 60, 600_001)
    alive = np.exp(-t)
    survival = sum(comb(count, k) * alive**k * (1 - alive) ** (count - k) for k in range(3, count + 1))
    assert_allclose(np.trapezoid(survival, t), float(redundancy.mean_life(name)), rtol=1e-6)


def test_evenly_spread_axes_reach_the_least_variance():
    # n unit axes give the information n in all; spread evenly, n/3 on each axis, it leaves 9/n, and never less
    for name, axes in redundancy.configurations().items():
        total = sum(float(variance) for variance in redundancy.variances(name))
        least = 9 / axes.rows
        assert total > least + 0.1 if name == "skew" else np.isclose(total, least)


def test_a_plane_does_not_survive():
    assert not redundancy.survives("orthogonal", 1)


# proofs that can fail


def test_left_handed_and_counter_clockwise_attitudes_are_told():
    assert not points.is_right_handed("UWN")
    labels = points.positions()["1"]
    assert not points.quarter_turns(labels[::-1])
    assert not points.quarter_turns((labels[0], labels[2], labels[1], labels[3]))


def test_faces_that_differ_disturb_the_zero_term():
    assert effects.opposite_faces_disturb_zero_term() != 0
    assert effects.common_face_error_turns_the_frame()
    assert effects.unequal_tilts_are_of_second_order()


def test_one_cooling_curve_cannot_separate_temperature_and_rate():
    assert effects.one_cooling_rate_is_collinear()
    # two time constants can: the columns of two exponentials are independent
    t = np.linspace(0, 5, 50)
    temperature = np.exp(-t) + 0.3 * np.exp(-4 * t)
    rate = -np.exp(-t) - 1.2 * np.exp(-4 * t)
    assert np.linalg.matrix_rank(np.column_stack([np.ones_like(t), temperature, rate]), tol=1e-6) == 3


def test_formulas_have_the_degrees_that_the_words_name():
    models = formulas.formulas()
    assert models["accelerometer-bias"].degree("T") == 3
    assert models["scale-factor"].degree("T") == 1
    assert not models["gyro-axis"].is_linear  # equivalent times cosine


# numbers in the notes


def test_turns_in_the_notes(notes):
    for magnitude in rates.magnitudes()[1:]:
        note = notes[f"rate-{magnitude / DEG_PER_SECOND:.3g}"]
        stated = float(re.search(r"([\d.]+) turns? in 2 min", note)[1])
        assert_allclose(rates.turns(magnitude), stated, rtol=5e-3)
        assert ("whole" in note) == bool(rates.closes_whole_turns(magnitude))
        if found := re.search(r"up to ([\d.e+]+) %", note):
            assert_allclose(100 * rates.horizontal_left(magnitude), float(found[1]), rtol=0.05)


@pytest.mark.parametrize(
    ("row", "text", "value"),
    [
        ("gyro-zero-negligible", "3.9e-8", 0.1 * DEG_PER_HOUR / (4 * np.pi)),
        ("gyro-zero-negligible", "3.7e-6", UP_RATE / (4 * np.pi)),
        ("adv-azimuth", "8e-4 deg/h", LEVEL_RATE * ARCMIN / 4 / DEG_PER_HOUR),
        ("adv-level-rate", "0.0034 deg/h", LEVEL_RATE * ARCMIN / DEG_PER_HOUR),
        ("adv-level-rate-zero", "0.0034 deg/h", LEVEL_RATE * ARCMIN / DEG_PER_HOUR),
        ("adv-level-gravity", "4.2e-8", ARCMIN**2 / 2),
        ("east-mean", "0.0034", LEVEL_RATE * ARCMIN / DEG_PER_HOUR),
        ("east-mean", "0.0028 deg/h", UP_RATE * ARCMIN / DEG_PER_HOUR),
        ("ref-position", "0.0044 deg/h", EARTH_RATE * ARCMIN / DEG_PER_HOUR),
        ("rate-within", "0.0027 deg/s", UP_RATE / DEG_PER_SECOND),
        (
            "rate-installation",
            "0.012 arcsec",
            earth_in_installation(slides.RATE_RANGE) / ARCSEC,
        ),
        (
            "rate-installation",
            "0.19",
            earth_in_installation(50 * DEG_PER_SECOND) / ARCSEC,
        ),
        ("rate-installation", "50 times", slides.INSTALLATION_RATE / (3 * DEG_PER_SECOND)),
        ("rate-scale", "76 %", 100 * rates.share_of_largest(2)),
        ("redundant-life", "1.75", float(redundancy.mean_life("skew") / redundancy.mean_life("orthogonal"))),
        ("redundant-life", "2.85", float(redundancy.mean_life("dodecahedron") / redundancy.mean_life("orthogonal"))),
        ("redundant-accuracy", "29 %", 100 * (1 - np.sqrt(0.5))),
        (
            "weak-scale",
            "12 times",
            rates.scale_deviation_of_turns(1, slides.RATE_RANGE) / rates.scale_deviation_of_list(1),
        ),
        (
            "weak-scale",
            "52 times",
            rates.scale_deviation_of_turns(1, 10 * DEG_PER_SECOND) / rates.scale_deviation_of_list(1),
        ),
        ("rate-duration", "174 min", 3 * len(slides.RATES) * slides.RATE_DURATION / MINUTE),
    ],
)
def test_numbers_in_the_notes(notes, row, text, value):
    assert text in notes[row]
    stated = text.split()[0]
    digits = len(re.sub(r"e.*|^0*\.?0*|\.", "", stated))
    assert f"{value:.{digits - 1}e}" == f"{float(stated):.{digits - 1}e}"


def test_duration_of_the_method_that_follows(notes):
    parts = 6 * slides.ACCELEROMETER_DURATION, slides.BIAS_POSITIONS * slides.BIAS_DURATION
    total = sum(parts) + 3 * len(slides.RATES) * slides.RATE_DURATION
    assert total == 3.6 * HOUR
    assert f"{total / MINUTE:.0f} min" in notes["weak-long"]
    assert f"{total / MINUTE / len(points.attitudes()):.0f} min each" in notes["weak-long"]


def test_latitude_of_the_notes(notes):
    assert LAT == 40 * DEG
    assert "40 deg" in notes["adv-level-rate"]


def test_g_term_error_is_that_of_the_simulation():
    import sympy as sp

    g, w, lat, tilt, azimuth = derivation.tilt_symbols()
    (cosine,) = (s for s in derivation.gyro_g_term_error().free_symbols if s.name == "c_x")
    assert sp.simplify(derivation.gyro_g_term_error() - cosine * w * sp.cos(lat) * sp.cos(azimuth) * tilt / g) == 0
