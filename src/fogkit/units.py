"""Factors between the units of the field and SI with radians.

Inside the package every quantity is in SI units and radians. A factor is used once, at the edge, in one of two ways:

- multiply to come in: ``bias = 0.01 * DEG_PER_HOUR`` is 0.01 deg/h in rad/s;
- divide to go out: ``rate / DEG_PER_HOUR`` is a rate in deg/h.

Examples
--------
>>> from fogkit.constants import EARTH_RATE
>>> bias = 0.01 * DEG_PER_HOUR
>>> print(f"{bias:.3e} rad/s, {EARTH_RATE / DEG_PER_HOUR:.3f} deg/h")
4.848e-08 rad/s, 15.041 deg/h

Angle random walk of 0.001 deg/sqrt(h) accumulates, in one hour, to

>>> angle = 0.001 * DEG_PER_SQRT_HOUR * HOUR**0.5
>>> round(angle / DEG, 12)
0.001
"""

from math import pi, sqrt

from fogkit.constants import STANDARD_GRAVITY

# Ratios
PERCENT = 1e-2
PPM = 1e-6

# Time, s; frequency, Hz
MINUTE = 60.0
HOUR = 3600.0
DAY = 86400.0
MILLISECOND = 1e-3
MICROSECOND = 1e-6
NANOSECOND = 1e-9
KILOHERTZ = 1e3
MEGAHERTZ = 1e6

# Length, m
KILOMETRE = 1e3
CENTIMETRE = 1e-2
MILLIMETRE = 1e-3
MICROMETRE = 1e-6
NANOMETRE = 1e-9

# Power, W
MILLIWATT = 1e-3
MICROWATT = 1e-6

# Angle, rad
DEG = pi / 180
ARCMIN = DEG / 60
ARCSEC = DEG / 3600
REVOLUTION = 2 * pi

# Angular rate, rad/s, and angular acceleration, rad/s^2
DEG_PER_SECOND = DEG
DEG_PER_HOUR = DEG / HOUR
DEG_PER_SECOND_SQUARED = DEG

# Random errors of a gyro. A white rate noise of 1 deg/h/sqrt(Hz) two-sided is an angle random walk of 1/60 deg/sqrt(h).
DEG_PER_SQRT_HOUR = DEG / sqrt(HOUR)  # angle random walk, rad/sqrt(s)
DEG_PER_HOUR_PER_SQRT_HZ = DEG_PER_HOUR  # the same quantity as a noise density, rad/s/sqrt(Hz) = rad/sqrt(s)
DEG_PER_HOUR_PER_SQRT_HOUR = DEG_PER_HOUR / sqrt(HOUR)  # rate random walk, rad/s/sqrt(s)
DEG_PER_HOUR_PER_HOUR = DEG_PER_HOUR / HOUR  # rate ramp, rad/s^2

# Acceleration, m/s^2, and what depends on it
MILLI_G = 1e-3 * STANDARD_GRAVITY
MICRO_G = 1e-6 * STANDARD_GRAVITY
DEG_PER_HOUR_PER_G = DEG_PER_HOUR / STANDARD_GRAVITY  # acceleration-sensitive drift rate, rad/s per m/s^2

# Random errors of an accelerometer: velocity random walk, m/s/sqrt(s), in both its usual units
M_PER_S_PER_SQRT_HOUR = 1 / sqrt(HOUR)
MICRO_G_PER_SQRT_HZ = MICRO_G
