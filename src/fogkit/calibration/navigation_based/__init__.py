"""Calibration by changes of the computed velocity: dwell, turn, dwell on a rough turntable.

A calibrated unit that navigates stays level, whatever turn it has made. One that is not shows it: the slopes of its
computed velocity in the dwells before and after the turn differ, and by how much tells the errors.

==================  =====================================================================================
module              answers
==================  =====================================================================================
`turn_model`        by how much does each error change the slope, to first order and exactly?
`compensation`      which matrices and biases make readings true, and how far are they from the truth?
`recordings`        what was recorded in each test, and when did the unit rest?
`plausibility`      are these recordings those of the plan, in the right units, at rest, unsaturated?
`slopes`            what is the slope of the velocity in a dwell, at which instant, and how sure is it?
`processing`        what do all tests give, navigated with the present parameters?
`matrix`            how do the changes of slope follow from the errors: by rotations, plan, or trial?
`iteration`         which parameters make the changes of slope vanish?
`results`           the record that comes back
`batch`             what do the fifteen parameters leave out? 59 states from the same recordings
==================  =====================================================================================
"""

from fogkit.calibration.navigation_based.compensation import Compensation, differences
from fogkit.calibration.navigation_based.iteration import calibrate
from fogkit.calibration.navigation_based.results import NavigationCalibration

__all__ = ["Compensation", "NavigationCalibration", "calibrate", "differences"]
