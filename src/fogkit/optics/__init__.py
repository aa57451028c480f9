"""One fibre-optic gyro: its optics, its digital loop, and the errors that the two make together.

==================  =====================================================================================
module              answers
==================  =====================================================================================
`coil`              what phase does a rotation make?
`interferometer`    what power does a phase make, exactly and as a Taylor polynomial?
`loop`              is the digital loop stable, and how does it respond?
`gyro`              all parameters of one gyro, and its angle random walk
`motion`            what does the case do? (angular oscillation, ramp)
`simulate`          what does the gyro read, half-period by half-period?
`measure`           what is the mean of a shaken gyro, taken properly?
`drift`             by what law does angular acceleration make drift?
`compensation`      how is that drift taken out, and what does that cost?
`systems`           the same loop as `control` systems, linear and nonlinear
==================  =====================================================================================
"""

from fogkit.optics.coil import Coil
from fogkit.optics.gyro import ClosedLoopGyro
from fogkit.optics.loop import BIAS_ORDERS, Loop, stable_gains

__all__ = ["BIAS_ORDERS", "ClosedLoopGyro", "Coil", "Loop", "stable_gains"]
