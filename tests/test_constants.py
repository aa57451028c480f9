"""WGS 84: the derived constants follow from the four defining ones, and agree with the print."""

import mpmath as mp
import pytest
from numpy.testing import assert_allclose

from fogkit import constants


@pytest.mark.parametrize(
    ("computed", "printed", "half_unit"),  # NIMA TR8350.2 (2000), tables 3.3 and 3.4; half a unit of the last digit
    [
        (constants.SEMI_MINOR_AXIS, 6356752.3142, 0.5e-4),
        (constants.ECCENTRICITY_SQUARED, 6.69437999014e-3, 0.5e-14),
        (constants.SECOND_ECCENTRICITY_SQUARED, 6.73949674228e-3, 0.5e-14),
        (constants.GRAVITY_RATIO, 0.00344978650684, 0.5e-14),
    ],
)
def test_computed_constants_agree_with_the_print(computed, printed, half_unit):
    assert_allclose(computed, printed, rtol=0, atol=half_unit)


def test_printed_gravity_follows_from_the_defining_constants():
    # Heiskanen and Moritz (1967), eqs. (2-58), (2-73), (2-74). q0 loses ten digits to cancellation, hence mpmath.
    with mp.workdps(40):
        a, f = mp.mpf(6378137), 1 / mp.mpf("298.257223563")
        GM, rate = mp.mpf("3986004.418e8"), mp.mpf("7292115e-11")
        b = a * (1 - f)
        e2nd = mp.sqrt(a**2 - b**2) / b
        m = rate**2 * a**2 * b / GM
        q0 = ((1 + 3 / e2nd**2) * mp.atan(e2nd) - 3 / e2nd) / 2
        q0_prime = 3 * (1 + 1 / e2nd**2) * (1 - mp.atan(e2nd) / e2nd) - 1
        equator = GM / (a * b) * (1 - m - m * e2nd * q0_prime / (6 * q0))
        pole = GM / a**2 * (1 + m * e2nd * q0_prime / (3 * q0))
        k = b * pole / (a * equator) - 1
    # One unit of the last digit printed: the polar value is 9.83218493786..., which the print cuts and does not round.
    assert_allclose(constants.EQUATORIAL_GRAVITY, float(equator), rtol=0, atol=1e-10)
    assert_allclose(constants.POLAR_GRAVITY, float(pole), rtol=0, atol=1e-10)
    # The print of k, ...65241, is wrong in its last digit, ...65246; in gravity that is 5e-14.
    assert_allclose(constants.SOMIGLIANA, float(k), rtol=0, atol=5e-14)


def test_earth_rate_is_one_turn_in_a_sidereal_day():
    # Mean sidereal day 86164.0905 s (IERS); the 7 digits of the rate, with the precession in right ascension of
    # 7.1e-12 rad/s, leave 2e-7.
    assert_allclose(constants.EARTH_RATE * 86164.0905, 2 * float(mp.pi), rtol=2e-7)
