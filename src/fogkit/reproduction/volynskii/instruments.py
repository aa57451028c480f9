"""What the paper states of its gyros, its rate table, its example and its results; results in the printed units."""

from fogkit.units import ARCMIN, ARCSEC, DEG, DEG_PER_HOUR, DEG_PER_SECOND, HOUR, MINUTE

GYRO_DRIFT = 0.01 * DEG_PER_HOUR
"""Drift of the gyros that is not accounted for, rad/s."""

ROCKING_ANGLE = 30 * DEG
ROCKING_PERIOD = 6.0
"""Amplitude, rad, and period, s, of the rocking of a surface ship."""

MAX_RATE = 30 * DEG_PER_SECOND
"""Largest rate of a surface ship as printed, rad/s."""

TURN_RATES = (3 * DEG_PER_SECOND, 6 * DEG_PER_SECOND)
"""Slowest and fastest steady turn of a ship, rad/s."""

TABLE_DRIFT = 0.002 * DEG_PER_HOUR
"""Error of the table's rate and of the Earth rate that is allowed, rad/s."""

SMALL_ANGLES = (1 * ARCSEC, 3 * ARCSEC)
"""The angles that are required of misalignment, mounting and readout, rad."""

AZIMUTH_ERRORS = (20 * ARCSEC, 30 * ARCSEC)
"""The azimuth errors of the table that are allowed, rad."""

TABLE_NONORTHOGONALITY = 6 * ARCSEC
TABLE_POSITIONING = 3 * ARCSEC
TABLE_RATE_STABILITY = 5e-6
"""The table: non-orthogonality of its axes (an upper bound) and positioning, rad; stability of its rate, relative."""

MISALIGNMENT_LIMIT = 5 * ARCMIN
"""Largest misalignment of a gyro's input axis, rad."""

BIAS_DURATION = 1 * HOUR
"""Duration of a reading for the biases, s; the paper's example."""

EXAMPLE_DURATION = 360.0
EXAMPLE_ANGLE = 4.6e7 * ARCSEC
EXAMPLE_READOUT = 2 * ARCSEC
EXAMPLE_NOISE = 0.1 * ARCSEC
EXAMPLE_BIAS_ERROR = 0.01 * ARCSEC
"""The numbers put into (22): T, s; 2 pi n, rad; readout error, rad; C_n, rad/sqrt(s); error of the bias, rad/s. The
print has the angle and the readout error in arcseconds per second."""

EXAMPLE_RESULT = 1.36e-7
"""What the paper gets from (22)."""

TEST_RATES = (1 * DEG_PER_SECOND, 36 * DEG_PER_SECOND)
TEST_DURATION = 30 * MINUTE
TEST_TEMPERATURE_CHANGE = 1.0
"""Rates, rad/s, and duration, s, of the scale factor tests; the largest change of temperature in them, K."""

TABLE_1 = {  # mean and spread, deg/h; range of temperature, degC
    "x": {"mean": 0.150, "spread": 0.008, "temperature": (33.6, 35.0)},
    "y": {"mean": -0.009, "spread": 0.006, "temperature": (33.2, 35.0)},
    "z": {"mean": -0.060, "spread": 0.008, "temperature": (33.0, 35.0)},
}
"""Biases."""

TABLE_2 = {  # mean and spread, unit not printed
    "x+": {"mean": 1.746892, "spread": 3.4e-6},
    "x-": {"mean": 1.746890, "spread": 2.9e-6},
    "y+": {"mean": 1.664746, "spread": 4.8e-6},
    "y-": {"mean": 1.664747, "spread": 4.4e-6},
    "z+": {"mean": 1.730345, "spread": 2.1e-6},
    "z-": {"mean": 1.730357, "spread": 3.1e-6},
}
"""Scale factors for positive and negative rate."""

TABLE_3 = {  # mean, arcmin; spread, arcsec
    "yx": {"mean": -2.9, "spread": 0.6},
    "zx": {"mean": 1.8, "spread": 0.8},
    "xy": {"mean": 2.3, "spread": 1.6},
    "zy": {"mean": 1.3, "spread": 0.9},
    "xz": {"mean": 2.4, "spread": 1.0},  # the mean is printed in arcsec
    "yz": {"mean": 2.7, "spread": 0.3},
}
"""Misalignment angles, by gyro and axis of the turn."""

FIGURES = {
    "1a": "frames of the plain construction",
    "1b": "frames of the block construction",
    "2": "frames of the trihedral construction",
    "3": "input axes against their nominal directions",
    "4": "axes of the table and of the unit",
}
"""What the captions say that each figure shows."""

TABLE_ANGLES = {"axis 1": "gamma_c", "axis 2": "alpha_c", "axis 3": "gamma_c1"}
"""The paper's names of the table's angles: inner, middle and outer axis."""

STAGE_2_AXES = {"x": "axis 2", "y": "axis 2", "z": "axis 3"}
"""The table's axis that turns the unit about each of its axes in the second stage."""
