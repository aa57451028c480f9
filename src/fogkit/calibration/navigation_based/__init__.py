"""Calibration by changes of the computed velocity: dwell, turn, dwell on a rough turntable.

A calibrated unit that navigates stays level, whatever turn it has made. One that is not shows it: the slopes of its
computed velocity in the dwells before and after the turn differ, and by how much tells the errors.

==================  =====================================================================================
module              answers
==================  =====================================================================================
`turn_model`        by how much does each error change the slope, to first order and exactly?
==================  =====================================================================================
"""
