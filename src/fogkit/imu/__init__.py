"""Three axes: the error model of a gyro triad, the constructions that carry it, and its readings from motion.

==================  =====================================================================================
module              answers
==================  =====================================================================================
`errors`            how do three gyros differ from ideal ones?
`constructions`     how do they stand in the case?
`readings`          what do they read on average while the case turns steadily?
==================  =====================================================================================
"""

from fogkit.imu.constructions import Construction
from fogkit.imu.errors import MISALIGNMENTS, GyroTriad

__all__ = ["MISALIGNMENTS", "Construction", "GyroTriad"]
