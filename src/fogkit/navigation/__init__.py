"""Where a unit is and how it stands, from what its gyros and accelerometers read.

==================  =====================================================================================
module              answers
==================  =====================================================================================
`increments`        what do gyros and accelerometers sum up in each step, of a recording or of a motion?
`strapdown`         what attitude, velocity and position follow from that?
==================  =====================================================================================
"""

from fogkit.navigation.increments import increments_from_motion, increments_from_rates
from fogkit.navigation.strapdown import State, Trajectory, integrate, integrate_arrays

__all__ = ["State", "Trajectory", "increments_from_motion", "increments_from_rates", "integrate", "integrate_arrays"]
