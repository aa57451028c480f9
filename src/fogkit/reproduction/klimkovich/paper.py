"""What the paper states in numbers: the matrix of its appendix, its tables, and the inputs of its estimates.

Indices are those of the print: the matrix counts rows and columns from zero, the equations count tests and axes from 1.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fogkit.calibration.navigation_based import turn_model
from fogkit.units import ARCSEC, DEG, MINUTE

TESTS = 9
TURNS = 5
"""Number of tests; whole turns n added to each rotation."""


@dataclass(frozen=True)
class Entry:
    """One printed element of the measurement matrix.

    Attributes
    ----------
    row, column : int
        Indices from 0.
    number : float
        What stands before pi and gravity.
    of_pi, of_gravity : bool
        Whether pi and gravity are printed as factors.
    """

    row: int
    column: int
    number: float
    of_pi: bool = False
    of_gravity: bool = True

    def value(self, gravity: float = 1.0) -> float:
        """The element, for a gravity in m/s^2; as a multiple of gravity if that is 1."""
        return self.number * (np.pi if self.of_pi else 1.0) * (gravity if self.of_gravity else 1.0)

    def __str__(self) -> str:
        number = f"{self.number:g}".replace(".", ",")
        factors = r"\pi " * self.of_pi + "g_0" * self.of_gravity
        if factors and abs(self.number) == 1:
            number = number.removesuffix("1")
        return f"H_{{{self.row},{self.column}}} = {number}{factors}"


def _entry(text: str) -> Entry:
    """Read ``row,column=number`` with `p` for pi and `g` for gravity behind the number."""
    place, _, value = text.partition("=")
    row, column = map(int, place.split(","))
    number = float(value.rstrip("pg"))
    return Entry(row, column, number, of_pi="p" in value, of_gravity="g" in value)


MATRIX = tuple(
    _entry(text)
    for text in (
        # turns about x: tests 1 to 3
        *("0,0=1g", "0,6=1g", "0,9=-1g"),
        *("1,13=-1", "1,14=-1", "1,2=-1g", "1,3=-10.5pg"),
        *("2,6=-2g",),
        *("3,14=2", "3,3=-11pg"),
        *("4,0=1g", "4,6=1g", "4,9=1g"),
        *("5,13=1", "5,14=-1", "5,2=1g", "5,3=-10.5pg"),
        # turns about y: tests 4 to 6
        *("6,1=-1g", "6,4=-1g", "6,10=1g"),
        *("7,12=-1", "7,14=-1", "7,5=-1g", "7,7=-10.5pg"),
        *("8,10=-2g",),
        *("9,12=2", "9,7=-11pg"),
        *("10,1=1g", "10,10=1g", "10,4=1g"),
        *("11,14=1", "11,12=-1", "11,0=1g", "11,7=-10.5pg"),
        # turns about z: tests 7 to 9
        *("12,12=-1", "12,13=-1", "12,1=1g", "12,11=10.5pg"),
        *("13,2=1g", "13,5=-1g", "13,8=1g"),
        *("14,13=2", "14,11=11pg"),
        *("15,5=2g",),
        *("16,12=1", "16,13=-1", "16,1=-1g", "16,11=10.5pg"),
        *("17,2=-1g", "17,5=-1g", "17,10=-1g"),
    )
)
"""The 51 printed elements, in the order of the print."""

BLOCKS = {"x": (1, 2, 3), "y": (4, 5, 6), "z": (7, 8, 9)}
"""Tests by the axis of the turn, as the headings in the appendix have it."""


def printed_matrix(gravity: float = 1.0) -> NDArray[np.float64]:
    """Measurement matrix of the appendix as printed, shape (18, 15); what is not printed is zero.

    Parameters
    ----------
    gravity : float, optional
        m/s^2. With 1 the elements of misalignments and scale factors are multiples of gravity.
    """
    H = np.zeros((2 * TESTS, len(turn_model.PARAMETERS)))
    for entry in MATRIX:
        H[entry.row, entry.column] = entry.value(gravity)
    return H


SCALE_FACTOR_TESTS = {1: 8, 2: 2, 3: 5}
"""Accelerometer, 1 to 3, to the test that gives its scale factor by (26)."""

START_OF_TEST_1 = "ENU"
"""Where x, y and z point at the start of test 1: the text has the unit matrix."""

TABLE_1 = {  # arcsec, ppm and m/s^2; the print heads the first accelerometer angle M_12
    **{"m_g_12": 4.89, "m_g_13": 1.17, "m_g_21": 1.18, "m_g_23": 4.83, "m_g_31": 4.88, "m_g_32": 1.18},
    **{"m_g_11": 0.538, "m_g_22": 0.552, "m_g_33": 0.466},
    **{"b_a_1": 1.082e-4, "b_a_2": 1.080e-4, "b_a_3": 1.079e-4},
    **{"m_a_13": 4.37, "m_a_21": 4.40, "m_a_32": 4.39},
}
"""Standard deviations of the state, in the printed units."""

TABLE_1_ACCELEROMETER_SCALE = {"m_a_11": 2.5, "m_a_22": 3.2, "m_a_33": 5.4}
"""Half differences of the vertical accelerations over gravity, ppm."""

TABLE_2 = {  # deg: set azimuth, and what the system finds less than it
    0: -0.00721,
    45: 0.01279,
    90: -0.01021,
    135: 0.00679,
    180: 0.01769,
    225: -0.01621,
    270: 0.00709,
    315: -0.01071,
}
TABLE_2_COLUMNS = ("number", "set azimuth", "difference")
"""Headings of table 2."""

TABLE_2_DEVIATION = 0.0118
"""Azimuths by gyrocompassing, deg: set angle to set less found; the printed standard deviation."""

BIAS_TEST_DWELL = 3 * MINUTE
GYROCOMPASSING_TIME = 5 * MINUTE
"""Dwell T of the gyro bias test and duration of the gyrocompassing, s."""

TEST_DURATION = 35.0
GYRO_BIAS_LEFT = 2e-7
BIAS_ANGLE = 0.7 * ARCSEC
"""Inputs of (33), s and rad/s, and what the paper gets, rad."""

SCHULER_FREQUENCY = 1.256e-3
START_ANGLE = 0.1 * DEG
START_ANGLE_EFFECT = 0.36 * ARCSEC
"""Inputs of (35), rad/s and rad, and what the paper gets at the same duration, rad."""

ITERATIONS = 8
FLOOR_AFTER = 3
"""Iteration of figure 3 and from which figure 5 is flat; iteration after which figure 4 no longer falls."""

SIZE_EFFECT_PARAMETERS = {"one point": 9, "two points": 18}
DELAY_PARAMETERS = 6
SENSITIVITY_CENTRES = (0.003, 0.03)
"""Unknowns of the size effect and of the delays; distances of the centres of the two-point model, m."""
