"""Three axes: error models of gyros and accelerometers, the constructions that carry them, readings from motion.

==================  =====================================================================================
module              answers
==================  =====================================================================================
`errors`            how do three gyros differ from ideal ones, each with a scale factor for either sign?
`triads`            the linear model of gyros or accelerometers: how do its three forms go into one another?
`unit`              what do three gyros and three accelerometers read, with noise, steps, range and nonlinearity?
`size_effect`       what do accelerometers feel of a turn that do not sit in one point?
`constructions`     how do they stand in the case?
`tables`            which columns do tables of readings have?
`readings`          what do they read on average while the case turns steadily?
==================  =====================================================================================
"""

from fogkit.imu.constructions import Construction
from fogkit.imu.errors import MISALIGNMENTS, GyroTriad
from fogkit.imu.size_effect import SizeEffect
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors, Shape

__all__ = [
    "MISALIGNMENTS",
    "Construction",
    "GyroTriad",
    "LinearTriad",
    "MeasurementUnit",
    "Sensors",
    "Shape",
    "SizeEffect",
]
