"""What the slides print of the laboratory calibration: attitudes, rates, durations, counts, names of standards.

An attitude is three letters among E W N S U D: where the axes x, y, z of the body point (east, west, north, south, up,
down). Latitude, noise and turning rates are not given; what is assumed in their place says so.
"""

import numpy as np

from fogkit.units import DEG, DEG_PER_SECOND, DEG_PER_SQRT_HOUR, MINUTE, REVOLUTION

ATTITUDES = {
    "1-1": "UEN",
    "1-2": "USE",
    "1-3": "UWS",
    "1-4": "UNW",
    "2-1": "DES",
    "2-2": "DSW",
    "2-3": "DWN",
    "2-4": "DNE",
}
"""The eight printed attitudes of the 24 points, by position and point."""

POINTS_OF_THE_CIRCLE = "ESWN"
"""East, south, west, north: the order of the four points of a position."""

POSITIONS, POINTS = 6, 4
"""Positions, and points in each."""

RAW_SHAPE, MEAN_SHAPE = (24, 6), (6, 6)
"""Sizes of the array N of all samples and of the array F of their means over the points of a position."""

COEFFICIENTS = 24
"""Error coefficients to be found."""

EQUATIONS, UNKNOWNS = 6, 4
"""Equations for one sensor, from F, and what is unknown in them."""

TURN = REVOLUTION
"""Angle of the turns one way and back, rad."""

RATES = DEG_PER_SECOND * np.array(
    [
        *(0, 0.1, -0.1, 0.2, -0.2, 0.5, -0.5, 1, -1, 3, -3, 5, -5, 8, -8, 10, -10, 20, -20),
        *(50, -50, 80, -80, 100, -100, 150, -150, 200, -200),
    ]
)
"""Rates of the table in their printed order, rad/s."""

RATE_RANGE = 200 * DEG_PER_SECOND
"""Range of the gyros, rad/s."""

INSTALLATION_RATE = 150 * DEG_PER_SECOND
"""Rate, both ways, that the installation errors are taken from, rad/s."""

ACCELEROMETER_DURATION = 2 * MINUTE
BIAS_DURATION = 10 * MINUTE
RATE_DURATION = 2 * MINUTE
"""Durations of one position of the accelerometers, one position of the gyro bias and one rate, s."""

BIAS_POSITIONS = 3
"""Positions for the gyro biases, one axis after the other to the east."""

SUPPLY = 27.0
"""Supply of the unit, V."""

LEAST_TEMPERATURE_POINTS = 2
START_UP_POINTS = 2
STEADY_POINTS = 3
STEADY_VARIABLES = 6
"""Points of measured temperature: the least number, those of the example of start-up and of the steady state, and the
variables that the latter make with their rates."""

STANDARDS = {  # name in the slides: (number as printed, as catalogued), (title as printed, as catalogued)
    "ieee-952": (
        ("IEEE Std 952-1997",) * 2,
        tuple(
            f"IEEE Standard Specification Format Guide and Test Procedure for Single-Axis {word} Fiber Optic Gyros"
            for word in ("Interferomentric", "Interferometric")
        ),
    ),
    "gjb-2426": (("GJB2426-2004", "GJB2426A-2004"), ("光纤陀螺测试方法", "光纤陀螺仪测试方法")),
    "gjb-1037": (("GJB1037A-2004",) * 2, ("单轴摆式伺服线加速度计实验方法", "单轴摆式伺服线加速度计试验方法")),
}
"""Standards whose number or title was compared: IEEE 952 with its title page, GJB with citations of them."""

ASSUMED_LATITUDE = 40 * DEG
"""Latitude for the numbers of the ledger, rad: that of Beijing. The slides have a symbol for it and no value."""

ASSUMED_ANGLE_RANDOM_WALK = 0.01 * DEG_PER_SQRT_HOUR
"""Noise of the gyros for the numbers of the ledger, rad/sqrt(s): of a medium grade. The slides have none."""

DRIFT_SOURCES = {"latter": "within", "former": "ambient"}
"""What heats by the slide on the steady state: the words of the print."""

ORDER_OF_SENTENCE = {"former": "steady state", "latter": "start-up"}
"""What the two words point to: the sentence before has the steady state first."""

SCREENING = tuple(f"环境应力筛选{word}产品研制过程中的一个重要环节" for word in "时是")
"""Sentence on screening by stress, as printed and as meant."""

DEFINED_INDICES = {"gyro": "i", "accelerometer": "j", "number of gyros": "m"}
"""Indices and counts that the text defines."""
