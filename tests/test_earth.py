"""The Earth against published WGS 84 values, quadrature, the normal potential and numerical differentiation."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import quad

from fogkit import earth
from fogkit.constants import (
    EARTH_RATE,
    ECCENTRICITY_SQUARED,
    EQUATORIAL_GRAVITY,
    FLATTENING,
    POLAR_GRAVITY,
    SEMI_MAJOR_AXIS,
    SEMI_MINOR_AXIS,
)
from fogkit.rotation import skew

EPS = np.finfo(float).eps
POLE = np.pi / 2

latitudes = st.floats(-POLE, POLE)
longitudes = st.floats(-np.pi, np.pi)
# The first call of a run pays for imports.
unhurried = settings(deadline=None)


def area_element(lat):
    """Area of the ellipsoid per unit of latitude, all longitudes together."""
    return 2 * np.pi * earth.radius_meridian(lat) * earth.radius_transverse(lat) * np.cos(lat)


def test_radii_at_the_equator_and_the_poles():
    # NIMA TR8350.2 (2000), table 3.3, prints the polar radius of curvature; the equatorial ones are b^2/a and a.
    assert_allclose(earth.radius_meridian([-POLE, POLE]), 6399593.6258, rtol=0, atol=0.5e-4)
    assert_allclose(earth.radius_transverse([-POLE, POLE]), 6399593.6258, rtol=0, atol=0.5e-4)
    assert_allclose(earth.radius_meridian(0.0), SEMI_MINOR_AXIS**2 / SEMI_MAJOR_AXIS, rtol=4 * EPS)
    assert_allclose(earth.radius_transverse(0.0), SEMI_MAJOR_AXIS, rtol=EPS)


def test_quarter_meridian():
    # 10 001 965.7293 m, published for WGS 84 as for GRS 80 (Moritz 2000); half a unit of the last digit.
    assert_allclose(quad(earth.radius_meridian, 0, POLE, epsrel=1e-13)[0], 10_001_965.7293, rtol=0, atol=0.5e-4)


def test_radius_of_the_sphere_of_equal_area():
    # TR8350.2, table 3.3: R2 = 6 371 007.1809 m.
    area = 2 * quad(area_element, 0, POLE, epsrel=1e-13)[0]
    assert_allclose(np.sqrt(area / (4 * np.pi)), 6_371_007.1809, rtol=0, atol=0.5e-4)


def test_mean_normal_gravity():
    # TR8350.2, table 3.4: mean over the ellipsoid 9.7976432222 m/s^2. One unit of the last digit, which the print cuts.
    total = quad(lambda lat: area_element(lat) * earth.normal_gravity(lat), 0, POLE, epsrel=1e-13)[0]
    area = quad(area_element, 0, POLE, epsrel=1e-13)[0]
    assert_allclose(total / area, 9.7976432222, rtol=0, atol=1e-10)


def test_normal_gravity_at_the_equator_and_the_poles():
    assert_allclose(earth.normal_gravity(0.0), EQUATORIAL_GRAVITY, rtol=EPS)
    # Somigliana's constant is printed with 12 digits: 1e-14 in gravity would need all 16.
    assert_allclose(earth.normal_gravity([-POLE, POLE]), POLAR_GRAVITY, rtol=1e-11)


def gravity_from_potential(lat, alt):
    """Length of the gradient of the normal potential, Heiskanen and Moritz (1967), eq. (2-62), with 40 digits."""
    with mp.workdps(40):
        a, f = mp.mpf(6378137), 1 / mp.mpf("298.257223563")
        GM, rate = mp.mpf("3986004.418e8"), mp.mpf("7292115e-11")
        b = a * (1 - f)
        E = mp.sqrt(a**2 - b**2)

        def q(u):
            return ((1 + 3 * (u / E) ** 2) * mp.atan(E / u) - 3 * u / E) / 2

        def potential(p, z):
            r2 = p**2 + z**2 - E**2
            u = mp.sqrt((r2 + mp.sqrt(r2**2 + 4 * (E * z) ** 2)) / 2)  # semi-minor axis of the confocal ellipsoid
            ellipsoidal = (rate * a) ** 2 / 2 * q(u) / q(b) * ((z / u) ** 2 - mp.mpf(1) / 3)
            return GM / E * mp.atan(E / u) + ellipsoidal + (rate * p) ** 2 / 2

        lat, e2 = mp.mpf(lat), f * (2 - f)
        N = a / mp.sqrt(1 - e2 * mp.sin(lat) ** 2)
        place = ((N + alt) * mp.cos(lat), (N * (1 - e2) + alt) * mp.sin(lat))
        return float(mp.hypot(mp.diff(potential, place, (1, 0)), mp.diff(potential, place, (0, 1))))


@pytest.mark.parametrize("lat", [-1.1, 0.0, 0.3, np.pi / 4, 1.2, 1.5])
@pytest.mark.parametrize("alt", [0.0, -400.0, 1e3, 1e4, 1e5])
def test_normal_gravity_is_the_gradient_of_the_normal_potential(lat, alt):
    # 1e-11: the equatorial and polar values are printed with 11 digits. The rest is what the series leaves out, with
    # the factors at the equator, where they are largest.
    h = abs(alt) / SEMI_MAJOR_AXIS
    rtol = 1e-11 + 6.3 * FLATTENING**2 * h + 6.5 * FLATTENING * h**2 + 4.2 * h**3
    assert_allclose(earth.normal_gravity(lat, alt), gravity_from_potential(lat, alt), rtol=rtol)


def test_series_of_gravity_is_as_good_as_its_docstring_says():
    lat = np.linspace(0, POLE - 0.01, 12)
    for alt, claim in [(1e3, 1.1e-8), (1e4, 7.2e-8), (1e5, 1.7e-5)]:
        truth = np.array([gravity_from_potential(each, alt) for each in lat])
        error = np.abs(earth.normal_gravity(lat, alt) / truth - 1).max()
        assert 0.9 * claim < error < claim  # the claim is the error rounded up to two digits


def test_gravity_vector_points_down():
    lat, alt = np.array([[0.2], [-0.8]]), np.array([0.0, 100.0, 5000.0])
    g_b_n = earth.gravity_n(lat, alt)
    assert g_b_n.shape == (2, 3, 3)
    np.testing.assert_array_equal(g_b_n[..., :2], 0)
    np.testing.assert_array_equal(g_b_n[..., 2], -earth.normal_gravity(lat, alt))


@given(latitudes, longitudes)
@unhurried
def test_earth_rate_is_along_the_polar_axis(lat, lon):
    omega_ie_n = earth.earth_rate_n(lat)
    assert_allclose(np.linalg.norm(omega_ie_n), EARTH_RATE, rtol=4 * EPS)
    assert_allclose(omega_ie_n, earth.dcm_e_n(lat, lon) @ [0, 0, EARTH_RATE], rtol=0, atol=EPS * EARTH_RATE)


def test_earth_rate_in_places_one_can_picture():
    # North on the equator, up at the north pole, down at the south pole; cos(pi/2) rounds to 6e-17.
    expected = EARTH_RATE * np.array([[0, 1, 0], [0, 0, 1], [0, 0, -1]])
    assert_allclose(earth.earth_rate_n([0, POLE, -POLE]), expected, rtol=0, atol=EPS * EARTH_RATE)


@pytest.mark.parametrize("lat", [-1.4, -0.5, 0.0, 0.9, 1.4])
@pytest.mark.parametrize("v_eb_n", [(250.0, 0.0, 0.0), (0.0, 250.0, 0.0), (0.0, 0.0, 9.0), (-170.0, 120.0, -30.0)])
def test_transport_rate_is_the_turning_of_the_local_frame(lat, v_eb_n):
    # Fly straight for dt either way, look up the local frame there, and differentiate C_n_e: its rate is C_n_e @ Omega.
    alt, lon, dt = 8000.0, 0.7, 0.1
    r_eb_e = earth.ecef_from_geodetic(lat, lon, alt)
    v_eb_e = earth.dcm_e_n(lat, lon).T @ v_eb_n

    def C_n_e(t):
        return earth.dcm_e_n(*earth.geodetic_from_ecef(r_eb_e + t * v_eb_e)[:2]).T

    Omega_en_n = earth.dcm_e_n(lat, lon) @ (C_n_e(dt) - C_n_e(-dt)) / (2 * dt)
    # Moves of 25 m: theta = 4e-6 rad per step. Truncation (theta * tan(lat))**2 < 1e-9, rounding EPS / theta < 1e-10,
    # both relative to the largest component, 250 * tan(lat) / 6.4e6.
    scale = 250 * (1 + abs(np.tan(lat))) / SEMI_MAJOR_AXIS
    assert_allclose(skew(earth.transport_rate_n(lat, alt, v_eb_n)), Omega_en_n, rtol=0, atol=1e-9 * scale)


def test_transport_rate_of_a_northward_flight_is_westward():
    omega_en_n = earth.transport_rate_n(np.zeros(4), np.zeros((2, 1)), [0.0, 100.0, 0.0])
    assert omega_en_n.shape == (2, 4, 3)
    assert (omega_en_n[..., 0] < 0).all()
    np.testing.assert_array_equal(omega_en_n[..., 1:], 0)


def degrees(d, m, s):
    return np.deg2rad(d + m / 60 + s / 3600)


def test_published_point():
    # EPSG Guidance Note 7-2, section on geographic/geocentric conversions: printed to 1 mm, from angles to 0.001 arcsec
    # (31 mm on the ground, so half of that), and back to those angles.
    lat, lon, r_eb_e = degrees(53, 48, 33.820), degrees(2, 7, 46.380), [3771793.968, 140253.342, 5124304.349]
    assert_allclose(earth.ecef_from_geodetic(lat, lon, 73.0), r_eb_e, rtol=0, atol=0.016)
    assert_allclose(earth.geodetic_from_ecef(r_eb_e)[:2], [lat, lon], rtol=0, atol=degrees(0, 0, 0.0005))
    assert_allclose(earth.geodetic_from_ecef(r_eb_e)[2], 73.0, rtol=0, atol=0.001)


def test_published_topocentric_coordinates():
    # EPSG Guidance Note 7-2, geocentric/topocentric conversions: east, north, up of that point from 55 N, 5 E, 200 m.
    lat, lon = np.deg2rad([55.0, 5.0])
    origin = earth.ecef_from_geodetic(lat, lon, 200.0)
    assert_allclose(origin, [3652755.3058, 319574.6799, 5201547.3536], rtol=0, atol=0.5e-4)
    r_n = earth.dcm_e_n(lat, lon) @ (np.array([3771793.968, 140253.342, 5124304.349]) - origin)
    assert_allclose(r_n, [-189013.869, -128642.040, -4220.171], rtol=0, atol=0.001)  # both points printed to 1 mm


@given(latitudes, longitudes, st.floats(-6.2e6, 1e9))
@unhurried
def test_position_comes_back(lat, lon, alt):
    r_eb_e = earth.ecef_from_geodetic(lat, lon, alt)
    distance = np.linalg.norm(r_eb_e)
    back_lat, back_lon, back_alt = earth.geodetic_from_ecef(r_eb_e)
    # Rounding of positions of the size of the Earth; seen from near the centre it is a larger angle, and near the axis
    # of the Earth a larger longitude, so longitude is compared as a distance.
    length = 8 * EPS * max(distance, SEMI_MAJOR_AXIS)
    assert_allclose(back_alt, alt, rtol=0, atol=length)
    assert_allclose(back_lat, lat, rtol=0, atol=length / distance)
    assert_allclose(2 * np.sin((back_lon - lon) / 2) * np.hypot(*r_eb_e[:2]), 0, atol=length)


@pytest.mark.parametrize("alt", [-6.25e6, -6.2e6, -5e6, -1e4, 0.0, 1e6, 1e12])
def test_position_comes_back_from_pole_to_pole(alt):
    # Down to 107 km from the centre, where each iteration still gains and the last one is needed.
    lat = np.linspace(-POLE, POLE, 37)
    back_lat, back_lon, back_alt = earth.geodetic_from_ecef(earth.ecef_from_geodetic(lat, 0.0, alt))
    length = 8 * EPS * max(alt, SEMI_MAJOR_AXIS)
    assert_allclose(back_alt, alt, rtol=0, atol=length)
    assert_allclose(back_lat, lat, rtol=0, atol=length / (alt + SEMI_MINOR_AXIS))
    np.testing.assert_array_equal(back_lon, 0)


def test_axis_of_the_earth():
    lat, lon, alt = earth.geodetic_from_ecef([[0, 0, 6.4e6], [0, 0, -6.4e6]])
    np.testing.assert_array_equal(lat, [POLE, -POLE])
    np.testing.assert_array_equal(lon, 0)
    assert_allclose(alt, 6.4e6 - SEMI_MINOR_AXIS, rtol=0, atol=4 * EPS * 6.4e6)


@given(latitudes, longitudes)
@unhurried
def test_points_at_height_zero_lie_on_the_ellipsoid(lat, lon):
    x, y, z = earth.ecef_from_geodetic(lat, lon)
    equation = (x**2 + y**2) / SEMI_MAJOR_AXIS**2 + z**2 / (SEMI_MAJOR_AXIS**2 * (1 - ECCENTRICITY_SQUARED))
    assert_allclose(equation, 1, rtol=8 * EPS)


@given(latitudes, longitudes)
@unhurried
def test_local_frame_is_right_handed(lat, lon):
    C_e_n = earth.dcm_e_n(lat, lon)
    assert_allclose(C_e_n @ C_e_n.T, np.eye(3), rtol=0, atol=4 * EPS)
    assert_allclose(np.linalg.det(C_e_n), 1, rtol=8 * EPS)


@pytest.mark.parametrize("lat", [-1.2, 0.1, 0.8])
def test_local_axes_point_where_the_coordinates_grow(lat):
    lon, alt, step = -2.0, 500.0, 1e-4
    for row, (dlat, dlon, dalt) in enumerate([(0, step, 0), (step, 0, 0), (0, 0, 1.0)]):
        ahead = earth.ecef_from_geodetic(lat + dlat, lon + dlon, alt + dalt)
        behind = earth.ecef_from_geodetic(lat - dlat, lon - dlon, alt - dalt)
        direction = (ahead - behind) / np.linalg.norm(ahead - behind)
        # Central difference: step^2 / 6 of curvature; rounding 2 m over EPS * 6.4e6 m in height.
        assert_allclose(earth.dcm_e_n(lat, lon)[row], direction, rtol=0, atol=step**2)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: earth.radius_meridian(45.0), r"`lat` must be in .* rad, got 45\.0\. Multiply degrees by"),
        (lambda: earth.radius_transverse([0.0, -1.6]), r"`lat` must be .* got -1\.6 at index \(1,\)"),
        (lambda: earth.earth_rate_n(np.nan), "`lat` must be finite"),
        (lambda: earth.ecef_from_geodetic(0, [np.inf]), "`lon` must be finite"),
        (lambda: earth.ecef_from_geodetic(0, 0, "high"), "`alt` must be"),
        (lambda: earth.dcm_e_n(2.0, 0.0), "`lat` must be in"),
        (lambda: earth.normal_gravity(0.0, 1.1e5), r"`alt` must be in \[-100000\.0, 100000\.0\] m, got 110000\.0"),
        (lambda: earth.gravity_n(0.0, -1.1e5), "`alt` must be in"),
        (lambda: earth.transport_rate_n(0.0, 0.0, [1.0, 2.0]), r"`v_eb_n` must be of shape \(\.\.\., 3\)"),
        (lambda: earth.transport_rate_n(0.0, np.nan, np.zeros(3)), "`alt` must be finite"),
        (lambda: earth.geodetic_from_ecef([6378.137, 0.0, 0.0]), "got 6378.14 m. Multiply kilometres"),
        (lambda: earth.geodetic_from_ecef([1.0, 2.0]), "`r_eb_e` must be of shape"),
        (lambda: earth.checked_latitude(2.0, name="lat_start"), "`lat_start` must be"),
    ],
)
def test_error_names_the_argument(call, message):
    with pytest.raises((TypeError, ValueError), match=message):
        call()


@pytest.mark.parametrize("sign", [-1, 1])
def test_poles_are_refused_only_where_east_is_needed(sign):
    earth.transport_rate_n(sign * (POLE - 1.001e-3), 0.0, np.ones(3))
    with pytest.raises(ValueError, match=r"East and north are not defined at a pole: keep 0\.001 rad away"):
        earth.transport_rate_n(sign * (POLE - 0.999e-3), 0.0, np.ones(3))
    for function in (earth.radius_meridian, earth.radius_transverse, earth.normal_gravity, earth.earth_rate_n):
        assert np.isfinite(function(sign * POLE)).all()


@pytest.mark.parametrize(
    "function",
    [
        earth.radius_meridian,
        earth.radius_transverse,
        earth.earth_rate_n,
        lambda lat: earth.normal_gravity(lat, 1e3 * lat),
        lambda lat: earth.dcm_e_n(lat, 2 * lat),
        lambda lat: earth.ecef_from_geodetic(lat, 2 * lat, 1e3 * lat),
        lambda lat: np.stack(earth.geodetic_from_ecef(earth.ecef_from_geodetic(lat, 2 * lat, 1e3 * lat)), axis=-1),
        lambda lat: earth.transport_rate_n(lat, 1e3 * lat, np.stack([lat, 1 + lat, 2 + lat], axis=-1)),
    ],
)
def test_leading_axes_are_a_loop(function):
    lat = np.random.default_rng(5).uniform(-1.5, 1.5, (4, 2))
    together = function(lat)
    for index in np.ndindex(4, 2):
        # A vector unit may round sine and cosine differently from a single call.
        assert_allclose(together[index], function(lat[index]), rtol=8 * EPS)
