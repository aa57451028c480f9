"""Where a unit is and how it stands, from what its gyros and accelerometers read.

==================  =====================================================================================
module              answers
==================  =====================================================================================
`increments`        what do gyros and accelerometers sum up in each step, of a recording or of a motion?
`states`            what is a state, and what is kept of a run?
`strapdown`         what attitude, velocity and position follow from that?
==================  =====================================================================================
"""

from fogkit.navigation.increments import increments_from_motion, increments_from_rates
from fogkit.navigation.states import State, Trajectory
from fogkit.navigation.strapdown import integrate, integrate_arrays

__all__ = ["State", "Trajectory", "increments_from_motion", "increments_from_rates", "integrate", "integrate_arrays"]
