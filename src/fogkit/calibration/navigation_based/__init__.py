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
`turns`             how many whole turns does a scale factor need?
`axes`              what are the axes of the table, and the calibration in them?
`gyro_bias`         what are the gyro biases, from half a turn about the vertical?
`azimuth`           where is north, by calibrated gyros at rest?
`batch`             what do the fifteen parameters leave out? 59 states from the same recordings
==================  =====================================================================================
"""

from fogkit.calibration.navigation_based.axes import Alignment, align_to_table
from fogkit.calibration.navigation_based.azimuth import Azimuth, gyrocompass_azimuth
from fogkit.calibration.navigation_based.compensation import Compensation, differences
from fogkit.calibration.navigation_based.gyro_bias import GyroBiases, estimate_gyro_biases
from fogkit.calibration.navigation_based.iteration import calibrate, require_observable
from fogkit.calibration.navigation_based.matrix import actual_matrix, finite_difference_matrix, model_matrix
from fogkit.calibration.navigation_based.processing import prepare
from fogkit.calibration.navigation_based.results import NavigationCalibration
from fogkit.calibration.navigation_based.turns import scale_factor_deviation, turns_needed

__all__ = [
    "Alignment",
    "Azimuth",
    "Compensation",
    "GyroBiases",
    "NavigationCalibration",
    "actual_matrix",
    "align_to_table",
    "calibrate",
    "differences",
    "estimate_gyro_biases",
    "finite_difference_matrix",
    "gyrocompass_azimuth",
    "model_matrix",
    "prepare",
    "require_observable",
    "scale_factor_deviation",
    "turns_needed",
]
