"""Where a unit is calibrated: tables and plates with their errors, what the operator does there, and what comes out.

==================  =====================================================================================
module              answers
==================  =====================================================================================
`table`             three-axis table: where is the platform, and which errors does it have?
`plans`             three-axis table: which positions and turns, for how long?
`bench`             three-axis table: what do gyros and table read while a plan is carried out?
`placements`        plate and single-axis table: how does the unit lie, for how long, and how fast does it turn?
`laboratory`        plate and single-axis table: what does the unit read, sample by sample?
`turn_tests`        turntable: which dwells and turns show the errors of a unit in its own navigation?
`rough_table`       rough turntable of two axes: which errors does it have, and what does it make of a plan?
`turn_motion`       rough turntable: how does the unit really move in a test, wobble and absorbers included?
`turn_recordings`   rough turntable: which increments does the unit record in each test?
`means`             what is one mean reading for each placement, and is the recording fit for it?
==================  =====================================================================================
"""

from fogkit.stand.bench import BenchRecord
from fogkit.stand.laboratory import Laboratory
from fogkit.stand.means import Observations, observations
from fogkit.stand.placements import Placement, Schedule
from fogkit.stand.plans import Plan, Segment
from fogkit.stand.rough_table import RoughTable
from fogkit.stand.table import RateTable
from fogkit.stand.turn_motion import Absorber, Harmonic, TurnMotion
from fogkit.stand.turn_tests import TurnTest, bias_test, nine_tests

__all__ = [
    "Absorber",
    "BenchRecord",
    "Harmonic",
    "Laboratory",
    "Observations",
    "Placement",
    "Plan",
    "RateTable",
    "RoughTable",
    "Schedule",
    "Segment",
    "TurnMotion",
    "TurnTest",
    "bias_test",
    "nine_tests",
    "observations",
]
