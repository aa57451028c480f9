"""Physical constants, SI and radians.

The Earth is the WGS 84 ellipsoid with its normal gravity field. Its four defining constants and the values derived from
them that are published with a limited number of digits are typed as printed; what follows from the defining constants
in closed form is computed, so that formulas which mix them stay consistent to the last bit.

References
----------
.. [1] Department of Defense World Geodetic System 1984, its definition and relationships with local geodetic systems,
   NIMA TR8350.2, third edition, amendment 1 (2000).
.. [2] The International System of Units (SI), BIPM, 9th edition (2019).
"""

#: Speed of light in vacuum, m/s; exact by the definition of the metre [2]_.
SPEED_OF_LIGHT = 299_792_458.0

#: Standard acceleration of free fall, m/s^2; exact, 3rd CGPM (1901), [2]_. A unit ("g"), not the gravity of any place.
STANDARD_GRAVITY = 9.80665

# Defining constants of WGS 84: [1]_, table 3.1.
SEMI_MAJOR_AXIS = 6_378_137.0  #: Equatorial radius of the ellipsoid, m.
FLATTENING = 1 / 298.257223563  #: Flattening of the ellipsoid, (a - b) / a.
GM = 3.986004418e14  #: Gravitational constant times the mass of the Earth with its atmosphere, m^3/s^2.
EARTH_RATE = 7.292115e-5  #: Rate of the Earth relative to inertial space, rad/s (15.041 deg/h).

# Derived from them in closed form; [1]_, table 3.3, prints 6356752.3142, 6.69437999014e-3 and 6.73949674228e-3.
SEMI_MINOR_AXIS = SEMI_MAJOR_AXIS * (1 - FLATTENING)  #: Polar radius of the ellipsoid, m.
ECCENTRICITY_SQUARED = FLATTENING * (2 - FLATTENING)  #: First eccentricity squared, (a^2 - b^2) / a^2.
SECOND_ECCENTRICITY_SQUARED = ECCENTRICITY_SQUARED / (1 - FLATTENING) ** 2  #: (a^2 - b^2) / b^2.

# Derived through the normal potential, as printed: [1]_, table 3.4 (to one unit, and k to 5e-14, right).
EQUATORIAL_GRAVITY = 9.7803253359  #: Normal gravity at the equator, on the ellipsoid, m/s^2.
POLAR_GRAVITY = 9.8321849378  #: Normal gravity at a pole, on the ellipsoid, m/s^2.
SOMIGLIANA = 0.00193185265241  #: Constant k of Somigliana's formula, b * POLAR / (a * EQUATORIAL) - 1.
#: Ratio of centrifugal to gravitational acceleration, m = EARTH_RATE^2 a^2 b / GM; table 3.4 prints 0.00344978650684.
GRAVITY_RATIO = EARTH_RATE**2 * SEMI_MAJOR_AXIS**2 * SEMI_MINOR_AXIS / GM
